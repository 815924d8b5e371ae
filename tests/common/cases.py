"""Cases that were written and read."""

from __future__ import annotations

import tomllib

import numpy as np

from cbpt import Case


def check_same(read: Case, made: Case) -> None:
    """The same keys and texts, and numbers to one unit in the last place: not every number of SI
    has one in the unit of a file."""
    compare(tomllib.loads(read.to_toml()), tomllib.loads(made.to_toml()))


def compare(read: object, made: object) -> None:
    """One value of a case, whatever it holds."""
    if isinstance(made, dict):
        assert isinstance(read, dict) and list(read) == list(made)
        compare(list(read.values()), list(made.values()))
    elif isinstance(made, list):
        assert isinstance(read, list)
        for one, other in zip(read, made, strict=True):
            compare(one, other)
    elif isinstance(made, float):
        assert isinstance(read, float)
        np.testing.assert_array_max_ulp(np.float64(read), np.float64(made), maxulp=1)
    else:
        assert read == made
