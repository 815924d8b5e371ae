"""What an answer says, whatever the version of its document.

    read(document)   the answer as the score knows it
    kept(document)   what of a document is kept beside it

A version of the document needs one reader here, entered in READERS; nothing else of the trial looks
into a document.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal

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


def _first(document: Document) -> Said:
    v = document["verdict"]
    groups = tuple(tuple(g) for g in v["rivals"])
    unnamed = v["kind"] == "unknown" or any("unknown" in g for g in groups)
    return Said(v["kind"], tuple(v["effects"]), groups, float(v["probability"]), remains=unnamed)


def _second(document: Document) -> Said:
    v = document["verdict"]
    groups = tuple(tuple(g) for g in v["rivals"])
    unnamed = v["kind"] == "unknown" or any("unknown" in g for g in groups)
    return Said(
        v["kind"],
        tuple(v["effects"]),
        groups,
        float(v["probability"]),
        perhaps=tuple(p["effect"] for p in v["perhaps"]),
        remains=unnamed or document["remains"] is not None,
        undecided=v["kind"] == "undecided",
        probability_of="named" if v["effects"] or groups else "whole",
    )


READERS: dict[str, Callable[[Document], Said]] = {
    "cbpt.diagnosis/1": _first,
    "cbpt.diagnosis/2": _second,
}
"""By the document's `schema`."""
BULKY = ("where", "ranking", "detectable", "next_run", "ladder")


def read(document: Document) -> Said:
    """The answer that a document carries."""
    schema = document["schema"]
    if schema not in READERS:
        raise ValueError(f"no reader for documents of {schema}; add one to READERS in adapter.py")
    return READERS[schema](document)


def kept(document: Document) -> dict[str, Any]:
    """The document without its long lists."""
    return {key: value for key, value in document.items() if key not in BULKY}
