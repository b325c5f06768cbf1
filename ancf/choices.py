r"""What a scene has chosen, and what the other choice would do to the tip.

    direction      loads fixed in space that might follow their section, and the reverse
    law            neo-Hookean rubber in place of Saint Venant-Kirchhoff, and the reverse
    cable          whether an axis without sections would do, which neither shears nor twists
    mesh           error of the discretisation (error_estimate.py), and how many elements it takes
    sections       error of the element's sections against the solid (model_error.py), and which would do

Linear sections show a part of what a law does at finite strain only (model_error.py), so what they leave out
under either law is added:

    d r = r(other) - r(own) + e(other) - e(own),    e = r_solid - r_element.
"""

from __future__ import annotations

import math
import time
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ancf.advice_state import State
from ancf.element_choice import CHOICE, MODEL_SHARE, choose
from ancf.elements import R
from ancf.error_estimate import order_of
from ancf.hyperelastic import Law, MooneyRivlin, NeoHookean
from ancf.influence import Influence
from ancf.materials import SaintVenantKirchhoff
from ancf.model_error import model_errors, model_shifts
from ancf.rod_model import RodModel
from ancf.rod_shape import node_rotations
from ancf.rotation import log
from ancf.scene import Force, LineLoad, Moment, Rod
from ancf.scene_cable import could_be_cable
from ancf.scene_materials import law_name
from ancf.scene_numbers import rod_numbers
from ancf.solver import solve
from ancf.validity import largest_strain

Floats = NDArray[np.float64]

# Field of the scene -> name of its table; those whose loads have a direction.
DIRECTED = {"moments": "moment", "forces": "force", "line_loads": "line_load", "line_moments": "line_moment"}
FEWER = 0.5  # share of the elements from which it is worth taking fewer


def choices(state: State) -> Iterator[Influence]:
    """Influence of each choice of the scene; nothing without an equilibrium."""
    if not state.known:
        return
    yield from _directions(state)
    yield from _law(state)
    yield from _cable(state)
    yield from _mesh(state)
    yield from _sections(state)


def _directions(state: State) -> Iterator[Influence]:
    axial = {rod.name for rod in state.scene.rods if rod.element == "cable"}
    for field, table in DIRECTED.items():
        loads = getattr(state.scene, field)
        acting = [load for load in loads if np.any(load.value) and load.rod not in axial]
        directions = {load.direction for load in acting}
        if len(directions) != 1:
            continue  # none, or both: which of them is meant is not ours to say
        (direction,) = directions
        other = "follower" if direction == "fixed" else "fixed"
        turned = tuple(replace(load, direction=other) if load in acting else load for load in loads)
        yield state.influence(
            f"{table} direction",
            replace(state.near, **{field: turned}),
            "either direction would do",
            f"matters: make sure that it is {_meaning(direction)}, not {_meaning(other)}",
            listed=direction,
            number=max(_turn(state, load) for load in acting),
            measure="turn of the section [rad]",
        )


def _meaning(direction: str) -> str:
    return "fixed in space" if direction == "fixed" else "turning with the section"


def _turn(state: State, load: Force | Moment | LineLoad) -> float:
    """Largest turn of the sections that a load acts on [rad]."""
    rod = next(model for model in state.model.rods if model.rod.name == load.rod)
    turns = np.linalg.norm(log(node_rotations(rod, rod.nodal(state.q))), axis=1)
    at = getattr(load, "at", None)
    return float(turns.max() if at is None else turns[round(at * (len(turns) - 1))])


def other_law(law: Law) -> Law:
    """The law that is compared with one: with equal Young's modulus and Poisson ratio."""
    kind = NeoHookean if isinstance(law, SaintVenantKirchhoff | MooneyRivlin) else SaintVenantKirchhoff
    return kind(law.young_modulus, law.poisson_ratio, law.density)


def _law(state: State) -> Iterator[Influence]:
    laws = {law_name(part.material) for rod in state.scene.rods for part in rod.parts}
    if len(laws) > 1 or any(rod.element == "cable" for rod in state.scene.rods):
        return
    (name,) = laws
    dq = state.neighbour(replace(state.near, rods=tuple(map(_of_other_law, state.scene.rods))))
    if dq is None:
        return
    size = np.linalg.norm(state.shifts(dq), axis=1)
    moved = state.shifts(dq)[state.tips]
    added = _left_out(state)
    tip = float(np.linalg.norm(moved + (0.0 if added is None else added), axis=1).max())
    strain = max(largest_strain(state.solution, rod) for rod in state.model.rods)
    other = law_name(other_law(state.scene.rods[0].parts[0].material))
    matters = f"needed: {other} gives another shape"
    if name == "saint-venant-kirchhoff":
        matters = f"matters: {other} gives another shape, and is nearer to rubber"
    yield state.judged(
        "law",
        tip,
        max(tip, float(size.max())),
        True,
        f"{other} would give the same",
        matters,
        listed=name,
        number=strain,
        measure="largest strain",
        note="" if added is not None else "without what the sections leave out",
    )


