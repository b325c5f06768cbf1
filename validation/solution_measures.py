"""What the property checks measure on solutions: symmetries, balance, reciprocity, independence of the path.

Lengths are compared in units of the rod's length L, forces of E I / L^2, moments of E I / L. A scene without
equilibrium counts as an infinite error: the scenes asked for here all have one.

Symbols
-------
A_o, r_b   rotation and position of the base;  k = (twist, about y, about z) reference curvature
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf.elements import ELEMENTS
from ancf.mesh import reference_axis
from ancf.scene import Force, Frame, Gravity, LineLoad, Moment, Rod, Scene, Support
from ancf.sections import Annulus, Circle, Ellipse, Polygon, Rectangle, Section
from ancf.solution import Solution
from reference.root import bracketed_root
from validation.criteria import largest
from validation.energy_measures import solid_law
from validation.kernel_measures import frame_and_gradients

Floats = NDArray[np.float64]

STATIONS = (0.2, 0.5, 0.8, 1.0)
# Lateral stretches of uniaxial states between 0.85 and 1.3, nu from -0.5 to 0.499: 0.81 to 1.16 in all laws.
# Neo-Hookean material of nu < 0 has a second, unstable state (P_yy falls as the section widens) up to 0.53.
LATERAL = (0.75, 1.25)


class NotConverged(RuntimeError):
    """A scene that has an equilibrium was not solved."""


def solved(scene: Scene) -> Solution:
    """Solution of a scene that has one; raises `NotConverged` with the solver's reason otherwise."""
    solution = ancf.solve(scene)
    if solution.status is not ancf.Status.CONVERGED:
        raise NotConverged(solution.reason)
    return solution


def shape(solution: Solution, reverse: bool = False) -> tuple[Floats, Floats]:
    """Positions relative to the base over L (n, 3), section gradients r_y, r_z (n, 2, 3) at the stations."""
    rod = solution.scene.rods[0]
    stations = [1.0 - at if reverse else at for at in (0.0, *STATIONS)]
    poses = [solution.pose(None, at) for at in stations]
    position = np.array([(p.position - rod.base.position) / rod.length for p in poses])
    return position, np.array([[p.r_y, p.r_z] for p in poses])


def difference(a: tuple[Floats, Floats], b: tuple[Floats, Floats]) -> float:
    """Largest difference of two shapes: positions in L, gradients as they are."""
    return largest(*(float(np.max(np.abs(x - y))) for x, y in zip(a, b, strict=True)))


def bending_stiffness(rod: Rod) -> float:
    """Smaller principal E I [N m2]."""
    return rod.material.young_modulus * float(np.linalg.eigvalsh(rod.section.second_moments)[0])


# --- symmetries: the same rod described in another way
# ------------------------------------------------------------


def turned(scene: Scene, rotation: Floats) -> Scene:
    """The scene with base and loads turned about the origin."""
    rod = scene.rods[0]
    base = Frame(rotation @ rod.base.position, rotation @ rod.base.rotation)
    return _changed(scene, replace(rod, base=base), lambda v, polar: rotation @ v)


def shifted(scene: Scene, vector: Floats) -> Scene:
    """The scene with the base moved."""
    rod = scene.rods[0]
    return replace(scene, rods=(replace(rod, base=Frame(rod.base.position + vector, rod.base.rotation)),))


def mirrored(scene: Scene) -> Scene:
    """The mirror image in the plane y = 0 of SCS, the section mirrored in its own plane y = 0.

    With M = diag(1, -1, 1): base M A_o M, curvature and moments (axial vectors) -M k and -M m, forces M f.
    """
    rod, M = scene.rods[0], np.diag([1.0, -1.0, 1.0])
    base = Frame(M @ rod.base.position, M @ rod.base.rotation @ M)
    image = replace(rod, base=base, curvature=-M @ rod.curvature, section=_flipped(rod, y=-1.0))
    return _changed(scene, image, lambda v, axial: -M @ v if axial else M @ v, (-1.0, 1.0))


