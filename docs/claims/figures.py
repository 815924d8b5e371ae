"""Counterparts of the paper's figures, and the page that holds its claims against this model.

    python docs/claims/figures.py               write docs/explanation/claims.md
    python docs/claims/figures.py --check       exit 1 if that page is not what would be written
    python docs/claims/figures.py --draw DIR    draw the figures into a folder (`make docs` does)

The page is generated, so it cannot drift from the model. Only drawing needs matplotlib.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from claim import FAILS, HOLDS
from claims import Claim, claims
from claims_of_drive import MEASURED, SIGN_CHANGES_NM
from evidence import (
    DECELERATION_COUNTS,
    EQUAL_SPEED_COUNTS,
    RINGS,
    SLIDE,
    Scan,
    crank_of_ball_ring_deg,
    deceleration_curves,
    equal_speed_curves,
    equal_speed_deformations_um,
    inside_wall_from,
    make_drive,
    minimum_preload_deformations_um,
    minimum_preload_N,
    pair_angles_arcsec,
    prototype_curves,
    prototype_torques_Nm,
    scan_contact_angle_deg,
    scan_preload_N,
    scan_rolling_circle_mm,
    scan_short_amplitude,
    scan_torque_Nm,
    undercut_below_mm,
    undercut_from,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HERE = Path(__file__).parent
PAGE = HERE.parent / "explanation" / "claims.md"

# Okabe and Ito's colours, which stay apart for colour-blind readers.
BLUE, ORANGE, GREEN, PURPLE, GREY = "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#8a8a8a"
SERIES = (ORANGE, BLUE, GREEN, PURPLE)
STYLE: dict[Any, Any] = {
    "svg.hashsalt": "cbpt",
    "svg.fonttype": "none",  # text stays text: small files that can be searched
    "font.family": "DejaVu Sans",
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.titlelocation": "left",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e4e4e4",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.4,
    "lines.markersize": 3.5,
    "legend.frameon": False,
    "legend.fontsize": 8,
    "figure.facecolor": "white",
}
DIAGONALS = ((0, "plus diagonal", BLUE), (1, "minus diagonal", ORANGE))
BALLS_EQUAL_SPEED = "equal-speed balls"
BALLS_DECELERATION = "deceleration balls Z2"
BALL_RING = "turn of the ball ring Φ1, deg"


# --- figures ------------------------------------------------------------------------------


def panels(count: int, height_in: float = 3.0) -> tuple[Figure, list[Axes]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.1 * count if count < 3 else 10.2, height_in), layout="constrained")
    return figure, list(np.atleast_1d(figure.subplots(1, count)))


def finish(axes: Axes, title: str, x: str, y: str, **legend: Any) -> None:
    axes.set(title=title, xlabel=x, ylabel=y)
    axes.minorticks_off()
    if "balls" in x:
        axes.set_xticks(range(10, 41, 5) if "Z2" in x else range(6, 25, 2))
    if axes.get_legend_handles_labels()[0]:
        axes.legend(**legend)


def minimum_preload() -> Figure:
    at_deg = np.arange(0.0, 54.1, 0.5)
    curves = minimum_preload_N(tuple(at_deg))
    figure, (left, middle, right) = panels(3)
    for axes, stated_N in ((left, 290.2), (middle, 320.9), (right, 303.8)):
        label = f"half of {stated_N} N (paper)"
        axes.axhline(stated_N / 2, color=GREY, linestyle="--", label=label)
    left.plot(at_deg, curves["deceleration"], color=BLUE, label="this model")
    middle.plot(at_deg, curves["rings"], color=BLUE, label="this model")
    right.plot(at_deg, curves["slide"], color=BLUE, label="this model")
    right.plot(at_deg, curves["slide, M0"], color=ORANGE, label="with M0 on it")
    right.plot(
        at_deg, curves["slide, paper"], color=GREEN, linewidth=1, label="and the paper's arms"
    )
    left.set_ylim(144, 145.5)
    middle.set_ylim(150, 162)
    right.set_ylim(136, 154)
    finish(left, "(a) deceleration", BALL_RING, "minimum preload, N", loc="upper right")
    finish(middle, "(b) ring grooves", BALL_RING, "minimum preload, N", loc="center right")
    finish(right, "(c) cross-slide", BALL_RING, "minimum preload, N", loc="center right")
    return figure


def deformation_at_minimum_preload() -> Figure:
    at_deg = tuple(np.arange(0.0, 360.1, 6.0))
    figure, (left, middle, right) = panels(3)
    for axes, kind, title in (
        (left, "deceleration", "(a) a deceleration ball"),
        (middle, "rings", "(b) a ring-groove ball"),
    ):
        for side, label, color in DIAGONALS:
            um = minimum_preload_deformations_um(kind, at_deg)[:, 0, side]
            axes.plot(at_deg, um, color=color, label=label)
        axes.set_ylim(top=1.4 * axes.get_ylim()[1])
        finish(axes, title, BALL_RING, "deformation of a diagonal, μm", loc="upper center")
    all_balls = minimum_preload_deformations_um("slide", (0.0,))[0]
    for side, label, color in DIAGONALS:
        right.plot(
            np.arange(1, len(all_balls) + 1), all_balls[:, side], "o", color=color, label=label
        )
    right.set_ylim(top=1.4 * right.get_ylim()[1])
    right.set_xticks(range(2, len(all_balls) + 1, 2))
    title = "(d) all balls of the cross-slide"
    finish(right, title, "ball", "deformation of a diagonal, μm", loc="upper center")
    return figure


def equal_speed_angle() -> Figure:
    curves = equal_speed_curves()
    count = np.array(EQUAL_SPEED_COUNTS)
    figure, (left, right) = panels(2)
    for name, label, color in (
        ("rings", "α2, ring grooves", BLUE),
        ("slide", "α3, cross-slide, as it reaches the output", ORANGE),
        ("slide, M0", "α3 with M0 on it", GREEN),
    ):
        left.plot(count, curves[name][0], "o-", color=color, label=label)
    left.set_ylim(0)
    finish(left, "(a) largest angle", BALLS_EQUAL_SPEED, "angle, arcsec")
    # What is below 1e-11 arcsec is near rounding.
    rings = np.where(curves["rings"][1] > 1e-11, curves["rings"][1], np.nan)
    right.semilogy(count, rings, "o-", color=BLUE, label="α2")
    right.semilogy(
        count, curves["slide, paper"][1], "o-", color=GREEN, label="α3 with the paper's arms"
    )
    right.text(24, 1e-10, "α3 of this model: 0", ha="right", color=ORANGE, fontsize=8)
    finish(right, "(b) amplitude over a turn", BALLS_EQUAL_SPEED, "amplitude, arcsec")
    return figure


def equal_speed_deformation() -> Figure:
    figure, both = panels(2)
    names = (("rings", "(a) ring grooves"), ("slide", "(b) cross-slide"))
    for axes, (kind, title) in zip(both, names, strict=True):
        loaded, unloaded = equal_speed_deformations_um(kind)
        axes.plot(EQUAL_SPEED_COUNTS, loaded, "o-", color=BLUE, label="largest of the FTMPs")
        axes.plot(EQUAL_SPEED_COUNTS, unloaded, "o-", color=ORANGE, label="smallest of the NFTMPs")
        axes.set_ylim(0, 8.5)
        finish(axes, title, BALLS_EQUAL_SPEED, "deformation of a diagonal, μm")
    return figure


def deceleration_angle() -> Figure:
    curves = deceleration_curves()
    figure, (left, right) = panels(2)
    left.plot(DECELERATION_COUNTS, curves["largest_arcsec"], "o-", color=BLUE)
    left.set_ylim(0)
    finish(left, "(a) largest α1", BALLS_DECELERATION, "angle, arcsec")
    right.semilogy(DECELERATION_COUNTS, curves["amplitude_arcsec"], "o-", color=BLUE)
    finish(right, "(b) amplitude of α1 over a turn", BALLS_DECELERATION, "amplitude, arcsec")
    return figure


def deceleration_deformation() -> Figure:
    curves = deceleration_curves()
    figure, (axes,) = panels(1)
    x = DECELERATION_COUNTS
    axes.plot(x, curves["loaded_um"], "o-", color=BLUE, label="largest of the FTMPs")
    axes.plot(x, curves["unloaded_um"], "o-", color=ORANGE, label="smallest of the NFTMPs")
    axes.set_ylim(0)
    finish(axes, "", BALLS_DECELERATION, "deformation of a diagonal, μm")
    return figure


def drive_over_a_turn() -> Figure:
    at_deg = np.linspace(0, 54, 163)
    figure, both = panels(2)
    for axes, pair, title in (
        (both[0], RINGS, "(a) αd, with ring grooves"),
        (both[1], SLIDE, "(b) αs, with a cross-slide"),
    ):
        alpha = np.add(*pair_angles_arcsec(make_drive(pair), crank_of_ball_ring_deg(at_deg)))
        axes.plot(at_deg, (alpha - alpha.min()) * 1e4, color=BLUE)
        finish(axes, title, BALL_RING, f"angle less {alpha.min():.4f}, 1e-4 arcsec")
    return figure


def _influence(
    scan: Scan, x: str, top_arcsec: float, gap_top_arcsec: float
) -> tuple[Figure, list[Axes]]:
    figure, both = panels(2)
    left, right = both
    for color, (z2, alpha) in zip(SERIES, scan.alpha_arcsec.items(), strict=True):
        left.plot(scan.x, alpha, color=color, label=f"{z2} balls")
    counts = list(scan.alpha_arcsec)
    pairs = zip(SERIES, scan.gaps(), counts, counts[1:], strict=False)
    for color, gap, few, more in pairs:
        right.plot(scan.x, gap, color=color, label=f"{few} less {more} balls")
    left.set_ylim(0, top_arcsec)
    right.set_ylim(0, gap_top_arcsec)
    finish(left, "(a) largest elastic angle", x, "α_dmax, arcsec")
    finish(right, "(b) gap between two ball numbers", x, "difference of α_dmax, arcsec")
    return figure, both


def _undercut_at(x: float, axes: Axes) -> None:
    """Names the coloured end of an axis, upright in the middle of it."""
    middle: dict[str, Any] = {"rotation": 90, "va": "center", "ha": "center"}
    axes.text(x, 0.5 * axes.get_ylim()[1], "undercut (20 balls)", fontsize=8, **middle)


def influence_of_short_amplitude() -> Figure:
    figure, both = _influence(scan_short_amplitude(), "short-amplitude coefficient K", 100, 60)
    for axes in both:
        axes.axvspan(0.1, inside_wall_from(), color="#f2f2f2", zorder=0)
        axes.axvspan(undercut_from(20), 0.62, color="#f6e3d7", zorder=0)
        axes.set_xlim(0.1, 0.62)
        top = axes.get_ylim()[1]
        axes.text(0.11, 0.02 * top, "no inside wall", fontsize=8, color="#555555")
        _undercut_at(0.605, axes)
    return figure


def influence_of_preload() -> Figure:
    return _influence(scan_preload_N(), "preload N_Z, N", 60, 30)[0]


def influence_of_rolling_circle() -> Figure:
    figure, both = _influence(scan_rolling_circle_mm(), "rolling-circle radius r0, mm", 50, 30)
    for axes in both:
        axes.axvspan(2.0, undercut_below_mm(20), color="#f6e3d7", zorder=0)
        axes.set_xlim(2.0, 8.0)
        _undercut_at(2.17, axes)
    return figure


def influence_of_contact_angle() -> Figure:
    return _influence(scan_contact_angle_deg(), "contact angle β, deg", 60, 30)[0]


def influence_of_torque() -> Figure:
    return _influence(scan_torque_Nm(), "torque M0, N m", 100, 40)[0]


def prototype() -> Figure:
    torque_Nm, curves = prototype_curves()
    figure, (left, right) = panels(2, 3.4)
    for color, (preload_N, alpha) in zip(SERIES, curves.items(), strict=False):
        left.plot(torque_Nm, alpha, color=color, label=f"{preload_N:g} N")
        *thresholds, hold_Nm = prototype_torques_Nm(preload_N)
        for torque, marker in zip(thresholds, "o^", strict=True):
            if torque <= torque_Nm[-1]:
                on_curve = np.interp(torque, torque_Nm, alpha)
                left.plot(torque, on_curve, marker, color=color, markersize=6)
        left.axvline(hold_Nm, color=color, linestyle=":")
        known = [(t, d) for (n, t), d in MEASURED.items() if n == preload_N]
        right.plot(*zip(*known, strict=True), "o", color=color, label=f"{preload_N:g} N")
        right.plot(SIGN_CHANGES_NM[preload_N], 0, "D", color=color, fillstyle="none")
    left.plot([], [], "o", color=GREY, label="a diagonal parts")
    left.plot([], [], "^", color=GREY, label="d = 0")
    right.plot([], [], "D", color=GREY, fillstyle="none", label="changes sign")
    right.axhline(0, color=GREY, linewidth=0.8)
    left.plot([], [], ":", color=GREY, label="slips")
    left.set(xlim=(0, 8), ylim=(0, 150))
    right.set(xlim=(0, 5.5), ylim=(-60, 60))
    finish(
        left,
        "(a) to (c) calculated, tracks taken as straight",
        "torque M0, N m",
        "α_dmax, arcsec",
        loc="upper left",
    )
    finish(
        right,
        "(d) calculated less measured, as the paper states it",
        "torque M0, N m",
        "difference, arcsec",
        loc="lower left",
    )
    return figure


FIGURES: dict[str, tuple[str, str, Callable[[], Figure]]] = {
    "7": (
        "Minimum preload over a turn",
        "Half of the paper's maximum, dashed, is the top of this model's curve for the "
        "deceleration pair, above it by the ratio Rw/(Rw - e) for the ring grooves, and 0.3 % "
        "above it for the cross-slide with all of M0 on it.",
        minimum_preload,
    ),
    "8": (
        "Deformation at the minimum preload",
        "Each state at the minimum preload of its own angle. The diagonal that the torque loads is "
        "pressed together, the other one just touches; a ball passes from one to the other where "
        "its arm changes sign. A ball of the cross-slide keeps its arm, and so its deformation. "
        "Of 16 balls the fifth, which the paper draws in (c), has no arm here and carries nothing.",
        deformation_at_minimum_preload,
    ),
    "9": (
        "Angle of the equal-speed pairs",
        "The curves of (a) keep one ratio. In (b) the swing of the ring grooves fades to nothing "
        "within a few balls; that of the cross-slide exists only with the paper's arms.",
        equal_speed_angle,
    ),
    "10": (
        "Deformation in the equal-speed pairs",
        "Crank at 0. A diagonal has two meshing points; its deformation is that of both.",
        equal_speed_deformation,
    ),
    "11": (
        "Angle of the deceleration pair",
        "At a fixed r0, so that the circle of balls grows with their number.",
        deceleration_angle,
    ),
    "12": (
        "Deformation in the deceleration pair",
        "The NFTMPs have their maximum at 14 balls.",
        deceleration_deformation,
    ),
    "13": (
        "Angle of the drive over a turn",
        "Both drives show the swing of α1 alone, lifted by the steady angle of the equal-speed "
        "pair.",
        drive_over_a_turn,
    ),
    "14": (
        "Influence of K",
        "Left of K = 0.2652 the ring grooves have no inside wall, from 0.5885 (20 balls) on "
        "the cycloid grooves undercut. Scales are cut: at the left end the torque slips.",
        influence_of_short_amplitude,
    ),
    "15": (
        "Influence of the preload",
        "The gap in (b) is not constant, as the paper has it; it shrinks like the angles "
        "themselves. Scales are cut where the torque slips.",
        influence_of_preload,
    ),
    "16": (
        "Influence of r0",
        "All angles come down to that of the ring grooves, which r0 changes little.",
        influence_of_rolling_circle,
    ),
    "17": (
        "Influence of β",
        "The contact angle of the deceleration pair; that of the ring grooves stays at 45 deg. "
        "Scales are cut where the torque slips.",
        influence_of_contact_angle,
    ),
    "18": (
        "Influence of the torque",
        "Nearly straight while nothing has parted. Scales are cut where the torque slips.",
        influence_of_torque,
    ),
    "20": (
        "The prototype",
        "Calculated with straight tracks, because the prototype's grooves undercut (smallest "
        "radius 0.20 mm against the 1.41 mm that its walls need) and its ring grooves "
        "(e = 0.48 mm against 1.77 mm) have no inside wall: with their true curvature there is "
        "no drive to solve. The largest angle at 400 N and 5 N m, 735 arcsec, is off the scale. "
        "In (d) stands all that the paper's text says of its measurement; the curves of its "
        "Figure 20 are not given as numbers. What follows from it, given which calculated curve, "
        "stands in [the experiment](experiment.md).",
        prototype,
    ),
}


def draw(out: Path) -> None:
    """Draw every figure as SVG, the same file for the same numbers."""
    import matplotlib

    out.mkdir(parents=True, exist_ok=True)
    with matplotlib.rc_context(STYLE):
        for number, (_, _, make) in FIGURES.items():
            path = out / f"fig{number}.svg"
            make().savefig(path, metadata={"Date": None, "Creator": None})


# --- page ---------------------------------------------------------------------------------

HEAD = """\
# The claims of the 2017 paper

