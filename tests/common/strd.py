"""The nonlinear regression problems of NIST's Statistical Reference Datasets (`data/strd`).

Problem   data, model with exact slopes, two starts, certified parameters
problems  all 27
digits    certified digits that a result has (LRE)

Slopes are complex steps (Squire and Trapp 1998): exact to rounding, without a formula for each.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cbpt.lab.inference.least_squares import Aim

Floats = NDArray[np.float64]
FOLDER = Path(__file__).parents[1] / "data" / "strd"
CERTIFIED = 11
"""Digits that the certified values have."""


def _gauss(x: Any, b: Any) -> Any:
    bells = (b[i] * np.exp(-((x - b[i + 1]) ** 2) / b[i + 2] ** 2) for i in (2, 5))
    return b[0] * np.exp(-b[1] * x) + sum(bells)


def _lanczos(x: Any, b: Any) -> Any:
    return sum(b[i] * np.exp(-b[i + 1] * x) for i in (0, 2, 4))


def _enso(x: Any, b: Any) -> Any:
    waves = ((12.0, 1, 2), (b[3], 4, 5), (b[6], 7, 8))
    turn = 2 * np.pi * x
    return b[0] + sum(b[i] * np.cos(turn / t) + b[k] * np.sin(turn / t) for t, i, k in waves)


def _cubics(x: Any, b: Any) -> Any:
    above = b[0] + b[1] * x + b[2] * x**2 + b[3] * x**3
    return above / (1 + b[4] * x + b[5] * x**2 + b[6] * x**3)


def _chwirut(x: Any, b: Any) -> Any:
    return np.exp(-b[0] * x) / (b[1] + b[2] * x)


def _rise(x: Any, b: Any) -> Any:
    return b[0] * (1 - np.exp(-b[1] * x))


MODELS: dict[str, Callable[[Any, Any], Any]] = {
    "Bennett5": lambda x, b: b[0] * (b[1] + x) ** (-1 / b[2]),
    "BoxBOD": _rise,
    "Chwirut1": _chwirut,
    "Chwirut2": _chwirut,
    "DanWood": lambda x, b: b[0] * x ** b[1],
    "ENSO": _enso,
    "Eckerle4": lambda x, b: b[0] / b[1] * np.exp(-0.5 * ((x - b[2]) / b[1]) ** 2),
    "Gauss1": _gauss,
    "Gauss2": _gauss,
    "Gauss3": _gauss,
    "Hahn1": _cubics,
    "Kirby2": lambda x, b: (b[0] + b[1] * x + b[2] * x**2) / (1 + b[3] * x + b[4] * x**2),
    "Lanczos1": _lanczos,
    "Lanczos2": _lanczos,
    "Lanczos3": _lanczos,
    "MGH09": lambda x, b: b[0] * (x**2 + x * b[1]) / (x**2 + x * b[2] + b[3]),
    "MGH10": lambda x, b: b[0] * np.exp(b[1] / (x + b[2])),
    "MGH17": lambda x, b: b[0] + b[1] * np.exp(-x * b[3]) + b[2] * np.exp(-x * b[4]),
    "Misra1a": _rise,
    "Misra1b": lambda x, b: b[0] * (1 - (1 + b[1] * x / 2) ** -2),
    "Misra1c": lambda x, b: b[0] * (1 - (1 + 2 * b[1] * x) ** -0.5),
    "Misra1d": lambda x, b: b[0] * b[1] * x / (1 + b[1] * x),
    "Nelson": lambda x, b: b[0] - b[1] * x[0] * np.exp(-b[2] * x[1]),
    "Rat42": lambda x, b: b[0] / (1 + np.exp(b[1] - b[2] * x)),
    "Rat43": lambda x, b: b[0] / (1 + np.exp(b[1] - b[2] * x)) ** (1 / b[3]),
    "Roszman1": lambda x, b: b[0] - b[1] * x - np.arctan(b[2] / (x - b[3])) / np.pi,
    "Thurber": _cubics,
}


@dataclass(frozen=True, eq=False)
class Problem:
    """y = model(x, b) + e."""

    name: str
    y: Floats
    x: Floats
    starts: tuple[Floats, Floats]
    certified: Floats
    u: Floats
    """Certified standard deviations."""
    level: str
    """Of difficulty, as NIST has it: Lower, Average or Higher."""

    def model(self, b: Floats) -> Floats:
        with np.errstate(all="ignore"):
            return np.asarray(MODELS[self.name](self.x, b), dtype=np.float64)

    def slopes(self, b: Floats) -> Floats:
        """Shape (n, p)."""
        step = 1e-200
        with np.errstate(all="ignore"):
            stepped = (MODELS[self.name](self.x, b + 1j * step * e) for e in np.eye(len(b)))
            return np.column_stack([s.imag / step for s in stepped])

    def residual(self, b: Floats) -> tuple[Floats, Floats]:
        """Reading less model, and the slopes of the model."""
        return self.y - self.model(b), self.slopes(b)


def problems() -> list[Problem]:
    return [_read(path) for path in sorted(FOLDER.glob("*.dat"))]


def _read(path: Path) -> Problem:
    lines = path.read_text().splitlines()
    found = [line.split() for line in lines if line.lstrip().startswith("b") and " = " in line]
    table = np.array([row[2:6] for row in found], dtype=np.float64)
    at = max(i for i, line in enumerate(lines) if line.startswith("Data:"))
    data = np.array([line.split() for line in lines[at + 1 :] if line.strip()], dtype=np.float64)
    x = data[:, 1] if data.shape[1] == 2 else data[:, 1:].T
    level = next(line.split()[0] for line in lines if "Level of Difficulty" in line)
    y = np.log(data[:, 0]) if path.stem == "Nelson" else data[:, 0]
    return Problem(path.stem, y, x, (table[:, 0], table[:, 1]), table[:, 2], table[:, 3], level)


def digits(found: Floats, certified: Floats) -> float:
    """Of the parameter that has fewest."""
    off = np.abs(found - certified) / np.abs(certified)
    if not np.isfinite(off).all():
        return 0.0
    return float(np.clip(-np.log10(np.maximum(off.max(), 1e-300)), 0, CERTIFIED))


AIM = Aim(tolerance=1e-12, steps=2000, reach=1.0)
"""How the engine is asked for all digits from a start that may be far off."""
