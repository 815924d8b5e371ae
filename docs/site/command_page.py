"""The page of the command line, made from the help of every verb (of clap and of argparse)."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

HEAD = """\
# Command line

`make docs` writes this page from the help of the program: `cbpt --help` lists the verbs,
`cbpt VERB --help` explains one.

Every verb ends with one of these exit codes:

| code | meaning |
|---|---|
| 0 | done |
| 1 | a file cannot be written |
| 2 | the input is wrong; the message names the place and the remedy |
| 3 | there is no solution, or no design keeps the bounds |
| 4 | `check` found an error in the design |
| 130 | interrupted by Ctrl-C |

A file is written whole or not at all: it stands beside its place until it is complete, and then
takes it. A symbolic link is followed: the file that it leads to is replaced. A CSV file of a sweep
grows row by row, with a record beside it.

"""
VERB = re.compile(r"^  ([a-z][a-z-]*)  +(.*)$")
SECTION = re.compile(r"^(\S.*):$")
VALUE = re.compile(r"^- (\S+):\s+(.*)$")
USAGE = re.compile(r"^usage:\s*(.*?)\n\n", re.IGNORECASE | re.DOTALL | re.MULTILINE)


def said(*arguments: str) -> str:
    """What the program prints, in lines of 100 characters."""
    ran = subprocess.run(
        [sys.executable, "-m", "cbpt.cli.main", *arguments],
        check=True,
        capture_output=True,
        text=True,
        encoding="utf-8",
        env={**os.environ, "COLUMNS": "100", "PYTHONIOENCODING": "utf-8"},
    )
    return ran.stdout


def verbs(text: str) -> list[str]:
    """The verbs that the help of the program lists."""
    commands = text.partition("Commands:\n")[2].partition("\n\n")[0]
    return [m[1] for line in commands.splitlines() if (m := VERB.match(line)) and m[1] != "help"]


def sections(text: str) -> Iterator[tuple[str, list[str]]]:
    """Each section of a help text that lists arguments: its title, and its lines."""
    title, lines = "", list[str]()
    for line in text.splitlines():
        if found := SECTION.match(line):
            if title:
                yield title, lines
            title, lines = found[1], []
        elif line[:1].strip():  # a paragraph after the last section
            if title:
                yield title, lines
            title = ""
        elif title:
            lines.append(line)
    if title:
        yield title, lines


def entries(lines: list[str]) -> list[tuple[str, str]]:
    """Argument and explanation, from the two-column form or with the explanation below it."""
    found: list[tuple[str, list[str]]] = []
    for line in lines:
        indent = len(line) - len(line.lstrip())
        if line.strip() and indent <= 6:
            name, _, rest = line.strip().partition("  ")
            found.append((name, [rest.strip()] if rest.strip() else []))
        elif line.strip() and found:
            found[-1][1].append(line.strip())
    return [
        (name.replace("|", "\\|"), in_a_cell(words))
        for name, words in found
        if not name.startswith(("-h,", "-V,"))
    ]


def in_a_cell(lines: list[str]) -> str:
    """An explanation in one line of a table, with listed values one after the other."""
    values = [VALUE.sub(r"`\1` (\2)", line) for line in lines if VALUE.match(line)]
    words = [line for line in lines if not VALUE.match(line)]
    if values and "Possible values:" in words:
        words[words.index("Possible values:")] = f"One of {', '.join(values)}."
    text = " ".join(words).replace("|", "\\|")
    return re.sub(r"<(?=\w)", r"\\<", text)


def section_of(verb: str, text: str) -> str:
    """One verb as a section of the page."""
    usage = USAGE.search(text)
    if usage is None:
        raise SystemExit(f"cbpt {verb} --help: no usage found")
    before, after = text[: usage.start()].strip(), text[usage.end() :]
    about = before or after.partition("\n\n")[0].strip()
    lines = [f"## {verb}", "", " ".join(about.split()), "", "```text"]
    words = " ".join(usage[1].split())
    lines += [words, "```", ""]
    rows = [(title, entries(listed)) for title, listed in sections(after)]
    if not any(listed for _, listed in rows):
        raise SystemExit(f"cbpt {verb} --help: no arguments found")
    for title, listed in rows:
        if listed:
            lines += [f"| {title} | |", "|---|---|"]
            lines += [f"| `{name}` | {explained} |" for name, explained in listed]
            lines.append("")
    return "\n".join(lines)


def write(source: Path) -> None:
    """Write the page into the folder of sources."""
    whole = said("--help")
    names = verbs(whole)
    if len(names) < 10:
        raise SystemExit(f"cbpt --help lists too few verbs: {names}")
    with ThreadPoolExecutor(2) as pool:
        helps = list(pool.map(lambda verb: said(verb, "--help"), names))
    parts = [HEAD, *(f"{section_of(v, t)}\n" for v, t in zip(names, helps, strict=True))]
    (source / "reference" / "command-line.md").write_text("\n".join(parts), encoding="utf-8")
