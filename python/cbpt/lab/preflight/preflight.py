"""A look at a table before any model does: what it holds, and what nobody could tell from it.

preflight   a table, and a case where there is one -> Preflight
Preflight   checks with the remedy for each, and effects that the table cannot show
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

from numpy.typing import ArrayLike

from cbpt._core import Case, Drive
from cbpt.errors import Say, said
from cbpt.lab.preflight.checks import checks
from cbpt.lab.preflight.coverage import blind_to
from cbpt.lab.preflight.record import Blind, Check
from cbpt.lab.readings.inputs import case_of, filled_in
from cbpt.lab.readings.reader import Readings, read_readings
from cbpt.lab.wording.html import Reported
from cbpt.lab.wording.numbers import angle_unit_of
from cbpt.lab.wording.versions import versions

__all__ = ["Preflight", "preflight"]

SCHEMA = "cbpt.preflight/1"
_MARKS = {"good": "ok  ", "look": "LOOK", "lost": "LOST"}


@dataclass(frozen=True, eq=False, repr=False)
class Preflight(Reported):
    """What a table holds, before any model."""

    source: Readings = field(repr=False)
    checks: tuple[Check, ...]
    """One for each subject, in the order of `checks`."""
    cannot_tell: tuple[Blind, ...]
    """Effects that these readings cannot show, and what the rig would have to do."""

    @property
    def good(self) -> bool:
        """Whether no check asks for another look."""
        return all(check.state == "good" for check in self.checks)

    def to_dict(self) -> dict[str, Any]:
        """As plain values, the same that `to_json` writes."""
        return {
            "schema": SCHEMA,
            "versions": versions(),
            "source": self.source.source,
            "data_sha256": self.source.sha256,
            "readings": len(self.source),
            "runs": int(self.source.run_index.max()) + 1 if len(self.source) else 0,
            "checks": [asdict(check) for check in self.checks],
            "cannot_tell": [asdict(blind) for blind in self.cannot_tell],
            "notes": list(map(str, self.source.notes)),
        }

    def to_json(self) -> str:
        """One JSON document."""
        return json.dumps(self.to_dict(), indent=2, allow_nan=False)

    def report(self, say: Say = str, angle_unit: str = "arcsec") -> str:
        """As text, angles in `angle_unit`; `say` says the steps of notes, else they are Python."""
        angle = angle_unit_of(angle_unit)
        return "\n".join(map(angle.retold, self._lines(say)))

    def _lines(self, say: Say) -> Iterator[str]:
        yield repr(self.source)
        for check in self.checks:
            yield f"{_MARKS[check.state]}  {check.subject}: {check.finding}"
            if check.remedy:
                yield f"      -> {check.remedy}"
        if self.cannot_tell:
            yield ""
            yield "These readings cannot show:"
        for blind in self.cannot_tell:
            yield f"- {', '.join(blind.effects)}: {blind.why}. {blind.remedy}"
        if self.source.notes:
            yield ""
        yield from (f"Note: {said(note, say)}" for note in self.source.notes)

    def __repr__(self) -> str:
        return self.report()


def preflight(
    case: Case | Drive | str | os.PathLike[str] | Mapping[str, Any] | None,
    data: Readings | str | os.PathLike[str] | Mapping[str, ArrayLike],
    *,
    columns: Mapping[str, str] | None = None,
    sheet: str | None = None,
    only: Mapping[str, Any] | None = None,
) -> Preflight:
    """Look at a table of readings before any model does.

    Parameters
    ----------
    case : Case, Drive, str, PathLike, dict or None
        The drive, as in `compare`. Its lever arm, load, rated torque and kind are used, and its
        stiffness to question units. None where there is no case yet.
    data : Readings, str, PathLike, mapping or data frame
        The table of readings, as `read_readings` takes it.
    columns : mapping of str to str, optional
        What headers of the table mean, as in `read_readings`.
    sheet : str, optional
        Sheet of a workbook, struct of a MATLAB file or group of a TDMS file.
    only : mapping, optional
        The readings to take, for example ``{"preload_step": 3}``.

    Returns
    -------
    Preflight
        Checks with remedies, and the effects that the table cannot show.

    Raises
    ------
    CaseError, ReadingsError
        The case or the table cannot be read.
    """
    if case is not None:
        case = case_of(case)
    if isinstance(data, Readings):
        readings = data
    else:
        lever_arm_mm, fill = (None, {}) if case is None else filled_in(case)
        readings = read_readings(
            data,
            lever_arm_mm=lever_arm_mm,
            columns=columns,
            sheet=sheet,
            need_preload=False,  # that there is none is a finding, not an error
            fill=fill,
            only=only,
        )
    return Preflight(readings, tuple(checks(readings, case)), tuple(blind_to(readings, case)))
