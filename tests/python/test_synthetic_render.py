"""`raylign.synthetic.render`: what it shows is exact, or as noisy as asked."""

import math

import numpy as np
import pytest

from raylign import synthetic
from raylign.camera import PinholeCamera, RadtanCamera
from raylign.errors import OptionsError, ShapeError
from raylign.geometry import se3_exp
from raylign.synthetic import (
    Antialiasing,
    PixelType,
    RenderOptions,
    Scene,
    SensorOptions,
    TextureKind,
    TextureOptions,
)

CAMERA = PinholeCamera(130.0, 128.0, 79.3, 60.2)
SIZE = {"width": 161, "height": 121}
EXACT = RenderOptions(antialiasing="none")
MOTION = se3_exp([0.12, -0.08, 0.15, 0.03, -0.05, 0.04])
WHITE = TextureOptions(kind="uniform", mean=100.0)

SCENES = {
    "room": synthetic.room(seed=1),
    "boxes": synthetic.boxes(n=3, seed=2),
    "plane": synthetic.plane(seed=3, slant_deg=40.0),
    "height_field": synthetic.height_field(seed=4),
    "sphere": synthetic.sphere(seed=5),
    "board": synthetic.room(seed=6) + synthetic.board(seed=7),
}
each_scene = pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES.keys())


def points_of(frame: synthetic.Frame, camera: PinholeCamera | RadtanCamera) -> np.ndarray:
    """(H, W, 3) world points."""
    v, u = np.mgrid[: frame.depth.shape[0], : frame.depth.shape[1]]
    bearing, _ = camera.unproject(np.stack([u, v], axis=-1).astype(float))
    p_c = bearing * (frame.depth / bearing[..., 2])[..., None]
    return (p_c - frame.T_cw[:3, 3]) @ frame.T_cw[:3, :3]


def look_through(scene: Scene, T_cw: np.ndarray, uv: np.ndarray) -> synthetic.Frame:
    """The one pixel that lies at `uv` in CAMERA."""
    shifted = PinholeCamera(CAMERA.fx, CAMERA.fy, CAMERA.cx - uv[0], CAMERA.cy - uv[1])
    return synthetic.render(scene, shifted, T_cw, width=1, height=1, options=EXACT)


@each_scene
def test_a_point_looks_the_same_from_everywhere(scene: Scene):
    first = synthetic.render(scene, CAMERA, np.eye(4), **SIZE, options=EXACT)
    assert first.valid.all()
    assert 20.0 < first.irradiance.std() < 45.0
    p_w = points_of(first, CAMERA).reshape(-1, 3)
    p_c = p_w @ MOTION[:3, :3].T + MOTION[:3, 3]
    uv, front = CAMERA.project(p_c)
    seen = 0
    for i in np.random.default_rng(0).choice(np.flatnonzero(front), 60, replace=False):
        second = look_through(scene, MOTION, uv[i])
        hidden = second.depth[0, 0] < p_c[i, 2] - 1e-9
        if hidden:
            continue
        seen += 1
        assert second.depth[0, 0] == pytest.approx(p_c[i, 2], abs=1e-11)
        assert second.irradiance[0, 0] == pytest.approx(first.irradiance.flat[i], abs=1e-6)
        assert second.face[0, 0] == first.face.flat[i]
    assert seen > 40


def test_depth_of_a_plane_is_the_closed_form():
    frame = synthetic.render(
        synthetic.plane(slant_deg=35.0, distance=1.7), CAMERA, np.eye(4), **SIZE
    )
    x = (np.arange(161) - CAMERA.cx) / CAMERA.fx
    slope = math.tan(math.radians(35.0))
    expected = 1.7 / (1.0 - x * slope)  # z = 1.7 + x z tan
    assert np.abs(frame.depth / expected - 1.0).max() < 1e-12
    normal = [math.sin(math.radians(35.0)), 0.0, -math.cos(math.radians(35.0))]
    assert np.abs(frame.normal - normal).max() < 1e-12


