r"""Balance of a solution: what is applied and what supports and the ground give back, as forces and moments.

A generalised force Q works on a rigid virtual motion dr = a + w x r, under which every nodal vector d but a
position changes by w x d, so whatever it comes from it has the resultants

    F = sum_nodes Q_r,      M = sum_nodes [ r x Q_r + sum_d d x Q_d ],

r from the origin of SCS. Strain energy does no work on it and has none. So at an equilibrium, over the whole
structure, loads at their load factor, passive effects, supports and joints to the ground sum to zero; joints
between rods are inside it. For one rod what its joints carry counts too.

The unit of force is the larger of E I/L^2 and the largest of the forces; of moment that of E I/L, the largest
of the moments, and E I/L^2 times the reach of the rods from the origin, about which they turn.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancf.effect_assembly import add_blocks, blocks_of

if TYPE_CHECKING:
    from ancf.rod_model import RodModel
    from ancf.solution import Solution

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Resultant:
    """Force (3,) [N] and moment (3,) [N m] about the origin of SCS, in SCS."""

    force: Floats
    moment: Floats

    def as_dict(self) -> dict[str, Any]:
        """Plain Python."""
        return {"force": self.force.tolist(), "moment": self.moment.tolist()}


class Reaction(NamedTuple):
    """Force (3,) [N] and moment (3,) [N m] about a rod's base, in SCS, by supports and joints to ground."""

    force: Floats
    moment: Floats


@dataclass(frozen=True, eq=False)
class Balance:
    """Everything that acts on a structure, or on one rod of it, from outside.

    `applied` has the effects by name, at their load factor; `reactions` what "supports", the "ground"
    (through joints) and, on one rod, "joints" with other rods exert.
    """

    applied: dict[str, Resultant]
    reactions: dict[str, Resultant]
    force_unit: float  # N
    moment_unit: float  # N m

    @property
    def unbalanced(self) -> Resultant:
        """Sum of everything; rounding at an equilibrium."""
        return _sum([*self.applied.values(), *self.reactions.values()])

    @property
    def relative(self) -> float:
        """Larger of the unbalanced force and moment in their units."""
        left = self.unbalanced
        return float(
            max(np.linalg.norm(left.force) / self.force_unit, np.linalg.norm(left.moment) / self.moment_unit)
        )

    def as_dict(self) -> dict[str, Any] | None:
        """Plain Python, every number finite; None where a load is too large for that."""
        if not np.isfinite(self.relative):
            return None
        return {
            "applied": {name: resultant.as_dict() for name, resultant in self.applied.items()},
            "reactions": {name: resultant.as_dict() for name, resultant in self.reactions.items()},
            "unbalanced": self.unbalanced.as_dict(),
            "relative": self.relative,
        }


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # what is not finite is left out
def balance(solution: Solution, name: str | None = None) -> Balance:
    """Balance of the whole structure, or of the rod of that name.

    Raises
    ------
    KeyError : no such rod.
    """
    model, q = solution.model, solution.q
    rods = model.rods if name is None else [rod for rod in model.rods if rod.rod.name == name]
    if not rods:
        raise KeyError(f"the scene has no rod named {name!r}; it has {[r.rod.name for r in model.rods]}")
    forces: dict[str, Floats] = {}
    for effect in model.effects:
        total = forces.setdefault(effect.name, np.zeros(model.n))
        share = 1.0 if effect.passive else solution.load_factor
        add_blocks(total, effect.dofs, share * effect.force(blocks_of(q, effect.dofs)))
    applied = {effect: _resultant(rods, q, Q) for effect, Q in forces.items()}
    reactions = {"supports": _resultant(rods, q, solution.support_force), **_carried(solution, rods)}
    units = [rod.bending_stiffness / rod.rod.length**2 for rod in rods]
    reach = max(
        max(rod.rod.length, float(np.max(np.linalg.norm(solution.nodes(rod.rod.name), axis=1))))
        for rod in rods
    )
    acting = [*applied.values(), *reactions.values()]
    force_unit = max(*units, *(float(np.linalg.norm(one.force)) for one in acting))
    moment_unit = max(force_unit * reach, *(float(np.linalg.norm(one.moment)) for one in acting))
    return Balance(applied, reactions, force_unit, moment_unit)


def _carried(solution: Solution, rods: list[RodModel]) -> dict[str, Resultant]:
    """What the ground, and joints with other rods, exert on these rods."""
    found: dict[str, list[Resultant]] = {}
    constraints = solution.model.constraints
    models = [] if constraints is None else constraints.joints
    for carried, model in zip(solution.joints, models, strict=True):
        inside = [any(section.rod is rod for rod in rods) for section in model.sections]
        if len(inside) > 1 and all(inside):
            continue
        source = "ground" if carried.joint.b is None else "joints"
        for sign, section, counts in zip((1.0, -1.0), model.sections, inside, strict=False):
            if counts:
                arm = section.rod.rod.base.position + section.position(solution.q)
                force, moment = sign * carried.force, sign * carried.moment
                found.setdefault(source, []).append(Resultant(force, moment + np.cross(arm, force)))
    return {source: _sum(resultants) for source, resultants in found.items()}


def _resultant(rods: list[RodModel], q: Floats, Q: Floats) -> Resultant:
    """Resultant of the generalised forces Q (n,) on some rods."""
    force, moment = np.zeros(3), np.zeros(3)
    for rod in rods:
        vectors, of_rod = rod.nodal(q), rod.nodal(Q)
        on_rod = of_rod[:, 0].sum(axis=0)
        force += on_rod
        # About the base first: far from the origin the arms have few digits left.
        moment += np.cross(vectors, of_rod).sum(axis=(0, 1)) + np.cross(rod.rod.base.position, on_rod)
    return Resultant(force, moment)


def _sum(resultants: list[Resultant]) -> Resultant:
    return Resultant(
        np.sum([one.force for one in resultants], axis=0),
        np.sum([one.moment for one in resultants], axis=0),
    )
