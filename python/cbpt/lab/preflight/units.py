"""Whether units, sides and signs of a table fit its case, before any model is fitted.

unit_checks   units, sign of the angle, and whether all runs are in the same units

The slope of the table (angle over torque) stands beside that of the case's model, its torques
beside the rated torque, and its preloads beside that of the case and those that hold the torque.
Drives differ from their models by a factor of a few, and so do loads: only more is asked about, and
what explains it is a question, as several slips make the same factor.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive
from cbpt.errors import CbptError
from cbpt.lab.model.forward import Assembled
from cbpt.lab.model.own_terms import campaign_of
from cbpt.lab.preflight.record import Check
from cbpt.lab.readings.readings import Readings
from cbpt.lab.wording.numbers import rounded
from cbpt.lab.wording.phrases import some, span

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Limits:
    """From where another look is due."""

    usual_arcsec: tuple[float, float] = (0.05, 36_000.0)
    """Elastic angles of reducers: beyond it the unit is doubtful."""
    alarm: float = 5.0
    """Between a factor of a few, by which a drive differs from its model, and that of the smallest
    wrong unit (kgf cm for N m, 10)."""
    of_angles: float = 12.0
    """The same between runs, for the angle: its smallest wrong unit (rad for deg) is a factor of
    57, and a play that comes or goes may change what a run turns by several times."""
    explains: float = 3.0
    """A slip explains a factor if it leaves no more than this, a factor of a few."""
    alike: float = 2.0
    """Torques or angles of runs that differ by no more than this factor are alike; a drive with
    friction turns less than in proportion in a small loop, but not a multiple in a like one."""
    follows: float = 0.5
    """Least correlation of angle and torque in a run that tells a slope."""
    varies: float = 0.1
    """Share of the largest range of a torque in a run from which on a run varies its torque."""
    dead: float = 1 / 3
    """Share of what its torque would turn it by, up to which an angle that does not follow is dead;
    and of what other runs turn by, from which on a torque that stays is."""
    answers: int = 3
    """Explanations that are asked about."""


_LIMITS = _Limits()


@dataclass(frozen=True)
class _Slip:
    """What may be wrong, as factors that make the stated numbers right."""

    question: str = ""
    torque: float = 1.0
    angle: float = 1.0
    preload: float = 1.0


_ARCSEC_PER_MRAD = 648 / np.pi
_SLIPS = (
    _Slip("are the torques in N mm, not in N m (or in N m, not in kN m)", torque=1e-3),
    _Slip("are the torques in N cm, not in N m", torque=1e-2),
    _Slip("are the torques in kgf cm or lbf in, not in N m", torque=0.1),
    _Slip("are the torques in kgf m, not in N m", torque=9.81),
    _Slip("are the torques in kN m, not in N m (or in N m, not in N mm)", torque=1e3),
    _Slip("are the angles in arcmin, not in arcsec (deg, not arcmin; rad, not deg)", angle=60.0),
    _Slip("are the angles in arcsec, not in arcmin (arcmin, not deg; deg, not rad)", angle=1 / 60),
    _Slip("are the angles in deg, not in arcsec", angle=3600.0),
    _Slip("are the angles in arcsec, not in deg", angle=1 / 3600),
    _Slip("are the angles in mrad, not in arcsec", angle=_ARCSEC_PER_MRAD),
    _Slip("are the angles in arcsec, not in mrad", angle=1 / _ARCSEC_PER_MRAD),
    _Slip("are the angles in rad, not in arcsec", angle=1e3 * _ARCSEC_PER_MRAD),
    _Slip("are the angles in arcsec, not in rad", angle=1e-3 / _ARCSEC_PER_MRAD),
    _Slip("are the preloads in kN, not in N", preload=1e3),
    _Slip("are the preloads in kgf, not in N", preload=9.81),
    _Slip("are the preloads in mN, not in N", preload=1e-3),
)


@dataclass(frozen=True, eq=False)
class _Runs:
    """Each run that turns under a torque; arrays have shape (k,)."""

    name: list[str]
    slope: Floats
    """Angle over torque, arcsec/(N m), by least squares."""
    torque_Nm: Floats
    angle_arcsec: Floats
    """Ranges."""
    largest_arcsec: float
    """Half of the largest range of an angle within a run."""
    between: bool = False
    """Whether no run varies its torque, so that all readings together stand for one."""
    deaf: tuple[str, ...] = ()
    """Runs whose angle does not follow a torque that varies, and hardly moves."""
    stuck: tuple[str, ...] = ()
    """Runs whose torque stays, while their angle moves as that of the others does."""

    @classmethod
    def of(cls, r: Readings) -> _Runs:
        rows = [np.flatnonzero(r.run_index == k) for k in range(int(r.run_index.max()) + 1)]
        torque = np.array([np.ptp(r.torque_Nm[mine]) for mine in rows])
        angle = np.array([np.ptp(r.elastic_angle_arcsec[mine]) for mine in rows])
        names = [str(r.run[mine[0]]) for mine in rows]
        varies = torque > _LIMITS.varies * torque.max()
        half = 0.5 * float(angle.max())
        if not varies.any() and np.ptp(r.torque_Nm) > 0:
            half = 0.5 * float(np.ptp(r.elastic_angle_arcsec))
            found = _slope(r, np.arange(len(r)))
            known = [] if found is None else [found]
            return cls(["all"] * len(known), *_table(known), half, between=True)
        slopes = [_slope(r, mine) for mine in rows]
        told = [found for found in slopes if found is not None]
        usual = float(np.median(np.abs([found[0] for found in told]))) if told else 0.0
        turns = float(np.median([found[2] for found in told])) if told else 0.0
        quiet = np.array([found is None for found in slopes])
        deaf = quiet & varies & (angle < _LIMITS.dead * usual * torque)
        stuck = quiet & ~varies & (angle > (1 - _LIMITS.dead) * turns) & bool(told)
        return cls(
            [name for name, found in zip(names, slopes, strict=True) if found is not None],
            *_table(told),
            half,
            deaf=tuple(name for name, so in zip(names, deaf.tolist(), strict=True) if so),
            stuck=tuple(name for name, so in zip(names, stuck.tolist(), strict=True) if so),
        )


def _slope(r: Readings, rows: NDArray[np.int64]) -> tuple[float, float, float] | None:
    """Slope, range of the torque and range of the angle; None where the angle does not follow."""
    torque, angle = r.torque_Nm[rows], r.elastic_angle_arcsec[rows]
    x, y = torque - torque.mean(), angle - angle.mean()
    both = float(x @ y)
    if abs(both) <= _LIMITS.follows * float(np.sqrt((x @ x) * (y @ y))):
        return None
    return both / float(x @ x), float(np.ptp(torque)), float(np.ptp(angle))


def _table(rows: list[tuple[float, float, float]]) -> tuple[Floats, Floats, Floats]:
    slope, torque, angle = np.array(rows, dtype=np.float64).reshape(-1, 3).T
    return slope, torque, angle


def unit_checks(r: Readings, case: Case | Drive | None) -> Iterator[Check]:
    """Units against the case, the sign of the angle, and runs against each other."""
    runs = _Runs.of(r)
    yield _units(r, runs, None if case is None else _Model(case, r))
    yield _sign(runs)
    yield _runs_alike(runs)


def input_side(r: Readings, drive: Drive) -> bool:
    """Whether torques would have to be those of the input side for the angle to follow them about
    as it does in the model of the drive."""
    runs, model = _Runs.of(r), _Model(drive, r)
    if model.ratio is None or not len(runs.slope):
        return False
    slope = float(np.median(np.abs(runs.slope)))
    if not _beyond(model.factor(_Slip(), slope), _LIMITS.alarm):
        return False
    factor = model.factor(_Slip(torque=model.ratio), slope)
    return factor > 0 and not _beyond(factor, _LIMITS.explains)


# --- against the case ---------------------------------------------------------------------


class _Model:
    """What the case says of the table's load; solutions are kept."""

    def __init__(self, case: Case | Drive, r: Readings) -> None:
        self.case = case
        self.torque_Nm = float(np.abs(r.torque_Nm).max())
        self.preload_N = None if r.preload_N is None else float(np.median(r.preload_N))
        stated = case if isinstance(case, Case) else None
        self.rated_Nm = stated and stated.rated_torque_Nm
        self.stated_preload_N = stated and stated.preload_N
        drive = stated.drive if stated else case
        ball = isinstance(drive, Drive) and drive.kind == "ball_drive"
        self.ratio = abs(drive.transmission_ratio) if ball and isinstance(drive, Drive) else None
        self._row = r.select([0]) if len(r) else r
        self._known: dict[tuple[float, float | None], float] = {}

    def slips(self) -> Iterator[_Slip]:
        """Everything that may be wrong."""
        yield from (s for s in _SLIPS if s.preload == 1.0 or self.preload_N is not None)
        if self.ratio is not None:
            words = f"of the input side (the transmission ratio is {self.ratio:.4g})"
            yield _Slip(f"are the torques those {words}", torque=self.ratio)
            yield _Slip(f"are the angles those {words}", angle=1 / self.ratio)

    def slope(self, torque_Nm: float, preload_N: float | None) -> float:
        """Angle over torque, arcsec/(N m); NaN where there is no solution."""
        key = torque_Nm, preload_N
        if key not in self._known:
            self._known[key] = self._solved(torque_Nm, preload_N)
        return self._known[key]

    def _solved(self, torque_Nm: float, preload_N: float | None) -> float:
        torque = torque_Nm * np.array([0.0, 1.0, 0.0, -1.0, 0.0])
        n = len(torque)
        rows = replace(
            self._row.select([0] * n),
            torque_Nm=torque,
            preload_N=None if preload_N is None else np.full(n, preload_N),
            elastic_angle_arcsec=np.zeros(n),
            run=np.ones(n, dtype=np.int64),
            time_s=np.arange(n, dtype=np.float64),
        )
        effects = self.case.effects if isinstance(self.case, Case) else []
        try:
            model = Assembled(campaign_of(self.case, rows, ()), [effect.id for effect in effects])
            angle = model.at(model.neutral).angle_arcsec
        except CbptError:
            return float("nan")
        return float(angle[1] - angle[3]) / (2 * torque_Nm)

    def rated_too_small(self, slip: _Slip) -> bool:
        """Whether torques go far beyond the rated one."""
        most = None if self.rated_Nm is None else _LIMITS.alarm * self.rated_Nm
        return most is not None and slip.torque * self.torque_Nm > most

    def preload_off(self, slip: _Slip) -> bool:
        """Whether preloads are far from that of the case."""
        if self.preload_N is None or not self.stated_preload_N:
            return False
        return _beyond(slip.preload * self.preload_N / self.stated_preload_N, _LIMITS.alarm)

    def held(self, slip: _Slip) -> bool:
        """Whether the preload holds the torque, or a good part of it."""
        preload = None if self.preload_N is None else slip.preload * self.preload_N
        return bool(np.isfinite(self.slope(self._some(slip), preload)))

    def factor(self, slip: _Slip, slope: float) -> float:
        """The slope of the readings over that of the model, at a torque that the preload holds; NaN
        where it holds none."""
        preload = None if self.preload_N is None else slip.preload * self.preload_N
        torque = self._some(slip)
        for _ in range(6):
            model = self.slope(torque, preload)
            if model > 0:
                return abs(slope) * slip.angle / slip.torque / model
            torque /= 10.0
        return float("nan")

    def _some(self, slip: _Slip) -> float:
        return slip.torque * self.torque_Nm / _LIMITS.alarm


