r"""Advice on a scene: which effects could be left out, which missing one would matter, and by how much.

The scene is solved once, and again with each change (advice_state.py): without each effect that it lists,
with each that it leaves out (missing_effects.py, missing_contacts.py), and with the other of two choices
(choices.py). The shift is the influence, counted in rod lengths at the tip and where it is largest.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np

from ancf.advice_state import State
from ancf.choices import choices
from ancf.influence import MATTERS, UNKNOWN, Influence
from ancf.missing_contacts import missing_contacts
from ancf.missing_effects import missing_effects
from ancf.scene import Scene, StabilityOptions
from ancf.scene_effects import EFFECT_MODULES
from ancf.scene_numbers import rod_numbers

ACCURACY = 1e-3  # of the length, where the scene asks for none
SECONDS = 5.0  # what finding the equilibrium may take, and all others as much
NEEDED, LEFT_OUT = "needed", "could be left out"


@dataclass(frozen=True)
class Advice:
    """Numbers of a scene and the influence of its effects, of missing ones and of choices, at an accuracy.

    `state` is where they were estimated, "equilibrium" or "reference"; `status` that of the solution.
    """

    accuracy: float
    asked: bool  # whether the scene asks for the accuracy
    state: str
    status: str
    numbers: dict[str, dict[str, float | None]]  # by rod
    listed: list[Influence]
    missing: list[Influence]
    choices: list[Influence]

    def as_dict(self) -> dict[str, Any]:
        """Plain Python; every number is finite."""
        return {
            "accuracy": self.accuracy,
            "accuracy_source": "solver.accuracy" if self.asked else "default",
            "state": self.state,
            "status": self.status,
            "numbers": self.numbers,
            "listed": [vars(influence) for influence in self.listed],
            "missing": [vars(influence) for influence in self.missing],
            "choices": [vars(influence) for influence in self.choices],
        }


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # what is not finite gives no estimate
def advise(scene: Scene, wanted: float | None = None) -> Advice:
    """Advice on a scene.

    Parameters
    ----------
    scene : with a mesh (`Model.scene` of a prepared model)
    wanted : accuracy of the tip, in lengths, that was asked for; `ACCURACY` if None
    """
    from ancf.solver import solve

    # In full: with one effect more or less a scene may reduce to other unknowns.
    options = replace(scene.solver, max_seconds=min(scene.solver.max_seconds, SECONDS), reduction="full")
    # The branch counts here, modes do not.
    buckled = scene.stability is not None and scene.stability.branch == "buckled"
    stability = StabilityOptions(1, "buckled") if buckled else None
    solution = solve(replace(scene, solver=options, stability=stability))
    limit = ACCURACY if wanted is None else wanted
    state = State.of(solution, limit, time.perf_counter() + SECONDS)
    return Advice(
        accuracy=limit,
        asked=wanted is not None,
        state="equilibrium" if state.known else "reference",
        status=str(solution.status),
        numbers={rod.rod.name: rod_numbers(solution, rod, state.known) for rod in solution.model.rods},
        listed=[*_listed(state)],
        choices=[*choices(state)],
        # Contact last: it may take what time is left.
        missing=[*missing_effects(state), *missing_contacts(state)],
    )


def without_each(scene: Scene) -> Iterator[tuple[str, Scene]]:
    """Each listed effect by the name of its table, and the scene without it."""
    absent = {field.name: field.default for field in fields(Scene)}
    for name, module in EFFECT_MODULES.items():
        if getattr(scene, name):
            yield module, replace(scene, **{name: absent[name]})
    for added in scene.added:
        yield added.table, replace(scene, added=tuple(other for other in scene.added if other is not added))


def _listed(state: State) -> Iterator[Influence]:
    """Influence of each listed effect, and of the friction of tendons beside that of tendons."""
    for name, without in without_each(state.scene):
        found = state.influence(name, without, LEFT_OUT, NEEDED, listed="yes")
        if found.verdict == UNKNOWN:
            note = "nothing holds the structure without it, or its loads are too large"
            found = replace(found, verdict=MATTERS, advice=NEEDED, note=note)
        yield found
    if state.known and any(tendon.friction for tendon in state.scene.tendons):
        smooth = tuple(replace(tendon, friction=0.0) for tendon in state.scene.tendons)
        other = replace(state.near, tendons=smooth)
        yield state.influence("tendon friction", other, LEFT_OUT, NEEDED, listed="yes")
