"""Camera calibrations from YAML: raylign's own, ROS, OpenCV, Kalibr and EuRoC, ORB-SLAM."""

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeAlias

from raylign._typing import PathLike
from raylign.camera import PinholeCamera, RadtanCamera
from raylign.io._streams import format_error
from raylign.io._text import read_text, shown
from raylign.io.sequence import Calibration

Node: TypeAlias = dict[str, Any]

_PINHOLE_NAMES = ("pinhole", "none", "")
_RADTAN_NAMES = ("brown_conrady", "radtan", "radial-tangential", "plumb_bob")
_OWN_FIELDS = {"model", "width", "height", "fx", "fy", "cx", "cy", "distortion", "baseline"}


def read_calibration(path: PathLike) -> Calibration:
    """Read a camera from a YAML file of one of five kinds, told apart by their keys.

    raylign's own, `camera:` with fx, fy, cx, cy (px), optionally width, height (px), model
    (`pinhole` or `brown_conrady`), distortion [k1, k2, p1, p2, k3] and baseline (m); ROS
    `camera_info` (`plumb_bob`); OpenCV's FileStorage (`camera_matrix`, `distortion_coefficients`);
    Kalibr's camchain and EuRoC's `sensor.yaml` (`intrinsics`, radtan; the first camera); ORB-SLAM's
    `Camera.fx`. Distortion is Brown-Conrady or none: a fisheye or rational model is refused.

    Args:
        path: YAML file.

    Returns:
        Calibration: a `PinholeCamera` where all distortion is 0.

    Raises:
        FormatError: the file cannot be read, is no YAML, of no known kind, or holds a value that is
            missing, not finite or out of range; the error has `file`, `field` and `reason`, and
            for a syntax error `line`.

    Example:
        >>> import pathlib, tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     path = pathlib.Path(folder) / "camera.yaml"
        ...     _ = path.write_text("camera: {fx: 500, fy: 501, cx: 320, cy: 240}")
        ...     read_calibration(path).camera
        PinholeCamera(fx=500.0, fy=501.0, cx=320.0, cy=240.0)
    """
    name, root = load_yaml(path)
    for matches, build in _KINDS:
        if matches(root):
            return build(_Reader(name, root))
    expected = "camera, camera_matrix, intrinsics, cam0 or Camera.fx"
    raise format_error(name, "", f"holds no camera: expected one of the keys {expected}")


def load_yaml(path: PathLike) -> tuple[str, Node]:
    """Name and top-level mapping of a YAML file, OpenCV's dialect included.

    Raises:
        FormatError: it cannot be read, is no YAML, or no mapping.
    """
    import yaml

    class Loader(yaml.SafeLoader):  # type: ignore[misc]
        """SafeLoader that takes OpenCV's matrices as mappings."""

    for kind in ("opencv-matrix", "opencv-nd-matrix"):  # the latter since OpenCV 5, for vectors
        Loader.add_constructor(
            f"tag:yaml.org,2002:{kind}",
            lambda loader, node: loader.construct_mapping(node, deep=True),
        )
    name, text = read_text(path)
    first, _, rest = text.partition("\n")
    if first.startswith("%YAML:"):  # OpenCV's directive, which YAML does not have
        text = "\n" + rest
    try:
        root = yaml.load(text, Loader)  # a SafeLoader
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        mark = getattr(error, "problem_mark", None)
        problem = getattr(error, "problem", None) or str(error)
        line = 0 if mark is None else mark.line + 1
        raise format_error(name, "", f"is no YAML: {problem}", line=line) from error
    if not isinstance(root, dict):
        raise format_error(name, "", "is no YAML mapping")
    return name, {str(key): value for key, value in root.items()}


