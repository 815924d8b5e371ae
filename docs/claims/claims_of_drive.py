"""Claims of Figures 13 to 20: the whole drive, one parameter at a time, and the prototype."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from claim import Claim, verdict
from evidence import (
    BALL_COUNTS,
    DECELERATION_COUNTS,
    PRELOAD_N,
    PROTOTYPE_PRELOADS_N,
    RINGS,
    SLIDE,
    TORQUE_NM,
    Scan,
    alpha_dmax_arcsec,
    bends_up_from,
    crank_of_ball_ring_deg,
    falls,
    falls_ever_slower,
    inside_wall_from,
    make_drive,
    make_prototype,
    pair_angles_arcsec,
    prototype_curves,
    prototype_torques_Nm,
    rises,
    rises_ever_faster,
    scan_contact_angle_deg,
    scan_deceleration_balls,
    scan_preload_N,
    scan_rolling_circle_mm,
    scan_short_amplitude,
    scan_torque_Nm,
    undercut_below_mm,
    undercut_from,
)

# --- Figure 13: the drive over a turn -----------------------------------------------------


def amplitude_of_drive() -> Iterator[Claim]:
    amplitudes = []
    for pair in (RINGS, SLIDE):
        largest = make_drive(pair).largest_elastic_angle(TORQUE_NM, PRELOAD_N)
        assert largest is not None
        amplitudes.append(largest.amplitude_arcsec)
    # Two periods of the ball ring, 36 steps each.
    crank_deg = crank_of_ball_ring_deg(np.linspace(0, 36, 73))
    angles = [np.add(*pair_angles_arcsec(make_drive(pair), crank_deg)) for pair in (RINGS, SLIDE)]
    repeats = all(np.allclose(a[:37], a[36:], rtol=0, atol=1e-8) for a in angles)
    sooner = any(np.allclose(a[:37], a[18:55], rtol=0, atol=1e-8) for a in angles)
    yield Claim(
        "amplitude of the drive",
        "13",
        "The angles of both drives swing by about 2e-4 arcsec, which is the swing of α1.",
        verdict(all(1.5e-4 < a < 2.5e-4 for a in amplitudes)),
        "The swing of the equal-speed pairs is smaller by seven orders and more.",
        {"with rings, arcsec": amplitudes[0], "with a cross-slide, arcsec": amplitudes[1]},
        {"both, arcsec": 2e-4},
    )
    yield Claim(
        "period of the drive",
        "13",
        "They repeat every 2π/Z2.",
        verdict(repeats and not sooner),
        "In the angle of the ball ring, and but for the equal-speed pair's share of less than "
        "1e-9 arcsec; of the crank it is 2π/Z1.",
        {"period of the ball ring, deg": 18.0, "of the crank, deg": 360 / 19},
        {"period, deg": 18.0},
    )


# --- Figures 14 to 18: one parameter at a time --------------------------------------------

COUNTS = ", ".join(map(str, BALL_COUNTS[:-1])) + f" and {BALL_COUNTS[-1]}"


def _angles(scan: Scan, name: str, *places: float) -> dict[str, float]:
    """Angle of 20 balls at points of the grid."""
    at = [int(np.argmin(np.abs(scan.x - place))) for place in places]
    alpha = scan.alpha_arcsec[20]
    return {f"20 balls at {name.format(f'{scan.x[i]:g}')}, arcsec": float(alpha[i]) for i in at}


def _gaps(scan: Scan, name: str, *places: float) -> dict[str, float]:
    """Gap from 20 to 27 balls at points of the grid."""
    at = [int(np.argmin(np.abs(scan.x - place))) for place in places]
    gap = scan.gaps()[1]
    return {
        f"20 less 27 balls at {name.format(f'{scan.x[i]:g}')}, arcsec": float(gap[i]) for i in at
    }


def influence_of_short_amplitude() -> Iterator[Claim]:
    scan = scan_short_amplitude()
    wall = inside_wall_from()
    undercut = {z2: undercut_from(z2) for z2 in BALL_COUNTS}
    with_wall, without = scan.between(wall, 1), scan.between(0, wall)
    step = without.alpha_arcsec[20][-1], with_wall.alpha_arcsec[20][0]
    yield Claim(
        "falls with K",
        "14",
        "α_dmax falls with K, ever slower.",
        verdict(
            scan.all(falls) and with_wall.all(falls_ever_slower) and without.all(falls_ever_slower),
            f"K stays on one side of {wall:.4f}, below undercut at {undercut[20]:.4f}",
        ),
        f"At K = {wall:.4f} the ring radius e = K r0 passes rq cos β: below it the ring grooves "
        "have no inside wall, so that half of their contacts are missing, and where the wall "
        "appears the angle drops steeply. From undercut on (at "
        f"{min(undercut.values()):.3f} to {max(undercut.values()):.3f} for {COUNTS} balls) there "
        "is no drive; at the low end the torque slips.",
        {
            **_angles(scan, "K = {}", 0.2, 0.3, 0.5, 0.58),
            "20 balls just below the inside wall, arcsec": step[0],
            "just above, arcsec": step[1],
        },
    )
    yield Claim(
        "gap shrinks with K",
        "14",
        "The gap between two ball numbers shrinks with K, ever slower.",
        verdict(scan.all_gaps(falls_ever_slower)),
        "The ring grooves are the same for every number of deceleration balls, so the gap does "
        "not see the step at their inside wall.",
        _gaps(scan, "K = {}", 0.2, 0.3, 0.5, 0.58),
    )


def influence_of_preload() -> Iterator[Claim]:
    scan = scan_preload_N()
    few, preloads_N = make_drive(ball_count=4), (600.0, 2400.0)
    trace_Nm, more_Nm = 0.1, 1.0
    by_torque = {
        torque_Nm: [alpha_dmax_arcsec(few, torque_Nm, preload_N) for preload_N in preloads_N]
        for torque_Nm in (trace_Nm, more_Nm)
    }
    fails = rises(by_torque[trace_Nm]) and falls(by_torque[more_Nm])
    share = trace_Nm * few.preload(1.0).drive.hold_N / preloads_N[0]
    yield Claim(
        "falls with the preload",
        "15",
        "α_dmax falls with the preload, ever slower.",
        verdict(
            scan.all(falls_ever_slower),
            "the torque is more than a few per cent of what few balls hold" if fails else "",
        ),
        "From the preload that just holds the torque up to 1500 N. With the preload each contact "
        "starts higher on its curve of force over deformation, where it is stiffer. But few "
        "balls between the unlike walls of an epicycloid and a hypocycloid let the preload alone "
        "turn the plate a little, and more with more. Beside a torque of a few per cent of hold "
        "that is not nothing (ring grooves do not do so): with 4 deceleration balls at "
        f"{trace_Nm:g} N m, {100 * share:.1f} % of what {preloads_N[0]:g} N holds, the angle rises "
        f"with the preload; at {more_Nm:g} N m it falls.",
        _angles(scan, "{} N", 200, 400, 600, 1200)
        | {
            f"4 balls at {torque_Nm:g} N m, {preload_N:g} N, arcsec": alpha
            for torque_Nm, angles in by_torque.items()
            for preload_N, alpha in zip(preloads_N, angles, strict=True)
        },
    )
    shrinks = scan.all_gaps(falls_ever_slower)
    steady = all(np.nanmax(gap) < 1.05 * np.nanmin(gap) for gap in scan.gaps())
    yield Claim(
        "gap does not change with the preload",
        "15",
        "The gap between two ball numbers does not change with the preload.",
        verdict(steady),
        "It shrinks, ever slower"
        + (", for every pair of ball numbers" if shrinks else " for some pairs of ball numbers")
        + ". Where nothing has parted every angle goes with about the preload to the power -1/3, "
        "and so must their difference. On an axis that also shows the angles near slipping the "
        "gap may look constant.",
        _gaps(scan, "{} N", 200, 400, 600, 1200),
    )


def influence_of_rolling_circle() -> Iterator[Claim]:
    scan = scan_rolling_circle_mm()
    undercut_mm = [undercut_below_mm(z2) for z2 in BALL_COUNTS]
    where = f"the grooves do not undercut (r0 above {undercut_mm[1]:.2f} mm with 20 balls)"
    yield Claim(
        "falls with r0",
        "16",
        "α_dmax falls with r0, ever slower.",
        verdict(scan.all(falls_ever_slower), where),
        "Arms go with r0, and larger grooves are flatter along the track. Below (from "
        f"{max(undercut_mm):.2f} to {min(undercut_mm):.2f} mm for {COUNTS} balls) the grooves "
        "undercut. Sought up to 8 mm.",
        _angles(scan, "{} mm", 2.5, 4, 8),
    )
    yield Claim(
        "gap shrinks with r0",
        "16",
        "The gap between two ball numbers shrinks with r0, ever slower.",
        verdict(scan.all_gaps(falls_ever_slower), where),
        "All arms grow in proportion to r0, so the angles of all numbers close in on that of the "
        "ring grooves, which they share.",
        _gaps(scan, "{} mm", 2.5, 4, 8),
    )


def influence_of_contact_angle() -> Iterator[Claim]:
    scan, both = scan_contact_angle_deg(), scan_contact_angle_deg(rings_too=True)
    turns_deg = max(bends_up_from(alpha, scan.x) for alpha in scan.alpha_arcsec.values())
    upper = scan.between(turns_deg, 90)
    yield Claim(
        "rises with beta",
        "17",
        "α_dmax rises with β, ever faster.",
        verdict(
            all(s.all(rises) for s in (scan, both))
            and upper.all(rises_ever_faster)
            and both.all(rises_ever_faster),
            f"β is above about {turns_deg:.0f} deg",
        ),
        "It rises over the whole range, up to where the torque slips, but below "
        f"{turns_deg:.0f} deg ever slower: while nothing has parted, α1 goes as "
        "(sin β)^(1/3)/(cos β)^2, whose first factor bends it down. Below 5 to 9 deg the plates "
        "approach by more than a twentieth of the ball radius. The contact angle of the ring "
        "grooves is kept; changed alike, the same holds from 25 deg up.",
        _angles(scan, "{} deg", 20, 45, 70),
    )
    gap_turns_deg = max(bends_up_from(gap, scan.x) for gap in scan.gaps())
    yield Claim(
        "gap grows with beta",
        "17",
        "The gap between two ball numbers grows with β, ever faster.",
        verdict(
            scan.all_gaps(rises)
            and scan.between(gap_turns_deg, 90).all_gaps(rises_ever_faster)
            and both.all_gaps(rises_ever_faster),
            f"β is above about {gap_turns_deg:.0f} deg",
        ),
        "It grows over the whole range; only the bend turns, for the same reason.",
        _gaps(scan, "{} deg", 20, 45, 70),
    )


def influence_of_torque() -> Iterator[Claim]:
    scan = scan_torque_Nm()
    yield Claim(
        "rises with the torque",
        "18",
        "α_dmax rises with M0, ever faster.",
        verdict(scan.all(rises_ever_faster)),
        "Up to 20 N m, or to where the torque slips. While nothing has parted the angle is nearly "
        "in proportion to M0; each contact that parts leaves more to the rest.",
        _angles(scan, "{} N m", 1, 5, 10, 15),
    )
    yield Claim(
        "gap grows with the torque",
        "18",
        "The gap between two ball numbers grows with M0, ever faster.",
        verdict(scan.all_gaps(rises_ever_faster)),
        "Both angles grow ever faster, that of fewer balls more so.",
        _gaps(scan, "{} N m", 1, 5, 10, 15),
    )


def all_scans() -> tuple[Scan, ...]:
    return (
        scan_short_amplitude(),
        scan_preload_N(),
        scan_rolling_circle_mm(),
        scan_contact_angle_deg(),
        scan_torque_Nm(),
    )


def influence_of_ball_number() -> Iterator[Claim]:
    alpha = scan_deceleration_balls()
    i = DECELERATION_COUNTS.index(20)
    yield Claim(
        "falls with Z2",
        "14 to 18",
        "α_dmax falls with the number of balls Z2, ever slower, and the gap of a fixed difference "
        "in number shrinks.",
        verdict(
            falls_ever_slower(alpha) and all(s.falls_ever_slower_with_balls() for s in all_scans())
        ),
        "At 10 to 40 balls in the base case, and at every point of the five scans.",
        {
            "10 balls, arcsec": alpha[0],
            "20 balls, arcsec": alpha[i],
            "30 balls, arcsec": alpha[i + 10],
            "40 balls, arcsec": alpha[-1],
        },
    )
    reverse = [make_drive(ball_count=z2, output_plate="epicycloid") for z2 in BALL_COUNTS]
    forward = [make_drive(ball_count=z2) for z2 in BALL_COUNTS]
    ratios_right = all(
        f.transmission_ratio == (z2 + 1) / 2 and r.transmission_ratio == -(z2 - 1) / 2
        for f, r, z2 in zip(forward, reverse, BALL_COUNTS, strict=True)
    )
    same_size = {
        z2: alpha_dmax_arcsec(make_drive(ball_count=z2, rolling_circle_radius_mm=80 / z2))
        for z2 in (*range(10, 35, 4), 38)
    }
    yield Claim(
        "larger ratio, higher precision",
        "14 to 18",
        "The ratio is (Z2 + 1)/2, or -(Z2 - 1)/2 where input and output turn against each other; "
        "the larger it is, the higher the precision.",
        verdict(
            ratios_right
            and falls(alpha)
            and falls(map(alpha_dmax_arcsec, reverse))
            and falls(same_size.values())
        ),
        "With either plate as the output. Much of it is size, because at a fixed r0 the drive "
        "grows with Z2; on a ball circle of a fixed 80 mm radius the angle falls by little, and "
        f"at {next(z2 for z2, a in same_size.items() if np.isnan(a))} balls the grooves undercut.",
        {
            "ratio 10.5, arcsec": alpha[i],
            "ratio 17.5, arcsec": alpha[DECELERATION_COUNTS.index(34)],
            "ratio 17.5 at the size of 10.5, arcsec": same_size[34],
        },
    )


# --- Figure 20: the prototype -------------------------------------------------------------

AS_STRAIGHT = (
    "Track curvature neglected: the prototype's grooves undercut (smallest radius 0.20 mm against "
    "1.41 mm) and its ring grooves (e = 0.48 mm against 1.77 mm) have no inside wall."
)


def prototype() -> Iterator[Claim]:
    torques = {preload_N: prototype_torques_Nm(preload_N) for preload_N in PROTOTYPE_PRELOADS_N}
    words = ("a diagonal parts", "d = 0", "holds")
    yield Claim(
        "prototype carries 5 N m",
        "20(a) to (c)",
        "The prototype carries up to 5 N m at preloads of 600, 500 and 400 N.",
        verdict(all(hold > TORQUE_NM for _, _, hold in torques.values())),
        f"{AS_STRAIGHT} But at 600 N the first diagonal parts before 5 N m, and at 400 N the balls "
        "with small arms come loose, which by the paper's own condition is not continuous "
        "transmission any more. The deceleration pair governs.",
        {
            f"{preload_N:g} N: {word}, N m": value
            for preload_N, values in torques.items()
            for word, value in zip(words, values, strict=True)
        },
    )
    torque_Nm, curves = prototype_curves()
    small, large = np.searchsorted(torque_Nm, (0.5, 5.0))
    angles = {f"prototype, {n:g} N": (a[small], a[large]) for n, a in curves.items()} | {
        f"base case, {n:g} N": [alpha_dmax_arcsec(make_drive(), t, n) for t in (0.5, 5.0)]
        for n in PROTOTYPE_PRELOADS_N
    }
    weaker = {f"{name}, %": 100 * (a[1] / (10 * a[0]) - 1) for name, a in angles.items()}
    in_order = np.array(list(weaker.values())).reshape(2, 3)
    yield Claim(
        "nonlinearity weakens",
        "20(a) to (c)",
        "The angle grows with M0, and the higher the preload, the straighter the curve.",
        verdict(
            all(rises_ever_faster(curve, torque_Nm) for curve in curves.values())
            and np.all(np.diff(in_order, axis=1) > 0)
        ),
        "Measured by how much the angle at 5 N m exceeds ten times that at 0.5 N m. " + AS_STRAIGHT,
        weaker,
    )
    yield measured(torque_Nm, curves)


# Calculated minus measured, arcsec, as far as the paper's text has figures: all that is known of
# the measurement.
MEASURED = {
    (600.0, 3.0): 32.3,
    (500.0, 2.5): 25.8,
    (400.0, 1.5): 16.8,
    (400.0, 4.0): -49.8,
    (400.0, 5.0): 39.0,
}
SIGN_CHANGES_NM = {600.0: 4.5, 500.0: 4.0, 400.0: 2.5}


def measured(torque_Nm: np.ndarray, curves: Mapping[float, np.ndarray]) -> Claim:
    calculated = {
        (preload_N, t): float(np.interp(t, torque_Nm, curves[preload_N]))
        for preload_N, t in MEASURED
    }
    less_preload = alpha_dmax_arcsec(make_prototype(), 5.0, 396.0)
    # What a compliance that the calculation lacks would do: measured above calculated, always.
    always_softer = all(difference <= 0 for difference in MEASURED.values())
    return Claim(
        "bearing explains the difference",
        "20(d)",
        "What is left between calculation and test is due to the eccentric section's bearing.",
        verdict(always_softer),
        "A compliance that the calculation lacks makes readings larger than calculated, at every "
        "torque. Here they are smaller up to 4.5, 4.0 and 2.5 N m, so a bearing cannot be the "
        "whole story; friction that holds the output back, or a calculated stiffness that is too "
        "low, can. The text has these differences alone and no calculated curve, so the measured "
        "one cannot be rebuilt: with this model's curve only "
        f"{calculated[600.0, 3.0] - 32.3:.1f} arcsec would be left of "
        f"{calculated[600.0, 3.0]:.1f} at 600 N and 3 N m. Near slipping, as at 400 N and 5 N m, "
        f"1 % of preload changes more than the whole difference. {AS_STRAIGHT}",
        {f"calculated at {n:g} N, {t:g} N m, arcsec": a for (n, t), a in calculated.items()}
        | {"the last with 1 % less preload, arcsec": less_preload},
        {
            **{f"difference at {n:g} N, {t:g} N m, arcsec": d for (n, t), d in MEASURED.items()},
            **{f"sign change at {n:g} N, N m": t for n, t in SIGN_CHANGES_NM.items()},
            "unloaded, between both directions, arcsec": 4.58,
        },
    )
