"""Which effects `change` fits at all levels where nobody names them."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from cbpt.lab.change.demanded import demanded

LIBRARY = ["backlash", "creep", "friction_hysteresis", "output_torsion", "stiffness_curve"]


def answer(names: list[str], perhaps: dict[str, float] | None = None, unnamed: bool = True) -> Any:
    """A diagnosis that is drawn with some effects; unnamed: beside a rest without a name, which
    leaves none of them certain."""
    combination = SimpleNamespace(effects=tuple(names), probability=1.0, unnamed=unnamed)
    return SimpleNamespace(
        competition=SimpleNamespace(
            fitter=SimpleNamespace(variants=[SimpleNamespace(effect=e) for e in LIBRARY])
        ),
        verdict=SimpleNamespace(
            names=tuple(names),
            effects=(),
            rivals=(),
            perhaps=tuple((perhaps or {}).items()),
            lack_of_fit=object() if unnamed else None,
        ),
        combinations=lambda: [combination],
    )


def test_beside_a_rest_what_all_levels_have_in_common_is_fitted_too() -> None:
    """Alone `perhaps` counts there, and friction alone cannot say that a play fell."""
    before = answer(["backlash", "friction_hysteresis", "creep"], {"friction_hysteresis": 0.14})
    after = answer(["backlash", "friction_hysteresis", "output_torsion"])
    found = demanded([before, after])
    assert ["backlash", "friction_hysteresis"] in found
    assert [] in found and ["friction_hysteresis"] in found


def test_what_levels_demand_for_certain_is_fitted_together() -> None:
    before = answer(["backlash", "friction_hysteresis"], unnamed=False)
    after = answer(["friction_hysteresis", "stiffness_curve"], unnamed=False)
    found = demanded([before, after])
    assert found == [["backlash", "friction_hysteresis", "stiffness_curve"]]
