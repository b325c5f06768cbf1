r"""How far the tips of a solution are from where an infinitely fine mesh of the same elements has them.

The error is estimated by the equilibrium with every element cut in two,

    r - r_exact = (r - r_fine)/(1 - s),     s the share of the error that the finer mesh still has,

a hierarchical estimate. Its first Newton step alone, which is the residual weighted by the adjoint, errs by
factors of ten on slender rods: axis and sections are (L/R)^2 times stiffer than bending, and on half of an
element they are asked to follow what the whole one did not show. So the finer equilibrium is found; the
coarse shape is a good start. The adjoint is what weighs errors of the model with (model_error.py).

The tip of a rod is moved by each element twice, by the error of its chord and by that of its turn,

    d r_tip = sum_e R_e dc_e + w_e x (r_tip - r_e),

which says where a finer mesh helps.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ancf.band import Factors
from ancf.elements import R
from ancf.model import Model
from ancf.newton import NewtonResult, newton
from ancf.refinement import carried, cut
from ancf.rod_model import RodModel
from ancf.rod_shape import node_rotations
from ancf.rotation import log
from ancf.scene import SAME_PLACE, Scene
from ancf.solution import Solution
from ancf.stepping import DIRECT_ITERATIONS, find_equilibrium

Floats = NDArray[np.float64]

ORDERS = {"3243": 3}  # of the tip error under refinement, observed (README); others 4
ORDER = 4
# Share of the error that half elements still have: 1/16 by order 4, up to 1/5 where the mesh is coarse.
STILL = 1.0 / 8.0
QUICK_ITERATIONS = 10  # from the coarse shape 3 to 7 do, or something is amiss
LEAST_TIME = 1e-3  # s, of a search that has run out of time


@dataclass(frozen=True, eq=False)
class ErrorEstimate:
    """Estimated tip error of each rod over its length, and what each of its elements has to do with it."""

    of_rod: tuple[float, ...]
    places: tuple[
        float, ...
    ]  # fraction of the length that it is taken at: 1, or the worst of a rod held there
    contributions: tuple[Floats, ...]  # (n_el,) of each rod, not negative
    finer: Solution  # the equilibrium with every element cut in two
    factors: Factors  # of its tangent
    iterations: int

    @property
    def largest(self) -> float:
        """The largest over the rods."""
        return max(self.of_rod)


def order_of(element: str) -> int:
    """Order of the tip error in the length of the elements, on smooth cases."""
    return ORDERS.get(element, ORDER)


def estimate_error(
    solution: Solution, tolerance: float = 0.0, deadline: float = np.inf
) -> ErrorEstimate | None:
    """Estimate of the tip error of a solution whose rods have their `breaks`; None where it cannot be had.

    It is of the discretisation alone: the finer mesh has the same elements and law. Where the tip of a rod is
    held it has no error, and the place between two elements that has the largest counts.

    Parameters
    ----------
    solution : converged
    tolerance : dimensionless, that the finer equilibrium may be content with where it meets rounding
    deadline : value of time.perf_counter() after which the estimate is given up

    Notes
    -----
    Costs one solve of twice the elements from a near start, 3 to 5 iterations.
    """
    coarse = solution.model
    fine = Model(replace(solution.scene, rods=tuple(cut(rod, 2) for rod in solution.scene.rods)))
    found, iterations = _equilibrium(fine, carried(coarse, solution.q, fine), tolerance, deadline)
    if found is None or found.lu is None:
        return None
    errors, places, contributions = [], [], []
    for rod, other in zip(coarse.rods, fine.rods, strict=True):
        moved, share = _compare(solution.scene, rod, rod.nodal(solution.q), other, other.nodal(found.q))
        distance = np.linalg.norm(moved, axis=1)
        place = int(np.argmax(distance)) if _tip_is_held(solution.scene, rod) else len(distance) - 1
        errors.append(float(distance[place]) / rod.rod.length / (1.0 - STILL))
        places.append(float(rod.mesh.breaks[place] / rod.rod.length))
        contributions.append(share)
    finer = replace(solution, scene=fine.scene, model=fine, q=found.q)
    return ErrorEstimate(tuple(errors), tuple(places), tuple(contributions), finer, found.lu, iterations)


def _equilibrium(
    fine: Model, start: Floats, tolerance: float, deadline: float
) -> tuple[NewtonResult | None, int]:
    """Equilibrium of the finer mesh near the coarse one, and the iterations that it took."""
    found = newton(fine, start, 1.0, QUICK_ITERATIONS, deadline)
    iterations = len(found.history)
    if found.converged:
        return found, iterations
    # Near a critical point, and where a shape may turn freely, steps end on rounding far above 1e-10.
    loose = Model(_with(fine.scene, tolerance=max(tolerance, fine.scene.solver.tolerance)))
    found = newton(loose, start, 1.0, DIRECT_ITERATIONS, deadline)
    iterations += len(found.history)
    if not found.converged:
        left = max(deadline - time.perf_counter(), LEAST_TIME)
        trace = find_equilibrium(Model(_with(fine.scene, max_seconds=left)))
        found = newton(loose, trace.q, 1.0, DIRECT_ITERATIONS, deadline)
        iterations += len(trace.history) + len(found.history)
    return (found if found.converged else None), iterations


def _with(scene: Scene, **options: float) -> Scene:
    return replace(scene, solver=replace(scene.solver, **options))


def _tip_is_held(scene: Scene, rod: RodModel) -> bool:
    """Whether the position of the rod's tip is prescribed."""
    name = rod.rod.name
    held = [joint for joint in scene.joints if joint.b is None and len(joint.along) == 3]
    grounded = [joint.a.at for joint in held if joint.a.rod == name]
    return any(at > 1.0 - SAME_PLACE for at in [support.at for support in rod.rod.supports] + grounded)


def _has_levers(scene: Scene, rod: RodModel) -> bool:
    """Whether elements move the tip by their lever: of a rod held at its base and nowhere else."""
    clamp, name = rod.rod.clamp, rod.rod.name
    joined = any(place.rod == name for joint in scene.joints for place in joint.places)
    return clamp is not None and clamp.at == 0.0 and not joined


def _compare(
    scene: Scene, rod: RodModel, q: Floats, finer: RodModel, q_fine: Floats
) -> tuple[Floats, Floats]:
    """Errors of the ends of elements (n_el + 1, 3) [m], and what each element moves the tip by (n_el,) [m].

    q : nodal vectors (n_nodes, vectors, 3), as `q_fine` on the mesh with each element cut in two
    """
    inner = len(rod.element.node_xi) - 1
    column = rod.element.vectors.index(R)
    r, r_fine = q[::inner, column], q_fine[:: 2 * inner, column]
    turned, turned_fine = node_rotations(rod, q)[::inner], node_rotations(finer, q_fine)[:: 2 * inner]
    # What an element adds, seen from its first section as the finer mesh has it.
    to_fine = turned_fine[:-1] @ np.swapaxes(turned[:-1], -1, -2)
    chord = np.einsum("nij,nj->ni", to_fine, np.diff(r, axis=0)) - np.diff(r_fine, axis=0)
    spin = log(to_fine @ turned[1:] @ np.swapaxes(turned_fine[1:], -1, -2))
    if _has_levers(scene, rod):
        share = np.linalg.norm(chord + np.cross(spin, r_fine[-1] - r_fine[1:]), axis=1)
    else:
        share = np.linalg.norm(chord, axis=1) + rod.rod.length * np.linalg.norm(spin, axis=1)
    return r - r_fine, share
