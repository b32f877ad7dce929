"""Public data sets: what exists, and a download that is refused unless it is what it should be."""

from raylign.datasets.download import DownloadError, fetch
from raylign.datasets.registry import BalEntry, bal_entries, find_bal

__all__ = ["BalEntry", "DownloadError", "bal_entries", "fetch", "find_bal"]
