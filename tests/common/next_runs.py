"""How many further runs decide: those that are suggested against runs at random.

The criterion is linearised: expected log odds of each two rivals from all runs so far together, by
what the diagnosis predicts for them. No run is simulated.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

import cbpt
from cbpt.lab.diagnosis.deciding_runs import open_hypotheses
from cbpt.lab.experiment.candidates import candidates, limits_of
from cbpt.lab.experiment.expected_gain import LIMIT, Prospect, prospect
from cbpt.lab.experiment.plan import Plan, PlannedRun, sequence
from cbpt.lab.model.priors import TWINS

HIDDEN: list[tuple[str, dict[str, float]]] = [
    ("eccentric_bearing", {"reference_deflection_um": 0.21, "exponent": 2 / 3}),
    ("output_torsion", {"compliance_arcsec_per_Nm": 0.35}),
    ("rough_contact", {"exponent": 1.58}),
    ("bearing_play", {"clearance_um": 0.15}),
    ("preload_loss", {"lost_share": 0.06}),
    ("preload_spring", {"spring_rate_N_per_um": 40.0}),
    ("friction_hysteresis", {"friction_radius_um": 120.0}),
    ("creep", {"compliance_arcsec_per_Nm": 0.06}),
    ("plate_tilt", {"tilt_cosine_urad": 8.0}),
    ("groove_pitch_error", {"harmonic": 2.0, "cosine_um": 0.2}),
    ("eccentricity_error", {"offset_sine_um": 0.1}),
    ("wear", {"lost_share_per_h": 0.3}),
]


@dataclass(frozen=True)
class Race:
    """Runs until the limit of odds; None where they did not reach it."""

    suggested: int | None
    random: tuple[int | None, ...]


def short_campaign() -> Plan:
    """Two runs of the example's drive at one input angle: a campaign that leaves much open."""
    runs = [
        PlannedRun(
            sequence("loop", torque, 7),
            preload,
            (10.0,),
            u_elastic_angle_arcsec=0.3,
            dwell_s=5.0,
        )
        for preload, torque in ((500.0, 7.5), (900.0, 9.0))
    ]
    return Plan.of_runs(runs)


def scaled(values: dict[str, float], strength: float) -> dict[str, float]:
    """The effect that much stronger; the exponent of a contact counts from Hertz's."""
    off = {"exponent": 1.5}
    return {
        n: v if n == "harmonic" else off.get(n, 0.0) + strength * (v - off.get(n, 0.0))
        for n, v in values.items()
    }


def view_of(case: Path, effect: str, values: dict[str, float], seed: int) -> Prospect | None:
    """What rivals predict for every candidate, after a short campaign; None without rivals that
    anything could tell apart.
    """
    readings = cbpt.simulate(case, short_campaign(), effects=[(effect, values)], seed=seed)
    d = cbpt.diagnose(case, readings, seed=seed)
    if not d.verdict.rivals:
        return None
    hypotheses = open_hypotheses(d)
    names = list(hypotheses.fits)
    if len(names) < 2 or any(b in TWINS.get(a, []) for a in names for b in names):
        return None
    runs = candidates(d.competition.campaign.drive, limits_of(readings))
    view = prospect(hypotheses, runs)
    assert view is not None
    return view


def race(view: Prospect, rng: np.random.Generator, draws: int, most: int = 15) -> Race | None:
    """Suggested runs against random ones; None where the best do not decide within `most`."""
    runs = view.rows.runs
    solved = [r for r in range(runs) if all(np.isfinite(_gains(view, [r])))]
    mine = _until(view, _greedy(view, solved), most)
    if mine is None:
        return None
    drawn = tuple(_until(view, iter(rng.permutation(solved).tolist()), most) for _ in range(draws))
    return Race(mine, drawn)


def _gains(view: Prospect, chosen: list[int]) -> list[float]:
    return list(view.gains(np.isin(view.rows.run_index, chosen)).values())


def _greedy(view: Prospect, solved: list[int]) -> Iterator[int]:
    """Each run the one that the product would suggest, given those before it."""
    chosen: list[int] = []
    while len(chosen) < len(solved):
        left = [r for r in solved if r not in chosen]
        worth = [
            view.mean_gain(view.gains(np.isin(view.rows.run_index, [*chosen, r]))) for r in left
        ]
        chosen.append(left[int(np.argmax(worth))])
        yield chosen[-1]


def _until(view: Prospect, order: Iterator[int], most: int) -> int | None:
    """How many runs bring every pair to the limit of odds."""
    chosen: list[int] = []
    for run in order:
        chosen.append(run)
        if min(_gains(view, chosen)) >= LIMIT:
            return len(chosen)
        if len(chosen) == most:
            return None
    return None
