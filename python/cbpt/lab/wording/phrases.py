"""Parts of sentences that many have.

few      the first few names of many
some     a word in front of them
counted  a number of things
span     two numbers as a range
"""

from __future__ import annotations

from collections.abc import Sequence

from cbpt.lab.wording.numbers import listed, rounded

_SHOWN = 5


def few(names: Sequence[str], most: int = _SHOWN) -> str:
    """`1, 2 and 3`, or `1, 2, 3, 4, 5 and 7 more`."""
    shown = list(names[:most])
    if len(names) == len(shown):
        return listed(shown)
    return f"{', '.join(shown)} and {len(names) - len(shown)} more"


def some(word: str, names: Sequence[str], most: int = _SHOWN) -> str:
    """`run 3`, `runs 1, 2 and 3`, or `runs 1, 2, 3, 4, 5 and 7 more`."""
    return f"{word}{'s' * (len(names) > 1)} {few(names, most)}"


def counted(number: int, thing: str) -> str:
    """`1 run`, or `3 runs`."""
    return f"{number} {thing}{'s' * (number != 1)}"


def span(low: float, high: float, digits: int = 3) -> str:
    """`2`, or `2 to 5`."""
    first, last = rounded(low + 0.0, digits), rounded(high + 0.0, digits)  # -0 is 0
    return first if first == last else f"{first} to {last}"
