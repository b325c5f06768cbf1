"""One sentence a family, taken from its points: the cheapest setting that reaches each target."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from validation.cost.points import CostPoint, milliseconds, reached
from validation.cost.run import FamilyCost

TARGETS = (1e-3, 1e-4)  # of the length
ALIKE = 1.25  # times this close are one: then the setting that comes first, the default, is named


@dataclass(frozen=True)
class Cheapest:
    """The cheapest beam, peer and solid of a family for one target; None where none reaches it."""

    target: float
    beam: CostPoint | None
    peer: CostPoint | None
    solid: CostPoint | None


def cheapest(cost: FamilyCost) -> list[Cheapest]:
    """By the median time, for each target."""
    return [
        Cheapest(target, *(_cheapest(cost.points, kind, target) for kind in ("beam", "peer", "solid")))
        for target in TARGETS
    ]


def _cheapest(points: Sequence[CostPoint], kind: str, target: float) -> CostPoint | None:
    good = reached([p for p in points if p.kind == kind], target)
    fastest = min((p.median for p in good), default=0.0)
    return next((p for p in good if p.median <= ALIKE * fastest), None)


def sentence(cost: FamilyCost) -> str:
    """The recommendation in words, times of this run."""
    parts = []
    for found in cheapest(cost):
        text = f"for {found.target:.0e} L "
        if found.beam is None:
            text += "no beam here is good enough" + _floor(cost)
        else:
            text += f"take {found.beam.label} with {found.beam.mesh} ({milliseconds(found.beam.median)})"
        others = [
            f"{p.model} {milliseconds(p.median)} with {p.mesh}"
            for p in (found.peer, found.solid)
            if p is not None
        ]
        parts.append(text + (f"; {', '.join(others)}" if others else ""))
    return (". ".join(part[0].upper() + part[1:] for part in parts) + ".").replace("e-0", "e-")


def _floor(cost: FamilyCost) -> str:
    """The smallest error that a model is left with on fine meshes, if the ladder knows it."""
    beams = {p.model for p in cost.points if p.kind == "beam"}
    floors = [f for f in cost.floors if f.model in beams]
    if not floors:
        return ""
    best = min(floors, key=lambda f: f.error + f.bar)
    return f": {best.model} is left with {best.error:.1e} ± {best.bar:.0e} on fine meshes"
