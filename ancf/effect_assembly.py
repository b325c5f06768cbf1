"""The effects of a scene together: which there are, their forces, potential, and blocks in the tangent.

What a scene does not list is neither imported nor built. A load counts by the load factor, what is passive
always; the blocks of a coupled effect do not fit the band of the rods and follow it (coupled_system.py).
"""

from __future__ import annotations

import importlib
from copy import copy
from itertools import groupby
from operator import attrgetter

import numpy as np
from numpy.typing import NDArray

from ancf.band import BandPattern
from ancf.counters import Counters
from ancf.effects import Effect, blocks_of
from ancf.finite_difference import difference_tangent
from ancf.rod_model import RodModel
from ancf.scene import Scene
from ancf.scene_effects import EFFECT_MODULES

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

RUN = 64  # blocks whose entries are added at once: what they touch of the band stays in the cache


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
    """

    def __init__(
        self, effects: list[Effect], pattern: BandPattern, unit: Floats, differences: bool, counters: Counters
    ) -> None:
        self.effects = effects
        self.unit = unit
        self.differences = differences
        self.counters = counters
        self.runs = [_runs(pattern, effect) for effect in effects]

    def of(self, effects: list[Effect]) -> EffectAssembly:
        """The same for effects that differ in their values only."""
        other = copy(self)
        other.effects = effects
        return other

    def forces(self, Q_int: Floats, Q_ext: Floats, q: Floats) -> None:
        """Add the forces at q (n,)."""
        for name, effects in groupby(self.effects, key=attrgetter("name")):
            with self.counters.effect(name):
                for effect in effects:
                    _add(Q_int, Q_ext, effect, effect.force(blocks_of(q, effect.dofs)))

    def terms(
        self, Q_int: Floats, Q_ext: Floats, flat: Floats, q: Floats, load_factor: float
    ) -> list[Floats]:
        """Add forces and tangents at q (n,) to the band `flat`; returns the entries of the coupled blocks."""
        coupled = []
        for name, pairs in groupby(zip(self.effects, self.runs, strict=True), key=lambda pair: pair[0].name):
            with self.counters.effect(name):
                for effect, runs in pairs:
                    e = blocks_of(q, effect.dofs)
                    Q, K = effect.force_and_tangent(e)
                    _add(Q_int, Q_ext, effect, Q)
                    if K is not None and self.differences:
                        K = difference_tangent(effect.force, e, blocks_of(self.unit, effect.dofs))
                    share = 1.0 if effect.passive else load_factor
                    if effect.coupled:
                        m, nd = effect.dofs.shape
                        coupled.append(np.zeros(m * nd * nd) if K is None else -share * K.ravel())
                    elif K is not None:
                        for run, begin, places in runs:
                            entries = np.bincount(places, K[run].ravel())
                            flat[begin : begin + len(entries)] -= share * entries
        return coupled

    def potential(self, q: Floats, load_factor: float) -> float | None:
        """Potential [J] at q (n,); None when an effect has none."""
        total = 0.0
        for effect in self.effects:
            V = effect.potential(blocks_of(q, effect.dofs))
            if V is None:
                return None
            total += V if effect.passive else load_factor * V
        return total


def _runs(pattern: BandPattern, effect: Effect) -> list[tuple[slice, int, Indices]]:
    """Runs of the blocks of an effect: where each begins in the band, and the places of its entries there."""
    found: list[tuple[slice, int, Indices]] = []
    for first in range(0, 0 if effect.coupled else len(effect.dofs), RUN):
        run = slice(first, first + RUN)
        places = pattern.block_slots(effect.dofs[run]).ravel()
        begin = int(places.min())
        found.append((run, begin, places - begin))
    return found


def _add(Q_int: Floats, Q_ext: Floats, effect: Effect, Q: Floats) -> None:
    if effect.passive:
        add_blocks(Q_int, effect.dofs, -Q)
    else:
        add_blocks(Q_ext, effect.dofs, Q)
