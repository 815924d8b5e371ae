"""One page of a drive, as a catalogue carries it.

    datasheet   a case -> HTML that needs no network and prints on one sheet of A4

Numbers come from the verbs of the same names: solve, preload, characterise, friction, transmission.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping
from html import escape
from os import PathLike
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive
from cbpt.design.costs import Costs, friction, friction_map
from cbpt.design.judge import at_load, effects_of, judge
from cbpt.design.transmission import transmission
from cbpt.errors import CbptError
from cbpt.figures import datasheet as figures
from cbpt.lab.characteristics.characterise import characterise
from cbpt.page.document.drawing import drawing_of
from cbpt.results import ARCSEC_PER_RAD, solve_many

Floats = NDArray[np.float64]
Row = tuple[str, str, str]
"""Name, value, unit."""

TITLE = "Cycloid ball planetary transmission"
# Loads of the pictures: torques on one side, and of a map torques and preloads.
_CURVE, _THRESHOLDS, _MAP = 61, 13, (13, 11)
_OVER = 1.2
_PRELOADS = (0.5, 1.0, 1.5)


def datasheet(
    case: Case | Drive | str | PathLike[str] | Mapping[str, Any],
    *,
    title: str = TITLE,
    torque_Nm: float | None = None,
    preload_N: float | None = None,
) -> str:
    """The data sheet of a drive, as one HTML page that needs no network.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The drive. `[rating]`, `[friction]` and `[operation]` are used where they are given.
    title : str
        What stands at the head of the page.
    torque_Nm, preload_N : float, optional
        The rated load. What is not given comes from `[load]` of the case.

    Returns
    -------
    str
        HTML. The same case gives the same page.

    Raises
    ------
    InvalidInputError
        A number is missing or not possible, or the reducer is a torsion spring.
    PlotError
        Matplotlib is not installed.
    """
    case = at_load(case, torque_Nm, preload_N)
    costs = friction(case)
    pictures = [
        ("Grooves and balls along the axis", "".join(_drawings(case))),
        ("Stiffness at three preloads", _stiffness(case)),
        ("Preload: thresholds and window", _window(case, costs)),
        ("Peak contact pressure", _pressures(case)),
        *_maps(case),
    ]
    blocks = [
        ("Drive", _drive_rows(case)),
        ("Accuracy", list(_accuracy_rows(case))),
        ("At the rated load", [*_load_rows(case), *_strength_rows(costs)]),
        ("Preload", _preload_rows(case, costs)),
        ("Friction and efficiency", _friction_rows(costs)),
    ]
    return _page(case, title, pictures, blocks)


# --- pictures -----------------------------------------------------------------------------


def _rated(case: Case) -> tuple[float, float]:
    assert case.torque_Nm is not None and case.preload_N is not None, "see at_load"
    return case.torque_Nm, case.preload_N


def _drawings(case: Case) -> Iterator[str]:
    """Both pairs, each without its solution's arrows."""
    solution = case.drive.solve(*_rated(case))
    for place, pair in enumerate(drawing_of(case.drive, solution, 0.0)["pairs"]):
        yield _own_names(figures.drawing_svg(pair), f"d{place}")


def _stiffness(case: Case) -> str:
    torque_Nm, preload_N = _rated(case)
    reach = _OVER * abs(torque_Nm)
    torque = np.linspace(-reach, reach, 2 * _CURVE + 1)
    curves = []
    for factor in _PRELOADS:
        found = solve_many(case.drive, torque, factor * preload_N)
        # From the angle without torque, where parts as made may have an error.
        angle = (found.elastic_angle_rad - found.elastic_angle_rad[_CURVE]) * ARCSEC_PER_RAD
        curves.append((f"{factor * preload_N:.4g} N", angle))
    return figures.stiffness_svg(torque, curves, torque_Nm)


def _window(case: Case, costs: Costs) -> str:
    torque_Nm, preload_N = _rated(case)
    torques = np.linspace(0.0, _OVER * abs(torque_Nm), _THRESHOLDS)
    nominal = case.drive.nominal()
    found = [nominal.preload(torque).drive for torque in torques]
    lines = [
        ("hold", np.array([t.hold_N for t in found])),
        ("continuous transmission", np.array([t.continuous_N for t in found])),
        ("zero backlash", np.array([t.zero_backlash_N for t in found])),
    ]
    at = abs(torque_Nm), preload_N
    return figures.window_svg(torques, lines, costs.preload_window_N, at)


def _pressures(case: Case) -> str:
    torque_Nm = _rated(case)[0]
    torques = np.linspace(0.0, _OVER * torque_Nm, _CURVE)
    found = judge(case, ["load.torque_Nm"], torques[:, None], pressures=True)
    pairs = [
        (name, found[f"{column}_pressure_Pa"] / 1e9)
        for name, column in (
            ("deceleration pair", "deceleration"),
            ("equal-speed pair", "equal_speed"),
        )
    ]
    return figures.pressure_svg(np.abs(torques), pairs, _limit_GPa(case), abs(torque_Nm))


