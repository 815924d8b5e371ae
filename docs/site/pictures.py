"""The pictures of the site, drawn by the program, and the gallery that shows them.

Pictures of the workbench need Chromium and Playwright. Where one of them is missing the build says
so, and the gallery shows the picture that the repository keeps.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import cbpt

TOP = Path(__file__).parents[2]
sys.path.insert(0, str(TOP / "docs" / "claims"))

# Name -> caption, and the command that draws it.
COMMANDS: dict[str, tuple[str, tuple[str, ...]]] = {
    "tutorial_first": (
        "Readings and model against the torque, and the residuals below",
        ("compare", "examples/tutorial/drive.toml", "examples/tutorial/first.csv", "--plot"),
    ),
    "diagnosis": (
        "Readings, the model before and after, the residuals and the error",
        ("diagnose", "examples/campaign.toml", "examples/campaign.csv", "--plot"),
    ),
    "isolability": (
        "Which effects a planned campaign could tell apart",
        ("isolability", "examples/campaign.toml", "examples/plan.toml", "--plot"),
    ),
    "tolerance": (
        "The elastic angle within the tolerances, and the share of each number",
        ("tolerance", "examples/toleranced.toml", "--plot"),
    ),
}
SCREENSHOTS = {
    "before": "The answer, and readings against the drive as stated",
    "after": "The same with the missing effect switched on",
    "missing": "Candidates: what could be missing",
    "where": "Where the model fails",
    "ladder": "The error after each step",
    "next": "What to measure next",
    "tell": "What these runs can detect and tell apart",
    "drive": "The drive to scale",
    "own_dark": "An effect of your own, in dark colours",
    "phone": "The page on a phone",
}
ROW = re.compile(r"^\| (\d\.\d) to (\d\.\d) \| (\d+) \| (\S+) \| (\S+) \| (\S+) to (\S+) \|$", re.M)


def probabilities() -> list[tuple[float, ...]]:
    """The trial's table of probabilities: from, to, sets, stated, right, low, high."""
    page = TOP / "docs" / "explanation" / "trial.md"
    found = ROW.findall(page.read_text(encoding="utf-8"))
    if not found:
        raise SystemExit(f"{page}: no table of probabilities found")
    return [tuple(float(value) for value in row) for row in found]


def draw_trial(path: Path) -> None:
    """Stated probability against the share that was right."""
    from matplotlib.figure import Figure

    rows = probabilities()
    stated, right = [r[3] for r in rows], [r[4] for r in rows]
    below = [max(r[4] - r[5], 0.0) for r in rows]
    above = [max(r[6] - r[4], 0.0) for r in rows]
    figure = Figure(figsize=(5, 6), layout="constrained")
    axes, counts = figure.subplots(2, 1, height_ratios=(3, 1), sharex=True)
    axes.plot([0, 1], [0, 1], color="0.7", linewidth=1, label="as stated")
    axes.errorbar(stated, right, yerr=[below, above], fmt="o", capsize=3, label="trial, 95 %")
    axes.set_ylabel("share that was right")
    # Points at the ends are whole.
    axes.set_ylim(-0.03, 1.03)
    axes.legend(loc="upper left", frameon=False)
    counts.bar([(r[0] + r[1]) / 2 for r in rows], [r[2] for r in rows], width=0.09)
    counts.set_ylabel("campaigns")
    counts.set_xlabel("stated probability")
    counts.set_xlim(0, 1.02)
    figure.savefig(path)


def draw(folder: Path) -> None:
    """Draw what matplotlib draws."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    claims = subprocess.Popen(
        [sys.executable, str(TOP / "docs/claims/figures.py"), "--draw", str(folder / "claims")]
    )
    for name, (_, command) in COMMANDS.items():
        subprocess.run(
            [sys.executable, "-m", "cbpt.cli.main", *command, str(folder / f"{name}.svg")],
            check=True,
            stdout=subprocess.DEVNULL,
            cwd=TOP,
        )
    draw_trial(folder / "trial.svg")
    # The command prints and Python draws.
    case = TOP / "examples" / "base_case.toml"
    cbpt.friction(case).plot(str(folder / "window.svg"))
    ranges = {"load.preload_N": [200, 4000], "deceleration.contact_angle_deg": [35, 60]}
    front = cbpt.pareto_front(case, {"free": ranges, "limits": {"preload": "continuous"}}, points=5)
    front.plot(str(folder / "front.svg"))
    if claims.wait():
        raise SystemExit("the figures of the claims were not drawn")


def screenshots(folder: Path) -> None:
    """Take pictures of the page; where there is no browser for it, say so."""
    try:
        import PIL  # noqa: F401
        import playwright  # noqa: F401
    except ImportError as error:
        print(f"        no pictures of the page: {error}")
        return
    if not shutil.which("chromium"):
        print("        no pictures of the page: there is no Chromium (`make setup-browser`)")
        return
    script = TOP / "docs" / "site" / "screenshots.py"
    subprocess.run(
        [sys.executable, str(script), str(folder)], check=True, stdout=subprocess.DEVNULL
    )


def write(source: Path, drawn: Path, keep: bool) -> None:
    """Write the gallery, and its pictures unless those of the last build are kept."""
    import figures

    if not (keep and drawn.is_dir()):
        draw(drawn)
        screenshots(drawn / "page")
    shutil.copytree(drawn, source / "pictures")
    lines = ["# Gallery", "", "The build of this site draws every picture with the program.", ""]
    lines += ["## Answers as pictures", ""]
    for name, (caption, command) in COMMANDS.items():
        lines += [f"### cbpt {command[0]}", "", f"{caption}.", ""]
        lines += [f"![{caption}](pictures/{name}.svg)", ""]
    lines += ["## The page", ""]
    if (drawn / "page").is_dir():
        for name, caption in SCREENSHOTS.items():
            lines += [f"{caption}:", "", f"![{caption}](pictures/page/{name}.png)", ""]
    else:
        lines += ["This site was built without a browser, so there is one picture of the page."]
        lines += ["", "![The page](img/page.png)", ""]
    lines += ["## The trial", "", "Stated probability against the share that was right"]
    lines += ["([the trial](explanation/trial.md)).", ""]
    lines += ["![Stated probability against the share that was right](pictures/trial.svg)", ""]
    lines += ["## Figures of the 2017 paper, computed by this model", ""]
    lines += ["What the paper says of each stands in [the claims](explanation/claims.md).", ""]
    for number, (title, _, _) in figures.FIGURES.items():
        lines += [f"{title}:", "", f"![{title}](pictures/claims/fig{number}.svg)", ""]
    (source / "gallery.md").write_text("\n".join(lines), encoding="utf-8")
