"""The verbs about drives that are still to be built, and about their parts as they were made.

friction       what preload and stiffness cost, with a picture of the preload window
tolerance      how the elastic angle varies within the tolerances of the drawing
optimise       the design with the smallest elastic angle within bounds; fronts of two objectives
transmission   the transmission error of the parts as they were made
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import Protocol

from cbpt.cli.options import (
    NO_SOLUTION,
    SUCCESS,
    Counter,
    add_angle_unit,
    add_json,
    add_load,
    add_plot,
    add_seed,
    check_name,
    check_plot,
    load_of,
    of_case,
    show_answer,
)
from cbpt.whole_files import write_whole


class _Written(Protocol):
    """An answer with a table."""

    def to_csv(self) -> str: ...
    def to_json(self) -> str: ...


def _write_out(out: Path | None, found: _Written) -> None:
    """Write the table of an answer to FILE.csv, or the complete answer to FILE.json."""
    if out:
        csv = out.suffix.lower() == ".csv"
        write_whole(out, found.to_csv() if csv else found.to_json() + "\n")


def is_with_window(argv: Sequence[str]) -> bool:
    """Whether a command line is friction with a picture, or asks for the help that has it; every
    other one of friction is the core's."""
    flags = {word.partition("=")[0] for word in argv[1:]}
    return argv[:1] == ["friction"] and bool(flags & {"--plot", "--help", "-h"})


def friction(argv: list[str]) -> int:
    """cbpt friction CASE --plot FILE"""
    from cbpt.design.costs import friction as costs_of

    parser = of_case(
        "cbpt friction",
        "What preload and stiffness cost over a period: friction torque at the input, efficiency, "
        "wear, static safety, the window of the preload.",
    )
    add_load(parser)
    parser.add_argument(
        "--coefficient",
        metavar="MU",
        type=float,
        help="friction coefficient of the contacts (default: that of the case, or 0.1)",
    )
    parser.add_argument(
        "--static-safety",
        metavar="S0",
        type=float,
        help="static safety that is required (default: that of the case, or 1)",
    )
    parser.add_argument(
        "--json",
        action="store_const",
        const="-",
        help="print the complete answer as one JSON object instead of the text",
    )
    parser.add_argument(
        "--out",
        metavar="FILE",
        type=Path,
        help="write the table of pairs to FILE.csv, or the complete answer to FILE.json",
    )
    add_plot(
        parser,
        "draw elastic angle, friction torque and static safety over the preload, with the window, "
        "to FILE.svg, .png or .pdf; the curves are those at the input angle",
    )
    options = parser.parse_args(argv)
    check_name(parser, "--out", options.out, ".csv", ".json")
    check_plot(options)
    found = costs_of(
        options.case,
        **load_of(options),
        coefficient=options.coefficient,
        static_safety=options.static_safety,
    )
    _write_out(options.out, found)
    show_answer(found, options.json, found.report)
    if options.plot:
        found.plot(options.plot)
    return SUCCESS if found.has_solution else NO_SOLUTION


def tolerance(argv: list[str]) -> int:
    """cbpt tolerance CASE"""
    from cbpt.design.tolerance import MOST_SAMPLES, SAMPLES
    from cbpt.design.tolerance import tolerance as drawn

    parser = of_case(
        "cbpt tolerance",
        "Draw random drives within the tolerances of the case ([tolerance], else [uncertainty]) "
        "and "
        "solve each: mean, spread, quantiles, worst cases, and the share of each parameter.",
    )
    parser.add_argument(
        "--samples",
        metavar="N",
        type=int,
        default=SAMPLES,
        help=f"number of drives (default {SAMPLES})",
    )
    parser.add_argument(
        "--friction",
        action="store_true",
        help="also friction torque, efficiency, wear, static safety and natural frequency of each "
        "drive, at the input angle",
    )
    add_load(parser)
    add_seed(parser, "answer")
    add_json(parser)
    add_angle_unit(parser)
    add_plot(parser)
    options = parser.parse_args(argv)
    if not 2 <= options.samples <= MOST_SAMPLES:
        parser.error(f"--samples {options.samples}: expected 2 to {MOST_SAMPLES}")
    check_plot(options)
    found = drawn(
        options.case,
        samples=options.samples,
        seed=options.seed,
        **load_of(options),
        friction=options.friction,
    )
    show_answer(found, options.json, lambda: found.report(options.angle_unit))
    if options.plot:
        found.plot(options.plot, options.angle_unit)
    return SUCCESS


