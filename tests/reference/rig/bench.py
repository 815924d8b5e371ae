"""The bench on which effects act, and what an instrument without noise would read of it.

Rows        a table of readings without its angle
drive_of    the drive that a case describes
Bench       one simulation as the effects see it
held_Nm     what the preload holds
simulate    the angle of every row, friction included
meshing     the meshing points alone; read_behind, slight_friction: what can be told from them
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, Protocol

import numpy as np

from reference.contact import Floats, Material
from reference.forward import CrossSlide, Deceleration, Drive, RingGroove
from reference.rig.mesh import (
    HERTZ,
    NO_SPRING,
    Ints,
    Law,
    Mesh,
    NotHeldError,
    Spring,
    State,
    deceleration_mesh,
    equilibrium,
    ring_mesh,
    root_of,
    slide_mesh,
)

ARCSEC = np.pi / 648000
CaseDict = Mapping[str, Mapping[str, Any]]


# --- a table and a drive ----------------------------------------------------------------------


@dataclass(frozen=True)
class Rows:
    """Readings in the order of time within each run, all but the angle."""

    run: Ints
    time_s: Floats
    torque_Nm: Floats
    preload_N: Floats
    input_angle_rad: Floats
    temperature_degC: Floats
    cycle: Ints

    def __len__(self) -> int:
        return len(self.run)

    @property
    def starts(self) -> Ints:
        """For each reading the index of the first reading of its run."""
        _, first, back = np.unique(self.run, return_index=True, return_inverse=True)
        return np.asarray(first[back], dtype=np.int64)

    @property
    def run_time_s(self) -> Floats:
        """Time since the run's first reading."""
        return self.time_s - self.time_s[self.starts]

    def take(self, rows: Ints) -> Rows:
        """Some of the readings."""
        return Rows(**{name: value[rows] for name, value in vars(self).items()})


def drive_of(case: CaseDict) -> Drive:
    """The drive that a case describes."""
    steel = case.get("material", {})
    modulus, poisson = (
        steel.get("youngs_modulus_GPa", 208.0) * 1e9,
        steel.get("poissons_ratio", 0.3),
    )
    material = Material(modulus, poisson, modulus, poisson)
    c, s = case["deceleration"], case["equal_speed"]
    deceleration = Deceleration(
        c["ball_count"],
        c["short_amplitude_coefficient"],
        c["rolling_circle_radius_mm"] * 1e-3,
        c["ball_radius_mm"] * 1e-3,
        c["groove_conformity"],
        np.deg2rad(c["contact_angle_deg"]),
        output=c.get("output", "hypocycloid"),
        material=material,
    )
    e = deceleration.short_amplitude * deceleration.rolling_radius_m
    count, pitch, radius = s["ball_count"], s["pitch_radius_mm"] * 1e-3, s["ball_radius_mm"] * 1e-3
    beta, conformity = np.deg2rad(s["contact_angle_deg"]), s["groove_conformity"]
    if s["kind"] == "cross_slide":
        slide = CrossSlide(count, pitch, radius, conformity, beta, material)
        return Drive(deceleration, slide)
    ring = RingGroove(count, pitch, e, radius, conformity, beta, beta, material=material)
    return Drive(deceleration, ring)


# --- friction ---------------------------------------------------------------------------------


class Friction(Protocol):
    """A friction torque that remembers; arrays have one entry for each run."""

    def begin(self, limit_Nm: Floats) -> Any:
        """Memory at a run's start, where no friction acts; limit_Nm is its largest torque."""

    def torque(self, memory: Any, way_rad: Floats, rate_rad_per_s: Floats) -> tuple[Floats, Floats]:
        """Friction torque (N m) after turning by way_rad, and its slope (N m/rad)."""

    def step(self, memory: Any, way_rad: Floats, rate_rad_per_s: Floats) -> Any:
        """Memory after that."""


# --- the bench --------------------------------------------------------------------------------


