"""The score of a trial: every measure of what was answered against what was hidden.

measures    every number of the table, each with its Wilson interval and whether it is reached
reliability bins of stated probability against the share that was right
intervals   whether 95 % intervals of parameters hold the truth
table       the measures as text
document    the same as plain values
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

from trial.grades import Grade, Outcome, contains, grade, size, true_statement

SEPARABLE = 0.8
"""Largest correlation with a rival up to which one name is asked for."""
Z95 = 1.959964
WORTH = 0.05
"""Fall of the error, in standard deviations of the noise, from which its share is asked for."""
GROUPS = {"singles": ("single",), "pairs": ("pair",), "both": ("single", "pair")}


# --- numbers ----------------------------------------------------------------------------------


def wilson(hits: int, n: int, z: float = Z95) -> tuple[float, float]:
    """Interval of a share (Wilson 1927); 0 to 1 where there is nothing to go by."""
    if n == 0:
        return 0.0, 1.0
    share, spread = hits / n, z * z / n
    middle = (share + spread / 2) / (1 + spread)
    half = z / (1 + spread) * math.sqrt(share * (1 - share) / n + spread / (4 * n))
    return max(0.0, middle - half), min(1.0, middle + half)


@dataclass(frozen=True)
class Measure:
    """One line of the table. value: the share or the number; low, high: 95 % interval, equal to the
    value where there is none. least, most: what it has to reach. sets: how many it rests on."""

    name: str
    where: str
    value: float
    low: float
    high: float
    sets: int
    least: float | None = None
    most: float | None = None
    unit: str = "%"

    @property
    def reached(self) -> str:
        """yes, no, or open where the interval holds both; empty where nothing is asked."""
        if not self.sets or (self.least is None and self.most is None):
            return ""
        least, most = self.least or -math.inf, math.inf if self.most is None else self.most
        if self.low >= least and self.high <= most:
            return "yes"
        return "no" if self.high < least or self.low > most else "open"


def share(
    name: str,
    where: str,
    outcomes: Sequence[Outcome],
    event: Callable[[Outcome], bool],
    least: float | None = None,
    most: float | None = None,
) -> Measure:
    """How often something happens."""
    hits, n = sum(map(event, outcomes)), len(outcomes)
    value = hits / n if n else math.nan
    return Measure(name, where, value, *wilson(hits, n), n, least, most)


def mean(
    name: str,
    where: str,
    values: Sequence[float],
    unit: str = "",
    least: float | None = None,
    most: float | None = None,
) -> Measure:
    """A mean with the interval of its standard error."""
    n = len(values)
    if not n:
        return Measure(name, where, math.nan, math.nan, math.nan, 0, least, most, unit)
    middle = sum(values) / n
    spread = math.sqrt(sum((v - middle) ** 2 for v in values) / max(n - 1, 1) / n)
    low, high = middle - Z95 * spread, middle + Z95 * spread
    return Measure(name, where, middle, low, high, n, least, most, unit)


# --- the table --------------------------------------------------------------------------------


def measures(outcomes: Sequence[Outcome]) -> list[Measure]:
    """Every measure that these outcomes can tell."""
    return [
        *_false_alarms(outcomes),
        *_names(outcomes),
        *_sets(outcomes),
        *_outsiders(outcomes),
        *_errors_fall(outcomes),
        *_probabilities(outcomes),
        *_coverage(outcomes),
        share("no answer", "all", list(outcomes), lambda o: bool(o.get("error")), most=0.0),
    ]


def _of(outcomes: Sequence[Outcome], *families: str) -> list[Outcome]:
    return [o for o in outcomes if o["family"] in families]


def _strengths(outcomes: Sequence[Outcome]) -> list[float]:
    return sorted({o["truth"]["d"] for o in outcomes})


def _false_alarms(outcomes: Sequence[Outcome]) -> list[Measure]:
    found, null = [], _of(outcomes, "null")
    for kind in dict.fromkeys(o["truth"]["noise"]["kind"] for o in null):
        these = [o for o in null if o["truth"]["noise"]["kind"] == kind]
        most = 0.05 if kind == "white" else 0.07
        found.append(share("false alarm", kind, these, lambda o: grade(o) == "wrong", most=most))
    for criterion in ("aic", "bic"):
        alarm = f"false alarm of plain {criterion.upper()}"
        found.append(share(alarm, "white", _noise(null, "white"), _picks_any(criterion)))
        found.append(share(alarm, "run_offset", _noise(null, "run_offset"), _picks_any(criterion)))
    return found


def _noise(outcomes: Sequence[Outcome], kind: str) -> list[Outcome]:
    return [o for o in outcomes if o["truth"]["noise"]["kind"] == kind and not o.get("error")]


def _picks_any(criterion: str) -> Callable[[Outcome], bool]:
    return lambda o: bool(o["criteria"][criterion])


def _picks_truth(criterion: str) -> Callable[[Outcome], bool]:
    return lambda o: set(o["criteria"][criterion]) == set(o["truth"]["answer"]["effects"])


def separable(outcome: Outcome) -> bool:
    """Whether no rival looks too much like what is hidden, as the rig can tell."""
    return max(outcome["oracle"]["rivals"].values(), default=0.0) <= SEPARABLE


def _names(outcomes: Sequence[Outcome]) -> list[Measure]:
    singles = [o for o in _of(outcomes, "single") if o.get("oracle")]
    answered = [o for o in singles if not o.get("error")]
    clear = [o for o in singles if separable(o)]
    found = []
    for d in _strengths(singles):
        these = [o for o in clear if o["truth"]["d"] == d]
        least = {6.0: 0.85}.get(d, 0.95 if d >= 8 else None)
        found.append(share("right single name", f"d = {d:g}, rivals <= 0.8", these, _right, least))
        found.append(share("  the oracle", f"d = {d:g}, rivals <= 0.8", these, _oracle_right))
        every = [o for o in singles if o["truth"]["d"] == d]
        found.append(share("  any rivals", f"d = {d:g}", every, _right))
        for criterion in ("aic", "bic"):
            tried = [o for o in answered if o["truth"]["d"] == d]
            name = f"  plain {criterion.upper()}, any rivals"
            found.append(share(name, f"d = {d:g}", tried, _picks_truth(criterion)))
    strong = [o for o in clear if o["truth"]["d"] >= 6]
    gap = [float(_oracle_right(o)) - float(_right(o)) for o in strong]
    found.append(mean("behind the oracle", "d >= 6, rivals <= 0.8", gap, "%", most=0.05))
    parameters = _of(outcomes, "parameter_only")
    found.append(share("parameter named", "3 to 6 sigma", parameters, _right))
    told = _is("right", "contains")
    found.append(share("parameter named or a rival", "3 to 6 sigma", parameters, told))
    return found


def _right(outcome: Outcome) -> bool:
    return grade(outcome) == "right"


def _oracle_right(outcome: Outcome) -> bool:
    return bool([outcome["oracle"]["names"]] == outcome["truth"]["answer"]["effects"])


def _sets(outcomes: Sequence[Outcome]) -> list[Measure]:
    found = []
    for where, families in GROUPS.items():
        strong = [o for o in _of(outcomes, *families) if o["truth"]["d"] >= 6]
        least, most = (0.95, 1.5) if where == "both" else (None, None)
        place = f"{where}, d >= 6"
        found.append(share("contains the truth", place, strong, _holds, least))
        spoken = [o for o in strong if not o.get("error") and size(o["answer"])]
        sizes = [size(o["answer"]) / len(o["truth"]["answer"]["effects"]) for o in spoken]
        found.append(mean("  mean size, for each hidden", place, sizes, most=most))
    wrong = [o for o in _of(outcomes, "single", "pair") if o["truth"]["d"] >= 6]
    found.append(share("a wrong name", "singles and pairs, d >= 6", wrong, _is("wrong", "twin")))
    exact = [o for o in _of(outcomes, "confounded") if o["truth"]["answer"]["exact"]]
    found.append(share("exact twin named singly", "confounded", exact, _is("twin"), most=0.02))
    found.append(share("rivals told", "confounded", _of(outcomes, "confounded"), _right))
    return found


def _is(*grades: Grade) -> Callable[[Outcome], bool]:
    return lambda o: grade(o) in grades


def _holds(outcome: Outcome) -> bool:
    return not outcome.get("error") and contains(
        outcome["answer"], outcome["truth"]["answer"]["effects"]
    )


def _outsiders(outcomes: Sequence[Outcome]) -> list[Measure]:
    found, outside = [], _of(outcomes, "outside")
    for d in _strengths(outside):
        these = [o for o in outside if o["truth"]["d"] == d]
        most, least = (0.02, 0.95) if d >= 12 else (None, None)
        found.append(share("outside: wrong name", f"d = {d:g}", these, _is("wrong"), most=most))
        found.append(share("outside: says unknown", f"d = {d:g}", these, _right, least))
    strong = [o for o in outside if o["truth"]["d"] >= 12]
    found.append(share("outside: wrong name", "d >= 12", strong, _is("wrong"), most=0.02))
    found.append(share("outside: says unknown", "d >= 12", strong, _right, 0.95))
    return found


def _errors_fall(outcomes: Sequence[Outcome]) -> list[Measure]:
    """How far the error on held-out readings falls, against what the true effect refitted gives.

    Mean over the sets in which the truth gives a fall worth its name: a held-out end of the range
    is predicted from beyond, where even the true effect, its size refitted, may do worse than none.
    """
    found = []
    for where, families in GROUPS.items():
        these = [
            o
            for o in _of(outcomes, *families)
            if o["truth"]["d"] >= 6 and not o.get("error") and o["oracle"]["held_out_arcsec"]
        ]
        place = f"{where}, d >= 6"
        least = 0.90 if where == "both" else None
        # From the refitted numbers: what the drive as stated leaves beyond them anybody removes.
        refitted = [f for o in these if (f := _fall(o, "refitted")) is not None]
        found.append(mean("held-out error fall", place, refitted, "%", least))
        stated = [f for o in these if (f := _fall(o, "stated")) is not None]
        found.append(mean("  from the drive as stated", place, stated, "%"))
    return found


def _fall(outcome: Outcome, start: str) -> float | None:
    """Share of the truth's fall, between -1 and 1.5; None where the truth gives next to nothing."""
    held, u = outcome["held_out"], outcome["truth"]["noise"]["u_arcsec"]
    best = held[start] - outcome["oracle"]["held_out_arcsec"]
    if best < WORTH * u:
        return None
    return float(min(max((held[start] - held["after"]) / best, -1.0), 1.5))