def test_depth_of_a_sphere_is_the_closed_form():
    frame = synthetic.render(synthetic.sphere(radius=0.6, distance=2.5), CAMERA, np.eye(4), **SIZE)
    points = points_of(frame, CAMERA)
    ball = frame.face == 0
    assert 2000 < ball.sum() < 8000
    from_centre = points[ball] - [0.0, 0.0, 2.5]
    assert np.abs(np.linalg.norm(from_centre, axis=-1) - 0.6).max() < 1e-12
    assert np.abs(frame.normal[ball] - from_centre / 0.6).max() < 1e-11
    assert np.abs(frame.depth[frame.face == 1] - 4.0).max() < 1e-12


def test_walls_of_a_room_meet_at_the_analytic_edge():
    """A box seen from its centre: the face is that of the largest scaled coordinate."""
    scene = Scene()
    scene.add_box(np.eye(4), size=[2.0, 1.0, 3.0], texture=WHITE)
    wide = PinholeCamera(40.0, 40.0, 80.0, 60.0)
    frame = synthetic.render(scene, wide, np.eye(4), **SIZE)
    v, u = np.mgrid[:121, :161]
    scaled = np.stack([(u - 80.0) / 40.0 / 1.0, (v - 60.0) / 40.0 / 0.5, np.full_like(u, 1) / 1.5])
    axis = np.abs(scaled).argmax(axis=0)
    sign = np.take_along_axis(scaled, axis[None], axis=0)[0] > 0
    margin = np.diff(np.sort(np.abs(scaled), axis=0), axis=0)[1] > 1e-9
    assert (frame.face == 2 * axis + sign)[margin].all()
    assert np.allclose(1.0 / frame.depth, np.abs(scaled).max(axis=0), rtol=1e-12)


def test_height_field_normals_are_those_of_its_depth():
    telephoto = PinholeCamera(520.0, 512.0, 79.3, 60.2)
    frame = synthetic.render(SCENES["height_field"], telephoto, np.eye(4), **SIZE)
    points = points_of(frame, telephoto)
    along_u = points[1:-1, 2:] - points[1:-1, :-2]
    along_v = points[2:, 1:-1] - points[:-2, 1:-1]
    numeric = np.cross(along_v, along_u)
    numeric /= np.linalg.norm(numeric, axis=-1, keepdims=True)
    assert np.abs(numeric - frame.normal[1:-1, 1:-1]).max() < 5e-4
    assert frame.depth.std() > 0.02


def test_texture_gradient_is_the_numeric_one():
    scene = SCENES["sphere"]
    p = np.random.default_rng(1).normal(size=(5, 7, 3)) * 0.4
    grey, gradient = scene.texture_at(0, p)
    assert grey.shape == (5, 7)
    assert gradient.shape == (5, 7, 3)
    for axis in range(3):
        step = 1e-5 * np.eye(3)[axis]
        numeric = (scene.texture_at(0, p + step)[0] - scene.texture_at(0, p - step)[0]) / 2e-5
        error = np.abs(numeric - gradient[..., axis]).max()
        assert error < 1e-7 * np.abs(gradient).max() * 20.0  # h² f''' / 6, the shortest wave 6 cm


def test_texture_at_is_what_the_picture_shows():
    frame = synthetic.render(SCENES["room"], CAMERA, MOTION, **SIZE, options=EXACT)
    points = points_of(frame, CAMERA)
    for face in np.unique(frame.face):
        mask = frame.face == face
        grey, _ = SCENES["room"].texture_at(face, points[mask])
        assert np.abs(grey - frame.irradiance[mask]).max() < 1e-6


def test_band_limit_takes_away_what_the_pixels_cannot_hold():
    """On a far plane every wave is shorter than 2.5 px: the mean is left; near, nothing changes."""
    far = synthetic.plane(slant_deg=0.0, distance=60.0)
    frame = synthetic.render(far, CAMERA, np.eye(4), **SIZE)
    assert np.abs(frame.irradiance - 128.0).max() < 1e-9
    near = synthetic.plane(slant_deg=0.0, distance=1.0)
    banded = synthetic.render(near, CAMERA, np.eye(4), **SIZE)
    plain = synthetic.render(near, CAMERA, np.eye(4), **SIZE, options=EXACT)
    assert np.array_equal(banded.irradiance, plain.irradiance)