@dataclass
class Bench:
    """One simulation as the effects see it; each changes what it acts on before it is solved.

    rows: as the table has it. torque_Nm, preload_N: what is really applied. preload_share: of it
    what reaches the meshing points. meshes: the two pairs, their gaps per ball in `gaps` (axial,
    normal, in the plane). Later effects read angles off `series` and `reading`.
    """

    rows: Rows
    drive: Drive
    torque_Nm: Floats
    preload_N: Floats
    stiffness_scale: float = 1.0
    contact_angle_rad: float = 0.0
    law: Law = HERTZ
    spring: Spring = NO_SPRING
    friction: tuple[Friction, Floats] | None = None
    friction_feels_series: bool = True
    gaps: list[Callable[[Bench, tuple[Mesh, Mesh]], tuple[list[Floats], list[Floats]]]] = field(
        default_factory=list
    )
    series: Floats = field(default_factory=lambda: np.zeros(0))
    reading: list[Callable[[Floats], Floats]] = field(default_factory=list)

    @property
    def arm_m(self) -> float:
        """Zo e, from the output plate's centre to the pitch point."""
        return self.drive.deceleration.pitch_arm_m

    def meshes(self) -> tuple[Mesh, Mesh]:
        """Both pairs of every reading, built once for each input angle."""
        shift, drive = self.contact_angle_rad, self.drive
        first = replace(
            drive.deceleration, contact_angle_rad=drive.deceleration.contact_angle_rad + shift
        )
        angles, back = np.unique(self.rows.input_angle_rad, return_inverse=True)
        phi, psi = np.array([drive.phases_rad(float(a)) for a in angles]).T
        one = deceleration_mesh(first, phi)
        pair = drive.equal_speed
        if isinstance(pair, CrossSlide):
            beta = pair.contact_angle_rad + shift
            two = slide_mesh(replace(pair, contact_angle_rad=beta), psi)
        else:
            outside = pair.contact_angle_outside_rad + shift
            inside = pair.contact_angle_inside_rad + shift
            turned = replace(
                pair, contact_angle_outside_rad=outside, contact_angle_inside_rad=inside
            )
            two = ring_mesh(turned, psi)
        out = []
        for mesh in (one, two):
            mesh = mesh.take(back.astype(np.int64))
            stiffness = mesh.stiffness * self.stiffness_scale
            out.append(replace(mesh, stiffness=stiffness, law=self.law, spring=self.spring))
        return self._with_gaps(out[0], out[1])

    def _with_gaps(self, one: Mesh, two: Mesh) -> tuple[Mesh, Mesh]:
        """Gaps of all effects added up, ball by ball."""
        if not self.gaps:
            return one, two
        total = [[np.zeros_like(m.ball_angle_rad) for _ in range(3)] for m in (one, two)]
        for gap in self.gaps:
            for sums, parts in zip(total, gap(self, (one, two)), strict=True):
                for one_sum, part in zip(sums, parts, strict=True):
                    one_sum += part
        return one.with_gaps(*total[0]), two.with_gaps(*total[1])


class Effect(Protocol):
    """Something that the nominal model does not know."""

    @property
    def id(self) -> str:
        """Its name."""

    @property
    def port(self) -> str:
        """Where it acts."""

    def act(self, bench: Bench) -> None:
        """Change the bench."""


PORTS = ("instrument", "load", "gap", "contact", "series", "reading")


# --- the drive under load ---------------------------------------------------------------------


@dataclass
class _Pairs:
    """Both pairs ready to be loaded, with what the drive makes of the slide's angle."""

    meshes: tuple[Mesh, Mesh]
    share: float
    preload_N: Floats
    zeros_m: list[Floats | None]

    def take(self, rows: Ints) -> _Pairs:
        zeros = [None if z is None else z[rows] for z in self.zeros_m]
        one, two = self.meshes
        return _Pairs((one.take(rows), two.take(rows)), self.share, self.preload_N[rows], zeros)

    def torque_held_Nm(self) -> tuple[Floats, Floats]:
        """Largest torque on the output (N m) that both pairs can balance, up and down."""
        (up1, down1), (up2, down2) = (m.capacity_m for m in self.meshes)
        factor = self.share if self.meshes[1].floats else 1.0
        up, down = np.minimum(up1, up2 / factor), np.minimum(down1, down2 / factor)
        return up * self.preload_N, down * self.preload_N

    def turn(
        self, torque_Nm: Floats, start: list[State] | None
    ) -> tuple[Floats, Floats, list[State]]:
        """Rotation at the output (rad), its slope (rad/(N m)) and the states to start from."""
        states = []
        for i, mesh in enumerate(self.meshes):
            load = torque_Nm * (self.share if i else 1.0)
            before = None if start is None else start[i]
            states.append(equilibrium(mesh, load, self.preload_N, self.zeros_m[i], before))
        factor = 2 * self.share if self.meshes[1].floats else 1.0
        one, two = states
        angle = one.rotation_rad + factor * two.rotation_rad
        slope = one.compliance_rad_per_Nm + factor * self.share * two.compliance_rad_per_Nm
        return angle, slope, states


