"""Before any reading: what a campaign could see, and what it could tell apart.

    isolability     a case and a plan -> Isolability
    Isolability     what it could see, as data, document, text and picture

An effect is let act in full at sizes over its plausible range. What is left of the change after
the refit has a length `d` in standard uncertainties; `detectable` says which d a diagnosis tells.
Two effects are told apart as far as the change by one lies outside everything that the other can
look like at any size and shape: with the largest correlation r that is d sqrt(1 - r^2), and half
its square is the log odds that it is expected to bring.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cbpt._core import Case, Drive
from cbpt.errors import InvalidInputError
from cbpt.figures.isolability import draw_isolability
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.covariance.one_thread import one_blas_thread
from cbpt.lab.experiment.design_fit import Sight
from cbpt.lab.experiment.detection import LIMIT, weight
from cbpt.lab.experiment.effect_changes import forms_of, possible
from cbpt.lab.experiment.isolability_data import CHANCES, IsolabilityData, Pair, Seen
from cbpt.lab.experiment.isolability_text import lines
from cbpt.lab.experiment.plan import Plan, read_plan
from cbpt.lab.experiment.separation import (
    guises_left,
    left_of,
    pair_of,
    prices_of,
    seen_in,
    soonest,
    twins_unseen,
)
from cbpt.lab.experiment.simulate import Instrument
from cbpt.lab.model.priors import CLASSES, LOT, PRIORS, VARIANTS, Variant, lots
from cbpt.lab.readings.inputs import case_of
from cbpt.lab.readings.reader import Readings
from cbpt.lab.selection.competition import Progress
from cbpt.lab.wording.html import Reported
from cbpt.lab.wording.versions import versions

__all__ = ["Isolability", "Pair", "Seen", "isolability"]

Floats = NDArray[np.float64]
SCHEMA = "cbpt.isolability/1"


@dataclass(frozen=True, eq=False, repr=False)
class Isolability(Reported, IsolabilityData):
    """What a campaign could see. `to_dict` is the JSON document; `report` says it in words."""

    def to_dict(self) -> dict[str, Any]:
        """The JSON document as plain values."""
        return deepcopy(_document(self))

    def to_json(self) -> str:
        """The document as text."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False, default=float)

    def report(self) -> str:
        """In words and tables."""
        return "\n".join(lines(self))

    def plot(self, path: str | os.PathLike[str]) -> None:
        """Draw the matrix of pairs to an SVG, PNG or PDF file; needs `pip install "cbpt[plot]"`."""
        draw_isolability(self.pairs, path)

    def __repr__(self) -> str:
        return self.report()


def isolability(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, Any],
    plan: Plan | Readings | str | os.PathLike[str] | Mapping[str, ArrayLike],
    *,
    effects: Sequence[str] | None = None,
    noise: Instrument | str | Sequence[str] = "white",
    u_elastic_angle_arcsec: float | None = None,
    progress: Progress | None = None,
) -> Isolability:
    """Say which effects a campaign could detect and tell apart, before any reading.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The drive, as in `compare`.
    plan : Plan, Readings, str, PathLike or mapping
        The campaign, as `read_plan` takes it.
    effects : sequence of str, optional
        Ids of the library. Without it, all of them.
    noise : Instrument, str or sequence of str
        An `Instrument`, or kinds of noise with their sizes, for example ``"run_offset=2"``.
        It counts through its covariance: tails, outliers and steps count as scatter of the same
        standard deviation.
    u_elastic_angle_arcsec : float, optional
        Standard uncertainty of a reading (k = 1), where the plan has none.
    progress : callable, optional
        Called as ``progress(what_is_next, share_done)``. What it raises ends the work.

    Returns
    -------
    Isolability
        The smallest detectable size of each effect (SI), and what tells each pair apart.

    Raises
    ------
    NoSolutionError
        The preload of the plan does not hold the torque in some rows.
    PlanError, ReadingsError, CaseError, InvalidInputError
        Plan, case or an argument cannot be read.
    """
    case = case_of(case)
    of_ball_drives(case)
    instrument = Instrument.of(noise)
    found = read_plan(plan, case).with_u(u_elastic_angle_arcsec)
    wanted = known(effects)
    with one_blas_thread():
        sight = Sight(case, found, covariance(instrument, found))
        return _isolability(found, instrument, sight, wanted, progress)


def of_ball_drives(case: Case | Drive) -> None:
    """Raise `InvalidInputError` for a torsion spring: what is plausible follows from readings."""
    drive = case if isinstance(case, Drive) else case.drive
    if drive.kind != "ball_drive":
        raise InvalidInputError(
            "plans can be judged for ball drives only: for a torsion spring the plausible sizes of "
            "effects are known only from readings"
        )


