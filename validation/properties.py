"""Property checks of the solver: statements that hold for every rod, each measured on random examples.

`PROPERTIES` is used by the report (examples drawn with NumPy) and by the property tests (examples drawn with
Hypothesis); both call the same measuring functions. Observed 0 is perfect, a property holds while observed <= bound.
"""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf.effects import Effect
from ancf.elements import ELEMENTS
from ancf.model import Model
from ancf.scene import Force, LineLoad, Moment, Scene
from validation import kernel_measures as kernel
from validation import solution_measures as solution
from validation.random_rods import (
    Draws,
    RngDraws,
    RodRange,
    bent_state,
    random_loads,
    random_model,
    random_rod,
    random_rotation,
    random_state,
    random_vector,
)

Floats = NDArray[np.float64]

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
HELIX = replace(CLOSED_FORM, shapes=("circle", "annulus"), formulations=("enhanced",), rules=("default",))
STRETCH = replace(
    STRAIGHT, elements=(1, 2, 5), slenderness=(5.0, 60.0), poisson_ratio=(-0.5, 0.499), supports=("free_section_clamp",)
)
LARGE_MOMENT = 2.5 / np.sqrt(3.0)  # component of v = M L / E I with |v| <= 2.5, the range of theory.md 3


@dataclass(frozen=True)
class Property:
    """A statement with its bound; `observe` measures one example on a rod of the given element.

    name: identifier; title: the statement; bound and unit of the observed value; source: where the statement and the
    bound come from; solves: whether an example solves scenes (tens of milliseconds instead of a few); elements: names
    of the elements it is promised for, empty for all.
    """

    name: str
    title: str
    bound: float
    unit: str
    source: str
    observe: Callable[[Draws, str], float]
    solves: bool = False
    elements: tuple[str, ...] = ()

    @property
    def element_names(self) -> tuple[str, ...]:
        """Elements it is promised for."""
        return self.elements or tuple(ELEMENTS)

    def run(self, rng: np.random.Generator) -> float:
        """Observed value of one random example."""
        draws = RngDraws(rng)
        return self.observe(draws, draws.choice(self.element_names))


# --- kernels --------------------------------------------------------------------------------------------------------


def _rigid(measure: Callable[..., float]) -> Callable[[Draws, str], float]:
    def observe(draws: Draws, element: str) -> float:
        model = random_model(draws, element)
        return measure(model, kernel.moved(model, random_rotation(draws), random_vector(draws, model.rod.length)))

    return observe


def _far_rigid_strain(draws: Draws, element: str) -> float:
    model = random_model(draws, element)
    away = random_vector(draws, 1e6)
    away[draws.choice((0, 1, 2))] = 1e6
    q = kernel.moved(model, random_rotation(draws), away)
    resolution = np.finfo(float).eps * np.linalg.norm(away) / np.min(model.mesh.h)
    return kernel.largest_kernel_strain(model, q) / float(resolution)


def _objectivity(draws: Draws, element: str) -> float:
    model = random_model(draws, element)
    return kernel.objectivity(model, random_state(draws, model), random_rotation(draws))


def _energy(draws: Draws, element: str) -> float:
    model = random_model(draws, element)
    q = random_state(draws, model)
    return abs(model.elastic.energy(kernel.per_element(model, q)) / kernel.integrated_energy(model, q) - 1.0)


def _elastic_orders(index: int) -> Callable[[Draws, str], float]:
    def observe(draws: Draws, element: str) -> float:
        model = random_model(draws, element)
        return kernel.elastic_orders(model, random_state(draws, model), random_state(draws, model) - model.q0)[index]

    return observe


def _asymmetry(draws: Draws, element: str) -> float:
    model = random_model(draws, element)
    e, e_previous = (kernel.per_element(model, random_state(draws, model)) for _ in range(2))
    _, K = model.elastic.force_and_tangent(e, e_previous)
    return float(np.max(np.abs(K - np.swapaxes(K, -1, -2))) / np.max(np.abs(K)))