def _of_other_law(rod: Rod) -> Rod:
    segments = tuple(replace(segment, material=other_law(segment.material)) for segment in rod.segments)
    return replace(rod, material=other_law(rod.material), segments=segments)


def _left_out(state: State) -> Floats | None:
    """e(other) - e(own) of each tip (n_rods, 3) in rod lengths; None where it is not known."""
    if state.errors is None or len({rod.element for rod in state.scene.rods}) > 1:
        return None
    element = (state.scene.rods[0].element,)
    own, other = model_shifts(state.errors, element), model_shifts(state.errors, element, other_law)
    if not own:
        return None
    length = np.array([rod.length for rod in state.scene.rods])
    return (np.concatenate(other) - np.concatenate(own)) / length[:, None]


def _cable(state: State) -> Iterator[Influence]:
    """Rods that nothing calls to twist or shear, solved as cables on their meshes."""
    axial = {rod.name for rod in state.scene.rods if could_be_cable(state.scene, rod)}
    left = state.deadline - time.perf_counter()
    if not axial or left <= 0.0:
        return
    rods = tuple(
        replace(rod, element="cable", formulation="", axial_rule="default") if rod.name in axial else rod
        for rod in state.scene.rods
    )
    found = solve(replace(state.scene, rods=rods, solver=replace(state.scene.solver, max_seconds=left)))
    if found.status != "converged":
        return
    moved = [
        np.linalg.norm(_ends(other, found.q) - _ends(rod, state.q), axis=1) / rod.rod.length
        for rod, other in zip(state.model.rods, found.model.rods, strict=True)
    ]
    numbers = [
        rod_numbers(state.solution, rod, False)["shear"] for rod in state.model.rods if rod.rod.name in axial
    ]
    first = next(rod for rod in state.scene.rods if rod.name in axial)
    yield state.judged(
        "cable",
        max(float(shift[-1]) for shift in moved),
        max(float(shift.max()) for shift in moved),
        False,
        'element = "cable" would do',
        'element = "cable" would not do: it has neither shear nor a section at finite strain',
        listed=first.element,
        number=max(number or 0.0 for number in numbers),
        measure="shear EI/(GA L^2)",
    )


def _ends(rod: RodModel, q: Floats) -> Floats:
    """Where elements end (n_el + 1, 3) [m], from the base of the rod."""
    inner = len(rod.element.node_xi) - 1
    return rod.nodal(q)[::inner, rod.element.vectors.index(R)]


def _mesh(state: State) -> Iterator[Influence]:
    if state.errors is None:
        return
    worst = int(np.argmax(state.errors.of_rod))
    rod, error = state.scene.rods[worst], state.errors.of_rod[worst]
    needed = max(math.ceil(rod.elements * (error / state.limit) ** (1.0 / order_of(rod.element))), 1)
    fewer = f", about {needed} would do" if needed <= FEWER * rod.elements else ""
    plural = "elements" if len(state.scene.rods) == 1 else f"elements of rod {rod.name!r}"
    yield state.judged(
        "mesh",
        error,
        error,
        False,
        f"fine enough{fewer}",
        f"too coarse: it takes about {needed} {plural}",
        listed=f"{rod.elements} x {rod.element}",
        number=float(rod.elements),
        measure=plural,
    )


def _sections(state: State) -> Iterator[Influence]:
    if state.errors is None or any(rod.element == "cable" for rod in state.scene.rods):
        return
    own = tuple(dict.fromkeys(rod.element for rod in state.scene.rods))
    found = model_errors(state.errors, tuple(dict.fromkeys((*own, *CHOICE))))
    if not found:
        return
    largest = [errors[rod.element] for rod, errors in zip(state.scene.rods, found, strict=True)]
    worst = int(np.argmax(largest))
    rod, errors = state.scene.rods[worst], found[worst]
    best = choose({name: errors[name] for name in CHOICE}, state.limit)
    cure = f"{best} leaves {errors[best]:.1g} L"
    if best == rod.element or errors[best] > MODEL_SHARE * errors[rod.element]:
        cure = "no element here does better"
    strain = largest_strain(state.solution, state.model.rods[worst])
    yield state.judged(
        "sections",
        largest[worst],
        largest[worst],
        True,
        f"{rod.element} is good enough against the solid",
        f"not good enough against the solid: {cure}",
        listed=f"{rod.element} {rod.formulation}",
        number=strain,
        measure="largest strain",
    )
