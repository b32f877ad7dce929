"""Files in and out: BAL text, PLY, NPZ. Every malformed input is one `raylign.FormatError`."""

from raylign.io.bal import read_bal, write_bal
from raylign.io.duplicates import resolve_duplicates
from raylign.io.npz import read_npz, write_npz
from raylign.io.ply import PlySummary, write_ply

__all__ = [
    "PlySummary",
    "read_bal",
    "read_npz",
    "resolve_duplicates",
    "write_bal",
    "write_npz",
    "write_ply",
]