# --- probabilities ----------------------------------------------------------------------------


def reliability(outcomes: Sequence[Outcome], bins: int = 10) -> list[dict[str, float]]:
    """Bins of stated probability: sets, mean stated, share true with its interval."""
    rows = []
    answered = [o for o in outcomes if not o.get("error")]
    for b in range(bins):
        low, high = b / bins, (b + 1) / bins
        inside = [
            o
            for o in answered
            if low <= o["answer"]["probability"] < high
            or (b == bins - 1 and o["answer"]["probability"] >= high)
        ]
        if inside:
            hits = sum(map(true_statement, inside))
            stated = sum(o["answer"]["probability"] for o in inside) / len(inside)
            interval = wilson(hits, len(inside))
            rows.append(
                {
                    "from": low,
                    "to": high,
                    "sets": len(inside),
                    "stated": stated,
                    "true": hits / len(inside),
                    "true_low": interval[0],
                    "true_high": interval[1],
                }
            )
    return rows


def _probabilities(outcomes: Sequence[Outcome]) -> list[Measure]:
    answered = [o for o in outcomes if not o.get("error")]
    squares = [(o["answer"]["probability"] - float(true_statement(o))) ** 2 for o in answered]
    rows = reliability(outcomes)
    off = sum(r["sets"] * abs(r["stated"] - r["true"]) for r in rows) / max(len(answered), 1)
    error = Measure(
        "expected calibration error", "all", off, off, off, len(answered), most=0.05, unit=""
    )
    return [mean("Brier score", "all", squares), error]


