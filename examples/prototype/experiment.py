"""The experiment of the 2017 paper, as far as its text states it, and what can be said of it.

    python examples/prototype/experiment.py                print the page
    python examples/prototype/experiment.py --page FILE    write it

The paper publishes no reading, only differences to a calculated curve that it does not publish
either. So every statement here holds under a condition: which calculated curve. `stated.csv` has
the paper's figures, `prototype.toml` the drive; `budget` the sensor, `conditions` the curves,
`diagnosis` what CBPT says of each, `effect_rows` which effect could do it and which cannot.
"""

from __future__ import annotations

import csv
import sys
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import cbpt

Array = NDArray[np.float64]
HERE = Path(__file__).parent
ARCSEC = np.pi / 648000

# Young's moduli, GPa. The paper names no material; the angle goes with the modulus to the power
# -2/3, so a softer material stands for any softer calculated curve.
CONDITIONS = {"bearing steel": 208.0, "bronze or cast iron": 110.0, "aluminium": 70.0}
UNLOADED_ARCSEC = 4.58
TORQUES_NM = np.arange(0.0, 5.01, 0.5)

# The number of an effect that is varied over its range in the library, and what stays with it.
EFFECTS: dict[str, tuple[str, dict[str, float]]] = {
    "bearing_play": ("clearance_um", {}),
    "eccentric_bearing": ("reference_deflection_um", {"exponent": 0.9}),
    "output_torsion": ("compliance_arcsec_per_Nm", {}),
    "preload_loss": ("lost_share", {}),
    "run_in": ("permanent_set_arcsec", {}),
    "rough_contact": ("exponent", {}),
    "preload_spring": ("spring_rate_N_per_um", {}),
    "friction_hysteresis": ("friction_radius_um", {"engagement_angle_arcsec": 5.0}),
    "contact_stiffness": ("stiffness_scale", {}),
    "contact_angle": ("contact_angle_shift_deg", {}),
    "preload_scale": ("preload_gain", {}),
    "torque_scale": ("torque_gain", {}),
    "sensor_gain": ("sensor_gain", {}),
}


# --- the sensor ---------------------------------------------------------------------------


def budget(angle_arcsec: float) -> list[tuple[str, str, float]]:
    """Contributions to the standard uncertainty of a reading: what, from what, u in arcsec."""
    lever_m, sensitivity_V_per_m = 0.1, 7990.0
    step_V = 10 / 4096
    step = step_V / sensitivity_V_per_m / lever_m / ARCSEC
    return [
        (
            "resolution",
            f"12 bit of 10 V at 7.99 V/mm: {step:.2f} arcsec a step",
            step / np.sqrt(12),
        ),
        ("nonlinearity", "0.84 % of the reading, a limit", 0.0084 * angle_arcsec / np.sqrt(3)),
        ("sensitivity", "0.12 % of the reading, a limit", 0.0012 * angle_arcsec / np.sqrt(3)),
        ("lever arm", "0.5 mm of 100 mm, assumed, a limit", 0.005 * angle_arcsec / np.sqrt(3)),
    ]


def u_of_reading(angle_arcsec: float) -> float:
    """Standard uncertainty of a reading without its gain, which `[uncertainty]` states."""
    return float(budget(angle_arcsec)[0][2])


# --- the readings, under a condition ------------------------------------------------------


