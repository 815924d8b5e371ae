"""Readings against the model as data: residuals row by row, the misfit and where it stands out."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from cbpt._core import Case, Drive
from cbpt.lab.covariance.repeatability import Repeats
from cbpt.lab.covariance.within_run import Scatter
from cbpt.lab.diagnosis.misfit import Group, Misfit
from cbpt.lab.readings.reader import Readings
from cbpt.results import Angles

if TYPE_CHECKING:
    from cbpt.lab.selection.fit_effects import Number, Prediction
    from cbpt.lab.selection.scan import Region

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class ComparisonData:
    """Readings against the model, row by row and in groups. Arrays have shape (n,)."""

    readings: Readings
    model: Angles | Prediction
    """The model at every row; NaN and a status where it has no solution."""
    residual_arcsec: Floats
    """Reading minus offset minus model; NaN where the model has no solution."""
    zero: str
    """`common` or `per_run`."""
    zero_arcsec: dict[str, float]
    """The offset taken off each run, empty for `common`."""
    best_common_zero_arcsec: float
    """The one offset for all rows that would leave the smallest misfit."""
    rmse_with_best_zero_arcsec: float
    """The RMSE it would leave."""
    p_value: float | None
    """Chance of a chi-squared this large if the model were complete and the stated uncertainty
    right; None without a stated uncertainty."""
    overall: Misfit | None
    """All rows with a solution; None where there is none."""
    groups: tuple[Group, ...]
    """By preload, torque, direction, input angle and run, as far as they vary."""
    findings: tuple[str, ...]
    """What is to be known about the design of the drive itself."""
    scatter: Scatter | None
    """What the readings themselves say of their scatter; None where too few follow each other."""
    p_value_of_scatter: float | None
    """Chance of a misfit this large if the model were complete, judged by that scatter."""
    repeats: Repeats | None
    """What readings taken again say of the uncertainty; None where too few were."""
    p_value_of_repeats: float | None
    """The same chance, judged by the repeats; None where they are not steady."""
    where: tuple[Region, ...]
    """Where the misfit stands out, the most telling first."""
    hints: tuple[str, ...]
    """Slips that the misfit looks like: a wrong unit, a wrong sign."""
    numbers: tuple[Number, ...]
    """Parameters of the effects that the model has beside the drive."""
    before: ComparisonData | None
    """The same without the effects that were to be fitted; None where none were."""
    case: Case | Drive | None = field(default=None, kw_only=True, repr=False)
    """The drive that was compared."""

    @property
    def u_from(self) -> str | None:
        """What the uncertainty of a reading is known from: `stated`, else `repeats`, else
        `scatter` inside the runs; None where nothing tells it."""
        if self.readings.u_elastic_angle_arcsec is not None:
            return "stated"
        if self.repeats is not None and self.repeats.steady:
            return "repeats"
        return None if self.scatter is None else "scatter"

    @property
    def without_solution(self) -> dict[str, list[int]]:
        """Lines of the table (of data: rows) at which the model has no solution, by status."""
        lines = self.readings.line
        failed = ~self.model.has_solution
        names = np.unique(self.model.status[failed])
        return {str(n): lines[failed & (self.model.status == n)].tolist() for n in names}

    def worst(self) -> Group | None:
        """The group with the largest part of the misfit for its number of rows."""
        apart = [g for g in self.groups if g.column != "run" and g.misfit.readings < self._solved]
        return max(apart, key=lambda g: g.misfit.rmse_arcsec, default=None)

    @property
    def _solved(self) -> int:
        return self.overall.readings if self.overall else 0
