"""Whole batches of loads by one compiled kernel (extra `fast`), for rods that allow it.

One rod of Saint Venant-Kirchhoff material under point loads; the tables of a model are built once and kept.
A row that the kernel cannot solve is only marked: the caller decides what to do with it.
"""

from __future__ import annotations

import importlib.util
import os
from threading import Lock
from typing import NamedTuple
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from ancf.batch_rows import RowsResult
from ancf.fused_load_tables import LoadTables, StartTables, load_tables, start_tables
from ancf.fused_memory import Lanes, Rows, lane_states, scratch_memory
from ancf.fused_tables import (
    ElasticTables,
    MeshTables,
    ProjectorTables,
    elastic_tables,
    held_vectors,
    mesh_tables,
    projector_tables,
)
from ancf.model import Model
from ancf.newton import FLOOR_FACTOR
from ancf.section_law import QuadraticSection

Floats = NDArray[np.float64]

# Samples side by side: 8 keep the pipelines busiest (34 000 solutions of bench_batch.py a second on one core
# with AVX-512, against 27 000 with 4), 4 take little more than half their time for a single row. Each is
# compiled when it is first needed.
FEW, MANY = 4, 8
# Rows of `Scratch.signs`: positive at a minimum of the potential; without one, at what may be stable.
LEAST_MINOR, DETERMINANT = 0, 1
# Fraction of the length within which a load stands on an element boundary.
ON_BOUNDARY = 1e-9


class Problem(NamedTuple):
    """Loads and starts of the rows, and when to stop."""

    moments: Floats  # (B, moments, 3) N m
    forces: Floats  # (B, forces, 3) N
    starts: Floats  # (0, 1 or B, n) dimensionless
    sign: NDArray[np.int64]  # (B,) which of `Scratch.signs` tells that a row is stable
    tolerance: float
    floor: float
    max_iterations: int


class Found(NamedTuple):
    """Results of the rows."""

    x: Floats  # (B, n) dimensionless
    converged: NDArray[np.bool_]
    residual: Floats
    iterations: NDArray[np.int64]


class Tables(NamedTuple):
    """Everything the kernel knows of a model."""

    mesh: MeshTables
    elastic: ElasticTables
    projectors: ProjectorTables
    loads: LoadTables
    start: StartTables
    at: Rows
    state: Lanes
    memory: Floats
    floor: float


_tables: WeakKeyDictionary[Model, dict[int, Tables]] = WeakKeyDictionary()
_reasons: WeakKeyDictionary[Model, str] = WeakKeyDictionary()
turns = Lock()  # the memory of a model serves one batch at a time


def unsupported(model: Model) -> str:
    """Why the fused kernel cannot take a model, in one sentence; empty if it can."""
    if model not in _reasons:
        _reasons[model] = _reason(model)
    return _reasons[model]


def no_gpu() -> str:
    """Why there is no GPU to solve on, in one sentence; empty if there is one."""
    simulated = os.environ.get("NUMBA_ENABLE_CUDASIM", "0") == "1"
    if importlib.util.find_spec("numba_cuda") is None and not simulated:
        return "numba-cuda is not installed (extra `cuda`)."
    from ancf.fused_cuda import present

    return "" if present() else "No CUDA GPU and driver were found."


def _reason(model: Model) -> str:
    scene = model.scene
    if importlib.util.find_spec("numba") is None:
        return "numba is not installed (extra `fast`)."
    if len(model.rods) != 1 or model.constraints is not None:
        return "The fused kernel solves one rod without joints or tendons of given length."
    (rod,) = model.rods
    if rod.elastic.assumed is not None:
        return "The fused kernel takes no assumed strains."
    if not isinstance(rod.elastic.section, QuadraticSection):
        return "The fused kernel knows Saint Venant-Kirchhoff material only."
    known = {"moment", "force", "gravity", "line_load"}
    if unknown := sorted({effect.name for effect in model.effects} - known):
        return f"The fused kernel knows no {' and no '.join(unknown)}."
    if any(load.direction != "fixed" for load in scene.line_loads):
        return "The fused kernel knows dead line loads only."
    if any(load.definition != "section" for load in scene.moments):
        return "The fused kernel knows moments by the section's rotation only."
    if len({support.dofs[0] for support in model.supports}) < len(model.supports):
        return "The fused kernel takes one support a node."
    clamps = {rod.node_at(s.at) for s in rod.rod.supports if s.kind == "free_section_clamp"}
    for load in (*scene.moments, *(f for f in scene.forces if f.direction == "follower")):
        if np.abs(rod.mesh.breaks / rod.rod.length - load.at).min() > ON_BOUNDARY:
            return "The fused kernel takes moments and follower forces between elements only."
        if rod.node_at(load.at) in clamps:
            return "The fused kernel takes no moment or follower force on a free-section clamp."
    return ""


