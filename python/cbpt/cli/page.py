"""The page's verbs on the command line.

report      the answer as one file to look at, send and print
workbench   the same live, served on this machine
datasheet   one page of a drive for a catalogue
"""

from __future__ import annotations

import argparse
import sys
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

from cbpt.cli.options import (
    COMPETING,
    SUCCESS,
    Counter,
    add_angle_unit,
    add_effects,
    add_load,
    add_seed,
    check_name,
    columns_of,
    inputs,
    of_case,
    only_of,
    show,
)
from cbpt.whole_files import write_whole

if TYPE_CHECKING:
    from cbpt.page.document.source import Told


def report(argv: list[str]) -> int:
    """cbpt report CASE DATA --out report.html"""
    from cbpt.page.document.units import ANGLE_SIZES

    parser = inputs(
        "cbpt report",
        "Diagnose readings and write the answer as one page that needs no network: the misfit, "
        "where it is largest, what could be missing, what to measure next, the drive.",
    )
    parser.add_argument(
        "--out",
        metavar="FILE",
        type=Path,
        required=True,
        help="FILE.html, or FILE.json for the data of the page alone",
    )
    add_effects(parser, COMPETING)
    _add_head(parser)
    add_seed(parser, "page")
    add_angle_unit(parser, ANGLE_SIZES, "the page as it opens")
    options = parser.parse_args(argv)
    columns = columns_of(parser, options)
    check_name(parser, "--out", options.out, ".html", ".json")
    from cbpt.lab.diagnosis.diagnose import diagnose
    from cbpt.lab.readings.inputs import case_and_readings
    from cbpt.page.document.campaign import campaign_isolability
    from cbpt.page.document.document import page_document
    from cbpt.page.document.plain import to_json
    from cbpt.page.document.source import Source, named

    case, readings = case_and_readings(
        options.case, options.data, columns or None, options.sheet, only_of(parser, options)
    )
    readings = named(readings, str(options.data), options.data.name)
    with Counter() as counter:
        diagnosis = diagnose(
            case,
            readings,
            effects=options.effects,
            seed=options.seed,
            progress=lambda what, share: counter.share(what, 0.5 * share),
        )
        isolability = campaign_isolability(
            diagnosis, lambda what, share: counter.share(what, 0.5 + 0.4 * share)
        )
        counter.share("the page", 0.9)
        files = str(options.case), str(options.data), _text(options.case)
        source = Source.of_files(*files, _reading(options), _judging(options))
        source = replace(source, told=_told(options), angle_unit=options.angle_unit)
        document = page_document(case, readings, source, diagnosis, isolability=isolability)
    if options.out.suffix.lower() == ".json":
        text = to_json(document) + "\n"
    else:
        from cbpt.page.report import report as page

        text = page(document)
    write_whole(options.out, text)
    show(diagnosis.sentence_in(options.angle_unit))
    print(f"Wrote {options.out}.")
    sys.stdout.flush()
    return SUCCESS


def workbench(argv: list[str]) -> int:
    """cbpt workbench [CASE DATA]"""
    parser = inputs(
        "cbpt workbench",
        "Work with the page in the browser: open a case and readings, see the misfit, switch "
        "effects on, and write effects of your own. Only this machine can reach it; Ctrl-C ends "
        "it.",
        needed=False,
    )
    parser.add_argument(
        "--port",
        type=int,
        help="port to listen on (default: 8327, or any free port; 0: any free port)",
    )
    parser.add_argument(
        "--host",
        default="127.0.0.1",
        help="address to listen on; any other than 127.0.0.1 lets others in the network reach it",
    )
    parser.add_argument(
        "--no-browser", action="store_true", help="print the address and do not open a browser"
    )
    options = parser.parse_args(argv)
    if options.port is not None and not 0 <= options.port < 65536:
        parser.error(f"--port {options.port}: expected 0 to 65535")
    if (options.case is None) != (options.data is None):
        parser.error("give both CASE and DATA, or neither and open them in the browser")
    from cbpt.page.workbench.serve import serve
    from cbpt.page.workbench.session import Session

    if options.case is None:
        session = Session()
    else:
        columns, only = columns_of(parser, options), only_of(parser, options)
        session = Session.of_files(
            options.case, options.data, columns, options.sheet, only, _reading(options)
        )
    serve(session, options.host, options.port, not options.no_browser)
    return SUCCESS


def datasheet(argv: list[str]) -> int:
    """cbpt datasheet CASE --out sheet.html"""
    parser = of_case(
        "cbpt datasheet",
        "Write one page of the drive as a catalogue carries it: drawing, ratio, stiffness, lost "
        "motion, preload window, pressures, friction torque and efficiency over torque and "
        "preload.",
    )
    parser.add_argument(
        "--out",
        metavar="FILE",
        type=Path,
        required=True,
        help="FILE.html, or FILE.pdf, which Chromium or another browser of this machine prints",
    )
    parser.add_argument("--title", metavar="TEXT", help="head of the page")
    add_load(parser, torque="rated torque", angle=False)
    options = parser.parse_args(argv)
    check_name(parser, "--out", options.out, ".html", ".pdf")
    from cbpt.page.datasheet import TITLE
    from cbpt.page.datasheet import datasheet as sheet
    from cbpt.page.printing import print_pdf

    html = sheet(
        options.case,
        title=options.title or TITLE,
        torque_Nm=options.torque_Nm,
        preload_N=options.preload_N,
    )
    pdf = options.out.suffix.lower() == ".pdf"
    write_whole(options.out, print_pdf(html) if pdf else html)
    print(f"Wrote {options.out}.")
    sys.stdout.flush()
    return SUCCESS


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def _add_head(parser: argparse.ArgumentParser) -> None:
    """What no file says."""
    parser.add_argument("--author", metavar="NAME", help="who writes the report, for its head")
    parser.add_argument("--rig", metavar="NAME", help="the rig, for the head of the report")
    parser.add_argument(
        "--date", metavar="DATE", help="date of the report, for its head (default: today)"
    )


def _told(options: argparse.Namespace) -> Told:
    """The same, as given."""
    from cbpt.page.document.source import Told

    return Told(options.rig, options.author, options.date or date.today().isoformat())


def _reading(options: argparse.Namespace) -> list[str]:
    """The flags that say how the table is read, to be said again."""
    found = []
    for flag, values in (("--column", options.column), ("--only", options.only)):
        found += [word for value in values for word in (flag, value)]
    if options.sheet is not None:
        found += ["--sheet", options.sheet]
    return found


def _judging(options: argparse.Namespace) -> list[str]:
    """The flags of the diagnosis, to be said again."""
    found = ["--with", *options.effects] if options.effects else []
    for flag, value in (("--author", options.author), ("--rig", options.rig)):
        found += [flag, value] if value else []
    found += ["--seed", str(options.seed)] if options.seed else []
    return found + (["--angle-unit", options.angle_unit] if options.angle_unit != "arcsec" else [])
