"""Add effects to a case: fit them to readings, and get the case with them in it.

fit         a case, its readings and effects -> Fitted
Fitted      values with uncertainties, the error before and after, the new case
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from threadpoolctl import threadpool_limits

from cbpt._core import Case, Drive, text_table
from cbpt.errors import InvalidInputError
from cbpt.lab.answer import Rung, parameters_of
from cbpt.lab.assembled import Campaign
from cbpt.lab.diagnose import prepared, rung
from cbpt.lab.fit import Fit, Fitter, Hypothesis
from cbpt.lab.holdout import folds
from cbpt.lab.inputs import case_and_readings
from cbpt.lab.library import PRIORS, Variant
from cbpt.lab.noise import Noise
from cbpt.lab.readings import Readings
from cbpt.lab.screen import Screen, Signatures
from cbpt.lab.sentence import shown

__all__ = ["Fitted", "fit"]


@dataclass(frozen=True, eq=False)
class Fitted:
    """Effects fitted to readings."""

    case: Case
    """The case with the effects in it, and the numbers of the drive as they were refitted."""
    readings: Readings
    effects: tuple[str, ...]
    before: Rung
    """The case as given."""
    after: Rung
    """With the effects, and the numbers refitted within their stated uncertainties."""
    result: Fit = field(repr=False)
    held_out_by: str
    notes: tuple[str, ...]

    def parameters(self) -> dict[str, dict[str, dict[str, Any]]]:
        """By effect and parameter: value and standard uncertainty, SI, unit, or why there is none."""
        return {e: parameters_of(self.result, e) for e in self.effects}

    def report(self) -> str:
        """As text."""
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        import json

        yield f"{len(self.readings)} readings of {self.readings.source}"
        yield from (f"Note: {note}" for note in self.notes)
        for effect, found in self.parameters().items():
            values = ", ".join(shown(n, p["value"], p["u"]) for n, p in found.items())
            yield f"{effect}: {values}"
        rows = [
            [name, f"{r.rmse_arcsec:.3f}", f"{r.held_out_rmse_arcsec:.3f}", f"{r.chi2_per_dof:.2f}"]
            for name, r in (("as given", self.before), ("fitted", self.after))
        ]
        yield f"Error, in sample and held out by {self.held_out_by}:"
        yield text_table(["", "rmse_arcsec", "held_out_arcsec", "chi2/dof"], json.dumps(rows))

    def __repr__(self) -> str:
        return self.report()


def fit(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, Any],
    data: Readings | str | os.PathLike[str] | Mapping[str, ArrayLike],
    effects: Sequence[str],
    *,
    columns: Mapping[str, str] | None = None,
) -> Fitted:
    """Fit effects of the library to readings, the numbers of the drive within their stated uncertainties.

    Of an effect that has several forms (see `cbpt effects`) the most probable one is taken. Raises
    `InvalidInputError` for an effect that is not in the library or cannot be seen in this table,
    `CaseError` and `ReadingsError` for what cannot be read.
    """
    case, readings = case_and_readings(case, data, columns)
    if isinstance(case, Drive):
        case = Case.from_toml(case.to_toml())
    with threadpool_limits(1, user_api="blas"):
        campaign, notes = prepared(Campaign.of(case, readings))
        fitter = Fitter(campaign)
        names = tuple(dict.fromkeys(effects))
        found = best_fit(fitter, names)
        fold, held_by = folds(campaign)
        nominal = fitter.at_nominal(found)
        return Fitted(
            case=case_with(case, fitter, found),
            readings=campaign.readings,
            effects=names,
            before=rung(fitter, "", nominal, fold),
            after=rung(fitter, " + ".join(names), found, fold),
            result=found,
            held_out_by=held_by,
            notes=tuple(notes),
        )


def best_fit(fitter: Fitter, names: Sequence[str]) -> Fit:
    """The most probable fit of some effects over all their forms and several starts."""
    forms = [_forms(fitter, name) for name in names]
    null = fitter.fit(Hypothesis())
    assert null is not None  # who prepares a campaign leaves out what has no solution
    best: Fit | None = None
    for variants in product(*forms):
        for start in _starts(fitter, null, variants):
            got = fitter.fit(Hypothesis(variants), start, Noise(looser=null.noise.looser))
            if got is not None and (best is None or got.log_evidence > best.log_evidence):
                best = got
    if best is None:
        raise InvalidInputError(
            f"{' + '.join(names)}: no fit was found at which the model has a solution at every reading"
        )
    return best


def _forms(fitter: Fitter, name: str) -> list[Variant]:
    known = {v.effect for v in fitter.variants}
    forms = [v for v in fitter.variants if v.effect == name]
    if name == "run_offset":
        raise InvalidInputError(
            'run_offset: a zero for each run is no effect to be added; set zero = "per_run" under [measurement]'
        )
    if not forms:
        raise InvalidInputError(
            f"{name}: not an effect of the library that this table can show; there are {', '.join(sorted(known))}"
        )
    return forms


def _starts(
    fitter: Fitter, null: Fit, variants: Sequence[Variant]
) -> Iterator[NDArray[np.float64]]:
    """Values to start from: what the linear problem finds at the shapes that suit it best."""
    from cbpt.lab.competition import places, start_values

    library = Signatures(fitter.campaign, variants)
    signatures = library.about(null, places(fitter))
    screen = Screen(null, signatures)
    members = [
        [m for m, s in enumerate(signatures) if s.variant is v and screen.usable(m)]
        for v in variants
    ]
    ranked = sorted(
        (screen.gain(choice) for choice in product(*members)), key=lambda g: -g.log_odds
    )
    for gain in ranked[:2]:
        yield start_values(fitter, signatures, gain.members, gain.sizes)
    if not ranked:
        raise InvalidInputError(
            f"{' + '.join(v.effect for v in variants)}: these readings do not depend on it at all"
        )


def case_with(case: Case, fitter: Fitter, found: Fit) -> Case:
    """The case with fitted effects, and with the numbers of the drive as refitted."""
    entries: dict[str, dict[str, float]] = {}
    for u in found.unknowns:
        effect, _, name = u.name.partition(".")
        if effect in PRIORS and not name:
            # Known by its effect: its one number.
            name = next(v.sizes[0] for v in fitter.variants if v.effect == effect)
        entries.setdefault(effect, {})[name] = found.value(u)
    for variant in found.hypothesis.variants:
        entries[variant.effect] |= dict(variant.fixed)
    return case.with_effects(list(entries.items()))
