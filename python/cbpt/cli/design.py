"""The verbs about drives that are still to be built.

tolerance   what the tolerances of the drawing make of the elastic angle
optimise    the design with the smallest elastic angle within bounds
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import Protocol

from cbpt.cli.campaigns import add_json
from cbpt.cli.lab import NO_SOLUTION, SUCCESS, Parser, add_plot, check_plot
from cbpt.results import ANGLE_UNITS


def tolerance(argv: list[str]) -> int:
    """cbpt tolerance CASE"""
    from cbpt.design.tolerance import MOST_SAMPLES, SAMPLES
    from cbpt.design.tolerance import tolerance as drawn

    parser = _of_case(
        "cbpt tolerance",
        "Draw drives within the tolerances that the case states ([tolerance], else [uncertainty]) "
        "and solve each: mean, spread, quantiles, worst cases, and the share of each number.",
    )
    parser.add_argument(
        "--samples", metavar="N", type=int, default=SAMPLES, help=f"drives to draw ({SAMPLES})"
    )
    _add_load(parser)
    _add_output(parser)
    add_plot(parser)
    options = parser.parse_args(argv)
    if not 2 <= options.samples <= MOST_SAMPLES:
        parser.error(f"--samples {options.samples}: expected 2 to {MOST_SAMPLES}")
    check_plot(options)
    found = drawn(
        options.case,
        samples=options.samples,
        seed=options.seed,
        torque_Nm=options.torque_Nm,
        preload_N=options.preload_N,
        input_angle_deg=options.input_angle_deg,
    )
    _tell(options, found)
    if options.plot:
        found.plot(options.plot, options.angle_unit)
    return SUCCESS


def optimise(argv: list[str]) -> int:
    """cbpt optimise CASE BOUNDS"""
    from cbpt.design.optimise import optimise as optimised

    parser = _of_case(
        "cbpt optimise",
        "Find the design with the smallest elastic angle at a load, within bounds on its "
        "numbers, size, preload, contact pressure, walls and spacings.",
        epilog="BOUNDS has [free], keys of a case with their least and greatest value, and "
        "[limits]: outer_radius_mm, contact_pressure_GPa, preload (hold, continuous or "
        "zero_backlash), undercut_margin, inside_wall_margin, ball_clearance_mm, "
        "ring_clearance_mm.",
    )
    parser.add_argument("bounds", metavar="BOUNDS", type=Path, help="what may change (TOML)")
    _add_load(parser)
    _add_output(parser)
    parser.add_argument("--out", metavar="CASE2", type=Path, help="write the design as a case file")
    options = parser.parse_args(argv)
    if options.out and options.out.suffix.lower() != ".toml":
        parser.error(f"--out {options.out}: the name of a case file ends in .toml")
    found = optimised(
        options.case,
        options.bounds,
        torque_Nm=options.torque_Nm,
        preload_N=options.preload_N,
        input_angle_deg=options.input_angle_deg,
        seed=options.seed,
    )
    if options.out and found.found:
        options.out.write_text(found.case.to_toml(), encoding="utf-8")
    _tell(options, found)
    return SUCCESS if found.found else NO_SOLUTION


def _of_case(prog: str, description: str, epilog: str | None = None) -> argparse.ArgumentParser:
    parser = Parser(prog=prog, description=description, epilog=epilog)
    parser.add_argument("case", metavar="CASE", type=Path, help="case file (TOML)")
    return parser


def _add_load(parser: argparse.ArgumentParser) -> None:
    for flag, name, what in (
        ("--torque-Nm", "T", "resistance torque"),
        ("--preload-N", "F", "axial preload"),
        ("--input-angle-deg", "A", "angle of the input crank"),
    ):
        what += ", in place of that of the case"
        parser.add_argument(flag, metavar=name, type=float, help=what)


def _add_output(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--seed", type=int, default=0, help="the same seed, the same answer")
    add_json(parser)
    parser.add_argument(
        "--angle-unit", choices=list(ANGLE_UNITS), default="arcsec", help="unit of text and plot"
    )


class _Answer(Protocol):
    def to_json(self) -> str: ...
    def report(self, angle_unit: str = "arcsec") -> str: ...


def _tell(options: argparse.Namespace, answer: _Answer) -> None:
    if options.json == "-":
        print(answer.to_json())
    else:
        if options.json:
            Path(options.json).write_text(answer.to_json() + "\n", encoding="utf-8")
        print(answer.report(options.angle_unit))
    sys.stdout.flush()
