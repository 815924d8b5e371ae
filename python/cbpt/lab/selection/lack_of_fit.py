"""Lack of fit: what a residual depends on, asked without naming a cause.

Component                  a family of basis functions: of torque, of torque at angles, ...
components                 all families that a table can show
Structure                  how much of a residual each of them explains
LackOfFit                  one family on top of a hypothesis, at its most favourable amplitude
lacks_of_fit_on            the families that stand out in the residual of a fit, with their evidence
says_no_more               whether it is only what a fit has a name for
held_out_with_lack_of_fit  readings less what the other folds and it predict of them

Each family is a set of overlapping hats (or levels, or powers) and their products, so it holds any
not too rough function of its columns. A family that holds any curve pays for each of them, so a law
with a name that happens to look alike would win over something simple without one. Therefore there
are simple families over the torque as well: smooth curves, one order, what began at one moment.
What a family explains is a sum of squares over its rank.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from itertools import groupby

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.fit_noise import fit_noise
from cbpt.lab.covariance.linear_gaussian import Linear, Margin, Noise, Whitener
from cbpt.lab.covariance.symmetric import eigen
from cbpt.lab.inference.cross_validation import held_out_by
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.model.discrepancy import DISCREPANCY_ODDS
from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.set_points import levels_of
from cbpt.lab.selection.ranking import ranked
from cbpt.lab.selection.rules import RULES

Floats = NDArray[np.float64]
Names = tuple[str, ...]


@dataclass(frozen=True)
class _Limits:
    """What is asked of a family, and of how many."""

    most_columns: int = 160
    most_levels: int = 40
    families: int = 3
    waves: int = 12
    """Half-waves of a smooth curve over the torque, and how many of them are large."""
    large_waves: int = 3
    moments: int = 64
    """Places in the table at which something may have begun."""
    amplitudes: tuple[float, ...] = (0.5, 1.5, 5.0, 15.0)


_LIMITS = _Limits()


@dataclass(frozen=True, eq=False)
class Component:
    """Patterns of shape (n, m) over the columns named."""

    columns: tuple[str, ...]
    patterns: Floats = field(repr=False)
    share: float = 1.0
    """Of the prior odds of a family: one of several forms of it has a part of them."""
    whole: bool = True
    """Whether it holds any curve, not a form of few numbers alone."""
    smooth: bool = False
    """Whether its patterns are the smaller the shorter they are, so that their number is no measure
    of what it may follow."""


def hats(values: Floats, knots: int) -> Floats:
    """Piecewise-linear functions that add up to 1, on knots among the values."""
    levels = np.unique(values)
    if len(levels) > knots:
        levels = np.unique(np.quantile(levels, np.linspace(0, 1, knots)))
    if len(levels) < 2:
        return np.ones((len(values), 1))
    return np.column_stack([np.interp(values, levels, row) for row in np.eye(len(levels))])


def levels(values: NDArray[np.generic]) -> Floats:
    """One column for each distinct value."""
    _, index = np.unique(values, return_inverse=True)
    return np.eye(int(index.max()) + 1)[index]


def smooth(values: Floats) -> Floats:
    """Powers up to the third, on the largest value."""
    x = values / max(float(np.abs(values).max()), 1e-300)
    return np.column_stack([np.ones(len(x)), x, x**2, x**3])


def waves(values: Floats) -> Floats:
    """Half-waves over the range, shorter ones the smaller, as in a smooth curve."""
    share = (values - values.min()) / max(float(np.ptp(values)), 1e-300)
    count = np.arange(1, _LIMITS.waves + 1)
    large = 1 / (1 + (count / _LIMITS.large_waves) ** 2)
    return np.asarray(np.cos(np.pi * share[:, None] * count) * large)


def slow_waves(values: Floats) -> Floats:
    """The same from a constant on, of which few matter: what changes slowly."""
    return np.column_stack([np.ones(len(values)), waves(values)[:, : 2 * _LIMITS.large_waves]])


def turn(angle_deg: Floats) -> Floats:
    """Distinct angles, or the first eight harmonics where there are many."""
    wrapped = np.round(np.mod(angle_deg, 360.0), 6)
    if len(np.unique(wrapped)) <= 24:
        return levels(wrapped)
    phase = np.deg2rad(wrapped)[:, None] * np.arange(1, 9)
    return np.column_stack([np.ones(len(phase)), np.cos(phase), np.sin(phase)])


def bases(readings: Readings) -> dict[str, Floats]:
    """Patterns of single columns, of those that vary."""
    r = readings
    torque = levels_of(r.torque_Nm).held
    alone = levels(torque) if len(np.unique(torque)) <= _LIMITS.most_levels else hats(torque, 12)
    found = {"torque_Nm": alone, "torque_smooth": smooth(torque), "torque_waves": waves(torque)}
    if r.preload_N is not None:
        preload = levels_of(r.preload_N).held
        few = len(np.unique(preload)) <= 6
        found["preload_N"] = levels(preload) if few else hats(preload, 6)
    if r.preload_step is not None:
        found["preload_step"] = levels(r.preload_step)
    found["input_angle_deg"] = turn(r.input_angle_deg)
    found["direction"] = levels(r.direction())
    if r.time_s is None:
        # Time went on though nobody wrote it down.
        even = {"order": np.arange(float(len(r)))}
    else:
        rate = np.abs(rate_of(r))
        even = {"time_s": r.time_s, "run_time_s": run_time(r), "torque_rate": rate}
    for name, values in even.items():
        found[name] = hats(values, 5 if name == "run_time_s" else 8)
        found[_smooth_of(name)] = slow_waves(values)
    found["later"] = _later(r)
    if r.temperature_degC is not None:
        found["temperature_degC"] = hats(r.temperature_degC, 4)
    if r.cycle is not None:
        found["cycle"] = levels(np.asarray(r.cycle))
    found["run"] = levels(r.run_index)
    return {name: b for name, b in found.items() if b.shape[1] > 1}


def _later(r: Readings) -> Floats:
    """1 from a moment on, 0 before: a column for each of some moments, spread over the readings."""
    n = len(r)
    place = np.arange(n)
    if r.time_s is not None:
        order = np.argsort(r.time_s, kind="stable")
        if np.count_nonzero(np.diff(r.run_index[order])) == r.run_index.max():
            # Else each run has a clock of its own, and the runs are as they are in the table.
            place[order] = np.arange(n)
    moments = np.unique(np.linspace(0, n, _LIMITS.moments + 2).astype(int)[1:-1])
    return np.asarray(place[:, None] >= moments[moments > 0], dtype=np.float64)


def run_time(readings: Readings) -> Floats:
    """Time since each run's first reading, s."""
    assert readings.time_s is not None
    first = np.full(int(readings.run_index.max()) + 1, np.inf)
    np.minimum.at(first, readings.run_index, readings.time_s)
    return np.asarray(readings.time_s - first[readings.run_index])


