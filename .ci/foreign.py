"""`python .ci/foreign.py WHEEL ...`: runs wheels for another machine or C library on Debian 12.

- aarch64, glibc: Debian's Python for arm64, unpacked into a folder, under qemu-user;
- x86_64, musl: CPython of Debian's sources, built against Debian's musl into a folder.

Needs apt-get, qemu-user and musl-tools; nothing is installed. What has no interpreter is told.
"""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from wheels import DIAGNOSIS, FOUND

TOP = Path(__file__).resolve().parents[1]
SOURCES = Path("/etc/apt/sources.list.d/debian.sources")
PYTHON = "python3.11"  # of Debian 12
TRIPLET = "x86_64-linux-musl"
ARM_PACKAGES = [
    *(PYTHON, f"{PYTHON}-minimal", f"lib{PYTHON}-minimal", f"lib{PYTHON}-stdlib"),
    *("libc6", "libgcc-s1", "libstdc++6", "zlib1g", "libexpat1", "libffi8", "libssl3"),
]
MUSL_SOURCES = ["zlib", "libffi", PYTHON]  # in the order in which they are built
LESS = ["--disable-docs", "--disable-exec-static-tramp"]  # what needs the headers of Linux
# musl 1.2.3 knows no packed relocations (RELR), which libraries of later wheels have.
MUSL_NUMBERS = ["numpy==1.26.4", "scipy==1.12.0"]


@dataclass(frozen=True)
class Foreign:
    """A Python that runs here after all. scripts: where its commands are looked for."""

    command: Sequence[str]
    scripts: Path
    platforms: Sequence[str]
    """Wheels that pip may take for it."""
    numbers: Sequence[str] = ("numpy", "scipy")


def run(
    command: Sequence[str | Path], folder: Path = TOP, env: Mapping[str, str] | None = None
) -> str:
    """What a command prints; its own words where it fails."""
    ran = subprocess.run(
        command,
        cwd=folder,
        env={**os.environ, **(env or {})},
        capture_output=True,
        text=True,
        check=False,
    )
    if ran.returncode:
        raise SystemExit(f"{' '.join(map(str, command))}\n{ran.stdout}{ran.stderr}")
    return ran.stdout


class Apt:
    """Debian's packages of any architecture, and their sources, with lists of its own."""

    def __init__(self, folder: Path, architecture: str) -> None:
        self.folder = folder
        for name in ("lists/partial", "cache/archives/partial"):
            (folder / name).mkdir(parents=True, exist_ok=True)
        text = SOURCES.read_text().replace("Types: deb\n", "Types: deb deb-src\n")
        (folder / "apt.sources").write_text(text)
        self.options = [
            *("-qq", "-o", f"APT::Architecture={architecture}"),
            *("-o", f"APT::Architectures={architecture}", "-o", "APT::Sandbox::User=root"),
            *("-o", "Dir::Etc::SourceList=/dev/null", "-o", f"Dir::Etc::SourceParts={folder}"),
            *("-o", f"Dir::State::Lists={folder}/lists", "-o", f"Dir::Cache={folder}/cache"),
        ]
        self("update")

    def __call__(self, *words: str) -> None:
        run(["apt-get", *self.options, *words], self.folder)


def arm_python(folder: Path) -> Foreign:
    """Debian's Python for arm64 under qemu."""
    root = folder / "root"
    python = root / "usr/bin" / PYTHON
    if not python.exists():
        Apt(folder, "arm64")("download", *ARM_PACKAGES)
        for package in folder.glob("*.deb"):
            run(["dpkg", "-x", package, root])
    platforms = ["manylinux2014_aarch64", "manylinux_2_27_aarch64", "manylinux_2_28_aarch64"]
    command = ["qemu-aarch64", "-L", str(root), str(python)]
    return Foreign(command, root / "usr/local/bin", platforms)


