"""The readings with a model beside them as CSV, safe to open in a spreadsheet."""

from __future__ import annotations

import csv
import io
from collections.abc import Mapping
from typing import Any

from cbpt.page.document.types import Model, PageDocument

_COLUMNS = (
    "run",
    "time_s",
    "torque_Nm",
    "preload_N",
    "preload_step",
    "input_angle_deg",
    "temperature_degC",
    "cycle",
    "branch",
    "measured_arcsec",
    "u_arcsec",
)


def csv_of(document: PageDocument, entry: Model) -> str:
    """A row a reading: what was read, the model, the residual."""
    readings: Mapping[str, Any] = document["readings"]
    columns: dict[str, Any] = {document["data"]["place"]: readings["row"]}
    columns |= {name: readings[name] for name in _COLUMNS if readings[name] is not None}
    zero = readings["zero_arcsec"]
    if any(zero):
        # As they were read, with what was taken off beside them.
        measured = zip(readings["measured_arcsec"], zero, strict=True)
        columns["measured_arcsec"] = [value + off for value, off in measured]
        columns["zero_of_run_arcsec"] = zero
    columns["model_arcsec"] = entry["model_arcsec"]
    columns["residual_arcsec"] = entry["residual_arcsec"]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows([cell(v) for v in row] for row in zip(*columns.values(), strict=True))
    return text.getvalue()


def cell(value: Any) -> Any:
    """What a spreadsheet takes for a value, never for a formula."""
    if isinstance(value, str) and value[:1] in ("=", "+", "-", "@", "\t", "\r"):
        return f"'{value}"
    return value