def solve_rows(
    model: Model,
    moments: Floats,
    forces: Floats,
    start: Floats | None = None,
    *,
    tolerance: float | None = None,
    max_iterations: int = 25,
) -> RowsResult:
    """Solve one rod under many loads.

    Parameters
    ----------
    model : one for which `unsupported` is empty
    moments, forces : (B, moments of the scene, 3) [N m], (B, forces of the scene, 3) [N], in SCS and in the
        scene's order; those that follow their section as they are at the reference
    start : nodal coordinates (B, n) or (n,) [SI] to begin from; None bends the rod by its moments
    tolerance : of the dimensionless step and residual; None: the scene's
    max_iterations : linear solves after which a row is given up

    Notes
    -----
    Magisano, Leonetti, Garcea, Int. J. Numer. Meth. Eng. 109 (2017) 1183 (tangent); the rest of the rule is
    newton.py's. About 0.6 Mflop a row for 8 elements 3333.
    """
    from ancf.fused_kernel import solve

    rows = len(moments)
    lanes = FEW if rows <= FEW else MANY
    tables = tables_of(model, lanes)
    problem = problem_of(model, moments, forces, start, tolerance, tables.floor, max_iterations)
    found = Found(np.empty((rows, model.n)), np.zeros(rows, bool), np.empty(rows), np.zeros(rows, np.int64))
    with turns:
        solve(problem, found, *tables[:8], (0.0,) * lanes)
    floor = np.full(rows, tables.floor)
    return RowsResult(found.x * model.unit, found.converged, found.residual, floor, found.iterations)


def problem_of(
    model: Model,
    moments: Floats,
    forces: Floats,
    start: Floats | None,
    tolerance: float | None,
    floor: float,
    max_iterations: int,
) -> Problem:
    """What `solve_rows` is asked for, as arrays for the kernel."""
    if start is None:
        starts = np.empty((0, model.n))
    else:
        starts = np.array([model.admissible(q) for q in np.atleast_2d(start)]) / model.unit
    moments, forces = (np.ascontiguousarray(values, dtype=float) for values in (moments, forces))
    follows = [force.direction == "follower" for force in model.scene.forces]
    # As `Model.conservative` of the row: a load of value zero does not count.
    turned = np.any(moments, axis=(1, 2)) | np.any(forces[:, follows], axis=(1, 2))
    return Problem(
        moments,
        forces,
        starts,
        np.where(turned, DETERMINANT, LEAST_MINOR),
        model.scene.solver.tolerance if tolerance is None else float(tolerance),
        floor,
        max_iterations,
    )


def tables_of(model: Model, lanes: int) -> Tables:
    """The tables of a model, and memory for so many lanes; built once."""
    of_model = _tables.setdefault(model, {})
    if lanes not in of_model:
        of_model[lanes] = _build(model, lanes)
    return of_model[lanes]


def _build(model: Model, lanes: int) -> Tables:
    (rod,) = model.rods
    held, mixed = held_vectors(model)
    mesh, elastic, loads = mesh_tables(rod, held), elastic_tables(rod), load_tables(model)
    at, memory = scratch_memory(model.n, mesh, elastic, loads, lanes)
    return Tables(
        mesh,
        elastic,
        projector_tables(rod, mesh, mixed),
        loads,
        start_tables(model, loads.node),
        at,
        lane_states(len(loads.node), len(rod.q0), lanes),
        memory,
        _floor(model),
    )


def _floor(model: Model) -> float:
    """Dimensionless residual that float64 leaves: eps max_i sum_j |K_ij| |q_j| with 3 x 3 blocks and vectors.

    Taken once, at the reference with its positions as far from the base as the arc is long: no rotation
    changes these norms, and no bent rod reaches farther.
    """
    (rod,) = model.rods
    _, flat = model.residual_and_tangent(model.q0, 0.0)
    b, n = model.pattern.b, model.n
    size = np.linalg.norm((model.q0 / model.unit).reshape(rod.q0.shape), axis=2)
    size[:, rod.element.vectors.index((0, 0, 0))] = rod.mesh.node_x / rod.rod.length
    reach = b // 3 + 1  # of a block, in blocks
    squares = np.zeros((2 * reach + 1, n // 3))
    for offset in range(-b, b + 1):
        columns = np.arange(max(0, -offset), min(n, n - offset))
        rows = columns + offset
        entries = flat[model.pattern.slots(rows, columns)] * model.unit[columns] / model.force_unit[rows]
        np.add.at(squares, (rows // 3 - columns // 3 + reach, columns // 3), entries**2)
    row_sums = np.zeros(n // 3 + 2 * reach)
    for shift, norms in enumerate(np.sqrt(squares) * size.ravel()):
        row_sums[shift : shift + n // 3] += norms
    return FLOOR_FACTOR * float(np.finfo(float).eps) * float(row_sums.max())
