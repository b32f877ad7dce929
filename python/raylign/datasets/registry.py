"""The registry of public data sets, read from `data/registry.toml`."""

import functools
import tomllib
from dataclasses import dataclass

from raylign._resources import data_file
from raylign.errors import OptionsError


@dataclass(frozen=True)
class BalEntry:
    """One problem of Bundle Adjustment in the Large (Agarwal et al., ECCV 2010).

    Attributes:
        scene: `ladybug`, `trafalgar`, `dubrovnik`, `venice` or `final`.
        name: published file name without suffixes, e.g. `problem-49-7776-pre`.
        url: where the bzip2 file is published.
        cameras: number of cameras in the header.
        points: number of points in the header.
        observations: number of observations in the header, None where not known for certain.
        sha256: of the decompressed text, None where the file has not been held.
    """

    scene: str
    name: str
    url: str
    cameras: int
    points: int
    observations: int | None = None
    sha256: str | None = None

    @property
    def alias(self) -> str:
        """Short name, e.g. `ladybug-49`."""
        return f"{self.scene}-{self.cameras}"


@functools.cache
def bal_entries() -> tuple[BalEntry, ...]:
    """Return every known BAL problem, scene by scene, smallest first."""
    with data_file("registry.toml").open("rb") as stream:
        table = tomllib.load(stream)["bal"]
    return tuple(
        BalEntry(url=table["url"].format(scene=row["scene"], name=row["name"]), **row)
        for row in table["problems"]
    )


def find_bal(name: str) -> BalEntry:
    """Look a problem up by `problem-49-7776-pre` or `ladybug-49`, with or without `bal/` before it.

    Raises:
        OptionsError: no such problem; the message names the nearest ones.
    """
    wanted = name.removeprefix("bal/").removesuffix(".bz2").removesuffix(".txt")
    for entry in bal_entries():
        if wanted in (entry.name, entry.alias):
            return entry
    raise OptionsError(f"no data set '{name}'{_suggestion(wanted)}")


def _suggestion(wanted: str) -> str:
    import difflib

    names = [key for entry in bal_entries() for key in (entry.alias, entry.name)]
    near = difflib.get_close_matches(wanted, names, n=3)
    return f"; did you mean {', '.join('bal/' + key for key in near)}?" if near else ""
