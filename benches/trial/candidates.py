"""Forms of the rig's own effects as they look in one campaign, whitened, for the oracle.

    Signer       whitened changes by an effect on one table
    candidates   every form of every effect of the rig, the true ones exactly
    conditional  d of each hidden effect with the sizes of the others refitted too

An effect with a phase has two columns, a lot of balls one for each ball, zeros of runs one for each
run; other shapes are drawn. To first order in sizes and numbers of the drive.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from reference.contact import Floats
from reference.rig import simulate
from reference.rig.bench import Bench, Turned, meshing, read_behind, slight_friction
from reference.rig.effects import LIBRARY, Hidden, Kind, draw_hidden
from reference.rig.kinds import Values
from reference.rig.mesh import Mesh, NotHeldError
from trial.evidence import Candidate
from trial.rivals import zeros_of_runs
from trial.strength import PARAMETERS, Yardstick

TAKEN = 30.0
"""Whitened norm up to which a change counts as to first order."""


@dataclass(frozen=True)
class Signer:
    """What effects add to the angle of a table."""

    yardstick: Yardstick

    @cached_property
    def _turned(self) -> Turned:
        y = self.yardstick
        return meshing(y.drive, y.rows, y.base)

    def angle(self, effects: Sequence[Hidden]) -> Floats:
        """Angle (rad) with effects besides the numbers of the drive."""
        y = self.yardstick
        every = (*y.base, *effects)
        if all(e.port in ("series", "reading") for e in effects):
            return read_behind(y.drive, y.rows, every, self._turned.angle_rad)
        return simulate(y.drive, y.rows, every, self._turned.states)

    def change(self, effect: Hidden) -> Floats:
        """What an effect adds to the angle (rad); friction to first order, which is much faster."""
        y = self.yardstick
        if effect.id == "friction_hysteresis":
            return slight_friction(y.drive, y.rows, (*y.base, effect), self._turned)
        return self.angle([effect]) - y.angle_rad

    def column(self, effect: Hidden) -> Floats | None:
        """Whitened change by an effect, of a size at which it is small; None if it cannot be."""
        kind = effect.kind
        for _ in range(6):
            try:
                column = self.yardstick.whiten(self.change(effect))
            except (NotHeldError, ArithmeticError):
                effect = effect.sized(kind.neutral + (effect.size - kind.neutral) / 10)
                continue
            norm = float(np.linalg.norm(column))
            if 0.1 < norm <= TAKEN:
                return column
            if norm == 0:
                return None
            off = (effect.size - kind.neutral) * 8.0 / norm
            off = float(np.clip(off, -abs(kind.high), abs(kind.high)))
            effect = effect.sized(kind.neutral + off)
        return None


def conditional(signer: Signer, hiddens: Sequence[Hidden]) -> tuple[list[Floats], list[float]]:
    """Whitened columns of the hidden effects, each the difference that leaving it out makes, and
    what is left of each when the sizes of the others are refitted too."""
    all_of = signer.angle(hiddens)
    columns = []
    for h in hiddens:
        less = signer.angle([e for e in hiddens if e is not h])
        columns.append(signer.yardstick.whiten(all_of - less))
    return columns, remaining(columns)


def remaining(columns: Sequence[Floats]) -> list[float]:
    """Norm of each column outside what the others span."""
    left = []
    for i, own in enumerate(columns):
        others = [c for j, c in enumerate(columns) if j != i]
        if others:
            basis = np.linalg.qr(np.column_stack(others))[0]
            own = own - basis @ (basis.T @ own)
        left.append(float(np.linalg.norm(own)))
    return left


# --- every form of every effect ---------------------------------------------------------------


def candidates(
    signer: Signer, hiddens: Sequence[Hidden], left_out: Sequence[str] = ()
) -> list[Candidate]:
    """Of every effect of the rig; those that are hidden also as they are."""
    found = []
    for name, kind in LIBRARY.items():
        if name in PARAMETERS.values() or name in left_out:
            continue
        found += [c for c in _of_kind(signer, kind) if c]
    if hiddens:
        columns, _ = conditional(signer, hiddens)
        for h, column in zip(hiddens, columns, strict=True):
            true = Candidate.of(h.id, "true", [column], one_sided=not h.kind.signed)
            found += [true] if true else []
    return found


def _of_kind(signer: Signer, kind: Kind) -> Iterator[Candidate | None]:
    rng = np.random.default_rng(11)
    if kind.id == "run_offset":
        yield Candidate.of(kind.id, "zeros", zeros_of_runs(signer.yardstick))
        return
    if kind.id == "ball_diameter_lot":
        yield Candidate.of(kind.id, "balls", _balls(signer))
        return
    for form in kind.forms:
        for values in _shapes(kind, form, rng):
            start = Hidden(kind, values, form)
            phases = [0.0, np.pi / 2] if "phase_rad" in values else [None]
            tried = [
                start if p is None else replace(start, values={**values, "phase_rad": p})
                for p in phases
            ]
            columns = [c for t in tried if (c := signer.column(t)) is not None]
            if columns:
                yield Candidate.of(kind.id, form, columns, one_sided=not kind.signed)


def _shapes(kind: Kind, form: str, rng: np.random.Generator) -> Iterator[Values]:
    """Shapes to try: every harmonic of the first form, else draws; one where there are none."""
    drawn = draw_hidden(kind, form, rng).values
    if "harmonic" in drawn:
        orders = range(2, 8) if form == kind.forms[0] else rng.integers(2, 8, 1)
        for order in orders:
            yield {**drawn, "harmonic": float(order)}
        return
    yield drawn
    others = set(drawn) - {kind.size, "phase_rad"}
    if others:
        yield draw_hidden(kind, form, rng).values


def _balls(signer: Signer) -> list[Floats]:
    """Whitened change by each ball of the cycloid pair, 0.2 um larger than its lot."""
    count = signer.yardstick.drive.deceleration.ball_count
    columns = []
    for ball in range(count):

        def act(b: Bench, v: Values, form: str, ball: int = ball) -> None:
            def gaps(bench: Bench, meshes: tuple[Mesh, Mesh]) -> tuple[list[Floats], list[Floats]]:
                one, two = ([np.zeros_like(m.ball_angle_rad) for _ in range(3)] for m in meshes)
                one[1] += v["size_m"] * (np.arange(count) == ball)
                return one, two

            b.gaps.append(gaps)

        kind = Kind("ball", "gap", "size_m", "m", 0.0, 3e-6, act)
        column = signer.column(Hidden(kind, {"size_m": 0.2e-6}))
        if column is not None:
            columns.append(column)
    return columns
