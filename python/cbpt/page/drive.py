"""The drive's part of the document: its drawing, findings, thresholds, and the angle over torque.

drive_section   kind, load, findings, thresholds, drawing, angle_curve, sliders
"""

from __future__ import annotations

from typing import Any

from cbpt._core import Case, Drive
from cbpt.lab.readings import Readings


def drive_section(case: Case | Drive, readings: Readings) -> dict[str, Any]:
    """Of a case, at the load that its readings reach."""
    drive = case if isinstance(case, Drive) else case.drive
    return {"kind": drive.kind, "drawing": None, "why_no_drawing": "to come"}