def _mixed_tangent(draws: Draws, element: str) -> float:
    model = random_model(draws, element)
    q, q_previous = random_state(draws, model), random_state(draws, model)
    same = kernel.mixed_tangent_difference(model, q)
    return max(same, kernel.mixed_prediction_error(model, q, q_previous))


def _patch(draws: Draws, element: str) -> float:
    F = np.eye(3) + 0.1 * np.array([random_vector(draws) for _ in range(3)])
    return kernel.patch_force(random_model(draws, element, STRAIGHT), random_rotation(draws) @ F)


def _zero_modes(bent: bool) -> Callable[[Draws, str], float]:
    def observe(draws: Draws, element: str) -> float:
        model = random_model(draws, element, RodRange(elements=(1, 2, 3), slenderness=(8.0, 60.0)))
        if bent:
            q = bent_state(model, random_vector(draws, 2.0)) @ random_rotation(draws).T
            v = model.elastic.generalised(kernel.per_element(model, q))
            count, gap = kernel.zero_modes(kernel.assembled(model, model.elastic.material_tangent(v)))
        else:
            count, gap = kernel.zero_modes(kernel.assembled(model, model.elastic.force_and_tangent(model.e0)[1]))
        return abs(count - 6) + (0.0 if gap > 1e4 else 1.0)

    return observe


# --- loads ----------------------------------------------------------------------------------------------------------


def _point_moment(draws: Draws, element: str) -> tuple[Model, Moment, Floats]:
    model = random_model(draws, element)
    kind, direction = draws.choice(("section", "vorticity")), draws.choice(("fixed", "follower"))
    moment = Moment("rod", draws.number(0.0, 1.0), random_vector(draws) + [0.0, 0.0, 1.5], direction, kind)
    q = random_state(draws, model)
    return Model(Scene((model.rod,), moments=(moment,))), moment, q


def _moment_identities(draws: Draws, element: str) -> float:
    model, moment, q = _point_moment(draws, element)
    rod, effect = model.rods[0], model.effects[0]
    if q.size != rod.q0.size:  # the moment gave the rod another mesh
        raise AssertionError("one moment never changes the number of nodes")
    point = rod.section_point(moment.at)
    e = q.ravel()[point.dofs].reshape(-1, 3)
    de = np.array([random_vector(draws) for _ in e])
    Q = effect.force(e[None])[0]
    M = kernel.polar_rotation(point, e) @ moment.value if moment.direction == "follower" else moment.value
    return max(
        kernel.moment_resultant(Q, e, M), kernel.moment_power(point, Q, e, de, M, moment.definition)
    )


def _loads(model_of: Model, q: Floats) -> list[tuple[Effect, Floats]]:
    return [(effect, q.ravel()[effect.dofs].reshape(len(effect.dofs), -1, 3)) for effect in model_of.effects]


def _load_orders(index: int) -> Callable[[Draws, str], float]:
    def observe(draws: Draws, element: str) -> float:
        rod = random_rod(draws, element)
        at = draws.number(0.0, 1.0)
        value = random_vector(draws) + [0.0, 0.0, 1.5]
        size = 0.5 * rod.section.outer_radius
        direction = draws.choice(("fixed", "follower"))
        scene = Scene(
            (rod,),
            moments=tuple(Moment("rod", at, value, direction, kind) for kind in ("section", "vorticity")),
            forces=(Force("rod", at, value, random_vector(draws, size)[:2], direction),),
            line_loads=(LineLoad("rod", value, direction),),
        )
        model = Model(scene)
        q, other = random_state(draws, model.rods[0]), random_state(draws, model.rods[0])
        change = 0.1 * (other - model.rods[0].q0)
        worst = [
            kernel.load_orders(effect, e, de)[index]
            for (effect, e), (_, de) in zip(_loads(model, q), _loads(model, change), strict=True)
        ]
        return max(worst)

    return observe


# --- solutions ------------------------------------------------------------------------------------------------------