def _optimise_parser() -> argparse.ArgumentParser:
    from cbpt.design.optimise import OBJECTIVES

    parser = of_case(
        "cbpt optimise",
        "Find the design with the smallest elastic angle (or friction torque, or wear) at a load, "
        "within bounds on its parameters, size, preload, contact pressure, walls, clearances and "
        "friction.",
        epilog="BOUNDS has two tables: [free] gives keys of the case with their smallest and "
        "largest value; [limits] may have outer_radius_mm, contact_pressure_GPa, preload (hold, "
        "continuous or "
        "zero_backlash), undercut_margin, inside_wall_margin, ball_clearance_mm, "
        "ring_clearance_mm, friction_torque_Nm, efficiency, wear_Nm_per_turn, static_safety, "
        "natural_frequency_Hz.",
    )
    parser.add_argument(
        "bounds", metavar="BOUNDS", type=Path, help="free parameters and limits (TOML)"
    )
    parser.add_argument(
        "--objective",
        choices=list(OBJECTIVES),
        default="elastic_angle",
        help="quantity to minimise (default elastic_angle)",
    )
    parser.add_argument(
        "--front",
        choices=list(OBJECTIVES),
        help="a second objective: designs of which none is better in both",
    )
    parser.add_argument(
        "--points", metavar="N", type=int, help="designs of the front (default 9); each is a search"
    )
    add_load(parser)
    add_seed(parser, "answer")
    add_json(parser)
    add_angle_unit(parser)
    parser.add_argument(
        "--out",
        metavar="FILE",
        type=Path,
        help="write the design as a case file, FILE.toml; with --front the designs, .csv or .json",
    )
    add_plot(parser)
    return parser


def optimise(argv: list[str]) -> int:
    """cbpt optimise CASE BOUNDS"""
    from cbpt.design.optimise import optimise as optimised

    parser = _optimise_parser()
    options = parser.parse_args(argv)
    if options.front is not None:
        return _front(parser, options)
    check_name(parser, "--out", options.out, ".toml")
    for name in ("points", "plot"):
        if getattr(options, name) is not None:
            parser.error(f"--{name} goes with --front")
    found = optimised(
        options.case,
        options.bounds,
        **load_of(options),
        seed=options.seed,
        objective=options.objective,
    )
    if options.out and found.found:
        write_whole(options.out, found.case.to_toml())
    show_answer(found, options.json, lambda: found.report(options.angle_unit))
    return SUCCESS if found.found else NO_SOLUTION


def _front(parser: argparse.ArgumentParser, options: argparse.Namespace) -> int:
    """Designs of which none is better in two objectives."""
    from cbpt.design.front import MOST_POINTS, POINTS, pareto_front

    points = POINTS if options.points is None else options.points
    check_name(parser, "--out", options.out, ".csv", ".json")
    check_plot(options)
    if options.front == options.objective:
        parser.error(f"--front {options.front}: give another objective than --objective")
    if not 2 <= points <= MOST_POINTS:
        parser.error(f"--points {points}: expected 2 to {MOST_POINTS}")
    with Counter() as counter:
        found = pareto_front(
            options.case,
            options.bounds,
            (options.objective, options.front),
            points=points,
            **load_of(options),
            seed=options.seed,
            progress=lambda done, total: counter.share("searches", done / total),
        )
    _write_out(options.out, found)
    show_answer(found, options.json, lambda: found.report(options.angle_unit))
    if options.plot and found.points:
        found.plot(options.plot, options.angle_unit)
    return SUCCESS if found.points else NO_SOLUTION


def transmission(argv: list[str]) -> int:
    """cbpt transmission CASE"""
    from cbpt.design.transmission import MOST_TURNS
    from cbpt.design.transmission import transmission as solved

    parser = of_case(
        "cbpt transmission",
        "Solve the drive with its parts as they were made ([as_made]) over the turns of the crank: "
        "transmission error without and with torque, its spectrum, the share of each ball, and the "
        "preload that the parts need.",
    )
    parser.add_argument(
        "--turns",
        metavar="N",
        type=int,
        help="turns of the crank to calculate (default: until the drive repeats)",
    )
    add_load(parser, angle=False)
    add_json(parser)
    parser.add_argument(
        "--out",
        metavar="FILE",
        type=Path,
        help="write the curve to FILE.csv, or the complete answer to FILE.json",
    )
    add_angle_unit(parser)
    add_plot(parser)
    options = parser.parse_args(argv)
    check_name(parser, "--out", options.out, ".csv", ".json")
    if options.turns is not None and not 1 <= options.turns <= MOST_TURNS:
        parser.error(f"--turns {options.turns}: expected 1 to {MOST_TURNS}")
    check_plot(options)
    found = solved(
        options.case,
        torque_Nm=options.torque_Nm,
        preload_N=options.preload_N,
        turns=options.turns,
    )
    _write_out(options.out, found)
    show_answer(found, options.json, lambda: found.report(options.angle_unit))
    if options.plot:
        found.plot(options.plot, options.angle_unit)
    return SUCCESS
