"""Reasons and advice that the paper gives beside Figures 14 to 19."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from claim import Claim, close, verdict
from evidence import (
    PRELOAD_N,
    RINGS,
    TORQUE_NM,
    Array,
    falls,
    make_drive,
    make_prototype,
    prototype_curves,
    rises,
)

import cbpt
from cbpt.results import ARCSEC_PER_RAD

# --- what the figures are put down to -----------------------------------------------------


def _pair(drive: cbpt.Drive, torque_Nm: float, preload_N: float) -> cbpt.PairSolution:
    pair = drive.solve(torque_Nm, preload_N).deceleration
    assert pair is not None
    return pair


def _um(pair: cbpt.PairSolution) -> Array:
    return np.asarray(pair.deformation_m) * 1e6


def arm_against_rolling_circle() -> Claim:
    longest = {}
    for radius_mm in (3.0, 4.0, 6.0):
        drive = make_drive(rolling_circle_radius_mm=radius_mm)
        # The torque of the loaded diagonals in the plane over their force, at the longest arm.
        hold_N = drive.preload(1.0, 0.0).deceleration.hold_N
        longest[radius_mm] = 1e3 / hold_N
    ratio = longest[6.0] / longest[3.0]
    return Claim(
        "arm against r0",
        "16",
        "The greater r0, the greater the turning radius of the balls; therefore the angle falls.",
        verdict(close(ratio, 2.0, 1e-9)),
        "All arms are in proportion to e = K r0. The angle that gives one and the same deformation "
        "goes as 1/r0, and the force that a torque needs too.",
        {"longest arm, r0 = 3 mm, mm": longest[3.0], "r0 = 6 mm, mm": longest[6.0]},
    )


def predeformation_against_preload() -> Claim:
    drive = make_drive()
    preloads_N = (300.0, 600.0, 1200.0)
    before = [float(_um(_pair(drive, 0.0, n)).mean()) for n in preloads_N]
    loaded = [float(_um(_pair(drive, TORQUE_NM, n)).max()) for n in preloads_N]
    further = [a - b for a, b in zip(loaded, before, strict=True)]
    return Claim(
        "predeformation against the preload",
        "15",
        "The predeformation of the meshing points grows with the preload, and the further "
        "deformation that gives the same force shrinks; therefore the angle falls.",
        verdict(rises(before) and falls(further)),
        "Force goes with deformation to the power 1.5, so a contact that starts higher on it "
        "is stiffer. Mean of all meshing points without torque, and what 5 N m adds at the point "
        "that it loads most. A diagonal has two meshing points; its deformation is that of both.",
        {f"{n:g} N: without torque, μm": x for n, x in zip(preloads_N, before, strict=True)}
        | {f"{n:g} N: 5 N m adds, μm": x for n, x in zip(preloads_N, further, strict=True)},
    )


def predeformation_against_contact_angle() -> Claim:
    angles_deg = (30.0, 45.0, 60.0)
    drives = [make_drive(contact_angle_deg=beta) for beta in angles_deg]
    bare = [_pair(drive, 0.0, PRELOAD_N) for drive in drives]
    before = [float(_um(pair).mean()) for pair in bare]
    in_plane = [
        float(pair.force_N.mean() * math.cos(math.radians(beta)))
        for pair, beta in zip(bare, angles_deg, strict=True)
    ]
    loaded = [float(_um(_pair(drive, TORQUE_NM, PRELOAD_N)).max()) for drive in drives]
    further = [a - b for a, b in zip(loaded, before, strict=True)]
    numbers = {"without torque, μm": before, "in the plane, N": in_plane, "5 N m adds, μm": further}
    return Claim(
        "predeformation against beta",
        "17",
        "At a fixed preload the predeformation and its force in the plane fall with β, "
        "and the torque deforms the meshing points more; therefore the angle rises.",
        verdict(falls(before) and falls(in_plane) and rises(further)),
        "Without torque a meshing point carries N_Z/(2 Z2 sin β), of which N_Z cot β/(2 Z2) is in "
        "the plane. The turn that the same deformation needs grows with 1/cos β on top.",
        {
            f"β = {beta:g} deg: {what}": values[i]
            for what, values in numbers.items()
            for i, beta in enumerate(angles_deg)
        },
    )


def forces_against_torque() -> Iterator[Claim]:
    drive = make_drive()
    torques_Nm = (1.0, 3.0, 5.0, 10.0)
    loaded, unloaded = [], []
    for torque_Nm in torques_Nm:
        pair = _pair(drive, torque_Nm, PRELOAD_N)
        role = np.array(pair.role)
        in_plane = np.asarray(pair.force_N) * math.cos(math.radians(45))
        loaded.append(float(in_plane[role == "FTMP"].sum()))
        unloaded.append(float(in_plane[role == "NFTMP"].sum()))
    yield Claim(
        "forces against the torque",
        "18",
        "With M0 the forces of the FTMPs in the plane of the plates grow and those of the NFTMPs "
        "fall.",
        verdict(rises(loaded) and falls(unloaded)),
        "Sums over the deceleration pair. Their axial parts together stay the preload, so what the "
        "one side gains the other loses.",
        {f"{t:g} N m: FTMPs, N": x for t, x in zip(torques_Nm, loaded, strict=True)}
        | {f"{t:g} N m: NFTMPs, N": x for t, x in zip(torques_Nm, unloaded, strict=True)},
    )
    per_Nm = drive.preload(1.0).drive.zero_backlash_N
    parts = [preload_N / per_Nm for preload_N in (300.0, 600.0, 1200.0)]

    def parted(torque_Nm: float) -> bool:
        """Whether a contact has parted somewhere over a period of the drive."""
        states = [drive.solve(torque_Nm, PRELOAD_N, a) for a in np.linspace(0, 360 * 3 / 19, 61)]
        pairs = [pair for s in states for pair in (s.deceleration, s.equal_speed) if pair]
        return any("parted" in pair.contact for pair in pairs)

    yield Claim(
        "backlash against the torque",
        "18",
        "At some M0 backlash arises at the NFTMPs; more preload moves it to a larger torque.",
        verdict(parted(1.01 * parts[1]) and not parted(0.99 * parts[1]) and rises(parts)),
        "It is in proportion to the preload. What parts there is one diagonal of one ball; "
        "all the others still hold the plate, so it turns freely nowhere.",
        {
            f"first diagonal parts at {n} N, N m": x
            for n, x in zip((300, 600, 1200), parts, strict=True)
        },
    )


# --- the rig ------------------------------------------------------------------------------


def angle_of_the_test_bar() -> Claim:
    _, curves = prototype_curves()
    largest_rad = max(float(curve.max()) for curve in curves.values()) / ARCSEC_PER_RAD
    error = math.tan(largest_rad) / largest_rad - 1
    return Claim(
        "angle of the test bar",
        "19",
        "The elastic angle is that whose tangent is Δh/h: the way of the bar at the sensor over "
        "its radius of 0.1 m.",
        verdict(error < 1e-3, "the axis of the output does not shift"),
        "Over the range of the test the tangent may even be left out. But the sensor stands on one "
        "side only: a shift of the shaft towards it, as its bearings and the in-plane force of the "
        "drive make it, reads as an angle. Two sensors across the axis would tell them apart.",
        {
            "1 arcsec at the sensor, μm": 0.1e6 / ARCSEC_PER_RAD,
            "a shift of 1 μm reads as, arcsec": ARCSEC_PER_RAD / 0.1e6,
            "error of Δh/h at the largest angle, %": 100 * error,
        },
    )


# --- advice -------------------------------------------------------------------------------


def imbalance() -> Claim:
    of_k = {k: make_drive(short_amplitude_coefficient=k) for k in (0.25, 0.5)}
    drives = {
        "K = 0.25": of_k[0.25],
        "K = 0.5": of_k[0.5],
        "K = 0.5, r0 = 8 mm": make_drive(rolling_circle_radius_mm=8.0),
    }
    e_mm = {name: 2e3 * drive.eccentricity_m for name, drive in drives.items()}
    half, base, twice = e_mm.values()
    return Claim(
        "imbalance",
        "14, 16",
        "The eccentricity of the input shaft, and with it the dynamic imbalance, grows in "
        "proportion to K and to r0.",
        verdict(close(2 * half, base, 1e-12) and close(2 * base, twice, 1e-12)),
        "The eccentricity of the crank is 2 K r0. At a given mass of the planet the imbalance goes "
        "with it; with r0 the plate, and so its mass, grows too. This model is static and computes "
        "no vibration.",
        {f"eccentricity of the crank, {name}, mm": value for name, value in e_mm.items()},
    )


def _with_angle(beta_deg: float) -> cbpt.Drive:
    """The base case with one contact angle in both pairs."""
    rings = {**RINGS, "contact_angle_deg": beta_deg}
    return make_drive(rings, contact_angle_deg=beta_deg)


def _load_on_contacts_N(beta_deg: float, preload_N: float) -> float:
    """Sum of the normal forces of the deceleration pair: friction and wear go with it."""
    return float(_pair(_with_angle(beta_deg), TORQUE_NM, preload_N).force_N.sum())


def wear_against_preload() -> Claim:
    preloads_N = (300.0, 600.0, 1200.0)
    sums = [_load_on_contacts_N(45.0, n) for n in preloads_N]
    return Claim(
        "wear against the preload",
        "15",
        "Wear, heat and losses grow with the preload; where efficiency and life allow, take a "
        "large one.",
        verdict(rises(sums)),
        "This model has no wear. It gives the normal forces, with which sliding friction and, by "
        "Archard's law, wear grow: their sum is N_Z/sin β, whatever the torque.",
        {f"sum of normal forces at {n:g} N, N": x for n, x in zip(preloads_N, sums, strict=True)},
    )


def wear_against_contact_angle() -> Claim:
    angles_deg = (30.0, 45.0, 60.0)
    fixed = [_load_on_contacts_N(beta, PRELOAD_N) for beta in angles_deg]
    needed_N = [_with_angle(beta).preload(TORQUE_NM).drive.continuous_N for beta in angles_deg]
    needed = [
        _load_on_contacts_N(beta, preload_N)
        for beta, preload_N in zip(angles_deg, needed_N, strict=True)
    ]
    where = "" if rises(fixed) else "the preload is the least that the torque needs"
    return Claim(
        "wear against beta",
        "17",
        "A larger β brings more wear, a shorter life and a lower efficiency; where they allow, "
        "take a small one.",
        verdict(rises(needed), where),
        "The sum of the normal forces, with which friction and wear grow, is N_Z/sin β: at a fixed "
        "preload it falls with β. But the preload that a torque needs goes with tan β, and with it "
        "the sum goes with 1/cos β. How wear widens the contact area is not modelled. "
        "To take up a wear w the plates approach by w/sin β, which falls with β; the paper has it "
        "rise.",
        {f"at 600 N, β = {b:g} deg, N": x for b, x in zip(angles_deg, fixed, strict=True)}
        | {
            f"at the least preload, β = {b:g} deg, N": x
            for b, x in zip(angles_deg, needed, strict=True)
        },
    )


def reversal_without_load() -> Claim:
    """4.58 arcsec between both directions, unloaded."""
    arm_m = 27 * make_prototype().eccentricity_m
    clearance_um = 4.58 / ARCSEC_PER_RAD * arm_m * 1e6
    return Claim(
        "reversal without load",
        "20",
        "Unloaded, the test bar turns by 4.58 arcsec between both directions, mainly because of "
        "the bearings of the input shaft.",
        verdict(0 < clearance_um < 20, "the bearing has that play"),
        "A play of that size in the eccentric bearing would do it, and is small for a bearing. "
        "Friction that holds the output back would do it as well; a reversal without load does not "
        "tell them apart. It adds the same angle at every torque, and the differences of Figure "
        "20(d) reach ten times that.",
        {"diametral play of the eccentric bearing, μm": clearance_um},
        {"unloaded, between both directions, arcsec": 4.58},
    )
