"""What can be wrong with the input, one class for each kind; all under `CbptError`.

An error says where (file, line, column, field), what was found, what was expected and what to
do about it. A case that cannot be solved is no error: it is a row with its status.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

__all__ = [
    "CaseError",
    "CaseMistake",
    "CbptError",
    "ChooseSheet",
    "InvalidInputError",
    "MissingLibraryError",
    "Mistake",
    "NoSolutionError",
    "PlanError",
    "PlotError",
    "ReadingsError",
    "Say",
    "Setting",
    "Step",
    "TakeColumn",
    "Words",
    "said",
    "told",
]


@dataclass(frozen=True, slots=True)
class TakeColumn:
    """A step: take the column under a header as a quantity in a unit; `extra` sets it aside."""

    header: str
    column: str

    def __str__(self) -> str:
        return f"pass columns={{{self.header!r}: {self.column!r}}}"


@dataclass(frozen=True, slots=True)
class ChooseSheet:
    """A step: read a sheet of a workbook, a struct or a group of a file."""

    name: str

    def __str__(self) -> str:
        return f"pass sheet={self.name!r}"


@dataclass(frozen=True, slots=True)
class Setting:
    """A step that names no place: `columns` or `sheet` as a whole."""

    name: str

    def __str__(self) -> str:
        return f"`{self.name}`"


Step = TakeColumn | ChooseSheet | Setting
"""What a reader is told to do. A front end says it in its own way; `str` says it in Python."""
Say = Callable[[Step], str]


class Words(str):
    """Text some parts of which are steps. As a `str` the steps are said in Python."""

    __slots__ = ("parts",)
    parts: tuple[str | Step, ...]

    def __new__(cls, *parts: str | Step) -> Words:
        flat: list[str | Step] = []
        for part in parts:
            flat += part.parts if isinstance(part, Words) else [part]
        words = super().__new__(cls, "".join(map(str, flat)))
        words.parts = tuple(flat)
        return words

    def __reduce__(self) -> tuple[type[Words], tuple[str | Step, ...]]:
        return type(self), self.parts

    @property
    def steps(self) -> tuple[Step, ...]:
        """The steps alone."""
        return tuple(part for part in self.parts if not isinstance(part, str))


def said(text: str, say: Say) -> str:
    """A text with its steps said by a front end."""
    if not isinstance(text, Words):
        return text
    return "".join(part if isinstance(part, str) else say(part) for part in text.parts)


class CbptError(Exception):
    """Base of every error that the product raises on purpose."""


class InvalidInputError(CbptError, ValueError):
    """A number of a drive or of a load that cannot be: names it, its value and what is required.

    Attributes: `field`, `found` and `required`, each empty where the message alone says it.
    """

    def __init__(
        self, message: str = "", field: str = "", found: str = "", required: str = ""
    ) -> None:
        super().__init__(message)
        self.field = field
        self.found = found
        self.required = required

    def __reduce__(self) -> tuple[type[InvalidInputError], tuple[str, str, str, str]]:
        return type(self), (str(self), self.field, self.found, self.required)


@dataclass(frozen=True, slots=True)
class CaseMistake:
    """One thing wrong with a case."""

    key: str
    """Dotted, as it was written; empty where the whole case is meant."""
    found: str
    """The value as it was written; empty where the key itself is the mistake."""
    problem: str
    """What is wrong; empty where `allowed` says it all."""
    allowed: str
    """What to write instead."""
    nearest: str | None
    """The nearest right key or word."""
    place: tuple[int | None, int | None, int | None]
    """Line and column of the file, and character of an expression, each from 1."""
    words: str
    """`problem`, `nearest` and `allowed` as text."""


class CaseError(CbptError, ValueError):
    """A case file cannot be read as it is: file, line, key, what was found and what is allowed.

    Attributes: `mistakes`, in the order of the file; empty where no part of the case is at fault;
    `shown`, the message with the lines of the file and a caret under each mistake.
    """

    def __init__(
        self, message: str = "", mistakes: Sequence[CaseMistake] = (), shown: str = ""
    ) -> None:
        super().__init__(message)
        self.mistakes = tuple(mistakes)
        self.shown = shown or message

    def __reduce__(self) -> tuple[type[CaseError], tuple[str, tuple[CaseMistake, ...], str]]:
        return type(self), (str(self), self.mistakes, self.shown)


class PlanError(CbptError, ValueError):
    """A plan cannot be read, or cannot be carried out: file, run, key, what was found, expected."""


class NoSolutionError(PlanError):
    """Rows of a plan at which the model has no solution."""


class MissingLibraryError(CbptError, ImportError):
    """A library is missing that only this needs; says how to install it."""


class PlotError(CbptError):
    """A picture cannot be drawn: matplotlib is missing or the file name has no known ending."""


@dataclass(frozen=True, slots=True)
class Mistake:
    """One thing wrong with a table, on one line or, the same thing again, on several.

    `lines` are 1-based and empty where the table as a whole is meant; `value` is what the first
    of them holds. The texts may be `Words`, whose steps a front end says in its own way.
    """

    lines: tuple[int, ...]
    column: str
    value: str
    expected: str
    remedy: str = ""

    def describe(self, place: str = "line", say: Say = str) -> str:
        """One sentence; `place` is what a line is called ("line" of a file, "row" of data), `say`
        how steps are said."""
        where = f"{place} {self.lines[0]}, " if self.lines else ""
        where += f"column {self.column!r}: " if self.column else ""
        found, expected = _short(said(self.value, say)), _short(said(self.expected, say))
        text = f"{where}found {found}, expected {expected}"
        if len(self.lines) > 1:
            rest = self.lines[1:]
            text += f" (the same on {place}s {', '.join(map(str, rest[:8]))}"
            text += f" and {len(rest) - 8} more)" if len(rest) > 8 else ")"
        return f"{text}; {_short(said(self.remedy, say))}" if self.remedy else text


def _short(text: str) -> str:
    """As much of a text as a message can hold."""
    return text if len(text) <= 1200 else f"{text[:1200]}..."


class ReadingsError(CbptError, ValueError):
    """A table of readings cannot be read as it is; lists the mistakes found, up to ten.

    Attributes: `path` (the file, or "<data>"), `mistakes`, and of the first of them `line`
    (1-based; None where the table as a whole is meant), `column`, `value`, `expected`.
    """

    SHOWN = 10
    MOST = 100
    """Reading stops after so many."""

    def __init__(self, path: str, mistakes: Sequence[Mistake], place: str = "line") -> None:
        self.path = path
        self.mistakes = tuple(mistakes)
        self.place = place
        first = self.mistakes[0]
        self.line = first.lines[0] if first.lines else None
        self.column = first.column
        self.value = first.value
        self.expected = first.expected
        super().__init__(self.told(str))

    def told(self, say: Say) -> str:
        """The message, its steps said by a front end."""
        sentences = [mistake.describe(self.place, say) for mistake in self.mistakes[: self.SHOWN]]
        if len(self.mistakes) > self.SHOWN:
            at_least = "at least " if len(self.mistakes) >= self.MOST else ""
            sentences.append(f"and {at_least}{len(self.mistakes) - self.SHOWN} more")
        joint = "\n  " if len(sentences) > 1 else " "
        return f"{self.path}:{joint}" + joint.join(sentences)

    @classmethod
    def of_table(cls, path: str, column: str, expected: str) -> ReadingsError:
        """Make the error of a table that lacks a whole column.

        Parameters
        ----------
        path : str
            The table.
        column : str
            The column that is missing.
        expected : str
            What was expected.

        Returns
        -------
        ReadingsError
            The error, with one mistake.
        """
        return cls(path, [Mistake((), column, "no such column", expected)])

    @classmethod
    def of_column(
        cls, path: str, column: str, found: str, expected: str, remedy: str = ""
    ) -> ReadingsError:
        """Make the error of a column that is there but cannot be used as it is.

        Parameters
        ----------
        path : str
            The table.
        column : str
            The column.
        found, expected : str
            What it holds, and what was expected.
        remedy : str
            What to do about it.

        Returns
        -------
        ReadingsError
            The error, with one mistake.
        """
        return cls(path, [Mistake((), column, found, expected, remedy)])

    def __reduce__(
        self,
    ) -> tuple[Callable[..., ReadingsError], tuple[str, tuple[Mistake, ...], str]]:
        return type(self), (self.path, self.mistakes, self.place)


def told(error: Exception, say: Say) -> str:
    """The message of an error, its steps said by a front end."""
    return error.told(say) if isinstance(error, ReadingsError) else str(error)
