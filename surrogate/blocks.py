"""Blocks of rows, the unit of work: always the same rows, so that data do not depend on who solves them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf.batch import BatchSolution
from ancf.scene import Scene
from surrogate.gate import Gate, solver_digest

Floats = NDArray[np.float64]

ROWS = 128  # of a block: enough for the batch kernel, few enough to lose little and to share among workers
RESULTS = ("pose", "stretch", "status", "iterations", "residual", "load_factor")
LONGEST_STATUS = "<U24"


@dataclass(frozen=True, eq=False)
class Block:
    """Consecutive rows of a design, as they are sent to a worker."""

    number: int
    first: int  # row of the design
    scene: Scene
    loads: dict[str, Floats]  # as `ancf.solve_batch` takes them
    gate: Gate


@dataclass(frozen=True, eq=False)
class Solved:
    """What a worker answers."""

    number: int
    arrays: dict[str, NDArray]
    outside: list[str]  # why rows are outside the domain of validity
    solver: str  # digest of the code that the worker ran


def solve(block: Block) -> Solved:
    """Solve the rows of a block, in any process; a row that fails keeps its status and its last pose."""
    loads = block.loads
    batch = ancf.solve_batch(
        block.scene, loads.get("moments"), forces=loads.get("forces"), tensions=loads.get("tensions")
    )
    outside = [f"row {block.first + row}: {'; '.join(why)}" for row, why in block.gate.outside(batch).items()]
    return Solved(block.number, results(batch), outside, solver_digest())


def results(batch: BatchSolution) -> dict[str, NDArray]:
    """The arrays of a data set that a batch gives, row by row.

    ``pose`` (n, 3, 4), ``stretch`` (n, 3) lengths of r_x, r_y, r_z at the tip, 1 at the reference;
    ``status``, ``iterations``, ``residual``; ``load_factor`` that was reached.
    """
    return {
        "pose": batch.poses,
        "stretch": np.linalg.norm(batch.poses[:, :, 1:], axis=1),
        "status": np.array([str(status) for status in batch.status], dtype=LONGEST_STATUS),
        "iterations": batch.iterations.astype(np.int64),
        "residual": batch.residual,
        "load_factor": batch.load_factor,
    }
