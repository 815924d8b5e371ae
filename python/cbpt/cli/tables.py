"""The verbs that look at loops and tables of readings by themselves.

characterise   the figures of catalogues: lost motion, hysteresis loss, rigidity
preflight      what a table holds, and what it cannot tell, before any model
"""

from __future__ import annotations

import argparse

from cbpt.cli.options import (
    SUCCESS,
    add_angle_unit,
    add_json,
    add_plot,
    check_plot,
    columns_of,
    in_flags,
    inputs,
    only_of,
    optional_files,
    show_answer,
)


def characterise(argv: list[str]) -> int:
    """cbpt characterise CASE [DATA]"""
    parser = _loop_parser()
    options = parser.parse_args(optional_files(argv, json=(".json",)))
    columns = columns_of(parser, options) if options.data else None
    only = only_of(parser, options)
    if not options.data and (options.by or only):
        parser.error("--by and --only need DATA")
    check_plot(options)
    from cbpt.lab.characteristics.characterise import characterise as characterised

    found = characterised(
        options.case,
        options.data,
        rated_torque_Nm=options.rated_torque_Nm,
        window=options.window,
        break_torques_Nm=options.break_torques_Nm,
        by=options.by,
        columns=columns or None,
        sheet=options.sheet,
        only=only,
    )
    show_answer(found, options.json, lambda: found.report(options.angle_unit))
    if options.plot:
        found.plot(options.plot, options.angle_unit)
    return SUCCESS


def _loop_parser() -> argparse.ArgumentParser:
    parser = inputs(
        "cbpt characterise",
        "Read the figures of catalogues and standards off torque-angle loops: lost motion, "
        "hysteresis loss, backlash, torsional rigidity, K1 to K3, loop energy. With DATA, "
        "the figures of the readings stand beside those of the model; without DATA, those of the "
        "model with its effects stand alone.",
        epilog="The rated torque is rated_torque_Nm under [rating] of the case; without it, the "
        "largest of the table. u combines the spread over repeats and runs (type A) with "
        "[uncertainty] (type B).",
        needed="case",
    )
    parser.add_argument(
        "--rated-torque-Nm",
        metavar="T",
        type=float,
        help="rated torque, instead of that of the case",
    )
    parser.add_argument(
        "--window",
        metavar="SHARE",
        type=float,
        default=0.03,
        help="share of the rated torque at which lost motion is read (default 0.03; strain-wave "
        "gears: 0.04)",
    )
    parser.add_argument(
        "--break-torques-Nm",
        metavar=("T1", "T2"),
        type=float,
        nargs=2,
        help="break torques between K1, K2 and K3 (default: fitted)",
    )
    parser.add_argument(
        "--by", metavar="COLUMN", help="figures for each value of COLUMN (default: each preload)"
    )
    add_json(parser)
    add_plot(parser)
    add_angle_unit(parser)
    return parser


def preflight(argv: list[str]) -> int:
    """cbpt preflight [CASE] DATA"""
    from cbpt.lab.preflight.preflight import preflight as looked_at

    parser = inputs(
        "cbpt preflight",
        "Check a table of readings before any model is fitted: units, sides, coverage of torque, "
        "preload and angle, repeats, display steps, rates, closed loops, zeros of runs, and which "
        "effects the table cannot show. Each finding says what to do on the rig.",
        epilog="CASE may be left out: a single file is DATA. CASE adds the lever arm, the load "
        "and the kind of reducer.",
        needed="case",
    )
    add_json(parser)
    add_angle_unit(parser, of="text")
    options = parser.parse_args(optional_files(argv, json=(".json",)))
    if options.data is None:
        options.case, options.data = None, options.case
        if options.data.suffix.lower() == ".toml":
            parser.error("DATA is missing: cbpt preflight CASE DATA, or cbpt preflight DATA")
    columns = columns_of(parser, options)
    found = looked_at(
        options.case,
        options.data,
        columns=columns or None,
        sheet=options.sheet,
        only=only_of(parser, options),
    )
    show_answer(found, options.json, lambda: found.report(in_flags, options.angle_unit))
    return SUCCESS
