"""Tables of readings for the tests of their reader."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cbpt.errors import ReadingsError
from cbpt.lab.readings.reader import Readings, read_readings

DATA = Path(__file__).parents[1] / "data"
CAMPAIGNS = sorted((DATA / "hidden_effect").glob("dev*.csv"))

Write = Callable[..., Path]


def refused(source: Any, **options: Any) -> ReadingsError:
    with pytest.raises(ReadingsError) as caught:
        read_readings(source, **options)
    return caught.value


def same(a: Readings, b: Readings, rtol: float = 1e-14) -> None:
    for name in ("torque_Nm", "preload_N", "input_angle_deg", "elastic_angle_arcsec", "run"):
        x, y = getattr(a, name), getattr(b, name)
        np.testing.assert_allclose(x, y, rtol=rtol, atol=0, err_msg=name)
    for name in ("u_elastic_angle_arcsec", "time_s", "temperature_degC", "cycle"):
        x, y = getattr(a, name), getattr(b, name)
        assert (x is None) == (y is None), name
        if x is not None:
            np.testing.assert_allclose(x, y, rtol=rtol, atol=0, err_msg=name)


HEAD = "run,time_s,torque_Nm,preload_N,elastic_angle_arcsec,u_elastic_angle_arcsec\n"
GOOD = "1,0,1,600,3,0.3\n1,1,2,600,6,0.3\n"

PLAIN = """\
run,torque_Nm,preload_N,elastic_angle_arcsec
1,0.5,600,3
1,1.25,600,7.5
2,-2,450.5,-12
"""

TABLE: dict[str, Any] = {
    "run": [1, 1, 2],
    "torque_Nm": [0.5, 1.25, -2],
    "preload / kN": np.array([0.6, 0.6, 0.4505]),
    "elastic_angle_arcsec": (3, 7.5, -12),
}
