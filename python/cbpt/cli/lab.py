"""The verbs that compare a model with readings; those about planned campaigns are in `campaigns`.

compare     model against a table of readings, with effects fitted where asked
diagnose    which effect is missing
change      what changed between two campaigns
fit         add effects to a case
"""

from __future__ import annotations

import argparse
import csv
import io
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cbpt.cli.options import (
    COMPETING,
    NO_SOLUTION,
    RESULTS,
    SUCCESS,
    Counter,
    add_angle_unit,
    add_effects,
    add_json,
    add_plot,
    add_results,
    add_seed,
    check_name,
    check_plot,
    check_results,
    columns_of,
    in_flags,
    inputs,
    only_of,
    optional_files,
    show,
    show_answer,
    show_results,
)
from cbpt.results import ANGLE_UNITS
from cbpt.whole_files import write_whole

if TYPE_CHECKING:
    from cbpt.lab.diagnosis.compare import Comparison
    from cbpt.lab.diagnosis.diagnosis import Diagnosis


def compare(argv: list[str]) -> int:
    """cbpt compare CASE DATA"""
    from cbpt.lab.diagnosis.compare import compare as compared

    parser = inputs(
        "cbpt compare",
        "Solve the model at every reading and report where and by how much it differs from them.",
        epilog="Columns of the table: run, time_s, torque_Nm, preload_N, input_angle_deg, "
        "temperature_degC, elastic_angle_arcsec, u_elastic_angle_arcsec; torque, preload and "
        "angle are required. Other names and units are accepted if their meaning is clear.",
    )
    add_effects(
        parser,
        "effects to fit to the readings (of the library, or own effects of the case); the report "
        "shows the misfit before and after",
    )
    add_plot(parser)
    parser.add_argument("--json", action="store_true", help="print one JSON object")
    parser.add_argument(
        "--out",
        metavar="FILE",
        type=Path,
        help="write FILE.csv (reading, model and residual of every row) or FILE.json",
    )
    add_angle_unit(parser, of="text, plot and table")
    options = parser.parse_args(argv)
    columns = columns_of(parser, options)
    check_name(parser, "--out", options.out, ".csv", ".json")
    check_plot(options)
    with Counter() as counter:
        comparison = compared(
            options.case,
            options.data,
            effects=options.effects,
            columns=columns or None,
            sheet=options.sheet,
            only=only_of(parser, options),
            progress=counter.show,
        )
    _write(comparison, options.out, options.angle_unit)
    report = comparison.report(options.angle_unit, in_flags)
    show_answer(comparison, "-" if options.json else None, lambda: report)
    if options.plot:
        comparison.plot(options.plot, options.angle_unit)
    return SUCCESS if comparison.overall else NO_SOLUTION


def _write(found: Comparison | Diagnosis, out: Path | None, angle_unit: str) -> None:
    """A comparison or an answer as a table, with angles in their unit, or as a document."""
    if out is None:
        return
    if out.suffix.lower() == ".json":
        write_whole(out, found.to_json() + "\n")
        return
    names, rows = _in_unit(*found.rows(), angle_unit)
    table = io.StringIO()
    csv.writer(table).writerows([names, *rows])
    write_whole(out, table.getvalue())


def _in_unit(
    names: list[str], rows: list[list[Any]], angle_unit: str
) -> tuple[list[str], list[list[Any]]]:
    """A table whose angles, in arcsec, are in another unit, which their headers name."""
    if angle_unit == "arcsec":
        return names, rows
    size = ANGLE_UNITS[angle_unit]
    angles = {place for place, name in enumerate(names) if name.endswith("_arcsec")}
    headers = [
        name.removesuffix("arcsec") + angle_unit if place in angles else name
        for place, name in enumerate(names)
    ]
    return headers, [
        [v * size if place in angles and v is not None else v for place, v in enumerate(row)]
        for row in rows
    ]


def diagnose(argv: list[str]) -> int:
    """cbpt diagnose CASE DATA"""
    parser = inputs(
        "cbpt diagnose",
        "Find the effect that is missing from the model, or show that none is needed or that these "
        "readings cannot decide.",
    )
    add_json(parser)
    add_effects(parser, COMPETING)
    add_plot(parser)
    parser.add_argument(
        "--by",
        metavar="COLUMN",
        help="diagnose the readings of each value of COLUMN separately, and show how the "
        "parameters change",
    )
    add_seed(parser, "answer")
    add_results(parser)
    add_angle_unit(parser, of="text, plot and table")
    parser.add_argument(
        "--out",
        metavar="FILE",
        type=Path,
        help="write FILE.csv (reading, model and residual of every row, before and after) or "
        "FILE.json (the complete answer)",
    )
    options = parser.parse_args(optional_files(argv, json=(".json",), results=RESULTS))
    check_results(parser, options)
    check_name(parser, "--out", options.out, ".csv", ".json")
    if options.by and (options.plot or options.results or options.out):
        parser.error(
            "--plot, --results and --out need a single diagnosis: choose a value with --only, not "
            "--by"
        )
    check_plot(options)
    given = {
        "columns": columns_of(parser, options) or None,
        "sheet": options.sheet,
        "only": only_of(parser, options),
        "seed": options.seed,
    }
    return _diagnose_by(options, given) if options.by else _diagnose(options, given)