def known(effects: Sequence[str] | None) -> tuple[str, ...]:
    """Ids of effects that can be looked for. Raises `InvalidInputError` for others."""
    every = tuple(dict.fromkeys([*(v.effect for v in VARIANTS), LOT]))
    if not effects:
        return every
    wrong = next((e for e in effects if e not in every), None)
    if wrong is not None and not isinstance(wrong, str):
        raise InvalidInputError(
            f"effects: found {wrong!r}, expected ids of effects (cbpt effects lists them)"
        )
    if wrong is not None:
        import difflib

        near = difflib.get_close_matches(wrong, every, 1)
        hint = f"; did you mean {near[0]}?" if near else ""
        if wrong == "run_offset":
            hint = "; an offset of each run is a kind of noise: --noise run_offset=SIZE (noise=)"
        raise InvalidInputError(
            f"effects: found {wrong!r}, expected any of {', '.join(every)}{hint}"
        )
    return tuple(dict.fromkeys(effects))


def covariance(instrument: Instrument, plan: Plan) -> Noise:
    """The noise of a plan as fits see it."""
    u = plan.rows.u_elastic_angle_arcsec
    assert u is not None
    offset = instrument.run_offset_per_u * float(np.median(u))
    return Noise(max(instrument.scale, 1e-3), instrument.correlation, offset)


def _isolability(
    plan: Plan,
    instrument: Instrument,
    sight: Sight,
    effects: Sequence[str],
    progress: Progress | None = None,
) -> Isolability:
    campaign = sight.campaign
    every = (*VARIANTS, *lots(campaign.balls))
    there, lacking = possible(campaign, [v for v in every if v.effect in effects])
    unseen = {
        effect: f"not detectable, because {column} is missing or does not vary"
        for effect, column in lacking.items()
    }
    tell = progress or (lambda what, share: None)
    variants: dict[str, list[Variant]] = {}
    for variant in there:
        variants.setdefault(variant.effect, []).append(variant)
    seen: list[Seen] = []
    alike: dict[str, list[Seen]] = {}
    looks: dict[str, list[Floats]] = {}
    for number, effect in enumerate(variants):
        share = 0.8 * number / len(variants)
        tell(effect, share)
        own = forms_of(campaign, variants[effect])
        lefts = []
        for form in own:
            tell(effect, share)
            lefts.append(left_of(sight, form))
        prices = prices_of(own, lefts)
        found = [
            seen_in(sight, form, left, weight(every, form.variant) + price)
            for form, left, price in zip(own, lefts, prices, strict=True)
        ]
        best = soonest(found)
        if best.smallest["even"] is None:
            unseen[effect] = best.why_not
            continue
        seen.append(best)
        # The same form at every shape at which it is seen, the soonest first.
        shaped = [s for s in found if s.form.variant is best.form.variant and s is not best]
        alike[effect] = [best, *(s for s in shaped if s.smallest["even"] is not None)]
        looks[effect] = guises_left(sight, found)
    order = {effect: i for i, effect in enumerate(effects)}
    seen.sort(key=lambda s: order[s.effect])
    pairs = []
    for i, one in enumerate(seen):
        tell("pairs of effects", 0.8 + 0.2 * i / len(seen))
        pairs += [
            pair_of(alike[one.effect], alike[other.effect], looks[one.effect], looks[other.effect])
            for other in seen[i + 1 :]
            if LOT not in (one.effect, other.effect)
        ]
    pairs += twins_unseen(effects, unseen)
    return Isolability(plan, instrument, tuple(seen), unseen, tuple(pairs), campaign.priors)


# --- the document -------------------------------------------------------------------------


def _document(i: Isolability) -> dict[str, Any]:
    rows = i.plan.rows
    return {
        "schema": SCHEMA,
        "versions": versions(),
        "source": rows.source,
        "rows": len(rows),
        "runs": int(rows.run_index.max()) + 1,
        "noise": {
            "scale": i.noise.scale,
            "correlation": i.noise.correlation,
            "run_offset_per_u": i.noise.run_offset_per_u,
        },
        "criterion": {
            "log_odds": LIMIT,
            "chances": {name: chance for name, (chance, _) in CHANCES.items()},
        },
        "priors": {PRIORS[e]: sd for e, sd in i.priors.items()},
        "effects": [_entry(i, s) for s in i.seen],
        "unseen": [{"effect": e, "why": why} for e, why in i.unseen.items()],
        "pairs": [
            {
                "effects": list(p.effects),
                "correlation": p.correlation,
                "verdict": p.verdict,
                "above": {
                    e: None if size is None else i.effect(e).form.values(size)
                    for e, size in zip(p.effects, p.above, strict=True)
                },
                "decided_by": list(p.decided_by),
            }
            for p in i.pairs
        ],
        "groups": i.groups(),
    }


def _entry(i: Isolability, s: Seen) -> dict[str, Any]:
    rival, correlation = i.looks_most_like(s.effect)
    return {
        "effect": s.effect,
        "class": CLASSES.get(s.effect, "effect"),
        "form": s.label,
        "smallest": {name: s.values(name) for name in CHANCES},
        "sizes": [
            {"values": s.form.values(float(size)), "d": None if np.isnan(d) else float(d)}
            for size, d in zip(s.form.sizes, s.d, strict=True)
        ],
        "looks_most_like": rival,
        "correlation": correlation,
    }
