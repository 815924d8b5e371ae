"""What the tolerances of a drawing make of the elastic angle.

    tolerance  a case -> Tolerance
    Tolerance  mean, spread, quantiles, worst cases, and the share of each number
    Spread     how friction, safety or vibration scatters, where that is asked for

Numbers scatter as the case says: evenly within `[tolerance]`, else normally by `[uncertainty]`,
each by itself. Drives are drawn (Monte Carlo, JCGM 101) and held beside the exact sensitivities
(JCGM 100). A drawn drive without a solution is counted with its status.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive
from cbpt.design.judge import (
    Judged,
    at_load,
    bare_drive_note,
    judge,
    left_out,
    nominal_parts_note,
    shown,
    value_of,
)
from cbpt.errors import InvalidInputError, NoSolutionError
from cbpt.figures.tolerance import draw_tolerance
from cbpt.lab.wording import layout
from cbpt.lab.wording.html import Reported
from cbpt.results import ANGLE_UNITS, ARCSEC_PER_RAD

__all__ = ["Scatter", "Spread", "Tolerance", "tolerance"]

Floats = NDArray[np.float64]

SAMPLES = 10_000
MOST_SAMPLES = 10_000_000
QUANTILES = (0.025, 0.5, 0.975)
# A number without limits is taken so many standard uncertainties off in the stack-up.
_STACKED_U = 3.0
# Margins whose loss is counted: name, column.
# Fewer values say nothing of their own fourth moment.
_MOMENT = 30
_COSTS = (
    "friction_torque_Nm",
    "efficiency",
    "wear_Nm_per_turn",
    "static_safety",
    "natural_frequency_Hz",
)
_LOST = {
    "undercut": "undercut_margin",
    "inside_wall_missing": "inside_wall_margin",
    "balls_touch": "deceleration_ball_clearance_m",
    "equal_speed_balls_touch": "equal_speed_ball_clearance_m",
    "rings_overlap": "ring_clearance_m",
}


@dataclass(frozen=True)
class Scatter:
    """A number that scatters, SI."""

    number: str
    """Name in SI."""
    value: float
    """The nominal one."""
    distribution: str
    """`uniform` within a limit, or `normal`."""
    size: float
    """The limit, plus or minus, or the standard uncertainty."""
    u: float
    """Standard uncertainty."""
    slope_arcsec: float | None
    """The elastic angle per unit, exact; None where the nominal drive has no solution."""
    share: float | None
    """Of the variance, by the slopes."""
    share_drawn: float | None
    """Of the variance, by the squared correlation of the drawn numbers and angles."""

    @property
    def key(self) -> str:
        """Its name as a case file has it, with the usual unit."""
        return shown(self.number, 0.0)[0]


@dataclass(frozen=True)
class Spread:
    """How a number of the drives within their tolerances scatters, in the unit of its name."""

    nominal: float
    """Of the drawing's own numbers; NaN without a solution."""
    mean: float
    sd: float
    quantiles: dict[float, float]
    """By probability."""

    def to_dict(self) -> dict[str, Any]:
        """The numbers in plain types."""
        return {
            "nominal": _plain(self.nominal),
            "mean": _plain(self.mean),
            "sd": _plain(self.sd),
            "quantiles": [
                {"probability": p, "value": _plain(value)} for p, value in self.quantiles.items()
            ],
        }


