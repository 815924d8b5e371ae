"""A whole campaign: the shortest plan that tells some effects apart.

    shortest_plan   a case, effects and what the rig can do -> Design
    Design          the plan, and how far each two effects are apart in it

Runs are chosen from `candidates`. Everything is linear here: each run adds its product matrix of
all columns that matter (numbers of drive and rig, offset, changes by the effects at the sizes asked
for, and what the rivals can look like), and how far two effects are apart in a plan follows from
the sum of them (Schur complement). Runs are added one by one, each the one that brings the most of
what is still wanted (what is enough counts no further); then those that are not needed are taken
out, and plans with one run less are tried by exchange. `isolability` of the plan, which is not
linear, is the check.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive, effect_specs
from cbpt.errors import InvalidInputError
from cbpt.lab.covariance.linear_gaussian import Noise
from cbpt.lab.covariance.one_thread import one_blas_thread
from cbpt.lab.experiment.candidates import Limits, candidates, described
from cbpt.lab.experiment.design_fit import Sight
from cbpt.lab.experiment.detection import LIMIT, distance, weight
from cbpt.lab.experiment.effect_changes import Form, forms_of, guises, possible
from cbpt.lab.experiment.isolability import Isolability, isolability, known, of_ball_drives
from cbpt.lab.experiment.isolability_data import CHANCES
from cbpt.lab.experiment.plan import Plan, PlannedRun
from cbpt.lab.model.priors import LOT, TWINS, VARIANTS, Variant
from cbpt.lab.readings.headers import unit_at_end
from cbpt.lab.readings.inputs import case_of
from cbpt.lab.selection.fit_effects import predicted
from cbpt.lab.selection.setting import prior
from cbpt.lab.wording import layout
from cbpt.lab.wording.html import Reported
from cbpt.lab.wording.numbers import display, listed, shown

__all__ = ["Apart", "Design", "shortest_plan"]

Floats = NDArray[np.float64]

MAX_RUNS = 12
_Z = CHANCES["sure"][1]
_SWEEPS = 3


@dataclass(frozen=True)
class Apart:
    """An effect at the size asked for, against another one or, where that is empty, nothing."""

    effect: str
    other: str
    d: float
    """How far apart they are, in standard uncertainties."""
    needed: float

    @property
    def enough(self) -> bool:
        """Whether they are told apart 19 times of 20."""
        return self.d >= self.needed


@dataclass(frozen=True, eq=False)
class Design(Reported):
    """A campaign that was designed. `report` says it in words."""

    case: Case | Drive
    plan: Plan | None
    """None where no run within the limits has a solution."""
    effects: tuple[str, ...]
    sizes: Mapping[str, Mapping[str, float]]
    """Parameters of each effect at which they are to be told apart, SI."""
    apart: tuple[Apart, ...]
    at_best: tuple[Apart, ...]
    """The same with every candidate in the plan, as often as the plan may have runs."""
    twins: tuple[tuple[str, str], ...]
    """Pairs that no plan tells apart."""
    max_runs: int

    @property
    def reached(self) -> bool:
        """Whether the plan tells all of them apart that can be."""
        return self.plan is not None and all(a.enough for a in self.apart)

    def checked(self) -> Isolability | None:
        """What the plan could see by `isolability`, which is not linear."""
        if self.plan is None:
            return None
        return isolability(self.case, self.plan, effects=self.effects)

    def report(self) -> str:
        """As text."""
        return "\n".join(self._lines())

    def _lines(self) -> Iterator[str]:
        for effect, values in self.sizes.items():
            told = ", ".join(shown((effect, n), v, None) for n, v in values.items())
            yield f"{effect}: {told}"
        for one, other in self.twins:
            yield (
                f"No plan can distinguish {one} from {other}: both change every reading of this "
                "rig in the same way."
            )
        if self.plan is None:
            yield "The model has no solution for any run within the limits: raise the preloads."
            return
        names = listed(list(self.effects))
        runs = len(self.plan.runs)
        if self.reached:
            size = f"{runs} run{'s' * (runs != 1)} of {len(self.plan.runs[0])} readings"
            yield f"{size} distinguish {names}"
            yield "from each other and from no effect with a probability of 95 %:"
        else:
            yield f"{self.max_runs} runs do not distinguish {names}; the best plan of that length:"
        table = [
            [
                f"{run.preload_N:g}",
                f"{max(run.torque_Nm, key=abs):g}",
                described(run),
                f"{run.input_angle_deg[0]:g}" if len(run.input_angle_deg) == 1 else "full turn",
            ]
            for run in self.plan.runs
        ]
        headers = ["preload_N", "torque_Nm", "torque sequence", "input_angle_deg"]
        yield layout.table(headers, table)
        rows = [
            [a.effect, a.other or "no effect", f"{a.d:.1f}", f"{a.needed:.1f}"]
            for a in sorted(self.apart, key=lambda a: a.d / a.needed)
        ]
        yield "Distance of each effect from the other, in standard uncertainties, closest first:"
        yield layout.table(["effect", "other", "distance", "needed"], rows[:10])
        for now, best in zip(self.apart, self.at_best, strict=True):
            if not now.enough:
                what = f"{now.effect} and {now.other or 'no effect'}"
                more = "more" if best.enough else "no number of"
                yield f"{what}: {more} such runs would distinguish them at this size."

    def __repr__(self) -> str:
        return self.report()


def shortest_plan(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, Any],
    effects: Sequence[str],
    *,
    u_elastic_angle_arcsec: float,
    limits: Limits | None = None,
    sizes: Mapping[str, Mapping[str, float]] | None = None,
    max_runs: int = MAX_RUNS,
    most: int | None = None,
) -> Design:
    """Search for the shortest plan that distinguishes effects.

    The plan distinguishes every two effects, and each effect from no effect, with a probability of
    0.95. The search exchanges runs one by one, so it may miss a shorter plan.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The drive, as in `compare`.
    effects : sequence of str
        Ids of the library.
    u_elastic_angle_arcsec : float
        Standard uncertainty of a reading (k = 1), arcsec.
    limits : Limits, optional
        What the rig can do. Without it, limits around the load of the case.
    sizes : mapping of str to mapping, optional
        Parameters of effects, named as in a case file, at which the effects must be distinguished.
        Without it, the geometric middle of their plausible range, at every shape.
    max_runs : int
        The largest number of runs.
    most : int, optional
        The number of candidate runs.

    Returns
    -------
    Design
        The plan, and the pairs of effects that it does not distinguish.

    Raises
    ------
    InvalidInputError
        An effect or a size is not possible.
    CaseError
        The case cannot be read.
    """
    case = case_of(case)
    of_ball_drives(case)
    names = known(effects)
    if not effects or LOT in names:
        raise InvalidInputError(
            "effects: name the effects to distinguish (cbpt effects lists them)"
            + (
                f"; {LOT} is not possible, because it can imitate nearly every other effect"
                if effects
                else ""
            )
        )
    if not 1 <= max_runs <= 100:
        raise InvalidInputError(f"max_runs: found {max_runs}, expected 1 to 100")
    limits = limits or limits_of_case(case)
    drive = case if isinstance(case, Drive) else case.drive
    runs = [
        replace(run, u_elastic_angle_arcsec=u_elastic_angle_arcsec)
        for run in candidates(drive, limits, most)
    ]
    with one_blas_thread():
        runs = _solved(case, runs)
        truths = _sizes(case, names, sizes or {})
        twins = tuple(
            (one, other)
            for i, one in enumerate(names)
            for other in names[i + 1 :]
            if other in TWINS.get(one, [])
        )
        if not runs:
            return Design(case, None, names, {}, (), (), twins, max_runs)
        wanted = _Wanted(case, runs, truths, twins)
        if not wanted.runs:
            return Design(case, None, names, wanted.values, (), (), twins, max_runs)
        chosen = wanted.shortest(max_runs)
        everything = max_runs * wanted.grams.sum(axis=0)
        return Design(
            case,
            Plan.of_runs([wanted.runs[r] for r in chosen]),
            names,
            wanted.values,
            wanted.apart(wanted.total(chosen)),
            wanted.apart(everything),
            twins,
            max_runs,
        )


def limits_of_case(case: Case | Drive) -> Limits:
    """Around the load that the case states. Raises `InvalidInputError` where it states none."""
    torque = case.torque_Nm if isinstance(case, Case) else None
    preload = case.preload_N if isinstance(case, Case) else None
    if torque is None or preload is None:
        raise InvalidInputError(
            "limits: the case has no [load]; give the range of the rig with --torque-Nm MAX and "
            "--preload-N LOW HIGH (limits=)"
        )
    return Limits(abs(torque), (0.6 * preload, 1.6 * preload))


def _solved(case: Case | Drive, runs: list[PlannedRun]) -> list[PlannedRun]:
    """Runs at every reading of which the model has a solution."""
    rows = Plan.of_runs(runs).rows
    fine = predicted(case, rows).has_solution
    return [run for number, run in enumerate(runs) if fine[rows.run_index == number].all()]


# --- at which sizes -----------------------------------------------------------------------

_NEUTRAL = {(spec.id, p.name): p.neutral for spec in effect_specs() for p in spec.parameters}
Truth = tuple[Variant, float]
"""A form of an effect, its shapes as they are to be looked at, and its size (SI, off neutral)."""


def _sizes(
    case: Case | Drive, effects: Sequence[str], sizes: Mapping[str, Mapping[str, float]]
) -> dict[str, Truth]:
    stray = next((e for e in sizes if e not in effects), None)
    if stray is not None:
        raise InvalidInputError(f"sizes: {stray} is not one of the effects to distinguish")
    found = {}
    for effect in effects:
        forms = [v for v in VARIANTS if v.effect == effect]
        if effect not in sizes:
            found[effect] = forms[0], float(np.sqrt(forms[0].low * forms[0].high))
            continue
        bare = Case.from_toml((case if isinstance(case, Drive) else case.drive).to_toml())
        (made,) = bare.with_effects([(effect, dict(sizes[effect]))]).effects
        values = dict(made.values)
        found[effect] = _at(effect, forms, values, list(sizes[effect]))
    return found


def _at(
    effect: str, forms: Sequence[Variant], values: Mapping[str, float], given: Sequence[str]
) -> Truth:
    """The form that has the sizes which are off neutral."""
    off = {
        n: v - (_NEUTRAL[effect, n] or 0.0) for n, v in values.items() if (effect, n) in _NEUTRAL
    }
    for form in forms:
        fixed = all(values.get(n) == v for n, v in form.fixed)
        ratios = np.array(form.ratios or (1.0,) * len(form.sizes))
        size = float(np.linalg.norm([off.get(n, 0.0) for n in form.sizes] / ratios))
        if fixed and size > 0:
            stems = {_stem(key) for key in given}
            stated = {
                s.name
                for s in form.shapes
                if s.name in given or display(effect, s.name)[0] in given or _stem(s.name) in stems
            }
            shapes = tuple(
                replace(s, grid=(values[s.name],)) if s.name in stated else s for s in form.shapes
            )
            return replace(form, shapes=shapes), size
    raise InvalidInputError(f"sizes: {effect} has no influence with {dict(values)}; give it a size")


def _stem(key: str) -> str:
    """The name of a parameter without its unit: of `time_constant_min`, `time_constant`."""
    unit = unit_at_end(key)
    return key.removesuffix(f"_{unit}") if unit else key


# --- what is wanted -----------------------------------------------------------------------


class _Wanted:
    """Product matrices of the runs, and how far effects are apart in a sum of them."""

    def __init__(
        self,
        case: Case | Drive,
        runs: list[PlannedRun],
        truths: Mapping[str, Truth],
        twins: Sequence[tuple[str, str]],
    ) -> None:
        self.runs = runs
        sight = Sight(case, Plan.of_runs(runs), Noise())
        forms = self._forms(sight, truths)
        self.values = {e: dict(f[0].values(float(f[0].sizes[0]))) for e, f in forms.items()}
        fine = np.array(
            [
                all(
                    np.isfinite(f.changes[self._rows(sight, r)]).all()
                    for own in forms.values()
                    for f in own
                )
                for r in range(len(runs))
            ]
        )
        if not fine.all():
            self.runs = [run for run, kept in zip(runs, fine, strict=True) if kept]
            if not self.runs:
                return
            sight = Sight(case, Plan.of_runs(self.runs), Noise())
            forms = self._forms(sight, truths)
        self._columns(sight, forms, truths)
        self._needs(forms, twins, len(sight.campaign) // len(self.runs))

    @staticmethod
    def _rows(sight: Sight, run: int) -> NDArray[np.bool_]:
        return np.asarray(sight.campaign.rows.run_index == run)

    @staticmethod
    def _forms(sight: Sight, truths: Mapping[str, Truth]) -> dict[str, list[Form]]:
        found = {}
        for effect, (variant, size) in truths.items():
            there, lacking = possible(sight.campaign, [variant])
            if not there:
                raise InvalidInputError(
                    f"effects: {effect} depends on {lacking[effect]}, which is missing or does not "
                    "vary in these runs"
                )
            found[effect] = forms_of(sight.campaign, there, np.array([size]))
        return found

    def _columns(
        self, sight: Sight, forms: Mapping[str, list[Form]], truths: Mapping[str, Truth]
    ) -> None:
        """All columns side by side, and the product matrix of each run."""
        whiten = sight.fit.whitener
        numbers = len(sight.fit.unknowns)
        columns = [sight.fit.margin.x[:, :numbers], whiten(np.ones((len(sight.campaign), 1)))]
        self.precision = np.r_[sight.root[:numbers] ** 2, 0.0]
        at = self.base = numbers + 1
        self.truth: dict[str, list[int]] = {}
        for effect, own in forms.items():
            self.truth[effect] = list(range(at, at + len(own)))
            columns += [whiten(form.changes) for form in own]
            at += len(own)
        self.looks: dict[str, list[list[int]]] = {}
        for effect, (_, size) in truths.items():
            there, _ = possible(sight.campaign, [v for v in VARIANTS if v.effect == effect])
            seen = [
                (f, f.changes, f.slopes) for f in forms_of(sight.campaign, there, np.array([size]))
            ]
            self.looks[effect] = []
            for guise in guises(seen):
                length = np.linalg.norm(whiten(np.nan_to_num(guise)), axis=0)
                if np.isfinite(guise).all() and length.min() > 1e-6:
                    columns.append(whiten(guise) / length)
                    self.looks[effect].append(list(range(at, at + guise.shape[1])))
                    at += guise.shape[1]
        wide = np.column_stack(columns)
        per_run = sight.campaign.offsets.shape[1] > 1
        grams = []
        for run in range(len(self.runs)):
            rows = wide[self._rows(sight, run)]
            gram = rows.T @ rows
            if per_run:
                offset = gram[self.base - 1].copy()
                gram -= np.outer(offset, offset) / max(offset[self.base - 1], 1e-300)
            grams.append(gram)
        self.grams = np.array(grams)

    def _needs(
        self, forms: Mapping[str, list[Form]], twins: Sequence[tuple[str, str]], readings: int
    ) -> None:
        """(effect, other or "", distance needed) of everything that is wanted."""
        self.needs: list[tuple[str, str, float]] = []
        for one, own in forms.items():
            form = own[0].variant
            alone = distance(form, weight(VARIANTS, form), 6 * readings, _Z)
            self.needs.append((one, "", alone))
            for other in forms:
                if other != one and (one, other) not in twins and (other, one) not in twins:
                    odds = prior((one,)) - prior((other,))
                    self.needs.append((one, other, _Z + np.sqrt(_Z**2 + 2 * max(LIMIT - odds, 0))))

    def total(self, chosen: Sequence[int]) -> Floats:
        """Product matrix of a plan."""
        return np.asarray(self.grams[list(chosen)].sum(axis=0))

    def distances(self, grams: Floats) -> Floats:
        """How far apart everything wanted is, for product matrices (b, m, m): shape (b, wanted)."""
        b = self.base
        corner = grams[:, :b, :b] + np.diag(self.precision + 1e-9)
        side = grams[:, :b, b:]
        left = grams[:, b:, b:] - side.transpose(0, 2, 1) @ np.linalg.solve(corner, side)
        out = np.empty((len(grams), len(self.needs)))
        for k, (one, other, _) in enumerate(self.needs):
            # Whatever the shape of the one, and whatever the other makes of itself.
            squares = [
                self._apart(left, a - b, [i - b for i in guise])
                for a in self.truth[one]
                for guise in (self.looks[other] if other else [[]])
            ]
            out[:, k] = np.sqrt(np.maximum(np.min(squares, axis=0), 0.0))
        return out

    @staticmethod
    def _apart(left: Floats, a: int, guise: list[int]) -> Floats:
        own = left[:, a, a]
        if not guise:
            return np.asarray(own)
        block = left[:, guise][:, :, guise]
        size = np.trace(block, axis1=1, axis2=2)[:, None, None]
        block = block + (1e-9 * size + 1e-12) * np.eye(len(guise))
        cross = left[:, guise, a]
        return np.asarray(
            own - np.sum(cross * np.linalg.solve(block, cross[:, :, None])[:, :, 0], 1)
        )

    def apart(self, gram: Floats) -> tuple[Apart, ...]:
        """The same for one plan, with what is needed."""
        found = self.distances(gram[None])[0]
        return tuple(
            Apart(one, other, float(d), needed)
            for (one, other, needed), d in zip(self.needs, found, strict=True)
        )

    def score(self, grams: Floats) -> Floats:
        """How much of what is wanted is there; all of it is the number of wants. What is enough
        counts no further, but for a hair.
        """
        share = self.distances(grams) / np.array([needed for _, _, needed in self.needs])
        return np.asarray(
            np.sum(np.minimum(share, 1.0) ** 2 + 1e-6 * np.minimum(share, 9.0), axis=1)
        )

    def enough(self, chosen: Sequence[int]) -> bool:
        """Whether a plan tells everything apart."""
        return bool(chosen) and all(a.enough for a in self.apart(self.total(chosen)))

    # --- the search -----------------------------------------------------------------------

    def shortest(self, max_runs: int) -> list[int]:
        """Runs of the shortest plan found; of the best one with `max_runs` where none is enough."""
        chosen: list[int] = []
        while len(chosen) < max_runs and not self.enough(chosen):
            have = self.total(chosen) if chosen else np.zeros_like(self.grams[0])
            chosen.append(int(np.argmax(self.score(have + self.grams))))
        if not self.enough(chosen):
            return sorted(self._exchanged(chosen))
        for run in list(chosen):
            fewer = chosen.copy()
            fewer.remove(run)
            chosen = fewer if self.enough(fewer) else chosen
        while len(chosen) > 1:
            # Without the run that is missed least, and the others exchanged.
            have = self.total(chosen)
            missed = int(np.argmax(self.score(have - self.grams[chosen])))
            fewer = self._exchanged([r for k, r in enumerate(chosen) if k != missed])
            if not self.enough(fewer):
                break
            chosen = fewer
        return sorted(chosen)

    def _exchanged(self, chosen: list[int]) -> list[int]:
        """Each run in turn for the one that is best in its place, until none is better."""
        chosen = chosen.copy()
        best = float(self.score(self.total(chosen)[None])[0])
        for _ in range(_SWEEPS):
            before = best
            for k in range(len(chosen)):
                without = self.total(chosen) - self.grams[chosen[k]]
                scores = self.score(without + self.grams)
                if scores.max() > best + 1e-9:
                    chosen[k], best = int(np.argmax(scores)), float(scores.max())
            if best <= before + 1e-9:
                break
        return chosen