def _maps(case: Case) -> Iterator[tuple[str, str]]:
    torque_Nm, preload_N = (abs(number) for number in _rated(case))
    torques = np.linspace(0.05, _OVER, _MAP[0]) * torque_Nm
    preloads = np.linspace(0.4, 1.6, _MAP[1]) * preload_N
    found = friction_map(case, torques[None, :], preloads[:, None])
    at = torque_Nm, preload_N
    yield (
        "Friction torque at the input",
        figures.map_svg(torques, preloads, 1e3 * found.friction_torque_Nm, "N mm", at),
    )
    yield (
        "Efficiency",
        figures.map_svg(torques, preloads, 100.0 * found.efficiency, "%", at),
    )


# --- numbers ------------------------------------------------------------------------------


def _drive_rows(case: Case) -> list[Row]:
    stated = tomllib.loads(case.to_toml())
    d, q = stated["deceleration"], stated["equal_speed"]
    ratio = case.drive.transmission_ratio
    sense = "same sense" if ratio > 0 else "other sense"
    e_m = case.drive.eccentricity_m
    kind = {"ring_groove": "ring grooves", "cross_slide": "cross-slide"}[q["kind"]]
    return [
        (f"Ratio, {sense}", f"{abs(ratio):g} : 1", ""),
        ("Balls, deceleration", f"{d['ball_count']} of {_mm(2 * d['ball_radius_m'])}", "mm"),
        (f"Balls, {kind}", f"{q['ball_count']} of {_mm(2 * q['ball_radius_m'])}", "mm"),
        ("Ball circles", f"{_mm(2 * _pitch_m(d))} / {_mm(2 * q['pitch_radius_m'])}", "mm"),
        ("Eccentricity / of the crank", f"{_mm(e_m)} / {_mm(2 * e_m)}", "mm"),
        ("Contact angle", f"{np.degrees(d['contact_angle_rad']):.4g}", "deg"),
    ]


def _pitch_m(deceleration: Mapping[str, Any]) -> float:
    return float(deceleration["ball_count"] * deceleration["rolling_circle_radius_m"])


def _limit_GPa(case: Case) -> float:
    return float(tomllib.loads(case.to_toml())["material"]["contact_pressure_limit_Pa"]) / 1e9


def _load_rows(case: Case) -> list[Row]:
    torque_Nm, preload_N = _rated(case)
    solution = case.drive.solve(torque_Nm, preload_N)
    angle, idle = solution.elastic_angle_arcsec, case.drive.solve(0.0, preload_N)
    if angle is not None and idle.elastic_angle_arcsec is not None:
        angle -= idle.elastic_angle_arcsec
    stiffness = solution.torsional_stiffness_Nm_per_rad
    per_arcmin = None if stiffness is None else stiffness * np.pi / 10_800
    return [
        ("Rated torque", f"{torque_Nm:g}", "N m"),
        ("Preload", f"{preload_N:g}", "N"),
        ("Elastic angle", _number(angle), "arcsec"),
        ("Torsional stiffness", _number(per_arcmin), "N m/arcmin"),
    ]


def _strength_rows(costs: Costs) -> list[Row]:
    largest = costs.largest_torque_Nm
    needed = float(costs.document["required_static_safety"])
    return [
        ("Static safety s₀", _number(costs.static_safety), ""),
        (f"Torque at s₀ = {needed:g}", _number(largest), "N m"),
    ]


def _preload_rows(case: Case, costs: Costs) -> list[Row]:
    needed = case.drive.preload(_rated(case)[0]).drive
    window = costs.preload_window_N
    shown = "none" if window is None else f"{_number(window[0])} to {_number(window[1])}"
    return [
        ("Holds above", _number(needed.hold_N), "N"),
        ("Continuous above", _number(needed.continuous_N), "N"),
        ("Zero backlash above", _number(needed.zero_backlash_N), "N"),
        ("Window", shown, "N"),
    ]


def _friction_rows(costs: Costs) -> list[Row]:
    back, efficiency = costs.backdriving_torque_Nm, costs.efficiency
    torque = costs.friction_torque_Nm
    return [
        ("Coefficient (assumed)", f"{float(costs.document['coefficient']):g}", ""),
        ("Friction torque, input", _number(None if torque is None else 1e3 * torque), "N mm"),
        ("Efficiency", _number(None if efficiency is None else 100 * efficiency), "%"),
        ("Torque to drive back", "locks" if back is None else _number(back), "N m"),
    ]


def _accuracy_rows(case: Case) -> Iterator[Row]:
    torque_Nm, preload_N = _rated(case)
    try:
        found = characterise(case, rated_torque_Nm=abs(torque_Nm))
        lost = next(f for f in found.figures if f.name == "lost_motion")
        yield (
            f"Lost motion (±{100 * found.convention.window:g} %)",
            _number(lost.value),
            "arcsec",
        )
    except (CbptError, StopIteration):
        pass
    if case.drive.has_parts_as_made:
        error = transmission(case)
        yield "Transmission error, idle", _number(error.unloaded_range_arcsec), "arcsec"
        yield "Transmission error, rated", _number(error.loaded_range_arcsec), "arcsec"
    else:
        largest = case.drive.largest_elastic_angle(torque_Nm, preload_N)
        ripple = None if largest is None else largest.amplitude_arcsec
        yield "Ripple of the angle", _number(ripple), "arcsec"