def _diagnose_by(options: argparse.Namespace, given: dict[str, Any]) -> int:
    from cbpt.lab.diagnosis.by_level import diagnose_by

    answer = diagnose_by(options.case, options.data, options.by, **given)
    show_answer(answer, options.json, lambda: answer.report(options.angle_unit))
    return SUCCESS


def _diagnose(options: argparse.Namespace, given: dict[str, Any]) -> int:
    from cbpt.lab.diagnosis.diagnose import diagnose as diagnosed

    with Counter() as counter:
        answer = diagnosed(
            options.case,
            options.data,
            effects=options.effects,
            progress=counter.share,
            **given,
        )
        counter.share("what the answer depends on", 0.98)
        answer.to_dict()  # made once and kept
    _write(answer, options.out, options.angle_unit)
    show_answer(answer, options.json, lambda: answer.report(in_flags, options.angle_unit))
    if options.json != "-" or options.results not in (None, "-"):
        show_results(answer, options)
    sys.stdout.flush()
    if options.plot:
        answer.plot(options.plot, options.angle_unit)
    return SUCCESS


def _change_parser() -> argparse.ArgumentParser:
    parser = inputs(
        "cbpt change",
        "Find out what changed between two campaigns on the same reducer: for each effect and for "
        "each number the probability that it did, with its value before and after; and whether the "
        "scatter changed.",
        epilog="The case is the same before and after. To test the answer, compare two "
        "campaigns between which nothing was changed: it must say so.",
        table=("BEFORE", "table of readings before, or the one table that --by divides"),
    )
    parser.add_argument(
        "after", metavar="AFTER", type=Path, nargs="?", help="table of readings after"
    )
    parser.add_argument(
        "--by",
        metavar="COLUMN",
        help="compare the values of COLUMN in the table BEFORE, instead of two tables",
    )
    parser.add_argument(
        "--reproducibility-arcsec",
        metavar="ARCSEC",
        type=float,
        help="standard deviation of the angle when the rig is set up again and nothing was changed",
    )
    parser.add_argument(
        "--repeated",
        metavar="LEVEL",
        nargs="+",
        action="append",
        default=[],
        help="levels of --by at which nothing was changed, instead of "
        "--reproducibility-arcsec; may be repeated",
    )
    add_effects(
        parser,
        "effects to fit before and after (default: what a diagnosis of either demands)",
    )
    add_json(parser)
    add_angle_unit(parser, of="text")
    add_seed(parser, "answer")
    return parser


def change(argv: list[str]) -> int:
    """cbpt change CASE BEFORE [AFTER]"""
    from cbpt.lab.change.change import change as changed

    parser = _change_parser()
    options = parser.parse_args(optional_files(argv, json=(".json",)))
    if (options.after is None) == (options.by is None):
        parser.error("give AFTER, or --by COLUMN, and not both")
    with Counter() as counter:
        answer = changed(
            options.case,
            options.data,
            options.after,
            by=options.by,
            effects=options.effects or None,
            columns=columns_of(parser, options) or None,
            sheet=options.sheet,
            only=only_of(parser, options),
            reproducibility_arcsec=options.reproducibility_arcsec,
            repeated=options.repeated,
            seed=options.seed,
            progress=counter.share,
        )
    show_answer(answer, options.json, lambda: answer.report(options.angle_unit))
    return SUCCESS


def fit(argv: list[str]) -> int:
    """cbpt fit CASE DATA --with EFFECT"""
    from cbpt.lab.diagnosis.fitted import fit as fitted

    parser = inputs(
        "cbpt fit",
        "Fit effects to readings, with the parameters of the drive free within their stated "
        "uncertainties, and write the case with the fitted effects.",
    )
    add_effects(
        parser,
        "ids of effects (cbpt effects lists them) or of own effects of the case",
        required=True,
    )
    parser.add_argument("--out", metavar="CASE2", type=Path, help="write the case with the effects")
    add_results(parser)
    add_angle_unit(parser)
    options = parser.parse_args(optional_files(argv, results=RESULTS))
    check_name(parser, "--out", options.out, ".toml")
    columns = columns_of(parser, options)
    check_results(parser, options)
    found = fitted(
        options.case,
        options.data,
        options.effects,
        columns=columns or None,
        sheet=options.sheet,
        only=only_of(parser, options),
    )
    if options.out:
        # What `fitted` has read: the file is there, and is UTF-8.
        write_whole(options.out, found.case.to_toml(options.case.read_text(encoding="utf-8-sig")))
    show(found.report(in_flags, options.angle_unit))
    show_results(found, options)
    if options.out:
        print(f"Wrote {options.out}: the case with the fitted effects.")
    return SUCCESS
