"""Conditions on the motions of a model, each met by a Lagrange multiplier: joints, tendons of given length.

With the conditions c(q, l) = 0 and multipliers lambda the potential is that of the rods plus lambda . c; the
multipliers are unknowns behind those of the rods, and the tangent is symmetric where all effects have
potentials (coupled_system.py).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancf.rod_model import RodModel
from ancf.scene import Scene

if TYPE_CHECKING:
    from ancf.joints import JointModel
    from ancf.tendon_length import TendonLength

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


@dataclass(frozen=True)
class ConstraintTerms:
    """What a constraint adds to the residual: g (nd,), dg/dl (nd,) and the entries of dg/dx (entries,)."""

    g: Floats
    rate: Floats
    tangent: Floats


class Constraint(ABC):
    """What the model asks of a constraint; l is the load factor.

    Attributes
    ----------
    name : under which its cost is counted, as an effect's
    dofs : (nd,) unknowns x that it reads and adds forces to; one may occur more than once
    multipliers : (conditions,) those of them that are its own
    rows, columns : (entries,) unknowns of the entries of its tangent
    held_dofs : unknowns of the rods between which its tangent does not fit their band
    energy : E I/L [J], which makes its equations dimensionless
    gap_unit : (conditions,) units of the conditions
    longest_step : largest step of the load factor, by which the motion it prescribes stays near
    conservative : whether its forces are those of its conditions, so that its tangent is symmetric
    """

    name: str
    dofs: Indices
    multipliers: Indices
    rows: Indices
    columns: Indices
    held_dofs: Indices
    energy: float
    gap_unit: Floats
    longest_step: float = np.inf
    conservative: bool = True

    @property
    def conditions(self) -> int:
        """Number of conditions."""
        return len(self.multipliers)

    @property
    def unit(self) -> Floats:
        """Units of the multipliers."""
        return self.energy / self.gap_unit

    @abstractmethod
    def terms(self, x: Floats, load_factor: float) -> ConstraintTerms:
        """Residual, its rate with the load factor, and its tangent, all of this constraint alone."""

    def closed(self, x: Floats, load_factor: float) -> bool:
        """Whether the conditions are met as they are meant, where they allow more than that."""
        return True


class Constraints:
    """All constraints of a model; their unknowns follow those of the rods."""

    def __init__(self, scene: Scene, rods: list[RodModel], first: int) -> None:
        self.joints: list[JointModel] = []
        self.tendons: list[TendonLength] = []
        self.end = first
        if scene.joints:
            from ancf.joints import JointModel

            for joint in scene.joints:
                self.joints.append(JointModel(joint, rods, self.end))
                self.end += self.joints[-1].conditions
        if scene.controlled_tendons:
            from ancf.tendon_length import estimated_multipliers, tendon_length

            for tendon in scene.controlled_tendons:
                self.tendons.append(tendon_length(tendon, rods, self.end))
                self.end += self.tendons[-1].conditions
            for one, m in zip(self.tendons, estimated_multipliers(scene, self.tendons), strict=True):
                one.expected = float(m)

    @property
    def models(self) -> list[Constraint]:
        """All of them, in the order of their multipliers."""
        return [*self.joints, *self.tendons]

    @property
    def unit(self) -> Floats:
        """Units of all multipliers."""
        return np.concatenate([one.unit for one in self.models])

    @property
    def gap_unit(self) -> Floats:
        """Units of all conditions."""
        return np.concatenate([one.gap_unit for one in self.models])

    @property
    def longest_step(self) -> float:
        """Largest step of the load factor for all prescribed motions."""
        return min(one.longest_step for one in self.models)

    def take_sides(self, q: Floats) -> None:
        """Tendons are taut or slack as they are at q (n,), until `leave_sides`."""
        for one in self.tendons:
            one.side = one.is_taut(one.multiplier(q))

    def wrong_side(self, q: Floats, tolerance: float) -> TendonLength | None:
        """The first tendon that is on the wrong side at the equilibrium q (n,), if any is."""
        return next((one for one in self.tendons if one.is_wrong(one.multiplier(q), tolerance)), None)

    def choose_sides(self, scene: Scene, q: Floats) -> Floats:
        """Choose all sides by linear theory about the equilibrium q (n,); q with the multipliers for them."""
        from ancf.tendon_length import estimated_multipliers

        q = q.copy()
        found = estimated_multipliers(scene, self.tendons, q)
        for one, m in zip(self.tendons, found, strict=True):
            q[one.multipliers] = m
            one.side = bool(m > 0.0)
        return q

    @property
    def sides(self) -> tuple[bool | None, ...]:
        """Which tendons are taken as taut."""
        return tuple(one.side for one in self.tendons)

    def leave_sides(self) -> None:
        """Tendons are taut or slack by their unknowns again."""
        for one in self.tendons:
            one.side = None

    def closed(self, q: Floats, load_factor: float) -> bool:
        """Whether every constraint is met as it is meant."""
        return all(one.closed(q[one.dofs], load_factor) for one in self.models)

    @cached_property
    def held_dofs(self) -> Indices:
        """Unknowns of the rods that do not fit their band, in order."""
        return np.unique(np.concatenate([one.held_dofs for one in self.models]))
