"""What a solid solution will cost, before it starts: unknowns, memory, time.

Block-tridiagonal LU of `slices` blocks of b = 6 ns unknowns, coupled by one plane: per block the pivot's LU,
2/3 b^3, and 3 ns right-hand sides, 2 b^2 3 ns = b^3: 5/3 b^3 floating point operations.
"""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from time import perf_counter

import numpy as np

from reference.solid_forms import Formulation
from reference.solid_linear import getrf, getrs
from reference.solid_mesh import RodMesh

ITERATIONS = 6  # from a beam-shaped guess: 4 to 7 (reference study)
PROBE_SIZE = 342  # block of core 2, ring 1
BYTES_FIXED = 85e6  # interpreter with NumPy, SciPy, scikit-fem
BYTES_PER_ELEMENT = {"displacement": 4.8e5, "mixed": 5.3e5}
SECONDS_PER_ELEMENT = {"displacement": 5e-4, "mixed": 6e-4}  # one assembly, at PROBE_RATE
SETUP_PER_ELEMENT = 4e-4
BLOCK_OVERHEAD = 1.7  # of the block solver over its bare arithmetic, 1.6 to 1.9 measured
ANNOUNCED = 30.0  # s
PROBE_RATE = 2e10  # flop/s at which the constants above were measured


@dataclass(frozen=True)
class SolidCost:
    """Estimate for one Newton solution: `unknowns`, peak `bytes`, wall `seconds` of one core."""

    unknowns: int
    bytes: float
    seconds: float

    def __str__(self) -> str:
        return f"{self.unknowns} unknowns, about {self.bytes / 1e9:.2g} GB and {self.seconds:.2g} s"


class SolidTooLarge(ValueError):
    """The estimated cost of a solid exceeds a limit that was set."""


def estimate(mesh: RodMesh, formulation: Formulation, iterations: int = ITERATIONS) -> SolidCost:
    """Cost of a Newton solution with the block solver, within a factor of two; measures this machine once."""
    elements, block = len(mesh.elements), 6 * len(mesh.section.nodes)
    size = mesh.nodes.size
    rate = _flops_per_second()
    factor = BLOCK_OVERHEAD * mesh.slices * 5 / 3 * block**3 / rate
    per_element = SECONDS_PER_ELEMENT[formulation] * iterations + SETUP_PER_ELEMENT
    kept = mesh.slices * block * (block / 2 + 1) * 8
    return SolidCost(
        unknowns=size,
        bytes=BYTES_FIXED + elements * BYTES_PER_ELEMENT[formulation] + kept,
        seconds=iterations * factor + elements * per_element * PROBE_RATE / rate,
    )


def check_cost(
    mesh: RodMesh,
    formulation: Formulation,
    *,
    solutions: int = 1,
    memory_limit: float | None = None,
    seconds_limit: float | None = None,
    report: Callable[[str], None] | None = None,
) -> None:
    """Tell the estimate to `report`, and refuse a solution beyond a limit ([byte], [s]).

    Without `report` a long solution is announced on standard error; without `memory_limit` the memory of
    the machine is the limit.

    Raises
    ------
    SolidTooLarge
        With the estimate, the limit and the mesh that causes it.
    """
    cost = estimate(mesh, formulation, solutions * ITERATIONS)
    memory_limit = machine_memory() if memory_limit is None else memory_limit
    if report is None and cost.seconds > ANNOUNCED:
        report = _announce
    text = f"Solid of {mesh.slices} slices with {len(mesh.section.nodes)} nodes a section"
    if report is not None:
        report(f"{text}: {cost}.")
    excess = []
    if memory_limit is not None and cost.bytes > memory_limit:
        excess.append(f"memory {cost.bytes / 1e9:.2g} GB > {memory_limit / 1e9:.2g} GB")
    if seconds_limit is not None and cost.seconds > seconds_limit:
        excess.append(f"time {cost.seconds:.2g} s > {seconds_limit:.2g} s")
    if excess:
        raise SolidTooLarge(
            f"{text} was not started: estimated {' and '.join(excess)}. "
            "The cost grows with slices and with the cube of the nodes of a section. "
            "Take fewer slices or a coarser section, or raise the limit."
        )


def machine_memory() -> float:
    """Memory of this machine [byte]; infinite where the system does not tell."""
    try:
        return float(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    except (AttributeError, OSError, ValueError):
        return math.inf


def _announce(text: str) -> None:
    sys.stderr.write(f"{text}\n")


@cache
def _flops_per_second() -> float:
    """Speed of this machine at the block solver's work, the best of three."""
    matrix = np.random.default_rng(0).normal(size=(PROBE_SIZE, PROBE_SIZE)) + PROBE_SIZE * np.eye(PROBE_SIZE)
    matrix = np.asfortranarray(matrix)
    seconds = []
    for _ in range(3):
        begin = perf_counter()
        lu, pivots, _ = getrf(matrix)
        getrs(lu, pivots, matrix[:, : PROBE_SIZE // 2])
        seconds.append(perf_counter() - begin)
    return 5 / 3 * PROBE_SIZE**3 / min(seconds)
