"""The lab's verbs about campaigns to come.

simulate    readings that a plan would give
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from cbpt.verbs import NO_SOLUTION, SUCCESS, columns_of, inputs

PLAN = ("PLAN", "runs to come (TOML), or a table of loads (CSV)")


def simulate(argv: list[str]) -> int:
    """cbpt simulate CASE PLAN"""
    from cbpt.lab.plan import read_plan, table_text
    from cbpt.lab.simulate import NOISES, NoSolutionError
    from cbpt.lab.simulate import simulate as simulated

    kinds = "; ".join(f"{kind}={size:g} ({told})" for kind, (_, size, told) in NOISES.items())
    parser = inputs(
        "cbpt simulate",
        "Readings that a campaign would give: the model with the effects of the case, and noise.",
        epilog=f"Kinds of noise, with the size each has where none is stated: {kinds}.",
        table=PLAN,
    )
    parser.add_argument(
        "--with",
        metavar=("EFFECT", "NAME=VALUE"),
        nargs="+",
        action="append",
        default=[],
        dest="effects",
        help="an effect of the library with its numbers, as in a case file: "
        "eccentric_bearing reference_deflection_um=2; repeatable",
    )
    parser.add_argument(
        "--noise",
        metavar="KIND",
        nargs="+",
        default=["white"],
        help="white (default), none, or any of those below, KIND=SIZE for another size",
    )
    parser.add_argument("--seed", type=int, default=0, help="the same seed, the same readings")
    add_u(parser)
    parser.add_argument("--out", metavar="FILE", type=Path, help="write FILE.csv, not the terminal")
    options = parser.parse_args(argv)
    columns = columns_of(parser, options)
    if options.out and options.out.suffix.lower() != ".csv":
        parser.error(f"--out {options.out}: the name must end in .csv")
    effects = [(words[0], _numbers(parser, words[1:])) for words in options.effects]
    from cbpt.lab.inputs import case_of

    case = case_of(options.case)
    try:
        readings = simulated(
            case,
            read_plan(options.data, case, columns=columns or None),
            effects=effects,
            noise=options.noise,
            seed=options.seed,
            u_elastic_angle_arcsec=options.u_arcsec,
        )
    except NoSolutionError as error:
        print(f"cbpt: {error}", file=sys.stderr)
        return NO_SOLUTION
    text = table_text(readings)
    if options.out:
        options.out.write_text(text, encoding="utf-8")
        print(f"Wrote {options.out}: {len(readings)} readings in {readings.run_index[-1] + 1} runs")
    else:
        print(text, end="")
    return SUCCESS


def add_u(parser: argparse.ArgumentParser) -> None:
    """The flag for a plan that states no uncertainty."""
    parser.add_argument(
        "--u-arcsec",
        metavar="U",
        type=float,
        help="standard uncertainty of a reading, in place of what the plan says",
    )


def _numbers(parser: argparse.ArgumentParser, words: list[str]) -> dict[str, float]:
    numbers = {}
    for word in words:
        name, equals, value = word.partition("=")
        try:
            numbers[name] = float(value)
        except ValueError:
            equals = ""
        if not equals:
            parser.error(f"--with {word}: expected NAME=VALUE, as in reference_deflection_um=2")
    return numbers