class _Reader:
    """Typed look-ups in a mapping of a file."""

    def __init__(self, file: str, node: Node, prefix: str = "") -> None:
        self.file, self.node, self.prefix = file, node, prefix

    def error(self, key: str, reason: str) -> Exception:
        return format_error(self.file, self.prefix + key, reason)

    def number(self, key: str, default: float | None = None) -> float:
        if key not in self.node and default is not None:
            return default
        if key not in self.node:
            raise self.error(key, "is missing")
        return self.as_number(self.node[key], key)

    def as_number(self, value: Any, key: str) -> float:
        try:  # str: YAML 1.1 does not know 5e2 as a number
            number = float(value) if isinstance(value, int | float | str) else math.nan
        except (ValueError, OverflowError):
            number = math.nan
        if isinstance(value, bool) or not math.isfinite(number):
            raise self.error(key, f"expected a finite number, got {shown(str(value))}")
        return number

    def numbers(self, key: str) -> list[float]:
        """A list of numbers, or the `data` of a matrix; empty where there is none."""
        value = self.node.get(key)
        if value is None:
            return []
        if isinstance(value, dict):
            value = value.get("data")
        if not isinstance(value, list):
            raise self.error(key, "expected a list of numbers")
        flat = [x for row in value for x in (row if isinstance(row, list) else [row])]
        return [self.as_number(x, key) for x in flat]

    def text(self, *keys: str) -> str:
        values = [self.node[key] for key in keys if self.node.get(key) is not None]
        return str(values[0]).strip().lower() if values else ""

    def size(self, key: str) -> int:
        """A side in px; 0 where it is not given."""
        value = self.number(key, 0.0)
        if value < 0 or value != int(value):
            raise self.error(key, f"expected a whole number of px, got {value:g}")
        return int(value)

    def child(self, key: str) -> "_Reader":
        value = self.node.get(key)
        if not isinstance(value, dict):
            raise self.error(key, "expected a mapping")
        node = {str(name): item for name, item in value.items()}
        return _Reader(self.file, node, f"{self.prefix}{key}.")

    def camera(
        self, pinhole: list[float], distortion: list[float], model: str
    ) -> PinholeCamera | RadtanCamera:
        """Build the model; only Brown-Conrady's five numbers are known."""
        fx, fy, cx, cy = pinhole
        if fx <= 0.0 or fy <= 0.0:
            raise self.error("fx, fy", f"must be > 0, got {fx:g} and {fy:g}")
        if not any(distortion):
            return PinholeCamera(fx, fy, cx, cy)
        if model not in _RADTAN_NAMES:
            known = ", ".join(name for name in (*_PINHOLE_NAMES, *_RADTAN_NAMES) if name)
            raise self.error("distortion", f"model {shown(model)} is not known, only {known}")
        if len(distortion) < 4 or any(distortion[5:]):
            raise self.error(
                "distortion", f"expected k1 k2 p1 p2 [k3], got {len(distortion)} numbers"
            )
        return RadtanCamera(fx, fy, cx, cy, *[*distortion, 0.0][:5])


def _own(reader: _Reader) -> Calibration:
    camera = reader.child("camera")
    unknown = sorted(set(camera.node) - _OWN_FIELDS)
    if unknown:
        raise camera.error(unknown[0], f"is no field; these are: {', '.join(sorted(_OWN_FIELDS))}")
    pinhole = [camera.number(key) for key in ("fx", "fy", "cx", "cy")]
    distortion = camera.numbers("distortion")
    model = camera.text("model") or ("brown_conrady" if distortion else "pinhole")
    if model not in (*_PINHOLE_NAMES, *_RADTAN_NAMES):
        raise camera.error("model", f"expected pinhole or brown_conrady, got {shown(model)}")
    baseline = camera.number("baseline", 0.0)
    if baseline < 0.0:
        raise camera.error("baseline", f"must be >= 0, got {baseline:g}")
    return Calibration(
        camera.camera(pinhole, distortion, model),
        camera.size("width"),
        camera.size("height"),
        baseline,
        f"intrinsics of {Path(reader.file).name}",
    )


