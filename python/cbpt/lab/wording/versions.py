"""What made a document: versions, as every JSON document of the lab states them."""

from __future__ import annotations

import platform

import numpy as np


def versions() -> dict[str, str]:
    """Of the package, of the libraries that its numbers come from, and of Python."""
    import scipy

    from cbpt import __version__

    return {
        "cbpt": __version__,
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "python": platform.python_version(),
    }