def _beyond(factor: float, limit: float) -> bool:
    """False for NaN, which is unknown."""
    return bool(abs(np.log(factor)) > np.log(limit)) if factor > 0 else False


def _units(r: Readings, runs: _Runs, model: _Model | None) -> Check:
    size = runs.largest_arcsec
    torque = float(np.abs(r.torque_Nm).max())
    words = f"angles reach {rounded(size)} arcsec about their middle, torques {rounded(torque)} N m"
    if lost := _lost_signals(runs):
        return Check("units", "look", f"{words}; {lost[0]}", lost[1])
    low, high = _LIMITS.usual_arcsec
    remedy = "Check the units of torque and angle in the headers."
    if not len(runs.slope):
        if np.ptp(r.torque_Nm) > 0:
            if not np.ptp(r.elastic_angle_arcsec) > 0:
                words = f"the angle is the same in every reading, torques {rounded(torque)} N m"
                remedy = "Was the angle sensor off, or its column not the one that was logged?"
                return Check("units", "look", words, remedy)
            words += (
                "; the angle does not follow the torque from run to run"
                if runs.between
                else "; in no run does the angle follow the torque"
            )
            remedy = "Check that the columns of torque and angle belong to the same readings."
            return Check("units", "look", words, remedy)
    elif model is not None:
        if runs.between:
            words += "; the torque changes from run to run, not within runs"
        return _against(model, float(np.median(np.abs(runs.slope))), size, words)
    if low <= size <= high:
        return Check("units", "good", words)
    return Check("units", "look", words, remedy)


