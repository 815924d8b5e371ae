"""The report as a file: whole in itself, closed to the network, safe from what files say."""

from __future__ import annotations

import base64
import gzip
import json
import re
from functools import cache
from pathlib import Path

import pytest

import cbpt
from cbpt.cli.main import main
from cbpt.cli.options import Counter
from cbpt.page.document.document import page_document
from cbpt.page.document.source import Command, Source
from cbpt.page.report import WEB, inside_script, plotly_path, report
from common.hidden import FOLDER

ATTACK = "</script><script>alert(1)</script><!--\u2028\u2029"


@cache
def page() -> str:
    case = cbpt.Case.from_file(FOLDER / "dev04.toml")
    readings = cbpt.read_readings(FOLDER / "dev04.csv")
    source = Source(ATTACK, "dev04.csv", f"# {ATTACK}", Command("dev04.toml", "dev04.csv"))
    return report(page_document(case, readings, source))


def element(name: str) -> str:
    found = re.search(rf'<script type="[^"]*" id="{name}">(.*?)</script>', page(), re.DOTALL)
    assert found is not None
    return found[1]


def test_the_document_is_inside_as_it_was() -> None:
    found = json.loads(element("document"))
    assert found["schema"] == "cbpt-page-1"
    assert found["case"]["name"] == ATTACK
    assert len(found["readings"]["row"]) == 396


def test_the_plotting_library_is_inside_compressed() -> None:
    raw = gzip.decompress(base64.b64decode(element("plotly")))
    assert raw == plotly_path().read_bytes()
    assert len(page()) < 3_500_000


def test_every_module_is_inside_and_found_by_the_others() -> None:
    found = re.search(r'<script type="importmap">(.*?)</script>', page(), re.DOTALL)
    assert found is not None
    modules = json.loads(found[1])["imports"]
    assert set(modules) == {
        f"cbpt/{path.relative_to(WEB).as_posix()}" for path in WEB.rglob("*.js")
    }
    for address in modules.values():
        text = base64.b64decode(address.partition(",")[2]).decode()
        imported = re.findall(r"""(?:^|\s)from\s+["']([^"']+)["'];""", text)
        assert set(imported) <= set(modules), imported


def test_nothing_is_loaded_from_elsewhere() -> None:
    frame = re.sub(r"<script[^>]*>.*?</script>", "", page(), flags=re.DOTALL)
    assert not re.search(r"(src|href)\s*=\s*\"(?!#|data:,)", frame)
    assert "@import" not in frame and "url(" not in frame
    policy = re.search(r'Content-Security-Policy"\s+content="([^"]*)"', page())
    assert policy is not None
    assert "default-src 'none'" in policy[1]
    assert "http" not in policy[1] and "unsafe-eval" not in policy[1]


@pytest.mark.parametrize("text", [ATTACK, "<", "a\u2028b", "\\<", '"<\\"'])
def test_json_inside_a_script_is_the_same_json(text: str) -> None:
    inside = inside_script(json.dumps({"key": text}, ensure_ascii=False))
    assert json.loads(inside) == {"key": text}
    assert not set("<\u2028\u2029") & set(inside)


def test_a_report_tells_how_far_it_is(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shares: list[float] = []

    class Recorded(Counter):
        def share(self, what: str, share: float) -> None:
            shares.append(share)

    monkeypatch.setattr("cbpt.cli.page.Counter", Recorded)
    files = [str(FOLDER / "dev11.toml"), str(FOLDER / "dev11.csv")]
    assert main(["report", *files, "--out", str(tmp_path / "page.json")]) == 0
    assert len(shares) > 5
    assert shares == sorted(shares)
    assert shares[-1] == 0.9
