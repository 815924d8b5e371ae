"""Whether an angle follows what a torque is said to do.

at_torques   a campaign with other torques
stays        whether the angle does not follow
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.model.dataset import Campaign

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class _Limits:
    """What counts as not followed."""

    follows: float = 0.5
    sigmas: float = 3.0
    """The angle does not follow where it shows no more than this share of what the model computes,
    and less than all of it by so many standard deviations."""


_LIMITS = _Limits()


def at_torques(campaign: Campaign, torque_Nm: Floats) -> Campaign:
    """The campaign with these torques, shape (n,), in place of those that were read."""
    given = campaign.readings
    read_Nm = given.torque_Nm if given.torque_read_Nm is None else given.torque_read_Nm
    readings = replace(given, torque_Nm=torque_Nm, torque_read_Nm=read_Nm)
    return replace(campaign, readings=readings)


def stays(computed: Floats, shown: Floats, dof: float) -> bool:
    """Whether the angle does not follow.

    computed: what the scatter of the torques would do to angles, arcsec, shape (n,).
    shown: what the angles do. dof: how many of these are independent.
    """
    size = float(computed @ computed)
    if not size > 0:
        return False
    gain = float(computed @ shown) / size
    rest = shown - gain * computed
    u_gain = float(np.sqrt(rest @ rest / dof / size))
    return gain <= _LIMITS.follows and gain + _LIMITS.sigmas * u_gain <= 1.0