def _lost_signals(runs: _Runs) -> tuple[str, str] | None:
    """What is said of runs in which one of both signals is missing, and the remedy."""
    if not runs.deaf and not runs.stuck:
        return None
    told = []
    if runs.deaf:
        told.append(f"in {some('run', runs.deaf)} the torque varies and the angle hardly moves")
    if runs.stuck:
        told.append(
            f"in {some('run', runs.stuck)} the torque stays while the angle moves as in the others"
        )
    remedy = "Was a sensor off or unplugged there? If so, remove the run from the table."
    return "; ".join(told), remedy


def _against(model: _Model, slope: float, size: float, words: str) -> Check:
    as_stated = _Slip()
    found = model.factor(as_stated, slope)
    told = [words]
    if np.isfinite(found):
        told.append(
            f"the angle changes by {rounded(slope)} arcsec/(N m), {rounded(found)} times what the "
            "model of the case file says"
        )
    wrong = _beyond(found, _LIMITS.alarm)
    if model.rated_too_small(as_stated):
        wrong = True
        told.append(f"the drive is rated for {rounded(model.rated_Nm or 0.0)} N m")
    if model.preload_off(as_stated):
        wrong = True
        told.append(
            f"the preloads are about {rounded(model.preload_N or 0.0)} N, that of the case is "
            f"{rounded(model.stated_preload_N or 0.0)} N"
        )
    if model.preload_N is not None and not model.held(as_stated):
        wrong = True
        told.append(
            f"a preload of {rounded(model.preload_N)} N, the median, does not hold "
            f"{rounded(model.torque_Nm / _LIMITS.alarm)} N m in the model, a fifth of the largest "
            "torque"
        )
    words = "; ".join(told)
    if not wrong:
        return Check("units", "good", words)
    return Check("units", "look", words, _question(_explaining(model, slope, size), found, model))


