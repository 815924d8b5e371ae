"""What the answer says of the uncertainty of a reading, and what that rests on.

noise_of    the part `noise` of the document
floor_of    the error that noise alone leaves, as far as it is known, and from what
statement   one sentence: stated, from repeats, or from the scatter about the answer
"""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import numpy as np

from cbpt.lab.budget import dof_of

if TYPE_CHECKING:
    from cbpt.lab.answer import Diagnosis


def noise_of(d: Diagnosis) -> dict[str, Any]:
    """Stated and estimated uncertainty (root mean square over the readings), and its structure."""
    c = d.competition.campaign
    noise = d.noise
    u = float(np.sqrt(np.mean(c.u_arcsec**2)))
    return {
        "u_stated_arcsec": u / c.u_believed if c.u_stated else None,
        "u_estimated_arcsec": noise.scale * u,
        "u_from": u_from(d),
        "u_dof": dof_of(d.competition.fitter, d.after),
        "u_says": statement(d),
        "repeats": asdict(c.repeats) if c.repeats else None,
        "model": list(d.verdict.noise),
        "run_offset_arcsec": noise.offset_arcsec,
        "correlation": noise.correlation,
    }


def u_from(d: Diagnosis) -> str:
    """`stated`, `repeats`, or `scatter` about the answer."""
    c = d.competition.campaign
    return "stated" if c.u_stated else "repeats" if c.u_repeated else "scatter"


def floor_of(d: Diagnosis) -> tuple[float | None, str]:
    """The error that noise alone leaves, and what it was taken from; None where nothing tells it.

    The scatter about an answer is noise only where the answer holds all that is at work.
    """
    from cbpt.lab.verdict import UNKNOWN

    c, v = d.competition.campaign, d.verdict
    if v.pattern is None and not any(UNKNOWN in group for group in v.rivals):
        return d.noise_floor_arcsec, "scatter about the answer"
    u = float(np.sqrt(np.mean(c.u_arcsec**2)))
    if c.u_stated:
        return u, "stated uncertainty" if c.u_believed == 1 else "scatter inside runs"
    if c.u_repeated:
        return u, "repeats"
    return None, "cannot be told: no model holds all, no uncertainty is stated, no repeats tell it"


def statement(d: Diagnosis) -> str:
    """What the uncertainty of a reading is and what it rests on."""
    c = d.competition.campaign
    found = d.noise.scale * float(np.sqrt(np.mean(c.u_arcsec**2)))
    about = f"the scatter about the answer gives {found:.3g} arcsec"
    about += f" ({dof_of(d.competition.fitter, d.after):.0f} degrees of freedom)"
    if c.u_stated:
        text = f"The uncertainty of a reading is stated; {about}"
    elif c.u_repeated:
        assert c.repeats is not None
        text = (
            f"The uncertainty of a reading was estimated from repeats, {c.repeats.u_arcsec:.3g} "
            f"arcsec ({c.repeats}); {about}"
        )
    else:
        text = f"The uncertainty of a reading was estimated: {about}"
    if c.repeats and c.u_stated and c.repeats.steady:
        text += f", repeats {c.repeats.u_arcsec:.3g} arcsec ({c.repeats})"
    if c.repeats and not c.repeats.steady:
        text += (
            f". Repeats differ by {c.repeats.u_arcsec:.3g} arcsec ({c.repeats}), far more than "
            "readings scatter inside their runs: something changes between them"
        )
    return f"{text}."
