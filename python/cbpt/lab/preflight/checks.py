"""The checks of a table, each a subject with what was found and the remedy on the rig.

checks   all of them
"""

from __future__ import annotations

from collections.abc import Iterator

from cbpt._core import Case, Drive
from cbpt.lab.characteristics.loops import loops_of
from cbpt.lab.preflight.closing import closed_check
from cbpt.lab.preflight.coverage import coverage_checks
from cbpt.lab.preflight.display import display_check
from cbpt.lab.preflight.legs import legs_of
from cbpt.lab.preflight.loops import steps_check, torque_noise_check
from cbpt.lab.preflight.odd_readings import odd_check
from cbpt.lab.preflight.rates import rates_check
from cbpt.lab.preflight.record import Check
from cbpt.lab.preflight.repeats import repeats_check
from cbpt.lab.preflight.saturation import saturation_check
from cbpt.lab.preflight.units import unit_checks
from cbpt.lab.preflight.zeros import zeros_check
from cbpt.lab.readings.reader import Readings


def checks(readings: Readings, case: Case | Drive | None) -> Iterator[Check]:
    """Every subject once, in the order in which a rig would be set right. What is odd by itself is
    told first and left out of the others, of which it would make something else."""
    single, odd = odd_check(readings)
    yield single
    if odd.any() and not odd.all():
        readings = readings.select(~odd)
    loops, legs = loops_of(readings), legs_of(readings)
    yield from unit_checks(readings, case)
    yield from coverage_checks(readings, case)
    yield saturation_check(readings)
    yield repeats_check(readings, loops, legs)
    yield from display_check(readings, loops, legs)
    yield from steps_check(loops, case)
    yield torque_noise_check(readings, loops)
    yield rates_check(readings, legs)
    yield closed_check(readings, loops)
    yield zeros_check(readings, loops, case)