def rate_of(readings: Readings) -> Floats:
    """Torque per time that led to each reading of a run, N m/s; 0 at the first."""
    assert readings.time_s is not None
    step = np.diff(readings.torque_Nm, prepend=readings.torque_Nm[:1])
    gap = np.diff(readings.time_s, prepend=readings.time_s[:1])
    same = np.diff(readings.run_index, prepend=-1) == 0
    return np.where(same & (gap > 0), step / np.where(gap > 0, gap, 1.0), 0.0)


_SINGLES = (
    "torque_Nm",
    "preload_N",
    "preload_step",
    "input_angle_deg",
    "direction",
    "time_s",
    "order",
    "run_time_s",
    "temperature_degC",
    "cycle",
)
"""Not `run`: what is constant within runs are their offsets, which belong to the noise."""
_LEVELS = "input_angle_deg", "run"
_WITH_TORQUE = (
    "preload_N",
    "preload_step",
    "input_angle_deg",
    "direction",
    "time_s",
    "order",
    "run_time_s",
    "torque_rate",
    "temperature_degC",
    "cycle",
    "run",
)


def components(readings: Readings) -> tuple[Component, ...]:
    """All families that the table can show."""
    return tuple(_components(bases(readings), len(readings)))


def _components(found: dict[str, Floats], n: int) -> Iterator[Component]:
    for name in _SINGLES:
        if name in found:
            share = 1 / 3 if name == "torque_Nm" else 1.0
            yield Component((name,), found[name], share)
    if "torque_smooth" in found:
        yield Component(("torque_Nm",), found["torque_waves"], 1 / 3, smooth=True)
        yield Component(("torque_Nm",), found["torque_smooth"][:, 1:], 1 / 3, whole=False)
    for name in _WITH_TORQUE:
        if name in found and "torque_smooth" in found:
            yield from _over_torque(name, found)
    yield from _from_a_moment(found)
    if {"torque_smooth", "direction", "preload_N"} <= found.keys():
        loads = product([found["torque_Nm"], found["preload_N"]])
        # Every load by itself: what is left beyond the scatter of its repeats is no noise.
        if loads.shape[1] < 0.6 * n:
            yield Component(("torque_Nm", "preload_N"), loads)
        three = [found[name] for name in ("torque_smooth", "direction", "preload_N")]
        yield Component(("torque_Nm", "direction", "preload_N"), product(three))


