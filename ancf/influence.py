"""What one effect does to the shape, and whether that matters at a wanted accuracy.

An influence below the accuracy is negligible, above it matters. To first order, or where a magnitude is taken
from elsewhere, that is said below half of it and above twice of it; in between one step is too coarse to
tell.
"""

from __future__ import annotations

from dataclasses import dataclass

SURE = 2.0  # factor within which one Newton step tells a small influence
NEGLIGIBLE, CLOSE, MATTERS, UNKNOWN = "negligible", "close", "matters", "unknown"


@dataclass(frozen=True)
class Influence:
    """Shift of the shape by one effect, or by another choice, in rod lengths; None where it is not known."""

    effect: str  # name of its table, or what is chosen
    tip: float | None  # shift of the tip of a rod, of the rod where it is largest
    largest: float | None  # shift of a node of the axis
    verdict: str
    first_order: bool = True  # by one Newton step, not by the equilibrium of the changed scene
    note: str = ""  # what was assumed
    listed: str = "no"  # yes, no, or what is chosen
    number: float | None = None  # dimensionless, that decides about it
    measure: str = ""  # what the number is
    advice: str = ""  # a sentence


def verdict_of(largest: float, limit: float, first_order: bool) -> str:
    """Whether a shift matters at a wanted accuracy."""
    factor = SURE if first_order else 1.0
    return NEGLIGIBLE if largest < limit / factor else MATTERS if largest > limit * factor else CLOSE


def worded(verdict: str, negligible: str, matters: str) -> str:
    """The advice that belongs to a verdict."""
    return {NEGLIGIBLE: negligible, MATTERS: matters, CLOSE: "too close to tell", UNKNOWN: "unknown"}[verdict]
