"""Likely slips: a misfit that a wrong unit or a wrong sign explains, said in words.

slips   what the readings look like, where one factor on the angle takes most of the misfit away
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Limits:
    """When a factor is taken for a wrong unit."""

    left: float = 0.1
    """Of the sum of squared residuals at most this part may be left once the factor is on."""
    near: float = 0.4
    """The logarithm of the factor may be this far from the slip's, as the drive may be off as
    well.
    """


_LIMITS = _Limits()

_ARCMIN, _MRAD, _URAD, _RAD = 1 / 60, np.pi / 648, np.pi / 0.648, np.pi / 648000

# Readings divided by model, and what that is a sign of. 57.3, the degrees of a radian, is too
# near to 60 to be distinguished from it.
_FACTORS = (
    (_ARCMIN, "are probably in arcmin, not in arcsec as stated (or in rad, not in deg)"),
    (1 / 3600, "are probably in deg, not in arcsec as stated"),
    (_MRAD, "are probably in mrad, not in arcsec as stated"),
    (_URAD, "are probably in urad, not in arcsec as stated"),
    (_RAD, "are probably in rad, not in arcsec as stated"),
    (1 / _ARCMIN, "are probably in arcsec, not in arcmin as stated (or in deg, not in rad)"),
    (3600.0, "are probably in arcsec, not in deg as stated"),
    (1 / _MRAD, "are probably in arcsec, not in mrad as stated"),
    (1 / _URAD, "are probably in arcsec, not in urad as stated"),
    (1000.0, "are about 1000 times too large: check the units for milli, micro or kilo"),
    (0.001, "are about 1000 times too small: check the units for milli, micro or kilo"),
    (1.0, ""),
)


def slips(
    reading_arcsec: Floats, model_arcsec: Floats, stiffness_rel: float = 0.0
) -> tuple[str, ...]:
    """Both finite, shape (n,), with the offset taken off; empty where nothing looks like a slip.
    stiffness_rel: stated standard uncertainty of the model's stiffness; within three of it a factor
    is the drive's own."""
    size = float(model_arcsec @ model_arcsec)
    misfit = float(np.sum((reading_arcsec - model_arcsec) ** 2))
    if len(reading_arcsec) < 3 or not size or not misfit:
        return ()
    factor = float(reading_arcsec @ model_arcsec) / size
    left = float(np.sum((reading_arcsec - factor * model_arcsec) ** 2))
    # A factor that is tiny leaves what the readings hold, not what the model does.
    held = float(reading_arcsec @ reading_arcsec)
    if not factor or left > _LIMITS.left * misfit or left > _LIMITS.left * held:
        return ()
    if abs(np.log(factor if factor > 0 else np.inf)) < 3 * stiffness_rel:
        return ()
    distance, words = min(
        (abs(float(np.log(abs(factor) / known))), words) for known, words in _FACTORS
    )
    if distance > _LIMITS.near:
        return ()
    told = [words] if words else []
    if factor < 0:
        told.append("have the opposite sign of the model: check the signs of torque and angle")
    return tuple(f"the readings {text} (they are {factor:.4g} times the model)" for text in told)
