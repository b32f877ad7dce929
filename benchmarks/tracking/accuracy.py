"""One motion on exactly rendered images: how close, and whether the status tells."""

import cv2
import numpy as np

from raylign import geometry, synthetic
from raylign.camera import PinholeCamera
from raylign.synthetic import RenderOptions
from raylign.tracking import Keyframe, TrackingOptions, align
from tracking import cv_odometry, frames

CAMERA = PinholeCamera(525.0, 525.0, 319.5, 239.5)
WIDTH, HEIGHT = 640, 480
EXACT = RenderOptions(antialiasing="none")
DEPTH_VARIANCE = 1e-8  # 1/m²: 0.1 mm at 1 m; the rendered depth is exact but float32
MOTIONS = ((0.027, 1.4), (0.084, 3.5), (0.187, 7.9))  # m, degrees: those of the issue
SCENES = {
    "room": synthetic.room,
    "boxes": synthetic.boxes,
    "sphere": synthetic.sphere,
    "height field": synthetic.height_field,
}
BOUND_MM, BOUND_DEG = 0.1, 0.003
# beyond this an OK is a lie, not an inaccuracy
WRONG_M, WRONG_DEG = 0.01, 0.5


def render(scene: synthetic.Scene, T_cw: np.ndarray) -> synthetic.Frame:
    return synthetic.render(scene, CAMERA, T_cw, width=WIDTH, height=HEIGHT, options=EXACT)


def exact_keyframe(frame: synthetic.Frame, camera: PinholeCamera = CAMERA) -> Keyframe:
    D = np.nan_to_num(1.0 / frame.depth).astype(np.float32)
    return Keyframe(frame.image, camera, inverse_depth=D, variance=DEPTH_VARIANCE)


def ball(random: np.random.Generator) -> np.ndarray:
    """Uniform in the unit ball."""
    direction = random.normal(size=3)
    return direction / np.linalg.norm(direction) * random.uniform() ** (1 / 3)


def motion(translation: float, degrees: float, random: np.random.Generator) -> np.ndarray:
    """T_th of this length and angle, in random directions."""
    xi = np.zeros(6)
    for part, size in ((slice(0, 3), translation), (slice(3, 6), np.deg2rad(degrees))):
        direction = random.normal(size=3)
        xi[part] = size * direction / np.linalg.norm(direction)
    T = geometry.se3_exp(xi)
    T[:3, 3] = xi[:3]
    return T


def systems(kinds: tuple[str, ...]) -> dict:
    """name -> (keyframe frame, target frame) -> (ok, T_th)."""
    finest = TrackingOptions(finest_level=0)
    # these images have no noise but that of rounding and interpolation
    told = TrackingOptions(finest_level=0, sigma_intensity=0.5)

    def ours(options: TrackingOptions):
        def call(host: synthetic.Frame, target: synthetic.Frame) -> tuple[bool, np.ndarray]:
            result = align(exact_keyframe(host), target.image, options=options)
            return result.ok, result.T_th

        return call

    def theirs(kind: str):
        def call(host: synthetic.Frame, target: synthetic.Frame) -> tuple[bool, np.ndarray]:
            odometry = cv_odometry.CvOdometry(kind, frames.matrix(CAMERA))
            prepared = [
                odometry.prepare(f.image, f.depth.astype(np.float32)) for f in (host, target)
            ]
            return odometry.compute(*prepared)

        return call

    return {
        "raylign, finest level 0": ours(finest),
        "raylign, finest level 0, σ_I 0.5": ours(told),
        "raylign, defaults (finest level 1)": ours(TrackingOptions()),
        **{f"cv2.Odometry {kind}": theirs(kind) for kind in kinds},
    }


def measure(repeats: int) -> list[dict]:
    """`repeats` random directions per scene and motion."""
    cv2.setNumThreads(1)
    rows = []
    for scene_name, make in SCENES.items():
        scene = make(seed=0)
        host = render(scene, np.eye(4))
        for number, (translation, degrees) in enumerate(MOTIONS):
            found: dict[str, list] = {name: [] for name in systems(("RGB",))}
            for i in range(repeats):
                T = motion(translation, degrees, np.random.default_rng([number, i]))
                target = render(scene, T)
                for name, call in systems(("RGB",)).items():
                    ok, estimate = call(host, target)
                    found[name].append((bool(ok), *frames.pose_error(estimate, T)))
            rows += [
                {"scene": scene_name, "motion": [translation, degrees], "system": name}
                | summarise(values)
                for name, values in found.items()
            ]
    return rows


def summarise(values: list[tuple[bool, float, float]]) -> dict:
    """Of (ok, m, degrees): errors of all tries, and the tries with OK that were far off."""
    ok = np.array([v[0] for v in values])
    mm = np.array([1e3 * v[1] for v in values])
    degrees = np.array([v[2] for v in values])
    wrong = (mm > 1e3 * WRONG_M) | (degrees > WRONG_DEG)
    return {
        "tries": len(values),
        "num_ok": int(ok.sum()),
        "num_ok_but_wrong": int((ok & wrong).sum()),
        "num_within_bound": int((ok & (mm <= BOUND_MM) & (degrees <= BOUND_DEG)).sum()),
        "median_mm": float(np.median(mm)),
        "max_mm": float(mm.max()),
        "median_deg": float(np.median(degrees)),
        "max_deg": float(degrees.max()),
        "max_ok_mm": float(mm[ok].max()) if ok.any() else None,
    }