def _matrix_camera(reader: _Reader) -> Calibration:
    """ROS camera_info and OpenCV FileStorage: a 3x3 matrix and a list."""
    key = _first_key(reader.node, _MATRIX_KEYS)
    K = reader.numbers(key)
    if len(K) != 9:
        raise reader.error(key, f"expected 9 numbers, got {len(K)}")
    if K[1] != 0.0 or K[3:4] != [0.0] or K[6:] != [0.0, 0.0, 1.0]:
        raise reader.error(key, "is no matrix [fx 0 cx; 0 fy cy; 0 0 1]")
    distortion_key = _first_key(reader.node, _DISTORTION_KEYS)
    model = reader.text("distortion_model", "camera_model") or "plumb_bob"
    return Calibration(
        reader.camera(
            [K[0], K[4], K[2], K[5]],
            reader.numbers(distortion_key),
            "plumb_bob" if model == "pinhole" else model,
        ),
        reader.size(_first_key(reader.node, ("image_width", "imageWidth", "width"))),
        reader.size(_first_key(reader.node, ("image_height", "imageHeight", "height"))),
        source=f"intrinsics of {Path(reader.file).name}",
    )


def _list_camera(reader: _Reader) -> Calibration:
    """Kalibr's camchain (`cam0:` and so on) and EuRoC's sensor.yaml: fx, fy, cx, cy in a list."""
    camera = reader.child("cam0") if "cam0" in reader.node else reader
    model = camera.text("camera_model") or "pinhole"
    if model != "pinhole":
        raise camera.error("camera_model", f"expected pinhole, got {shown(model)}")
    pinhole = camera.numbers("intrinsics")
    if len(pinhole) != 4:
        raise camera.error("intrinsics", f"expected fx fy cx cy, got {len(pinhole)} numbers")
    distortion = camera.numbers(
        _first_key(camera.node, ("distortion_coeffs", "distortion_coefficients"))
    )
    size = camera.numbers("resolution") or [0.0, 0.0]
    if len(size) != 2 or any(side < 0 or side != int(side) for side in size):
        raise camera.error("resolution", "expected width and height in px")
    return Calibration(
        camera.camera(pinhole, distortion, camera.text("distortion_model") or "radtan"),
        int(size[0]),
        int(size[1]),
        source=f"intrinsics of {Path(reader.file).name}",
    )


def _dotted_camera(reader: _Reader) -> Calibration:
    """ORB-SLAM's flat keys: `Camera.fx`, `Camera.k1`; version 3 calls it `Camera1`."""
    dot = "Camera." if "Camera.fx" in reader.node else "Camera1."
    pinhole = [reader.number(dot + key) for key in ("fx", "fy", "cx", "cy")]
    distortion = [reader.number(dot + key, 0.0) for key in ("k1", "k2", "p1", "p2", "k3")]
    kind = reader.text("Camera.type") or "pinhole"
    if kind not in ("pinhole", "rectified"):
        raise reader.error("Camera.type", f"expected PinHole, got {shown(kind)}")
    return Calibration(
        reader.camera(pinhole, distortion, "radtan"),
        reader.size("Camera.width"),
        reader.size("Camera.height"),
        source=f"intrinsics of {Path(reader.file).name}",
    )


_MATRIX_KEYS = ("camera_matrix", "cameraMatrix", "Camera_Matrix", "K", "k")
_DISTORTION_KEYS = (
    "distortion_coefficients",
    "Distortion_Coefficients",
    "distCoeffs",
    "dist_coeffs",
    "D",
    "d",
)
_KINDS: tuple[tuple[Callable[[Node], bool], Callable[[_Reader], Calibration]], ...] = (
    (lambda node: "camera" in node, _own),
    (lambda node: any(key in node for key in _MATRIX_KEYS), _matrix_camera),
    (lambda node: "intrinsics" in node or "cam0" in node, _list_camera),
    (lambda node: "Camera.fx" in node or "Camera1.fx" in node, _dotted_camera),
)


def _first_key(node: Node, keys: tuple[str, ...]) -> str:
    """The first of the keys that is there, else the first of them."""
    return next((key for key in keys if key in node), keys[0])
