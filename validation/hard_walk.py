"""The walk: the load in a hundred equal steps, each begun at the last equilibrium; work against energy.

Along a path of equilibria the work of the external loads is the strain energy, whatever the loads are:
Q_int(q) = f Q_ext(q) at load factor f, and Q_int . dq = dU. Supports do no work. With the trapezoidal rule

    W = sum 1/2 (f_i Q_i + f_{i+1} Q_{i+1}) . (q_{i+1} - q_i),

whose error falls as 1/n^2 (order 2), and Simpson's rule by Richardson, (4 W_2n - W_n)/3 (order 4).
Moments fixed in space have no potential, but their work is this integral all the same.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf.solution import Solution
from validation.hard_drift import LOADS, Scene, copied

Floats = NDArray[np.float64]

STEPS = 100  # of the walk
RULES = (25, 50, 100)  # equal steps of the quadratures: every fourth, every second, every equilibrium
# Differences of two quadratures below this share of the energy are rounding and tell no order.
RESOLVED = 1e-11
NOTHING = 1e-12  # E I/L: strain energy of a rod that is not loaded, but for rounding


@dataclass(frozen=True)
class Balance:
    """Work against strain energy: |W - U|/U of Simpson's rule on the finest steps, and the observed orders.

    An order is None where the differences are below rounding: then the rule is exact for this path.
    """

    error: float
    trapezoid_error: float
    trapezoid_order: float | None
    simpson_order: float | None


def scaled(scene: Scene, load_factor: float) -> Scene:
    """The scene with all its loads multiplied."""
    changed = copied(scene)
    for table in LOADS:
        for load in changed.get(table, []):
            load["value"] = [load_factor * v for v in load["value"]]
    for load in changed.get("pressure", []):
        load["value"] *= load_factor
    if "gravity" in changed:
        gravity = changed["gravity"]
        gravity["acceleration"] = [load_factor * v for v in gravity["acceleration"]]
    return changed


def walk(scene: Scene, steps: int = STEPS) -> list[Solution]:
    """Equilibria at the load factors i/steps, each begun at the last one, up to the first failure."""
    found: list[Solution] = []
    options = {**scene.get("solver", {}), "predictor": "none"}
    for i in range(1, steps + 1):
        here = {**scaled(scene, i / steps), "solver": options}
        solution = ancf.solve(ancf.scene_from_dict(here), start=found[-1].q if found else None)
        if solution.status is not ancf.Status.CONVERGED:
            break
        found.append(solution)
    return found


def energy_balance(path: list[Solution], rules: tuple[int, int, int] = RULES) -> Balance:
    """Balance of a whole walk of rules[-1] steps; every rule must divide the next."""
    if len(path) != rules[-1]:
        raise ValueError(f"a walk of {rules[-1]} steps is needed, not {len(path)}")
    model = path[-1].model
    q = np.array([model.q0, *(solution.q for solution in path)])
    Q = np.array([np.zeros(model.n), *(s.model.residual(s.q).Q_ext for s in path)])  # of the scaled loads
    U = sum(path[-1].strain_energy(rod.rod.name) for rod in model.rods)
    work = [trapezoid(q[:: rules[-1] // n], Q[:: rules[-1] // n]) for n in rules]
    return balance(work, U, NOTHING * sum(rod.bending_stiffness / rod.rod.length for rod in model.rods))


def trapezoid(q: Floats, Q: Floats) -> float:
    """Work (scalar) of generalised forces Q (n + 1, m) along coordinates q (n + 1, m)."""
    return float(np.sum(0.5 * (Q[1:] + Q[:-1]) * np.diff(q, axis=0)))


def balance(work: list[float], energy: float, smallest: float = 0.0) -> Balance:
    """Errors and orders from three trapezoidal sums of n, 2 n, 4 n steps and the exact energy.

    `smallest` is an energy below which there is nothing to balance: errors are relative to the larger.
    """
    scale = max(abs(energy), smallest)
    errors = [abs(w - energy) / scale for w in work]
    simpson = [abs((4.0 * b - a) / 3.0 - energy) / scale for a, b in pairwise(work)]
    return Balance(simpson[-1], errors[-1], _order(errors[-2:]), _order(simpson))


def _order(errors: list[float]) -> float | None:
    coarse, fine = errors
    if not fine > RESOLVED:
        return None
    return math.log2(coarse / fine)