def musl_python(folder: Path) -> Foreign:
    """CPython against musl. It needs zlib for archives, and libffi for the ctypes of SciPy."""
    made = folder / "made"
    python = made / "bin" / PYTHON
    if not python.exists():
        release = platform.freedesktop_os_release()["VERSION_CODENAME"]  # not its updates
        names = [f"{name}/{release}" for name in MUSL_SOURCES]
        Apt(folder, "amd64")("source", "--download-only", *names)
        compiler = folder / "cc"  # musl-gcc says that it is for glibc
        answer = f'case "$*" in *-print-multiarch*) echo {TRIPLET};; *) exec musl-gcc "$@";; esac'
        compiler.write_text(f"#!/bin/sh\n{answer}\n")
        compiler.chmod(0o755)
        own = [f"--build={TRIPLET}"]
        options = {
            "zlib": ["--static"],
            "libffi": [*own, "--disable-shared", "--disable-multi-os-directory", *LESS],
            PYTHON: [*own, "--without-ensurepip", "--disable-test-modules"],
        }
        env = {"CC": str(compiler), "CFLAGS": "-O1 -fPIC"}
        env |= {"CPPFLAGS": f"-I{made}/include", "LDFLAGS": f"-L{made}/lib"}
        for name in MUSL_SOURCES:
            _built(folder, name, [*options[name], f"--prefix={made}"], env)
    platforms = ["musllinux_1_2_x86_64", "musllinux_1_1_x86_64"]
    return Foreign([str(python)], made / "bin", platforms, MUSL_NUMBERS)


def _built(folder: Path, name: str, options: Sequence[str], env: Mapping[str, str]) -> None:
    (packed,) = folder.glob(f"{name}_*.orig.tar.*")
    unpacked = folder / name
    unpacked.mkdir()
    run(["tar", "xf", packed, "-C", unpacked, "--strip-components=1"])
    run(["./configure", *options], unpacked, env)
    run(["make", "-s"], unpacked)
    run(["make", "-s", "install"], unpacked)


def try_out(wheel: Path, foreign: Foreign, folder: Path) -> str:
    """Runs the smoke test and a diagnosis with a wheel; says with what."""
    site = folder / "site"
    shutil.rmtree(site, ignore_errors=True)
    line = [sys.executable, "-m", "pip", "install", "-q", "--no-deps", "--only-binary", ":all:"]
    line += ["--target", str(site), "--python-version", PYTHON.removeprefix("python")]
    for each in foreign.platforms:
        line += ["--platform", each]
    run([*line, str(wheel), *foreign.numbers, "threadpoolctl"])
    foreign.scripts.mkdir(parents=True, exist_ok=True)
    script = foreign.scripts / "cbpt"
    script.write_text(f'#!/bin/sh\nexec {" ".join(foreign.command)} -m cbpt.cli.main "$@"\n')
    script.chmod(0o755)
    path = {"PYTHONPATH": str(site)}
    run([*foreign.command, "examples/smoke.py"], env=path)
    answer = run([*foreign.command, *DIAGNOSIS], env=path)
    if FOUND not in answer:
        raise SystemExit(f"{wheel.name}: another answer than “{FOUND}”:\n{answer}")
    show = "import sys, numpy, scipy; print(sys.version.split()[0], sys.implementation._multiarch,"
    show += " 'numpy', numpy.__version__, 'scipy', scipy.__version__)"
    return run([*foreign.command, "-c", show], env=path).strip()


def main() -> int:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("wheels", nargs="+", type=Path)
    parser.add_argument("--folder", type=Path, default=TOP / "out/foreign", help="of interpreters")
    options = parser.parse_args()
    for wheel in options.wheels:
        if "manylinux" in wheel.name and wheel.stem.endswith("aarch64"):
            name, needs, make = "aarch64", "qemu-aarch64", arm_python
        elif "musllinux" in wheel.name and wheel.stem.endswith("x86_64"):
            name, needs, make = "musl", "musl-gcc", musl_python
        else:
            print(f"{wheel.name}: no interpreter for it")
            continue
        if not (shutil.which(needs) and shutil.which("apt-get") and SOURCES.exists()):
            print(f"{wheel.name}: not run, as it needs Debian and {needs}")
            continue
        folder = options.folder.absolute() / name
        folder.mkdir(parents=True, exist_ok=True)
        told = try_out(wheel.absolute(), make(folder), folder)
        print(f"{wheel.name}: runs under Python {told}", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
