"""Progress of work that has parts.

part_of  tells the progress of a part
rising   never goes back, where parts are done at once
untold   where nobody asks
"""

from __future__ import annotations

from cbpt.lab.selection.competition import Progress


def part_of(tell: Progress, begin: float, end: float, head: str = "") -> Progress:
    """Tells the progress of a part of the work, which goes from one share of the whole to another;
    head: what stands before what is next."""
    return lambda what, share: tell(head + what, begin + (end - begin) * share)


def rising(tell: Progress) -> Progress:
    """Tells the largest share so far in place of a smaller one."""
    most = 0.0

    def told(what: str, share: float) -> None:
        nonlocal most
        most = max(most, share)
        tell(what, most)

    return told


def untold(what: str, share: float) -> None:
    """Progress that nobody asks for."""
