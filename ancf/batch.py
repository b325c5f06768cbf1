"""`solve_batch`: one scene under many rows of loads, solved together; a bad row never spoils the others.

Newton takes all rows at once, in one of two forms that agree to 1e-11: the NumPy kernels (batch_newton.py)
and, where numba is installed and the scene is of its kind, one fused kernel, on the CPU (fused.py) or, for
large batches, on a GPU (fused_cuda.py). A row that it leaves, without convergence or at an unstable
equilibrium, is searched for alone, as `solve` does it.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancf.batch_rows import BatchLoads, RowsResult, read_rows, refuse_batch
from ancf.batch_starts import dear_starts, solve_in_waves
from ancf.failure import explain
from ancf.model import Model
from ancf.scene import Scene
from ancf.sensitivity import pose_map, sensitivity
from ancf.solution import Solution, Status
from ancf.solver import prepare, solve
from ancf.stepping import find_equilibrium

Floats = NDArray[np.float64]

ENGINES = ("auto", "numpy", "fused", "cuda")
# Rows from which a GPU is looked for: one core of a CPU solves as many in about 3 s, and the kernel of the
# GPU takes longer than that to compile once.
LARGE = 100_000
SEE = "see help(ancf.solve_batch)"

_models: WeakKeyDictionary[Scene, dict[tuple[bool, ...], Model]] = WeakKeyDictionary()


@dataclass(frozen=True, eq=False)
class BatchSolution:
    """Equilibria of the rows of a batch; a failed row holds its last equilibrium, at `load_factor`.

    `engine` names the form that was used, "numpy", "fused", "cuda", or "solve" where rows are solved one by
    one.
    """

    loads: BatchLoads
    model: Model
    q: Floats  # (B, n) nodal coordinates, as `Solution.q`
    status: NDArray[np.object_]  # (B,) of Status
    reason: list[str]  # "" where a row converged
    load_factor: Floats  # (B,)
    iterations: NDArray[np.intp]  # (B,) linear solves in all
    residual: Floats  # (B,)
    residual_floor: Floats  # (B,)
    engine: str
    seconds: float

    def __len__(self) -> int:
        return len(self.q)

    @property
    def rod(self) -> str:
        """Name of the rod whose tip the poses are: that of the first moment, else force, else tendon."""
        scene = self.loads.scene
        return (*scene.moments, *scene.forces, *scene.tendons)[0].rod

    @cached_property
    def poses(self) -> Floats:
        """Tip poses (B, 3, 4), columns r, r_x, r_y, r_z in SCS."""
        rod = next(rod for rod in self.model.rods if rod.rod.name == self.rod)
        dofs, P = pose_map(rod)
        poses = (self.q[:, dofs] @ P.T).reshape(-1, 4, 3).swapaxes(1, 2)
        poses[:, :, 0] += rod.rod.base.position
        return poses

    def solution(self, row: int) -> Solution:
        """The full record of one row, solved from where the batch left it."""
        return solve(self.loads.row(row), start=self.q[row])

    def sensitivity(self, parameter: str = "moment", index: int = 0) -> Floats:
        """Derivatives (B, 12, 3) or (B, 12) of the tip poses, as `Solution.sensitivity`."""
        return np.array(
            [
                sensitivity(self.loads.under(self.model, row), q, factor, parameter, self.rod, index)
                for row, (q, factor) in enumerate(zip(self.q, self.load_factor, strict=True))
            ]
        )


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # non-finite numbers are caught and reported
def solve_batch(
    scene: Scene,
    moments: ArrayLike | None = None,
    *,
    forces: ArrayLike | None = None,
    tensions: ArrayLike | None = None,
    lengths: ArrayLike | None = None,
    start: ArrayLike | None = None,
    engine: str = "auto",
) -> BatchSolution:
    """Equilibria of one scene under many rows of loads.

    Parameters
    ----------
    moments : (B, 3) [N m] values of the first [[moment]] of the scene, in its frame, or (B, k, 3) of all k
    forces : (B, 3) or (B, k, 3) [N], likewise; loads that are not given keep the values of the scene
    tensions : (B,) [N] of the first tendon of given tension, or (B, k) of all k
    lengths : (B,) [m] of the first tendon of controlled length, or (B, k) of all k
    start : nodal coordinates (n,) or (B, n) to begin from, as `BatchSolution.q`; None finds its own starts:
        closed form under moments, else solved neighbours in the order of the rows where they are near
    engine : "auto", or "numpy" | "fused" | "cuda" to insist on a form; "auto" takes a GPU that is present
        for 100 000 rows or more

    Returns
    -------
    `BatchSolution`, each row with its own status.

    Notes
    -----
    Under `accuracy` in [solver] the mesh is the one that the row of the largest loads needs. `max_seconds` is
    for the rows together, and again for each one that is searched for alone.

    Raises
    ------
    InputError : no rows, wrong shapes, rows that are not finite, an engine that cannot take the scene or, for
        "cuda", has no GPU.
    SceneError : the scene cannot be meshed.
    """
    started = time.perf_counter()
    loads = read_rows(scene, moments, forces, tensions, lengths)
    if scene.solver.accuracy is not None:  # the mesh that the largest row needs serves all of them
        scene = solve(loads.scene).scene
        loads = read_rows(scene, moments, forces, tensions, lengths)
    model = _model(scene, loads)
    begin = None if start is None else _starts(start, len(loads), model)
    chosen = _engine(model, engine, len(loads))
    deadline = started + scene.solver.max_seconds
    q = np.empty((len(loads), model.n))
    status = np.full(len(loads), Status.CONVERGED, dtype=object)
    reason, load_factor = [""] * len(loads), np.ones(len(loads))
    iterations, residual, floor = np.zeros(len(loads), int), np.zeros(len(loads)), np.zeros(len(loads))
    left = np.arange(len(loads))
    if chosen != "solve":
        newton = _newton(chosen, deadline)
        if begin is not None:
            found = newton(model, loads, begin)
        elif chosen in ("fused", "cuda") and (model.conservative or not dear_starts(model)):
            found = newton(model, loads, None)
        else:
            found = solve_in_waves(model, loads, newton, deadline)
        q, iterations, residual, floor = found.q, found.iterations, found.residual, found.floor
        left = np.flatnonzero(~found.converged)
    for row in left:
        under = loads.under(model, int(row))
        trace = find_equilibrium(under, begin[row] if chosen == "solve" and begin is not None else None)
        q[row], status[row], load_factor[row] = trace.q, trace.status, trace.load_factor
        residual[row], floor[row] = trace.residual, trace.floor
        iterations[row] += len(trace.history)
        if trace.status is not Status.CONVERGED:
            message = explain(under, trace)
            reason[row] = f"{message.what} {message.value}; {message.cause}"
    seconds = time.perf_counter() - started
    return BatchSolution(
        loads, model, q, status, reason, load_factor, iterations, residual, floor, chosen, seconds
    )


def _engine(model: Model, wanted: str, rows: int) -> str:
    """The form to use; raises `InputError` when the one that is insisted on cannot take the scene."""
    if wanted not in ENGINES:
        refuse_batch(
            "There is no such engine.",
            f"engine = {wanted!r}",
            f"one of {', '.join(ENGINES)}",
            "a misspelt name",
            SEE,
        )
    scene = model.scene
    alone = scene.follows_path or model.constraints is not None or model.settling
    if alone or scene.solver.tangent != "analytic":
        refused = (
            "The scene follows a path, has joints, tendons of given length, contact or the finite-difference"
            " tangent: rows are solved alone."
        )
        form = "solve"
    else:
        from ancf.fused import no_gpu, unsupported

        refused = "" if wanted == "numpy" else unsupported(model)
        form = "numpy" if wanted == "numpy" or refused else "fused"
        if form == "fused" and (wanted == "cuda" or (wanted == "auto" and rows >= LARGE)):
            refused = no_gpu()
            form = "fused" if refused else "cuda"
    if wanted not in ("auto", form):
        refuse_batch(
            f"The engine {wanted!r} cannot take this batch.", "engine", f"engine = {wanted!r}", refused, SEE
        )
    return form


def _newton(engine: str, deadline: float) -> Callable[[Model, BatchLoads, Floats | None], RowsResult]:
    """Newton for rows from their starts; the fused kernel also finds starts of its own (None)."""
    if engine in ("fused", "cuda"):
        if engine == "fused":
            from ancf.fused import solve_rows as fused_rows
        else:
            from ancf.fused_cuda import solve_rows as fused_rows
        return lambda model, loads, start: fused_rows(model, loads.moments, loads.forces, start)
    from ancf.batch_newton import solve_rows

    return lambda model, loads, start: solve_rows(
        model, loads, model.q0 if start is None else start, deadline
    )


def _model(scene: Scene, loads: BatchLoads) -> Model:
    """The model of a scene for all batches in which the same of its loads act; made once."""
    known = _models.setdefault(scene, {})
    acting = tuple(bool(np.any(load.value)) for load in (*loads.scene.moments, *loads.scene.forces))
    if acting not in known:
        known[acting] = prepare(loads.scene)
    return known[acting]


def _starts(start: ArrayLike, count: int, model: Model) -> Floats:
    """Starts (B, n), checked."""
    values = np.asarray(start, dtype=float)
    if values.shape not in ((model.n,), (count, model.n)) or not np.isfinite(values).all():
        refuse_batch(
            "The start does not belong to this batch.", f"start, shape {values.shape}",
            f"must be ({model.n},) or ({count}, {model.n}), and finite",
            "rows, elements or meshes differ from those of the state", SEE,
        )  # fmt: skip
    return np.broadcast_to(values, (count, model.n))
