"""The table of units that the core hands on."""

import math
import pickle

import pytest

from cbpt._core import effect_specs, units
from cbpt.results import ANGLE_UNITS, ARCSEC_PER_RAD
from cbpt.units import UNITS, unit_at_end


def test_a_conversion_is_a_ratio_of_whole_numbers() -> None:
    assert UNITS["deg"].conversion(UNITS["arcsec"]) == (3600, 1, 0)
    assert UNITS["Nmm"].conversion(UNITS["kNm"]) == (1, 1e6, 0)
    assert UNITS["degC"].conversion(UNITS["K"]) == (1, 1, 273.15)
    with pytest.raises(ValueError, match="Nm measures torque, N measures force"):
        UNITS["Nm"].conversion(UNITS["N"])


def test_units_are_values() -> None:
    assert len(UNITS) == len(units())
    for symbol, unit in UNITS.items():
        assert pickle.loads(pickle.dumps(unit)) == unit == type(unit)(symbol)
        assert hash(unit) == hash(type(unit)(symbol))
        assert unit.size > 0
    with pytest.raises(ValueError, match="furlong"):
        type(UNITS["m"])("furlong")


def test_a_name_ends_in_its_unit() -> None:
    for name, written in (
        ("torque_Nm", "N m"),
        ("stiffness_Nm_per_arcmin", "N m/arcmin"),
        ("quadratic_per_rad", "1/rad"),
        ("rate_arcsec_per_h", "arcsec/h"),
        ("torque_lbf_in", "lbf in"),
    ):
        unit = unit_at_end(name)
        assert unit is not None and unit.written == written
    for name in ("share", "ball_count", "rate_deg_per_week", "pressure_drop_per_h_m2", "N"):
        assert unit_at_end(name) is None, name


def test_parameters_of_effects_end_in_units_of_the_table() -> None:
    for spec in effect_specs():
        for parameter in spec.parameters:
            shown = unit_at_end(parameter.display_name)
            inside = unit_at_end(parameter.name)
            assert (shown is None) == (inside is None), parameter.name
            if shown and inside:
                assert shown.quantity == inside.quantity
                assert shown.size == parameter.display_size
                assert inside.size == 1


def test_angles_are_said_in_every_unit_of_the_table() -> None:
    assert list(ANGLE_UNITS) == ["arcsec", "arcmin", "deg", "urad", "mrad", "rad"]
    assert 648000 / math.pi == ARCSEC_PER_RAD
    for symbol, one in ANGLE_UNITS.items():
        assert one * UNITS[symbol].size == pytest.approx(math.pi / 648000, rel=1e-15)
