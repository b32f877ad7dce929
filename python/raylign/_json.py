"""Turn options, summaries and arrays into what JSON can hold."""

import enum
import math
from typing import Any

import numpy as np


def jsonable(value: Any) -> Any:
    """Return `value` as nested dicts, lists, strings and finite numbers.

    Enumerators become their lower-case names, structured arrays lists of rows, objects with
    `to_dict()` dicts, and numbers that JSON cannot hold (inf, nan) strings that `float()` reads.
    """
    if value is None or isinstance(value, (bool, str)):
        return value
    if isinstance(value, enum.Enum):
        return value.name.lower()
    if isinstance(value, np.ndarray):
        return _array(value)
    if isinstance(value, np.generic):
        return jsonable(value.item())
    if isinstance(value, int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, dict):
        return {str(key): jsonable(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [jsonable(item) for item in value]
    if hasattr(value, "to_dict"):
        return jsonable(value.to_dict())
    raise TypeError(f"no JSON form for {type(value).__name__}")


def _array(array: np.ndarray[Any, np.dtype[Any]]) -> Any:
    names = array.dtype.names
    if names is None:
        return jsonable(array.tolist())
    return [{name: jsonable(row[name]) for name in names} for row in array]
