"""The data sheet: one page, the numbers of the verbs, and what is told where it cannot be made."""

from __future__ import annotations

import re
import shutil
from functools import cache
from pathlib import Path

import pytest

import cbpt
from cbpt.cli.main import main
from cbpt.page.printing import print_pdf

TOP = Path(__file__).parents[2]
CASE = TOP / "examples" / "base_case.toml"
MADE = TOP / "examples" / "as_made" / "drive.toml"


@cache
def sheet(case: Path = CASE) -> str:
    return cbpt.datasheet(case)


def rows(html: str) -> dict[str, tuple[str, str]]:
    cells = r'<tr><td>(.*?)</td><td class="value">(.*?)</td><td class="unit">(.*?)</td></tr>'
    return {name: (value, unit) for name, value, unit in re.findall(cells, html)}


def test_its_numbers_are_those_of_the_verbs() -> None:
    found = rows(sheet())
    drive = cbpt.Drive.from_file(CASE)
    solution = drive.solve(5.0, 600.0)
    assert found["Ratio, same sense"] == ("10.5 : 1", "")
    assert found["Elastic angle"] == (f"{solution.elastic_angle_arcsec:.1f}", "arcsec")
    assert found["Continuous above"] == (f"{drive.preload(5.0).drive.continuous_N:.0f}", "N")
    costs = cbpt.friction(CASE)
    assert costs.efficiency is not None
    assert found["Efficiency"] == (f"{100 * costs.efficiency:.1f}", "%")
    assert found["Static safety s₀"] == (f"{costs.static_safety:.2f}", "")
    assert {"Lost motion (±3 %)", "Torsional stiffness", "Window"} <= found.keys()


def test_parts_as_made_show_their_transmission_error() -> None:
    found = rows(sheet(MADE))
    error = cbpt.transmission(MADE)
    assert found["Transmission error, idle"] == (f"{error.unloaded_range_arcsec:.1f}", "arcsec")
    assert "parts as they were made" in sheet(MADE)


def test_effects_that_the_sheet_leaves_out_are_told() -> None:
    effects: list[tuple[str, dict[str, float]]] = [("eccentric_bearing", {})]
    case = cbpt.Case.from_file(CASE).with_effects(effects)
    told = "Effects of the case (eccentric_bearing) count in the lost motion alone."
    assert told in cbpt.datasheet(case) and "count in the lost motion" not in sheet()


def test_it_needs_no_network_and_its_pictures_have_names_of_their_own() -> None:
    html = sheet()
    assert html.count("<svg") == 7
    assert not re.findall(r'(?:src|href)="(?!#)', html)
    names = re.findall(r'\bid="([^"]+)"', html)
    assert len(names) == len(set(names))
    assert "default-src 'none'" in html and "<script" not in html


def test_a_title_is_text() -> None:
    html = cbpt.datasheet(CASE, title="<b>X & Y</b>")
    assert "<h1>&lt;b&gt;X &amp; Y&lt;/b&gt;</h1>" in html


@pytest.mark.skipif(shutil.which("chromium") is None, reason="needs Chromium")
@pytest.mark.parametrize("case", [CASE, MADE])
def test_it_prints_on_one_page(case: Path) -> None:
    pdf = print_pdf(sheet(case))
    assert pdf.startswith(b"%PDF")
    assert re.findall(rb"/Count (\d+)", pdf) == [b"1"]


def test_the_verb_writes_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "sheet.html"
    assert main(["datasheet", str(CASE), "--out", str(out)]) == 0
    assert out.read_text(encoding="utf-8") == sheet()
    assert f"Wrote {out}." in capsys.readouterr().out


def test_what_cannot_be_is_told(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    assert main(["datasheet", str(CASE), "--out", "sheet.docx"]) == 2
    assert "must end in .html or .pdf" in capsys.readouterr().err
    spring = TOP / "examples" / "reducer.toml"
    assert main(["datasheet", str(spring), "--out", str(tmp_path / "a.html")]) == 2
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(
        cbpt.CbptError, match=r"none was found: install Chromium, or write .*\.html"
    ):
        print_pdf("<p></p>")
