"""The sentence of the answer in parts, as the page shows it."""

from __future__ import annotations

from cbpt.lab.diagnosis.diagnosis_data import DiagnosisData
from cbpt.lab.diagnosis.sentence import Say, sentence
from cbpt.lab.wording.numbers import AngleUnit
from cbpt.page.document.types import SentencePart
from cbpt.page.document.units import ANGLE_SIZES, name_and_unit

__all__ = ["sentences"]

# No name and no number holds it.
_MARK = "\0"


def sentences(d: DiagnosisData) -> dict[str, list[SentencePart]]:
    """The sentence by unit of angle."""
    return {unit: _parts(d, AngleUnit(unit)) for unit in ANGLE_SIZES}


def _parts(d: DiagnosisData, angle: AngleUnit) -> list[SentencePart]:
    """Words and numbers that were found, in turn; the numbers with names and units in print."""
    text = sentence(d, Say(_in_print, f"{_MARK}({{}}){_MARK}".format, angle))
    return [
        {"text": part, "aside": bool(k % 2)} for k, part in enumerate(text.split(_MARK)) if part
    ]


def _in_print(key: str, value: str) -> str:
    name, unit = name_and_unit(key)
    signs = value.replace("+-", "±").replace("-", "−")
    return f"{name} {signs} {unit}".rstrip()
