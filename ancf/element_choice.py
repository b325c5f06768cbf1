"""Which element a rod gets when the program chooses: the cheapest whose sections are good enough."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ancf.elements import ELEMENTS
from ancf.scene import Rod, Scene

# Validated elements that may be chosen, the cheapest first: on one mesh 3363 costs 1.3 to 2.2 times 3333.
# 3243 costs as much and needs a finer mesh in every case that was tried (validation/accuracy_cost.py).
CHOICE = ("3333", "3363")
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
    return [name for name in CHOICE if not (linear_only and ELEMENTS[name].quadratic_section)]


def sections_are_held(scene: Scene, rod: Rod) -> bool:
    """Whether supports or loads of a rod mean something else to sections of second degree.

    A clamp holds their bulging too, which stiffens bending as if the rod were shorter by 0.05 (nu = 0.3) to
    0.14 R (nu = 0.49); the paper's moment takes it along.
    """
    clamped = any(support.kind == "clamp" for support in rod.supports)
    return clamped or any(
        m.rod == rod.name and m.definition == "vorticity" and np.any(m.value) for m in scene.moments
    )


def choose(errors: Mapping[str, float], wanted: float) -> str:
    """The cheapest element whose sections suffice for an accuracy, or the best if none does.

    What the model takes of the accuracy costs elements by the fourth root only: (1 - 0.7)^(-1/4) = 1.35 times
    as many, less than a dearer element costs.

    Parameters
    ----------
    errors : model error of each candidate, the cheapest first
    """
    enough = [name for name, error in errors.items() if error <= MODEL_SHARE * wanted]
    if enough:
        return enough[0]
    smallest = min(errors.values())
    return next(name for name, error in errors.items() if BETTER * error <= smallest)


def left_for_mesh(wanted: float, model_error: float) -> float:
    """What the estimate may be: nearly the rest, or nearly all where the model errs too much anyway."""
    return MARGIN * (max(wanted - model_error, MESH_SHARE * wanted) if model_error < wanted else wanted)
