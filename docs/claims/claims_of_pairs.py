"""Claims of Figures 7 to 12: minimum preload, equal-speed pairs, deceleration pair."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from claim import Claim, close, verdict
from evidence import (
    DECELERATION_COUNTS,
    EQUAL_SPEED_COUNTS,
    PAPER_FORM,
    PAPER_SHARE,
    PRELOAD_N,
    RINGS,
    SLIDE,
    TORQUE_NM,
    alpha_dmax_arcsec,
    crank_of_ball_ring_deg,
    deceleration_curves,
    equal_speed_curves,
    equal_speed_deformations_um,
    falls,
    falls_ever_slower,
    make_drive,
    make_prototype,
)

# --- Figures 7 and 8: minimum preload -----------------------------------------------------


# The paper gives four digits and does not name its stiffness formula. The material drops out of a
# minimum preload, and one stiffness for all contacts would move it by 0.03 %.
PRELOAD_TOLERANCE = 0.001


def minimum_preload_deceleration() -> Claim:
    ours = make_drive().preload(TORQUE_NM).deceleration.continuous_N
    paper = 290.2
    twice_hold = 2 * make_prototype().preload(TORQUE_NM).deceleration.hold_N
    return Claim(
        "minimum preload, deceleration",
        "7(a)",
        "The largest minimum preload of the deceleration pair is 290.2 N.",
        verdict(close(ours, paper, PRELOAD_TOLERANCE)),
        "The paper's number is twice this one; the factor is unexplained. It fits an axial "
        "balance that counts all four meshing points of a ball. With it the paper's prototype "
        f"would need {twice_hold:.0f} N only to hold the 5 N m that the paper tests at 400 to "
        "600 N, so this model has no such factor.",
        {"largest minimum preload, N": ours, "twice that, N": 2 * ours},
        {"largest minimum preload, N": paper},
    )


def minimum_preload_rings() -> Claim:
    ours = make_drive().preload(TORQUE_NM).equal_speed.continuous_N
    e_mm = make_drive().eccentricity_m * 1e3
    shorter = {**RINGS, "pitch_radius_mm": RINGS["pitch_radius_mm"] - e_mm}
    short_arm = make_drive(shorter).preload(TORQUE_NM).equal_speed.continuous_N
    paper = 320.9
    return Claim(
        "minimum preload, rings",
        "7(b)",
        "The largest minimum preload of the ring-groove pair is 320.9 N.",
        verdict(close(ours, paper, PRELOAD_TOLERANCE)),
        "The same factor 2, and an arm: with Rw - e in place of Rw twice the model's value is "
        "the paper's. The in-plane normals run through the middle of each ring groove, which is "
        "at Rw from the axis of its plate, so statics give Rw.",
        {
            "largest minimum preload, N": ours,
            "with the arm Rw - e, N": short_arm,
            "twice that, N": 2 * short_arm,
        },
        {"largest minimum preload, N": paper},
    )


def minimum_preload_slide() -> Claim:
    carried = make_drive(SLIDE).preload(TORQUE_NM).equal_speed.continuous_N
    whole = make_drive({**SLIDE, **PAPER_SHARE}).preload(TORQUE_NM).equal_speed.continuous_N
    paper = 303.8
    return Claim(
        "minimum preload, slide",
        "7(c)",
        "The largest minimum preload of the cross-slide pair is 303.8 N.",
        verdict(any(close(ours, paper, PRELOAD_TOLERANCE) for ours in (carried, whole))),
        "The factor 2 again, and 0.3 % that stay unexplained. The cross-slide holds the planet, "
        "which carries M0 Z1/Z3, so it needs less than with all of M0.",
        {
            "with M0 on it, N": whole,
            "twice that, N": 2 * whole,
            "with the torque that it carries, N": carried,
        },
        {"largest minimum preload, N": paper},
    )


def equal_speed_governs() -> Claim:
    rings, slide = make_drive().preload(TORQUE_NM), make_drive(SLIDE).preload(TORQUE_NM)
    prototype = make_prototype().preload(TORQUE_NM)
    deceleration_N = rings.deceleration.continuous_N
    rings_govern = rings.equal_speed.continuous_N > deceleration_N
    slide_governs = slide.equal_speed.continuous_N > deceleration_N
    where = "" if slide_governs else "the pair has ring grooves"
    return Claim(
        "equal-speed pair governs",
        "7",
        "In the base case the equal-speed pair governs the minimum preload (the minimum APF).",
        verdict(rings_govern, where),
        "With a cross-slide at the torque that it carries the deceleration pair governs. Which "
        "pair governs is a matter of the design: in the paper's prototype (track curvature "
        "neglected: its grooves undercut and its ring grooves have no inside wall) it is the "
        "deceleration pair.",
        {
            "deceleration, N": deceleration_N,
            "rings, N": rings.equal_speed.continuous_N,
            "cross-slide, N": slide.equal_speed.continuous_N,
            "prototype, deceleration, N": prototype.deceleration.continuous_N,
            "prototype, rings, N": prototype.equal_speed.continuous_N,
        },
        {"deceleration, N": 290.2, "rings, N": 320.9, "cross-slide, N": 303.8},
    )


def larger_of_both() -> Claim:
    drive = make_drive()
    need_N = drive.preload(TORQUE_NM).drive.continuous_N
    # A period of the drive, fine enough to meet the maximum of both pairs.
    crank_deg = np.linspace(0, 360 * 3 / 19, 61)

    def least_approach_um(preload_N: float) -> float:
        states = [drive.solve(TORQUE_NM, preload_N, angle) for angle in crank_deg]
        pairs = [pair for s in states for pair in (s.deceleration, s.equal_speed) if pair]
        return min(pair.approach_m for pair in pairs) * 1e6

    above, below = least_approach_um(1.01 * need_N), least_approach_um(0.99 * need_N)
    return Claim(
        "larger of both",
        "7",
        "For continuous transmission the larger of both pairs' largest minimum preloads is "
        "necessary and sufficient.",
        verdict(above > 0 > below),
        "The minimum preload is the state in which the plates' axial approach d is 0: 1 % above "
        "it d stays above 0 at every crank angle, 1 % below it does not and balls with small "
        "arms come loose. The torque itself is held down to a lower preload.",
        {
            "larger of both, N": need_N,
            "least d 1 % above it, μm": above,
            "least d 1 % below it, μm": below,
            "holds the torque from, N": drive.preload(TORQUE_NM).drive.hold_N,
        },
    )


def _repeats(kind: str, period_deg: float) -> bool:
    """Whether the minimum preload repeats after a turn of the ball ring, and not after half."""
    at = np.array([0.0, 1.7, 4.1, 6.9])

    def preload(shift_deg: float) -> np.ndarray:
        drive = make_drive(SLIDE if kind == "slide" else RINGS)
        pairs = [drive.preload(TORQUE_NM, a) for a in crank_of_ball_ring_deg(at + shift_deg)]
        name = "deceleration" if kind == "deceleration" else "equal_speed"
        return np.array([getattr(pair, name).continuous_N for pair in pairs])

    start = preload(0.0)
    same = np.allclose(preload(period_deg), start, rtol=1e-9)
    return same and not np.allclose(preload(period_deg / 2), start, rtol=1e-6)


def periods() -> Iterator[Claim]:
    rings_deg, slide_deg = 360 * 20 / (14 * 21), 360 * 20 / (16 * 21)
    yield Claim(
        "period, deceleration",
        "7(a)",
        "The minimum preload of the deceleration pair repeats every 2π/Z2 of the angle Φ1.",
        verdict(_repeats("deceleration", 360 / 20)),
        "After 2π/Z2 of the ring of balls every ball stands where the one before it stood.",
        {"period of the ball ring, deg": 360 / 20},
        {"period of Φ1, deg": 360 / 20},
    )
    ours_deg = 360 * 21 / (20 * 14)
    assert _repeats("rings", ours_deg)
    yield Claim(
        "period, rings",
        "7(b)",
        "That of the ring-groove pair repeats every 2π Z2/[Zd (Z2 + 1)].",
        verdict(_repeats("rings", rings_deg)),
        "It repeats every 2π/Zd of the planet, and while the planet turns by 1 the ball ring "
        "turns by (Z2 + 1)/Z2, which makes 2π (Z2 + 1)/(Z2 Zd). The paper has the ratio of the "
        "two turns the other way round.",
        {"period of the ball ring, deg": ours_deg, "of the planet, deg": 360 / 14},
        {"period of Φ1, deg": rings_deg},
    )
    turn = np.linspace(0, 90, 7)
    constant = np.ptp(
        [make_drive(SLIDE).preload(TORQUE_NM, a).equal_speed.continuous_N for a in turn]
    )
    swing = np.ptp(
        [
            make_drive({**SLIDE, **PAPER_FORM}).preload(TORQUE_NM, a).equal_speed.continuous_N
            for a in turn
        ]
    )
    yield Claim(
        "period, slide",
        "7(c)",
        "That of the cross-slide pair repeats every 2π Z2/[ZS (Z2 + 1)].",
        verdict(constant > 1e-9 and _repeats("slide", slide_deg)),
        "It is constant: the planet does not turn against a cross-slide, and the shift of the "
        "balls along straight grooves has no arm once the forces on the floating plate balance. "
        "With e cos φ added to every arm, as in the paper, it swings with the crank itself.",
        {
            "swing over a turn, N": float(constant),
            "swing with the paper's arms, N": float(swing),
        },
        {"period of Φ1, deg": slide_deg},
    )


def deformation_at_minimum_preload() -> Iterator[Claim]:
    """Figure 8: each state at the minimum preload of its own angle."""
    loaded, unloaded, armless = [], [], 0
    at_largest_deg = {}
    ball_ring_deg = np.arange(0.0, 180.1, 1.5)
    for pair, kind in (("deceleration", RINGS), ("equal_speed", RINGS), ("equal_speed", SLIDE)):
        drive = make_drive(kind)
        first_ball = []
        # Backwards, so that the first ball's angle on its own circle rises with the turn.
        for crank_deg in -crank_of_ball_ring_deg(ball_ring_deg):
            need_N = getattr(drive.preload(TORQUE_NM, crank_deg), pair).continuous_N
            state = getattr(drive.solve(TORQUE_NM, need_N, crank_deg), pair)
            role, deformation_um = np.array(state.role), state.deformation_m * 1e6
            loaded.append(deformation_um[role == "FTMP"].min())
            unloaded.append(deformation_um[role == "NFTMP"].max())
            armless += int(np.count_nonzero(role == "neutral"))
            first_ball.append(deformation_um[:2].max())
        if kind is RINGS:
            # The planet turns Z2/Z3 of what the ball ring turns.
            turned = ball_ring_deg * (1.0 if pair == "deceleration" else 20 / 21)
            at_largest_deg[pair] = float(turned[np.argmax(first_ball)])
    where = "the arm of the ball is not 0" if armless else ""
    yield Claim(
        "deformation at the minimum preload",
        "8",
        "At the minimum preload every FTMP is deformed and every NFTMP is not.",
        verdict(min(loaded) > 0 and max(unloaded) < 1e-9, where),
        "That is the state that defines the minimum preload. A ball whose arm is 0 carries "
        "nothing there; in the cross-slide these are always the two balls across the grooves.",
        {"least FTMP deformation, μm": min(loaded)},
    )
    yield Claim(
        "largest deformation at the minimum preload",
        "8",
        "A ball's deformation is largest in the first half of its period.",
        verdict(at_largest_deg["deceleration"] < 88, "the pair is the deceleration pair"),
        "A deceleration ball has its longest arm where cos φ = K, at 60 deg of the 180 deg "
        "during which it is an FTMP. A ring-groove ball has it in the middle.",
        {
            "deceleration, deg": at_largest_deg["deceleration"],
            "rings, deg": at_largest_deg["equal_speed"],
        },
    )


# --- Figures 9 and 10: equal-speed pairs --------------------------------------------------


def angle_against_equal_speed_balls() -> Claim:
    curves = equal_speed_curves()
    rings, slide = curves["rings"][0], curves["slide"][0]
    i, j = EQUAL_SPEED_COUNTS.index(14), EQUAL_SPEED_COUNTS.index(16)
    return Claim(
        "angle against equal-speed balls",
        "9(a)",
        "The angles α2 (rings) and α3 (cross-slide) fall with the number of balls, ever slower, "
        "and so does their difference.",
        verdict(all(map(falls_ever_slower, (rings, slide, slide - rings)))),
        "All contacts of a pair are springs side by side; with Z of them under one preload and "
        "one torque the angle goes with Z to the power -2/3.",
        {"α2 of 14 balls, arcsec": rings[i], "α3 of 16 balls, arcsec": slide[j]},
    )


def ratio_of_equal_speed_pairs() -> Iterator[Claim]:
    curves = equal_speed_curves()
    rings = curves["rings"][0]
    whole, carried = rings / curves["slide, M0"][0], rings / curves["slide"][0]
    spread = max(np.ptp(whole), np.ptp(carried))
    numbers = {
        "ratio with M0 on both": float(whole[-1]),
        "ratio with what each carries and passes on": float(carried[-1]),
    }
    yield Claim(
        "ratio is constant",
        "9(a)",
        "The ratio of α2 to α3 does not depend on the number of balls.",
        verdict(spread < 1e-4, "both pairs have the same number of balls"),
        "Both go with the same power of the number.",
        {**numbers, "spread over 6 to 24 balls, below": 1e-4},
    )
    yield Claim(
        "ratio is 0.6443",
        "9(a)",
        "That ratio is about 0.6443.",
        verdict(any(close(value, 0.6443, 0.01) for value in numbers.values())),
        "The cross-slide has two rows in series, which alone gives 0.5; the curvature of the "
        "ring grooves makes it 0.506. The cross-slide carries M0 Z1/Z3 and passes on Z1/Z3 of "
        "its angle, which gives 0.62. 0.6443 is unexplained.",
        numbers,
        {"ratio": 0.6443},
    )
    yield Claim(
        "rings above slide",
        "10",
        "In one place: α2 is greater than α3.",
        verdict(np.any(whole > 1) or np.any(carried > 1)),
        "It contradicts the paper's own ratio below 1; α2 is the smaller at every count.",
        numbers,
    )


def amplitude_against_equal_speed_balls() -> Iterator[Claim]:
    curves = equal_speed_curves()
    rings, slide, paper = (curves[name][1] for name in ("rings", "slide", "slide, paper"))
    ratio = rings / paper
    deceleration = deceleration_curves()["amplitude_arcsec"][DECELERATION_COUNTS.index(20)]
    i, j = EQUAL_SPEED_COUNTS.index(14), EQUAL_SPEED_COUNTS.index(16)
    yield Claim(
        "amplitude against equal-speed balls",
        "9(b)",
        "The amplitudes of α2 and α3 fall with the number of balls in a fixed ratio, that of α2 "
        "being the greater.",
        verdict(
            falls_ever_slower(rings)
            and falls_ever_slower(slide)
            and np.ptp(ratio) < 0.01 * ratio.max()
        ),
        "The amplitude of α2 falls about a hundredfold with every two balls, to below 1e-9 arcsec "
        "from 11 on, but 10 balls have more of it than 9. That of α3 is 0, or with the paper's "
        "arms from 7 balls on many times that of α2, so the ratio is not fixed.",
        {
            "α2, 6 balls, arcsec": rings[0],
            "α2, 9 balls, arcsec": rings[3],
            "α2, 10 balls, arcsec": rings[4],
            "α3, any count, arcsec": float(slide.max()),
            "α3 with the paper's arms, 10 balls, arcsec": paper[4],
        },
    )
    small = rings[i] < 1e-9 and slide[j] < 1e-9
    yield Claim(
        "amplitudes three orders apart",
        "9(b), 11(b)",
        "The amplitudes of α2 and α3 are three orders smaller than that of α1.",
        verdict(not small and close(np.log10(deceleration / rings[i]), 3, 0.2)),
        "They are smaller by far more than that, so neglecting them, which is all the paper does "
        "with the claim, is sound.",
        {"α1, 20 balls, arcsec": deceleration, "α2 and α3, 14 and 16 balls, arcsec, below": 1e-9},
    )


def rings_stiffer() -> Claim:
    curves = equal_speed_curves()
    rings = curves["rings"][0]
    stiffer = all(np.all(rings < curves[name][0]) for name in ("slide", "slide, M0"))
    return Claim(
        "rings stiffer",
        "9, 13",
        "The drive with ring grooves is more precise than the one with a cross-slide.",
        verdict(stiffer),
        "The cross-slide has two rows in series, the ring grooves have one. It stays softer "
        "although it carries only M0 Z1/Z3 and passes on only Z1/Z3 of its angle.",
        {
            "drive with rings, arcsec": alpha_dmax_arcsec(make_drive()),
            "with a cross-slide, arcsec": alpha_dmax_arcsec(make_drive(SLIDE)),
            "the same as the paper adds it up, arcsec": alpha_dmax_arcsec(
                make_drive({**SLIDE, **PAPER_SHARE})
            ),
        },
    )


def inside_softer() -> Claim:
    state = make_drive().solve(TORQUE_NM, PRELOAD_N).equal_speed
    assert state is not None
    stiffness = np.asarray(state.force_N) / np.asarray(state.deformation_m) ** 1.5
    outside, inside = (stiffness[np.asarray(state.diagonal) == side] for side in (1, -1))
    return Claim(
        "inside walls softer",
        "10",
        "The stiffness k2 at the inside of a ring groove is below k1 at its outside.",
        verdict(inside.max() < outside.min()),
        "The outside wall curves round the ball along the track, the inside wall away from it. "
        "k is that of a diagonal, two contacts in series.",
        {"k1, N/m^1.5": float(outside.max()), "k2, N/m^1.5": float(inside.max())},
    )


def deformation_against_equal_speed_balls() -> Claim:
    rings, slide = (equal_speed_deformations_um(kind) for kind in ("rings", "slide"))
    i, j = EQUAL_SPEED_COUNTS.index(14), EQUAL_SPEED_COUNTS.index(16)
    return Claim(
        "deformation against equal-speed balls",
        "10",
        "The deformations of FTMPs and NFTMPs of both pairs fall with the number of balls, and "
        "not in proportion.",
        verdict(all(falls(curve) for pair in (rings, slide) for curve in pair)),
        "Approach and turn of a pair both go with the number to the power -2/3. Largest FTMP "
        "and smallest NFTMP deformation, crank at 0.",
        {
            "rings, 14 balls, FTMP, μm": rings[0][i],
            "rings, 14 balls, NFTMP, μm": rings[1][i],
            "cross-slide, 16 balls, FTMP, μm": slide[0][j],
            "cross-slide, 16 balls, NFTMP, μm": slide[1][j],
        },
    )


# --- Figures 11 to 13: deceleration pair and drive ----------------------------------------


def angle_against_deceleration_balls() -> Iterator[Claim]:
    curves = deceleration_curves()
    i = DECELERATION_COUNTS.index(20)
    yield Claim(
        "angle against deceleration balls",
        "11(a)",
        "The angle α1 falls with the number of balls, ever slower.",
        verdict(falls_ever_slower(curves["largest_arcsec"])),
        "At a fixed r0 more balls also stand on a larger circle, with a longer arm.",
        {"α1, 20 balls, arcsec": curves["largest_arcsec"][i]},
    )
    amplitude = curves["amplitude_arcsec"]
    yield Claim(
        "amplitude against deceleration balls",
        "11(b)",
        "The amplitude of α1 falls with the number of balls, ever slower, and is negligible.",
        verdict(falls_ever_slower(amplitude) and amplitude[i] < 1e-3),
        "It falls by more than a third with every ball.",
        {
            "10 balls, arcsec": amplitude[0],
            "20 balls, arcsec": amplitude[i],
            "30 balls, arcsec": amplitude[i + 10],
        },
    )
    loaded, unloaded = curves["loaded_um"], curves["unloaded_um"]
    turns = int(np.argmax(unloaded))
    yield Claim(
        "deformation against deceleration balls",
        "12",
        "The deformation of FTMPs falls with the number of balls; that of NFTMPs follows no such "
        "rule.",
        verdict(falls_ever_slower(loaded) and 0 < turns < len(unloaded) - 1),
        "More balls share the preload, which lowers both, and need a smaller turn for the same "
        f"torque, which relieves the NFTMPs less: theirs rises up to {DECELERATION_COUNTS[turns]} "
        "balls and then falls.",
        {
            "FTMP, 10 balls, μm": loaded[0],
            "FTMP, 20 balls, μm": loaded[i],
            "NFTMP, 10 balls, μm": unloaded[0],
            "NFTMP, 14 balls, μm": unloaded[4],
            "NFTMP, 20 balls, μm": unloaded[i],
        },
    )


def stiffness_against_short_amplitude() -> Claim:
    """The reason that the paper gives for what K does."""

    def of(k: float) -> tuple[float, float]:
        """Mean stiffness of a meshing point, N/m^1.5, and torsional stiffness of the pair."""
        pair = make_drive(short_amplitude_coefficient=k).solve(1e-6, PRELOAD_N).deceleration
        assert pair is not None
        point = pair.force_N / pair.deformation_m**1.5
        return float(point.mean()), pair.torsional_stiffness_Nm_per_rad

    (low, turning_low), (high, turning_high) = of(0.3), of(0.55)
    return Claim(
        "stiffness against K",
        "14",
        "The larger K, the greater the stiffness of the meshing points; therefore the angle falls.",
        verdict(high / low > (turning_high / turning_low) ** 0.5),
        "The angle falls because the eccentricity e = K r0, and with it the lever arm, grows. The "
        "curvature that K adds to one wall it takes from the opposite wall of the same ball.",
        {
            "stiffness of a meshing point, K = 0.55 over K = 0.3": high / low,
            "torsional stiffness of the pair, K = 0.55 over K = 0.3": turning_high / turning_low,
            "lever arm, K = 0.55 over K = 0.3": 0.55 / 0.3,
        },
    )
