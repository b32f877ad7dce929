"""Typed surface of the compiled module. scripts/make_stub.py writes it: do not edit."""

import enum
from collections.abc import Callable, Iterator, Sequence
from typing import Any, ClassVar, Self, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

class Error(RuntimeError): ...
class OptionsError(Error, ValueError): ...
class ShapeError(Error, ValueError): ...

class FormatError(Error, ValueError):
    file: str
    line: int
    field: str
    reason: str

def build_info() -> dict[str, Any]: ...
def so3_hat(omega: object, /) -> NDArray[np.float64]: ...
def so3_vee(omega_hat: object, /) -> NDArray[np.float64]: ...
def so3_exp(omega: object, /) -> NDArray[np.float64]: ...
def so3_log(R: object, /) -> NDArray[np.float64]: ...
def so3_adjoint(R: object, /) -> NDArray[np.float64]: ...
def so3_left_jacobian(omega: object, /) -> NDArray[np.float64]: ...
def so3_right_jacobian(omega: object, /) -> NDArray[np.float64]: ...
def so3_left_jacobian_inverse(omega: object, /) -> NDArray[np.float64]: ...
def so3_right_jacobian_inverse(omega: object, /) -> NDArray[np.float64]: ...
def quaternion_exp(omega: object, /) -> NDArray[np.float64]: ...
def quaternion_log(q: object, /) -> NDArray[np.float64]: ...
def quaternion_to_matrix(q: object, /) -> NDArray[np.float64]: ...
def quaternion_from_matrix(R: object, /) -> NDArray[np.float64]: ...
def se3_hat(xi: object, /) -> NDArray[np.float64]: ...
def se3_vee(xi_hat: object, /) -> NDArray[np.float64]: ...
def se3_exp(xi: object, /) -> NDArray[np.float64]: ...
def se3_log(T: object, /) -> NDArray[np.float64]: ...
def se3_inverse(T: object, /) -> NDArray[np.float64]: ...
def se3_adjoint(T: object, /) -> NDArray[np.float64]: ...
def se3_left_jacobian(xi: object, /) -> NDArray[np.float64]: ...
def se3_right_jacobian(xi: object, /) -> NDArray[np.float64]: ...
def se3_left_jacobian_inverse(xi: object, /) -> NDArray[np.float64]: ...
def se3_right_jacobian_inverse(xi: object, /) -> NDArray[np.float64]: ...
def sim3_hat(xi: object, /) -> NDArray[np.float64]: ...
def sim3_vee(xi_hat: object, /) -> NDArray[np.float64]: ...
def sim3_exp(xi: object, /) -> NDArray[np.float64]: ...
def sim3_log(S: object, /) -> NDArray[np.float64]: ...
def sim3_inverse(S: object, /) -> NDArray[np.float64]: ...
def sim3_adjoint(S: object, /) -> NDArray[np.float64]: ...
def sim3_left_jacobian(xi: object, /) -> NDArray[np.float64]: ...
def sim3_right_jacobian(xi: object, /) -> NDArray[np.float64]: ...
def sim3_left_jacobian_inverse(xi: object, /) -> NDArray[np.float64]: ...
def sim3_right_jacobian_inverse(xi: object, /) -> NDArray[np.float64]: ...
def umeyama(source: object, target: object, *, with_scale: bool = True) -> NDArray[np.float64]: ...

class PinholeCamera:
    __fields__: ClassVar[tuple[str, ...]]
    num_params: ClassVar[int]
    @property
    def fx(self) -> float: ...
    @property
    def fy(self) -> float: ...
    @property
    def cx(self) -> float: ...
    @property
    def cy(self) -> float: ...
    @property
    def params(self) -> NDArray[np.float64]: ...
    def __init__(self, fx: float, fy: float, cx: float, cy: float) -> None: ...
    def __repr__(self) -> str: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def project(self, p_c: object) -> tuple[Any, ...]: ...
    def project_with_jacobians(self, p_c: object) -> tuple[Any, ...]: ...
    def unproject(self, uv: object) -> tuple[Any, ...]: ...
    def unproject_with_jacobians(self, uv: object) -> tuple[Any, ...]: ...
    @staticmethod
    def is_in_front(p_c: object) -> object: ...
    def matrix(self) -> NDArray[np.float64]: ...
    def at_level(self, level: int) -> PinholeCamera: ...

class RadtanCamera:
    __fields__: ClassVar[tuple[str, ...]]
    num_params: ClassVar[int]
    @property
    def fx(self) -> float: ...
    @property
    def fy(self) -> float: ...
    @property
    def cx(self) -> float: ...
    @property
    def cy(self) -> float: ...
    @property
    def k1(self) -> float: ...
    @property
    def k2(self) -> float: ...
    @property
    def p1(self) -> float: ...
    @property
    def p2(self) -> float: ...
    @property
    def k3(self) -> float: ...
    @property
    def params(self) -> NDArray[np.float64]: ...
    def __init__(
        self,
        fx: float,
        fy: float,
        cx: float,
        cy: float,
        k1: float,
        k2: float,
        p1: float,
        p2: float,
        k3: float = 0.0,
    ) -> None: ...
    def __repr__(self) -> str: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def project(self, p_c: object) -> tuple[Any, ...]: ...
    def project_with_jacobians(self, p_c: object) -> tuple[Any, ...]: ...
    def unproject(self, uv: object) -> tuple[Any, ...]: ...
    def unproject_with_jacobians(self, uv: object) -> tuple[Any, ...]: ...
    @staticmethod
    def is_in_front(p_c: object) -> object: ...

class BalCamera:
    __fields__: ClassVar[tuple[str, ...]]
    num_params: ClassVar[int]
    @property
    def f(self) -> float: ...
    @property
    def k1(self) -> float: ...
    @property
    def k2(self) -> float: ...
    @property
    def params(self) -> NDArray[np.float64]: ...
    def __init__(self, f: float, k1: float = 0.0, k2: float = 0.0) -> None: ...
    def __repr__(self) -> str: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def project(self, p_c: object) -> tuple[Any, ...]: ...
    def project_with_jacobians(self, p_c: object) -> tuple[Any, ...]: ...
    def unproject(self, uv: object) -> tuple[Any, ...]: ...
    def unproject_with_jacobians(self, uv: object) -> tuple[Any, ...]: ...
    @staticmethod
    def is_in_front(p_c: object) -> object: ...

@overload
def undistort_map(
    camera: PinholeCamera, K_new: object, *, width: int, height: int
) -> tuple[Any, ...]: ...
@overload
def undistort_map(
    camera: RadtanCamera, K_new: object, *, width: int, height: int
) -> tuple[Any, ...]: ...

class Interpolation(enum.Enum):
    NEAREST = 0
    LINEAR = 1
    CUBIC = 2

class SampleInterpolation(enum.Enum):
    BILINEAR = 0
    CENTRAL_DIFFERENCE = 1
    CUBIC_BSPLINE = 2

class ColorOrder(enum.Enum):
    RGB = 0
    BGR = 1

def remap(
    image: object, map_x: object, map_y: object, *, interpolation: Interpolation
) -> NDArray[Any]: ...
def to_grey(image: object, *, color_order: ColorOrder) -> NDArray[Any]: ...
def gradient_image(image: object, *, color_order: ColorOrder) -> NDArray[Any]: ...
def max_gradient(image: object, *, color_order: ColorOrder) -> NDArray[Any]: ...
def sample(
    image: object, uv: object, *, interpolation: SampleInterpolation, color_order: ColorOrder
) -> tuple[Any, ...]: ...

