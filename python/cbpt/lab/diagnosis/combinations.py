"""The sets of effects that the readings leave, each with its own numbers.

Combination   one set: probability, parameters, errors
combinations  those that make up 95 % of the posterior, the most probable first
remains       what is left after the answer, against what readings scatter by
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from cbpt.lab.diagnosis.diagnosis_data import DiagnosisData, probable_sets
from cbpt.lab.diagnosis.rungs import rung_of, rung_of_lack_of_fit
from cbpt.lab.selection.posterior import UNKNOWN, named_of, posterior_of
from cbpt.lab.selection.rest import remains_arcsec
from cbpt.lab.selection.rules import RULES


@dataclass(frozen=True)
class Combination:
    """One set of effects."""

    effects: tuple[str, ...]
    """`run_offset` among them where the noise has offsets of runs."""
    unnamed: bool
    """Whether something without a name is at work beside them."""
    probability: float
    parameters: dict[str, dict[str, dict[str, Any]]]
    """By effect and parameter; SI, with standard uncertainties."""
    rmse_arcsec: float
    held_out_rmse_arcsec: float
    chi2_per_dof: float

    def to_dict(self) -> dict[str, Any]:
        """As plain values."""
        return {**vars(self), "effects": list(self.effects)}


def combinations(d: DiagnosisData) -> list[Combination]:
    """Those that make up 95 % of the posterior, at most twelve, the most probable first: what
    remains without a name may take more from one than from another."""
    posterior = posterior_of(d.competition)
    return [
        _combination(d, names, d.verdict.of_set(names) * posterior.sets[names])
        for names in probable_sets(posterior)
    ]


def _combination(d: DiagnosisData, names: tuple[str, ...], probability: float) -> Combination:
    """One set. One noise judges all that have names: a fit without an effect may take it for noise.
    What has no name is a free function, with the noise that was fitted beside it."""
    fitter, base = d.competition.fitter, named_of(names)
    fit = d.fit_of(base)
    lacks = [lack for lack in d.competition.lacks_of_fit if lack.base == base]
    if UNKNOWN in names and lacks:
        errors = rung_of_lack_of_fit(lacks[0], d.fold)
    else:
        errors = rung_of(fitter, "", fitter.look(fit, d.noises.of(base)), d.fold)
    return Combination(
        effects=tuple(n for n in names if n != UNKNOWN),
        unnamed=UNKNOWN in names,
        probability=probability,
        parameters={e: d.parameters(fit, e) for e in base},
        rmse_arcsec=errors.rmse_arcsec,
        held_out_rmse_arcsec=errors.held_out_rmse_arcsec,
        chi2_per_dof=errors.chi2_per_dof,
    )


def remains(d: DiagnosisData) -> dict[str, Any] | None:
    """What is left after the answer; None where it is no more than readings scatter by."""
    lack, adequacy = d.verdict.lack_of_fit, d.verdict.adequacy
    if lack is None:
        return None
    before = float(np.sqrt(np.mean(d.before.residual_arcsec**2)))
    rest = remains_arcsec(lack, adequacy)
    # Where this test finds nothing it says nothing of the rest: the posterior alone does.
    known = adequacy is not None and adequacy.p_value < RULES.left_chance
    return {
        "depends_on": list(lack.columns),
        "rms_arcsec": rest,
        "share_of_misfit": min((rest / before) ** 2, 1.0) if before > 0 else None,
        "left_arcsec": adequacy.left_arcsec if adequacy else None,
        "expected_arcsec": adequacy.expected_arcsec if adequacy and known else None,
        "expected_from": adequacy.source if adequacy and known else None,
        "p_value": adequacy.p_value if adequacy and known else None,
    }
