"""Speed beside what people use today: SciPy `fsolve`, one case at a time. Ratios first.

    python benches/peers.py [--cases N]

20-ball deceleration pair of the base case on one geometry, random loads; both in one run on one
machine, because times alone say little on a shared one. The residual of both is checked.
"""

from __future__ import annotations

import argparse
import os
import time

# One thread, so that the ratio is about the solver and not about the number of cores.
os.environ["RAYON_NUM_THREADS"] = "1"

import numpy as np
from scipy.optimize import fsolve

import cbpt


def main(cases: int, peer_cases: int) -> None:
    drive = cbpt.Drive.from_toml(cbpt.example_case())
    rng = np.random.default_rng(0)
    torque, preload = rng.uniform(0.5, 5, cases), rng.uniform(300, 900, cases)
    start = time.perf_counter()
    angles = cbpt.solve_many(drive, torque, preload)
    ours = (time.perf_counter() - start) / cases
    assert angles.has_solution.all() and angles.residual.max() <= 1e-11

    # What fsolve is given: arms and stiffnesses of the deceleration pair, taken from the solved
    # contacts, so that both solve the same equations.
    pair = drive.solve(torque_Nm=5, preload_N=600).deceleration
    assert pair is not None
    stiffness = pair.force_N / pair.deformation_m**1.5
    sine = np.sqrt(0.5)
    arm = (pair.deformation_m / sine - pair.approach_m) / pair.angle_rad

    def equations(x: np.ndarray, m0: float, n_z: float) -> list[float]:
        delta = np.maximum((x[0] * 1e-6 + arm * x[1] * 1e-6) * sine, 0.0)
        force = stiffness * delta**1.5
        return [force.sum() * sine / n_z - 1, (force @ arm * sine - m0) / n_z]

    start = time.perf_counter()
    solved = [
        fsolve(equations, [4.0, 1.0], args=(m0, n_z), xtol=1e-10)[1] * 1e-6
        for m0, n_z in zip(torque[:peer_cases], preload[:peer_cases], strict=True)
    ]
    theirs = (time.perf_counter() - start) / peer_cases
    agreement = np.abs(solved / angles.alpha_deceleration_rad[:peer_cases] - 1).max()

    print(f"fsolve / cbpt, time a load:  {theirs / ours:.0f}")
    print(f"cbpt   {ours * 1e6:8.2f} us (both pairs of the drive, one thread, {cases} loads)")
    print(f"fsolve {theirs * 1e6:8.2f} us (deceleration pair alone, {peer_cases} loads)")
    print(f"largest relative difference of the deceleration angle: {agreement:.1e}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=100_000)
    options = parser.parse_args()
    main(options.cases, min(options.cases, 2_000))
