"""Speed beside what others would write, in one run on one thread; ratios first.

    python benches/peers.py [--cases N] [--rounds N] [--json FILE]

The deceleration pair of the base case (20 balls, 40 contacts) at one input angle, N random loads of
0.5 to 5 N m and 300 to 900 N; then loads at 40 to 99.9 % of what holds, a new geometry for every
load, two threads and starting times. Every scaled residual is checked to be at most 1e-11.

Peers take turns with CBPT in every round; a time is the processor's, the least of all rounds, which
is what a shared machine disturbs least. "From the answer" starts a peer at the solution, so that it
makes one pass over the contacts and no more: no start can do better, CBPT's own included.

The peers need a C compiler and `pip install --group bench`; what is missing is said, not guessed.
"""

from __future__ import annotations

import argparse
import ctypes
import json
import os
import platform
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

os.environ |= {"RAYON_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import fsolve

import cbpt

Floats = NDArray[np.float64]
TOP = Path(__file__).parents[1]
INPUT_ANGLE_RAD = 0.1
SIN = np.sqrt(0.5)


# --- what is run --------------------------------------------------------------------------


def library() -> ctypes.CDLL:
    """`benches/speed`, built: CBPT without Python around it, and the levenberg-marquardt crate."""
    manifest = TOP / "benches" / "speed" / "Cargo.toml"
    subprocess.run(
        ["cargo", "build", "--release", "--quiet", "--manifest-path", str(manifest)], check=True
    )
    target = Path(os.environ.get("CARGO_TARGET_DIR", manifest.parent / "target"))
    name = {"darwin": "libspeed.dylib", "win32": "speed.dll"}.get(sys.platform, "libspeed.so")
    found = ctypes.CDLL(str(target / "release" / name))
    found.pair_holding_arm_m.restype = ctypes.c_double
    return found


def flags() -> set[str]:
    """Instruction sets of this processor, where the system says."""
    info = Path("/proc/cpuinfo")
    return set(info.read_text().split()) if info.exists() else set()


def c_kernel(width: int, folder: str) -> ctypes.CDLL | str:
    """The kernel by hand, or why it is missing."""
    compiler = shutil.which("cc")
    needed = {4: {"avx2", "fma"}, 8: {"avx512f", "avx512dq"}}[width]
    if compiler is None:
        return "no C compiler"
    if not needed <= flags():
        return "this processor has no " + " ".join(sorted(needed - flags()))
    out = Path(folder) / f"kernel{width}.so"
    switches = [f"-m{flag}" for flag in sorted(needed)]
    source = TOP / "benches" / "speed" / "kernel.c"
    command = [compiler, "-O3", "-ffast-math", "-funroll-loops", "-shared", "-fPIC", *switches]
    subprocess.run([*command, f"-DWIDTH={width}", str(source), "-o", str(out), "-lm"], check=True)
    return ctypes.CDLL(str(out))


def pointer(values: Floats) -> ctypes.c_void_p:
    """Where an array lies."""
    return ctypes.c_void_p(values.ctypes.data)


class Pair:
    """The contacts as peers see them: force (u d + v alpha)^1.5, u and v the levers times k^0.4."""

    def __init__(self, lib: ctypes.CDLL) -> None:
        arm, stiffness = np.zeros(64), np.zeros(64)
        angle = ctypes.c_double(INPUT_ANGLE_RAD)
        count = lib.pair_contacts(angle, pointer(arm), pointer(stiffness))
        self.u = stiffness[:count] ** 0.4 * SIN
        self.v = self.u * arm[:count]
        self.arm_m = float(arm.max())
        self.hold_m = float(lib.pair_holding_arm_m(angle))
        self.axial = float((self.u**2.5).sum())
        self.turning = float((self.v**2 * np.sqrt(self.u)).sum())

    def start(self, torque: Floats, preload: Floats) -> tuple[Floats, Floats]:
        """The response at rest."""
        third = np.cbrt(preload / self.axial)
        return third**2, torque / (1.5 * self.turning * third)

    def residual(
        self, torque: Floats, preload: Floats, approach: Floats, rotation: Floats
    ) -> float:
        y = np.maximum(np.outer(approach, self.u) + np.outer(rotation, self.v), 0.0) ** 1.5
        axial = np.abs(y @ self.u / preload - 1)
        return float(max(axial.max(), np.abs((y @ self.v - torque) / preload / self.arm_m).max()))


def with_fsolve(pair: Pair, torque: Floats, preload: Floats) -> Floats:
    def equations(x: Floats, m0: float, n_z: float) -> list[float]:
        y = np.maximum(pair.u * (x[0] * 1e-6) + pair.v * (x[1] * 1e-6), 0.0)
        force = y * np.sqrt(y)
        return [force @ pair.u / n_z - 1, (force @ pair.v - m0) / n_z]

    starts = np.column_stack(pair.start(torque, preload)) * 1e6
    return np.array(
        [
            fsolve(equations, start, args=(m0, n_z), xtol=1e-10)[1] * 1e-6
            for start, m0, n_z in zip(starts, torque, preload, strict=True)
        ]
    )


def with_numpy(pair: Pair, torque: Floats, preload: Floats) -> tuple[Floats, Floats]:
    """Newton on blocks of cases that fit the caches."""
    approach, rotation = pair.start(torque, preload)
    levers = np.array([pair.u**2, pair.u * pair.v, pair.v**2]).T
    for block in np.split(np.arange(len(torque)), range(512, len(torque), 512)):
        d, a, n, m = approach[block], rotation[block], preload[block], torque[block]
        for _ in range(30):
            y = np.multiply.outer(d, pair.u)
            y += np.multiply.outer(a, pair.v)
            np.maximum(y, 0.0, out=y)
            np.sqrt(y, out=y)
            s00, s01, s11 = (y @ levers).T
            r0, r1 = s00 * d + s01 * a - n, s01 * d + s11 * a - m
            done = max(np.abs(r0 / n).max(), np.abs(r1 / n).max() / pair.arm_m) <= 1e-11
            factor = 2 / 3 / (s00 * s11 - s01**2)
            d, a = d - factor * (s11 * r0 - s01 * r1), a - factor * (s00 * r1 - s01 * r0)
            if done:
                break
        approach[block], rotation[block] = d, a
    return approach, rotation


def numba_kernel() -> Callable[..., int] | str:
    try:
        from numba import njit
    except ImportError:
        return "numba is not installed"

    def newton(
        levers: tuple[Floats, Floats],
        scales: tuple[float, float, float],
        given: bool,
        loads: tuple[Floats, Floats],
        states: tuple[Floats, Floats],
        residual: Floats,
    ) -> int:
        u, v = levers
        axial, turning, arm = scales
        torque, preload = loads
        approach, rotation = states
        for c in range(len(torque)):
            n, m = preload[c], torque[c]
            if given:
                d, a = approach[c], rotation[c]
            else:
                third = (n / axial) ** (1 / 3)
                d, a = third * third, m / (1.5 * turning * third)
            left = np.inf
            for _ in range(50):
                s00 = s01 = s11 = 0.0
                for i in range(len(u)):
                    weight = np.sqrt(max(u[i] * d + v[i] * a, 0.0))
                    s00 += weight * u[i] * u[i]
                    s01 += weight * u[i] * v[i]
                    s11 += weight * v[i] * v[i]
                r0, r1 = s00 * d + s01 * a - n, s01 * d + s11 * a - m
                left = max(abs(r0) / n, abs(r1) / (n * arm))
                factor = 2 / 3 / (s00 * s11 - s01 * s01)
                d -= factor * (s11 * r0 - s01 * r1)
                a -= factor * (s00 * r1 - s01 * r0)
                if left <= 1e-11:
                    break
            approach[c], rotation[c], residual[c] = d, a, left
        return 0

    compiled: Callable[..., int] = njit(fastmath=True)(newton)
    return compiled


# --- timing -------------------------------------------------------------------------------


def least(rounds: int, works: dict[str, tuple[int, Callable[[], object]]]) -> dict[str, float]:
    """Least time a case of each, in microseconds; all take turns in every round.

    What the processor spends, so that other jobs do not count; where a work returns seconds, those.
    """
    times = dict.fromkeys(works, np.inf)
    for _ in range(rounds):
        for name, (cases, work) in works.items():
            start = time.process_time()
            told = work()
            taken = told if isinstance(told, float) else time.process_time() - start
            times[name] = min(times[name], taken / cases * 1e6)
    return times


def starting(command: list[str], rounds: int = 9) -> float:
    """Least time of a process, ms."""
    times = []
    for _ in range(rounds):
        start = time.perf_counter()
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        times.append(time.perf_counter() - start)
    return min(times) * 1e3


def import_beyond_numpy(rounds: int = 9) -> float:
    """Least time of `import cbpt` once numpy is there, ms."""
    code = (
        "import numpy, time; s = time.perf_counter(); import cbpt; print(time.perf_counter() - s)"
    )
    runs = (subprocess.check_output([sys.executable, "-c", code]) for _ in range(rounds))
    return min(float(run) for run in runs) * 1e3


# --- what is timed ------------------------------------------------------------------------

Work = Callable[[], object]
Works = dict[str, tuple[int, Work]]
"""By name, how many cases it solves and what does it."""


def size(number: int) -> ctypes.c_size_t:
    """A count as C has it."""
    return ctypes.c_size_t(number)


@dataclass(frozen=True)
class Loads:
    """Random loads of the base case's pair, some of them near what holds."""

    torque: Floats
    preload: Floats
    hard: Floats

    @classmethod
    def drawn(cls, cases: int, pair: Pair, rng: np.random.Generator) -> Loads:
        torque, preload = rng.uniform(0.5, 5, cases), rng.uniform(300, 900, cases)
        return cls(torque, preload, rng.uniform(0.4, 0.999, cases) * preload * pair.hold_m)

    def __len__(self) -> int:
        return len(self.torque)


@dataclass(frozen=True)
class OnePair:
    """CBPT and its peers on one pair; the solution by NumPy is what the others are held against."""

    lib: ctypes.CDLL
    pair: Pair
    loads: Loads
    solved: tuple[Floats, Floats]

    @classmethod
    def of(cls, lib: ctypes.CDLL, pair: Pair, loads: Loads) -> OnePair:
        solved = with_numpy(pair, loads.torque, loads.preload)
        assert pair.residual(loads.torque, loads.preload, *solved) <= 1e-11
        return cls(lib, pair, loads, solved)

    def by(self, name: str, torque: Floats, rotation: Floats) -> Work:
        """A routine of the library, as many loads as the torque has."""
        function, residual = getattr(self.lib, name), np.zeros(len(torque))
        angle = ctypes.c_double(INPUT_ANGLE_RAD)

        def work() -> None:
            columns = map(pointer, (torque, self.loads.preload, rotation, residual))
            solved = function(angle, size(len(torque)), *columns)
            assert solved == len(torque) and residual.max() <= 1e-11, name

        return work

    def works(self) -> Works:
        """All but the kernels."""
        all_, few = len(self.loads), min(len(self.loads), 2_000)
        torque, preload, out = self.loads.torque, self.loads.preload, np.zeros(all_)
        first = slice(few // 4)
        return {
            "cbpt": (all_, self.by("cbpt_pair", torque, out)),
            "cbpt, 40 to 99.9 % of hold": (all_, self.by("cbpt_pair", self.loads.hard, out)),
            "cbpt, scalar solver": (few, self.by("cbpt_pair_scalar", torque[:few], out)),
            "levenberg-marquardt crate": (
                few,
                self.by("levenberg_marquardt_pair", torque[:few], out),
            ),
            "fsolve": (few // 4, lambda: with_fsolve(self.pair, torque[first], preload[first])),
            "numpy, batched Newton": (all_, lambda: with_numpy(self.pair, torque, preload)),
        }

    def agreement(self) -> float:
        """Largest relative difference of CBPT's angles and NumPy's."""
        rotation = np.zeros(len(self.loads))
        self.by("cbpt_pair", self.loads.torque, rotation)()
        found = float(np.abs(rotation / self.solved[1] - 1).max())
        assert found < 1e-10
        return found

    def kernels(self, folder: str) -> tuple[Works, dict[str, str]]:
        """Newton by numba and in C, from rest and from the answer; and why some are missing."""
        kernels = {
            "numba": numba_kernel(),
            "C AVX2": c_kernel(4, folder),
            "C AVX-512": c_kernel(8, folder),
        }
        works: Works = {}
        for name, kernel in kernels.items():
            if isinstance(kernel, str):
                continue
            by = self.in_c if isinstance(kernel, ctypes.CDLL) else self.by_numba
            for given in (False, True):
                work = by(kernel, given)
                work()  # compiled, and checked
                works[name + (", from the answer" if given else "")] = (len(self.loads), work)
        return works, {name: why for name, why in kernels.items() if isinstance(why, str)}

    def states(self, given: bool) -> tuple[Floats, Floats]:
        """Where a kernel starts and leaves its answer."""
        return self.solved if given else (np.zeros(len(self.loads)), np.zeros(len(self.loads)))

    def by_numba(self, kernel: Any, given: bool) -> Work:
        pair, residual, states = self.pair, np.zeros(len(self.loads)), self.states(given)
        scales = (pair.axial, pair.turning, pair.arm_m)
        loads = (self.loads.torque, self.loads.preload)

        def work() -> None:
            kernel((pair.u, pair.v), scales, given, loads, states, residual)
            assert residual.max() <= 1e-11, "numba"

        return work

    def in_c(self, kernel: Any, given: bool) -> Work:
        pair, residual, states = self.pair, np.zeros(len(self.loads)), self.states(given)

        def work() -> None:
            kernel.newton(
                *map(size, (len(self.loads), len(pair.u))),
                *map(pointer, (pair.u, pair.v)),
                ctypes.c_double(pair.arm_m),
                ctypes.c_int(given),
                *map(pointer, (self.loads.torque, self.loads.preload, *states, residual)),
            )
            assert residual.max() <= 1e-11, "C"

        return work


@dataclass(frozen=True)
class BothPairs:
    """The whole drive, on one thread and on two; loads: torque and preload."""

    lib: ctypes.CDLL
    loads: tuple[Floats, Floats]
    angles: Floats

    @classmethod
    def of(cls, lib: ctypes.CDLL, loads: Loads) -> BothPairs:
        # Long enough for threads to start and for the curve, which one of them makes, not to count.
        torque, preload = np.tile(loads.torque, 10), np.tile(loads.preload, 10)
        return cls(lib, (torque, preload), np.zeros(len(torque)))

    def drive(self, threads: int, by_clock: bool) -> Work:
        """All loads; by the clock, or (None) by the processor's time."""
        seconds, count = np.zeros(1), len(self.angles)

        def work() -> float | None:
            columns = map(pointer, (*self.loads, self.angles, seconds))
            assert self.lib.cbpt_drive(size(threads), size(count), *columns) == count
            return float(seconds[0]) if by_clock else None

        return work

    def apart(self) -> float:
        """Two sweeps that share nothing, at once: what the machine lets two do."""
        half, ends = len(self.angles) // 2, np.zeros(2)

        def one(place: int) -> None:
            mine = slice(place * half, (place + 1) * half)
            columns = (*(x[mine] for x in (*self.loads, self.angles)), ends[place:])
            assert self.lib.cbpt_drive(size(1), size(half), *map(pointer, columns)) == half

        threads = [threading.Thread(target=one, args=(place,)) for place in (0, 1)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        return float(ends.max())

    def works(self) -> Works:
        many = len(self.angles)
        return {
            "cbpt, both pairs, 1 thread": (many, self.drive(1, True)),
            "cbpt, both pairs, 2 threads": (many, self.drive(2, True)),
            "cbpt, both pairs, two halves apart at once": (many, self.apart),
            "cbpt, both pairs, processor time of one": (many, self.drive(1, False)),
            "cbpt, both pairs, processor time of two": (many, self.drive(2, False)),
        }


def geometries(lib: ctypes.CDLL, loads: Loads, rng: np.random.Generator) -> Works:
    """A new geometry for every load, and single contacts."""
    cases, count = len(loads), min(len(loads), 5_000)
    low, high = np.array([[0.35, 5e-3, 0.70, 1.05], [0.50, 7e-3, 0.87, 1.12]])
    numbers = np.ascontiguousarray(rng.uniform(low, high, (count, 4)).T)
    angles, along, stiffness = np.zeros(cases), rng.uniform(500, 900, cases), np.zeros(cases)

    def geometry() -> None:
        columns = map(pointer, (numbers, loads.torque, loads.preload, angles))
        found = lib.cbpt_new_geometry(size(1), size(count), *columns)
        assert found == count, f"{found} of {count}"

    def hertz(name: str) -> None:
        across = ctypes.c_double(50.0)
        getattr(lib, name)(size(cases), pointer(along), across, pointer(stiffness))

    return {
        "cbpt, new geometry, both pairs": (count, geometry),
        "cbpt, one Hertz stiffness": (cases, lambda: hertz("cbpt_hertz")),
        "cbpt, one Hertz stiffness alone": (cases, lambda: hertz("cbpt_hertz_scalar")),
    }


# --- the table ----------------------------------------------------------------------------


def main(cases: int, rounds: int) -> dict[str, Any]:
    """Everything timed, as plain values."""
    cases -= cases % 8
    lib, rng = library(), np.random.default_rng(0)
    pair = Pair(lib)
    loads = Loads.drawn(cases, pair, rng)
    one, paper = OnePair.of(lib, pair, loads), cbpt.Drive.from_toml(cbpt.example_case())
    agreement = one.agreement()
    with tempfile.TemporaryDirectory() as folder:
        kernels, absent = one.kernels(folder)
        works = {
            **one.works(),
            **kernels,
            **geometries(lib, loads, rng),
            **BothPairs.of(lib, loads).works(),
            "cbpt.solve_many from Python, both pairs": (
                cases,
                lambda: cbpt.solve_many(paper, loads.torque, loads.preload, 5.7),
            ),
        }
        times = least(rounds, works)
    return {
        "machine": f"{platform.processor() or platform.machine()}: {model()}",
        "widths": sorted(flags() & {"avx2", "fma", "avx512f", "avx512dq"}),
        "load": os.getloadavg()[0],
        "date": time.strftime("%Y-%m-%d"),
        "cases": cases,
        "rounds": rounds,
        "agreement": agreement,
        "absent": absent,
        "us": times,
        "ms": {
            "import cbpt beyond numpy": import_beyond_numpy(),
            **help_time(),
        },
    }


def model() -> str:
    info = Path("/proc/cpuinfo")
    lines = info.read_text().splitlines() if info.exists() else []
    return next((line.split(": ")[1] for line in lines if line.startswith("model name")), "?")


def help_time() -> dict[str, float]:
    target = Path(os.environ.get("CARGO_TARGET_DIR", TOP / "target"))
    binary = target / "release" / "cbpt"
    return {"cbpt --help, the binary": starting([str(binary), "--help"])} if binary.exists() else {}


def text(found: dict[str, Any]) -> str:
    us, ms = found["us"], found["ms"]

    def row(name: str, value: float | None, target: str, unit: str = "x") -> str:
        shown = "absent" if value is None else f"{value:.3g} {unit}"
        return f"{name:<58}{shown:>12}   {target}"

    def ratio(above: str, below: str = "cbpt") -> float | None:
        return us[above] / us[below] if above in us and below in us else None

    lines = [
        row("fsolve / cbpt", ratio("fsolve"), ">= 800"),
        row("numba / cbpt", ratio("numba"), ">= 1.5"),
        row("numba from the answer / cbpt", ratio("numba, from the answer"), "(1 pass)"),
        row("cbpt / C AVX2", ratio("cbpt", "C AVX2"), "<= 1.5"),
        row("cbpt / C AVX2 from the answer", ratio("cbpt", "C AVX2, from the answer"), "(1 pass)"),
        row("cbpt / C AVX-512", ratio("cbpt", "C AVX-512"), "<= 1.5"),
        row("numpy / cbpt", ratio("numpy, batched Newton"), ""),
        row("levenberg-marquardt crate / cbpt", ratio("levenberg-marquardt crate"), ""),
        row("scalar solver / cbpt", ratio("cbpt, scalar solver"), ""),
        row("40 to 99.9 % of hold / easy", ratio("cbpt, 40 to 99.9 % of hold"), "<= 3"),
        row(
            "1 thread / 2 threads",
            ratio("cbpt, both pairs, 1 thread", "cbpt, both pairs, 2 threads"),
            ">= 1.9",
        ),
        row(
            "1 thread / two halves that share nothing, at once",
            ratio("cbpt, both pairs, 1 thread", "cbpt, both pairs, two halves apart at once"),
            "(the machine's own)",
        ),
        row(
            "2 x processor time of one thread / of two",
            2
            * us["cbpt, both pairs, processor time of one"]
            / us["cbpt, both pairs, processor time of two"],
            "(lost to nothing but waiting)",
        ),
        row("a new geometry, both pairs", us["cbpt, new geometry, both pairs"], "<= 6", "us"),
        row("one Hertz stiffness", us["cbpt, one Hertz stiffness"] * 1e3, "<= 30", "ns"),
        *(
            row(name, value, "<= 30" if "import" in name else "<= 20", "ms")
            for name, value in ms.items()
        ),
        "",
        *(f"{name:<58}{value:>12.4f} us" for name, value in us.items()),
        *(f"{name:<58}{'absent':>12}   {why}" for name, why in found["absent"].items()),
        "",
        f"{found['machine']}; {' '.join(found['widths']) or 'widths unknown'}; load average "
        f"{found['load']:.1f}; {found['date']}",
        f"{found['cases']} loads, least of {found['rounds']} rounds in turns; angles agree to "
        f"{found['agreement']:.0e}",
    ]
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=100_000)
    parser.add_argument("--rounds", type=int, default=9)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    result = main(options.cases, options.rounds)
    print(text(result))
    if options.json:
        options.json.write_text(json.dumps(result, indent=1))
