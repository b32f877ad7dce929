"""The exception tree: `raylign.Error` catches all; the specific ones are `ValueError`s too."""

from raylign._core import Error, FormatError, OptionsError, ShapeError

__all__ = ["Error", "FormatError", "OptionsError", "ShapeError"]
