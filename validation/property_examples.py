"""Random examples of the properties: what is drawn, and which measure is taken on it.

Every function takes a source of numbers and the name of an element, and returns the observed value; 0 is
perfect.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf.effects import Effect
from ancf.elements import ELEMENTS
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.scene import Force, LineLoad, Moment, Scene
from validation import kernel_measures as kernel, solution_measures as solution
from validation.criteria import largest
from validation.energy_measures import integrated_energy
from validation.random_rods import (
    Draws,
    RodRange,
    bent_state,
    random_loads,
    random_model,
    random_rod,
    random_rotation,
    random_state,
    random_turn,
    random_vector,
)

Floats = NDArray[np.float64]
Observe = Callable[[Draws, str], float]

STRAIGHT = RodRange(curved=(False,), shear_factors=(False,))
# Solutions: stiff enough in compression to have one equilibrium at these loads, fine enough to find it.
SOLVED = RodRange(
    elements=(4, 6, 8),
    slenderness=(15.0, 50.0),
    poisson_ratio=(-0.3, 0.49),
    rules=("default", "full"),
    supports=("clamp", "free_section_clamp"),
)
LOAD = 0.7  # E I / L and E I / L^2
CLOSED_FORM = replace(STRAIGHT, elements=(12,), slenderness=(100.0, 200.0), poisson_ratio=(-0.3, 0.49))
# Finite strain (theory.md 2) moves the tip of a thin ring by 3.2e-3 L at L/R = 100 and |v| = 2.5, falling
# with (R/L)^2: from 200 on it is below half of the bound.
HELIX = replace(
    CLOSED_FORM,
    slenderness=(200.0, 400.0),
    shapes=("circle", "annulus"),
    formulations=("enhanced",),
    rules=("default",),
)
STRETCH = replace(
    STRAIGHT,
    elements=(1, 2, 5),
    slenderness=(5.0, 60.0),
    poisson_ratio=(-0.5, 0.499),
    supports=("free_section_clamp",),
)
BIAS = np.array([0.0, 0.0, 1.5])  # keeps random loads away from zero
LARGE_MOMENT = 2.5 / np.sqrt(3.0)  # component of v = M L / E I with |v| <= 2.5, the range of theory.md 3


# --- kernels
# --------------------------------------------------------------------------------------------------------


def rigid(measure: Callable[..., float]) -> Observe:
    """One measure of the reference after a rigid motion."""

    def observe(draws: Draws, element: str) -> float:
        model = random_model(draws, element)
        return measure(
            model, kernel.moved(model, random_rotation(draws), random_vector(draws, model.rod.length))
        )

    return observe


def far_rigid_strain(draws: Draws, element: str) -> float:
    """Strain of a rigid motion 1e6 m away over eps |r| / h."""
    model = random_model(draws, element)
    away = random_vector(draws, 1e6)
    away[draws.choice((0, 1, 2))] = 1e6
    q = kernel.moved(model, random_rotation(draws), away)
    resolution = np.finfo(float).eps * np.linalg.norm(away) / np.min(model.mesh.h)
    return kernel.largest_kernel_strain(model, q) / float(resolution)


def objectivity(draws: Draws, element: str) -> float:
    """See `kernel_measures.objectivity`."""
    model = random_model(draws, element)
    return kernel.objectivity(model, random_state(draws, model), random_rotation(draws))


def energy(draws: Draws, element: str) -> float:
    """Gram-form energy against the volume integral, relative, by what the section rule leaves of the law.

    Saint Venant-Kirchhoff is a polynomial and exact; degree 8 leaves 2e-8 of rubber at strains of 0.3.
    """
    model = random_model(draws, element)
    q = random_state(draws, model)
    rule = 1e-10 if isinstance(model.rod.material, SaintVenantKirchhoff) else 1e-6
    return abs(model.elastic.energy(kernel.per_element(model, q)) / integrated_energy(model, q) - 1.0) / rule


def elastic_orders(index: int) -> Observe:
    """See `kernel_measures.elastic_orders`; index 0 the order, 1 the error."""

    def observe(draws: Draws, element: str) -> float:
        model = random_model(draws, element)
        return kernel.elastic_orders(
            model, random_state(draws, model), random_state(draws, model) - model.q0
        )[index]

    return observe


def asymmetry(draws: Draws, element: str) -> float:
    """Relative asymmetry of the elastic tangent, mixed or plain."""
    model = random_model(draws, element)
    e, e_previous = (kernel.per_element(model, random_state(draws, model)) for _ in range(2))
    _, K = model.elastic.force_and_tangent(e, e_previous)
    return float(np.max(np.abs(K - np.swapaxes(K, -1, -2))) / np.max(np.abs(K)))


def mixed_tangent(draws: Draws, element: str) -> float:
    """Mixed-integration-point tangent at rest, and its predicted strain."""
    model = random_model(draws, element)
    q, q_previous = random_state(draws, model), random_state(draws, model)
    same = kernel.mixed_tangent_difference(model, q)
    return largest(same, kernel.mixed_prediction_error(model, q, q_previous))


def patch(measure: Callable[..., float]) -> Observe:
    """One measure of a straight rod in a random state of constant strain."""

    def observe(draws: Draws, element: str) -> float:
        F = np.diag([1.02, 0.97, 1.01]) + 0.1 * np.array([random_vector(draws) for _ in range(3)])
        return measure(random_model(draws, element, STRAIGHT), random_rotation(draws) @ F)

    return observe


def zero_modes(bent: bool) -> Observe:
    """Zero modes other than six, plus one where the gap to the seventh is below 1e4."""

    def observe(draws: Draws, element: str) -> float:
        model = random_model(draws, element, RodRange(elements=(1, 2, 3), slenderness=(8.0, 60.0)))
        if bent:
            q = bent_state(model, random_turn(draws, model)) @ random_rotation(draws).T
            count, gap = kernel.zero_modes(kernel.assembled(model, kernel.strain_tangent(model, q)))
        else:
            count, gap = kernel.zero_modes(
                kernel.assembled(model, model.elastic.force_and_tangent(model.e0)[1])
            )
        return abs(count - 6) + (0.0 if gap > 1e4 else 1.0)

    return observe


# --- loads
# ----------------------------------------------------------------------------------------------------------


def moment_identities(draws: Draws, element: str) -> float:
    """Resultant and power of a point moment, every definition and direction."""
    kind, direction = draws.choice(("section", "vorticity")), draws.choice(("fixed", "follower"))
    moment = Moment("rod", draws.number(0.0, 1.0), random_vector(draws) + BIAS, direction, kind)
    model = Model(Scene((random_rod(draws, element),), moments=(moment,)))
    rod = model.rods[0]
    q = random_state(draws, rod)
    dq = np.random.default_rng(draws.choice(range(2**16))).uniform(-1.0, 1.0, q.shape)
    Q = np.zeros(model.n)
    for effect, e in _loads(model, q):
        np.add.at(Q, effect.dofs, effect.force(e).reshape(effect.dofs.shape))
    # On an element boundary r_x has two values: the vorticity is the mean of both sides.
    spin = kernel.section_spin if kind == "section" else kernel.vorticity
    sides = []
    for before in (False, True):
        point = rod.section_point(moment.at, before)
        e, de = (x.ravel()[point.dofs].reshape(-1, 3) for x in (q, dq))
        sides.append(spin(point, e, de))
        M = kernel.polar_rotation(point, e) @ moment.value if direction == "follower" else moment.value
    w = 0.5 * (sides[0] + sides[1])
    power = abs(np.sum(Q * dq.ravel()) - M @ w) / (np.linalg.norm(M) * np.linalg.norm(w))
    return largest(kernel.moment_resultant(Q.reshape(q.shape), q, M), float(power))


def _loads(model_of: Model, q: Floats) -> list[tuple[Effect, Floats]]:
    return [(effect, q.ravel()[effect.dofs].reshape(len(effect.dofs), -1, 3)) for effect in model_of.effects]


def load_orders(index: int) -> Observe:
    """See `kernel_measures.load_orders`: every kind of load at once."""

    def observe(draws: Draws, element: str) -> float:
        rod = random_rod(draws, element)
        # No sliver beside the load: positions rounded to eps L leave r_x eps L/h in an element of length h.
        at = draws.choice((0.0, 1.0, draws.number(0.1, 0.9)))
        value = random_vector(draws) + BIAS
        size = 0.5 * rod.section.outer_radius
        direction = draws.choice(("fixed", "follower"))
        scene = Scene(
            (rod,),
            moments=tuple(Moment("rod", at, value, direction, kind) for kind in ("section", "vorticity")),
            forces=(Force("rod", at, value, random_vector(draws, size)[:2], direction),),
            line_loads=(LineLoad("rod", value, direction),),
        )
        model = Model(scene)
        # Noise as large as the vectors moves every one of them: a direction of only small strains, when the
        # state's turns are drawn as zero, changes a load so little that rounding hides the order.
        q, other = random_state(draws, model.rods[0]), random_state(draws, model.rods[0], strain=2.0)
        change = 0.1 * (other - model.rods[0].q0)
        worst = [
            kernel.load_orders(effect, e, de)[index]
            for (effect, e), (_, de) in zip(_loads(model, q), _loads(model, change), strict=True)
        ]
        return largest(*worst)

    return observe


# --- solutions
# ------------------------------------------------------------------------------------------------------


def _scene(draws: Draws, element: str) -> Scene:
    # Few elements where an iteration is dear: the statements hold on any mesh.
    allowed = replace(SOLVED, elements=(4,)) if ELEMENTS[element].quadratic_section else SOLVED
    return random_loads(draws, random_rod(draws, element, allowed), LOAD)


def turned(draws: Draws, element: str) -> float:
    """Solution of the turned scene against the turned solution."""
    scene, rotation = _scene(draws, element), random_rotation(draws)
    before, after = (solution.shape(solution.solved(s)) for s in (scene, solution.turned(scene, rotation)))
    return solution.difference((before[0] @ rotation.T, before[1] @ rotation.T), after)


def shifted(draws: Draws, element: str) -> float:
    """Solution of the scene 2.5e6 L away against the solution."""
    scene = _scene(draws, element)
    away = random_vector(draws)
    # 1e6 m for a rod of 0.4 m: absolute positions are stored to eps 1e6 m = 2.2e-10 m, 6e-10 of such a rod
    shift = 2.5e6 * scene.rods[0].length * away
    return solution.difference(
        *(solution.shape(solution.solved(s)) for s in (scene, solution.shifted(scene, shift)))
    )


def mirrored(draws: Draws, element: str) -> float:
    """Solution of the mirror image against the mirrored solution."""
    scene = _scene(draws, element)
    (r, g), image = (solution.shape(solution.solved(s)) for s in (scene, solution.mirrored(scene)))
    M = np.diag([1.0, -1.0, 1.0])
    return solution.difference((r @ M, np.array([[-1.0], [1.0]]) * (g @ M)), image)


def reversed(draws: Draws, element: str) -> float:
    """Solution of the rod described from its other end against the solution."""
    scene = _scene(draws, element)
    a, b = solution.solved(scene), solution.solved(solution.reversed_rod(scene))
    (r, g), (r_back, g_back) = solution.shape(a), solution.shape(b, reverse=True)
    bases = (b.scene.rods[0].base.position - scene.rods[0].base.position) / scene.rods[0].length
    return solution.difference((r, g), (r_back + bases, np.array([[1.0], [-1.0]]) * g_back))


def scaled(draws: Draws, element: str) -> float:
    """Solution in mm, g, s against the solution in m, kg, s."""
    scene = _scene(draws, element)
    other = solution.millimetres_and_grams(scene)
    return solution.difference(*(solution.shape(solution.solved(s)) for s in (scene, other)))


def on_scene(measure: Callable[[Scene], float]) -> Observe:
    """One measure of a random scene."""
    return lambda draws, element: measure(_scene(draws, element))


def reciprocity(draws: Draws, element: str) -> float:
    """Betti's theorem for two point loads on one rod."""
    # Loads on the uniform grid: both scenes then have the same mesh.
    rod = random_rod(draws, element, replace(SOLVED, elements=(4, 8)))
    unit = solution.bending_stiffness(rod) / rod.length**2
    first, second = (draws.choice((1.0, 0.75, 0.5)) for _ in range(2))
    bias = np.array([0.0, 1.5, 0.0])  # a load of size 1 at least
    a = Force("rod", first, unit * (random_vector(draws) + bias))
    value = unit * (random_vector(draws) + bias)
    b = (
        Moment("rod", second, value * rod.length)
        if ELEMENTS[element].has_section and draws.choice((False, True))
        else Force("rod", second, value)
    )
    return solution.reciprocity(rod, a, b)


