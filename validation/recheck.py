"""Is a solution one? Equilibrium and energy checked without the solver's kernel, tangent or load arrays.

The energy is the volume integral of the law in F (energy_measures.py). Virtual work is that of the loads as
the scene lists them, on poses of the moved rod: a force on its point, a moment on the turn of its section,
weight and line loads by quadrature. At an equilibrium both agree for every motion that the supports allow;
the derivative of the energy is taken by differences along random motions.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ancf.effects.line_load import FOLLOWER_POINTS
from ancf.quadrature import gauss
from ancf.rod_model import RodModel
from ancf.rotation import log
from ancf.scene import Force, Moment
from ancf.solution import Solution
from validation.energy_measures import integrated_energy
from validation.kernel_measures import frame_and_gradients

Floats = NDArray[np.float64]

# Of a motion by a radian; what truncation leaves falls with the fourth power, what rounding leaves rises. The
# last ones are for elements of 1e-5 of the length, which longer ones turn inside out.
STEPS = (1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
GOOD = 1e-8  # no smaller step is tried
SMALL = 1e-2
SECTION_DEGREE = 4  # of the monomials of quadratic sections times det J_0, plus one
ALONG = 6  # Gauss points of weight and line loads in each element


def energy_error(solution: Solution) -> float:
    """Difference of the kernel's strain energy from the volume integral, over E I/L plus the energy."""
    error = 0.0
    for rod in solution.model.rods:
        U = solution.strain_energy(rod.rod.name)
        exact = integrated_energy(rod, rod.nodal(solution.q))
        error = max(error, abs(U - exact) / (abs(U) + rod.bending_stiffness / rod.rod.length))
    return error


@np.errstate(invalid="ignore")  # a step that turns an element inside out says nothing; the next one decides
def work_error(solution: Solution, rng: np.random.Generator, motions: int = 2) -> float:
    """Largest difference of inner and outer virtual work, over E I/L plus either, in random motions."""
    unit = max(rod.bending_stiffness / rod.rod.length for rod in solution.model.rods)
    worst = 0.0
    for _ in range(motions):
        motion = _motion(solution, rng)
        error = np.inf
        for step in STEPS:
            inner, outer = _works(solution, motion, step)
            error = min(error, abs(inner - outer) / (unit + abs(inner) + abs(outer)))
            if error <= GOOD:
                break
        worst = max(worst, error)
    return worst


def _works(solution: Solution, motion: Floats, step: float) -> tuple[float, float]:
    """Virtual work of stress and of the loads per unit of a motion, by fourth-order differences."""
    inner, outer = 0.0, 0.0
    for share, weight in ((1.0, 8.0), (2.0, -1.0)):
        ahead, behind = (
            replace(solution, q=solution.q + side * share * step * motion) for side in (1.0, -1.0)
        )
        inner += weight * (_energy(ahead) - _energy(behind)) / (12.0 * step)
        outer += weight * _work_of_loads(solution, ahead, behind) / (12.0 * step)
    return inner, outer


def _motion(solution: Solution, rng: np.random.Generator) -> Floats:
    """Motion (n,) that bends, twists and shears the rods, and stretches them as little as it can.

    The sections spin by a polynomial w(s), zero at the supports, and the axis goes along, r' = w x r_x,
    so that the stiffness against stretch does not drown the work; a hundredth of any other motion is added.
    """
    model = solution.model
    motion = np.zeros(model.n)
    for rod in model.rods:
        s, q = rod.mesh.node_x / rod.rod.length, rod.nodal(solution.q)
        free = np.prod([s - support.at for support in rod.rod.supports], axis=0)[:, None]
        powers = np.stack([s**k for k in range(3)], axis=1)
        w = free * (powers @ rng.uniform(-1, 1, (3, 3)))
        part = np.cross(w[:, None], q)
        steps = 0.5 * np.cross(w[:-1] + w[1:], np.diff(q[:, 0], axis=0))
        held = int(np.argmin(np.abs(s - rod.rod.supports[0].at)))
        part[:, 0] = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
        part[:, 0] -= part[held, 0]
        any_motion = np.einsum("nij,nvj->nvi", np.tensordot(powers, rng.uniform(-1, 1, (3, 3, 3)), 1), q)
        any_motion[:, 0] = powers @ rng.uniform(-1, 1, (3, 3)) * rod.rod.length
        part += SMALL * free[:, None] * any_motion
        motion[rod.first_dof : rod.first_dof + rod.size] = part.ravel()
    return model.system.project(motion)