# --- intervals of parameters ------------------------------------------------------------------

_FULL = 60 * math.pi / 648000
Values = Mapping[str, float]


def _wave(
    size: str, cosine: str, sine: str, sign: float
) -> dict[str, Callable[[Values, float], float]]:
    return {
        cosine: lambda v, t: v[size] * math.cos(v["phase_rad"]),
        sine: lambda v, t: sign * v[size] * math.sin(v["phase_rad"]),
    }


TRUE: dict[str, dict[str, Callable[[Values, float], float]]] = {
    "rough_contact": {"exponent": lambda v, t: 1.5 + v["excess"]},
    "sensor_nonlinearity": {
        "quadratic_per_rad": lambda v, t: v["error_rad"] * (1 - abs(v["cubic_share"])) / _FULL**2,
        "cubic_per_rad2": lambda v, t: v["error_rad"] * v["cubic_share"] / _FULL**3,
    },
    "drift": {"rate_rad_per_s": lambda v, t: v["total_rad"] / t},
    "eccentric_bearing": {
        "reference_deflection_m": lambda v, t: v["u_ref_m"],
        "exponent": lambda v, t: v["exponent"],
    },
    "bearing_play": {"clearance_m": lambda v, t: v["clearance_m"]},
    "output_torsion": {"compliance_rad_per_Nm": lambda v, t: v["compliance_rad_per_Nm"]},
    "eccentricity_error": _wave("offset_m", "offset_sine_m", "offset_cosine_m", 1.0),
    "run_in": {"permanent_set_rad": lambda v, t: v["set_rad"]},
    "creep": {
        "compliance_rad_per_Nm": lambda v, t: v["rate_rad_per_Nm"],
        "time_constant_s": lambda v, t: v["tau_s"],
    },
    "friction_hysteresis": {
        "friction_radius_m": lambda v, t: v["mu_T_m"],
        "engagement_angle_rad": lambda v, t: v["length_rad"],
    },
    "preload_loss": {"lost_share": lambda v, t: v["share"]},
    "preload_spring": {"spring_rate_N_per_m": lambda v, t: v["rate_N_per_m"]},
    "thermal_preload": {"rate_N_per_K": lambda v, t: v["rate_N_per_K"]},
    "wear": {"lost_share_per_s": lambda v, t: v["lost_share"] / t},
    "groove_pitch_error": _wave("amplitude_m", "cosine_m", "sine_m", -1.0),
    "plate_tilt": _wave("tilt_rad", "tilt_cosine_rad", "tilt_sine_rad", 1.0),
}
"""What a parameter of the library is in a rig that hides the same form; t: how long it lasts."""


