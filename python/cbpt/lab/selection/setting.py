"""What all hypotheses of one competition share: the readings, their noise, the library, prior odds.

Setting     the shared part, frozen
prepare     a first fit of the drive as stated, readings that scatter more, noises
prior       log prior odds of a set of effects
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.covariance.artefacts import (
    Artefact,
    encoders,
    first_readings,
    gains_of,
    random_walk,
    walks_by_order,
)
from cbpt.lab.covariance.fit_noise import fit_noise, price_of
from cbpt.lab.covariance.linear_gaussian import Linear, Margin, Noise, Whitener
from cbpt.lab.covariance.outliers import inflation_of
from cbpt.lab.covariance.symmetric import eigen
from cbpt.lab.inference.crew import both
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.inference.fit import Fitter
from cbpt.lab.inference.hypothesis import Hypothesis
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.priors import ODDS, Variant
from cbpt.lab.readings.set_points import levels_of
from cbpt.lab.selection.lack_of_fit import Component, components
from cbpt.lab.selection.linear_screen import Signature, Signatures, Stack
from cbpt.lab.selection.starts import places

Floats = NDArray[np.float64]
_TORQUE_SHARES = (0.7, 1.4, 2.8)
"""Of the uncertainty of a reading that the noise of the torque may be."""
_ARTEFACT_SIZES = (1.0, 2.0, 4.0, 8.0, 16.0)
"""The same of an artefact."""
_SCREENED = 2000
"""Readings by which artefacts are looked for."""
Names = tuple[str, ...]
"""A set of effects by their ids, sorted; empty: the drive as stated."""


def prior(names: Names) -> float:
    """Log prior odds of a set of effects against nothing."""
    return float(sum(np.log(ODDS.get(n, ODDS[""])) for n in names))


@dataclass(frozen=True, eq=False)
class Setting:
    """What all hypotheses of one competition share."""

    fitter: Fitter
    null: Fit
    """The drive as stated, with its own noise."""
    plain: Noise
    """White noise of the stated size, of the kind that `null` has."""
    flexible: Noise
    """The noise as a fit sees it that may follow the whole library."""
    noises: tuple[Noise, ...]
    """Both of these, and the same of every other kind of noise that the readings may have: an
    effect may hide in what seems to scatter."""
    library: Signatures = field(repr=False)
    names: dict[int, tuple[str, str]] = field(repr=False)
    """(effect, parameter) of each value of the model."""
    families: tuple[Component, ...] = field(repr=False)
    """Families of basis functions by which a lack of fit is found."""
    signatures: list[Signature] = field(repr=False)
    """Of the library, about the drive as stated."""
    wider: Stack = field(repr=False)
    """The same, and behind them those of finite sizes that only single effects are tried with."""
    variants: Mapping[str, float] = field(repr=False)
    """By effect: how many variants it has, rarer ones by their odds."""
    variant_price: Mapping[str, float] = field(default_factory=dict, repr=False)
    """By label: log of how much a variant exceeds the mean evidence of its effect where it is the
    best of them."""

    def weights(self, stack: Stack) -> Floats:
        """Log prior odds of the variant of each signature."""
        of_one = {e: prior((e,)) - np.log(count) for e, count in self.variants.items()}
        return np.array([of_one[s.variant.effect] for s in stack.signatures])

    def price(self, fit: Fit) -> float:
        """Log price of having chosen the best of several variants of each effect."""
        variants = fit.hypothesis.variants
        return float(sum(self.variant_price.get(v.label, 0.0) for v in variants))

    def score(self, fit: Fit) -> float:
        """Log of evidence times prior odds."""
        names = fit.hypothesis.effects
        return fit.log_evidence + prior(names) - self.price(fit)


def prepare(fitter: Fitter) -> Setting:
    """The setting of a competition. The model must have a solution at every row."""
    campaign = fitter.campaign
    first = fitter.fit(Hypothesis(), free_noise=False)
    if first is None:
        raise ValueError("the model has no solution at some rows: remove these rows first")
    names = places(fitter)
    families = components(campaign.readings)
    if campaign.torque_scatter_Nm:
        # Ramps that are alike have their torques by the time since they began, and what scatters
        # about them is a function of that time and of the torques that were read; so are the rates
        # of these.
        of_scatter = {"run_time_s", "torque_rate"}
        families = tuple(f for f in families if not of_scatter.intersection(f.columns))
    library = Signatures(campaign, fitter.variants)
    signatures = library.about(first, names)
    (nulls, flexibles), far = both(
        campaign,
        partial(_nulls, fitter, first, signatures, families),
        partial(library.far, first, names),
    )
    null = nulls[0]
    bare = plain(null.noise)
    flexible = flexibles[0]
    # Behind the others, so that a number means the same in both lists.
    wider = Stack(signatures + far)
    return Setting(
        fitter=fitter,
        null=null,
        plain=bare,
        flexible=flexible,
        noises=tuple(n for f, g in zip(nulls, flexibles, strict=True) for n in (f.noise, g)),
        library=library,
        names=names,
        families=families,
        signatures=signatures,
        wider=wider,
        variants=_counted(fitter.variants),
    )


def _nulls(
    fitter: Fitter, first: Fit, signatures: list[Signature], families: tuple[Component, ...]
) -> tuple[list[Fit], list[Noise]]:
    """The drive without an effect under each kind of noise, the most probable first, and the noise
    of each as all that the library may show leaves it."""
    plain_noise = fitter.campaign.plain_noise
    kinds = [plain_noise]
    kinds += [
        replace(plain_noise, inflation=inflation)
        for inflation in _inflations(fitter, first, signatures, families)
    ]
    whole = _whole(fitter, signatures)
    freely = _flexible_fit(fitter, first, whole, plain_noise)
    kinds += _of_the_torque(fitter, first, whole, freely)
    kinds += _of_the_instrument(fitter, first, whole, freely)
    nulls = [fit for kind in kinds if (fit := fitter.fit(Hypothesis(), noise=kind)) is not None]
    nulls.sort(key=lambda fit: -fit.log_evidence)
    return nulls, [_flexible_noise(fitter, fit, whole) for fit in nulls]


def _inflations(
    fitter: Fitter, fit: Fit, signatures: list[Signature], families: tuple[Component, ...]
) -> Iterator[Floats]:
    """Inflation factors of the readings' standard deviations where they do not scatter alike: as
    all that the library and the table may show leaves them, and as the drive alone does. A reading
    at the end of a loop is followed by a curve that nothing else demands."""
    c = fitter.campaign
    if len(c) < 12:
        return
    numbers = fit.point.slopes * np.array([u.unit for u in fit.unknowns])
    seen = [np.where(np.isfinite(s.columns), s.columns, 0.0) for s in signatures]
    y = c.y_arcsec - fit.point.angle_arcsec
    whitener = Whitener.of(c.plain_noise, c.u_arcsec, c.rows)
    found: list[Floats] = []
    wide = [numbers, *seen, *(f.patterns for f in families if f.whole)]
    of = partial(inflation_of, y, c.offsets, whitener=whitener)
    for inflation in both(c, partial(of, fields=wide), partial(of, fields=[numbers])):
        if inflation is None or _of_one_place(c, inflation > 1.5):
            continue
        if not any(np.allclose(inflation, other) for other in found):
            found.append(inflation)
            yield inflation


def _of_one_place(campaign: Campaign, loose: NDArray[np.bool_]) -> bool:
    """Whether loose readings sit together where chance would not put them: that is no noise."""
    r, count = campaign.readings, int(np.count_nonzero(loose))
    if count < 3:
        return False
    size = np.abs(r.torque_Nm)
    places = [
        r.run_index,
        np.round(np.mod(r.input_angle_deg, 360.0), 3),
        size > np.quantile(size, 0.6),
    ]
    if r.preload_N is not None:
        places.append(levels_of(r.preload_N).index)
    for place in places:
        values, index = np.unique(place, return_inverse=True)
        inside = np.bincount(index[loose], minlength=len(values))
        at = int(np.argmax(inside))
        share = float(np.mean(index == at))
        if (
            len(values) > 1
            and inside[at] >= 0.9 * count
            and share ** inside[at] * len(values) < 3e-4
        ):
            return True
    return False


def _of_the_torque(
    fitter: Fitter, fit: Fit, whole: _Whole, freely: tuple[Noise, float]
) -> list[Noise]:
    """Noise of the torque readings, where a fit that may follow the whole library scatters that
    way; none else. freely: such a fit under plain noise."""
    slope = _slope(fit, np.abs(fitter.campaign.readings.torque_Nm))
    if slope is None:
        return []
    noise, value = freely
    typical = float(np.median(fitter.campaign.u_arcsec))
    found = []
    for share in _TORQUE_SHARES:
        own = slope * (share * typical / float(np.quantile(slope, 0.9)))
        found.append(
            _flexible_fit(
                fitter, fit, whole, replace(noise, torque_arcsec=own), bool(noise.numbers)
            )
        )
    best, of_best = max(found, key=lambda f: f[1])
    return [plain(best)] if of_best > value else []


def _of_the_instrument(
    fitter: Fitter, fit: Fit, whole: _Whole, freely: tuple[Noise, float]
) -> list[Noise]:
    """Artefacts of the instrument, each where a fit that may follow the whole library gains by
    it. freely: such a fit under plain noise."""
    if fitter.campaign.drive.kind == "torsion_spring":
        # Beside a loop of play and friction still to be explained nothing is told of it; once the
        # loop is explained it is asked for.
        return []
    noise, value = freely
    found = []
    for kind in with_an_artefact(fitter, fit, noise, whole.columns):
        fitted, of_fitted = _flexible_fit(fitter, fit, whole, kind, bool(noise.numbers))
        if of_fitted > value:
            found.append(plain(fitted))
    return found


def with_an_artefact(
    fitter: Fitter, fit: Fit, noise: Noise, columns: Floats | None = None
) -> Iterator[Noise]:
    """A noise with each artefact of the instrument that gains more than it costs, about a fit, of
    the size that gains most. columns: what else is free, of length 1 in stated uncertainties."""
    c = fitter.campaign
    if noise.has_artefact:
        return
    y, x, precision = fitter.linear(fit)
    if columns is not None:
        x, precision = (
            np.column_stack([x, columns]),
            np.r_[precision, np.full(columns.shape[1], 1e-4)],
        )
    some = c.rows.thinned(_SCREENED) if len(c) > _SCREENED else np.ones(len(c), dtype=bool)
    whitener = Whitener.of(noise.select(some), c.u_arcsec[some], c.rows.select(some))
    margin = Margin.of(whitener(y[some]), whitener(x[some]), precision)
    sizes = np.array(_ARTEFACT_SIZES) * float(np.median(c.u_arcsec))
    for alike in _artefacts(c, fit):
        seen = whitener(np.column_stack([one.columns_arcsec[some] for one in alike]))
        left, end, found = margin.left(seen), 0, []
        for artefact in alike:
            own = slice(end, end := end + artefact.columns_arcsec.shape[1])
            gains = gains_of(seen[:, own].T @ left[:, own], left[:, own].T @ margin.y, sizes)
            best = int(np.argmax(gains))
            found.append((float(gains[best]), artefact.sized(sizes[best])))
        gain, sized = max(found, key=lambda f: f[0])
        kind = replace(noise, artefact=sized.beside(noise.artefact))
        if gain > price_of(kind) - price_of(noise):
            yield kind


def _artefacts(campaign: Campaign, fit: Fit) -> Iterator[list[Artefact]]:
    """Those that the columns of a table can show, and of those that differ by a period alone all;
    without times a zero wanders from reading to reading."""
    time_s = campaign.readings.time_s
    if time_s is None:
        # No time, no `drift`: a steady one is a straight walk.
        yield walks_by_order(np.arange(float(len(campaign))))
    elif (walk := random_walk(time_s)) is not None:
        yield [walk]
    for first in first_readings(campaign.rows.before):
        yield [first]
    read, typical = campaign.y_arcsec, float(np.median(campaign.u_arcsec))
    if periods := encoders(read, read - fit.residual_arcsec, typical):
        yield periods


def _slope(fit: Fit, size: Floats) -> Floats | None:
    """How fast the angle of each reading changes with its torque (of these sizes), arcsec/(N m)."""
    gains = [i for i, u in enumerate(fit.unknowns) if u.name == "torque_scale"]
    if not gains:
        return None
    loaded = size > 0.05 * size.max()
    slope = np.abs(fit.point.slopes[:, gains[0]]) / np.where(loaded, size, np.inf)
    # Without torque a gain shows nothing; the slope there is that of small torques.
    small = loaded & (size <= np.quantile(size[loaded], 0.3))
    return np.where(loaded, slope, np.median(slope[small]))


def plain(noise: Noise) -> Noise:
    """A noise without what is fitted of it."""
    return replace(noise, scale=1.0, correlation=0.0, offset_arcsec=0.0)


@dataclass(frozen=True, eq=False)
class _Whole:
    """The whole library as columns that are free in a fit."""

    columns: Floats
    """Orthogonal in stated uncertainties, (n, m); arcsec."""
    count: int
    """How many there were before."""


def _whole(fitter: Fitter, signatures: list[Signature]) -> _Whole:
    """Each column of length 1 in stated uncertainties, and then turned: many signatures look alike,
    and what all leave out is seen by none."""
    u = fitter.campaign.u_arcsec[:, None]
    columns = np.column_stack([s.columns for s in signatures])
    columns = columns[:, np.isfinite(columns).all(axis=0)] / u
    length = np.linalg.norm(columns, axis=0)
    columns = columns[:, length > 1e-9] / length[length > 1e-9]
    square, axes = eigen(columns.T @ columns)
    return _Whole(u * (columns @ axes[:, square > 1e-12]), columns.shape[1])


def _flexible_noise(fitter: Fitter, fit: Fit, whole: _Whole) -> Noise:
    """The noise as seen by a fit that may follow the whole library."""
    c = fitter.campaign
    noise, _ = _flexible_fit(fitter, fit, whole, plain(fit.noise))
    # What so many free columns take from the scatter by chance is given back.
    square = np.square(whole.columns / c.u_arcsec[:, None]).sum(axis=0)
    taken = float(np.sum(square / (square + 1e-2)))
    return replace(noise, scale=noise.scale * np.sqrt(len(c) / max(len(c) - taken, 1.0)))


def _flexible_fit(
    fitter: Fitter, fit: Fit, whole: _Whole, start: Noise, structures: bool = True
) -> tuple[Noise, float]:
    """The noise that suits a fit which may follow the whole library, and its log likelihood."""
    c = fitter.campaign
    y, x, precision = fitter.linear(fit)
    # Each signature may be as strong as a hundred standard deviations of the whole table.
    free = np.full(whole.columns.shape[1], 1e-4)
    linear = Linear(y, np.column_stack([x, whole.columns]), np.r_[precision, free])
    enough = len(c) > 3 * whole.count
    return fit_noise(linear, c.u_arcsec, c.rows, start, fitter.stated_dof, structures and enough)


def _counted(variants: Iterable[Variant]) -> dict[str, float]:
    """By effect."""
    found: dict[str, float] = {}
    for v in variants:
        found[v.effect] = found.get(v.effect, 0.0) + v.odds
    return found