`python docs/claims/figures.py` writes this page from numbers that the package computes;
`python docs/claims/figures.py --check` tells whether it is up to date.

Each row of the table is a statement of the 2017 paper (DOI 10.1177/1687814017734112) on its
Figures 7 to 20. {holds} of {all} statements hold, {where} hold in part, {fails} do not hold.
"Unexplained" means that the reason for a difference is not known.

Base case unless stated otherwise: 5 N m, preload 600 N, K = 0.5, r0 = 4 mm, 20 deceleration balls,
14 ring-groove balls or 16 cross-slide balls, balls of 1.5 mm radius, contact angles 45 deg,
conformity 1.08, Rw = RS = 40 mm. The paper names no material; this model takes bearing steel.

Words of the table:

- α1, α2, α3: elastic angles of the deceleration, ring-groove and cross-slide pair; α_dmax: largest
  angle over a turn of the drive with ring grooves;
- FTMP: meshing points that the torque loads; NFTMP: meshing points that it unloads;
- "ever slower", "ever faster": every slope between neighbouring points of a curve is larger than
  the slope before it;
- a torque slips if the preload cannot hold it. Curves end there, or earlier where the displacements
  are no longer small beside the balls.

Trends are tested with 13, 20, 27 and 34 balls.

## All claims

| Figure | The paper says | Verdict | This model | The paper | Why |
|---|---|---|---|---|---|
"""


def number(value: float) -> str:
    """Five digits; two, or none, of what is almost nothing, whose digits are rounding."""
    if abs(value) < 1e-12:
        return "0"
    return f"{value:.2g}" if abs(value) < 1e-6 else f"{value:.5g}"


def row(claim: Claim) -> str:
    def cell(numbers: dict[str, float]) -> str:
        return "<br>".join(f"{name}: {number(value)}" for name, value in numbers.items())

    cells = (
        claim.figure,
        claim.says,
        f"**{claim.verdict}**",
        cell(dict(claim.model)),
        cell(dict(claim.paper)),
        claim.why,
    )
    return "| " + " | ".join(cells) + " |"


def page() -> str:
    """The text of the page."""
    rows = claims()
    holds = sum(claim.verdict == HOLDS for claim in rows)
    fails = sum(claim.verdict == FAILS for claim in rows)
    where = len(rows) - holds - fails
    head = HEAD.format(all=len(rows), holds=holds, where=where, fails=fails)
    parts = [head + "\n".join(map(row, rows)) + "\n", "## Figure by figure\n"]
    for key, (title, text, _) in FIGURES.items():
        parts.append(f"### Figure {key}: {title}\n\n{text}\n")
        parts.append(f"<!-- picture: claims/fig{key}.svg | {title} -->\n")
    return "\n".join(parts)


def main() -> int:
    parser = argparse.ArgumentParser(description="Draw the figures and write the page of claims.")
    parser.add_argument("--draw", type=Path, metavar="DIR", help="only draw, into this folder")
    parser.add_argument("--check", action="store_true", help="only compare the page, write nothing")
    options = parser.parse_args()
    if options.draw:
        draw(options.draw)
        return 0
    text = page()
    if options.check:
        if PAGE.exists() and PAGE.read_text(encoding="utf-8") == text:
            return 0
        print(f"{PAGE} is not up to date: run python {Path(__file__).name}", file=sys.stderr)
        return 1
    PAGE.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