def _pairs(bench: Bench) -> _Pairs:
    """Meshes, and with a spring the approach of each pair at no torque."""
    meshes = bench.meshes()
    zeros: list[Floats | None] = [None, None]
    if bench.spring.rate_N_per_m > 0:
        none = np.zeros(len(bench.rows))
        zeros = [equilibrium(m, none, bench.preload_N).approach_m for m in meshes]
    return _Pairs(meshes, bench.drive.transfer, bench.preload_N, zeros)


def prepare(drive: Drive, rows: Rows, effects: Sequence[Effect]) -> Bench:
    """The bench after every effect, in the order of the ports."""
    bench = Bench(rows, drive, rows.torque_Nm.copy(), rows.preload_N.copy())
    bench.series = np.zeros(len(rows))
    for effect in sorted(effects, key=lambda e: PORTS.index(e.port)):
        effect.act(bench)
    return bench


def held_Nm(drive: Drive, rows: Rows, effects: Sequence[Effect] = ()) -> tuple[Floats, Floats]:
    """Largest torque of either sign (N m) that every reading's preload can hold."""
    return _pairs(prepare(drive, rows, effects)).torque_held_Nm()


@dataclass(frozen=True)
class Turned:
    """The meshing points under the torque of every reading: angle (rad), slope (rad/(N m)), and the
    states to start another solution from."""

    angle_rad: Floats
    slope_rad_per_Nm: Floats
    states: list[State]


def meshing(drive: Drive, rows: Rows, effects: Sequence[Effect] = ()) -> Turned:
    """The meshing points alone, without friction, series and instrument."""
    bench = prepare(drive, rows, effects)
    return Turned(*_pairs(bench).turn(bench.torque_Nm, None))


def read_behind(drive: Drive, rows: Rows, effects: Sequence[Effect], meshing_rad: Floats) -> Floats:
    """Angle (rad) read where the meshing points' own is known: effects in series and of the
    instrument alone."""
    bench = prepare(drive, rows, effects)
    return _read(bench, meshing_rad + bench.series)


def slight_friction(drive: Drive, rows: Rows, effects: Sequence[Effect], turned: Turned) -> Floats:
    """What friction adds to the angle (rad) to first order in its torque: minus the slope times the
    friction torque along the angle without it."""
    bench = prepare(drive, rows, effects)
    assert bench.friction is not None
    friction, limit = bench.friction
    felt = turned.angle_rad + (bench.series if bench.friction_feels_series else 0.0)
    place = np.arange(len(rows)) - rows.starts
    held = np.zeros(len(rows))
    alive = np.flatnonzero(place == 0)
    memory = friction.begin(limit[alive])
    for number in range(1, int(place.max()) + 1):
        now = np.flatnonzero(place == number)
        memory = _some(memory, np.isin(rows.starts[alive], rows.starts[now]))
        alive, way = now, felt[now] - felt[now - 1]
        rate = way / np.maximum(rows.time_s[now] - rows.time_s[now - 1], 1e-9)
        held[now] = friction.torque(memory, way, rate)[0]
        memory = friction.step(memory, way, rate)
    return -turned.slope_rad_per_Nm * held


def _read(bench: Bench, angle_rad: Floats) -> Floats:
    for reads in bench.reading:
        angle_rad = reads(angle_rad)
    return angle_rad


