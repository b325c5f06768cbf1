"""`solve`: scene in, solution out. A missing equilibrium is a status with a message, never an exception."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from ancf.errors import Message
from ancf.model import Model
from ancf.newton import Outcome
from ancf.solution import Solution, Status
from ancf.stepping import Trace, find_equilibrium, inverted_at, smallest_stretch

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from ancf.scene import Scene


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # non-finite numbers are caught and reported
def solve(scene: Scene, start: NDArray[np.float64] | None = None) -> Solution:
    """Find the static equilibrium of a scene.

    Parameters
    ----------
    start : nodal coordinates (n,) [SI] to begin from, as kept in `Solution.q`; None begins as the scene says

    Returns
    -------
    `Solution`; `status` is ``converged`` or says why not, and then the state is the last equilibrium found.

    Raises
    ------
    SceneError : the scene cannot be meshed (supports closer than elements, overlapping reference).

    Notes
    -----
    Newton with a band LU: cost linear in the number of elements. Paper section 2.4.
    """
    started = time.perf_counter()
    model = Model(scene)
    for rod in model.rods:
        _ = rod.elastic.v0
    setup = time.perf_counter() - started
    trace = find_equilibrium(model, start)
    total = time.perf_counter() - started
    counters = model.counters
    message = None if trace.status is Status.CONVERGED else _explain(model, trace)
    return Solution(
        scene=scene,
        model=model,
        q=trace.q,
        status=trace.status,
        reason="" if message is None else f"{message.what} {message.value}; {message.cause}",
        message=message,
        load_factor=trace.load_factor,
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
        effects={n: {"calls": counters.calls[n], "seconds": counters.seconds[n]} for n in counters.calls},
    )


# Loads beyond this many E I / L^2 pull a rod into a boundary layer shorter than any sensible element.
EXTREME_LOAD = 1e5

_CAUSES = {
    Outcome.TOO_MANY: (
        "the load step is too large or a limit point is near",
        "use smaller loads, or more elements",
    ),
    Outcome.DIVERGED: (
        "the load has no equilibrium near this shape, or is far beyond the rod's stiffness",
        "check the units of load, modulus and section",
    ),
    Outcome.NOT_FINITE: (
        "the load overflows float64, or a section collapsed",
        "check the magnitude of the loads against E I / L^2",
    ),
    Outcome.SINGULAR: (
        "a limit or bifurcation point, or supports that leave a rigid motion",
        "check `supports`; perturb the load slightly if the rod is on the verge of buckling",
    ),
    Outcome.STAGNATED: (
        "round-off: the residual cannot fall below what float64 leaves at this stiffness ratio",
        "loosen `tolerance`, or use fewer elements or a less slender rod",
    ),
}


def _explain(model: Model, trace: Trace) -> Message:
    """The five parts of a failure, from the Newton iteration that ended it."""
    options = model.scene.solver
    failed = trace.failure
    what = f"No equilibrium at load factor {trace.tried:.6g} (the last one is at {trace.load_factor:.6g})."
    where = f"load step {trace.steps + 1}"
    if trace.status is Status.OUT_OF_TIME:
        return Message(
            what,
            where,
            f"more than max_seconds = {options.max_seconds:g} s",
            "the budget is too small for this scene",
            "raise `max_seconds`, or use fewer elements",
        )
    assert failed is not None
    name, node = _owner(model, failed.worst_dof)
    where += f", rod {name!r}, node {node}"
    value = f"residual {failed.residual:.2e} > {max(options.tolerance, failed.floor):.1e}"
    value += f" after {len(failed.history)} iterations and {trace.cutbacks} cut-backs"
    if trace.status is Status.LIMIT_POINT:
        cause = f"a limit point: the shape changes by {trace.rates[-1]:.0f} rod lengths per load factor there"
        advice = "load the rod less; path following through limit points is not in this version"
    elif trace.status is Status.MATERIAL_UNSTABLE:
        value = f"smallest axial stretch {smallest_stretch(model, trace.q):.3f}"
        cause = "Saint Venant-Kirchhoff carries no more compression below a stretch of 0.577"
        advice = "reduce the compression; this law has no stable state there"
    elif trace.status is Status.INVERTED_ELEMENT:
        inverted = inverted_at(model, failed.q)
        if inverted is not None:
            where = f"load step {trace.steps + 1}, rod {inverted[0]!r}, element {inverted[1]}"
            value = f"det [r_x r_y r_z] = {inverted[2]:.3g}, must be positive"
        cause, advice = "the element is turned inside out", "reduce the load or use more elements"
    else:
        cause, advice = _CAUSES[failed.outcome]
    largest = float(np.max(np.abs(model.residual(model.q0).Q_ext / model.force_unit)))
    if largest > EXTREME_LOAD:
        cause = (
            f"the load is {largest:.1e} times E I / L^2 (moments: E I / L), far beyond the rod's stiffness"
        )
        advice = "check the units of load, modulus and section"
    if not np.isfinite(failed.residual):
        value = f"residual not finite after {len(failed.history)} iterations and {trace.cutbacks} cut-backs"
    if trace.steps + trace.cutbacks >= options.max_steps:
        cause = f"the budget max_steps = {options.max_steps} is used up; {cause}"
        advice = f"raise `max_steps`; {advice}"
    return Message(what, where, value, cause, advice)


def _owner(model: Model, dof: int) -> tuple[str, int]:
    """Rod and node of an unknown."""
    for rod in model.rods:
        if dof < rod.first_dof + rod.size:
            return rod.rod.name, (dof - rod.first_dof) // (3 * len(rod.element.vectors))
    raise IndexError(dof)
