"""The answer: figures of readings, of the model, or of both side by side, with text and picture.

Characteristics   all groups, with the convention and the warnings
"""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import Any

import numpy as np

from cbpt.figures.characteristics import Branches, LoopPicture, draw_loops
from cbpt.lab.characteristics.record import CharacteristicsData, Group
from cbpt.lab.characteristics.text import lines
from cbpt.lab.characteristics.uncertainty import LoopSet
from cbpt.lab.wording.html import Reported
from cbpt.lab.wording.numbers import angle_unit_of
from cbpt.lab.wording.versions import versions

__all__ = ["Characteristics"]

SCHEMA = "cbpt.characteristics/1"


@dataclass(frozen=True, eq=False, repr=False)
class Characteristics(Reported, CharacteristicsData):
    """Figures of catalogues and standards, with standard uncertainties (k = 1)."""

    def to_dict(self) -> dict[str, Any]:
        """As plain values, the same that `to_json` writes."""
        source = self.source
        return {
            "schema": SCHEMA,
            "versions": versions(),
            "source": source.source if source else None,
            "data_sha256": source.sha256 if source else None,
            "of": "readings" if source else "model",
            "by": self.by,
            "rated_torque_Nm": self.convention.rated_torque_Nm,
            "rated_torque_from": self.rated_torque_from,
            "window": self.convention.window,
            "figures": [figure.to_dict() for figure in self.figures],
            "model_figures": [f.to_dict() for g in self.groups if g.readings for f in g.model],
            "ratios": [
                {"name": name, "setting": g.setting, "value": value, "u": u}
                for g in self.groups
                for name, value, u in g.ratios()
            ],
            "stiffness_curve": [
                {"setting": g.setting, **row}
                for g in self.groups
                for row in g.stiffness_curve(self.convention)
            ],
            "warnings": [
                {"setting": g.setting, "warning": w} for g in self.groups for w in g.warnings
            ],
            "notes": list(map(str, source.notes)) if source else [],
        }

    def to_json(self) -> str:
        """One JSON document."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False)

    def report(self, angle_unit: str = "arcsec") -> str:
        """As text, angles in `angle_unit` (arcsec, arcmin, deg, urad, mrad, rad)."""
        return "\n".join(map(angle_unit_of(angle_unit).retold, lines(self, angle_unit)))

    def plot(self, path: str | os.PathLike[str], angle_unit: str = "arcsec") -> None:
        """Draw the loops, with the figures where they are read off, to an SVG, PNG or PDF file.

        Needs matplotlib: `pip install "cbpt[plot]"`.
        """
        draw_loops([self._picture(group) for group in self.groups], path, angle_unit)

    def _picture(self, group: Group) -> LoopPicture:
        loops, model = group.loops or group.model_loops, group.model_loops
        return LoopPicture(
            title=group.setting or (self.source.source if self.source else "model"),
            loops=_drawn(loops),
            model=_drawn(model) if group.loops else [],
            values={f.name: f.value for f in group.figures},
            rated_torque_Nm=self.convention.rated_torque_Nm,
            window_Nm=self.convention.window_Nm,
        )

    def __repr__(self) -> str:
        return self.report()


def _drawn(loops: LoopSet | None) -> list[Branches]:
    """Branches of each full loop as they are drawn, each loop about its own middle."""
    found: list[Branches] = []
    for loop in loops.full if loops else ():
        at_zero = [float(b.at(np.clip(0.0, *b.ends_Nm))) for b in loop.branches]
        middle = float(np.mean(at_zero))
        found.append([(b.torque_Nm, b.angle_arcsec - middle) for b in loop.branches])
    return found
