"""What the second version of the answer has to reach, measured on any version.

    targets      every measure with its interval, what it has to reach, and the oracle beside it
    calibration  expected calibration error of each family
    NAMES        what the families are called in the table

Shares have Wilson's interval, distances from the oracle that of paired shares, calibration errors
one from 400 resamples.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from reference.rig.instrument import TOGETHER
from trial import claims
from trial.adapter import NOTHING_MISSING
from trial.claims import Outcome
from trial.families import FAMILIES
from trial.grades import true_statement
from trial.score import Z95, Measure, mean, share

STRONG = 8.0
NUMBERS = {
    "contact_stiffness": "contact_stiffness_rel",
    "torque_scale": "torque_gain_rel",
    "preload_scale": "preload_gain_rel",
    "sensor_gain": "sensor_gain_rel",
}
"""Numbers of drive and rig, and what the rig calls how far their logarithms are off."""
WORDS = {"white": "white", TOGETHER: "zeros and correlation"}
NAMES = {"one": "single", "two": "pair", "three": "triple"}
Event = Callable[[Outcome], bool]


def targets(outcomes: Sequence[Outcome]) -> list[Measure]:
    """Every measure that these outcomes can tell."""
    good = claims.answered(outcomes)
    return [
        *_alarms(good),
        *_singles(good),
        *_pairs(good),
        *_triples(good),
        *_spoken(good),
        *_others(good),
        *_outside(good),
        *_small(good),
        *_confident(good),
        *calibration(good),
        *_pulls(good),
        *_speed(good),
        share("no answer", "all", list(outcomes), lambda o: bool(o.get("error")), most=0.0),
    ]


# --- which ------------------------------------------------------------------------------------


def _of(outcomes: Sequence[Outcome], *families: str) -> list[Outcome]:
    return [o for o in outcomes if o["family"] in families]


def _noise(outcomes: Sequence[Outcome], *kinds: str) -> list[Outcome]:
    return [o for o in outcomes if o["truth"]["noise"]["kind"] in kinds]


def _quiet(outcomes: Sequence[Outcome]) -> list[Outcome]:
    """Noise alone: no effect, no display, no artefact."""
    bare = [o for o in _of(outcomes, "slide", "spring") if not o["truth"]["hidden"]]
    return [*_of(outcomes, "null"), *_noise(_of(outcomes, "coarse"), TOGETHER), *bare]


def _at(outcomes: Sequence[Outcome], d: float) -> list[Outcome]:
    return [o for o in outcomes if abs(o["truth"]["d"] / d - 1) < 0.15]


def _from(outcomes: Sequence[Outcome], d: float) -> list[Outcome]:
    return [o for o in outcomes if o["truth"]["d"] >= 0.94 * d]


def by_oracle(event: Event) -> Event:
    """The same of what the oracle says."""
    return lambda o: event({**o, "answer": o["oracle"]["answer"]})


def _behind(
    name: str, where: str, outcomes: Sequence[Outcome], event: Event, most: float | None
) -> Measure:
    """How far the share stays behind the oracle's, on the same sets (interval: Agresti, Min 2005,
    half a set added to each of the four outcomes of a pair)."""
    asked = [o for o in outcomes if o.get("oracle")]
    gaps = [int(by_oracle(event)(o)) - int(event(o)) for o in asked]
    name = f"  {name}, behind the oracle"
    n, lost, won = len(gaps), gaps.count(1), gaps.count(-1)
    if not n:
        return Measure(name, where, math.nan, math.nan, math.nan, 0, most=most)
    middle = (lost - won) / (n + 2)
    half = Z95 * math.sqrt(lost + won + 1 - (lost - won) ** 2 / (n + 2)) / (n + 2)
    value = (lost - won) / n
    low, high = min(middle - half, value), max(middle + half, value)
    return Measure(name, where, value, max(low, -1.0), min(high, 1.0), n, most=most)


def _three(
    name: str,
    where: str,
    outcomes: Sequence[Outcome],
    event: Event,
    reach: tuple[float | None, float | None],
) -> list[Measure]:
    """A share, the oracle's, and how far behind it is. reach: at least, and behind at most."""
    least, most = reach
    return [
        share(name, where, outcomes, event, least=least),
        share("  the oracle", where, [o for o in outcomes if o.get("oracle")], by_oracle(event)),
        _behind(name, where, outcomes, event, most),
    ]


# --- the measures -----------------------------------------------------------------------------


def _alarms(outcomes: Sequence[Outcome]) -> list[Measure]:
    quiet, coarse = _quiet(outcomes), _of(outcomes, "coarse")
    coarse = [o for o in coarse if o not in _noise(coarse, TOGETHER)]
    found = [share("false alarm", "noise alone", quiet, claims.alarms, most=0.05)]
    for kind in dict.fromkeys(o["truth"]["noise"]["kind"] for o in quiet):
        found.append(share("  false alarm", kind, _noise(quiet, kind), claims.alarms))
    found.append(share("false alarm", "coarse display", coarse, claims.alarms, most=0.07))
    for kind in dict.fromkeys(o["truth"]["noise"]["kind"] for o in coarse):
        found.append(share("  false alarm", kind, _noise(coarse, kind), claims.alarms))
    for family, where in (("artefact", "artefacts"), ("spring_artefact", "artefacts, springs")):
        found += _under_artefacts(_of(outcomes, family), where)
    return found