class PyramidOptions:
    __fields__: ClassVar[tuple[str, ...]]
    max_levels: int
    min_side: int
    def __init__(self, *, max_levels: int = ..., min_side: int = ...) -> None: ...
    def replace(self, *, max_levels: int = ..., min_side: int = ...) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class DepthPyramidOptions:
    __fields__: ClassVar[tuple[str, ...]]
    pyramid: PyramidOptions
    max_depth_ratio: float
    def __init__(self, *, pyramid: PyramidOptions = ..., max_depth_ratio: float = ...) -> None: ...
    def replace(self, *, pyramid: PyramidOptions = ..., max_depth_ratio: float = ...) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class ImagePyramid:
    @property
    def num_levels(self) -> int: ...
    def __init__(
        self,
        image: object,
        *,
        options: PyramidOptions | None = None,
        color_order: ColorOrder = ColorOrder.RGB,
    ) -> None: ...
    def assign(self, image: object, *, color_order: ColorOrder = ColorOrder.RGB) -> None: ...
    def __len__(self) -> int: ...
    def __getitem__(self, level: int) -> NDArray[Any]: ...
    def __iter__(self) -> Iterator[NDArray[Any]]: ...

class DepthPyramid:
    @property
    def num_levels(self) -> int: ...
    def __init__(
        self, inverse_depth: object, variance: object, *, options: DepthPyramidOptions | None = None
    ) -> None: ...
    def __len__(self) -> int: ...
    def __getitem__(self, level: int) -> tuple[NDArray[Any], NDArray[Any]]: ...
    def __iter__(self) -> Iterator[tuple[NDArray[Any], NDArray[Any]]]: ...

class BSplineImage:
    @property
    def coefficients(self) -> NDArray[Any]: ...
    def __init__(self, image: object, *, color_order: ColorOrder = ColorOrder.RGB) -> None: ...
    def sample(self, uv: object) -> tuple[Any, ...]: ...

class DepthNoise(enum.Enum):
    KINECT = 0
    DISPARITY = 1
    TIME_OF_FLIGHT = 2
    CONSTANT = 3