def supports(draws: Draws, element: str) -> float:
    """Largest violation of the support conditions C (q - q0) = 0."""
    scene = _scene(draws, element)
    scene = replace(scene, solver=replace(scene.solver, predictor=draws.choice(("auto", "none"))))
    found = solution.solved(scene)
    moved = (found.q - found.model.q0) / found.model.unit
    return largest(*(float(np.max(np.abs(s.rows @ moved[s.dofs]))) for s in found.model.supports))


def resumed(draws: Draws, element: str) -> float:
    """Solution saved and resumed against the solution; it takes two iterations at most."""
    scene = _scene(draws, element)
    first = solution.solved(scene)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "state.npz"
        first.save(path)
        again = ancf.resume(scene, path)
    return solution.difference(solution.shape(first), solution.shape(again)) + (again.iterations > 2)


def helix(measure: Callable[..., float]) -> Observe:
    """One measure of a straight round rod under a random tip moment."""

    def observe(draws: Draws, element: str) -> float:
        v = random_vector(draws, LARGE_MOMENT)
        v[2] = np.copysign(max(abs(v[2]), 0.1), v[2])
        return measure(random_rod(draws, element, HELIX), v)

    return observe


def stretched(draws: Draws, element: str) -> float:
    """See `solution_measures.stretch_error`."""
    return solution.stretch_error(random_rod(draws, element, STRETCH), draws.number(0.85, 1.3))
