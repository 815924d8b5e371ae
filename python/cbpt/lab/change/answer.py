"""What changed: the record with its text and its document.

Change   the answer of `change`
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from math import isfinite
from typing import Any

from cbpt.lab.change.record import ByItself, Changed, ChangeData
from cbpt.lab.change.text import lines, sentence
from cbpt.lab.wording.html import Reported
from cbpt.lab.wording.numbers import angle_unit_of
from cbpt.lab.wording.versions import versions

__all__ = ["Change"]

SCHEMA = "cbpt.change/1"


def _plain(record: Changed | ByItself) -> dict[str, Any]:
    """As plain values."""
    moved = {"moved": record.moved} if isinstance(record, Changed) else {}
    return {k: list(v) if isinstance(v, tuple) else v for k, v in asdict(record).items()} | moved


@dataclass(frozen=True, eq=False, repr=False)
class Change(Reported, ChangeData):
    """What changed between campaigns on the same reducer."""

    @property
    def sentence(self) -> str:
        """The verdict in words."""
        return sentence(self)

    def sentence_in(self, angle_unit: str) -> str:
        """The same with angles in this unit."""
        return sentence(self, angle_unit_of(angle_unit))

    def to_dict(self) -> dict[str, Any]:
        """As plain values, the same that `to_json` writes. Values SI."""
        return {
            "schema": SCHEMA,
            "versions": versions(),
            "by": self.by,
            "verdict": self._verdict(),
            "unchanged": [asdict(u) for u in self.unchanged],
            "odd_level": self._odd_level(),
            "rests_differ_arcsec": self.rests_differ_arcsec,
            "unlike_design": self.unlike_design or None,
            "not_shown": {effect: list(levels) for effect, levels in self.not_shown.items()},
            "by_itself": [_plain(b) for b in self.by_itself],
            "noise": self.noise.to_dict(),
            "remains": self.remains,
            "not_followed_arcsec": self.not_followed_arcsec,
            "moves_arcsec": {e: m if isfinite(m) else None for e, m in self.moves_arcsec.items()},
            "told_from_arcsec": self.told_from_arcsec,
            "hidden": list(self.hidden),
            "runs_differ": list(self.runs_differ),
            "on_large_loops": list(self.on_large_loops),
            "levels": [
                {
                    "level": level,
                    "source": readings.source,
                    "data_sha256": readings.sha256,
                    "readings": len(readings),
                    "rmse_arcsec": rmse,
                    "u_arcsec": u,
                }
                for level, readings, rmse, u in zip(
                    self.levels,
                    self.readings,
                    self.rmse_arcsec,
                    self.noise.u_arcsec,
                    strict=True,
                )
            ],
            "loops": [
                asdict(w) | {"differ": w.differ and [self.levels[i] for i in w.differ]}
                for w in self.loops
            ],
            "effects_fitted_at_every_level": list(self.effects),
            "probability_of_change": {
                g.effect: self.weighed.changed(g.effect) for g in self.weighed.groups
            },
            "combinations": [
                {
                    "effects": sorted({v.effect for v in choice.levels.variants}),
                    "changed": sorted(choice.changed),
                    "probability": choice.probability,
                }
                for choice in self.weighed.choices
                if choice.probability >= 0.001
            ],
            "reproducibility_arcsec": self.reproducibility_arcsec,
            "levels_differ_by_arcsec": self.levels_differ_by_arcsec,
            "notes": list(self.notes),
        }

    def _odd_level(self) -> dict[str, Any] | None:
        """With the names of its levels."""
        odd = self.odd_level
        if odd is None:
            return None
        return asdict(odd) | {"level": self.levels[odd.level], "other": self.levels[odd.other]}

    def _verdict(self) -> dict[str, Any]:
        """What changed, as plain values."""
        return {
            "kind": self.kind,
            "changed": [_plain(c) for c in self.changed],
            "rivals": [list(group) for group in self.rivals],
            "rests_on": self._rests_on(),
            "perhaps": [{"effect": e, "probability": p} for e, p in self.perhaps.items()],
            "probability": self.probability,
            "sentence": self.sentence,
        }

    def _rests_on(self) -> list[dict[str, Any]]:
        """Numbers from outside the readings, and of which size they would undo the verdict."""
        if self.kind != "changed" or self.reproducibility_arcsec is not None:
            return []
        size = self.levels_differ_by_arcsec
        # Levels that lie 3.5 standard deviations of their difference apart, sqrt(2) of one: as far
        # as it takes for two values in place of one, whose ranges are wide.
        undone = None if size is None else size / 5
        return [{"number": "reproducibility_arcsec", "taken_as": 0.0, "would_undo": undone}]

    def to_json(self) -> str:
        """One JSON document."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False, default=float)

    def report(self, angle_unit: str = "arcsec") -> str:
        """As text, angles in `angle_unit` (arcsec, arcmin, deg, urad, mrad, rad)."""
        return "\n".join(lines(self, angle_unit_of(angle_unit)))

    def __repr__(self) -> str:
        return self.report()