def _scene(draws: Draws, element: str) -> Scene:
    return random_loads(draws, random_rod(draws, element, SOLVED), LOAD)


def _turned(draws: Draws, element: str) -> float:
    scene, rotation = _scene(draws, element), random_rotation(draws)
    before, after = (solution.shape(solution.solved(s)) for s in (scene, solution.turned(scene, rotation)))
    return solution.difference((before[0] @ rotation.T, before[1] @ rotation.T), after)


def _shifted(draws: Draws, element: str) -> float:
    scene = _scene(draws, element)
    away = random_vector(draws)
    # 1e6 m for a rod of 0.4 m: absolute positions are stored to eps 1e6 m = 2.2e-10 m, 6e-10 of such a rod
    shift = 2.5e6 * scene.rods[0].length * away
    return solution.difference(*(solution.shape(solution.solved(s)) for s in (scene, solution.shifted(scene, shift))))


def _mirrored(draws: Draws, element: str) -> float:
    scene = _scene(draws, element)
    (r, g), image = (solution.shape(solution.solved(s)) for s in (scene, solution.mirrored(scene)))
    M = np.diag([1.0, -1.0, 1.0])
    return solution.difference((r @ M, np.array([[-1.0], [1.0]]) * (g @ M)), image)


def _reversed(draws: Draws, element: str) -> float:
    scene = _scene(draws, element)
    a, b = solution.solved(scene), solution.solved(solution.reversed_rod(scene))
    (r, g), (r_back, g_back) = solution.shape(a), solution.shape(b, reverse=True)
    bases = (b.scene.rods[0].base.position - scene.rods[0].base.position) / scene.rods[0].length
    return solution.difference((r, g), (r_back + bases, np.array([[1.0], [-1.0]]) * g_back))


def _scaled(draws: Draws, element: str) -> float:
    scene = _scene(draws, element)
    other = solution.millimetres_and_grams(scene)
    return solution.difference(*(solution.shape(solution.solved(s)) for s in (scene, other)))


def _on_scene(measure: Callable[[Scene], float]) -> Callable[[Draws, str], float]:
    return lambda draws, element: measure(_scene(draws, element))


def _reciprocity(draws: Draws, element: str) -> float:
    rod = random_rod(draws, element, SOLVED)
    unit = solution.bending_stiffness(rod) / rod.length**2
    first, second = (draws.choice((1.0, 0.7, 0.45)) for _ in range(2))
    bias = np.array([0.0, 1.5, 0.0])  # a load of size 1 at least
    a = Force("rod", first, unit * (random_vector(draws) + bias))
    value = unit * (random_vector(draws) + bias)
    b = Moment("rod", second, value * rod.length) if draws.choice((False, True)) else Force("rod", second, value)
    return solution.reciprocity(rod, a, b)


def _supports(draws: Draws, element: str) -> float:
    scene = _scene(draws, element)
    scene = replace(scene, solver=replace(scene.solver, predictor=draws.choice(("auto", "none"))))
    found = solution.solved(scene)
    moved = (found.q - found.model.q0) / found.model.unit
    return max(float(np.max(np.abs(s.rows @ moved[s.dofs]))) for s in found.model.supports)


def _resumed(draws: Draws, element: str) -> float:
    scene = _scene(draws, element)
    first = solution.solved(scene)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "state.npz"
        first.save(path)
        again = ancf.resume(scene, path)
    return solution.difference(solution.shape(first), solution.shape(again)) + (again.iterations > 2)


def _helix(measure: Callable[..., float]) -> Callable[[Draws, str], float]:
    def observe(draws: Draws, element: str) -> float:
        v = random_vector(draws, LARGE_MOMENT)
        v[2] = np.copysign(max(abs(v[2]), 0.1), v[2])
        return measure(random_rod(draws, element, HELIX), v)

    return observe


def _stretched(draws: Draws, element: str) -> float:
    return solution.stretch_error(random_rod(draws, element, STRETCH), draws.number(0.85, 1.3))
