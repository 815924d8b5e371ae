"""The lab's verbs about campaigns to come.

simulate      readings that a plan would give
isolability   what a plan could detect and distinguish
next_run      the runs that would decide between the effects that remain possible
plan          the shortest campaign that distinguishes effects
"""

from __future__ import annotations

import argparse
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from cbpt.cli.options import (
    NO_SOLUTION,
    SUCCESS,
    add_angle_unit,
    add_json,
    add_plot,
    add_seed,
    check_name,
    check_plot,
    columns_of,
    inputs,
    of_case,
    show,
    show_answer,
    tell,
)
from cbpt.whole_files import write_whole

if TYPE_CHECKING:
    from cbpt.lab.experiment.candidates import Limits

PLAN = ("PLAN", "planned runs (TOML), or a table of loads (CSV)")


def simulate(argv: list[str]) -> int:
    """cbpt simulate CASE PLAN"""
    from cbpt.lab.experiment.plan import read_plan, table_text
    from cbpt.lab.experiment.simulate import simulate as simulated
    from cbpt.lab.wording.phrases import counted

    parser = inputs(
        "cbpt simulate",
        "Simulate the readings of a campaign: the model with the effects of the case, plus noise.",
        epilog=noises(),
        table=PLAN,
    )
    parser.add_argument(
        "--with",
        metavar=("EFFECT", "NAME=VALUE"),
        nargs="+",
        action="append",
        default=[],
        dest="effects",
        help="an effect of the library to add, with its parameters as in a case file: "
        "eccentric_bearing reference_deflection_um=2; may be repeated",
    )
    add_instrument(parser)
    add_seed(parser, "readings")
    parser.add_argument("--out", metavar="FILE", type=Path, help="write FILE.csv")
    options = parser.parse_args(argv)
    columns = columns_of(parser, options)
    check_name(parser, "--out", options.out, ".csv")
    effects = [(words[0], _numbers(parser, words[1:])) for words in options.effects]
    from cbpt.lab.readings.inputs import case_of

    case = case_of(options.case)
    readings = simulated(
        case,
        read_plan(options.data, case, columns=columns or None),
        effects=effects,
        noise=options.noise,
        seed=options.seed,
        u_elastic_angle_arcsec=options.u_arcsec,
    )
    text = table_text(readings)
    if options.out:
        write_whole(options.out, text)
        runs = counted(int(readings.run_index[-1]) + 1, "run")
        print(f"Wrote {options.out}: {len(readings)} readings in {runs}")
    else:
        print(text, end="")
    return SUCCESS


def isolability(argv: list[str]) -> int:
    """cbpt isolability CASE PLAN"""
    from cbpt.lab.experiment.isolability import isolability as isolable
    from cbpt.lab.experiment.plan import read_plan
    from cbpt.lab.readings.inputs import case_of

    parser = inputs(
        "cbpt isolability",
        "Find which effects a planned campaign could detect, from which size on, and which of them "
        "it could distinguish, before any reading is taken.",
        epilog=noises(),
        table=PLAN,
    )
    parser.add_argument(
        "--effects", metavar="EFFECT", nargs="+", help="ids of effects (default: all)"
    )
    add_instrument(parser)
    add_json(parser)
    add_plot(parser)
    options = parser.parse_args(argv)
    columns = columns_of(parser, options)
    check_plot(options)
    case = case_of(options.case)
    found = isolable(
        case,
        read_plan(options.data, case, columns=columns or None),
        effects=options.effects,
        noise=options.noise,
        u_elastic_angle_arcsec=options.u_arcsec,
    )
    show_answer(found, options.json, found.report)
    if options.plot:
        found.plot(options.plot)
    return SUCCESS


def next_run(argv: list[str]) -> int:
    """cbpt next-run CASE DATA"""
    from cbpt.lab.diagnosis.deciding_runs import CANDIDATES
    from cbpt.lab.diagnosis.diagnose import diagnose
    from cbpt.lab.diagnosis.next_runs import ranked
    from cbpt.lab.experiment.candidates import limits_of

    parser = inputs(
        "cbpt next-run",
        "Diagnose the readings, then rank further runs by how much each is expected to help decide "
        "between the explanations that remain possible (expected gain of log evidence).",
    )
    parser.add_argument(
        "--candidates",
        metavar="N",
        type=int,
        default=CANDIDATES,
        help=f"number of runs to choose from (default {CANDIDATES})",
    )
    add_limits(parser, "default: about 25 %% beyond the readings")
    add_json(parser)
    add_angle_unit(parser)
    parser.add_argument("--out", metavar="PLAN", type=Path, help="write the best run to PLAN.toml")
    add_seed(parser, "answer")
    options = parser.parse_args(argv)
    columns = columns_of(parser, options)
    check_name(parser, "--out", options.out, ".toml")
    answer = diagnose(options.case, options.data, columns=columns or None, seed=options.seed)
    seen = answer.readings
    limits = limited(options, limits_of(seen)) if seen.preload_N is not None else None
    found = ranked(answer, limits, options.candidates)
    plan = found.plan()
    if options.out and plan:
        write_whole(options.out, plan.to_toml())
    show_answer(found, options.json, lambda: found.report(angle_unit=options.angle_unit))
    if options.out and not plan:
        tell(f"{options.out} is not written: there is no run to write")
    return SUCCESS


