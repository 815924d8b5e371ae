"""What README.md and the pages of docs/ show is run, block after block, as a reader would.

    ```python             all of a file in one namespace; `>>>` is compared with what it shows
    ```console, ```sh     lines that begin with `cbpt ` or `$ cbpt `; exit code 0, or 3 where the
                          line ends in `# exits 3`
    ```text               right after such a block: what it prints (of commands, the last one),
                          `...` for anything
    ```toml               a case file, where it has a deceleration pair

A file's blocks share a directory with a copy of examples/. A block is not run where the line
before it is a comment `<!-- not run: reason -->`.
"""

from __future__ import annotations

import contextlib
import doctest
import io
import re
import shlex
import shutil
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest

import cbpt
from cbpt.cli.main import main

TOP = Path(__file__).parents[2]
PAGES = [TOP / "README.md", *sorted((TOP / "docs").rglob("*.md"))]
FENCE = re.compile(r"^(?P<indent> *)(?P<mark>```+|~~~+) *(?P<language>[\w+-]*)")
NOT_RUN = re.compile(r"<!-- *not run: *\S.*-->")
COMMAND = re.compile(r"^(?:\$ +)?(?P<command>cbpt .*)$")
EXITS = re.compile(r"#.*\bexits (\d+)\b")


@dataclass(frozen=True)
class Block:
    """A fenced block: its language, its text, the line its text begins on, and what it follows."""

    language: str
    text: str
    line: int
    run: bool
    follows: Block | None


def blocks(page: str) -> Iterator[Block]:
    lines = page.splitlines()
    at = 0
    last: Block | None = None
    while at < len(lines):
        fence = FENCE.match(lines[at])
        if not fence:
            last = None if lines[at].strip() else last
            at += 1
            continue
        end = at + 1
        while end < len(lines) and lines[end].strip() != fence["mark"]:
            end += 1
        text = textwrap.dedent("\n".join(lines[at + 1 : end])) + "\n"
        run = not (at and NOT_RUN.search(lines[at - 1]))
        last = Block(fence["language"], text, at + 2, run, last)
        yield last
        at = end + 1


def commands(block: Block) -> Iterator[tuple[int, str]]:
    """The lines of a block that call cbpt, each with its number; a backslash joins the next."""
    lines = enumerate(block.text.splitlines(), block.line)
    for number, line in lines:
        found = COMMAND.match(line)
        if not found:
            continue
        command = found["command"]
        while command.endswith("\\"):
            command = command[:-1] + next(lines)[1].lstrip("> ")
        yield number, command


def run_python(page: Path, block: Block, namespace: dict[str, Any]) -> str:
    """Run a block in the namespace; returns what it prints."""
    printed = io.StringIO()
    place = f"{page.relative_to(TOP)}"
    with contextlib.redirect_stdout(printed):
        if block.text.lstrip().startswith(">>>"):
            test = doctest.DocTestParser().get_doctest(
                block.text, namespace, place, place, block.line - 1
            )
            doctest.DebugRunner(optionflags=doctest.ELLIPSIS).run(test, clear_globs=False)
            namespace.update(test.globs)
        else:
            # Blank lines above, so that a traceback has the line of the page.
            text = "\n" * (block.line - 1) + block.text
            exec(compile(text, str(page), "exec"), namespace)
    return printed.getvalue()


def run_command(command: str, place: str, capture: pytest.CaptureFixture[str]) -> str:
    """Run a line in this process, without the start of another; returns what it prints.

    That the installed command is the same has a test of its own (`tests/cli/test_command.py`).
    """
    expected = EXITS.search(command)
    capture.readouterr()
    code = main(shlex.split(command, comments=True)[1:])
    printed, told = capture.readouterr()
    assert code == (int(expected[1]) if expected else 0), f"{place}: {command}\n{printed}{told}"
    return printed


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(TOP)))
def test_what_a_page_shows_works(
    page: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capfd: pytest.CaptureFixture[str],
) -> None:
    ignored = shutil.ignore_patterns("embed", "__pycache__", "out")
    shutil.copytree(TOP / "examples", tmp_path / "examples", ignore=ignored)
    monkeypatch.chdir(tmp_path)
    namespace: dict[str, Any] = {"__name__": "__main__"}
    printed: dict[Block, str] = {}
    for block in blocks(page.read_text(encoding="utf-8")):
        place = f"{page.relative_to(TOP)}:{block.line}"
        if not block.run:
            continue
        if block.language == "python":
            printed[block] = run_python(page, block, namespace)
        elif block.language in ("console", "sh"):
            for number, command in commands(block):
                where = f"{page.relative_to(TOP)}:{number}"
                printed[block] = run_command(command, where, capfd)
        elif block.language == "text" and block.follows in printed:
            shown = printed[block.follows]
            same = doctest.OutputChecker().check_output(block.text, shown, doctest.ELLIPSIS)
            assert same, f"{place} is not what is printed:\n{shown}"
        elif block.language == "toml" and re.search(r"^\[deceleration\]", block.text, re.MULTILINE):
            cbpt.Case.from_toml(block.text, place)


# --- the reader of pages itself -----------------------------------------------------------

PAGE = """\
```python
a = 1
print(a + 1)
```

```text
2
```
Words.
```text
no output
```
<!-- not run: for a test -->
```sh
cbpt nothing
```
1. item
   ```console
   $ cbpt solve x.toml \\
   >   --json   # exits 2
   $ make
   cbpt schema
   ```
"""


def test_blocks_are_found_with_their_places() -> None:
    found = list(blocks(PAGE))
    assert [(block.language, block.line, block.run) for block in found] == [
        ("python", 2, True),
        ("text", 7, True),
        ("text", 11, True),
        ("sh", 15, False),
        ("console", 19, True),
    ]
    assert found[1].follows is found[0]
    assert found[2].follows is None
    assert list(commands(found[4])) == [
        (19, "cbpt solve x.toml --json   # exits 2"),
        (22, "cbpt schema"),
    ]


def test_what_fails_is_told(capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(AssertionError, match="page:7: cbpt solve"):
        run_command("cbpt solve missing.toml", "page:7", capfd)
    run_command("cbpt solve missing.toml  # exits 2: there is no such file", "page:7", capfd)
    with pytest.raises(ZeroDivisionError):
        run_python(TOP / "README.md", Block("python", "1 / 0\n", 2, True, None), {})
    with pytest.raises(doctest.DocTestFailure):
        run_python(TOP / "README.md", Block("python", ">>> 1 + 1\n3\n", 2, True, None), {})
    run_python(TOP / "README.md", Block("python", ">>> print('a b')\na ...\n", 2, True, None), {})
