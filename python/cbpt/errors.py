"""What can be wrong with the input, one class for each kind; all under `CbptError`.

An error says where (file, line, column, field), what was found, what was expected and what to
do about it. A case that cannot be solved is no error: it is a row with its status.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

__all__ = [
    "CaseError",
    "CbptError",
    "InvalidInputError",
    "Mistake",
    "NoSolutionError",
    "PlanError",
    "PlotError",
    "ReadingsError",
]


class CbptError(Exception):
    """Base of every error that the product raises on purpose."""


class InvalidInputError(CbptError, ValueError):
    """A number of a drive or of a load that cannot be: names it, its value and what is required."""


class CaseError(CbptError, ValueError):
    """A case file cannot be read as it is: file, line, key, what was found and what is allowed."""


class PlanError(CbptError, ValueError):
    """A plan cannot be read, or cannot be carried out: file, run, key, what was found, expected."""


class NoSolutionError(PlanError):
    """Rows of a plan at which the model has no solution."""


class PlotError(CbptError):
    """A picture cannot be drawn: matplotlib is missing or the file name has no known ending."""


@dataclass(frozen=True, slots=True)
class Mistake:
    """One thing wrong with a table, on one line or, the same thing again, on several.

    `lines` are 1-based and empty where the table as a whole is meant; `value` is what the first
    of them holds.
    """

    lines: tuple[int, ...]
    column: str
    value: str
    expected: str
    remedy: str = ""

    def describe(self, place: str = "line") -> str:
        """One sentence; `place` is what a line is called ("line" of a file, "row" of data)."""
        where = f"{place} {self.lines[0]}, " if self.lines else ""
        where += f"column {self.column!r}: " if self.column else ""
        text = f"{where}found {self.value}, expected {self.expected}"
        if len(self.lines) > 1:
            rest = self.lines[1:]
            text += f" (the same on {place}s {', '.join(map(str, rest[:8]))}"
            text += f" and {len(rest) - 8} more)" if len(rest) > 8 else ")"
        return f"{text}; {self.remedy}" if self.remedy else text


class ReadingsError(CbptError, ValueError):
    """A table of readings cannot be read as it is; lists every mistake found, up to ten.

    Attributes: `path` (the file, or "<data>"), `mistakes`, and of the first of them `line`
    (1-based; None where the table as a whole is meant), `column`, `value`, `expected`.
    """

    SHOWN = 10

    def __init__(self, path: str, mistakes: Sequence[Mistake], place: str = "line") -> None:
        self.path = path
        self.mistakes = tuple(mistakes)
        self.place = place
        first = self.mistakes[0]
        self.line = first.lines[0] if first.lines else None
        self.column = first.column
        self.value = first.value
        self.expected = first.expected
        sentences = [mistake.describe(place) for mistake in self.mistakes[: self.SHOWN]]
        if len(self.mistakes) > self.SHOWN:
            sentences.append(f"and {len(self.mistakes) - self.SHOWN} more")
        joint = "\n  " if len(sentences) > 1 else " "
        super().__init__(f"{path}:{joint}" + joint.join(sentences))

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