def reversed_rod(scene: Scene) -> Scene:
    """The same body described from its other end: x' = -x, y' = y, z' = -z, clamp at 1, loads at 1 - at.

    With B = diag(-1, 1, -1) the frames are R B, and dR'/dx' = -R hat(k) B = R' hat(-B k).
    """
    rod, B = scene.rods[0], np.diag([-1.0, 1.0, -1.0])
    position, frame = reference_axis(np.array([rod.length]), rod.curvature)
    A_o = rod.base.rotation
    other = replace(
        rod,
        base=Frame(rod.base.position + A_o @ position[0], A_o @ frame[0] @ B),
        curvature=-B @ rod.curvature,
        section=_flipped(rod, z=-1.0),
        supports=tuple(Support(1.0 - s.at, s.kind) for s in rod.supports),
    )
    return _changed(scene, other, lambda v, axial: v, (1.0, -1.0), reverse=True)


def millimetres_and_grams(scene: Scene) -> Scene:
    """The scene in mm, g, s: E as before, forces by 1e6, moments by 1e9, density by 1e-6."""
    rod = scene.rods[0]
    material = rod.material
    density = None if material.density is None else material.density * 1e-6
    other = replace(
        rod,
        length=rod.length * 1e3,
        section=_scaled(rod, 1e3),
        material=replace(material, density=density),
        base=Frame(rod.base.position * 1e3, rod.base.rotation),
        curvature=rod.curvature * 1e-3,
    )
    return replace(
        scene,
        rods=(other,),
        moments=tuple(replace(m, value=m.value * 1e9) for m in scene.moments),
        forces=tuple(replace(f, value=f.value * 1e6, offset=f.offset * 1e3) for f in scene.forces),
        line_loads=tuple(replace(f, value=f.value * 1e3) for f in scene.line_loads),
        gravity=None if scene.gravity is None else Gravity(scene.gravity.acceleration * 1e3),
    )


def _changed(
    scene: Scene,
    rod: Rod,
    vector: Callable[[Floats, bool], Floats],
    offset: tuple[float, float] = (1.0, 1.0),
    reverse: bool = False,
) -> Scene:
    """The scene with another rod, load vectors mapped by `vector(value, axial)`, places turned around."""

    def at(value: float) -> float:
        return 1.0 - value if reverse else value

    def moved(force: Force) -> Force:
        return replace(force, value=vector(force.value, False), at=at(force.at), offset=force.offset * offset)

    gravity = scene.gravity
    return replace(
        scene,
        rods=(rod,),
        moments=tuple(replace(m, value=vector(m.value, True), at=at(m.at)) for m in scene.moments),
        forces=tuple(moved(force) for force in scene.forces),
        line_loads=tuple(replace(f, value=vector(f.value, False)) for f in scene.line_loads),
        gravity=None if gravity is None else Gravity(vector(gravity.acceleration, False)),
    )


def _flipped(rod: Rod, y: float = 1.0, z: float = 1.0) -> Section:
    """The section with y or z reversed; only polygons see it."""
    if not isinstance(rod.section, Polygon):
        return rod.section
    return Polygon(tuple((y * a, z * b) for a, b in reversed(rod.section.points)))


def _scaled(rod: Rod, factor: float) -> Section:
    """The section with all its lengths multiplied."""
    section = rod.section
    if isinstance(section, Polygon):
        return Polygon(tuple((factor * a, factor * b) for a, b in section.points))
    assert isinstance(section, Circle | Annulus | Ellipse | Rectangle)
    return replace(section, **{f.name: factor * getattr(section, f.name) for f in fields(section)})


# --- balance and reciprocity
# --------------------------------------------------------------------------------------