def _energy(solution: Solution) -> float:
    return sum(integrated_energy(rod, rod.nodal(solution.q)) for rod in solution.model.rods)


def _work_of_loads(here: Solution, ahead: Solution, behind: Solution) -> float:
    """Work of the loads at the solution `here` from `behind` to `ahead`, two states close to it."""
    scene = here.scene
    work = 0.0
    for load in scene.forces:
        work += float(_present(here, load) @ (_place(ahead, load) - _place(behind, load)))
    for load in scene.moments:
        turn = log(ahead.pose(load.rod, load.at).rotation @ behind.pose(load.rod, load.at).rotation.T)
        work += float(_present(here, load) @ turn)
    for rod in here.model.rods:
        name = rod.rod.name
        # A following load is the one that its own rule makes of it; for dead ones the rule is exact.
        xi, weight = gauss(FOLLOWER_POINTS)
        at = (rod.mesh.breaks[:-1, None] + 0.5 * rod.mesh.h[:, None] * (1.0 + xi)).ravel() / rod.rod.length
        dx = (0.5 * rod.mesh.h[:, None] * weight).ravel()
        way = ahead.displaced(name, at, 0.0, 0.0) - behind.displaced(name, at, 0.0, 0.0)
        for load in scene.line_loads:
            if load.rod == name:
                value = (
                    [_turned(here, name, x, load.value) for x in at]
                    if load.direction == "follower"
                    else load.value
                )
                work += float(np.sum(dx[:, None] * way * value))
        if scene.gravity is not None:
            work += float(_weight(rod, ahead, behind) @ scene.gravity.acceleration)
    return here.load_factor * work


def _place(solution: Solution, load: Force) -> Floats:
    """Where a point force acts (3,): its point, or the mean under its affine traction.

    The latter on sections that are not linear.

    Traction (1/A + y y_0/I_z + z z_0/I_y) F has the resultant F at (y_0, z_0); the matrix of second moments
    is inverted where it is not diagonal.
    """
    rod = next(rod for rod in solution.model.rods if rod.rod.name == load.rod)
    y_0, z_0 = load.offset
    if rod.element.linear_section:
        return solution.displaced(load.rod, load.at, y_0, z_0)
    y, z, area = rod.rod.section_at(load.at).quadrature(SECTION_DEGREE)
    points = np.column_stack([y, z])
    slopes = np.linalg.solve(points.T @ (area[:, None] * points), np.array([y_0, z_0]))
    traction = area * (1.0 / area.sum() + points @ slopes)
    return traction @ solution.displaced(load.rod, load.at, y, z)


def _present(here: Solution, load: Force | Moment) -> Floats:
    """A load in SCS as it acts at the solution."""
    return _turned(here, load.rod, load.at, load.value) if load.direction == "follower" else load.value


def _turned(here: Solution, rod: str, at: float, value: Floats) -> Floats:
    return here.pose(rod, float(at)).rotation @ value


def _weight(rod: RodModel, ahead: Solution, behind: Solution) -> Floats:
    """Sum of mass times way (3,) [kg m] over the rod, by the volume of its interpolated reference."""
    name, total = rod.rod.name, np.zeros(3)
    for e0, start, h in zip(rod.e0, rod.mesh.breaks[:-1], rod.mesh.h, strict=True):
        for xi, weight in zip(*gauss(ALONG), strict=True):
            at = float(start + 0.5 * h * (1.0 + xi)) / rod.rod.length
            y, z, area = rod.rod.section_at(at).quadrature(SECTION_DEGREE)
            _, J_0 = frame_and_gradients(rod, e0, xi, h, y, z)
            way = ahead.displaced(name, at, y, z) - behind.displaced(name, at, y, z)
            density = rod.rod.parts[rod.rod.part_at(at)].material.density
            assert density is not None
            total += 0.5 * h * weight * density * ((area * np.linalg.det(J_0)) @ way)
    return total