def plan(argv: list[str]) -> int:
    """cbpt plan CASE --separate EFFECT EFFECT"""
    from cbpt.lab.experiment.candidates import Limits
    from cbpt.lab.experiment.shortest_plan import MAX_RUNS, limits_of_case, shortest_plan
    from cbpt.lab.readings.inputs import case_of

    parser = of_case(
        "cbpt plan",
        "Find the shortest campaign that distinguishes effects from each other and from no effect "
        "with a probability of 95 %, or find that no campaign can.",
    )
    parser.add_argument(
        "--separate",
        metavar="EFFECT",
        nargs="+",
        required=True,
        help="ids of the effects to distinguish (cbpt effects lists them)",
    )
    parser.add_argument(
        "--size",
        metavar=("EFFECT", "NAME=VALUE"),
        nargs="+",
        action="append",
        default=[],
        help="size at which an effect must be distinguished, as in a case file: eccentric_bearing "
        "reference_deflection_um=0.2; may be repeated (default: the middle of the plausible range)",
    )
    add_limits(parser, "default: from the [load] of the case")
    parser.add_argument(
        "--u-arcsec",
        metavar="U",
        type=float,
        required=True,
        help="standard uncertainty of a reading, arcsec",
    )
    most = f"largest number of runs (default {MAX_RUNS})"
    parser.add_argument("--max-runs", metavar="N", type=int, default=MAX_RUNS, help=most)
    parser.add_argument("--out", metavar="PLAN", type=Path, help="write the plan to PLAN.toml")
    options = parser.parse_args(argv)
    check_name(parser, "--out", options.out, ".toml")
    case = case_of(options.case)
    if options.torque_Nm is not None and options.preload_N is not None:
        limits = Limits(options.torque_Nm, tuple(options.preload_N))
    else:
        limits = limited(options, limits_of_case(case))
    found = shortest_plan(
        case,
        options.separate,
        u_elastic_angle_arcsec=options.u_arcsec,
        limits=limits,
        sizes={words[0]: _numbers(parser, words[1:]) for words in options.size},
        max_runs=options.max_runs,
    )
    show(found.report())
    if options.out and found.plan:
        write_whole(options.out, found.plan.to_toml())
        print(f"Wrote {options.out}; check it with cbpt isolability {options.case} {options.out}")
    return SUCCESS if found.plan else NO_SOLUTION


# --- what the verbs share -----------------------------------------------------------------


def noises() -> str:
    """What --noise takes."""
    from cbpt.lab.experiment.simulate import NOISES

    kinds = "; ".join(f"{kind}={size:g} ({told})" for kind, (_, size, told) in NOISES.items())
    return f"Kinds of noise, each with its default size: {kinds}."


def add_instrument(parser: argparse.ArgumentParser) -> None:
    """Flags of what an instrument adds."""
    parser.add_argument(
        "--noise",
        metavar="KIND",
        nargs="+",
        default=["white"],
        help="white (default), none, or any of the kinds below; KIND=SIZE sets the size",
    )
    parser.add_argument(
        "--u-arcsec",
        metavar="U",
        type=float,
        help="standard uncertainty of a reading, arcsec (default: that of the plan)",
    )


def add_limits(parser: argparse.ArgumentParser, usual: str) -> None:
    """Flags of what the rig can do."""
    parser.add_argument(
        "--torque-Nm", metavar="MAX", type=float, help=f"largest torque of the rig ({usual})"
    )
    parser.add_argument(
        "--preload-N",
        metavar=("LOW", "HIGH"),
        type=float,
        nargs=2,
        help=f"lowest and highest preload of the rig ({usual})",
    )


def limited(options: argparse.Namespace, limits: Limits) -> Limits:
    """Limits with what the flags say of them."""
    if options.torque_Nm is not None:
        limits = replace(limits, torque_Nm=options.torque_Nm)
    if options.preload_N is not None:
        limits = replace(limits, preload_N=tuple(options.preload_N))
    return limits


def _numbers(parser: argparse.ArgumentParser, words: list[str]) -> dict[str, float]:
    numbers = {}
    for word in words:
        name, equals, value = word.partition("=")
        try:
            numbers[name] = float(value)
        except ValueError:
            equals = ""
        if not equals:
            parser.error(f"{word}: expected NAME=VALUE, as in reference_deflection_um=2")
    return numbers
