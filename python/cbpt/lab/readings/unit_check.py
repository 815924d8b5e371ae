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
    no_drive: float = 25.0
    """No drive is further from its design, whatever slip made it: five times as far as contacts are
    likely to be too soft or too stiff."""
    near: float = 0.4
    """The logarithm of the factor may be this far from the slip's, as the drive may be off as
    well.
    """


_LIMITS = _Limits()

_ARCMIN, _MRAD, _URAD, _RAD = 1 / 60, np.pi / 648, np.pi / 0.648, np.pi / 648000

# Readings divided by model, and what that is a sign of. 57.3, the degrees of a radian, is too
# near to 60 to be distinguished from it. The unit that the header states is not known here.
_FACTORS = (
    (_ARCMIN, "numbers in arcmin with arcsec stated, in deg with arcmin, or in rad with deg"),
    (1 / 3600, "numbers in deg with arcsec stated, or in rad with arcmin"),
    (_MRAD, "numbers in mrad with arcsec stated"),
    (_URAD, "numbers in urad with arcsec stated"),
    (_RAD, "numbers in rad with arcsec stated"),
    (1 / _ARCMIN, "numbers in arcsec with arcmin stated, in arcmin with deg, or in deg with rad"),
    (3600.0, "numbers in arcsec with deg stated, or in arcmin with rad"),
    (1 / _MRAD, "numbers in arcsec with mrad stated"),
    (1 / _URAD, "numbers in arcsec with urad stated"),
    (1000.0, "milli, micro or kilo in a unit"),
    (0.001, "milli, micro or kilo in a unit"),
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
    far = abs(float(np.log(abs(factor)))) > np.log(_LIMITS.no_drive)
    if distance > _LIMITS.near and not far:
        return ()
    told = []
    if words or far:
        causes = "; or ".join(_causes(factor, distance, words))
        told.append(f"readings that are {abs(factor):.4g} times the model, as by {causes}")
    if factor < 0:
        told.append("readings of the opposite sign: reverse the sign of torque or angle")
    return tuple(told)


def _causes(factor: float, distance: float, words: str) -> list[str]:
    """What makes readings so many times the model."""
    causes = [words] if distance <= _LIMITS.near and words else []
    causes.append("swapped columns of torque and angle")
    if abs(factor) > 1:
        causes.append("torques of the input side (multiply them by the transmission ratio)")
    return [*causes, "a stiffness in the case that is as much too large or too small"]
