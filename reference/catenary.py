"""Elastic cable without bending stiffness, hanging between two supports of equal height.

With the weight w L of the cable, EA, and the horizontal force H and vertical force V = w L/2 at the supports,

    span = H L/EA + (2 H/w) asinh(V/H),   sag = (H/w) (sqrt(1 + (V/H)^2) - 1) + w L^2/(8 EA)

(Irvine, Cable Structures, 1981, ch. 1.3, eq. 1.25-1.26: Lagrangian coordinate, small elastic strain).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import asinh, hypot

from reference.root import bracketed_root


@dataclass(frozen=True)
class HangingCable:
    """Horizontal force [N], vertical force at each support [N], and sag of the middle [m]."""

    horizontal: float
    vertical: float
    sag: float


def hanging_cable(length: float, span: float, weight: float, EA: float) -> HangingCable:
    """Forces and sag of a cable of `length` [m] unstretched on a `span` [m]; weight per length [N/m].

    Raises
    ------
    ValueError where the span is not positive, or beyond 1.5 times the length.
    """
    if not 0.0 < span < 1.5 * length:
        raise ValueError(f"span {span:g} m must lie between 0 and 1.5 times the length {length:g} m")
    V = 0.5 * weight * length

    def gap(H: float) -> float:
        return H * length / EA + 2.0 * H / weight * asinh(V / H) - span

    high = V
    while gap(high) < 0.0:
        high *= 2.0
    low = V
    while gap(low) > 0.0:
        low *= 0.5
    H = bracketed_root(gap, low, high)
    sag = (hypot(H, V) - H) / weight + weight * length**2 / (8.0 * EA)
    return HangingCable(H, V, sag)
