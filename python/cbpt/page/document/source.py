"""Where a document comes from: names and texts of its files, and the commands that read them.

Command     the words of a command line on a case and a table
Source      names and texts of the files, as the document tells them
Told        what no file says: the rig, who writes, when
from_here   a file as a command line names it
as_word     a file's name, never taken for an option
named       readings without the folder that they come from
"""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path, PurePath

from cbpt.lab.readings.reader import Readings
from cbpt.page.document.types import CommandWords

__all__ = ["Command", "Source", "Told", "as_word", "from_here", "named"]


@dataclass(frozen=True)
class Command:
    """The words of a command line on a case and a table."""

    case: str
    data: str
    reading: tuple[str, ...] = ()
    """Flags that say how the table is read; every verb that reads one takes them."""
    diagnosis: tuple[str, ...] = ()
    """Flags of the diagnosis alone: effects that compete, seed."""

    @property
    def report(self) -> str:
        """The command that writes the report."""
        words = ["cbpt", "report", self.case, self.data, *self.reading, *self.diagnosis]
        return shlex.join([*words, "--out", "report.html"])

    def compare(self, case: str) -> str:
        """The command that compares another case file with the same table."""
        return shlex.join(["cbpt", "compare", case, self.data, *self.reading])

    def words(self) -> CommandWords:
        """The parts, each quoted for a shell."""
        return {
            "case": shlex.quote(self.case),
            "data": shlex.quote(self.data),
            "reading": shlex.join(self.reading),
        }


@dataclass(frozen=True)
class Told:
    """What no file says, for the head of a report."""

    rig: str | None = None
    author: str | None = None
    date: str | None = None


@dataclass(frozen=True)
class Source:
    """What the document tells of its files, and the command line that makes it."""

    case_name: str
    data_name: str
    case_text: str
    command: Command
    told: Told = Told()
    angle_unit: str = "arcsec"
    """In which a report is opened; the page can change it."""

    @classmethod
    def of_files(
        cls,
        case: str,
        data: str,
        case_text: str = "",
        reading: Sequence[str] = (),
        diagnosis: Sequence[str] = (),
    ) -> Source:
        """Of files on disk; the flags are those of `Command`."""
        command = Command(from_here(case), from_here(data), tuple(reading), tuple(diagnosis))
        return cls(PurePath(case).name, PurePath(data).name, case_text, command)


def from_here(path: str) -> str:
    """A file as a command line names it on a page that may be sent on: from where it is run, and
    without what lies above that."""
    here = Path.cwd()
    file = Path(path)
    if not file.is_absolute():
        return path
    return str(file.relative_to(here)) if file.is_relative_to(here) else file.name


def as_word(name: str) -> str:
    """A file's name in a command line, never taken for an option."""
    return f"./{name}" if name.startswith("-") else name


def named(readings: Readings, path: str, name: str) -> Readings:
    """Readings of a file by its name alone: where it lies is nobody else's business."""
    return replace(readings, source=readings.source.replace(path, name, 1))
