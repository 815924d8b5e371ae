"""The page's verbs on the command line.

report      the answer as one file to look at, send and print
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cbpt.verbs import SUCCESS, columns_of, inputs, only_of

if TYPE_CHECKING:
    from cbpt.lab.answer import Diagnosis


def report(argv: list[str]) -> int:
    """cbpt report CASE DATA --out report.html"""
    parser = inputs(
        "cbpt report",
        "Diagnose readings and write the answer as one page that opens without a network: the "
        "misfit, where it stands out, what could be missing, what to measure next, the drive.",
    )
    parser.add_argument(
        "--out",
        metavar="FILE",
        type=Path,
        required=True,
        help="FILE.html, or FILE.json for the page's document alone",
    )
    parser.add_argument(
        "--with",
        metavar="EFFECT",
        nargs="+",
        action="extend",
        default=[],
        dest="effects",
        help="own effects of the case that are to compete instead of being taken as given",
    )
    parser.add_argument(
        "--seed", type=int, default=0, help="of the simulated chances; the same seed, the same page"
    )
    options = parser.parse_args(argv)
    columns = columns_of(parser, options)
    if options.out.suffix.lower() not in (".html", ".json"):
        parser.error(f"--out {options.out}: the name must end in .html or .json")
    from cbpt.lab.diagnose import diagnose
    from cbpt.lab.inputs import case_and_readings
    from cbpt.page.document import Source, page_document
    from cbpt.page.plain import to_json

    case, readings = case_and_readings(
        options.case, options.data, columns or None, options.sheet, only_of(parser, options)
    )
    diagnosis = diagnose(case, readings, effects=options.effects, seed=options.seed)
    isolability, why = isolability_of(diagnosis)
    source = Source.of_files(
        str(options.case), str(options.data), _text(options.case), *_flags(options)
    )
    document = page_document(
        case,
        readings,
        source,
        diagnosis,
        isolability=isolability,
        reasons={"isolability": why} if why else None,
    )
    if options.out.suffix.lower() == ".json":
        text = to_json(document) + "\n"
    else:
        from cbpt.page.report import report as page

        text = page(document)
    options.out.write_text(text, encoding="utf-8")
    print(diagnosis.sentence)
    print(f"Wrote {options.out}.")
    sys.stdout.flush()
    return SUCCESS


def isolability_of(d: Diagnosis) -> tuple[dict[str, Any] | None, str]:
    """What the campaign could see and tell apart; or None, and why."""
    from cbpt.errors import CbptError
    from cbpt.lab.isolability import isolability

    try:
        u = None
        if d.readings.u_elastic_angle_arcsec is None:
            u = d.to_dict()["noise"]["u_estimated_arcsec"]
        return isolability(d.case, d.readings, u_elastic_angle_arcsec=u).to_dict(), ""
    except CbptError as error:
        return None, str(error)


def _text(path: Path) -> str:
    return path.read_text(encoding="utf-8")


def _flags(options: argparse.Namespace) -> list[str]:
    """What was given beside CASE, DATA and --out, to be said again."""
    found = []
    for flag, values in (("--column", options.column), ("--only", options.only)):
        found += [word for value in values for word in (flag, value)]
    if options.sheet is not None:
        found += ["--sheet", options.sheet]
    if options.effects:
        found += ["--with", *options.effects]
    return found + (["--seed", str(options.seed)] if options.seed else [])