class DepthModel:
    __fields__: ClassVar[tuple[str, ...]]
    noise: DepthNoise
    sigma: float
    focal_baseline: float
    min_depth: float
    max_depth: float
    edge_ratio: float
    edge_radius: int
    def __init__(
        self,
        *,
        noise: DepthNoise | str = ...,
        sigma: float = ...,
        focal_baseline: float = ...,
        min_depth: float = ...,
        max_depth: float = ...,
        edge_ratio: float = ...,
        edge_radius: int = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        noise: DepthNoise | str = ...,
        sigma: float = ...,
        focal_baseline: float = ...,
        min_depth: float = ...,
        max_depth: float = ...,
        edge_ratio: float = ...,
        edge_radius: int = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def inverse_depth_sigma(self, depth: object) -> NDArray[np.float64]: ...

def inverse_depth(depth: object, *, model: DepthModel, depth_scale: float) -> tuple[Any, ...]: ...

class LossType(enum.Enum):
    TRIVIAL = 0
    HUBER = 1
    SOFT_L1 = 2
    CAUCHY = 3
    ARCTAN = 4
    TUKEY = 5
    GEMAN_MCCLURE = 6
    STUDENT_T = 7

class Loss:
    __fields__: ClassVar[tuple[str, ...]]
    type: LossType
    scale: float
    degrees_of_freedom: float
    def __init__(
        self, *, type: LossType | str = ..., scale: float = ..., degrees_of_freedom: float = ...
    ) -> None: ...
    def replace(
        self, *, type: LossType | str = ..., scale: float = ..., degrees_of_freedom: float = ...
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def evaluate(self, squared_norm: object) -> tuple[Any, ...]: ...
    @staticmethod
    def parse(text: str) -> Loss: ...

class LinearSolverType(enum.Enum):
    AUTO = 0
    DENSE_NORMAL_CHOLESKY = 1
    DENSE_SCHUR = 2
    SPARSE_SCHUR = 3
    ITERATIVE_SCHUR = 4

class Preconditioner(enum.Enum):
    AUTO = 0
    IDENTITY = 1
    JACOBI = 2
    SCHUR_JACOBI = 3
    CLUSTER_JACOBI = 4
    CLUSTER_TRIDIAGONAL = 5
    TWO_LEVEL = 6
    STALE_FACTOR = 7

class Termination(enum.Enum):
    NOT_RUN = 0
    CONVERGENCE = 1
    MAX_ITERATIONS = 2
    TIME_LIMIT = 3
    USER_STOPPED = 4
    FAILURE = 5

class Backend(enum.Enum):
    AUTO = 0
    CERES = 1
    NATIVE = 2

class PoseParametrization(enum.Enum):
    SE3 = 0
    QUATERNION = 1
    ANGLE_AXIS = 2

class PointParametrization(enum.Enum):
    XYZ = 0
    HOMOGENEOUS = 1
    INVERSE_DEPTH = 2

class JacobianStorage(enum.Enum):
    AUTO = 0
    DOUBLE = 1
    FLOAT = 2

class Gauge(enum.Enum):
    FREE = 0
    FIRST_CAMERA = 1
    TWO_CAMERAS = 2

class ParameterKind(enum.Enum):
    POSE = 0
    INTRINSICS = 1
    POINT = 2

class LmOptions:
    __fields__: ClassVar[tuple[str, ...]]
    max_num_iterations: int
    max_solver_time_s: float
    function_tolerance: float
    gradient_tolerance: float
    parameter_tolerance: float
    initial_lambda: float
    min_lambda: float
    max_lambda: float
    min_relative_decrease: float
    min_diagonal: float
    max_diagonal: float
    max_num_consecutive_invalid_steps: int
    jacobi_scaling: bool
    num_threads: int
    def __init__(
        self,
        *,
        max_num_iterations: int = ...,
        max_solver_time_s: float = ...,
        function_tolerance: float = ...,
        gradient_tolerance: float = ...,
        parameter_tolerance: float = ...,
        initial_lambda: float = ...,
        min_lambda: float = ...,
        max_lambda: float = ...,
        min_relative_decrease: float = ...,
        min_diagonal: float = ...,
        max_diagonal: float = ...,
        max_num_consecutive_invalid_steps: int = ...,
        jacobi_scaling: bool = ...,
        num_threads: int = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        max_num_iterations: int = ...,
        max_solver_time_s: float = ...,
        function_tolerance: float = ...,
        gradient_tolerance: float = ...,
        parameter_tolerance: float = ...,
        initial_lambda: float = ...,
        min_lambda: float = ...,
        max_lambda: float = ...,
        min_relative_decrease: float = ...,
        min_diagonal: float = ...,
        max_diagonal: float = ...,
        max_num_consecutive_invalid_steps: int = ...,
        jacobi_scaling: bool = ...,
        num_threads: int = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class LinearSolverOptions:
    __fields__: ClassVar[tuple[str, ...]]
    type: LinearSolverType
    preconditioner: Preconditioner
    explicit_schur: bool
    max_num_iterations: int
    forcing_tolerance: float
    def __init__(
        self,
        *,
        type: LinearSolverType | str = ...,
        preconditioner: Preconditioner | str = ...,
        explicit_schur: bool = ...,
        max_num_iterations: int = ...,
        forcing_tolerance: float = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        type: LinearSolverType | str = ...,
        preconditioner: Preconditioner | str = ...,
        explicit_schur: bool = ...,
        max_num_iterations: int = ...,
        forcing_tolerance: float = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class BundleOptions:
    __fields__: ClassVar[tuple[str, ...]]
    backend: Backend
    pose_parametrization: PoseParametrization
    point_parametrization: PointParametrization
    loss: Loss
    lm: LmOptions
    linear_solver: LinearSolverOptions
    jacobian_storage: JacobianStorage
    parity: bool
    def __init__(
        self,
        *,
        backend: Backend | str = ...,
        pose_parametrization: PoseParametrization | str = ...,
        point_parametrization: PointParametrization | str = ...,
        loss: Loss | str = ...,
        lm: LmOptions = ...,
        linear_solver: LinearSolverOptions = ...,
        jacobian_storage: JacobianStorage | str = ...,
        parity: bool = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        backend: Backend | str = ...,
        pose_parametrization: PoseParametrization | str = ...,
        point_parametrization: PointParametrization | str = ...,
        loss: Loss | str = ...,
        lm: LmOptions = ...,
        linear_solver: LinearSolverOptions = ...,
        jacobian_storage: JacobianStorage | str = ...,
        parity: bool = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class ConstantCoordinate:
    __fields__: ClassVar[tuple[str, ...]]
    kind: ParameterKind
    index: int
    coordinate: str
    def __init__(
        self, *, kind: ParameterKind | str = ..., index: int = ..., coordinate: str = ...
    ) -> None: ...
    def replace(
        self, *, kind: ParameterKind | str = ..., index: int = ..., coordinate: str = ...
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class BundleConfig:
    __fields__: ClassVar[tuple[str, ...]]
    gauge: Gauge
    constant_cameras: list[int]
    constant_intrinsics: list[int]
    constant_points: list[int]
    constant_coordinates: list[ConstantCoordinate]
    def __init__(
        self,
        *,
        gauge: Gauge | str = ...,
        constant_cameras: list[int] = ...,
        constant_intrinsics: list[int] = ...,
        constant_points: list[int] = ...,
        constant_coordinates: list[ConstantCoordinate] = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        gauge: Gauge | str = ...,
        constant_cameras: list[int] = ...,
        constant_intrinsics: list[int] = ...,
        constant_points: list[int] = ...,
        constant_coordinates: list[ConstantCoordinate] = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class IterationSummary:
    __fields__: ClassVar[tuple[str, ...]]
    iteration: int
    linear_solver_iterations: int
    num_residual_blocks: int
    step_is_valid: bool
    step_is_accepted: bool
    cost: float
    cost_change: float
    gain_ratio: float
    gradient_max_norm: float
    step_norm: float
    lambda_: float
    linear_solver_time_s: float
    iteration_time_s: float
    cumulative_time_s: float
    def __init__(
        self,
        *,
        iteration: int = ...,
        linear_solver_iterations: int = ...,
        num_residual_blocks: int = ...,
        step_is_valid: bool = ...,
        step_is_accepted: bool = ...,
        cost: float = ...,
        cost_change: float = ...,
        gain_ratio: float = ...,
        gradient_max_norm: float = ...,
        step_norm: float = ...,
        lambda_: float = ...,
        linear_solver_time_s: float = ...,
        iteration_time_s: float = ...,
        cumulative_time_s: float = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        iteration: int = ...,
        linear_solver_iterations: int = ...,
        num_residual_blocks: int = ...,
        step_is_valid: bool = ...,
        step_is_accepted: bool = ...,
        cost: float = ...,
        cost_change: float = ...,
        gain_ratio: float = ...,
        gradient_max_norm: float = ...,
        step_norm: float = ...,
        lambda_: float = ...,
        linear_solver_time_s: float = ...,
        iteration_time_s: float = ...,
        cumulative_time_s: float = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class Summary:
    __fields__: ClassVar[tuple[str, ...]]
    termination: Termination
    message: str
    backend: str
    backend_reason: str
    initial_cost: float
    final_cost: float
    num_accepted: int
    num_rejected: int
    num_residuals: int
    num_effective_parameters: int
    linear_solver: LinearSolverType
    linear_solver_reason: str
    jacobian_storage: str
    num_threads: int
    deterministic: bool
    preprocessor_time_s: float
    residual_time_s: float
    jacobian_time_s: float
    linear_solver_time_s: float
    total_time_s: float
    iterations: NDArray[Any]
    def __init__(
        self,
        *,
        termination: Termination | str = ...,
        message: str = ...,
        backend: str = ...,
        backend_reason: str = ...,
        initial_cost: float = ...,
        final_cost: float = ...,
        num_accepted: int = ...,
        num_rejected: int = ...,
        num_residuals: int = ...,
        num_effective_parameters: int = ...,
        linear_solver: LinearSolverType | str = ...,
        linear_solver_reason: str = ...,
        jacobian_storage: str = ...,
        num_threads: int = ...,
        deterministic: bool = ...,
        preprocessor_time_s: float = ...,
        residual_time_s: float = ...,
        jacobian_time_s: float = ...,
        linear_solver_time_s: float = ...,
        total_time_s: float = ...,
        iterations: NDArray[Any] = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        termination: Termination | str = ...,
        message: str = ...,
        backend: str = ...,
        backend_reason: str = ...,
        initial_cost: float = ...,
        final_cost: float = ...,
        num_accepted: int = ...,
        num_rejected: int = ...,
        num_residuals: int = ...,
        num_effective_parameters: int = ...,
        linear_solver: LinearSolverType | str = ...,
        linear_solver_reason: str = ...,
        jacobian_storage: str = ...,
        num_threads: int = ...,
        deterministic: bool = ...,
        preprocessor_time_s: float = ...,
        residual_time_s: float = ...,
        jacobian_time_s: float = ...,
        linear_solver_time_s: float = ...,
        total_time_s: float = ...,
        iterations: NDArray[Any] = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def is_usable(self) -> bool: ...
    def brief_report(self) -> str: ...
    def full_report(self) -> str: ...

class CountSummary:
    __fields__: ClassVar[tuple[str, ...]]
    min: float
    median: float
    mean: float
    max: float
    def __init__(
        self, *, min: float = ..., median: float = ..., mean: float = ..., max: float = ...
    ) -> None: ...
    def replace(
        self, *, min: float = ..., median: float = ..., mean: float = ..., max: float = ...
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class ProblemStatistics:
    __fields__: ClassVar[tuple[str, ...]]
    num_cameras: int
    num_points: int
    num_observations: int
    observations_per_camera: CountSummary
    observations_per_point: CountSummary
    track_length_histogram: list[int]
    cost: float
    rmse: float
    median_error: float
    max_error: float
    num_behind_camera: int
    num_non_finite: int
    num_unobserved_cameras: int
    num_unobserved_points: int
    num_underconstrained_points: int
    num_underconstrained_cameras: int
    num_duplicate_observations: int
    num_non_positive_focal: int
    def __init__(
        self,
        *,
        num_cameras: int = ...,
        num_points: int = ...,
        num_observations: int = ...,
        observations_per_camera: CountSummary = ...,
        observations_per_point: CountSummary = ...,
        track_length_histogram: list[int] = ...,
        cost: float = ...,
        rmse: float = ...,
        median_error: float = ...,
        max_error: float = ...,
        num_behind_camera: int = ...,
        num_non_finite: int = ...,
        num_unobserved_cameras: int = ...,
        num_unobserved_points: int = ...,
        num_underconstrained_points: int = ...,
        num_underconstrained_cameras: int = ...,
        num_duplicate_observations: int = ...,
        num_non_positive_focal: int = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        num_cameras: int = ...,
        num_points: int = ...,
        num_observations: int = ...,
        observations_per_camera: CountSummary = ...,
        observations_per_point: CountSummary = ...,
        track_length_histogram: list[int] = ...,
        cost: float = ...,
        rmse: float = ...,
        median_error: float = ...,
        max_error: float = ...,
        num_behind_camera: int = ...,
        num_non_finite: int = ...,
        num_unobserved_cameras: int = ...,
        num_unobserved_points: int = ...,
        num_underconstrained_points: int = ...,
        num_underconstrained_cameras: int = ...,
        num_duplicate_observations: int = ...,
        num_non_positive_focal: int = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class BalProblem:
    @property
    def cameras(self) -> NDArray[np.float64]: ...
    @property
    def points(self) -> NDArray[np.float64]: ...
    @property
    def camera_index(self) -> NDArray[np.int32]: ...
    @property
    def point_index(self) -> NDArray[np.int32]: ...
    @property
    def observations(self) -> NDArray[np.float64]: ...
    @property
    def colors(self) -> NDArray[np.uint8]: ...
    @property
    def num_cameras(self) -> int: ...
    @property
    def num_points(self) -> int: ...
    @property
    def num_observations(self) -> int: ...
    def __init__(
        self,
        cameras: object,
        points: object,
        camera_index: object,
        point_index: object,
        observations: object,
        *,
        colors: object = None,
    ) -> None: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def copy(self) -> BalProblem: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def to_dict(self) -> dict[str, Any]: ...
    def replace(self, **changes: Any) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def validate(self) -> None: ...
    def __repr__(self) -> str: ...
    def residuals(self) -> NDArray[np.float64]: ...
    def cost(self) -> float: ...
    def depths(self) -> NDArray[np.float64]: ...
    def statistics(self) -> ProblemStatistics: ...
    def camera_centers(self) -> NDArray[np.float64]: ...
    def T_cw(self) -> NDArray[Any]: ...
    def normalized(self, *, extent: float = 100.0) -> tuple[BalProblem, NDArray[np.float64]]: ...
    def transformed(self, S_nw: ArrayLike) -> BalProblem: ...

class CameraModel(enum.Enum):
    BAL = 0
    PINHOLE = 1
    RADTAN = 2

def camera_param_names(camera_model: CameraModel) -> list[str]: ...

class BundleProblem:
    @property
    def camera_model(self) -> CameraModel: ...
    @property
    def T_cw(self) -> NDArray[np.float64]: ...
    @property
    def intrinsics(self) -> NDArray[np.float64]: ...
    @property
    def points(self) -> NDArray[np.float64]: ...
    @property
    def camera_index(self) -> NDArray[np.int32]: ...
    @property
    def point_index(self) -> NDArray[np.int32]: ...
    @property
    def observations(self) -> NDArray[np.float64]: ...
    @property
    def colors(self) -> NDArray[np.uint8]: ...
    @property
    def num_cameras(self) -> int: ...
    @property
    def num_points(self) -> int: ...
    @property
    def num_observations(self) -> int: ...
    def __init__(
        self,
        camera_model: CameraModel,
        T_cw: object,
        intrinsics: object,
        points: object,
        camera_index: object,
        point_index: object,
        observations: object,
        *,
        colors: object = None,
    ) -> None: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def copy(self) -> BundleProblem: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def to_dict(self) -> dict[str, Any]: ...
    def replace(self, **changes: Any) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...
    def validate(self) -> None: ...
    def residuals(self) -> NDArray[np.float64]: ...
    def cost(self) -> float: ...
    def depths(self) -> NDArray[np.float64]: ...
    def statistics(self) -> ProblemStatistics: ...
    def camera_centers(self) -> NDArray[np.float64]: ...
    def __repr__(self) -> str: ...
    @staticmethod
    def from_bal(problem: BalProblem, *, camera_model: CameraModel) -> BundleProblem: ...
    def to_bal(self) -> BalProblem: ...

def read_bal(path: str, *, duplicates: str) -> BalProblem: ...
def parse_bal(text: bytes, *, name: str, duplicates: str) -> BalProblem: ...
def write_bal(problem: BalProblem, path: str) -> None: ...
def format_bal(problem: BalProblem) -> bytes: ...
def write_ply(
    problem: BalProblem,
    path: str,
    *,
    cameras: bool,
    camera_scale: float,
    camera_color: Sequence[int],
    point_color: Sequence[int],
) -> tuple[Any, ...]: ...

class BalKind(enum.Enum):
    STREET = 0
    ORBIT = 1

class BalOptions:
    __fields__: ClassVar[tuple[str, ...]]
    kind: BalKind
    num_cameras: int
    num_points: int
    num_observations: int
    mean_track_length: float
    seed: int
    num_laps: int
    views_per_stop: int
    stop_spacing: float
    loop_closure_fraction: float
    max_distance: float
    image_width: int
    image_height: int
    focal: float
    focal_sigma: float
    k1: float
    k1_sigma: float
    k2: float
    k2_sigma: float
    far_fraction: float
    far_factor: float
    pixel_noise: float
    outlier_fraction: float
    rotation_noise_deg: float
    translation_noise: float
    point_noise: float
    focal_noise: float
    distortion_noise: float
    def __init__(
        self,
        *,
        kind: BalKind | str = ...,
        num_cameras: int = ...,
        num_points: int = ...,
        num_observations: int = ...,
        mean_track_length: float = ...,
        seed: int = ...,
        num_laps: int = ...,
        views_per_stop: int = ...,
        stop_spacing: float = ...,
        loop_closure_fraction: float = ...,
        max_distance: float = ...,
        image_width: int = ...,
        image_height: int = ...,
        focal: float = ...,
        focal_sigma: float = ...,
        k1: float = ...,
        k1_sigma: float = ...,
        k2: float = ...,
        k2_sigma: float = ...,
        far_fraction: float = ...,
        far_factor: float = ...,
        pixel_noise: float = ...,
        outlier_fraction: float = ...,
        rotation_noise_deg: float = ...,
        translation_noise: float = ...,
        point_noise: float = ...,
        focal_noise: float = ...,
        distortion_noise: float = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        kind: BalKind | str = ...,
        num_cameras: int = ...,
        num_points: int = ...,
        num_observations: int = ...,
        mean_track_length: float = ...,
        seed: int = ...,
        num_laps: int = ...,
        views_per_stop: int = ...,
        stop_spacing: float = ...,
        loop_closure_fraction: float = ...,
        max_distance: float = ...,
        image_width: int = ...,
        image_height: int = ...,
        focal: float = ...,
        focal_sigma: float = ...,
        k1: float = ...,
        k1_sigma: float = ...,
        k2: float = ...,
        k2_sigma: float = ...,
        far_fraction: float = ...,
        far_factor: float = ...,
        pixel_noise: float = ...,
        outlier_fraction: float = ...,
        rotation_noise_deg: float = ...,
        translation_noise: float = ...,
        point_noise: float = ...,
        focal_noise: float = ...,
        distortion_noise: float = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

def synthetic_bal(options: BalOptions) -> tuple[BalProblem, BalProblem, NDArray[np.bool]]: ...
def write_synthetic_bal(
    options: BalOptions, path: str, *, truth_path: str | None, progress: object
) -> tuple[Any, ...]: ...

class TextureKind(enum.Enum):
    BANDLIMITED = 0
    NOISE = 1
    CHECKER = 2
    UNIFORM = 3

class TextureOptions:
    __fields__: ClassVar[tuple[str, ...]]
    kind: TextureKind
    seed: int
    min_wavelength: float
    max_wavelength: float
    num_waves: int
    mean: float
    contrast: float
    def __init__(
        self,
        *,
        kind: TextureKind | str = ...,
        seed: int = ...,
        min_wavelength: float = ...,
        max_wavelength: float = ...,
        num_waves: int = ...,
        mean: float = ...,
        contrast: float = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        kind: TextureKind | str = ...,
        seed: int = ...,
        min_wavelength: float = ...,
        max_wavelength: float = ...,
        num_waves: int = ...,
        mean: float = ...,
        contrast: float = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class HeightFieldOptions:
    __fields__: ClassVar[tuple[str, ...]]
    width: float
    height: float
    amplitude: float
    min_wavelength: float
    max_wavelength: float
    num_waves: int
    seed: int
    def __init__(
        self,
        *,
        width: float = ...,
        height: float = ...,
        amplitude: float = ...,
        min_wavelength: float = ...,
        max_wavelength: float = ...,
        num_waves: int = ...,
        seed: int = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        width: float = ...,
        height: float = ...,
        amplitude: float = ...,
        min_wavelength: float = ...,
        max_wavelength: float = ...,
        num_waves: int = ...,
        seed: int = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class Antialiasing(enum.Enum):
    NONE = 0
    BANDLIMIT = 1
    SUPERSAMPLE = 2

class RenderOptions:
    __fields__: ClassVar[tuple[str, ...]]
    antialiasing: Antialiasing
    supersampling: int
    psf_sigma: float
    background: float
    exposure_time: float
    blur_samples: int
    readout_time: float
    num_threads: int
    def __init__(
        self,
        *,
        antialiasing: Antialiasing | str = ...,
        supersampling: int = ...,
        psf_sigma: float = ...,
        background: float = ...,
        exposure_time: float = ...,
        blur_samples: int = ...,
        readout_time: float = ...,
        num_threads: int = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        antialiasing: Antialiasing | str = ...,
        supersampling: int = ...,
        psf_sigma: float = ...,
        background: float = ...,
        exposure_time: float = ...,
        blur_samples: int = ...,
        readout_time: float = ...,
        num_threads: int = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class Scene:
    @property
    def num_faces(self) -> int: ...
    def __init__(self) -> None: ...
    def add_box(self, T_ws: object, *, size: object, texture: TextureOptions) -> None: ...
    def add_rectangle(
        self, T_ws: object, *, width: float, height: float, texture: TextureOptions
    ) -> None: ...
    def add_sphere(self, T_ws: object, *, radius: float, texture: TextureOptions) -> None: ...
    def add_height_field(
        self, T_ws: object, *, options: HeightFieldOptions, texture: TextureOptions
    ) -> None: ...
    def add(self, other: Scene) -> None: ...
    def __add__(self, other: Scene) -> Scene: ...
    def texture_at(self, face: int, p_w: object) -> tuple[Any, ...]: ...

class SensorResponse(enum.Enum):
    LINEAR = 0
    GAMMA = 1
    LUT = 2

class PixelType(enum.Enum):
    UINT8 = 0
    UINT16 = 1
    FLOAT32 = 2

class SensorOptions:
    __fields__: ClassVar[tuple[str, ...]]
    exposure: float
    gain: float
    bias: float
    vignette_r2: float
    vignette_r4: float
    vignette_r6: float
    response: SensorResponse
    gamma: float
    lut: list[float]
    read_noise: float
    shot_noise: float
    format: PixelType
    def __init__(
        self,
        *,
        exposure: float = ...,
        gain: float = ...,
        bias: float = ...,
        vignette_r2: float = ...,
        vignette_r4: float = ...,
        vignette_r6: float = ...,
        response: SensorResponse | str = ...,
        gamma: float = ...,
        lut: list[float] = ...,
        read_noise: float = ...,
        shot_noise: float = ...,
        format: PixelType | str = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        exposure: float = ...,
        gain: float = ...,
        bias: float = ...,
        vignette_r2: float = ...,
        vignette_r4: float = ...,
        vignette_r6: float = ...,
        response: SensorResponse | str = ...,
        gamma: float = ...,
        lut: list[float] = ...,
        read_noise: float = ...,
        shot_noise: float = ...,
        format: PixelType | str = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class DepthSensorOptions:
    __fields__: ClassVar[tuple[str, ...]]
    model: DepthModel
    noise: float
    correlation_length: float
    inverse_depth_step: float
    max_incidence_deg: float
    dropout: float
    def __init__(
        self,
        *,
        model: DepthModel = ...,
        noise: float = ...,
        correlation_length: float = ...,
        inverse_depth_step: float = ...,
        max_incidence_deg: float = ...,
        dropout: float = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        model: DepthModel = ...,
        noise: float = ...,
        correlation_length: float = ...,
        inverse_depth_step: float = ...,
        max_incidence_deg: float = ...,
        dropout: float = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

def expose(
    irradiance: object, *, options: SensorOptions, seed: int, index: int
) -> NDArray[Any]: ...
@overload
def render(
    scene: Scene,
    camera: PinholeCamera,
    T_cw: object,
    *,
    width: int,
    height: int,
    options: RenderOptions,
    motion: object,
) -> tuple[Any, ...]: ...
@overload
def render(
    scene: Scene,
    camera: RadtanCamera,
    T_cw: object,
    *,
    width: int,
    height: int,
    options: RenderOptions,
    motion: object,
) -> tuple[Any, ...]: ...
@overload
def sense_depth(
    depth: object,
    normal: object,
    camera: PinholeCamera,
    *,
    options: DepthSensorOptions,
    seed: int,
    index: int,
) -> NDArray[np.float32]: ...
@overload
def sense_depth(
    depth: object,
    normal: object,
    camera: RadtanCamera,
    *,
    options: DepthSensorOptions,
    seed: int,
    index: int,
) -> NDArray[np.float32]: ...
def noise_field(
    *, width: int, height: int, correlation_length: float, seed: int, index: int
) -> NDArray[np.float64]: ...

class NoiseModel(enum.Enum):
    CONSTANT = 0
    EXACT = 1

class SigmaMode(enum.Enum):
    REEVALUATE = 0
    FROZEN = 1

class GradientMode(enum.Enum):
    FORWARD = 0
    ESM = 1

class AffineMode(enum.Enum):
    NONE = 0
    CLOSED_FORM = 1
    JOINT = 2

class MotionGroup(enum.Enum):
    SE3 = 0
    SO3 = 1
    SIM3 = 2

class AlignmentStatus(enum.Enum):
    OK = 0
    LOST_OVERLAP = 1
    TOO_FEW_POINTS = 2
    DIVERGED = 3
    NOT_CONVERGED = 4
    DEGENERATE = 5
    LOW_TEXTURE = 6
    MOTION_BOUND = 7

class AffineOptions:
    __fields__: ClassVar[tuple[str, ...]]
    mode: AffineMode
    prior_sigma_a: float
    prior_sigma_b: float
    def __init__(
        self,
        *,
        mode: AffineMode | str = ...,
        prior_sigma_a: float = ...,
        prior_sigma_b: float = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        mode: AffineMode | str = ...,
        prior_sigma_a: float = ...,
        prior_sigma_b: float = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class DepthTermOptions:
    __fields__: ClassVar[tuple[str, ...]]
    enabled: bool
    estimate_weight: bool
    weight: float
    use_gradient: bool
    max_difference: float
    def __init__(
        self,
        *,
        enabled: bool = ...,
        estimate_weight: bool = ...,
        weight: float = ...,
        use_gradient: bool = ...,
        max_difference: float = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        enabled: bool = ...,
        estimate_weight: bool = ...,
        weight: float = ...,
        use_gradient: bool = ...,
        max_difference: float = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class AcceptanceOptions:
    __fields__: ClassVar[tuple[str, ...]]
    min_points: int
    min_overlap: float
    min_good_ratio: float
    min_agreement: float
    max_translation: float
    max_rotation: float
    max_sigma: float
    def __init__(
        self,
        *,
        min_points: int = ...,
        min_overlap: float = ...,
        min_good_ratio: float = ...,
        min_agreement: float = ...,
        max_translation: float = ...,
        max_rotation: float = ...,
        max_sigma: float = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        min_points: int = ...,
        min_overlap: float = ...,
        min_good_ratio: float = ...,
        min_agreement: float = ...,
        max_translation: float = ...,
        max_rotation: float = ...,
        max_sigma: float = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class TrackingOptions:
    __fields__: ClassVar[tuple[str, ...]]
    motion: MotionGroup
    noise_model: NoiseModel
    sigma_intensity: float
    adapt_sigma: bool
    min_sigma_intensity: float
    sigma_mode: SigmaMode
    loss: Loss
    gradient: GradientMode
    affine: AffineOptions
    depth: DepthTermOptions
    finest_level: int
    coarsest_level: int
    rotation_first: bool
    level_iterations: list[int]
    lm: LmOptions
    acceptance: AcceptanceOptions
    def __init__(
        self,
        *,
        motion: MotionGroup | str = ...,
        noise_model: NoiseModel | str = ...,
        sigma_intensity: float = ...,
        adapt_sigma: bool = ...,
        min_sigma_intensity: float = ...,
        sigma_mode: SigmaMode | str = ...,
        loss: Loss | str = ...,
        gradient: GradientMode | str = ...,
        affine: AffineOptions = ...,
        depth: DepthTermOptions = ...,
        finest_level: int = ...,
        coarsest_level: int = ...,
        rotation_first: bool = ...,
        level_iterations: list[int] = ...,
        lm: LmOptions = ...,
        acceptance: AcceptanceOptions = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        motion: MotionGroup | str = ...,
        noise_model: NoiseModel | str = ...,
        sigma_intensity: float = ...,
        adapt_sigma: bool = ...,
        min_sigma_intensity: float = ...,
        sigma_mode: SigmaMode | str = ...,
        loss: Loss | str = ...,
        gradient: GradientMode | str = ...,
        affine: AffineOptions = ...,
        depth: DepthTermOptions = ...,
        finest_level: int = ...,
        coarsest_level: int = ...,
        rotation_first: bool = ...,
        level_iterations: list[int] = ...,
        lm: LmOptions = ...,
        acceptance: AcceptanceOptions = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class KeyframeOptions:
    __fields__: ClassVar[tuple[str, ...]]
    min_gradient: float
    max_points: int
    spacing: int
    block_size: int
    def __init__(
        self,
        *,
        min_gradient: float = ...,
        max_points: int = ...,
        spacing: int = ...,
        block_size: int = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        min_gradient: float = ...,
        max_points: int = ...,
        spacing: int = ...,
        block_size: int = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class TrackingFrame:
    @property
    def num_levels(self) -> int: ...
    @property
    def has_depth(self) -> bool: ...
    def __init__(
        self,
        image: object,
        camera: PinholeCamera,
        *,
        inverse_depth: object,
        variance: object,
        max_levels: int,
    ) -> None: ...

class TrackingKeyframe:
    @property
    def num_levels(self) -> int: ...
    @property
    def options(self) -> KeyframeOptions: ...
    @property
    def camera(self) -> PinholeCamera: ...
    def __init__(self, frame: TrackingFrame, *, options: KeyframeOptions) -> None: ...
    def points(self, level: int) -> NDArray[np.float32]: ...

class LevelResult:
    @property
    def level(self) -> int: ...
    @property
    def num_points(self) -> int: ...
    @property
    def num_evaluations(self) -> int: ...
    @property
    def depth_weight(self) -> float: ...
    @property
    def summary(self) -> Summary: ...

class AlignmentMaps:
    @property
    def residual(self) -> NDArray[np.float32]: ...
    @property
    def sigma(self) -> NDArray[np.float32]: ...
    @property
    def normalised_residual(self) -> NDArray[np.float32]: ...
    @property
    def weight(self) -> NDArray[np.float32]: ...
    @property
    def warped(self) -> NDArray[np.float32]: ...
    @property
    def mask(self) -> NDArray[Any]: ...

class AlignmentResult:
    @property
    def T_th(self) -> NDArray[np.float64]: ...
    @property
    def status(self) -> AlignmentStatus: ...
    @property
    def reason(self) -> str: ...
    @property
    def ok(self) -> bool: ...
    @property
    def covariance(self) -> NDArray[np.float64]: ...
    @property
    def hessian_covariance(self) -> NDArray[np.float64]: ...
    @property
    def information(self) -> NDArray[np.float64]: ...
    @property
    def inflation(self) -> float: ...
    @property
    def information_eigenvalues(self) -> NDArray[np.float64]: ...
    @property
    def weakest_direction(self) -> NDArray[np.float64]: ...
    @property
    def sigma_scale(self) -> float: ...
    @property
    def residual_variance(self) -> float: ...
    @property
    def depth_residual_variance(self) -> float: ...
    @property
    def num_points(self) -> int: ...
    @property
    def overlap(self) -> float: ...
    @property
    def usage(self) -> float: ...
    @property
    def good_ratio(self) -> float: ...
    @property
    def agreement(self) -> float: ...
    @property
    def a(self) -> float: ...
    @property
    def b(self) -> float: ...
    @property
    def mean_inverse_depth(self) -> float: ...
    @property
    def levels(self) -> list[LevelResult]: ...
    @property
    def maps(self) -> object: ...
    def __repr__(self) -> str: ...

class Aligner:
    @property
    def options(self) -> TrackingOptions: ...
    def __init__(self, options: TrackingOptions) -> None: ...
    def align(
        self,
        keyframe: TrackingKeyframe,
        target: TrackingFrame,
        *,
        T_init: object,
        a: float,
        b: float,
        maps: bool,
    ) -> AlignmentResult: ...

class KeyframeRule:
    __fields__: ClassVar[tuple[str, ...]]
    distance_weight: float
    usage_weight: float
    min_good_ratio: float
    min_agreement: float
    def __init__(
        self,
        *,
        distance_weight: float = ...,
        usage_weight: float = ...,
        min_good_ratio: float = ...,
        min_agreement: float = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        distance_weight: float = ...,
        usage_weight: float = ...,
        min_good_ratio: float = ...,
        min_agreement: float = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class MotionModelOptions:
    __fields__: ClassVar[tuple[str, ...]]
    constant_velocity: bool
    search_rotation: float
    max_frame_translation: float
    max_frame_rotation: float
    def __init__(
        self,
        *,
        constant_velocity: bool = ...,
        search_rotation: float = ...,
        max_frame_translation: float = ...,
        max_frame_rotation: float = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        constant_velocity: bool = ...,
        search_rotation: float = ...,
        max_frame_translation: float = ...,
        max_frame_rotation: float = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class ShutterOptions:
    __fields__: ClassVar[tuple[str, ...]]
    estimate_readout: bool
    readout_s: float
    def __init__(self, *, estimate_readout: bool = ..., readout_s: float = ...) -> None: ...
    def replace(self, *, estimate_readout: bool = ..., readout_s: float = ...) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class OdometryOptions:
    __fields__: ClassVar[tuple[str, ...]]
    tracking: TrackingOptions
    keyframe: KeyframeOptions
    keyframe_rule: KeyframeRule
    motion: MotionModelOptions
    shutter: ShutterOptions
    depth_model: DepthModel
    depth_scale: float
    num_recovery_keyframes: int
    min_depth_agreement: float
    max_depth_step: float
    def __init__(
        self,
        *,
        tracking: TrackingOptions = ...,
        keyframe: KeyframeOptions = ...,
        keyframe_rule: KeyframeRule = ...,
        motion: MotionModelOptions = ...,
        shutter: ShutterOptions = ...,
        depth_model: DepthModel = ...,
        depth_scale: float = ...,
        num_recovery_keyframes: int = ...,
        min_depth_agreement: float = ...,
        max_depth_step: float = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        tracking: TrackingOptions = ...,
        keyframe: KeyframeOptions = ...,
        keyframe_rule: KeyframeRule = ...,
        motion: MotionModelOptions = ...,
        shutter: ShutterOptions = ...,
        depth_model: DepthModel = ...,
        depth_scale: float = ...,
        num_recovery_keyframes: int = ...,
        min_depth_agreement: float = ...,
        max_depth_step: float = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class OdometryStatus(enum.Enum):
    OK = 0
    RECOVERED = 1
    LOST = 2
    NO_DEPTH = 3

class OdometryResult:
    @property
    def frame(self) -> int: ...
    @property
    def timestamp(self) -> float: ...
    @property
    def status(self) -> OdometryStatus: ...
    @property
    def reason(self) -> str: ...
    @property
    def T_wc(self) -> NDArray[np.float64]: ...
    @property
    def keyframe(self) -> int: ...
    @property
    def is_keyframe(self) -> bool: ...
    @property
    def num_alignments(self) -> int: ...
    @property
    def readout_s(self) -> float: ...
    @property
    def alignment(self) -> AlignmentResult: ...

class RgbdOdometry:
    @property
    def options(self) -> OdometryOptions: ...
    def __init__(
        self, camera: PinholeCamera, *, options: OdometryOptions, T_wc: object
    ) -> None: ...
    def track(self, image: object, depth: object, *, timestamp: float) -> OdometryResult: ...

class Linearization:
    @property
    def cost(self) -> float: ...
    @property
    def residuals(self) -> NDArray[np.float64]: ...
    @property
    def gradient(self) -> NDArray[np.float64]: ...
    @property
    def num_columns(self) -> int: ...
    @property
    def row_starts(self) -> NDArray[np.int32]: ...
    @property
    def columns(self) -> NDArray[np.int32]: ...
    @property
    def values(self) -> NDArray[np.float64]: ...

@overload
def linearize(
    problem: BalProblem, *, config: BundleConfig, options: BundleOptions
) -> Linearization: ...
@overload
def linearize(
    problem: BundleProblem, *, config: BundleConfig, options: BundleOptions
) -> Linearization: ...
@overload
def adjust(
    problem: BalProblem,
    *,
    config: BundleConfig,
    options: BundleOptions,
    callback: Callable[[IterationSummary], bool | None] | None,
) -> Summary: ...
@overload
def adjust(
    problem: BundleProblem,
    *,
    config: BundleConfig,
    options: BundleOptions,
    callback: Callable[[IterationSummary], bool | None] | None,
) -> Summary: ...

class LossScope(enum.Enum):
    PIXEL = 0
    PATCH = 1

class LeavingRule(enum.Enum):
    KEEP_COST = 0
    ZERO = 1

class PatchBorder(enum.Enum):
    REPLICATE = 0
    WRAP = 1

class PatchWarp(enum.Enum):
    AUTO = 0
    NONE = 1
    DEPTH = 2
    NORMAL = 3

class BrightnessModel(enum.Enum):
    AFFINE = 0
    GAIN = 1
    NONE = 2

class VisibilityRule(enum.Enum):
    AUTO = 0
    TRACKS = 1
    ALL = 2

class CovarianceScope(enum.Enum):
    NONE = 0
    POSES = 1
    ALL = 2

class PatchPattern:
    @property
    def name(self) -> str: ...
    @property
    def offsets(self) -> NDArray[np.float64]: ...
    @property
    def size(self) -> int: ...
    def __init__(self, offsets: object) -> None: ...
    @staticmethod
    def parse(text: str) -> PatchPattern: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def to_dict(self) -> dict[str, Any]: ...
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class BrightnessOptions:
    __fields__: ClassVar[tuple[str, ...]]
    model: BrightnessModel
    prior_sigma_a: float
    prior_sigma_b: float
    balanced: bool
    def __init__(
        self,
        *,
        model: BrightnessModel | str = ...,
        prior_sigma_a: float = ...,
        prior_sigma_b: float = ...,
        balanced: bool = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        model: BrightnessModel | str = ...,
        prior_sigma_a: float = ...,
        prior_sigma_b: float = ...,
        balanced: bool = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class NoiseOptions:
    __fields__: ClassVar[tuple[str, ...]]
    loss: LossType
    scope: LossScope
    scale: float
    nu: float
    sensor_sigma: float
    def __init__(
        self,
        *,
        loss: LossType | str = ...,
        scope: LossScope | str = ...,
        scale: float = ...,
        nu: float = ...,
        sensor_sigma: float = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        loss: LossType | str = ...,
        scope: LossScope | str = ...,
        scale: float = ...,
        nu: float = ...,
        sensor_sigma: float = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class VisibilityOptions:
    __fields__: ClassVar[tuple[str, ...]]
    rule: VisibilityRule
    max_view_angle: float
    max_scale_change: float
    occlusion: float
    max_residual: float
    min_zncc: float
    min_grey: float
    max_grey: float
    min_texture: float
    min_views: int
    def __init__(
        self,
        *,
        rule: VisibilityRule | str = ...,
        max_view_angle: float = ...,
        max_scale_change: float = ...,
        occlusion: float = ...,
        max_residual: float = ...,
        min_zncc: float = ...,
        min_grey: float = ...,
        max_grey: float = ...,
        min_texture: float = ...,
        min_views: int = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        rule: VisibilityRule | str = ...,
        max_view_angle: float = ...,
        max_scale_change: float = ...,
        occlusion: float = ...,
        max_residual: float = ...,
        min_zncc: float = ...,
        min_grey: float = ...,
        max_grey: float = ...,
        min_texture: float = ...,
        min_views: int = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class PhotometricOptions:
    __fields__: ClassVar[tuple[str, ...]]
    backend: Backend
    point_parametrization: PointParametrization
    pattern: PatchPattern
    warp: PatchWarp
    interpolation: SampleInterpolation
    presmooth: float
    num_levels: int
    brightness: BrightnessOptions
    noise: NoiseOptions
    visibility: VisibilityOptions
    refine_poses: bool
    refine_points: bool
    refine_intrinsics: bool
    max_num_rounds: int
    hold_out: int
    force: bool
    covariance: CovarianceScope
    leaving: LeavingRule
    max_leaving_share: float
    border: PatchBorder
    min_depth: float
    lm: LmOptions
    additive_damping: bool
    def __init__(
        self,
        *,
        backend: Backend | str = ...,
        point_parametrization: PointParametrization | str = ...,
        pattern: PatchPattern | str = ...,
        warp: PatchWarp | str = ...,
        interpolation: SampleInterpolation | str = ...,
        presmooth: float = ...,
        num_levels: int = ...,
        brightness: BrightnessOptions = ...,
        noise: NoiseOptions = ...,
        visibility: VisibilityOptions = ...,
        refine_poses: bool = ...,
        refine_points: bool = ...,
        refine_intrinsics: bool = ...,
        max_num_rounds: int = ...,
        hold_out: int = ...,
        force: bool = ...,
        covariance: CovarianceScope | str = ...,
        leaving: LeavingRule | str = ...,
        max_leaving_share: float = ...,
        border: PatchBorder | str = ...,
        min_depth: float = ...,
        lm: LmOptions = ...,
        additive_damping: bool = ...,
    ) -> None: ...
    def replace(
        self,
        *,
        backend: Backend | str = ...,
        point_parametrization: PointParametrization | str = ...,
        pattern: PatchPattern | str = ...,
        warp: PatchWarp | str = ...,
        interpolation: SampleInterpolation | str = ...,
        presmooth: float = ...,
        num_levels: int = ...,
        brightness: BrightnessOptions = ...,
        noise: NoiseOptions = ...,
        visibility: VisibilityOptions = ...,
        refine_poses: bool = ...,
        refine_points: bool = ...,
        refine_intrinsics: bool = ...,
        max_num_rounds: int = ...,
        hold_out: int = ...,
        force: bool = ...,
        covariance: CovarianceScope | str = ...,
        leaving: LeavingRule | str = ...,
        max_leaving_share: float = ...,
        border: PatchBorder | str = ...,
        min_depth: float = ...,
        lm: LmOptions = ...,
        additive_damping: bool = ...,
    ) -> Self: ...
    def validate(self) -> None: ...
    def to_dict(self) -> dict[str, Any]: ...
    def __eq__(self, other: object, /) -> bool: ...
    __hash__: ClassVar[None]  # type: ignore[assignment]
    def __repr__(self) -> str: ...
    def __copy__(self) -> Self: ...
    def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...
    def __reduce__(self) -> tuple[Any, ...]: ...

class PointStatus(enum.Enum):
    OK = 0
    FEW_VIEWS = 1
    OUT_OF_VIEW = 2
    OCCLUDED = 3
    LOW_TEXTURE = 4
    SATURATED = 5
    DIVERGED = 6
    FIXED = 7

class EdgeStatus(enum.Enum):
    OK = 0
    BEHIND = 1
    OUT_OF_VIEW = 2
    OBLIQUE = 3
    SCALE_CHANGE = 4
    OCCLUDED = 5
    SATURATED = 6
    MISMATCH = 7
    NOT_USED = 8

class PhotometricProblem:
    def __init__(
        self, *, images: list[Any], masks: list[Any], max_levels: int, arrays: dict[str, Any]
    ) -> None: ...
    def validate(self, *, pattern_size: int) -> None: ...
    def default_gauge(self) -> Gauge: ...
    def image(self, index: int) -> NDArray[Any]: ...

class PhotometricResult:
    @property
    def T_cw(self) -> NDArray[np.float64]: ...
    @property
    def points(self) -> NDArray[np.float64]: ...
    @property
    def brightness(self) -> NDArray[np.float64]: ...
    @property
    def intrinsics(self) -> NDArray[np.float64]: ...
    @property
    def accepted(self) -> bool: ...
    @property
    def reason(self) -> str: ...
    @property
    def num_hold_out(self) -> int: ...
    @property
    def hold_out_cost_before(self) -> float: ...
    @property
    def hold_out_cost_after(self) -> float: ...
    @property
    def messages(self) -> list[str]: ...
    @property
    def point_status(self) -> NDArray[np.uint8]: ...
    @property
    def edge_status(self) -> NDArray[np.uint8]: ...
    @property
    def edge_image(self) -> NDArray[np.int32]: ...
    @property
    def edge_point(self) -> NDArray[np.int32]: ...
    @property
    def edge_rms_before(self) -> NDArray[np.float64]: ...
    @property
    def edge_rms_after(self) -> NDArray[np.float64]: ...
    @property
    def point_rms_before(self) -> NDArray[np.float64]: ...
    @property
    def point_rms_after(self) -> NDArray[np.float64]: ...
    @property
    def image_rms_before(self) -> NDArray[np.float64]: ...
    @property
    def image_rms_after(self) -> NDArray[np.float64]: ...
    @property
    def shift_px(self) -> NDArray[np.float64]: ...
    @property
    def hosts(self) -> NDArray[np.int32]: ...
    @property
    def host_uv(self) -> NDArray[np.float64]: ...
    @property
    def patches(self) -> NDArray[np.float32]: ...
    @property
    def normals(self) -> NDArray[np.float64]: ...
    @property
    def sigma(self) -> float: ...
    @property
    def nu(self) -> float: ...
    @property
    def threshold(self) -> float: ...
    @property
    def noise_ratio(self) -> float: ...
    @property
    def presmooth(self) -> float: ...
    @property
    def gauge(self) -> str: ...
    @property
    def summary(self) -> Summary: ...
    @property
    def rounds(self) -> NDArray[Any]: ...
    @property
    def pose_covariance(self) -> NDArray[np.float64]: ...
    @property
    def point_covariances(self) -> NDArray[np.float64]: ...
    @property
    def shared_noise(self) -> float: ...
    @property
    def covariance_overlap(self) -> float: ...
    @property
    def free_directions(self) -> int: ...

class CramerRaoBound:
    @property
    def pose_covariance(self) -> NDArray[np.float64]: ...
    @property
    def center_covariances(self) -> NDArray[np.float64]: ...
    @property
    def point_covariances(self) -> NDArray[np.float64]: ...
    @property
    def free_directions(self) -> int: ...

def photometric_cramer_rao(
    problem: PhotometricProblem,
    *,
    config: BundleConfig,
    options: PhotometricOptions,
    sigma: float,
    is_rounded: bool,
    has_noisy_patches: bool,
) -> CramerRaoBound: ...
def adjust_photometric(
    problem: PhotometricProblem,
    *,
    config: BundleConfig,
    options: PhotometricOptions,
    callback: Callable[[IterationSummary], bool | None] | None,
) -> PhotometricResult: ...
