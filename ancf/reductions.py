r"""What a scene does not call for is left out: unknowns out of its plane, pivoting of symmetric tangents.

The search for an equilibrium runs on a reduced model, everything else (sections, reactions, sensitivities,
stability) on the full one:

* planar: a scene that is its own mirror image in a plane (scene_plane.py) is solved on the unknowns in the
  plane (planar_model.py), about half of all, unless it is so small that this does not pay;
* symmetric: where every load that acts has a potential, tangents are factorised by Cholesky, and by LU where
  they are not positive definite. Couples across the plane of a planar scene have one on its shapes.

Either makes its last, smallest steps with the factors at hand (newton.py).

Paths (arc length, the buckled branch), joints, prescribed motions and finite-difference tangents are solved
in full, as are batches.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from copy import copy
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancf.effects import blocks_of
from ancf.elements import ELEMENTS
from ancf.errors import Message, SceneError
from ancf.linear_system import LinearSystem
from ancf.scene_cable import could_be_cable
from ancf.scene_plane import Plane, find_plane

if TYPE_CHECKING:
    from ancf.model import Model
    from ancf.scene import Rod, Scene
    from ancf.stepping import Trace

Floats = NDArray[np.float64]

# Effects whose potential `has_potential` knows from the scene; the others are asked.
JUDGED = ("moment", "line_moment", "force", "line_load")
# Unknowns from which on the plane pays under point moments alone. Time in full by time in the plane, of 3333:
# 0.9 at 81 and 153 unknowns, 1.0 at 225, 1.15 at 297 (benchmarks/bench_planar.py).
FEW_UNKNOWNS = 200
# Dimensionless distance from the plane that rounding may give a start.
ROUNDING = 1e-13


@dataclass(frozen=True)
class Reductions:
    """What of a scene is left out, and the sentences that say so."""

    plane: Plane | None
    symmetric: bool

    def sentences(self, model: Model) -> list[str]:
        """A sentence for each reduction; `model` is the reduced one."""
        from ancf.planar_model import PlanarModel

        found = []
        if isinstance(model, PlanarModel):
            assert self.plane is not None
            found.append(
                f"planar: rods and loads stay in the plane across ({self.plane}),"
                f" {model.solved} of {model.unknowns} unknowns are solved for"
            )
        if self.symmetric:
            where = "" if self.plane is None else "on shapes in the plane "
            found.append(f"symmetric: {where}the loads have a potential, Cholesky factors replace LU")
        if model.scene.solver.reduction == "full":
            return []
        axial = [rod for rod in model.scene.rods if could_be_cable(model.scene, rod)]
        return [*found, _of_cables(axial)] if axial else found


def chosen(scene: Scene, source: str = "") -> Reductions:
    """The reductions of a scene; raises `SceneError` where `planar` is asked for and the scene is not.

    `source` names the scene in the message.
    """
    options = scene.solver
    if options.reduction == "full":
        return Reductions(None, False)
    if options.reduction == "planar":
        plane = _in_full(scene) if scene.follows_path or options.tangent != "analytic" else find_plane(scene)
        if isinstance(plane, Message):
            where = f"{source}: {plane.where}" if source else plane.where
            raise SceneError(replace(plane, where=where))
        return Reductions(plane, has_potential(scene, plane))
    if scene.follows_path or scene.constrained or options.tangent != "analytic":
        return Reductions(None, False)
    plane = find_plane(scene) if pays(scene) else None
    if not isinstance(plane, Plane):
        return Reductions(None, has_potential(scene, None))
    return Reductions(plane, has_potential(scene, plane))


def pays(scene: Scene) -> bool:
    """Whether a plane would save more than it costs to look for it, and for motions out of it.

    Under point moments alone a short rod has next to nothing to save: its start is known in closed form.
    Loads of value zero do not count.
    """
    weight = 0.0 if scene.gravity is None else scene.gravity.acceleration
    loads = (*scene.forces, *scene.line_loads, *scene.line_moments, *scene.pressures)
    pulled = any(tendon.tension != 0.0 for tendon in scene.tendons)
    if pulled or np.any(weight) or any(np.any(load.value) for load in loads):
        return True
    if not any(np.any(load.value) for load in scene.moments):
        return True
    return sum(_unknowns(rod) for rod in scene.rods) >= FEW_UNKNOWNS


def _unknowns(rod: Rod) -> int:
    element = ELEMENTS[rod.element]
    return 3 * len(element.vectors) * (rod.elements * (len(element.node_xi) - 1) + 1)


def settled(model: Model) -> Reductions:
    """The reductions of a scene, less those that an effect forbids that only its model knows."""
    reductions = chosen(model.scene)
    others = (effect for effect in model.effects if effect.name not in JUDGED)
    if reductions.symmetric and any(
        effect.potential(blocks_of(model.q0, effect.dofs)) is None for effect in others
    ):
        reductions = replace(reductions, symmetric=False)
    return reductions


def has_potential(scene: Scene, plane: Plane | None) -> bool:
    """Whether all loads that act have a potential, of a planar scene on shapes in the plane.

    Section moments are conjugate to the rotation of their section, which is an angle in the plane.
    """
    followers = [load for load in (*scene.forces, *scene.line_loads) if load.direction == "follower"]
    couples = [m for m in scene.moments if plane is None or m.definition != "section"]
    spread = scene.line_moments if plane is None else ()
    return not any(np.any(load.value) for load in (*followers, *couples, *spread))


def reduced(model: Model, reductions: Reductions) -> Model:
    """The model on which an equilibrium is sought; the same where nothing is left out."""
    if reductions.plane is not None:
        from ancf.planar_model import PlanarModel

        stays = model.scene.solver.reduction == "planar"
        return PlanarModel(model, reductions.plane, reductions.symmetric, stays)
    if not reductions.symmetric or type(model.system) is not LinearSystem:
        return model
    found = copy(model)
    system = (model.pattern, model.supports, model.unit, model.force_unit, model.counters)
    vars(found)["system"] = LinearSystem(*system, symmetric=True)
    found.eased = True
    return found


def search(model: Model, start: Floats | None) -> tuple[Trace, list[str]]:
    """The search for an equilibrium, and the sentences of the reductions that it was found under.

    In the plane first where the scene has one. Where the rods leave it, or no equilibrium is found in it, the
    full model decides.
    """
    from ancf.solution import Status
    from ancf.stepping import find_equilibrium

    deadline = time.perf_counter() + model.scene.solver.max_seconds
    reductions = settled(model)
    lean = reduced(model, reductions)
    if reductions.plane is not None:
        from ancf.planar_model import LeavesPlane, PlanarModel

        assert isinstance(lean, PlanarModel)
        if lean.stays or start is None or lean.is_planar(start, ROUNDING):
            try:
                trace = find_equilibrium(lean, start, deadline)
            except LeavesPlane:
                trace = None
            final = (Status.CONVERGED, Status.OUT_OF_TIME)
            if trace is not None and (lean.stays or trace.status in final):
                return trace, reductions.sentences(lean)
        reductions = Reductions(None, reductions.symmetric and has_potential(model.scene, None))
        lean = reduced(model, reductions)
    return find_equilibrium(lean, start, deadline), reductions.sentences(lean)


def _in_full(scene: Scene) -> Message:
    return Message(
        "A path and finite differences are followed in space.",
        "solver.reduction",
        f'reduction = "planar" with method = "{scene.solver.method}", tangent = "{scene.solver.tangent}"',
        "a path has to see branches out of the plane, and differences are taken of all unknowns",
        'take reduction = "auto" or "full"',
    )


def _of_cables(rods: Sequence[Rod]) -> str:
    """What cables in the place of rods would leave out."""
    names = ", ".join(repr(rod.name) for rod in rods)
    return (
        f'cable, on request: nothing turns or twists sections of {names}, element = "cable" is possible;'
        f" it leaves out shear, some {max(map(_shear_share, rods)):.1g} of a tip force's deflection"
    )


def _shear_share(rod: Rod) -> float:
    part = min(rod.parts, key=lambda part: part.section.area)
    shear = part.section.area * part.material.lame_mu * min(rod.shear_factors) * rod.length**2
    return 3.0 * part.material.young_modulus * part.section.weaker_second_moment / shear


def sentences(model: Model) -> list[str]:
    """What will be left out of a scene, a sentence each."""
    reductions = settled(model)
    return reductions.sentences(reduced(model, reductions))