def _over_torque(name: str, found: dict[str, Floats]) -> Iterator[Component]:
    """A curve of the torque at each value of another column, a smooth one with waves, or one order
    of it alone: a gain of each is less than a curve of each, and costs a fifth."""
    columns, other, torque = ("torque_Nm", name), found[name], found["torque_smooth"]
    forms = [torque, *_orders(torque)]
    share = 1 / (len(forms) + 1)
    for form in forms:
        yield Component(columns, product([form, other]), share, form is torque)
    other = found.get(_smooth_of(name), other)
    yield Component(columns, product([found["torque_waves"], other]), share, smooth=True)


def _smooth_of(name: str) -> str:
    """Where a column that goes on evenly has its smooth curves."""
    return f"{name}, smooth"


def _orders(torque: Floats) -> list[Floats]:
    """A gain, what is the same whatever the sign, and an odd curve."""
    return [torque[:, [1]], torque[:, [2]], torque[:, [1, 3]]]


def _from_a_moment(found: dict[str, Floats]) -> Iterator[Component]:
    """An offset, or an order of the torque, from one moment on: something slipped or cracked."""
    if "torque_smooth" not in found or "later" not in found:
        return
    time, torque = "time_s" if "time_s" in found else "order", found["torque_smooth"]
    forms = [((time,), torque[:, [0]]), *((("torque_Nm", time), form) for form in _orders(torque))]
    for columns, form in forms:
        for later in found["later"].T[:, :, None]:
            share = 1 / (len(forms) * found["later"].shape[1])
            yield Component(columns, form * later, share, whole=False)


def product(bases: Sequence[Floats]) -> Floats:
    """Every pattern of one times every one of the others, but for those that no row has."""
    out = reduce(lambda a, b: (a[:, :, None] * b[:, None, :]).reshape(len(a), -1), bases)
    return out[:, np.abs(out).max(axis=0) > 0.2]


class Structure:
    """Families seen through one fit: its noise and the refit of its unknowns."""

    def __init__(self, families: Sequence[Component], whitener: object, margin: Margin) -> None:
        self.families = [f for f in families if f.patterns.shape[1] <= _LIMITS.most_columns]
        length = np.maximum(np.linalg.norm(margin.x, axis=0), 1e-300)
        axes, size, _ = np.linalg.svd(margin.x / length, full_matrices=False)
        self._free = axes[:, size > 1e-9 * max(float(size.max(initial=0.0)), 1e-300)]
        self.axes: list[Floats] = []
        for together in _by_columns(self.families):
            joined = np.column_stack([family.patterns for family in together])
            seen = self.projected(whitener(joined))  # type: ignore[operator]
            ends = np.cumsum([family.patterns.shape[1] for family in together])[:-1]
            self.axes += [_axes(patterns) for patterns in np.split(seen, ends, axis=1)]
        self.ranks = np.array([a.shape[1] for a in self.axes])

    def projected(self, columns: Floats) -> Floats:
        """What is left of whitened columns once every unknown is refitted, whatever its prior."""
        return np.asarray(columns - self._free @ (self._free.T @ columns))

    def scores(self, residuals: Floats) -> Floats:
        """Sums of squares explained, shape (families, columns of residuals), of unit variance."""
        return np.array([np.sum((a.T @ residuals) ** 2, axis=0) for a in self.axes])

    def log_odds(self, scores: Floats) -> Floats:
        """Bayes factor of an amplitude fitted against none, shape as scores."""
        m = np.maximum(self.ranks, 1)[:, None]
        ratio = np.maximum(scores / m, 1.0)
        return np.asarray(0.5 * m * (ratio - 1 - np.log(ratio)) * (self.ranks[:, None] > 0))


