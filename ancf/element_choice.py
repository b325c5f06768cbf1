"""Which element a rod gets when the program chooses: the cheapest whose sections are good enough."""

from __future__ import annotations

from collections.abc import Mapping

from ancf.elements import ELEMENTS
from ancf.error_estimate import order_of
from ancf.scene import Rod, Scene

# Validated elements that may be chosen, the cheapest first, by the cost of a solve on one mesh. 3243 costs as
# much as 3333 and needs a finer mesh in every case that was tried (validation/accuracy_cost.py).
COSTS = {"3333": 1.0, "3363": 2.2}
# Of the wanted accuracy: what the error of the model, known to a factor of two, may take, and what is left
# for the mesh at least.
MODEL_SHARE, MESH_SHARE = 0.7, 0.1
MARGIN = 0.9  # estimates err by some 10 %
# What a model error must fall to for a dearer element that does not suffice either.
BETTER = 0.5


def candidates(scene: Scene, rod: Rod) -> list[str]:
    """Elements that may stand in the place of the rod's, the cheapest first.

    Joined rods have one element. Sections of second degree are taken where supports and loads mean the same
    to them.
    """
    if not rod.any_element:
        return [rod.element]
    together = scene.rods if scene.joints else (rod,)
    linear_only = any(sections_are_held(scene, one) or not one.any_element for one in together)
    return [name for name in COSTS if not (linear_only and ELEMENTS[name].quadratic_section)]


def sections_are_held(scene: Scene, rod: Rod) -> bool:
    """Whether supports or loads of a rod mean something else to sections of second degree.

    A clamp holds their bulging too, which stiffens bending as if the rod were shorter by 0.05 (nu = 0.3) to
    0.14 R (nu = 0.49); the paper's moment takes it along.
    """
    clamped = any(support.kind == "clamp" for support in rod.supports)
    return clamped or any(m.rod == rod.name and m.definition == "vorticity" for m in scene.moments)


def choose(errors: Mapping[str, float], wanted: float) -> str:
    """The element with the least cost for an accuracy, or the best if none suffices.

    Elements in proportion to (what the model leaves of the accuracy)^(-1/order), times the cost of one.

    Parameters
    ----------
    errors : model error of each candidate, the cheapest first
    """
    enough = {
        name: COSTS.get(name, 1.0) * (wanted - error) ** (-1.0 / order_of(name))
        for name, error in errors.items()
        if error <= MODEL_SHARE * wanted
    }
    if enough:
        return min(enough, key=enough.__getitem__)
    smallest = min(errors.values())
    return next(name for name, error in errors.items() if BETTER * error <= smallest)


def left_for_mesh(wanted: float, model_error: float) -> float:
    """What the estimate may be: nearly the rest, or nearly all where the model errs too much anyway."""
    return MARGIN * (max(wanted - model_error, MESH_SHARE * wanted) if model_error < wanted else wanted)