def intervals(outcomes: Sequence[Outcome]) -> list[tuple[str, bool]]:
    """(effect.parameter, whether its 95 % interval holds the truth) where forms are the same."""
    found = []
    for o in _of(outcomes, "single"):
        hidden = o["truth"]["hidden"][0]
        if o.get("error") or hidden["form"] != "library" or o["truth"]["d"] < 6:
            continue
        given = o["parameters"].get(hidden["id"], {})
        for name, true in TRUE.get(hidden["id"], {}).items():
            p = given.get(name)
            if p is not None and p["u"]:
                off = abs(p["value"] - true(hidden["values"], o["truth"]["duration_s"]))
                found.append((f"{hidden['id']}.{name}", off <= Z95 * p["u"]))
    return found


def _coverage(outcomes: Sequence[Outcome]) -> list[Measure]:
    held = intervals(outcomes)
    total = Measure(
        "95 % intervals cover",
        "same form, d >= 6, named",
        sum(h for _, h in held) / len(held) if held else math.nan,
        *wilson(sum(h for _, h in held), len(held)),
        len(held),
        0.93,
        0.97,
    )
    found = [total]
    for name in sorted({n for n, _ in held}):
        these = [h for n, h in held if n == name]
        hits, n = sum(these), len(these)
        found.append(Measure(f"  {name}", "d >= 6", hits / n, *wilson(hits, n), n))
    return found


# --- as text and as JSON ----------------------------------------------------------------------


def _number(x: float, unit: str) -> str:
    if math.isnan(x):
        return "-"
    return f"{100 * x:.1f}" if unit == "%" else f"{x:.3f}"


def table(found: Sequence[Measure]) -> str:
    """One line a measure."""
    lines = [f"{'measure':40} {'where':28}{'value':>8}{'95 % interval':>18}{'sets':>6}  to reach"]
    for m in found:
        interval = f"{_number(m.low, m.unit)} .. {_number(m.high, m.unit)}"
        asked = [f">= {_number(m.least, m.unit)}"] if m.least is not None else []
        asked += [f"<= {_number(m.most, m.unit)}"] if m.most is not None else []
        value = _number(m.value, m.unit)
        line = f"{m.name:40} {m.where:28}{value:>8}{interval:>18}{m.sets:>6}"
        lines.append(f"{line}  {', '.join(asked)} {m.reached}".rstrip())
    return "\n".join(lines)


def plain(m: Measure) -> dict[str, Any]:
    """A measure as plain values, what is not finite as None."""
    values = {**asdict(m), "reached": m.reached}
    return {
        k: None if isinstance(v, float) and not math.isfinite(v) else v for k, v in values.items()
    }


def document(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """The score as plain values, NaN as None."""

    rows = [plain(m) for m in measures(outcomes)]
    return {"sets": len(outcomes), "measures": rows, "reliability": reliability(outcomes)}