def test_supersampling_is_the_mean_over_the_pixel():
    ss, sigma = 4, 0.5
    options = RenderOptions(antialiasing="supersample", supersampling=ss, psf_sigma=0.0)
    pixel = synthetic.render(SCENES["room"], CAMERA, np.eye(4), **SIZE, options=options)
    fine = PinholeCamera(
        CAMERA.fx * ss, CAMERA.fy * ss, (CAMERA.cx + 0.5) * ss - 0.5, (CAMERA.cy + 0.5) * ss - 0.5
    )
    big = synthetic.render(
        SCENES["room"], fine, np.eye(4), width=161 * ss, height=121 * ss
    ).irradiance
    mean = big.reshape(121, ss, 161, ss).mean(axis=(1, 3))
    assert np.abs(mean - pixel.irradiance).max() < 1e-9
    blurred = synthetic.render(
        SCENES["room"], CAMERA, np.eye(4), **SIZE, options=options.replace(psf_sigma=sigma)
    )
    assert np.array_equal(blurred.depth, pixel.depth)
    assert blurred.irradiance.std() < pixel.irradiance.std()


def test_a_wave_through_the_psf_loses_what_a_gaussian_takes():
    scene, lam = Scene(), 0.1
    texture = TextureOptions(min_wavelength=lam, max_wavelength=lam, num_waves=1)
    T_ws = np.eye(4)
    T_ws[2, 3] = 1.0
    scene.add_rectangle(T_ws, width=9.0, height=9.0, texture=texture)
    sharp = synthetic.render(scene, CAMERA, np.eye(4), **SIZE, options=EXACT)
    options = RenderOptions(antialiasing="supersample", supersampling=8, psf_sigma=1.0)
    soft = synthetic.render(scene, CAMERA, np.eye(4), **SIZE, options=options)
    _, gradient = scene.texture_at(0, [0.011, 0.02, 1.0])
    cu, cv = 1.0 / (np.array([130.0, 128.0]) * lam) * gradient[:2] / np.hypot(*gradient[:2])
    factor = np.sinc(cu) * np.sinc(cv) * np.exp(-2.0 * np.pi**2 * (cu**2 + cv**2))
    expected = 128.0 + factor * (sharp.irradiance - 128.0)
    assert np.abs(soft.irradiance - expected).max() < 0.02
    assert factor < 0.95


def test_threads_and_seeds():
    options = RenderOptions(antialiasing="supersample", supersampling=2)
    noisy = SensorOptions(read_noise=2.0)
    arguments = (SCENES["boxes"], CAMERA, MOTION)
    one = synthetic.render(*arguments, **SIZE, options=options, sensor=noisy, seed=3, index=5)
    two = synthetic.render(
        *arguments, **SIZE, options=options.replace(num_threads=2), sensor=noisy, seed=3, index=5
    )
    for name in ("image", "irradiance", "depth", "normal", "face"):
        assert np.array_equal(getattr(one, name), getattr(two, name), equal_nan=True)
    again = synthetic.expose(one.irradiance, options=noisy, seed=3, index=5)
    assert np.array_equal(again, one.image)
    for other in ({"seed": 4, "index": 5}, {"seed": 3, "index": 6}):
        assert not np.array_equal(
            synthetic.expose(one.irradiance, options=noisy, **other), one.image
        )
    assert not np.array_equal(
        synthetic.render(synthetic.room(seed=1), CAMERA, MOTION, **SIZE).image,
        synthetic.render(synthetic.room(seed=2), CAMERA, MOTION, **SIZE).image,
    )


@pytest.mark.parametrize(("width", "height"), [(1, 1), (17, 3), (16, 16), (5, 40)])
def test_odd_sizes_are_crops_of_the_large_picture(width: int, height: int):
    large = synthetic.render(SCENES["boxes"], CAMERA, MOTION, **SIZE)
    small = synthetic.render(SCENES["boxes"], CAMERA, MOTION, width=width, height=height)
    assert np.array_equal(small.irradiance, large.irradiance[:height, :width])
    assert np.array_equal(small.normal, large.normal[:height, :width])