def _mm(length_m: float) -> str:
    return f"{length_m * 1e3:.4g}"


def _number(value: float | None) -> str:
    """Three digits; a dash where there is none."""
    if value is None or not np.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    digits = max(2 - int(np.floor(np.log10(abs(value)))), 0)
    return f"{value:.{digits}f}" if abs(value) >= 1e-2 else f"{value:.2g}"


# --- the page -----------------------------------------------------------------------------

_SHEET = """
@page { size: A4; margin: 11mm 12mm; }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 186mm; font: 8.6pt/1.28 system-ui, "DejaVu Sans", sans-serif;
  color: #1c2026; background: #fff; -webkit-print-color-adjust: exact; print-color-adjust: exact; }
@media screen { body { padding: 10mm 4mm; } }
header { border-bottom: 2.2pt solid #0072b2; padding-bottom: 1.6mm; margin-bottom: 2.4mm; }
h1 { font-size: 16pt; margin: 0; letter-spacing: -0.01em; }
header p { margin: 0.6mm 0 0; color: #515a66; }
h2 { font-size: 8.8pt; margin: 0 0 0.5mm; color: #0b4f7d; font-weight: 650; }
.numbers { columns: 3; column-gap: 6mm; }
.numbers div { break-inside: avoid; margin-bottom: 2mm; }
.pictures { display: grid; grid-template-columns: repeat(2, 1fr); gap: 1.4mm 5mm;
  margin-top: 2.4mm; }
figure { margin: 0; break-inside: avoid; }
figcaption { font-weight: 650; color: #0b4f7d; }
figure svg { width: 100%; height: 54mm; display: block; }
figure.drawing { display: grid; grid-template-columns: 1fr 1fr; }
figure.drawing figcaption { grid-column: 1 / 3; }
table { width: 100%; border-collapse: collapse; }
td { padding: 0.35mm 0; border-bottom: 0.4pt solid #dde1e7; vertical-align: baseline; }
td.value { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap;
  padding-left: 2mm; }
td.unit { width: 1px; padding-left: 1.2mm; color: #515a66; white-space: nowrap; }
footer { margin-top: 2mm; padding-top: 1mm; border-top: 0.6pt solid #b9c0ca; color: #515a66;
  font-size: 7pt; }
"""


def _page(
    case: Case,
    title: str,
    pictures: list[tuple[str, str]],
    blocks: list[tuple[str, list[Row]]],
) -> str:
    ratio = case.drive.transmission_ratio
    torque_Nm, preload_N = _rated(case)
    numbers = "\n".join(_block(head, rows) for head, rows in blocks if rows)
    drawn = "\n".join(
        f"<figure{' class=drawing' if place == 0 else ''}><figcaption>{escape(head)}</figcaption>"
        f"{_own_names(svg, f'p{place}')}</figure>"
        for place, (head, svg) in enumerate(pictures)
    )
    made = "nominal parts"
    if case.drive.has_parts_as_made:
        made = "parts as they were made (lines of thresholds: nominal)"
    effects = ", ".join(effects_of(case))
    counted = f" Effects of the case ({effects}) count in the lost motion alone." if effects else ""
    return (
        "<!doctype html>\n"
        f'<html lang="en"><head><meta charset="utf-8"><title>{escape(title)}</title>\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        '<meta http-equiv="Content-Security-Policy" '
        "content=\"default-src 'none'; style-src 'unsafe-inline'\">\n"
        f"<style>{_SHEET}</style></head>\n<body>\n"
        f"<header><h1>{escape(title)}</h1><p>Ratio {abs(ratio):g} : 1 · {torque_Nm:g} N m at a "
        f"preload of {preload_N:g} N</p></header>\n"
        f'<section class="numbers">\n{numbers}\n</section>\n'
        f'<section class="pictures">\n{drawn}\n</section>\n'
        f"<footer>Computed by statics, Hertz contacts and Coulomb friction for {made}, plates "
        "rigid but for the contacts. Efficiency, friction and pressures: means and maxima over a "
        "period. A dot marks the load as set; dashed: rated torque."
        f"{escape(counted)}</footer>\n</body></html>\n"
    )


def _block(head: str, rows: list[Row]) -> str:
    cells = "".join(
        f'<tr><td>{escape(name)}</td><td class="value">{escape(value)}</td>'
        f'<td class="unit">{escape(unit)}</td></tr>'
        for name, value, unit in rows
    )
    return f"<div><h2>{escape(head)}</h2><table>{cells}</table></div>"


def _own_names(svg: str, name: str) -> str:
    """The picture with names that no other picture on the page has."""
    for before in ('id="', 'href="#', "url(#"):
        svg = svg.replace(before, f"{before}{name}-")
    return svg