def applied(solution: Solution) -> tuple[Floats, Floats]:
    """Resultant of all loads: force (3,) [N], moment (3,) about the base [N m], from the deformed positions
    alone.
    """
    scene, model = solution.scene, solution.model.rods[0]
    rod, base = scene.rods[0], scene.rods[0].base.position
    force, moment = np.zeros(3), np.zeros(3)
    for m in scene.moments:
        moment += solution.pose(None, m.at).rotation @ m.value if m.direction == "follower" else m.value
    for f in scene.forces:
        value = solution.pose(None, f.at).rotation @ f.value if f.direction == "follower" else f.value
        force += value
        arm = loaded_point(solution, f.at, f.offset) - base
        moment += np.cross(arm, value)
    for load in scene.line_loads:
        # Three points an element: exact for a dead load, the rule of the program for a follower.
        for x, weight in _axial(model.mesh.breaks, 3):
            pose = solution.pose(None, x / rod.length)
            value = weight * (pose.rotation @ load.value if load.direction == "follower" else load.value)
            force += value
            moment += np.cross(pose.position - base, value)
    if scene.gravity is not None:
        density, weight, first = rod.material.density or 0.0, 0.0, np.zeros(3)
        y, z, area = rod.section.quadrature(16 if np.any(rod.curvature) else 4)
        for e0, left, right in zip(model.e0, model.mesh.breaks[:-1], model.mesh.breaks[1:], strict=True):
            for x, share in _axial(np.array([left, right]), 5):
                xi = 2.0 * (x - left) / (right - left) - 1.0
                volume = np.ones_like(area)  # of a cable, which is straight
                if model.element.has_section:
                    volume = np.linalg.det(frame_and_gradients(model, e0, xi, right - left, y, z)[1])
                mass = density * share * area * volume
                weight += mass.sum()
                first += mass @ (solution.displaced(None, np.full(len(y), x / rod.length), y, z) - base)
        force += weight * scene.gravity.acceleration
        moment += np.cross(first, scene.gravity.acceleration)
    return force, moment


def loaded_point(solution: Solution, at: float, offset: Floats) -> Floats:
    """Point (3,) [m] that a force moves: the value at `offset` of the affine map nearest to the section.

    In a linear section that is the material point itself; a quadratic one takes an affine traction.
    """
    y, z, weight = solution.scene.rods[0].section.quadrature(8)
    points = solution.displaced(None, np.full(len(y), at), y, z)
    affine = np.column_stack([np.ones_like(y), y, z])
    weighted = affine * weight[:, None]
    coefficients = np.linalg.solve(weighted.T @ affine, weighted.T @ points)
    return np.asarray(np.array([1.0, *offset]) @ coefficients, float)


def _axial(breaks: Floats, points: int) -> list[tuple[float, float]]:
    xi, weight = np.polynomial.legendre.leggauss(points)
    return [
        (0.5 * (a + b) + 0.5 * (b - a) * s, 0.5 * (b - a) * w)
        for a, b in pairwise(breaks)
        for s, w in zip(xi, weight, strict=True)
    ]


def imbalance(scene: Scene) -> float:
    """|reaction + loads| over max(load, E I / L^2), or E I / L, in units of 1e-10 + ten residual floors."""
    solution = solved(scene)
    rod = scene.rods[0]
    force, moment = applied(solution)
    reaction_force, reaction_moment = solution.reaction()
    unit = bending_stiffness(rod) / rod.length**2
    worst = largest(
        float(np.max(np.abs(force + reaction_force))) / max(float(np.linalg.norm(force)), unit),
        float(np.max(np.abs(moment + reaction_moment)))
        / max(float(np.linalg.norm(moment)), unit * rod.length),
    )
    return worst / (1e-10 + 10.0 * solution.residual_floor)


def reciprocity(rod: Rod, a: Force, b: Force | Moment, step: float = 1e-4) -> float:
    """Betti: the work of load a on the displacement by b against the reverse, relative; `step` E I / L^2
    scales both.

    Both signs of each load are solved, so that what is quadratic in the load drops out.
    """
    motions = []
    for load in (a, b):
        pair = [solved(_loaded(rod, replace(load, value=sign * step * load.value))) for sign in (1.0, -1.0)]
        motions.append([_conjugate(pair, at) for at in (a, b)])
    work_ab, work_ba = float(a.value @ motions[1][0]), float(b.value @ motions[0][1])
    own = float(np.sqrt(abs((a.value @ motions[0][0]) * (b.value @ motions[1][1]))))
    return abs(work_ab - work_ba) / own


def _loaded(rod: Rod, load: Force | Moment) -> Scene:
    return Scene((rod,), forces=(load,)) if isinstance(load, Force) else Scene((rod,), moments=(load,))


