"""The command line's enumerations: the library's enumerators in lower case (a test compares)."""

import enum
from typing import TypeVar

E = TypeVar("E", bound=enum.Enum)


class Backend(enum.StrEnum):
    """raylign.Backend."""

    AUTO = "auto"
    CERES = "ceres"
    NATIVE = "native"


class Pose(enum.StrEnum):
    """raylign.PoseParametrization."""

    SE3 = "se3"
    QUATERNION = "quaternion"
    ANGLE_AXIS = "angle_axis"


class Point(enum.StrEnum):
    """raylign.PointParametrization."""

    XYZ = "xyz"
    HOMOGENEOUS = "homogeneous"
    INVERSE_DEPTH = "inverse_depth"


class Storage(enum.StrEnum):
    """raylign.JacobianStorage."""

    AUTO = "auto"
    DOUBLE = "double"
    FLOAT = "float"


class LinearSolver(enum.StrEnum):
    """raylign.LinearSolverType."""

    AUTO = "auto"
    DENSE_NORMAL_CHOLESKY = "dense_normal_cholesky"
    DENSE_SCHUR = "dense_schur"
    SPARSE_SCHUR = "sparse_schur"
    ITERATIVE_SCHUR = "iterative_schur"


class Precondition(enum.StrEnum):
    """raylign.Preconditioner."""

    AUTO = "auto"
    IDENTITY = "identity"
    JACOBI = "jacobi"
    SCHUR_JACOBI = "schur_jacobi"
    CLUSTER_JACOBI = "cluster_jacobi"
    CLUSTER_TRIDIAGONAL = "cluster_tridiagonal"
    TWO_LEVEL = "two_level"
    STALE_FACTOR = "stale_factor"


class GaugeChoice(enum.StrEnum):
    """raylign.Gauge."""

    FREE = "free"
    FIRST_CAMERA = "first_camera"
    TWO_CAMERAS = "two_cameras"


class Duplicates(enum.StrEnum):
    """What a reader does with a second observation of the same point in the same camera."""

    ERROR = "error"
    FIRST = "first"
    MEAN = "mean"
    KEEP = "keep"


class LogStyle(enum.StrEnum):
    """How iterations are printed."""

    TABLE = "table"
    G2O = "g2o"


class AlignmentChoice(enum.StrEnum):
    """raylign.trajectory.Alignment."""

    NONE = "none"
    FIRST_POSE = "first_pose"
    SE3 = "se3"
    SIM3 = "sim3"


class TrajectoryFormat(enum.StrEnum):
    """How a trajectory file is written."""

    TUM = "tum"
    KITTI = "kitti"


def library_value(enum_type: type[E], choice: enum.StrEnum) -> E:
    """Return the library's enumerator of the same name."""
    return enum_type[choice.name]