def _explaining(model: _Model, slope: float, size: float) -> list[_Slip]:
    """Slips each of which makes all of it right, the nearest first."""
    low, high = _LIMITS.usual_arcsec
    found = []
    for slip in model.slips():
        factor = model.factor(slip, slope)
        likely = slip.angle == 1.0 or low <= slip.angle * size <= high
        if not likely or not factor > 0 or _beyond(factor, _LIMITS.explains):
            continue
        if model.rated_too_small(slip) or model.preload_off(slip):
            continue
        if model.preload_N is None or model.held(slip):
            found.append((abs(float(np.log(factor))), slip))
    return [slip for _, slip in sorted(found, key=lambda pair: pair[0])][: _LIMITS.answers]


def _question(slips: list[_Slip], found: float, model: _Model) -> str:
    asked = [slip.question for slip in slips]
    slope_fits = found > 0 and not _beyond(found, _LIMITS.explains)
    if model.ratio is None and found > _LIMITS.alarm:
        asked.append(
            "are the torques or the angles those of the input side (with a transmission ratio of "
            f"about {rounded(found, 2)})"
        )
    if not asked:
        if model.rated_Nm is not None and model.rated_too_small(_Slip()) and slope_fits:
            return "Is the rated torque in the case right? The slope fits that of the model."
        return (
            "No wrong unit of one column explains it. Check the units of torque, angle and "
            "preload, and the stiffness in the case."
        )
    text = "; or ".join(asked)
    return (
        f"{text[0].upper()}{text[1:]}? If none, are the columns of torque and angle swapped, or is "
        "the stiffness in the case wrong?"
    )