def _by_columns(families: Sequence[Component]) -> Iterator[list[Component]]:
    """Families one after another that depend on the same: one whitening for all of them."""
    return (list(group) for _, group in groupby(families, lambda family: family.columns))


def _axes(seen: Floats) -> Floats:
    """Orthonormal axes of what columns span; a pattern that the refit takes away is no pattern."""
    size, vectors = eigen(seen.T @ seen)
    strong = size > max(1e-3 * float(size.sum()) / max(len(size), 1), 1e-300)
    return np.asarray(seen @ (vectors[:, strong] / np.sqrt(size[strong])))


# --- a lack of fit as a rival -------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class LackOfFit:
    """Something real without a name, on top of a hypothesis.

    base: the effects of the hypothesis; columns: what the pattern depends on; amplitude: in
    standard uncertainties of a reading.
    """

    base: Names
    columns: Names
    log_evidence: float
    amplitude: float
    noise: Noise
    problem: Patterned = field(repr=False)

    @property
    def fitted_arcsec(self) -> Floats:
        """What it amounts to at every reading, shape (n,)."""
        return self.problem.fitted(self.amplitude, self.noise)

    @property
    def explained_arcsec(self) -> float:
        """Root mean square of what the readings lose without it, all else refitted: an unknown may
        cancel a part of the pattern."""
        with_it = self.problem.residual(self.amplitude, self.noise)
        without = self.problem.residual(None, self.noise)
        return math.sqrt(float(np.mean((without - with_it) ** 2)))

    @property
    def free_numbers(self) -> float:
        """How many free numbers its patterns amount to: the readings' share in what is known of
        each (effective number of parameters)."""
        c = self.problem.fitter.campaign
        first = len(self.problem.precision)
        seen = Whitener.of(self.noise, c.u_arcsec, c.rows)(self.problem.columns[:, first:])
        size = np.linalg.svd(seen, compute_uv=False) ** 2
        prior = self.problem.prior(self.amplitude)[first]
        return float(np.sum(size / (size + prior)))


@dataclass(frozen=True, eq=False)
class Patterned:
    """A linear problem whose last columns are basis functions, behind the unknowns; arcsec."""

    fitter: Fitter
    y: Floats
    columns: Floats
    precision: Floats
    start: Noise

    def prior(self, amplitude: float) -> Floats:
        """Precisions of all columns, the patterns being of an amplitude."""
        patterns = self.columns.shape[1] - len(self.precision)
        u = float(np.median(self.fitter.campaign.u_arcsec))
        own = np.full(patterns, (amplitude * u) ** -2.0)
        return np.concatenate([self.precision, own])

    def rated(self, amplitude: float, structures: bool = False) -> tuple[float, Noise]:
        """Log evidence, and the noise that suits it."""
        c = self.fitter.campaign
        noise, value = fit_noise(
            Linear(self.y, self.columns, self.prior(amplitude)),
            c.u_arcsec,
            c.rows,
            self.start,
            self.fitter.stated_dof,
            structures,
        )
        return value, noise

    def mode(self, amplitude: float, noise: Noise) -> Floats:
        """Most probable values of all columns."""
        c = self.fitter.campaign
        whitener = Whitener.of(noise, c.u_arcsec, c.rows)
        y, x = whitener(self.y), whitener(self.columns)
        return np.asarray(Margin.of(y, x, self.prior(amplitude)).mode)

    def fitted(self, amplitude: float, noise: Noise) -> Floats:
        """What the patterns amount to at every reading."""
        first = len(self.precision)
        return np.asarray(self.columns[:, first:] @ self.mode(amplitude, noise)[first:])

    def residual(self, amplitude: float | None, noise: Noise) -> Floats:
        """Readings less everything, where patterns have an amplitude; else less the unknowns."""
        if amplitude is not None:
            return np.asarray(self.y - self.columns @ self.mode(amplitude, noise))
        c = self.fitter.campaign
        whitener = Whitener.of(noise, c.u_arcsec, c.rows)
        unknowns = self.columns[:, : len(self.precision)]
        margin = Margin.of(whitener(self.y), whitener(unknowns), self.precision)
        return np.asarray(self.y - unknowns @ margin.mode)