def test_distorted_camera_sees_along_its_rays():
    camera = RadtanCamera(130.0, 128.0, 79.3, 60.2, -0.25, 0.05, 0.002, -0.001)
    frame = synthetic.render(SCENES["room"], camera, np.eye(4), **SIZE, options=EXACT)
    points = points_of(frame, camera)
    uv, _ = CAMERA.project(points[60, 20])
    straight = look_through(SCENES["room"], np.eye(4), uv)
    assert straight.irradiance[0, 0] == pytest.approx(frame.irradiance[60, 20], abs=1e-6)
    assert np.hypot(*(uv - [20, 60])) > 3.0
    folded = RadtanCamera(40.0, 40.0, 79.3, 60.2, -0.6, 0.0, 0.0, 0.0)
    assert not synthetic.render(SCENES["room"], folded, np.eye(4), **SIZE).valid.all()


def test_rays_that_meet_nothing():
    options = RenderOptions(background=7.0)
    frame = synthetic.render(synthetic.board(), CAMERA, np.eye(4), **SIZE, options=options)
    empty = ~frame.valid
    assert empty.any()
    assert frame.valid.any()
    assert np.isnan(frame.depth[empty]).all()
    assert np.isnan(frame.normal[empty]).all()
    assert (frame.irradiance[empty] == 7.0).all()
    assert (frame.face[empty] == -1).all()


def test_rolling_shutter_takes_each_row_at_its_time():
    motion = np.array([0.2, -0.1, 0.05, 0.02, 0.1, -0.03])
    options = EXACT.replace(readout_time=0.8)
    rolled = synthetic.render(
        SCENES["room"], CAMERA, MOTION, **SIZE, options=options, motion=motion
    )
    for v in (0, 60, 120):
        time = 0.8 * ((v + 0.5) / 121 - 0.5)
        still = synthetic.render(
            SCENES["room"], CAMERA, se3_exp(time * motion) @ MOTION, **SIZE, options=EXACT
        )
        assert np.abs(rolled.irradiance[v] - still.irradiance[v]).max() < 1e-9
        assert np.abs(rolled.depth[v] - still.depth[v]).max() < 1e-12


def test_motion_blur_is_the_mean_over_the_exposure():
    motion = np.array([0.1, 0.0, 0.0, 0.0, 0.05, 0.0])
    options = EXACT.replace(exposure_time=0.5, blur_samples=4)
    blurred = synthetic.render(
        SCENES["room"], CAMERA, MOTION, **SIZE, options=options, motion=motion
    )
    mean = np.zeros_like(blurred.irradiance)
    for s in range(4):
        pose = se3_exp(0.5 * ((s + 0.5) / 4 - 0.5) * motion) @ MOTION
        mean += synthetic.render(SCENES["room"], CAMERA, pose, **SIZE, options=EXACT).irradiance / 4
    assert np.abs(mean - blurred.irradiance).max() < 1e-9
    still = synthetic.render(SCENES["room"], CAMERA, MOTION, **SIZE, options=EXACT)
    assert np.array_equal(blurred.depth, still.depth)


def test_vignette_of_a_white_wall_is_the_polynomial():
    sensor = SensorOptions(
        vignette_r2=-0.4, vignette_r4=0.1, vignette_r6=-0.05, exposure=1.2, format="float32"
    )
    wall = synthetic.plane(slant_deg=0.0, texture=WHITE)
    frame = synthetic.render(wall, CAMERA, np.eye(4), **SIZE, sensor=sensor)
    v, u = np.mgrid[:121, :161]
    r2 = ((u - 80.0) ** 2 + (v - 60.0) ** 2) / (0.25 * (161**2 + 121**2))
    expected = 120.0 * (1.0 - 0.4 * r2 + 0.1 * r2**2 - 0.05 * r2**3)
    assert np.abs(frame.image - expected).max() < 1e-5


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"exposure": 2.0, "gain": math.log(0.75), "bias": 5.0}, 155.0),
        ({"response": "gamma", "gamma": 2.0}, 255.0 * math.sqrt(100.0 / 255.0)),
        ({"response": "lut", "lut": [0.0, 10.0, 255.0]}, 10.0 * 200.0 / 255.0),
        ({"bias": -300.0}, -200.0),
    ],
)
def test_response(changes: dict, expected: float):
    sensor = SensorOptions(format="float32", **changes)
    image = synthetic.expose(np.full((2, 3), 100.0), options=sensor)
    assert image == pytest.approx(expected, rel=1e-6)


