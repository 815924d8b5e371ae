"""Tables that the command line and the lab share."""

import numpy as np
import pytest

from cbpt._core import text_table


def cells(table: str) -> list[list[str]]:
    """The cells of the rows below the head."""
    return [
        [cell.strip() for cell in line.strip("│").split("┆")] for line in table.split("\n")[3:-1]
    ]


def test_numbers_are_rounded_and_what_is_missing_is_a_dash() -> None:
    rows: list[list[str | float | None]] = [
        ["a", 1.23456789, None],
        ["b", np.float64(2), True],
        ["c", float("nan"), 10**30],
        ["d", float("inf"), 12_345_678],
    ]
    assert cells(text_table(["name", "x", "y"], rows)) == [
        ["a", "1.23457", "-"],
        ["b", "2", "true"],
        ["c", "-", "1e30"],
        ["d", "-", "12345678"],
    ]


def test_a_cell_that_is_no_number_and_no_text_is_refused() -> None:
    with pytest.raises(TypeError, match="Cell"):
        text_table(["x"], [[object()]])  # type: ignore[list-item]
