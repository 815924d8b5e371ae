"""Which effect is missing: the whole way from readings to an answer.

    diagnose    a case and its readings -> Diagnosis

Steps: readings at which the model has no solution are set aside and told; everything competes
(`competition`); the odds become words (`verdict`); the answer is dressed with where the model
fails, how the error falls in sample and on what was held back, and what the readings could have
shown (`answer`).
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cbpt._core import Case, Drive, OwnEffect
from cbpt.errors import InvalidInputError, ReadingsError
from cbpt.lab.covariance.loose_runs import loose_runs
from cbpt.lab.covariance.one_thread import one_blas_thread
from cbpt.lab.covariance.repeatability import no_uncertainty_of, pooled
from cbpt.lab.covariance.repeated_runs import kinds_of_runs, most_correlation
from cbpt.lab.covariance.within_run import estimate
from cbpt.lab.diagnosis.diagnosis import Diagnosis
from cbpt.lab.diagnosis.diagnosis_data import Rung, finished, noises_of
from cbpt.lab.diagnosis.fit_text import (
    at_limits,
    beyond_likely,
    beyond_own_loops,
    moved_by,
    solutions,
)
from cbpt.lab.diagnosis.held_angle import held_angle
from cbpt.lab.diagnosis.held_torque import held_torque
from cbpt.lab.diagnosis.ramped_torque import ramped_torque
from cbpt.lab.diagnosis.rarer import by_prior_odds_alone, of_a_torque_sensor
from cbpt.lab.diagnosis.rungs import rung_of, rung_of_lack_of_fit
from cbpt.lab.diagnosis.torque_scatter import with_torque_scatter
from cbpt.lab.inference.closing import closed
from cbpt.lab.inference.cross_validation import folds
from cbpt.lab.inference.evidence import Fit
from cbpt.lab.model.dataset import Campaign
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.own_terms import campaign_of, chosen
from cbpt.lab.model.priors import PRIORS
from cbpt.lab.preflight.units import input_side
from cbpt.lab.readings.inputs import case_and_readings
from cbpt.lab.readings.reader import Readings
from cbpt.lab.readings.unit_check import slips
from cbpt.lab.selection.competition import Competition, Progress
from cbpt.lab.selection.decision import Verdict, judge, withheld
from cbpt.lab.selection.history import with_its_history
from cbpt.lab.selection.model_comparison import compete
from cbpt.lab.selection.rules import RULES
from cbpt.lab.selection.setting import Names
from cbpt.lab.wording.names import number_called
from cbpt.lab.wording.numbers import listed
from cbpt.results import solve_many

__all__ = ["diagnose"]

Floats = NDArray[np.float64]

FEWEST = 6
MOST = 1200
_OF_A_TURN = 5
"""Readings that stay on each side of a turn between readings, where others are left out."""
# N cm, N mm, kN m, kgf, lbf in, lbf: what loads are at times written in.
_LOAD_FACTORS = (0.01, 100.0, 1e-3, 1e3, 9.80665, 1 / 9.80665, 0.1129848, 4.448222)


@dataclass(frozen=True)
class _OtherUnit:
    """When loads in another unit are asked about."""

    agrees: float = 0.05
    """Share of the squared misfit below which readings agree with them; an effect that is missing
    may leave as much."""
    gains: tuple[float, float] = (0.34, 2.9)
    """On the angles, by a stiffness of the contacts that is likely, a fifth of what is stated to
    five times as much: angles go with its power -2/3."""
    better: float = 4.0
    """How many times less they have to leave than such a stiffness."""


_OTHER_UNIT = _OtherUnit()


def diagnose(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, object],
    data: Readings | str | os.PathLike[str] | Mapping[str, ArrayLike],
    *,
    effects: Sequence[str | OwnEffect] = (),
    columns: Mapping[str, str] | None = None,
    sheet: str | None = None,
    only: Mapping[str, object] | None = None,
    seed: int = 0,
    progress: Progress | None = None,
) -> Diagnosis:
    """Say which effect the readings demand, that none is needed, or that they cannot tell.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The drive, as in `compare`.
    data : Readings, str, PathLike, mapping or data frame
        The table of readings, as `read_readings` takes it.
    effects : sequence of str or OwnEffect
        Own effects that compete with the library: from `cbpt.effects`, or ids of own effects of the
        case, which are then fitted anew.
    columns : mapping of str to str, optional
        What headers of the table mean, as in `read_readings`.
    sheet : str, optional
        Sheet of a workbook, struct of a MATLAB file or group of a TDMS file.
    only : mapping, optional
        The readings to take, for example ``{"preload_step": 3}``.
    seed : int
        Seed of the simulated p-values. The same seed gives the same answer.
    progress : callable, optional
        Called as ``progress(what_is_next, share_done)``. What it raises ends the work.

    Returns
    -------
    Diagnosis
        The verdict, and everything it rests on.

    Raises
    ------
    CaseError, ReadingsError
        The case or the table cannot be read, or there are too few readings to judge.
    InvalidInputError
        An own effect cannot be fitted.

    Notes
    -----
    The method and its sources are on the page *Diagnosis* of the documentation.
    """
    case, readings = case_and_readings(case, data, columns, sheet, only)
    with one_blas_thread():
        return diagnosed(case, readings, seed, _own(case, effects), progress)


def _own(case: Case | Drive, effects: Sequence[str | OwnEffect]) -> list[OwnEffect]:
    ids, own = chosen(case, effects)
    for other in set(ids) - {effect.id for effect in own}:
        raise InvalidInputError(
            f"effect {other!r}: the case has no own effect with this id; give ids of own effects "
            "only. What a diagnosis compares of the library is fixed; `fit` takes any effect"
        )
    return own


def diagnosed(
    case: Case | Drive,
    readings: Readings,
    seed: int,
    own: Sequence[OwnEffect] = (),
    progress: Progress | None = None,
) -> Diagnosis:
    """The diagnosis of readings that are already read."""
    campaign, notes = prepared(campaign_of(case, readings, own))
    campaign, told = with_its_history(campaign)
    return judged(case, campaign, seed, [*notes, *told], progress)


def judged(
    case: Case | Drive,
    campaign: Campaign,
    seed: int,
    noted: Sequence[str],
    progress: Progress | None = None,
) -> Diagnosis:
    """The diagnosis of readings of which it is known what can be judged, and their history."""
    notes = list(noted)
    rng = np.random.default_rng(seed)
    competition = compete(campaign, rng, progress)
    verdict = judge(competition)
    if input_side(campaign.readings, campaign.drive):
        verdict = withheld(competition, "input side")
    fold, held_by = folds(campaign)
    fits = competition.fits
    fits[verdict.names] = closed(competition.fitter, fits[verdict.names])
    notes += _notes(campaign, fits[verdict.names])
    notes += by_prior_odds_alone(competition, verdict)
    notes += of_a_torque_sensor(competition, verdict)
    nominal = competition.fitter.at_nominal(fits[verdict.names])
    ladder = tuple(_ladder(competition, verdict, nominal, fold))
    if progress:
        progress("the answer", 1.0)
    return Diagnosis(
        case=case,
        readings=campaign.readings,
        competition=competition,
        verdict=verdict,
        before=nominal,
        after=fits[verdict.names],
        ladder=ladder,
        reached=1 + len(path(verdict.names, fits)),
        held_out_by=held_by,
        fold=fold,
        notes=tuple(notes),
        seed=seed,
    )


def _notes(campaign: Campaign, fit: Fit) -> Iterator[str]:
    """What a reader should know of the fit behind the answer."""
    offset = float(np.abs(fit.offsets_arcsec).max()) if campaign.offsets.shape[1] == 1 else 0.0
    if offset > 5 * float(np.median(campaign.u_arcsec)):
        yield f"a common offset of {fit.offsets_arcsec[0]:.3g} arcsec was subtracted"
    if fit.noise.inflation is not None:
        lines = campaign.readings.line[fit.noise.inflation > RULES.far_reading].tolist()
        if 0 < len(lines) <= 0.05 * len(campaign):
            shown = ", ".join(map(str, lines[:8]))
            yield f"{len(lines)} readings are outliers and were given less weight: lines {shown}"
    yield from map(str, solutions(fit))
    yield from beyond_own_loops(campaign, fit)
    yield from at_limits(campaign, fit)
    yield from beyond_likely(fit)
    for u in fit.unknowns:
        value = fit.value(u)
        at_end = value <= u.lower * (1 + 1e-6) or value >= u.upper * (1 - 1e-6)
        number = u.name.partition(".")[0]
        if at_end and number in PRIORS:
            yield (
                f"the fit moves {number_called(number, campaign.drive.kind)} by "
                f"{moved_by(u.name, fit)}, to the limit of its plausible range: check that the "
                "case file is that of this drive"
            )


def _ladder(
    competition: Competition, verdict: Verdict, nominal: Fit, fold: NDArray[np.int64]
) -> Iterator[Rung]:
    """From the drive as stated to the answer, and one step further."""
    fitter, fits, names = competition.fitter, competition.fits, verdict.names
    # One noise judges every rung: a fit without the effect may take the effect for noise.
    lack_of_fit, noises = verdict.lack_of_fit, noises_of(competition, verdict)

    def seen(added: str, fit: Fit, names: Names) -> Rung:
        noise = noises.of(names)
        return rung_of(fitter, added, fitter.look(finished(fitter, fit, noise), noise), fold)

    yield seen("", nominal, ())
    yield seen("parameters refitted", fits[()], ())
    for reached, added in path(names, fits):
        yield seen(added, fits[reached], reached)
    further = _one_more(competition, names)
    if lack_of_fit is not None:
        yield rung_of_lack_of_fit(lack_of_fit, fold)
    elif further:
        added = next(iter(set(further) - set(names)))
        yield seen(added, fits[further], further)


def prepared(campaign: Campaign) -> tuple[Campaign, list[str]]:
    """Readings that can be judged, and what was set aside. Raises `ReadingsError` where too few
    are left.
    """
    notes = list(campaign.readings.notes)
    steps = campaign.readings.preload_step
    if steps is not None and len(np.unique(steps)) > 1:
        notes.append(
            f"{len(np.unique(steps))} preload steps are fitted together, with the same parameters; "
            "--by preload_step (diagnose_by) diagnoses each step separately, and cbpt change --by "
            "preload_step (change) says what differs between them"
        )
    campaign, told = held_angle(campaign)
    notes += told
    n = len(campaign)
    if n > MOST:
        campaign = campaign.select(campaign.rows.thinned(MOST) | _beside_turns(campaign))
        notes.append(f"{len(campaign)} of {n} readings, evenly spread, were used for the diagnosis")
    model = _as_given(campaign)
    solved = np.isfinite(model)
    if not solved.all():
        lines = campaign.readings.line[~solved]
        shown = ", ".join(map(str, lines[:8].tolist())) + (", ..." if len(lines) > 8 else "")
        notes.append(
            f"{len(lines)} readings were left out because the model has no solution there (the "
            "preload does not hold the torque, see cbpt compare): lines " + shown
        )
        if solved.any():
            campaign, model = campaign.select(solved), model[solved]
    _stop_if_too_little(campaign, len(solved), int(np.count_nonzero(solved)))
    _stop_if_a_slip(campaign, model)
    _stop_if_it_does_not_follow(campaign, model)
    campaign, told = held_torque(campaign, _as_given)
    if not told and campaign.drive.kind == "ball_drive":
        campaign, told = ramped_torque(campaign, _as_given)
    if told:
        model = _as_given(campaign)
    notes += told
    campaign, told = _uncertain(campaign, model)
    notes += told
    notes += _between_points(campaign)
    campaign, told = _with_loose_runs(campaign, model)
    notes += told
    if campaign.step_arcsec:
        notes.append(
            f"the angle is recorded in steps of {campaign.step_arcsec:g} arcsec, which is coarse "
            "compared with its uncertainty; readings at the same load round to the same value, so "
            "averaging them gains little"
        )
        stated = campaign.readings.u_elastic_angle_arcsec
        if stated is not None and (campaign.u_reading_arcsec > stated).any():
            notes.append(
                "the stated uncertainty is smaller than the rounding error (step / sqrt(12) = "
                f"{campaign.step_arcsec / 12**0.5:.3g} arcsec), which was added to it"
            )
    if not campaign.u_stated and not campaign.u_repeated:
        why = no_uncertainty_of(campaign.repeats)
        notes.append(
            f"no uncertainty is stated and {why}, so the uncertainty was estimated from the "
            "scatter; an error of the model that is as small as this scatter cannot be detected"
        )
    return campaign, notes


def _beside_turns(campaign: Campaign) -> NDArray[np.bool_]:
    """Readings of the ramps on both sides of turns between readings, which only they show."""
    order, near = campaign.rows.order, np.zeros(len(campaign), dtype=bool)
    turns = np.isin(order, Assembled(campaign, ()).turns_between_readings)
    for place in np.flatnonzero(turns):
        near[order[max(place - _OF_A_TURN, 0) : place + _OF_A_TURN + 1]] = True
    return near


def _between_points(campaign: Campaign) -> list[str]:
    """What the points of the case's table leave open, where that is as much as readings scatter by
    or more."""
    if campaign.curve_errors is None:
        return []
    largest = float(np.linalg.norm(campaign.curve_errors.columns_arcsec, axis=1).max())
    if largest < float(np.median(campaign.u_arcsec)):
        return []
    return [
        "the points of the case leave the curve between and beyond them open by up to "
        f"{largest:.3g} arcsec (what other curves through them differ by), which counts as noise; "
        "more points in the case, up to the largest torque, make it certain"
    ]


def _uncertain(campaign: Campaign, model: Floats) -> tuple[Campaign, list[str]]:
    """What readings scatter by, from all that tells it, and what is to be said of that."""
    notes = list[str]()
    # The mean torques of holds and ramps scatter no more.
    smooth = campaign.held is not None or campaign.torque_errors is not None
    if campaign.u_stated and not smooth:
        campaign, notes = with_torque_scatter(campaign)
    campaign, told = _believed(campaign, model)
    campaign = _repeated(campaign, model)
    if campaign.u_stated or campaign.drive.kind != "torsion_spring":
        return campaign, notes + told
    if not campaign.u_repeated:
        campaign = _of_the_scatter(campaign, model)
    return (campaign, []) if smooth else with_torque_scatter(campaign)


def _with_loose_runs(campaign: Campaign, model: Floats) -> tuple[Campaign, list[str]]:
    """The campaign with a larger uncertainty for runs that scatter more than the others."""
    if campaign.torque_scatter_Nm or campaign.step_arcsec:
        return campaign, []
    weighted = (campaign.y_arcsec - model) / campaign.u_arcsec
    factor = loose_runs(campaign.readings, weighted)
    _, first = np.unique(campaign.readings.run_index, return_index=True)
    loose = [i for i in first if factor[i] > 1]
    if not loose:
        return campaign, []
    told = listed([f"{campaign.readings.run[i]} ({factor[i]:.2g} times as much)" for i in loose])
    scatter = f"run {told} scatters" if len(loose) == 1 else f"the runs {told} scatter"
    note = f"{scatter} more than the others; the uncertainty of these readings was taken larger"
    return replace(campaign, u_arcsec=campaign.u_arcsec * factor), [note]


def _stop_if_too_little(campaign: Campaign, n: int, solved: int) -> None:
    source, r = campaign.readings.source, campaign.readings
    if solved < FEWEST or 2 * solved < n:
        if n > solved:
            raise ReadingsError.of_column(
                source,
                "torque",
                f"torques that the preload does not hold at {n - solved} of {n} readings",
                f"a solution of the model at half of the readings, and at {FEWEST} or more",
                "check the units of torque and preload, and the drive",
            )
        raise ReadingsError.of_column(
            source,
            "elastic_angle",
            f"{n} readings",
            f"at least {FEWEST}",
            "measure more torques and preloads: any model fits so few readings",
        )
    for column, values, why in (
        ("torque", r.torque_Nm, "vary the torque: a single torque identifies no effect"),
        ("elastic_angle", r.elastic_angle_arcsec, "check the sensor: its angle never changes"),
    ):
        if np.ptp(values) <= 1e-9 * max(float(np.abs(values).max()), 1e-300):
            raise ReadingsError.of_column(
                source, column, f"{values[0]:g} at every reading", "a column that varies", why
            )


def _stop_if_a_slip(campaign: Campaign, model: Floats) -> None:
    """A wrong unit or sign would be diagnosed as an effect."""
    offset = float(np.median(campaign.y_arcsec - model))
    spring = campaign.drive.kind == "torsion_spring"
    rel = campaign.priors.get("contact_stiffness", 0.0) if spring else 0.0
    found = slips(campaign.y_arcsec - offset, model, rel) or slips(campaign.y_arcsec, model, rel)
    if found:
        raise ReadingsError.of_column(
            campaign.readings.source,
            "elastic_angle",
            "; ".join(found),
            "readings of the sign and about the size that the model computes",
            "write the unit in the header, swap the columns, multiply torques of the input side by "
            "the ratio, reverse the sign of the torque or of the angle, or state the stiffness "
            "that the drive has",
        )


def _stop_if_it_does_not_follow(campaign: Campaign, model: Floats) -> None:
    """Loads in a wrong unit, or angles that have nothing to do with the torque."""
    r, rows = campaign.readings, campaign.rows

    def within_runs(values: Floats) -> Floats:
        mean = np.bincount(index, values) / np.bincount(index)
        return np.asarray(values - mean[index])

    index = rows.run_index
    if 4 * np.var(within_runs(model)) < np.var(model):
        # Every run stands at about one load: the angle follows it from run to run.
        index = np.zeros_like(index)
    y, x = within_runs(campaign.y_arcsec), within_runs(model)
    size = float(y @ y)
    if len(campaign) < 12 or not size or not float(x @ x):
        return
    off = float(np.sum((y - x) ** 2))
    found = []
    factors = list(_factors(campaign)) if off > 0.1 * size else []
    for (name, factor), angle in zip(factors, _with_factors(campaign, factors), strict=True):
        if np.isfinite(angle).all():
            found.append((float(np.sum((y - within_runs(angle)) ** 2)), name, factor))
    gain = float(x @ y) / float(x @ x)
    least, most = _OTHER_UNIT.gains
    of_the_drive = float(np.sum((y - gain * x) ** 2)) if least < gain < most else np.inf
    if found and min(found)[0] < min(_OTHER_UNIT.agrees * off, of_the_drive / _OTHER_UNIT.better):
        _, name, factor = min(found)
        what = f"values that agree with the angles only if they are multiplied by {factor:g}"
        expected, remedy = f"the {name} in the unit of its header", "check the unit"
        if factor not in _LOAD_FACTORS:
            what += ", the transmission ratio"
            expected = "the torque of the output side"
            remedy = "multiply torques of the input side by the ratio"
        raise ReadingsError.of_column(r.source, name, what, expected, remedy)
    follows = float(x @ y) ** 2 >= 0.3 * size * float(x @ x)
    if follows and float(x @ y) < 0:
        raise ReadingsError.of_column(
            r.source,
            "elastic_angle",
            "angles that fall where the torque rises",
            "angles of the sign of the torque",
            "reverse the sign of the torque or of the angle",
        )
    if not follows:
        raise ReadingsError.of_column(
            r.source,
            "elastic_angle",
            "angles that do not change with the torque",
            "angles that the model explains at least in part",
            "check which column is the angle, and the case file",
        )


def _with_factors(campaign: Campaign, factors: Sequence[tuple[str, float]]) -> Floats:
    """Angles of the model, arcsec, with torque or preload multiplied by each factor, shape
    (factors, n)."""
    r = campaign.readings
    if not factors:
        return np.zeros((0, len(r)))
    preload = np.zeros(len(r)) if r.preload_N is None else r.preload_N
    loads = {
        column: np.ravel([values * (f if name == column else 1.0) for name, f in factors])
        for column, values in (("torque", r.torque_Nm), ("preload", preload))
    }
    angles = np.tile(r.input_angle_deg, len(factors))
    found = solve_many(campaign.drive, loads["torque"], loads["preload"], angles)
    return found.elastic_angle_arcsec.reshape(len(factors), len(r))


def _factors(campaign: Campaign) -> Iterator[tuple[str, float]]:
    """By what a torque or a preload may be off: units, and for a torque the transmission ratio."""
    for factor in _LOAD_FACTORS:
        yield "torque", factor
        if campaign.readings.preload_N is not None:
            yield "preload", factor
    if campaign.drive.kind == "ball_drive":
        yield "torque", float(campaign.drive.transmission_ratio)


def _believed(campaign: Campaign, model: Floats) -> tuple[Campaign, list[str]]:
    """The stated uncertainty, unless the readings scatter by far more inside their runs."""
    if not campaign.u_stated or campaign.step_arcsec or campaign.torque_scatter_Nm:
        return campaign, []
    u = campaign.u_arcsec
    if float(u.max()) > 1.5 * float(u.min()):
        return campaign, []
    found = estimate(campaign.readings, campaign.y_arcsec - model)
    if found is None or found.ratio is None or found.dof < 30 or found.ratio < 5:
        return campaign, []
    told = (
        f"the readings scatter by {found.u_arcsec:.3g} arcsec within runs, {found.ratio:.3g} times "
        "the stated uncertainty; the scatter was used instead: check the unit of the uncertainty"
    )
    scaled = replace(campaign, u_arcsec=campaign.u_arcsec * found.ratio, u_believed=found.ratio)
    return scaled, [told]


def _repeated(campaign: Campaign, model: Floats) -> Campaign:
    """What repeats say of the noise: its correlation is no larger than theirs, and its size is
    theirs where none is stated."""
    residual = campaign.y_arcsec - model
    found = pooled(campaign.readings, residual, estimate(campaign.readings, residual))
    rows = replace(campaign.rows, most_correlation=most_correlation(campaign.readings, residual))
    campaign = replace(campaign, repeats=found, rows=rows)
    if found is None or not campaign.u_repeated:
        return campaign
    return replace(campaign, u_arcsec=np.full(len(campaign), found.u_arcsec))


def _of_the_scatter(campaign: Campaign, model: Floats) -> Campaign:
    """An uncertainty to start from, of the right size: angles of reducers span many decades; and as
    much more for runs of one kind than for those of another as their repeats say."""
    found = estimate(campaign.readings, campaign.y_arcsec - model)
    if found is None or not found.u_arcsec:
        return campaign
    kinds = kinds_of_runs(campaign.readings, campaign.y_arcsec - model)
    return replace(campaign, u_arcsec=found.u_arcsec * kinds)


def _as_given(campaign: Campaign) -> Floats:
    """The case at every reading, arcsec; NaN where there is no solution."""
    model = Assembled(campaign, [effect for effect, _ in campaign.effects])
    return model.at(model.neutral).angle_arcsec


def path(names: Names, fits: Mapping[Names, Fit]) -> list[tuple[Names, str]]:
    """The sets on the way to `names`, one effect at a time, the one that helps most first."""
    found: list[tuple[Names, str]] = []
    have: Names = ()
    while have != names:
        options = [tuple(sorted((*have, n))) for n in names if n not in have]
        known = [o for o in options if o in fits]
        if not known:
            return [*found, (names, " + ".join(n for n in names if n not in have))]
        best = max(known, key=lambda o: fits[o].log_evidence)
        found.append((best, next(iter(set(best) - set(have)))))
        have = best
    return found


def _one_more(competition: Competition, names: Names) -> Names | None:
    """The best set with one more effect: the step at which the ladder stalls."""
    more = [n for n in competition.fits if set(names) < set(n) and len(n) == len(names) + 1]
    return max(more, key=lambda n: competition.log_odds[n], default=None)
