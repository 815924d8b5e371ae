"""`make wheels`: the wheels for Linux and the source distribution, run where this machine can.

- `build`: the wheels by maturin, linked by zig against the C library that each names;
- `check_sdist`: the source distribution holds what a packager needs;
- `try_out`: a wheel in an environment of its own, with the oldest and the newest numpy and scipy.

maturin refuses a wheel that needs a newer C library, or another library, than its name promises.
"""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import subprocess
import sys
import tarfile
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

TOP = Path(__file__).resolve().parents[1]
TARGETS = {  # of Rust, and what pip is told
    "x86_64-unknown-linux-gnu": "manylinux2014",
    "aarch64-unknown-linux-gnu": "manylinux2014",
    "x86_64-unknown-linux-musl": "musllinux_1_2",
    "aarch64-unknown-linux-musl": "musllinux_1_2",
}
NEWEST = ["numpy", "scipy"]
# By Python: the first releases within pyproject.toml that have wheels for it.
OLDEST = {
    "3.11": ["numpy==1.26.0", "scipy==1.12.0"],
    "3.12": ["numpy==1.26.0", "scipy==1.12.0"],
    "3.13": ["numpy==2.1.0", "scipy==1.14.1"],
}
IN_SDIST = ["README.md", "LICENSE", "CHANGELOG.md", "docs/install.md", "examples/smoke.py"]
IN_SDIST += ["tests/conftest.py", "crates/cbpt-core/Cargo.toml", "Cargo.lock"]
DIAGNOSIS = ["-m", "cbpt.cli.main", "diagnose", "examples/campaign.toml", "examples/campaign.csv"]
FOUND = "One of compliance of the eccentric bearing or torsion of the output shaft is needed"


def told(since: float, line: str) -> None:
    print(f"{time.perf_counter() - since:6.0f} s  {line}", flush=True)


def run(command: Sequence[str | Path]) -> str:
    """What a command prints; its own words where it fails."""
    # maturin asks the first Python of the path for zig.
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    env = {**os.environ, "PATH": path}
    ran = subprocess.run(command, cwd=TOP, env=env, capture_output=True, text=True, check=False)
    if ran.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}\n{ran.stdout}{ran.stderr}")
    return ran.stdout


def build(maturin: str, target: str, out: Path) -> Path:
    """The wheel for a target of Rust."""
    run(["rustup", "target", "add", target])
    line = [maturin, "build", "--release", "--locked", "--zig", "--target", target]
    line += ["--compatibility", TARGETS[target], "--out", str(out)]
    run(line)
    system = "musllinux" if target.endswith("musl") else "manylinux"
    (wheel,) = out.glob(f"cbpt-*-abi3-{system}*_{target.split('-')[0]}.whl")
    return wheel


def check_sdist(maturin: str, out: Path) -> Path:
    """The source distribution."""
    run([maturin, "sdist", "--out", str(out)])
    (sdist,) = out.glob("cbpt-*.tar.gz")
    with tarfile.open(sdist) as archive:
        names = {name.split("/", 1)[1] for name in archive.getnames() if "/" in name}
    if missing := [name for name in IN_SDIST if name not in names]:
        raise SystemExit(f"{sdist.name} lacks {', '.join(missing)}")
    return sdist


def pythons() -> dict[str, str]:
    """Interpreters of this machine that can be started, by version."""
    found = {}
    pyenv = Path.home() / ".pyenv/versions"
    for version in OLDEST:
        kept = sorted(str(path) for path in pyenv.glob(f"{version}.*/bin/python"))
        for name in [f"python{version}", *kept]:
            path = shutil.which(name)
            if path and not subprocess.run([path, "--version"], capture_output=True).returncode:
                found.setdefault(version, path)
    return found


def try_out(wheel: Path, python: str, numbers: list[str]) -> str:
    """Installs and runs a wheel; says with what."""
    with tempfile.TemporaryDirectory() as folder:
        run([python, "-m", "venv", folder])
        inside = str(Path(folder, "bin", "python"))
        run([inside, "-m", "pip", "install", "-q", "--only-binary", ":all:", str(wheel), *numbers])
        run([inside, "examples/smoke.py"])
        answer = run([inside, *DIAGNOSIS])
        if FOUND not in answer:
            raise SystemExit(f"{wheel.name}: another answer than “{FOUND}”:\n{answer}")
        show = "import sys, numpy, scipy; print(*sys.version_info[:2], sep='.', end=': ');"
        show += "print('numpy', numpy.__version__, 'scipy', scipy.__version__)"
        return run([inside, "-c", show]).strip()


def runs_here(target: str) -> bool:
    return target == f"{platform.machine()}-unknown-linux-gnu"


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--out", type=Path, default=TOP / "dist", help="folder of the wheels")
    parser.add_argument("--target", action="append", choices=TARGETS, help="not all of them")
    options = parser.parse_args()
    maturin = shutil.which("maturin", path=str(Path(sys.executable).parent)) or "maturin"
    out: Path = options.out.absolute()
    shutil.rmtree(out, ignore_errors=True)
    began = time.perf_counter()
    told(began, check_sdist(maturin, out).name)
    for target in options.target or TARGETS:
        wheel = build(maturin, target, out)
        told(began, f"{wheel.name}, {wheel.stat().st_size / 1e6:.1f} MB")
        if not runs_here(target):
            told(
                began,
                "  for another machine or C library: built and audited; .ci/foreign.py may run it",
            )
            continue
        for version, python in pythons().items():
            for numbers in (OLDEST[version], NEWEST):
                told(began, f"  runs under Python {try_out(wheel, python, numbers)}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
