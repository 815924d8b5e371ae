"""Angles of notes in the unit that is asked for."""

from __future__ import annotations

import pytest

from cbpt.lab.wording.numbers import angle_unit_of


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (
            "a common offset of 84 arcsec was subtracted",
            "a common offset of 1.4 arcmin was subtracted",
        ),
        ("up to 1.5e+03 arcsec, -0.6 arcsec", "up to 25 arcmin, -0.01 arcmin"),
        ("state reproducibility_arcsec", "state reproducibility_arcsec"),
        ("the column alpha_2 arcsec", "the column alpha_2 arcsec"),
        ("in steps of 3 arcsecs", "in steps of 3 arcsecs"),
        ("u 0.3..0.6 arcsec, -6 to 12 arcsec", "u 0.005..0.01 arcmin, -0.1 to 0.2 arcmin"),
        ("'at 5 arcsec.csv' and 3 arcsec^2", "'at 5 arcsec.csv' and 3 arcsec^2"),
    ],
)
def test_angles_are_retold(text: str, expected: str) -> None:
    assert angle_unit_of("arcmin").retold(text) == expected
    assert angle_unit_of("arcsec").retold(text) == text