# --- runs against each other --------------------------------------------------------------


def _sign(runs: _Runs) -> Check:
    name = "sign of the angle"
    if not len(runs.slope):
        return Check(name, "good", "no run tells it")
    down = runs.slope < 0
    if not down.any():
        where = "from run to run" if runs.between else _everywhere(runs)
        return Check(name, "good", f"the angle grows with the torque {where}")
    if down.all():
        remedy = "Is the sign of the torque or that of the angle reversed? Turn one of them over."
        where = "from run to run" if runs.between else _everywhere(runs)
        return Check(name, "look", f"the angle falls as the torque grows {where}", remedy)
    few = down if down.sum() <= 0.5 * len(down) else ~down
    these = [run for run, take in zip(runs.name, few.tolist(), strict=True) if take]
    way = "falls as the torque grows" if few is down else "grows with the torque"
    words = f"the angle {way} in {some('run', these)}, and not in the others"
    remedy = "Was the torque or the angle taken with the other sign there? Turn it over in those."
    return Check(name, "look", words, remedy)


def _everywhere(runs: _Runs) -> str:
    return "in every other run" if runs.deaf or runs.stuck else "in every run"


def _runs_alike(runs: _Runs) -> Check:
    name = "units of the runs"
    if len(runs.slope) < 2:
        return Check(name, "good", "no two runs to compare")
    torques = runs.torque_Nm / np.median(runs.torque_Nm)
    angles = runs.angle_arcsec / np.median(runs.angle_arcsec)
    told = [
        *_other_unit("torques", runs, (torques, angles), _LIMITS.alarm),
        *_other_unit("angles", runs, (angles, torques), _LIMITS.of_angles),
    ]
    if not told:
        return Check(name, "good", "the runs turn alike under like torques")
    return Check(name, "look", "; ".join(told), "Are those runs in another unit than the others?")


def _other_unit(
    what: str, runs: _Runs, columns: tuple[Floats, Floats], limit: float
) -> Iterator[str]:
    """Runs in which one column goes far further, or less far, than in most while the other does
    not."""
    own, other = columns
    odd = [
        (run, mine)
        for run, mine, theirs in zip(runs.name, own.tolist(), other.tolist(), strict=True)
        if _beyond(mine, limit) and not _beyond(theirs, _LIMITS.alike)
    ]
    if odd:
        names, factors = zip(*odd, strict=True)
        rest = "angles" if what == "torques" else "torques"
        yield (
            f"the {what} of {some('run', names)} reach {span(min(factors), max(factors))} times as "
            f"far as those of most runs, while the {rest} do not"
        )
