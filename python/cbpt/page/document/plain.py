"""Numbers as a JSON document has them: lists, without NaN, with as many digits as can be seen."""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import Any, overload

import numpy as np
from numpy.typing import NDArray

from cbpt.page.document.types import Column

Floats = NDArray[np.float64]

# An instrument shows no more, and a page of twenty thousand readings stays small.
_DECIMALS = 6


@overload
def numbers(values: Floats, decimals: int = _DECIMALS) -> Column: ...
@overload
def numbers(values: None, decimals: int = _DECIMALS) -> None: ...
@overload
def numbers(values: Floats | None, decimals: int = _DECIMALS) -> Column | None: ...
def numbers(values: Floats | None, decimals: int = _DECIMALS) -> Column | None:
    """An array as a list; what is no number is None."""
    if values is None:
        return None
    rounded = np.round(np.asarray(values, dtype=np.float64), decimals)
    if np.isfinite(rounded).all():
        return list(rounded.tolist())
    return [v if math.isfinite(v) else None for v in rounded.tolist()]


def finite_numbers(values: Floats, decimals: int = _DECIMALS) -> list[float]:
    """An array without gaps as a list."""
    return [float(v) for v in np.round(values, decimals)]


def array(values: Sequence[float | None]) -> Floats:
    """Such a list as an array again."""
    return np.array([np.nan if v is None else v for v in values], dtype=np.float64)


def finite(value: float | None) -> float | None:
    """A number, or None where it is none."""
    return None if value is None or not math.isfinite(value) else float(value)


def to_json(document: Any) -> str:
    """One line of JSON."""
    return json.dumps(document, allow_nan=False, default=float, separators=(",", ":"))
