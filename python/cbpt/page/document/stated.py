"""The model as stated, and what every model of a table has: all that the page needs to begin.

stated         the case as it is, but for the best zero: its entry of the document
rows_of        what every entry has: the model and the residual row by row, and the error
with_zeros     a model with the zeros that fit best
best_zeros     these zeros
key_of         the key of the model with some effects
free_function  what the model of a lack of fit is called
stop_if_taken  refuses an own effect that is called as a model is
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive
from cbpt.errors import InvalidInputError
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.readings.reader import Readings
from cbpt.lab.wording.names import columns_in_words
from cbpt.page.document.plain import finite, numbers
from cbpt.page.document.types import Model, Role

Floats = NDArray[np.float64]

STATED, REFITTED, UNKNOWN = "stated", "refitted", "unknown"
"""Keys of the models that have no effect of their own."""


def key_of(effects: Sequence[str]) -> str:
    """The key of the model with some effects."""
    return "+".join(sorted(effects)) or REFITTED


def free_function(columns: Sequence[str]) -> str:
    """The label of a lack of fit: a free-form function of the torque and the cycle."""
    return f"a free-form function of {columns_in_words(columns)}"


def stop_if_taken(id: str) -> None:
    """Raises `InvalidInputError` for the id of an own effect that is the key of a model."""
    if id in (STATED, REFITTED, UNKNOWN):
        required = "this id is reserved by the page; choose another"
        raise InvalidInputError(f'id = "{id}": {required}', "id", id, required)


def rows_of(
    key: str, role: Role, label: str, effects: Sequence[str], y: Floats, model: Floats
) -> Model:
    """What every entry has: the model and the residual row by row, and the error."""
    residual = y - model
    solved = np.isfinite(residual)
    return {
        "key": key,
        "role": role,
        "label": label,
        "effects": list(effects),
        "model_arcsec": numbers(model),
        "residual_arcsec": numbers(residual),
        "rmse_arcsec": float(np.sqrt(np.mean(residual[solved] ** 2))) if solved.any() else None,
        "held_out_rmse_arcsec": None,
        "chi2_per_dof": None,
        "zero_arcsec": None,
        "parameters": [],
        "numbers": [],
        "probability": None,
        "tell_tale": "",
        "signature_arcsec": None,
        "converged": True,
        "case_text": None,
        "why_no_case": None,
        "loop": None,
    }


def stated(case: Case | Drive, readings: Readings) -> tuple[Model, Floats, list[str]]:
    """The case as it is, but for the best zero: its entry, the model row by row, its regimes."""
    campaign = campaign_of(case, readings, ())
    given = Assembled(campaign, [effect for effect, _ in campaign.effects])
    point, regimes = given.with_regimes(given.neutral)
    model, zero = with_zeros(campaign, point.angle_arcsec)
    entry = rows_of(STATED, "stated", "the drive as stated", (), campaign.y_arcsec, model)
    entry["zero_arcsec"] = finite(zero)
    return entry, model, regimes.tolist()


def with_zeros(campaign: Campaign, angle: Floats) -> tuple[Floats, float]:
    """The model with the zeros that fit best, and the zero where all readings share one."""
    zero = best_zeros(campaign, angle)
    return angle + campaign.offsets @ zero, float(zero[0]) if len(zero) == 1 else np.nan


def best_zeros(campaign: Campaign, angle: Floats) -> Floats:
    """One for all, or one for each run, which are columns without overlap; arcsec."""
    weight = np.where(np.isfinite(angle), campaign.u_arcsec**-2.0, 0.0)
    off = np.where(np.isfinite(angle), campaign.y_arcsec - angle, 0.0)
    columns = campaign.offsets.T
    return np.asarray((columns @ (weight * off)) / np.maximum(columns @ weight, 1e-300))
