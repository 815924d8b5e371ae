"""What the answer says of the uncertainty of a reading, and what that rests on.

noise_of    the part `noise` of the document
estimated   standard uncertainty of a reading, as the answer has it
noise_floor the scatter about the answer, where it holds all that is at work, else why there is none
floor_of    the same, else the error that noise alone leaves by what is stated or repeats tell
statement   one sentence: stated, from repeats, or from the scatter about the answer
"""

from __future__ import annotations

from dataclasses import asdict
from typing import Any

import numpy as np

from cbpt.lab.covariance.repeatability import no_uncertainty_of
from cbpt.lab.diagnosis.diagnosis_data import DiagnosisData
from cbpt.lab.inference.residuals import scatter_of
from cbpt.lab.wording.names import columns_in_words
from cbpt.lab.wording.numbers import ARCSEC, AngleUnit


def noise_of(d: DiagnosisData) -> dict[str, Any]:
    """Stated and estimated uncertainty (root mean square over the readings), and its structure."""
    c = d.competition.campaign
    noise = d.noise
    return {
        "u_stated_arcsec": _stated(d),
        "u_estimated_arcsec": estimated(d),
        "u_from": u_from(d),
        "u_dof": scatter_of(d.competition.fitter, d.after)[1],
        "u_says": statement(d),
        "repeats": asdict(c.repeats) if c.repeats else None,
        "model": list(d.verdict.noise),
        "run_offset_arcsec": noise.offset_arcsec,
        "correlation": noise.correlation,
    }


def u_from(d: DiagnosisData) -> str:
    """`stated`, `repeats`, or `scatter`: about the answer, or, where what is stated cannot be
    meant, inside the runs."""
    c = d.competition.campaign
    if c.u_stated:
        return "stated" if c.u_believed == 1 else "scatter"
    return "repeats" if c.u_repeated else "scatter"


def _stated(d: DiagnosisData) -> float | None:
    """Root mean square over the readings of what the table states, arcsec."""
    u = d.readings.u_elastic_angle_arcsec
    return None if u is None else float(np.sqrt(np.mean(u**2)))


def estimated(d: DiagnosisData) -> float:
    """What a reading is known to under the noise of the answer, arcsec, what the torque scatters by
    included; what is stated counts as some degrees of freedom beside those of the scatter."""
    c = d.competition.campaign
    if c.step_arcsec and d.verdict.lack_of_fit is None:
        # A coarse display has the noise that it has; what is judged by is more.
        return scatter_of(d.competition.fitter, d.after)[0]
    torque = d.noise.torque_arcsec
    variance = (d.noise.scale * c.u_reading_arcsec) ** 2 + (0.0 if torque is None else torque**2)
    return float(np.sqrt(np.mean(variance)))


def noise_floor(d: DiagnosisData) -> tuple[float | None, str]:
    """The error that noise alone leaves, by the scatter about the answer, and what that is; None
    with the reason where something is at work that the answer does not hold.

    Offsets of runs are no part of it, as they are none of the errors that are held against it.
    """
    from cbpt.lab.selection.posterior import UNKNOWN

    if d.verdict.undecided:
        return None, "is unknown: the readings do not decide"
    if d.verdict.lack_of_fit is None and not any(UNKNOWN in group for group in d.verdict.rivals):
        return estimated(d), "scatter about the answer"
    return None, "is unknown: no model explains all of the misfit"


def floor_of(d: DiagnosisData) -> tuple[float | None, str]:
    """The error that noise alone leaves, and what it was taken from; None where nothing tells it.

    Without a noise floor of the answer, what is stated or what repeats tell.
    """
    floor, of = noise_floor(d)
    if floor is not None:
        return floor, of
    c = d.competition.campaign
    u = float(np.sqrt(np.mean(c.u_reading_arcsec**2)))
    if c.u_stated:
        return u, "stated uncertainty" if c.u_believed == 1 else "scatter within runs"
    if c.u_repeated:
        return u, "repeats"
    return None, f"{of}, no uncertainty is stated and {no_uncertainty_of(c.repeats)}"


def statement(d: DiagnosisData, angle: AngleUnit = ARCSEC) -> str:
    """What the uncertainty of a reading is and what it rests on."""
    c, stated = d.competition.campaign, _stated(d)
    about, used = _about(d, angle), estimated(d)
    if stated is not None and c.u_believed != 1:
        text = (
            f"The table states an uncertainty of {angle.text(stated)}, but within runs the "
            f"readings scatter by {angle.text(stated * c.u_believed)}, which was used instead; "
            f"{about}"
        )
    elif stated is not None:
        text = f"The stated uncertainty of a reading is {angle.text(stated)}; {about}"
    elif c.u_repeated:
        assert c.repeats is not None
        text = (
            f"The uncertainty of a reading was estimated from repeated readings, "
            f"{angle.text(c.repeats.u_arcsec)} ({c.repeats}); {about}"
        )
    else:
        text = f"No uncertainty is stated, so that of a reading was estimated: {about}"
    if c.repeats and c.u_stated and c.repeats.steady:
        text += f", repeated readings give {angle.text(c.repeats.u_arcsec)} ({c.repeats})"
    scatter = scatter_of(d.competition.fitter, d.after)[0]
    if d.verdict.lack_of_fit is None and abs(used / max(scatter, 1e-300) - 1) > 0.02:
        between = stated is not None and min(stated, scatter) < used < max(stated, scatter)
        text += (
            f". Combined, the two give {angle.text(used)}"
            if between
            else f". Without outliers and model discrepancy it is {angle.text(used)}"
            if used < scatter
            else f". The noise of the answer is {angle.text(used)}"
        )
    if c.repeats and not c.repeats.steady:
        text += (
            f". Repeated readings differ by {angle.text(c.repeats.u_arcsec)} ({c.repeats}), far "
            "more than the readings scatter within runs: something changes between the repeats"
        )
    return f"{text}."


def _about(d: DiagnosisData, angle: AngleUnit) -> str:
    """The scatter about the answer, with its own degrees of freedom."""
    scatter, dof = scatter_of(d.competition.fitter, d.after)
    if d.verdict.lack_of_fit is not None:
        columns = columns_in_words(d.verdict.lack_of_fit.columns)
        return (
            f"beside a smooth function of {columns}, which stands for the misfit without a name, "
            f"the readings scatter by {angle.text(estimated(d))}; a part of that can be misfit"
        )
    offsets = ", with an offset for each run" if d.noise.offset_arcsec else ""
    of = "the drive as stated" if d.verdict.undecided else "the answer"
    adequacy, stated = d.verdict.adequacy, d.competition.campaign.u_stated
    untested = ""
    if adequacy is not None and adequacy.source == "nothing" and not stated:
        untested = (
            ", and nothing else tells what they scatter by: a part of that can be misfit, so no "
            "cause is certain; state u_elastic_angle, or repeat a run"
        )
    return (
        f"the residuals of {of} give {angle.text(scatter)} ({dof:.0f} degrees of freedom{offsets})"
        f"{untested}"
    )