def lacks_of_fit_on(
    fitter: Fitter, fit: Fit, families: Sequence[Component], noise: Noise, least: float = 1.0
) -> Iterator[LackOfFit]:
    """The families that stand out most, each with the amplitude and noise that suit it; those whose
    log odds are more than `least`.

    Looked at through two noises: that of the fit, which may have taken the pattern for noise, and
    `noise`, as a fit sees it that can follow the whole library.
    """
    start = replace(noise, inflation=fit.noise.inflation)
    tried: dict[int, Component] = {}
    for seen in (fit, fitter.look(fit, start)):
        structure = Structure(families, seen.whitener, seen.margin)
        if not structure.families:
            continue
        scores = structure.scores(structure.projected(seen.margin.y)[:, None])
        shares = np.log([f.share for f in structure.families])
        odds = structure.log_odds(scores)[:, 0] + shares
        # Of the forms that depend on the same, the likeliest, and the smooth one.
        foremost: dict[tuple[Names, bool], int] = {}
        for i in ranked(odds.tolist()):
            foremost.setdefault((structure.families[i].columns, structure.families[i].smooth), i)
        for i in list(foremost.values())[: _LIMITS.families]:
            if odds[i] > least:
                tried[i] = structure.families[i]
    y, x, precision = fitter.linear(fit)
    for family in tried.values():
        patterns = family.patterns - family.patterns.mean(axis=0)
        problem = Patterned(fitter, y, np.column_stack([x, patterns]), precision, start)
        ratings = [(problem.rated(a)[0], a) for a in _LIMITS.amplitudes]
        amplitude = max(ratings)[1]
        value, suited = problem.rated(amplitude, structures=True)
        # Every amplitude is as likely: the mean over them, not the largest.
        values = np.array([v for v, _ in ratings])
        value += float(np.log(np.mean(np.exp(values - values.max())))) + fit.log_size_prior
        names = fit.hypothesis.effects
        value += float(np.log(family.share))
        yield LackOfFit(names, family.columns, value, amplitude, suited, problem)


def says_no_more(lack_of_fit: LackOfFit, fit: Fit) -> bool:
    """Whether effects with names follow the readings as well, and could follow any such one.

    At two or three input angles an offset of a centre is any function of the angle: a lack of fit
    with no more freedom than the sizes of the effects is no reason to call the effects unknown.
    """
    sizes = sum(u.size_of >= 0 for u in fit.unknowns)
    problem = lack_of_fit.problem
    patterns = problem.columns[:, len(problem.precision) :]
    if (
        not set(lack_of_fit.base) < set(fit.hypothesis.effects)
        or fit.discrepancy_sd > DISCREPANCY_ODDS[1][0]
    ):
        return False
    if np.linalg.matrix_rank(patterns) > sizes:
        return False
    c = problem.fitter.campaign
    whitener = Whitener.of(lack_of_fit.noise, c.u_arcsec, c.rows)
    prior = problem.prior(lack_of_fit.amplitude)
    free = Margin.of(whitener(problem.y), whitener(problem.columns), prior).chi2
    return bool(
        problem.fitter.look(fit, lack_of_fit.noise).margin.chi2 - free < 2 * RULES.log_rival_odds
    )


def held_out_with_lack_of_fit(lack_of_fit: LackOfFit, fold: NDArray[np.int64]) -> Floats:
    """Readings less what the other folds predict of them with it, arcsec, shape (n,)."""
    p = lack_of_fit.problem
    precision = p.prior(lack_of_fit.amplitude)
    linear = Linear(p.y, p.columns, precision)
    return held_out_by(p.fitter.campaign, linear, lack_of_fit.noise, fold)
