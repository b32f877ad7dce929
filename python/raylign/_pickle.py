"""How the bound option and summary classes come out of a pickle."""

from typing import Any, TypeVar

T = TypeVar("T")


def rebuild(cls: type[T], fields: dict[str, Any]) -> T:
    """Call `cls` with its fields as keywords: the constructor validates them again."""
    return cls(**fields)
