"""The drive in the page's document, typed: its load, solution, thresholds, sliders and drawing."""

from __future__ import annotations

from typing import Literal, NotRequired, TypedDict

Column = list[float | None]
"""Numbers; null where there is none."""


class Load(TypedDict):
    torque_Nm: float
    preload_N: float | None
    input_angle_deg: float


class DriveSolution(TypedDict):
    status: str
    message: str
    elastic_angle_arcsec: float | None
    deceleration_arcsec: float | None
    equal_speed_arcsec: float | None
    torsional_stiffness_Nm_per_arcsec: float | None
    hold_preload_N: float | None


class Finding(TypedDict):
    code: str
    severity: str
    pair: str | None
    message: str
    remedy: str


class PairThresholds(TypedDict):
    hold_N: float | None
    continuous_N: float | None
    zero_backlash_N: float | None


class DriveThresholds(TypedDict):
    """Preloads, maxima over a period; null: no preload does it."""

    torque_Nm: float
    drive: PairThresholds
    deceleration: PairThresholds
    equal_speed: PairThresholds


class AngleCurve(TypedDict):
    """At the load's preload and input angle."""

    torque_Nm: list[float]
    elastic_angle_arcsec: Column
    deceleration_arcsec: Column
    equal_speed_arcsec: Column
    status: list[str]


class Loop(TypedDict):
    """The drive with the effects of a model along one loop of the torque, there and back; the
    instruments of the rig are left out."""

    torque_Nm: list[float]
    """From the largest down to the smallest and up again."""
    elastic_angle_arcsec: Column
    u_arcsec: Column | None
    """Standard uncertainty; null where nothing was fitted."""


class Slider(TypedDict):
    key: str
    label: str
    unit: str
    value: float
    min: float
    max: float
    step: float


class Sliders(TypedDict):
    load: list[Slider]
    design: list[Slider]


class DrawnLine(TypedDict):
    plate: str
    kind: str
    x: list[float]
    y: list[float]


class DrawnCircle(TypedDict):
    plate: str
    kind: str
    x: float
    y: float
    radius: float


class DrawnBall(TypedDict):
    number: int
    x: float
    y: float
    radius: float


class PointState(TypedDict):
    """What a meshing point carries; nothing is known without a solution."""

    state: str | None
    role: str | None
    force_N: float | None
    in_plane_force_N: float | None
    deformation_um: float | None
    gap_um: float | None
    peak_pressure_GPa: float | None


class MeshingPoint(PointState):
    ball: int
    diagonal: str
    plate: str
    x: float
    y: float
    nx: float
    ny: float


class Arrow(TypedDict):
    ball: int
    diagonal: str
    x: float
    y: float
    dx: float
    dy: float
    force_N: float


class Centre(TypedDict):
    label: str
    x: float
    y: float


class Place(TypedDict):
    x: float
    y: float


class Wall(DrawnLine):
    diagonal: str
    contact: Place
    nx: float
    ny: float
    state: str | None
    force_N: float | None


class CutBall(TypedDict):
    ball: int
    ball_radius_mm: float
    walls: list[Wall]


class Plates(TypedDict):
    output: str
    other: str


class LoadedPair(TypedDict):
    """The balls of a pair and what they carry."""

    pair: str
    title: str
    extent_mm: float
    balls: list[DrawnBall]
    points: list[MeshingPoint]
    arrows: list[Arrow]
    arrow_mm_per_N: float | None
    torque_Nm: float | None
    angle_arcsec: float | None
    carrying: int | None
    peak_pressure_GPa: float | None


class DrawnPair(LoadedPair):
    plates: Plates
    lines: list[DrawnLine]
    circles: list[DrawnCircle]
    centres: list[Centre]
    section: CutBall


class Drawing(TypedDict):
    """See `drawing`."""

    unit: Literal["mm"]
    pairs: list[DrawnPair]


class DriveSection(TypedDict):
    """The drive at one load."""

    kind: str
    """ball_drive or torsion_spring."""
    load: Load
    design: dict[str, float]
    """By key of the design sliders."""
    solution: DriveSolution
    findings: list[Finding]
    thresholds: DriveThresholds | None
    angle_curve: AngleCurve
    sliders: Sliders
    drawing: Drawing | None
    why_no_drawing: str | None
    loop: NotRequired[Loop | None]
    """At a load of choice, with the effects that were asked for."""
