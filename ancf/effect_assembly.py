"""The effects of a scene together: which there are, their forces, potential, and blocks in the tangent.

What a scene does not list is neither imported nor built. A load counts by the load factor, what is passive
always; the blocks of a coupled effect do not fit the band of the rods and follow it (coupled_system.py).
"""

from __future__ import annotations

import importlib
from copy import copy
from functools import cached_property
from itertools import groupby
from typing import TYPE_CHECKING, TypeGuard

import numpy as np
from numpy.typing import NDArray

from ancf.band import BandPattern
from ancf.counters import Counters
from ancf.effects import Effect, SparseEffect, blocks_of
from ancf.finite_difference import difference_tangent
from ancf.rod_model import RodModel
from ancf.scene import Scene
from ancf.scene_effects import EFFECT_MODULES

if TYPE_CHECKING:
    from ancf.mirror_system import Parity

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]


def load_effects(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """The effects of a scene: what it does not list is neither imported nor built."""
    found: list[Effect] = []
    for attribute, name in EFFECT_MODULES.items():
        if getattr(scene, attribute):
            found += importlib.import_module(f"ancf.effects.{name}").build(scene, rods)
    for added in scene.added:
        from ancf.added_effects import build_added

        found += build_added(added, scene, rods)
    return found


def add_blocks(total: Floats, dofs: Indices, Q: Floats) -> None:
    """Add the generalised forces Q (m, nd / 3, 3) of the blocks to those of all unknowns."""
    if len(dofs):
        begin = int(dofs.min())
        added = np.bincount(dofs.ravel() - begin, Q.ravel())
        total[begin : begin + len(added)] += added


class EffectAssembly:
    """Sums over the effects of one model.

    Parameters
    ----------
    unit : (n,) unit of each unknown
    differences : tangents by finite differences (the paper's) instead of the effects' own
    side : the unknowns of one parity, on which the tangents are wanted instead (mirror_system.py)
    """

    def __init__(
        self,
        effects: list[Effect],
        pattern: BandPattern,
        unit: Floats,
        differences: bool,
        counters: Counters,
        side: Parity | None = None,
    ) -> None:
        self.unit = unit
        self.differences = differences
        self.counters = counters
        self.side = side
        self.places = [_Places(pattern, effect, side, self._is_sparse(effect)) for effect in effects]
        self._take(effects)

    def _take(self, effects: list[Effect]) -> None:
        self.effects = effects
        pairs = groupby(zip(effects, self.places, strict=True), key=lambda pair: pair[0].name)
        self._kinds = [(name, list(group)) for name, group in pairs]

    def of(self, effects: list[Effect]) -> EffectAssembly:
        """The same for effects that differ in their values only."""
        other = copy(self)
        other._take(effects)
        return other

    def forces(self, Q_int: Floats, Q_ext: Floats, q: Floats) -> None:
        """Add the forces at q (n,)."""
        for name, effects in self._kinds:
            with self.counters.effect(name):
                for effect, _ in effects:
                    _add(Q_int, Q_ext, effect, effect.force(blocks_of(q, effect.dofs)))

    def terms(
        self, Q_int: Floats, Q_ext: Floats, flat: Floats, q: Floats, load_factor: float
    ) -> list[Floats]:
        """Add forces and tangents at q (n,) to the band `flat`; returns the entries of the coupled blocks."""
        coupled = []
        for name, effects in self._kinds:
            with self.counters.effect(name):
                for effect, places in effects:
                    e = blocks_of(q, effect.dofs)
                    if self._is_sparse(effect):
                        Q, K = effect.force_and_entries(e)
                    else:
                        Q, K = effect.force_and_tangent(e)
                    _add(Q_int, Q_ext, effect, Q)
                    if K is not None and self.differences:
                        K = difference_tangent(effect.force, e, blocks_of(self.unit, effect.dofs))
                    share = 1.0 if effect.passive else load_factor
                    if effect.coupled:
                        m, nd = effect.dofs.shape
                        coupled.append(np.zeros(m * nd * nd) if K is None else -share * K.ravel())
                    elif K is not None:
                        places.subtract(flat, share, K)
        return coupled

    def _is_sparse(self, effect: Effect) -> TypeGuard[SparseEffect]:
        whole = effect.coupled or self.differences or self.side is not None
        return isinstance(effect, SparseEffect) and not whole

    def potential(self, q: Floats, load_factor: float) -> float | None:
        """Potential [J] at q (n,); None when an effect has none."""
        total = 0.0
        for effect in self.effects:
            V = effect.potential(blocks_of(q, effect.dofs))
            if V is None:
                return None
            total += V if effect.passive else load_factor * V
        return total


class _Places:
    """Where the tangent of one effect goes; found when the first one comes, as dead loads have none."""

    def __init__(self, pattern: BandPattern, effect: Effect, side: Parity | None, sparse: bool) -> None:
        self.pattern = pattern
        self.effect = effect
        self.side = side
        self.sparse = sparse

    @cached_property
    def _map(self) -> tuple[Floats | None, Indices]:
        """F on one block (nd, m), None: all of its unknowns are wanted; and the unknowns (blocks, m)."""
        return (None, self.effect.dofs) if self.side is None else self.side.blocks_of(self.effect.dofs)

    @cached_property
    def _slots(self) -> Indices:
        """Places in the band of the entries that the effect gives."""
        slots = self.pattern.block_slots(self._map[1]).ravel()
        return slots[self.effect.entries] if isinstance(self.effect, SparseEffect) and self.sparse else slots

    def subtract(self, flat: Floats, share: float, K: Floats) -> None:
        """Subtract a share of the blocks K (m, nd, nd), of a parity F^T K F, or of a sparse effect's K."""
        F, _ = self._map
        block = (K if F is None else F.T @ K @ F).ravel()
        # On flat arrays `at` is as fast as any other way to add to places that may repeat.
        np.subtract.at(flat, self._slots, block if share == 1.0 else share * block)


def _add(Q_int: Floats, Q_ext: Floats, effect: Effect, Q: Floats) -> None:
    if effect.passive:
        np.subtract.at(Q_int, effect.dofs.ravel(), Q.ravel())
    else:
        np.add.at(Q_ext, effect.dofs.ravel(), Q.ravel())
