"""What package indexes show and hand out: links that hold there, licences, extras, the sdist."""

from __future__ import annotations

import re
import subprocess
import tomllib
from pathlib import Path
from runpy import run_path
from typing import Any

import pytest

TOP = Path(__file__).parents[2]
CRATES = sorted((TOP / "crates").iterdir())
INLINE = re.compile(r"\]\(([^)\s]+)\)")
DEFINED = re.compile(r"^\[([^\]]+)\]: (\S+)$", re.MULTILINE)
USED = re.compile(r"\[([^\]]+)\](?:\[([^\]]+)\])?(?![\[(])")
FENCED = re.compile(r"^```.*?^```$|`[^`\n]*`", re.MULTILINE | re.DOTALL)


def manifest(path: Path) -> dict[str, Any]:
    return tomllib.loads(path.read_text(encoding="utf-8"))


PROJECT: dict[str, Any] = manifest(TOP / "pyproject.toml")
REPOSITORY: str = manifest(TOP / "Cargo.toml")["workspace"]["package"]["repository"]
PLACES = (
    f"{REPOSITORY}/blob/main/",
    REPOSITORY.replace("github.com", "raw.githubusercontent.com") + "/main/",
)


def prose(page: str) -> str:
    """A page without what is code."""
    return FENCED.sub("", (TOP / page).read_text(encoding="utf-8"))


def links(page: str) -> list[str]:
    text = prose(page)
    return INLINE.findall(text) + [url for _, url in DEFINED.findall(text)]


@pytest.mark.parametrize("page", ["README.md", "crates/cbpt-core/README.md"])
def test_links_hold_wherever_the_page_is_shown(page: str) -> None:
    relative = [url for url in links(page) if not url.startswith("https://")]
    assert not relative, "a package index shows the page without the repository beside it"


def test_links_into_the_repository_have_their_file() -> None:
    found = links("README.md") + list(PROJECT["project"]["urls"].values())
    inside = [url.removeprefix(place) for url in found for place in PLACES if url.startswith(place)]
    assert len(inside) > 15
    assert [path for path in inside if not (TOP / path.split("#")[0]).is_file()] == []


def test_every_reference_of_the_readme_is_defined_and_used() -> None:
    text = prose("README.md")
    defined = {name.lower() for name, _ in DEFINED.findall(text)}
    used = {(name or shown).lower() for shown, name in USED.findall(DEFINED.sub("", text))}
    assert used == defined


def test_the_readme_opens_with_pip_install() -> None:
    blocks = re.findall(r"^```sh\n(.*?)^```", (TOP / "README.md").read_text(), re.M | re.S)
    assert blocks[0].startswith("pip install cbpt")
    assert "make demo" in blocks[1] and "make test" in blocks[1]


@pytest.mark.parametrize("crate", CRATES, ids=lambda crate: crate.name)
def test_every_crate_has_the_licence_and_says_where_it_lives(crate: Path) -> None:
    assert (crate / "LICENSE").read_bytes() == (TOP / "LICENSE").read_bytes()
    package = manifest(crate / "Cargo.toml")["package"]
    assert all(package[key] == {"workspace": True} for key in ("license", "repository", "homepage"))
    assert package.get("publish") is False or (crate / package["readme"]).is_file()


@pytest.mark.parametrize("crate", CRATES, ids=lambda crate: crate.name)
def test_every_rust_file_of_tests_is_part_of_a_program(crate: Path) -> None:
    """Where a crate lists its programs of tests, cargo looks for no others."""
    listed = manifest(crate / "Cargo.toml")
    if listed["package"].get("autotests", True):
        return
    roots = {test["name"] for test in listed["test"]}
    files = {path.stem: path.read_text() for path in (crate / "tests").glob("*.rs")}
    whole = "".join(text for name, text in files.items() if name in roots)
    parts = set(re.findall(r"^mod (\w+);", whole, re.MULTILINE))
    folders = {path.parent.name for path in (crate / "tests").glob("*/main.rs")}
    assert files.keys() | folders <= roots | parts


def test_the_source_distribution_is_the_whole_repository() -> None:
    assert PROJECT["tool"]["maturin"]["sdist-generator"] == "git"
    if not (TOP / ".git").exists():
        pytest.skip("not a checkout: what is tracked is not known")
    listed = subprocess.run(
        ["git", "ls-files", "tests", "docs", "examples", "CHANGELOG.md", "LICENSE", "Cargo.lock"],
        cwd=TOP, capture_output=True, text=True, check=True,
    ).stdout.split()  # fmt: skip
    assert {"CHANGELOG.md", "LICENSE", "Cargo.lock", "examples/smoke.py"} <= set(listed)
    assert {name.split("/")[0] for name in listed} >= {"tests", "docs", "examples"}


def test_a_wheel_is_asked_for_the_answer_of_the_readme() -> None:
    """The README's is that of the package: its blocks are run by tests/docs/test_readme.py."""
    found = run_path(str(TOP / ".ci/wheels.py"))["FOUND"]
    assert found in (TOP / "README.md").read_text(encoding="utf-8")


def test_extras_that_messages_name_exist() -> None:
    extras = set(PROJECT["project"]["optional-dependencies"])
    texts = "".join(p.read_text() for p in (TOP / "python").rglob("*.py"))
    named = re.findall(r"cbpt\[([\w,]+)\]", texts + (TOP / "README.md").read_text())
    parts = {part for name in named for part in name.split(",")}
    assert {"pandas", "xarray", "plot", "io"} <= parts <= extras
    documented = (TOP / "docs/install.md").read_text()
    assert [extra for extra in extras if f"| `{extra}` |" not in documented] == []


def test_classifiers_begin_at_the_python_that_is_required() -> None:
    project = PROJECT["project"]
    least = project["requires-python"].removeprefix(">=")
    assert f"Programming Language :: Python :: {least}" in project["classifiers"]
    assert project["classifiers"] == sorted(project["classifiers"])
    minimum = dict(part.split(">=") for part in project["dependencies"][:2])
    oldest = dict(
        part.split("==") for part in run_path(str(TOP / ".ci/wheels.py"))["OLDEST"][least]
    )
    assert {name: f"{version}.0" for name, version in minimum.items()} == oldest
