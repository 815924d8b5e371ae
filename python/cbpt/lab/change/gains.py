"""Gains of instruments, which look like what the model lacks.

is_gain  whether an effect is one
"""

from __future__ import annotations

from cbpt.lab.model.priors import CLASSES, PRIORS


def is_gain(effect: str) -> bool:
    """Whether it is the gain of an instrument. That is the same at all levels as far as anybody
    knows; so it is told as changed only if that moves the angles by more than the whole rest,
    beyond what other changes make up for: gains of 8 to 17 % stood in for a stiffness that fell.
    """
    return effect in PRIORS and CLASSES[effect] == "rig"
