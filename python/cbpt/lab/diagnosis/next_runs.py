"""The run that would decide what the readings leave open: document and text.

next_runs   a case and its readings -> NextRuns
ranked      the same of a diagnosis that has been made
NextRuns    runs ranked by what they are expected to bring
"""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from cbpt._core import Case, Drive
from cbpt.lab.diagnosis.deciding_runs import CANDIDATES, HARDLY, most_probable, rank
from cbpt.lab.diagnosis.diagnose import diagnose
from cbpt.lab.diagnosis.diagnosis import Diagnosis
from cbpt.lab.experiment.candidates import Limits, described
from cbpt.lab.experiment.expected_gain import DECIDED, LIMIT, Suggested
from cbpt.lab.experiment.plan import Plan
from cbpt.lab.readings.reader import Readings
from cbpt.lab.wording import html, layout
from cbpt.lab.wording.numbers import listed, rounded
from cbpt.lab.wording.versions import versions

__all__ = ["NextRuns", "next_runs", "ranked"]

SCHEMA = "cbpt.next_run/1"
_FROM_LEADING = "separates the most probable from"


@dataclass(frozen=True, eq=False)
class NextRuns:
    """Runs ranked by what they are expected to bring. `report` says it in words."""

    diagnosis: Diagnosis = field(repr=False)
    open: Mapping[str, float]
    """Hypotheses that are open, with the share of each among them."""
    ranked: tuple[Suggested, ...]
    why_none: str = ""
    """Why no run is suggested, where none is."""
    twins: tuple[tuple[str, str], ...] = ()
    """Pairs that no reading of this rig tells apart."""
    untold: tuple[str, ...] = ()
    """Hypotheses that no run within reach tells from the most probable one."""

    @property
    def best(self) -> Suggested | None:
        """The first of the runs."""
        return self.ranked[0] if self.ranked else None

    def plan(self) -> Plan | None:
        """The best run as a plan."""
        return Plan.of_runs([self.ranked[0].run]) if self.ranked else None

    def runs_like_it(self) -> int | None:
        """About how many such runs the closest pair needs, were each to bring as much."""
        if self.best is None:
            return None
        least = min(g for pair, g in self.best.pairs.items() if pair not in self.twins)
        return int(np.ceil(LIMIT / max(least, 1e-9))) if least > HARDLY else None

    def to_dict(self) -> dict[str, Any]:
        """The JSON document as plain values."""
        return {
            "schema": SCHEMA,
            "seed": self.diagnosis.seed,
            "versions": versions(),
            "data_sha256": self.diagnosis.readings.sha256,
            "source": self.diagnosis.readings.source,
            "open": dict(self.open),
            "why_none": self.why_none,
            "twins": [list(pair) for pair in self.twins],
            "untold": list(self.untold),
            "runs": [
                {
                    **vars(s.run),
                    "direction": described(s.run),
                    "gain": s.gain,
                    "largest_gain": s.largest_gain,
                    "separates": s.separates,
                    "pairs": [{"between": list(p), "gain": g} for p, g in s.pairs.items()],
                }
                for s in self.ranked
            ],
        }

    def to_json(self) -> str:
        """The document as text."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False, default=float)

    def report(self, most: int = 5, angle_unit: str = "arcsec") -> str:
        """In words and a table of the best runs."""
        return "\n".join(self._lines(most, angle_unit))

    def _lines(self, most: int, angle_unit: str) -> Iterator[str]:
        yield self.diagnosis.sentence_in(angle_unit)
        if self.open:
            shares = ", ".join(f"{name} {share:.2f}" for name, share in self.open.items())
            yield f"Hypotheses, with the share of each among these: {shares}."
        for one, other in self.twins:
            yield (
                f"No run on this rig can distinguish {one} from {other}: both change every reading "
                "in the same way."
            )
        if self.why_none:
            yield self.why_none
        if not self.ranked:
            return
        if self.diagnosis.verdict.kind in ("effect", "complete"):
            yield "The answer is not open: further runs would make it more certain."
        table = []
        for s in self.ranked[:most]:
            d = s.to_dict()
            peak, angles = f"{d['torque_Nm']:g}", s.run.input_angle_deg
            table.append(
                [
                    f"{s.run.preload_N:g}",
                    peak,
                    d["direction"],
                    f"{angles[0]:g}" if len(angles) == 1 else "a turn",
                    f"{s.gain:.1f}",
                    self._separated(s, ", ".join),
                ]
            )
        yield (
            "Runs, the most useful first. gain: expected log evidence for the true hypothesis over "
            f"the others ({LIMIT:.1f} or more, {np.exp(LIMIT):.0f} : 1, decide; over each other at "
            f"most {DECIDED:g} count):"
        )
        headers = [
            *("preload_N", "torque_Nm", "torque goes", "input_angle_deg", "gain"),
            _FROM_LEADING,
        ]
        yield layout.table(headers, table)
        if self.ranked[0].gain < LIMIT:
            yield "None of these runs is expected to decide alone."
        count = self.runs_like_it()
        if count is not None and count > 1:
            yield f"About {count} such runs would decide between the two closest hypotheses."
        if self.untold:
            yield (
                "No run within reach tells the most probable hypothesis from "
                f"{listed(self.untold, 'or')}; other knowledge, such as a drawing or a "
                "calibration, can."
            )

    def _separated(self, run: Suggested, joined: Callable[[Sequence[str]], str]) -> str:
        """The hypotheses that a run tells from the most probable one, in a cell of a table."""
        gains = run.against(most_probable(self.open))
        told = [name for name, gain in gains.items() if gain > LIMIT]
        return "all others" if len(told) == len(gains) else joined(told)

    def __repr__(self) -> str:
        return self.report()

    def _repr_html_(self) -> str:
        """As a notebook shows it: a table of the best runs, and the report folded."""
        rows = [
            [
                d["preload_N"],
                d["torque_Nm"],
                d["direction"],
                rounded(s.gain),
                self._separated(s, listed),
            ]
            for s in self.ranked[:5]
            for d in [s.to_dict()]
        ]
        headers = ["preload_N", "torque_Nm", "torque goes", "gain", _FROM_LEADING]
        found = html.table(headers, rows) if rows else html.paragraph(self.why_none)
        return found + html.folded("the whole report", self.report())


def next_runs(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, Any],
    data: Readings | str | os.PathLike[str] | Mapping[str, ArrayLike],
    *,
    columns: Mapping[str, str] | None = None,
    limits: Limits | None = None,
    most: int = CANDIDATES,
    seed: int = 0,
) -> NextRuns:
    """Diagnose the readings, and rank the runs that could decide between the open explanations.

    Parameters
    ----------
    case : Case, Drive, str, PathLike or dict
        The drive, as in `compare`.
    data : Readings, str, PathLike, mapping or data frame
        The table of readings, as `read_readings` takes it.
    columns : mapping of str to str, optional
        What headers of the table mean, as in `read_readings`.
    limits : Limits, optional
        What the rig can do. Without it, a quarter more than it did in these readings.
    most : int
        The number of candidate runs.
    seed : int
        Seed of the candidates and of the diagnosis. The same seed gives the same result.

    Returns
    -------
    NextRuns
        The runs, the one with the largest expected gain of log odds first.

    Raises
    ------
    CaseError, ReadingsError, InvalidInputError
        As in `diagnose`.
    """
    return ranked(diagnose(case, data, columns=columns, seed=seed), limits, most)


def ranked(d: Diagnosis, limits: Limits | None = None, most: int = CANDIDATES) -> NextRuns:
    """Rank the runs that could decide what a diagnosis leaves open."""
    found = rank(d, limits, most)
    return NextRuns(d, found.open, found.ranked, found.why_none, found.twins, tuple(found.untold()))
