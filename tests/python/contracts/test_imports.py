"""What `import raylign` loads and links."""

import re
import subprocess
import sys

from raylign import _core

HEAVY_PACKAGES = ["cv2", "matplotlib", "scipy", "typer", "rich", "pooch", "PIL", "requests"]
HEAVY_LIBRARIES = re.compile(
    r"lib(gdal|gtk|gdk|Qt\d|opencv_(highgui|imgcodecs|videoio))", re.IGNORECASE
)


def run(code: str) -> str:
    """Run `code` in a fresh interpreter and return what it prints."""
    result = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


def test_import_is_light():
    """The figure (median of warm starts) is measured by benchmarks/import_time.py."""
    loaded = set(run("import sys, raylign; print(*sys.modules)").split())
    assert {"raylign._core", "numpy"} <= loaded
    assert loaded.isdisjoint(HEAVY_PACKAGES)


def test_core_links_no_heavy_library():
    """Ldd resolves the whole tree of shared libraries, not only the direct ones."""
    listing = subprocess.run(
        ["ldd", _core.__file__], capture_output=True, text=True, check=True
    ).stdout
    names = [line.split()[0] for line in listing.splitlines()]
    assert any(name.startswith("libglog") for name in names)
    assert any(name.startswith("libopencv_core") for name in names)
    assert not [name for name in names if HEAVY_LIBRARIES.search(name)]
    assert "not found" not in listing