def _under_artefacts(outcomes: Sequence[Outcome], where: str) -> list[Measure]:
    bare, physics = [o for o in outcomes if not o["truth"]["hidden"]], claims.speaks_of_physics
    most = None if "springs" in where else 0.05
    found = [share("named as physics", where, bare, physics, most=most)]
    for kind in dict.fromkeys(o["truth"]["noise"]["kind"] for o in bare):
        found.append(share("  named as physics", kind, _noise(bare, kind), physics))
    found.append(share("  any alarm", where, bare, claims.alarms))
    some = [o for o in outcomes if o["truth"]["hidden"]]
    found.append(share("  friction held", where, some, claims.all_held))
    found.append(share("  friction named", where, some, claims.named))
    return found


def _singles(outcomes: Sequence[Outcome]) -> list[Measure]:
    every = _of(outcomes, "one")
    strong, found = _from(every, STRONG), []
    for kind, word in WORDS.items():
        place = f"{word}, d >= 8"
        found += _three("single held", place, _noise(strong, kind), claims.all_held, (0.95, 0.05))
    others = [o for o in strong if o["truth"]["noise"]["kind"] not in WORDS]
    found += _three("single held", "other noises, d >= 8", others, claims.all_held, (None, None))
    for d in (6.0, 8.0, 12.0):
        these = _at(every, d)
        found += _three("single named", f"d = {d:g}", these, claims.named, (None, 0.10))
    return found


def _pairs(outcomes: Sequence[Outcome]) -> list[Measure]:
    strong, found = _from(_of(outcomes, "two"), STRONG), []
    for kind, word in WORDS.items():
        place = f"{word}, d >= 8"
        found += _three("pair held", place, _noise(strong, kind), claims.all_held, (0.75, 0.10))
    others = [o for o in strong if o["truth"]["noise"]["kind"] not in WORDS]
    found += _three("pair held", "other noises, d >= 8", others, claims.all_held, (None, None))
    found.append(share("  one of the two held", "d >= 8", strong, claims.part_held))
    found += _three("pair named", "d >= 8", strong, claims.named, (None, 0.15))
    return found


def _triples(outcomes: Sequence[Outcome]) -> list[Measure]:
    strong = _from(_of(outcomes, "three"), 12.0)
    return [
        *_three("triple held", "d >= 12", strong, claims.all_held, (0.60, None)),
        *_three("triple named", "d >= 12", strong, claims.named, (None, None)),
    ]


def _spoken(outcomes: Sequence[Outcome]) -> list[Measure]:
    found = []
    for where, families in (
        ("singles", ("one",)),
        ("pairs", ("two",)),
        ("triples", ("three",)),
        ("all of these", ("one", "two", "three")),
    ):
        these = [(claims.spoken(o), claims.accepted(o)) for o in _of(outcomes, *families)]
        sizes = [len(said) / len(hidden) for said, hidden in these if said]
        most = 1.5 if where == "all of these" else None
        found.append(mean("effects spoken of for each hidden", where, sizes, most=most))
    return found


def _others(outcomes: Sequence[Outcome]) -> list[Measure]:
    """Families for which no figure is asked."""
    found = []
    for family in ("strong", "slide", "spring", "spring_logged"):
        these = [o for o in _of(outcomes, family) if claims.accepted(o)]
        found += _three(f"{family}: held", "d >= 8", these, claims.all_held, (None, None))
        found += _three(f"{family}: named", "d >= 8", these, claims.named, (None, None))
    return found


def _names_alone(o: Outcome) -> bool:
    """A name without a word of what remains."""
    answer = o["answer"]
    named = set(answer["effects"]) - claims.beside(o)
    return bool(named or answer["rivals"]) and not claims.tells_unnamed(o)


def _outside(outcomes: Sequence[Outcome]) -> list[Measure]:
    strong = [o for o in outcomes if claims.unnamed(o) and o["truth"]["d"] >= 11.4]
    found = [share("outside: a name alone", "d >= 12", strong, _names_alone, most=0.02)]
    for family in ("outside", "spring"):
        these = _of(strong, family)
        where = f"{family}, d >= 12"
        found.append(share("  outside: a name alone", where, these, _names_alone))
        found.append(share("  outside: says that more is left", where, these, claims.tells_unnamed))
    return found


def _certain(o: Outcome) -> bool:
    return bool(set(o["answer"]["effects"]) - {"unknown"})


def _small(outcomes: Sequence[Outcome]) -> list[Measure]:
    small, lawless = _of(outcomes, "small"), _of(outcomes, "lawless")
    none = [o for o in small if not o["truth"]["hidden"]]
    some = [o for o in small if o["truth"]["hidden"]]
    few = [*none, *lawless]
    found = [share("an effect certain", "lawless, small without one", few, _certain, most=0.0)]
    found.append(share("  an effect certain", "lawless", lawless, _certain))
    found.append(share("  nothing is missing", "lawless", lawless, _says_nothing))
    found.append(share("  an effect certain", "small, without one", none, _certain))
    false = share("  a false effect certain", "small, with one", some, _false)
    return [
        *found,
        false,
        *_three("  held", "small, with one", some, claims.all_held, (None, None)),
    ]


