"""Why no equilibrium was found: the status of a search that ended, and its message in five parts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancf import cable
from ancf.errors import Message
from ancf.materials import SaintVenantKirchhoff
from ancf.newton import SMALLEST_SHARE, NewtonResult, Outcome
from ancf.rod_model import RodModel
from ancf.rod_shape import node_rotations
from ancf.rotation import log
from ancf.solution import Status

if TYPE_CHECKING:
    from ancf.model import Model
    from ancf.stepping import Trace

Floats = NDArray[np.float64]

# dq / d load factor grows like 1 / sqrt(distance) towards a limit point; steps go down to 1e-6 of the load.
LIMIT_POINT_RATE = 20.0
# Uniaxial Saint Venant-Kirchhoff, P = E (s^3 - s) / 2, carries no more compression below the stretch
# s = 1/sqrt(3) = 0.577; a rod within 3 % of it when the search ends has met that limit.
UNSTABLE_STRETCH = 0.595
# A section squeezed to less of its volume has collapsed to a line or a point: Saint Venant-Kirchhoff, finite
# there, has equilibria of that kind, and none of them is a rod.
SMALLEST_VOLUME = 1e-4
# Beyond this many E I / L^2 a load pulls the rod into a boundary layer shorter than any sensible element.
EXTREME_LOAD = 1e5
# An element whose ends turn against each other by more [rad] is too long: the tip is off by 4e-4 L at 0.52
# (a full circle on 12 elements 3333) and by 8e-3 L at 1.05 (two turns).
LARGEST_TURN = 0.7

# Quarter of a buckling wave in an element: critical loads beyond are those of the mesh.
LARGEST_WAVE = 0.5 * np.pi

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
    Outcome.INVERTED: (
        "the section is compressed or sheared beyond what this element can follow",
        "reduce the load or use more elements",
    ),
    Outcome.OFF_PATH: (
        "the path turns sharply or branches there",
        "start the path with a small imperfection, or use more elements",
    ),
    Outcome.OVERTURNED: (
        "a rotational spring or bed knows rotations below half a turn: beyond it their sense is lost",
        "load the rod less, or replace the spring by the moment that it would exert",
    ),
    Outcome.CHATTERING: (
        "tendons of given length change between taut and slack: near there the rod is not stable",
        "give one of them a tension, or change the lengths slightly",
    ),
    Outcome.STAGNATED: (
        "round-off: the residual cannot fall below what float64 leaves at this stiffness ratio",
        "loosen `tolerance`, or use fewer elements or a less slender rod",
    ),
}


def status_of_failure(model: Model, trace: Trace, result: NewtonResult) -> Status:
    """Status of a search that ended with the failed step `result`."""
    if result.outcome is Outcome.OUT_OF_TIME:
        return Status.OUT_OF_TIME
    if result.outcome is Outcome.NOT_FINITE:
        return Status.NOT_FINITE
    # A converged step is refused for this reason only.
    if result.converged or result.outcome is Outcome.INVERTED:
        return Status.INVERTED_ELEMENT
    if smallest_stretch(model, trace.q) < UNSTABLE_STRETCH:
        return Status.MATERIAL_UNSTABLE
    steep = len(trace.rates) > 2 and trace.rates[-1] > LIMIT_POINT_RATE * float(np.median(trace.rates))
    if steep and largest_turn(model, trace.q) < LARGEST_TURN:
        return Status.LIMIT_POINT
    return Status.NOT_CONVERGED


def explain(model: Model, trace: Trace) -> Message:
    """The five parts of a failure."""
    options, failed = model.scene.solver, trace.failure
    what = f"No equilibrium at load factor {trace.tried:.6g} (the last one is at {trace.load_factor:.6g})."
    where = f"load step {trace.steps + 1}"
    if trace.status is Status.OUT_OF_TIME:
        value = f"more than max_seconds = {options.max_seconds:g} s"
        advice = "raise `max_seconds`, or use fewer elements"
        return Message(what, where, value, "the budget is too small for this scene", advice)
    if trace.budget_used:
        value = (
            f"max_steps = {options.max_steps} used up by {trace.steps} steps and {trace.cutbacks} cut-backs"
        )
        cause = "the scene needs more load steps than it may take"
        if trace.status is Status.LIMIT_POINT and trace.followed is not None:
            peak = trace.followed.limit_point
            assert peak is not None
            cause = (
                f"the load factor turns back at a limit point, {peak.load_factor:.4g}, and has not come to 1"
            )
        return Message(what, where, value, cause, "raise `max_steps`, or apply less load")
    assert failed is not None  # a search ends by success, by its budgets, or by a failed step
    name, node = _owner(model, failed.worst_dof)
    where += f", rod {name!r}, node {node}"
    tried = f"{len(failed.history)} iterations and {trace.cutbacks} cut-backs"
    value = f"residual {failed.residual:.2e} > {max(options.tolerance, failed.floor):.1e} after {tried}"
    if failed.outcome is Outcome.OFF_PATH:
        value = f"after {tried} the next equilibrium found lies elsewhere, or a joint is half a turn off"
    if failed.outcome is Outcome.OVERTURNED:
        value = f"after {tried} a section on a rotational spring is turned by more than 3 rad"
    if not np.isfinite(failed.residual):
        value = f"residual not finite after {tried}"
    cause, advice = _CAUSES.get(failed.outcome, ("", ""))
    load = float(np.max(np.abs(model.residual(model.q0).Q_ext / model.force_unit)))
    turn = largest_turn(model, trace.q)
    if trace.status is Status.LIMIT_POINT:
        cause = f"a limit point: the shape changes by {trace.rates[-1]:.0f} rod lengths per load factor there"
        advice = 'load the rod less, or follow the path through it: method = "arclength" in [solver]'
    elif trace.status is Status.MATERIAL_UNSTABLE:
        value = f"smallest axial stretch {smallest_stretch(model, trace.q):.3f}"
        cause = "Saint Venant-Kirchhoff carries no more compression below a stretch of 0.577"
        advice = "reduce the compression; this law has no stable state there"
    elif trace.status is Status.INVERTED_ELEMENT:
        rod, element, determinant = smallest_determinant(model, failed.q)
        where = f"load step {trace.steps + 1}, rod {rod!r}, element {element}"
        value = f"det F = {determinant:.3g}, must exceed {SMALLEST_VOLUME:g}"
        cause, advice = "the element is turned inside out", "reduce the load or use more elements"
        if determinant > SMALLEST_VOLUME:
            value += f", and is not after {SMALLEST_SHARE:g} of the next step"
            cause, advice = _CAUSES[Outcome.INVERTED]
    elif load > EXTREME_LOAD:
        cause = f"the load is {load:.1e} times E I / L^2 (moments: E I / L), far beyond the rod's stiffness"
        advice = "check the units of load, modulus and section"
    elif lying := lying_rods(model):
        cause = f"nothing but friction holds rod {lying[0]!r}, and it slides"
        advice = "raise `friction` of its [[contact]], load it less along the surface, or give it a support"
    elif turn > LARGEST_TURN:
        cause = f"elements too long: one turns by {turn:.2g} rad between its ends"
        advice = f"use at least {turn / (0.5 * LARGEST_TURN):.0f} times as many elements"
    return Message(what, where, value, cause, advice)


def lying_rods(model: Model) -> list[str]:
    """Rods without support or joint, which contact alone holds."""
    joined = {place.rod for joint in model.scene.joints for place in joint.places}
    return [rod.name for rod in model.scene.rods if not rod.supports and rod.name not in joined]


def is_collapsed(model: Model, q: Floats) -> bool:
    """Whether q (n,) has a section turned inside out or squeezed to nothing."""
    return not smallest_determinant(model, q)[2] > SMALLEST_VOLUME


def smallest_determinant(model: Model, q: Floats) -> tuple[str, int, float]:
    """Rod, element and value of the smallest det F at the axial points; negative: inside out.

    Over the whole section where the law needs it (rubber), else det [r_x r_y r_z] on the axis; of a cable its
    stretch.
    """
    found = []
    for rod in model.rods:
        v, count = rod.generalised(q), len(rod.element.directors)
        if not rod.element.has_section:
            stretch = np.linalg.norm(v[:, :, 0], axis=-1)
            worst = np.unravel_index(np.argmin(stretch), stretch.shape)
            found.append((rod.rod.name, int(worst[0]), float(stretch[worst])))
            continue
        linear = [count + k - 1 for k in (rod.element.y_director, rod.element.z_director)]
        determinant = np.linalg.det(v[:, :, [0, *linear]])
        smallest = rod.elastic.section.smallest_volume(v)
        if smallest is not None:  # inf where the law does not need it
            determinant = np.where(smallest == np.inf, determinant, smallest)
        worst = np.unravel_index(np.argmin(determinant), determinant.shape)
        found.append((rod.rod.name, int(worst[0]), float(determinant[worst])))
    return min(found, key=lambda entry: entry[2])


def smallest_stretch(model: Model, q: Floats) -> float:
    """Smallest axial stretch |r_x| at the axial points that obey Saint Venant-Kirchhoff."""
    stretches = [
        float(np.linalg.norm(rod.generalised(q)[rod.elements_of(part), :, 0], axis=-1).min())
        for rod in model.rods
        for part, segment in enumerate(rod.rod.parts)
        if isinstance(segment.material, SaintVenantKirchhoff)
    ]
    return min(stretches, default=np.inf)


def largest_turn(model: Model, q: Floats) -> float:
    """Largest rotation [rad] between the ends of an element, beyond that of the reference."""
    return max(float(element_turns(rod, q).max()) for rod in model.rods)


def largest_wave(model: Model, q: Floats) -> float:
    """Largest part of a turn [rad] of a buckling wave that an element has: h sqrt(-N/E I), N its axial force.

    A compressed element beyond a quarter wave (pi/2) bends in ways that its polynomials do not follow.
    """
    worst = 0.0
    for rod in model.rods:
        pressed = np.max(-_axial_forces(rod, q), axis=1).clip(min=0.0)
        first, kind = rod.element_kinds
        young = np.array([rod.material_of(index).young_modulus for index in first])
        second = np.array([rod.section_in(index, 0.0).weaker_second_moment for index in first])
        worst = max(worst, float(np.max(rod.mesh.h * np.sqrt(pressed / (young * second)[kind]))))
    return worst


def _axial_forces(rod: RodModel, q: Floats) -> Floats:
    """Section force along the axis (n_el, points) [N]."""
    if not rod.element.has_section:
        return cable.axial_forces(rod, q)
    r_x = rod.generalised(q)[:, :, 0]
    return np.sum(rod.section_force(q)[:, :, 0] * r_x, axis=-1) / np.linalg.norm(r_x, axis=-1)


def element_turns(rod: RodModel, q: Floats) -> Floats:
    """Rotation [rad] between the ends of each element (n_el,), beyond that of the reference."""
    R = node_rotations(rod, rod.nodal(q))
    first, last = rod.mesh.nodes_of[:, 0], rod.mesh.nodes_of[:, -1]
    return np.linalg.norm(log(np.swapaxes(R[first], -1, -2) @ R[last]), axis=-1)


def _owner(model: Model, dof: int) -> tuple[str, int]:
    """Rod and node of an unknown; of a multiplier, the first that its constraint acts on."""
    if model.constraints and dof >= model.motions:
        dof = int(next(one for one in model.constraints.models if dof <= one.multipliers[-1]).dofs[0])
    for rod in model.rods:
        if dof < rod.first_dof + rod.size:
            return rod.rod.name, (dof - rod.first_dof) // (3 * len(rod.element.vectors))
    raise IndexError(dof)
