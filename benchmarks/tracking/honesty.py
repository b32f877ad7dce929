"""Input that has no answer: how often the status says OK all the same. It must be never."""

import numpy as np

from raylign import synthetic
from raylign.camera import PinholeCamera
from raylign.depth import inverse_depth
from raylign.tracking import AlignmentStatus, Frame, Keyframe, TrackingOptions, align

CAMERA = PinholeCamera(262.5, 262.5, 159.5, 119.5)
WIDTH, HEIGHT = 320, 240
BEHIND = np.diag([-1.0, 1.0, -1.0, 1.0])  # turned about y by 180 degrees


def shot(scene: synthetic.Scene, T_cw: np.ndarray, seed: int, index: int) -> tuple:
    """Image (uint8), D and V of a Kinect-like camera."""
    frame = synthetic.render(
        scene, CAMERA, T_cw, width=WIDTH, height=HEIGHT, seed=seed, index=index,
        sensor=synthetic.SensorOptions(read_noise=1.0, shot_noise=0.02),
    )  # fmt: skip
    depth = synthetic.sense_depth(frame, CAMERA, seed=seed, index=index)
    return frame.image, *inverse_depth(depth)


def flat(random: np.random.Generator) -> np.ndarray:
    """No texture: one grey value and a camera's noise."""
    grey = random.uniform(20, 230) + random.normal(scale=1.0, size=(HEIGHT, WIDTH))
    return np.clip(np.rint(grey), 0, 255).astype(np.uint8)


def noise(random: np.random.Generator) -> np.ndarray:
    return random.integers(0, 256, (HEIGHT, WIDTH), np.uint8)


def cases(seed: int) -> dict:
    """name -> (host image, D, V), (target image, D, V)."""
    random = np.random.default_rng(seed)
    scene = synthetic.boxes(seed=seed)
    other_scene = [synthetic.height_field, synthetic.sphere, synthetic.plane][seed % 3](
        seed=10_000 + seed
    )
    host = shot(scene, np.eye(4), seed, 0)
    same = shot(scene, np.eye(4), seed, 1)
    behind = shot(scene, BEHIND, seed, 1)
    other = shot(other_scene, np.eye(4), seed, 1)
    repainted = shot(synthetic.room(seed=20_000 + seed), np.eye(4), seed, 1)
    nothing = np.full((HEIGHT, WIDTH), np.nan, np.float32)
    return {
        "no overlap (turned by 180°)": (host, behind),
        "no texture in either image": ((flat(random), *host[1:]), (flat(random), *same[1:])),
        "no texture in the target": (host, (flat(random), *same[1:])),
        "keyframe depth all NaN": ((host[0], nothing, nothing), same),
        "target of pure noise": (host, (noise(random), *same[1:])),
        "both of pure noise": ((noise(random), *host[1:]), (noise(random), *same[1:])),
        "other scene": (host, other),
        "same walls, other paint": (host, repainted),
    }


def measure(repeats: int) -> list[dict]:
    """Seeds 0 to `repeats` − 1, photometric and with the depth residual."""
    counts: dict[tuple[str, str], dict[str, int]] = {}
    first_ok: dict[tuple[str, str], int] = {}
    options = TrackingOptions()
    for seed in range(repeats):
        for name, (host, target) in cases(seed).items():
            keyframe = Keyframe(host[0], CAMERA, inverse_depth=host[1], variance=host[2])
            for mode in ("photometric", "photometric + depth"):
                depth = mode != "photometric"
                frame = Frame(
                    target[0],
                    CAMERA,
                    inverse_depth=target[1] if depth else None,
                    variance=target[2] if depth else None,
                )
                status = align(keyframe, frame, options=options).status
                row = counts.setdefault((name, mode), {})
                row[status.name] = row.get(status.name, 0) + 1
                if status is AlignmentStatus.OK:
                    first_ok.setdefault((name, mode), seed)
    return [
        {
            "case": name,
            "mode": mode,
            "seeds": repeats,
            "num_ok": row.get("OK", 0),
            "first_ok_seed": first_ok.get((name, mode)),
            "statuses": row,
        }
        for (name, mode), row in counts.items()
    ]