def test_pixel_formats():
    light = np.array([[-3.0, 99.4, 99.6, 300.0]])
    assert synthetic.expose(light).tolist() == [[0, 99, 100, 255]]
    wide = synthetic.expose(light, options=SensorOptions(format=PixelType.UINT16))
    assert wide.dtype == np.uint16
    assert wide.tolist() == [[0, 25546, 25597, 65535]]
    real = synthetic.expose(light, options=SensorOptions(format="float32"))
    assert np.array_equal(real, light.astype(np.float32))


def test_noise_has_the_variance_asked_for_in_every_grey_bin():
    sensor = SensorOptions(read_noise=1.5, shot_noise=0.05, format="float32")
    levels = np.repeat(np.arange(20.0, 241.0, 20.0), 40)
    light = np.broadcast_to(levels, (1000, levels.size))
    error = synthetic.expose(light, options=sensor, seed=11) - light
    for level in np.unique(levels):
        variance = error[:, levels == level].var()
        assert variance == pytest.approx(1.5**2 + 0.05 * level, rel=0.03)
    whitened = error / np.sqrt(1.5**2 + 0.05 * light)
    assert whitened.var() == pytest.approx(1.0, abs=0.012)
    assert abs(whitened.mean()) < 0.01
    for shift in (np.roll(whitened, 1, axis=0), np.roll(whitened, 1, axis=1)):
        assert abs((whitened * shift).mean()) < 0.01


@pytest.mark.parametrize(
    "options",
    [
        (RenderOptions, "supersampling", 0),
        (RenderOptions, "exposure_time", 1.5),
        (SensorOptions, "exposure", 0.0),
        (SensorOptions, "read_noise", -1.0),
        (SensorOptions, "vignette_r2", -1.1),
        (TextureOptions, "min_wavelength", 0.0),
        (synthetic.HeightFieldOptions, "amplitude", math.inf),
    ],
)
def test_bad_options_are_named(options: tuple):
    cls, name, value = options
    with pytest.raises(OptionsError, match=f"{cls.__name__}.{name}"):
        cls(**{name: value})


def test_bad_arguments_are_refused():
    room = SCENES["room"]
    with pytest.raises(OptionsError, match="T_cw"):
        synthetic.render(room, CAMERA, 2.0 * np.eye(4), **SIZE)
    with pytest.raises(ShapeError, match="T_cw"):
        synthetic.render(room, CAMERA, np.eye(3), **SIZE)
    with pytest.raises(ShapeError, match="width"):
        synthetic.render(room, CAMERA, np.eye(4), width=0, height=3)
    with pytest.raises(OptionsError, match="motion"):
        synthetic.render(room, CAMERA, np.eye(4), **SIZE, motion=np.full(6, np.nan))
    with pytest.raises(OptionsError, match=r"SensorOptions\.lut"):
        SensorOptions(response="lut", lut=[3.0, 2.0])
    for call in (
        lambda: synthetic.room(size=(1.0, 0.0, 1.0)),
        lambda: synthetic.plane(slant_deg=90.0),
        lambda: synthetic.plane(distance=-1.0),
        lambda: synthetic.boxes(n=-1),
        lambda: synthetic.sphere(radius=0.0),
        lambda: synthetic.board(size=(0.0, 1.0)),
        lambda: synthetic.look_at([0, 0, 0], [0, 1, 0]),
        lambda: room.texture_at(6, [0.0, 0.0, 0.0]),
    ):
        with pytest.raises(OptionsError):
            call()


def test_look_at_looks_at():
    T_wc = synthetic.look_at([1.0, -0.5, 0.2], [0.3, 0.4, 2.0], roll_deg=10.0)
    uv, valid = CAMERA.project((np.array([0.3, 0.4, 2.0]) - T_wc[:3, 3]) @ T_wc[:3, :3])
    assert valid
    assert uv == pytest.approx([CAMERA.cx, CAMERA.cy])
    assert np.allclose(T_wc[:3, :3] @ T_wc[:3, :3].T, np.eye(3))
    level = synthetic.look_at([1.0, -0.5, 0.2], [0.3, 0.4, 2.0])
    assert level[1, 0] == 0.0  # x stays horizontal
    assert level[1, 1] > 0.0  # y points down
    assert synthetic.boxes(n=1).num_faces == 12
    assert Antialiasing.NONE is EXACT.antialiasing
    assert TextureKind.UNIFORM is WHITE.kind