def _false(o: Outcome) -> bool:
    return bool(claims.false_certain(o))


def _says_nothing(o: Outcome) -> bool:
    return o["answer"]["kind"] in NOTHING_MISSING and not _certain(o)


# --- probabilities ----------------------------------------------------------------------------


def _confident(outcomes: Sequence[Outcome]) -> list[Measure]:
    asked = [o for o in outcomes if o["family"] not in ("confounded", "parameter_only")]
    sure = [o for o in asked if claims.confident(o)]
    name = "p >= 0.9: truth not held, or false name"
    found = [
        share("p >= 0.9: no truth held, or a false name certain", "all", sure, _wrong, most=0.03),
        share(name, "all", sure, claims.misleads),
    ]
    for family in dict.fromkeys(o["family"] for o in asked):
        these = _of(sure, family)
        found.append(share(f"  {name}", NAMES.get(family, family), these, claims.misleads))
    none = [o for o in sure if claims.accepted(o)]
    found.append(share("  p >= 0.9: no truth held at all", "effects", none, _nothing_true))
    return found


def _nothing_true(o: Outcome) -> bool:
    return not claims.part_held(o)


def _wrong(o: Outcome) -> bool:
    """What `claims.misleads` is but for half a truth: of two effects one held, the other open."""
    if claims.accepted(o):
        return bool(claims.false_certain(o)) or _nothing_true(o)
    return claims.misleads(o)


def event(o: Outcome) -> bool:
    """What the stated probability is the probability of."""
    return true_statement(o) if o["family"] in FAMILIES else claims.is_so(o)


def calibration_error(stated: np.ndarray[Any, Any], true: np.ndarray[Any, Any]) -> float:
    """Expected calibration error in ten bins of the stated probability."""
    bins = np.minimum((stated * 10).astype(int), 9)
    off = [abs(float(np.sum(stated[bins == b] - true[bins == b]))) for b in np.unique(bins)]
    return sum(off) / len(stated) if len(stated) else math.nan


def calibration(outcomes: Sequence[Outcome]) -> list[Measure]:
    """Of each family, and of all; an undecided answer claims nothing."""
    outcomes = [o for o in outcomes if not o["answer"].get("undecided")]
    found, rng = [], np.random.default_rng(1)
    families = list(dict.fromkeys(o["family"] for o in outcomes))
    for where, these in [(f, _of(outcomes, f)) for f in families] + [("all", list(outcomes))]:
        stated = np.array([o["answer"]["probability"] for o in these])
        true = np.array([float(event(o)) for o in these])
        picks = rng.integers(0, max(len(these), 1), (400, len(these)))
        again = [calibration_error(stated[p], true[p]) for p in picks] if len(these) else [math.nan]
        low, high = np.quantile(again, [0.025, 0.975])
        off = calibration_error(stated, true)
        place = NAMES.get(where, where)
        row = Measure(
            "calibration error", place, off, float(low), float(high), len(these), most=0.05, unit=""
        )
        found.append(row)
    return found


# --- speed ------------------------------------------------------------------------------------


def _pulls(outcomes: Sequence[Outcome]) -> list[Measure]:
    """How far drive numbers are off after pairs that are held, in their standard uncertainties:
    root mean square, with the interval of chi-squared."""
    from scipy.stats import chi2

    held = [o for o in _of(outcomes, "two") if o.get("drive") and claims.all_held(o)]
    found = []
    for number, shift in NUMBERS.items():
        pulls = [
            (off - math.expm1(o["truth"]["shifts"][shift])) / u
            for o in held
            if shift in o["truth"].get("shifts", {}) and number in o["drive"]
            for off, u in [o["drive"][number]]
        ]
        if pulls:
            square, n = float(np.sum(np.square(pulls))), len(pulls)
            low, high = (math.sqrt(square / chi2.ppf(p, n)) for p in (0.975, 0.025))
            rms = math.sqrt(square / n)
            found.append(
                Measure("rms error in u, after a pair", number, rms, low, high, n, unit="")
            )
    return found


def _speed(outcomes: Sequence[Outcome]) -> list[Measure]:
    """Processor time of an answer, one thread; 20,000 readings are timed by benches/diagnosis."""
    timed = [o for o in outcomes if o.get("cpu_seconds") and o["truth"].get("readings", 0) >= 300]
    seconds = np.sort([o["cpu_seconds"] for o in timed])
    n = len(seconds)
    if not n:
        return []
    half = 0.98 * math.sqrt(n)
    low, high = (seconds[int(np.clip(n / 2 + s * half, 0, n - 1))] for s in (-1, 1))
    where = "300 to 600 readings, median"
    middle = float(np.median(seconds))
    return [
        Measure("seconds an answer", where, middle, float(low), float(high), n, most=1.0, unit="")
    ]
