"""What made a document: versions, as every JSON document of the lab states them."""

from __future__ import annotations

import platform
from importlib.metadata import version

import numpy as np


def product_version() -> str:
    """Of this package, as it is installed."""
    return version("cbpt")


def versions() -> dict[str, str]:
    """Of the package, of the libraries that its numbers come from, and of Python."""
    import scipy

    return {
        "cbpt": product_version(),
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "python": platform.python_version(),
    }