@cache
def stated() -> tuple[dict[str, float], ...]:
    """The rows of `stated.csv`."""
    with (HERE / "stated.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return tuple({k: float(v) for k, v in row.items() if k != "what"} for row in rows)


def document(modulus_GPa: float) -> dict[str, Any]:
    """The case of the prototype with another material."""
    case = tomllib.loads((HERE / "prototype.toml").read_text(encoding="utf-8"))
    case["material"]["youngs_modulus_GPa"] = modulus_GPa
    return case


@cache
def calculated(modulus_GPa: float, preload_N: float, torque_Nm: float) -> tuple[float, float]:
    """Largest elastic angle, arcsec, and the crank angle where it is, deg."""
    if torque_Nm == 0:
        return 0.0, 0.0
    found = cbpt.Drive.from_dict(document(modulus_GPa)).largest_elastic_angle(torque_Nm, preload_N)
    assert found is not None, "the prototype holds every torque of the test"
    return found.elastic_angle_arcsec, found.input_angle_deg


def readings(modulus_GPa: float) -> dict[str, list[float]]:
    """The readings that the paper's differences make with one calculated curve."""
    table: dict[str, list[float]] = {
        "run": [],
        "torque_Nm": [],
        "preload_N": [],
        "input_angle_deg": [],
        "elastic_angle_arcsec": [],
        "u_elastic_angle_arcsec": [],
    }
    seen: set[float] = set()
    for row in stated():
        preload = row["preload_N"]
        unloaded = {**row, "torque_Nm": 0.0, "calculated_minus_measured_arcsec": 0.0}
        for point in [row] if preload in seen else [unloaded, row]:
            angle, crank = calculated(modulus_GPa, preload, point["torque_Nm"])
            angle -= point["calculated_minus_measured_arcsec"]
            u = np.hypot(point["u_arcsec"] if point["torque_Nm"] else 0.0, u_of_reading(angle))
            new = (preload, point["torque_Nm"], preload, crank, angle, float(u))
            for column, value in zip(table.values(), new, strict=True):
                column.append(value)
        seen.add(preload)
    return table


def conditions() -> Iterator[list[str]]:
    """Rows of the table of calculated curves: measured out of calculated at the stated points."""
    for name, modulus in CONDITIONS.items():
        cells = []
        for row in stated():
            if row["calculated_minus_measured_arcsec"] == 0:
                continue
            angle = calculated(modulus, row["preload_N"], row["torque_Nm"])[0]
            left = angle - row["calculated_minus_measured_arcsec"]
            cells.append(f"{left:.1f} of {angle:.1f}")
        yield [f"{name}, {modulus:g} GPa", *cells]


def diagnosis(condition: str) -> list[str]:
    """A row of the table of diagnoses."""
    modulus = CONDITIONS[condition]
    case, table = document(modulus), readings(modulus)
    before = cbpt.compare(case, table).overall
    found = cbpt.diagnose(case, table)
    ways = [row for row in found.to_dict()["combinations"] if row["probability"] >= 0.1]
    sets = [
        " + ".join([*row["effects"], *(["something without a name"] if row["unnamed"] else [])])
        for row in ways
    ]
    told = "; ".join(names or "no effect" for names in sets)
    assert before is not None
    return [condition, f"{before.rmse_arcsec:.0f}", found.verdict.kind, told or "none above 0.1"]


# --- which effect could do it -------------------------------------------------------------


def sizes(effect: str) -> Array:
    """Sizes over the library's range of an effect."""
    number = EFFECTS[effect][0]
    (spec,) = (s for s in cbpt._core.effect_specs() if s.id == effect)
    (found,) = (n for n in spec.parameters if n.display_name == number)
    low, high = (end / found.display_size for end in found.range)
    return np.geomspace(low, high, 41) if low > 0 else np.linspace(low, high, 41)


@cache
def changes(effect: str, modulus_GPa: float) -> dict[tuple[float, float], Array]:
    """What an effect adds to the readings on the way up from zero torque, arcsec, for each of its
    sizes; NaN where the torque slips."""
    preloads = list(dict.fromkeys(row["preload_N"] for row in stated()))
    places = [(preload, float(torque)) for preload in preloads for torque in TORQUES_NM]
    preload_N, torque_Nm = np.array(places).T
    crank = np.radians([calculated(modulus_GPa, *place)[1] for place in places])
    run = np.repeat(np.arange(len(preloads)), len(TORQUES_NM))
    time_s = np.arange(len(places), dtype=np.float64)
    drive = cbpt.Drive.from_dict(document(modulus_GPa))
    predictor = cbpt._core.Predictor(drive, [effect], run, time_s, torque_Nm, preload_N, crank)
    number, rest = EFFECTS[effect]
    values = predictor.neutral()
    bare = predictor.predict(values).angle_rad
    names = [found for *_, found in predictor.parameters]
    for place, found in enumerate(names):
        if found.display_name in rest:
            values[place] = rest[found.display_name] * found.display_size
    (varied,) = (i for i, found in enumerate(names) if found.display_name == number)
    added = []
    for size in sizes(effect):
        values[varied] = size * names[varied].display_size
        added.append(predictor.predict(values).angle_rad - bare)
    table = np.array(added).T / ARCSEC
    return dict(zip(places, table, strict=True))


def size_for(effect: str, modulus_GPa: float, row: Mapping[str, float]) -> float | None:
    """The smallest size that makes the stated difference at one point; None where none does."""
    grid = sizes(effect)
    miss = changes(effect, modulus_GPa)[row["preload_N"], row["torque_Nm"]]
    miss = miss + row["calculated_minus_measured_arcsec"]
    crossing = np.flatnonzero(miss[:-1] * miss[1:] <= 0)
    if not len(crossing):
        return None
    i = min(crossing, key=lambda k: abs(grid[k]))
    share = miss[i] / (miss[i] - miss[i + 1]) if miss[i] != miss[i + 1] else 0.0
    return float(grid[i] + share * (grid[i + 1] - grid[i]))


POINTS = tuple(row for row in stated() if row["calculated_minus_measured_arcsec"])
SMALLER = POINTS[:3]
"""Where the readings are smaller than calculated, at a low torque."""
WRONG_WAY = "wrong way"


def at_point(effect: str, modulus_GPa: float, row: Mapping[str, float]) -> float | str:
    """The size that makes the difference at one point; else how far the effect reaches."""
    size = size_for(effect, modulus_GPa, row)
    if size is not None:
        return size
    added = changes(effect, modulus_GPa)[row["preload_N"], row["torque_Nm"]]
    needed = -row["calculated_minus_measured_arcsec"]
    most = np.nanmax(added * np.sign(needed)) * np.sign(needed)
    return f"only {most:.0f} arcsec" if most * needed > 0.05 * needed**2 else WRONG_WAY


def verdict(found: Sequence[float | str]) -> str:
    """What the sizes at the points say of an effect."""
    smaller, sizes_there = found[:3], [size for size in found[:4] if isinstance(size, float)]
    if all(size == WRONG_WAY for size in smaller):
        return "cannot: it makes these readings larger"
    if not any(isinstance(size, float) for size in smaller):
        return "cannot: too little"
    if len(sizes_there) < 4:
        return "a part at most"
    spread = max(sizes_there) - min(sizes_there)
    alike = spread < 0.2 * max(abs(size) for size in sizes_there)
    return "could" if alike else "a part at most: no one size fits"


def effect_rows(modulus_GPa: float) -> Iterator[list[str]]:
    """Rows of the table of effects."""
    for effect, (number, _) in EFFECTS.items():
        found = [at_point(effect, modulus_GPa, row) for row in POINTS]
        cells = [size if isinstance(size, str) else f"{float(f'{size:.2g}'):g}" for size in found]
        yield [f"`{effect}`", f"`{number}`", *cells, verdict(found)]


def makes_larger() -> list[str]:
    """Effects that make the readings larger at low torque under every condition."""
    return [
        effect
        for effect in EFFECTS
        if all(
            at_point(effect, modulus, row) == WRONG_WAY
            for modulus in CONDITIONS.values()
            for row in SMALLER
        )
    ]


# --- the page -----------------------------------------------------------------------------


def table(head: Sequence[str], rows: Iterator[list[str]]) -> str:
    """A table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def at(row: Mapping[str, float]) -> str:
    return f"{row['preload_N']:g} N, {row['torque_Nm']:g} N m"


def page() -> str:
    """The page of the documentation."""
    differences = [f"{row['calculated_minus_measured_arcsec']:g} arcsec" for row in POINTS]
    arm_m = cbpt.Drive.from_dict(document(208.0)).eccentricity_m * 27
    clearance_um = UNLOADED_ARCSEC * ARCSEC * arm_m * 1e6
    contributions = [
        [what, source, f"{u:.2f}", f"{budget(100.0)[i][2]:.2f}"]
        for i, (what, source, u) in enumerate(budget(40.0))
    ]
    together = [f"{np.sqrt(sum(u**2 for *_, u in budget(angle))):.2f}" for angle in (40.0, 100.0)]
    text = (HERE / "page.md").read_text(encoding="utf-8")
    places = {
        "budget": table(
            ["contribution", "from", "u at 40 arcsec", "u at 100 arcsec"],
            iter([*contributions, ["together", "", *together]]),
        ),
        "conditions": table(
            ["calculated with", *map(at, POINTS)],
            iter([["calculated less measured", *differences], *conditions()]),
        ),
        "diagnoses": table(
            ["calculated with", "rmse, arcsec", "verdict", "combinations from probability 0.1"],
            map(diagnosis, CONDITIONS),
        ),
        "effects": table(
            ["effect", "its size", *map(at, POINTS), "alone"],
            effect_rows(CONDITIONS["bearing steel"]),
        ),
        "larger": ", ".join(f"`{effect}`" for effect in makes_larger()),
        "clearance": f"{clearance_um:.2f}",
        "range": f"{0.0084 * 1e-3 / 0.1 / ARCSEC:.0f}",
    }
    for name, filled in places.items():
        text = text.replace("{" + name + "}", filled)
    return text


def main(arguments: Sequence[str]) -> int:
    if not arguments:
        print(page(), end="")
        return 0
    _, name = arguments
    Path(name).write_text(page(), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