@dataclass(frozen=True, eq=False)
class Tolerance(Reported):
    """The elastic angle of drives within their tolerances, arcsec; standard errors of what is
    drawn stand beside it."""

    case: Case
    nominal_arcsec: float | None
    """Of the drawing's own numbers; None without a solution."""
    numbers: tuple[Scatter, ...]
    mean_arcsec: float
    mean_error_arcsec: float
    sd_arcsec: float
    sd_error_arcsec: float
    quantiles_arcsec: dict[float, tuple[float, float]]
    """By probability: the quantile and its standard error."""
    linear_u_arcsec: float | None
    """Standard uncertainty by the exact slopes."""
    stacked_linear_arcsec: tuple[float, float] | None
    """Least and greatest angle with every number at its limit, by the slopes."""
    stacked_arcsec: tuple[float | None, float | None]
    """The same two corners solved; None without a solution."""
    status: dict[str, int]
    """How many drawn drives ended how."""
    lost: dict[str, int]
    """In how many a margin is lost: `undercut`, `inside_wall_missing`, `balls_touch`,
    `equal_speed_balls_touch`, `rings_overlap`."""
    samples: int
    seed: int
    angles_arcsec: Floats = field(repr=False)
    """Of every drawn drive, NaN without a solution."""
    friction: dict[str, Spread] = field(default_factory=dict)
    """At the input angle, where it was asked for: `friction_torque_Nm`, `efficiency`,
    `wear_Nm_per_turn`, `static_safety` and, with an inertia, `natural_frequency_Hz`."""

    def share_of(self, count: int) -> tuple[float, float]:
        """Share of the drawn drives, and its standard error."""
        share = count / self.samples
        return share, float(np.sqrt(share * (1 - share) / self.samples))

    def to_dict(self) -> dict[str, Any]:
        """The document: plain types, JSON-safe."""
        numbers = []
        for n in self.numbers:
            key, value = shown(n.number, n.value)
            per_si = shown(n.number, 1.0)[1]
            numbers.append(
                {
                    "number": key,
                    "value": value,
                    "distribution": n.distribution,
                    "limit" if n.distribution == "uniform" else "u_stated": n.size * per_si,
                    "u": n.u * per_si,
                    "elastic_angle_arcsec_per_unit": (
                        None if n.slope_arcsec is None else n.slope_arcsec / per_si
                    ),
                    "share_of_variance": n.share,
                    "share_of_variance_drawn": n.share_drawn,
                }
            )
        stacked = self.stacked_linear_arcsec
        counts = {"status": self.status, "lost": self.lost}
        return {
            "torque_Nm": self.case.torque_Nm,
            "preload_N": self.case.preload_N,
            "input_angle_deg": self.case.input_angle_deg or 0.0,
            "samples": self.samples,
            "seed": self.seed,
            "nominal_arcsec": self.nominal_arcsec,
            "mean_arcsec": _plain(self.mean_arcsec),
            "mean_error_arcsec": _plain(self.mean_error_arcsec),
            "sd_arcsec": _plain(self.sd_arcsec),
            "sd_error_arcsec": _plain(self.sd_error_arcsec),
            "quantiles": [
                {"probability": p, "arcsec": _plain(q), "error_arcsec": _plain(e)}
                for p, (q, e) in self.quantiles_arcsec.items()
            ],
            "linear_u_arcsec": self.linear_u_arcsec,
            "stacked_linear_arcsec": None if stacked is None else list(stacked),
            "stacked_arcsec": list(self.stacked_arcsec),
            **{
                name: {
                    key: {"count": count, "share": share, "share_error": error}
                    for key, count in found.items()
                    for share, error in [self.share_of(count)]
                }
                for name, found in counts.items()
            },
            **(
                {"friction": {name: spread.to_dict() for name, spread in self.friction.items()}}
                if self.friction
                else {}
            ),
            "not_counted": left_out(self.case),
            "numbers": numbers,
        }

    def to_json(self) -> str:
        """`to_dict` as JSON text."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False)

    def report(self, angle_unit: str = "arcsec") -> str:
        """Text for a terminal."""
        one = ANGLE_UNITS[angle_unit]

        def angle(arcsec: float | None) -> str:
            return "no solution" if arcsec is None else f"{arcsec * one:.6g}"

        def with_error(arcsec: float, error: float) -> str:
            known = f"{error * one:.2g}" if np.isfinite(error) else "unknown, too few drives"
            return f"{arcsec * one:.6g} (standard error {known})"

        c = self.case
        solved = int(np.isfinite(self.angles_arcsec).sum())
        of_those = f", of the {solved} drives that have a solution" if solved < self.samples else ""
        lines = [
            f"Elastic angle at {c.torque_Nm:g} N m, {c.preload_N:g} N, input angle "
            f"{c.input_angle_deg or 0:g} deg, in {angle_unit}; {self.samples} random drives, seed "
            f"{self.seed}",
            f"  nominal {angle(self.nominal_arcsec)}",
            f"  mean {with_error(self.mean_arcsec, self.mean_error_arcsec)}{of_those}",
            f"  standard deviation {with_error(self.sd_arcsec, self.sd_error_arcsec)}; linear "
            f"estimate {angle(self.linear_u_arcsec)}",
        ]
        lines += [
            f"  {100 * p:g} % lie below {with_error(*found)}"
            for p, found in self.quantiles_arcsec.items()
        ]
        if self.stacked_linear_arcsec is not None:
            linear = " to ".join(angle(end) for end in self.stacked_linear_arcsec)
            exact = " to ".join(angle(end) for end in self.stacked_arcsec)
            lines.append(
                f"  worst case, every number at its limit: linear estimate {linear}; exact {exact}"
            )
        rows = []
        for n in self.numbers:
            key, value = shown(n.number, n.value)
            size = shown(n.number, n.size)[1]
            sign = "+-" if n.distribution == "uniform" else "u"
            rows.append(
                [
                    key,
                    value,
                    f"{sign} {size:.6g}",
                    *(None if share is None else 100 * share for share in (n.share, n.share_drawn)),
                ]
            )
        heads = ["number", "nominal", "scatters by", "share_%", "share_drawn_%"]
        lines.append(layout.table(heads, rows))
        lines += self._of_friction()
        lines_of = [(_ended(kind), count) for kind, count in self.status.items() if kind != "ok"]
        lines_of += [(name.replace("_", " "), count) for name, count in self.lost.items()]
        for name, count in lines_of:
            if count:
                share, error = self.share_of(count)
                lines.append(
                    f"{name}: {count} of the drives, {100 * share:.3g} % "
                    f"(standard error {100 * error:.2g})"
                )
        lines += bare_drive_note(self.case, "the angles are")
        lines += nominal_parts_note(self.case, "the angles are")
        return "\n".join(lines)

    def _of_friction(self) -> list[str]:
        if not self.friction:
            return []
        rows: list[list[Any]] = [
            [name, s.nominal, s.mean, s.sd, *s.quantiles.values()]
            for name, s in self.friction.items()
        ]
        heads = ["at the input angle", "nominal", "mean", "sd"]
        return [layout.table([*heads, *(f"{100 * p:g}_%" for p in QUANTILES)], rows)]

    def __repr__(self) -> str:
        return self.report()

    def plot(self, path: str | PathLike[str], angle_unit: str = "arcsec") -> None:
        """Draw the histogram to a file (SVG, PNG or PDF by its ending). Needs matplotlib."""
        draw_tolerance(self, path, angle_unit)


def tolerance(
    case: Case | Drive | str | PathLike[str] | Mapping[str, Any],
    *,
    samples: int = SAMPLES,
    seed: int = 0,
    torque_Nm: float | None = None,
    preload_N: float | None = None,
    input_angle_deg: float | None = None,
    friction: bool = False,
) -> Tolerance:
    """Draw drives within the tolerances of the case, and solve each one under its load.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The drive with its `[tolerance]`.
    samples : int
        The number of drives.
    seed : int
        Seed of the random numbers. The same seed gives the same drives.
    torque_Nm, preload_N, input_angle_deg : float, optional
        The load. What is not given comes from `[load]` of the case.
    friction : bool
        Whether to compute friction torque, efficiency, wear, static safety and natural frequency of
        each drive too, with the coefficient of the case. It takes several times as long.

    Returns
    -------
    Tolerance
        Mean, standard deviation and quantiles of the elastic angle, and the share of each number.

    Raises
    ------
    InvalidInputError
        The case states no tolerance, or a number is not possible.
    NoSolutionError
        No drive that was drawn has a solution.
    """
    if not 2 <= samples <= MOST_SAMPLES:
        raise InvalidInputError(f"samples = {samples}: expected 2 to {MOST_SAMPLES}")
    if seed < 0:
        raise InvalidInputError(f"seed = {seed}: expected 0 or more")
    case = at_load(case, torque_Nm, preload_N, input_angle_deg)
    spreads = case.spreads()
    if not spreads:
        raise InvalidInputError(
            "the case states no tolerance: add a table [tolerance] with plus-or-minus limits, for "
            "example deceleration_ball_radius_um = 2 for +-2 um, or a table [uncertainty] with "
            "standard uncertainties under the same names"
        )
    names = [name for name, _, _ in spreads]
    nominal = np.array([value_of(case, name) for name in names], dtype=np.float64)
    generator = np.random.default_rng(seed)
    drawn = np.empty((samples, len(names)))
    for place, (_, distribution, size) in enumerate(spreads):
        if distribution == "uniform":
            drawn[:, place] = nominal[place] + generator.uniform(-size, size, samples)
        else:
            drawn[:, place] = nominal[place] + size * generator.standard_normal(samples)
    judged = judge(
        case.nominal(),
        names,
        drawn,
        pressures=friction,
        coefficient=case.friction_coefficient if friction else None,
    )
    return _summary(_Sample(case, names, nominal, spreads, drawn, judged), seed)


@dataclass(frozen=True, eq=False)
class _Sample:
    """Drives that were drawn, and what became of them."""

    case: Case
    names: list[str]
    nominal: Floats
    spreads: list[tuple[str, str, float]]
    """Name, distribution and size of each number that scatters."""
    drawn: Floats
    judged: Judged

    @property
    def u(self) -> Floats:
        """Standard uncertainty of each number."""
        return np.array([s / np.sqrt(3) if d == "uniform" else s for _, d, s in self.spreads])

    @property
    def ends(self) -> Floats:
        """How far each number is taken off for the worst cases."""
        return np.array(
            [size if d == "uniform" else _STACKED_U * size for _, d, size in self.spreads]
        )


def _summary(sample: _Sample, seed: int) -> Tolerance:
    """What the drawn drives say together."""
    case, judged = sample.case, sample.judged
    angles = judged["elastic_angle_rad"] * ARCSEC_PER_RAD
    solved = np.isfinite(angles)
    kinds, counts = np.unique(judged.status, return_counts=True)
    status = {str(kind): int(count) for kind, count in zip(kinds, counts, strict=True)}
    if not solved.any():
        found = ", ".join(f"{_ended(kind)} ({count})" for kind, count in status.items())
        raise NoSolutionError(f"no solution for any of {len(angles)} random drives: {found}")
    slopes, before = _slopes(case, sample.names)
    good = angles[solved]
    n = len(good)
    sd = float(good.std(ddof=1)) if n > 1 else float("nan")
    variance = None if slopes is None else float(np.sum((slopes * sample.u) ** 2))
    # The fourth moment tells how well the standard deviation is known; of a few it knows nothing
    # itself, and that of normal values stands for it.
    fourth = float(np.mean((good - good.mean()) ** 4)) / sd**4 if sd > 0 and n >= _MOMENT else 3.0
    stacked, corners = _worst_cases(sample, slopes, before)
    return Tolerance(
        case=case,
        nominal_arcsec=before,
        numbers=tuple(_scatters(sample, slopes, solved, good)),
        mean_arcsec=float(good.mean()),
        mean_error_arcsec=sd / np.sqrt(n),
        sd_arcsec=sd,
        sd_error_arcsec=sd * float(np.sqrt(max(fourth - 1.0, 0.0) / (4 * n))),
        quantiles_arcsec={p: _quantile(good, p) for p in QUANTILES},
        linear_u_arcsec=None if variance is None else float(np.sqrt(variance)),
        stacked_linear_arcsec=stacked,
        stacked_arcsec=corners,
        status=status,
        # A margin of a row that is no drive is NaN, which is not lost but counted by its status.
        lost={name: int(np.sum(judged[column] <= 0)) for name, column in _LOST.items()},
        samples=len(angles),
        seed=seed,
        angles_arcsec=angles,
        friction=_friction(sample),
    )


def _friction(sample: _Sample) -> dict[str, Spread]:
    """How the costs scatter; nothing where they were not asked for."""
    case, drawn = sample.case, sample.judged
    if not np.isfinite(drawn["friction_torque_Nm"]).any():
        return {}
    one = sample.nominal[None, :]
    coefficient = case.friction_coefficient
    nominal = judge(case.nominal(), sample.names, one, pressures=True, coefficient=coefficient)
    return {
        name: Spread(
            nominal=float(nominal[name][0]),
            mean=float(good.mean()),
            sd=float(good.std(ddof=1)) if len(good) > 1 else float("nan"),
            quantiles={p: float(np.quantile(good, p)) for p in QUANTILES},
        )
        for name in _COSTS
        for good in [drawn[name][np.isfinite(drawn[name])]]
        if len(good)
    }


def _scatters(
    sample: _Sample, slopes: Floats | None, solved: NDArray[np.bool_], good: Floats
) -> Iterator[Scatter]:
    """Each number with its share of the variance; good: angles of the drives with a solution."""
    n, u = len(good), sample.u
    sd = float(good.std(ddof=1)) if n > 1 else float("nan")
    variance = None if slopes is None else float(np.sum((slopes * u) ** 2))
    for place, (name, distribution, size) in enumerate(sample.spreads):
        own = sample.drawn[solved, place]
        slope = None if slopes is None else float(slopes[place])
        share = None if slope is None or not variance else float((slope * u[place]) ** 2 / variance)
        r = np.corrcoef(own, good)[0, 1] if n > 2 and own.std() > 0 and sd > 0 else np.nan
        yield Scatter(
            name,
            float(sample.nominal[place]),
            distribution,
            size,
            float(u[place]),
            slope,
            share,
            _plain(r * r),
        )


def _worst_cases(
    sample: _Sample, slopes: Floats | None, before: float | None
) -> tuple[tuple[float, float] | None, tuple[float | None, float | None]]:
    """Least and greatest angle with every number at its limit: by the slopes, and solved."""
    if slopes is None or before is None:
        return None, (None, None)
    way, reach = np.sign(slopes) * sample.ends, float(np.sum(np.abs(slopes) * sample.ends))
    corners = np.array([sample.nominal - way, sample.nominal + way])
    both = judge(sample.case.nominal(), sample.names, corners)["elastic_angle_rad"]
    low, high = (_plain(angle * ARCSEC_PER_RAD) for angle in both)
    return (before - reach, before + reach), (low, high)


def _ended(status: str) -> str:
    """How a drawn drive without a solution ended, in words."""
    if status == "no_drive":
        return "numbers that describe no possible drive"
    return f"no solution: {status.replace('_', ' ')}"


def _slopes(case: Case, names: list[str]) -> tuple[Floats | None, float | None]:
    """Exact slopes of the angle, arcsec per SI, and the nominal angle; None without a solution."""
    assert case.torque_Nm is not None and case.preload_N is not None
    found = case.drive.sensitivities(
        case.torque_Nm, case.preload_N, case.input_angle_deg or 0.0, names
    ).elastic_angle
    if found is None:
        return None, None
    slopes = np.array([found.slopes[name] for name in names]) * ARCSEC_PER_RAD
    return slopes, found.value * ARCSEC_PER_RAD


def _quantile(good: Floats, p: float) -> tuple[float, float]:
    """A quantile and its standard error: half of what the ranks a binomial standard deviation to
    both sides are apart; NaN where there are none."""
    reach = np.sqrt(p * (1 - p) / len(good))
    if not reach <= p <= 1 - reach:  # beyond all that was drawn
        return float(np.quantile(good, p)), np.nan
    low, middle, high = np.quantile(good, [p - reach, p, p + reach])
    return float(middle), float(high - low) / 2


def _plain(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