def simulate(
    drive: Drive,
    rows: Rows,
    effects: Sequence[Effect] = (),
    start: list[State] | None = None,
) -> Floats:
    """Elastic angle (rad) that an instrument without noise would read, every row of the table.

    alpha = alpha1(M) + alpha2(M) with ring grooves, alpha1(M) + 2 (Z1/Z3) alpha3(M Z1/Z3) with a
    cross-slide, M = M0 - friction; then what stands in series; then the instrument. Raises
    NotHeldError where the preload cannot hold the torque. start: states near the solution.
    """
    bench = prepare(drive, rows, effects)
    if not bool((bench.preload_N > 0).all()):
        raise NotHeldError("no preload left")
    pairs = _pairs(bench)
    up, down = pairs.torque_held_Nm()
    if bench.spring.rate_N_per_m == 0:
        over = (bench.torque_Nm >= 0.999 * up) | (-bench.torque_Nm >= 0.999 * down)
        if bool(over.any()):
            raise NotHeldError(f"{int(over.sum())} readings above what the preload holds")
    if bench.friction is None:
        angle = pairs.turn(bench.torque_Nm, start)[0] + bench.series
    else:
        angle = _with_friction(bench, pairs, *bench.friction)
    return _read(bench, angle)


def _with_friction(bench: Bench, pairs: _Pairs, friction: Friction, limit_Nm: Floats) -> Floats:
    """All runs side by side, each reading from the one before it.

    The meshing points carry m = M0 - T(alpha), alpha their own angle under m plus (if friction
    feels it) what stands in series. A run begins at its first reading without friction.
    """
    rows, starts = bench.rows, bench.rows.starts
    felt = bench.series if bench.friction_feels_series else np.zeros(len(rows))
    place = np.arange(len(rows)) - starts
    up, down = pairs.torque_held_Nm()
    margin = np.inf if bench.spring.rate_N_per_m > 0 else 0.9999
    alive = np.flatnonzero(place == 0)
    mesh_torque = bench.torque_Nm[alive]
    first, _, states = pairs.take(alive).turn(mesh_torque, None)
    angle = np.zeros(len(rows))
    angle[alive] = first + felt[alive]
    memory = friction.begin(limit_Nm[alive])
    for number in range(1, int(place.max()) + 1):
        now = np.flatnonzero(place == number)
        kept = np.isin(starts[alive], starts[now])
        alive, memory, states = now, _some(memory, kept), [_some(s, kept) for s in states]
        spread = 1.3 * limit_Nm[alive] + 1e-12
        step = _Step(
            pairs.take(alive),
            friction,
            memory,
            states,
            torque_Nm=bench.torque_Nm[alive],
            series_rad=felt[alive],
            before_rad=angle[alive - 1],
            gap_s=np.maximum(rows.time_s[alive] - rows.time_s[alive - 1], 1e-9),
        )
        low = np.maximum(step.torque_Nm - spread, -margin * down[alive])
        high = np.minimum(step.torque_Nm + spread, margin * up[alive])
        guess = mesh_torque[kept] + step.torque_Nm - bench.torque_Nm[alive - 1]
        unit = np.abs(step.torque_Nm) + spread
        mesh_torque = root_of(step.balance, np.clip(guess, low, high), low, high, unit)
        step.balance(mesh_torque)
        angle[alive], states = step.turned_rad, step.states
        memory = friction.step(memory, step.way_rad, step.way_rad / step.gap_s)
    return angle - felt + bench.series


@dataclass
class _Step:
    """From one reading of every run to the next, under friction."""

    pairs: _Pairs
    friction: Friction
    memory: Any
    states: list[State]
    torque_Nm: Floats
    series_rad: Floats
    before_rad: Floats
    gap_s: Floats
    turned_rad: Floats = field(default_factory=lambda: np.zeros(0))

    @property
    def way_rad(self) -> Floats:
        """How far the output has turned since the reading before."""
        return self.turned_rad - self.before_rad

    def balance(self, m: Floats) -> tuple[Floats, Floats]:
        """m - M0 + T(alpha(m)), which grows with m, and its slope."""
        mesh_rad, slope, self.states = self.pairs.turn(m, self.states)
        self.turned_rad = mesh_rad + self.series_rad
        way = self.way_rad
        held, stiff = self.friction.torque(self.memory, way, way / self.gap_s)
        return m - self.torque_Nm + held, 1 + stiff * slope


def _some(value: Any, kept: Any) -> Any:
    """Some entries of an array, or of every array of a memory or a state."""
    if isinstance(value, State):
        return State(**{name: part[kept] for name, part in vars(value).items()})
    if isinstance(value, tuple):
        return tuple(_some(part, kept) for part in value)
    return value[kept]
