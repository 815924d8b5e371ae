"""What an answer says, whatever the version of its document.

    read(document)   the answer as the score knows it
    kept(document)   what of a document is kept beside it

Nothing else of the trial looks into a document; older versions are read by `cbpt.read_answer`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

from cbpt import read_answer

Document = Mapping[str, Any]
NOTHING_MISSING = ("complete", "rig", "parameter")
"""Kinds of the first version that say that no effect is missing."""


@dataclass(frozen=True)
class Said:
    """An answer.

    kind: as the document has it. effects: what is certain. rivals: groups of which one is needed.
    perhaps: what may be at work besides. remains: something without a name is left. undecided: the
    data cannot say. probability: that `probability_of` is so: the whole of what was answered, or
    that all that is named is at work, whatever else is.
    """

    kind: str
    effects: tuple[str, ...]
    rivals: tuple[tuple[str, ...], ...]
    probability: float
    perhaps: tuple[str, ...] = ()
    remains: bool = False
    undecided: bool = False
    probability_of: Literal["whole", "named"] = "whole"

    def plain(self) -> dict[str, Any]:
        """As plain values."""
        return asdict(self)


def read(document: Document) -> Said:
    """The answer that a document carries."""
    found = read_answer(document)
    v = found["verdict"]
    first = document["schema"] == "cbpt.diagnosis/1"
    groups = tuple(tuple(g) for g in v["rivals"])
    unnamed = v["kind"] == "unknown" or any("unknown" in g for g in groups)
    return Said(
        v["kind"],
        tuple(v["effects"]),
        groups,
        float(v["probability"]),
        perhaps=tuple(p["effect"] for p in v["perhaps"]),
        remains=unnamed or found["remains"] is not None,
        undecided=v["kind"] == "undecided",
        probability_of="named" if (v["effects"] or groups) and not first else "whole",
    )


BULKY = ("where", "ranking", "detectable", "next_run", "ladder")


def kept(document: Document) -> dict[str, Any]:
    """The document without its long lists."""
    return {key: value for key, value in document.items() if key not in BULKY}