def _conjugate(plus_minus: list[Solution], load: Force | Moment) -> Floats:
    """Displacement of the point of a force, or small rotation of the section of a moment, between two
    solutions.
    """
    plus, minus = plus_minus
    if isinstance(load, Force):
        return loaded_point(plus, load.at, load.offset) - loaded_point(minus, load.at, load.offset)
    turn = plus.pose(None, load.at).rotation @ minus.pose(None, load.at).rotation.T
    return 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])


# --- independence of how the solution is found
# --------------------------------------------------------------------


def path_dependence(scene: Scene) -> float:
    """Difference of the solutions with and without the predictor: one step against many."""
    walked = replace(scene, solver=replace(scene.solver, predictor="none"))
    return difference(shape(solved(scene)), shape(solved(walked)))


def difference_tangent_dependence(scene: Scene) -> float:
    """Difference of the solutions with the analytic and the paper's finite-difference tangent."""
    numerical = replace(scene, solver=replace(scene.solver, tangent="finite-difference"))
    return difference(shape(solved(scene)), shape(solved(numerical)))


def zero_effects(scene: Scene) -> float:
    """Number of coordinates that change, even in the last bit, when loads of zero magnitude are added."""
    rod, zero = scene.rods[0], np.zeros(3)
    turning = ("fixed", "follower") if ELEMENTS[rod.element].has_section else ("fixed",)
    moments = tuple(Moment(rod.name, 1.0, zero, direction) for direction in turning)
    more = replace(
        scene,
        moments=(*scene.moments, *(moments if len(turning) > 1 else ())),
        forces=(*scene.forces, *(Force(rod.name, 1.0, zero, direction=d) for d in turning)),
        line_loads=(*scene.line_loads, *(LineLoad(rod.name, zero, d) for d in turning)),
        gravity=scene.gravity or Gravity(zero),
    )
    return float(np.count_nonzero(solved(scene).q != solved(more).q))


# --- closed forms
# -------------------------------------------------------------------------------------------------


def helix_error(rod: Rod, v: Floats) -> float:
    """Tip position error / L of a straight round rod under M = v E I / L, against theory.md 1."""
    stiffness = bending_stiffness(rod)
    solution = solved(Scene((rod,), moments=(Moment(rod.name, 1.0, v * stiffness / rod.length),)))
    e, phi = rod.base.rotation[:, 0], float(np.linalg.norm(v))
    m = v / phi
    tip = m * (m @ e) + np.sin(phi) / phi * (e - m * (m @ e)) + (1.0 - np.cos(phi)) / phi * np.cross(m, e)
    return float(np.linalg.norm((solution.tip().position - rod.base.position) / rod.length - tip))


def section_moment_error(rod: Rod, v: Floats) -> float:
    """Largest |m(s) - M| L / E I along a rod under the tip moment M = v E I / L: m is constant in space."""
    stiffness = bending_stiffness(rod)
    solution = solved(Scene((rod,), moments=(Moment(rod.name, 1.0, v * stiffness / rod.length),)))
    return float(np.max(np.abs(solution.section_forces().moment * rod.length / stiffness - v)))


def stretch_error(rod: Rod, stretch: float) -> float:
    """Error of axial and lateral stretch under the force of a uniaxial state, sections free to contract.

    The lateral stretch t makes P_yy(diag(s, t, t)) = 0; the force is A P_xx, P = dPsi/dF of the law in
    `reference/`.
    """
    law = solid_law(rod.material)

    def nominal(lateral: float) -> Floats:
        return law.stress(np.diag([stretch, lateral, lateral]))

    lateral = bracketed_root(lambda t: float(nominal(t)[1, 1]) / rod.material.young_modulus, *LATERAL)
    P = float(nominal(lateral)[0, 0]) * rod.section.area
    solution = solved(Scene((rod,), forces=(Force(rod.name, 1.0, P * rod.base.rotation[:, 0]),)))
    tip = solution.tip()
    axial = float((tip.position - rod.base.position) @ rod.base.rotation[:, 0]) / rod.length
    return largest(
        abs(axial - stretch),
        abs(float(np.linalg.norm(tip.r_y)) - lateral),
        abs(float(np.linalg.norm(tip.r_z)) - lateral),
    )
