"""Whether loops end where they began.

closed_check   loops that are open, and a drift that all of them share
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from cbpt.lab.characteristics.loops import Loop
from cbpt.lab.covariance.robust import typical_size
from cbpt.lab.covariance.within_run import display_step
from cbpt.lab.preflight.record import Check
from cbpt.lab.preflight.sizes import scatter_arcsec
from cbpt.lab.readings.readings import Readings
from cbpt.lab.wording.numbers import rounded
from cbpt.lab.wording.phrases import some, span


@dataclass(frozen=True)
class _Limits:
    """What is open."""

    clear: float = 5.0
    """Standard deviations of a gap, or of the mean of gaps: no noise leaves as much."""
    tell: int = 5
    """Gaps that tell how far they scatter, where readings do not."""
    share: int = 3
    """Gaps that tell what they have in common."""


_LIMITS = _Limits()


def closed_check(r: Readings, loops: Sequence[Loop]) -> Check:
    """Whole loops, those that do not close, and what they share."""
    whole = [loop for loop in loops if loop.whole]
    words = f"{len(whole)} whole, {len(loops) - len(whole)} half or one-way"
    if not whole:
        remedy = "Run one and a quarter cycles: 0, +T, -T, +T."
        return Check("loops", "lost", words, remedy)
    least = max(_LIMITS.clear * _gap_sd(r, whole), 1.001 * display_step(r.elastic_angle_arcsec))
    open_ = [loop for loop in whole if abs(loop.open_arcsec or 0.0) > least]
    fitted = "" if r.time_s is not None else ", and record time_s so that a drift can be fitted"
    if open_:
        remedy = (
            "A first loading or a drift leaves a loop open. Repeat the cycle until it closes; if "
            f"it never does, let the rig warm up{fitted}."
        )
        return Check("loops", "look", f"{words}; {_told(open_)}", remedy)
    if drift := _shared(r, whole):
        remedy = (
            "The scatter of the readings does not explain that: a drift, or a first loading in "
            f"each run. Let the rig warm up{fitted}, or begin each run with a cycle that does not "
            "count."
        )
        return Check("loops", "look", f"{words}; {drift}", remedy)
    composed = sum(loop.composed for loop in whole)
    if composed:
        words += f"; {composed} start and end at zero torque, and may hold a first loading"
        return Check("loops", "look", words, "Run a quarter cycle more, to the largest torque.")
    return Check("loops", "good", words)


def _told(loops: Sequence[Loop]) -> str:
    gaps = [abs(loop.open_arcsec or 0.0) for loop in loops]
    runs = some("run", list(dict.fromkeys(loop.run for loop in loops)))
    return (
        f"{len(loops)} {'does' if len(loops) == 1 else 'do'} not close, in {runs}, by "
        f"{span(min(gaps), max(gaps))} arcsec"
    )


def _gap_sd(r: Readings, whole: Sequence[Loop]) -> float:
    """Standard deviation of a gap, the difference of two readings."""
    scatter = scatter_arcsec(r, whole)
    if scatter:
        return float(np.sqrt(2) * scatter)
    gaps = _gaps(whole)
    return typical_size(gaps - np.median(gaps)) if len(gaps) >= _LIMITS.tell else 0.0


def _gaps(loops: Sequence[Loop]) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    return np.array([loop.gap_arcsec for loop in loops if loop.gap_arcsec is not None])


def _shared(r: Readings, whole: Sequence[Loop]) -> str:
    """What is said where the gaps of all loops have a mean that no noise has; else empty."""
    known = [loop for loop in whole if loop.gap_arcsec is not None and not loop.composed]
    gaps, scatter = _gaps(known), scatter_arcsec(r, whole)
    if len(gaps) < _LIMITS.share or not scatter:
        return ""
    sd = max(np.sqrt(2) * scatter, float(np.std(gaps, ddof=1)))
    mean = float(np.mean(gaps))
    least = max(_LIMITS.clear * sd / np.sqrt(len(gaps)), display_step(r.elastic_angle_arcsec))
    if abs(mean) <= least:
        return ""
    words = (
        f"the angle ends {rounded(abs(mean))} arcsec {'above' if mean > 0 else 'below'} where a "
        "loop began, on average"
    )
    if r.time_s is not None:
        rows = [np.concatenate([b.row for b in loop.branches]) for loop in known]
        took = [np.ptp(np.interp([x.min(), x.max()], np.arange(len(r)), r.time_s)) for x in rows]
        words += f"; one loop takes {rounded(float(np.median(took)))} s"
    return words
