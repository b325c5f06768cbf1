"""`solve`: scene in, solution out. A missing equilibrium is a status with a message, never an exception."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from ancf.errors import InputError, Message
from ancf.failure import explain
from ancf.model import Model
from ancf.reductions import search
from ancf.solution import Solution, Status

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ancf.scene import Scene


NO_START = Message(
    "A start and accuracy are both given.",
    "solver.accuracy",
    "start holds the coordinates of one mesh, and accuracy chooses another",
    "a scene that asks for an accuracy has no mesh before it is solved",
    "leave the start away, or solve the scene of an earlier solution (solution.scene), which has its mesh",
)


def prepare(scene: Scene) -> Model:
    """The arrays of a scene, every one that could be refused among them.

    Raises `SceneError` when supports stand closer than elements or the reference overlaps itself. Where the
    scene asks for an `accuracy`, the mesh is the one that is tried first.
    """
    if scene.solver.accuracy is not None:
        from ancf.refinement import prepared

        scene = prepared(scene)
    model = Model(scene)
    for rod in model.rods:
        _ = rod.elastic.v0
    return model


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # non-finite numbers are caught and reported
def solve(scene: Scene, start: NDArray[np.float64] | None = None) -> Solution:
    """Find the static equilibrium of a scene.

    Parameters
    ----------
    scene : validated records, from `load_scene` or `scene_from_dict`
    start : nodal coordinates (n,) [SI] to begin from, as kept in `Solution.q`; None begins as the scene says.
        Paths (arc length, the buckled branch) begin at the reference

    Returns
    -------
    `Solution`; `status` is ``converged`` or says why not, and then the state is the last equilibrium found.

    Raises
    ------
    SceneError : the scene cannot be meshed (supports closer than elements, overlapping reference).
    InputError : a `start`, or elements, for a scene that asks for an `accuracy` (accuracy.py).

    Notes
    -----
    Newton on what the scene calls for (reductions.py) with band LU or Cholesky: cost linear in the number of
    elements. Paper section 2.4.
    """
    if scene.solver.accuracy is not None:
        from ancf.accuracy import solve_to_accuracy

        if start is not None:
            raise InputError(NO_START)
        return solve_to_accuracy(scene)
    started = time.perf_counter()
    model = prepare(scene)
    setup = time.perf_counter() - started
    trace, reductions = search(model, start)
    counters = model.counters
    stability = None
    if scene.stability is not None or trace.followed is not None:
        from ancf.stability import examine

        deadline = started + scene.solver.max_seconds
        stability = examine(model, trace.q, trace.load_factor, trace.followed, deadline)
    total = time.perf_counter() - started
    message = None if trace.status is Status.CONVERGED else explain(model, trace)
    return Solution(
        scene=scene,
        model=model,
        q=trace.q,
        status=trace.status,
        reason="" if message is None else f"{message.what} {message.value}; {message.cause}",
        message=message,
        load_factor=trace.load_factor,
        stable=trace.stable,
        steps=trace.steps,
        cutbacks=trace.cutbacks,
        residual=trace.residual,
        residual_floor=trace.floor,
        history=trace.history,
        seconds={
            "total": total,
            "setup": setup,
            "assembly": sum(counters.seconds.values()),
            "linear_solve": counters.linear_solve,
        },
        path=[] if trace.followed is None else trace.followed.points,
        stability=stability,
        reductions=reductions,
        effects={n: {"calls": counters.calls[n], "seconds": counters.seconds[n]} for n in counters.calls},
    )
