"""Where the data files that travel with the package are."""

from pathlib import Path

_PACKAGE = Path(__file__).parent


def data_file(name: str) -> Path:
    """Return the path of a shipped data file, e.g. `"registry.toml"` or `"bal/street.txt.gz"`.

    An installed package holds them in `raylign/_data`; a source tree in `data/` at its root.

    Raises:
        FileNotFoundError: neither place has it.
    """
    installed = _PACKAGE / "_data" / name
    if installed.exists():
        return installed
    # The build tree links the .py files into place, so resolve first.
    source = Path(__file__).resolve().parents[2] / "data" / name
    if source.exists():
        return source
    raise FileNotFoundError(f"raylign's data file '{name}' is missing from the installation")
