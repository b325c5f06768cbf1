"""Helical spring of a round wire under an axial wrench: exact for a rod that neither stretches nor shears.

A helix of radius R and pitch angle a has the curvature cos^2 a/R and the twist sin a cos a/R. A force F along
its axis and a couple K about it keep it a helix, of R' and a', with (Love, Treatise, 4th ed. 1927, art. 271)

    F = GJ (tau' - tau) cos a'/R' - EI (kappa' - kappa) sin a'/R',
    K = GJ (tau' - tau) sin a'    + EI (kappa' - kappa) cos a'.

Ends that do not turn keep the angle L cos a/R round the axis: R' = R cos a'/cos a, sin a' = sin a + delta/L.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import asin, cos, hypot, pi, sin


@dataclass(frozen=True)
class Helix:
    """Unstressed helix: length of the wire [m], curvature and twist [1/m]."""

    length: float
    curvature: float
    twist: float

    @property
    def rate(self) -> float:
        """Angle round the axis per length of wire [1/m]: cos a/R = sqrt(curvature^2 + twist^2)."""
        return hypot(self.curvature, self.twist)

    @property
    def sine(self) -> float:
        """sin a of the pitch angle."""
        return self.twist / self.rate

    @property
    def radius(self) -> float:
        """R [m]: curvature/(curvature^2 + twist^2)."""
        return self.curvature / self.rate**2


def pulled_spring(helix: Helix, EI: float, GJ: float, extension: float) -> tuple[float, float]:
    """Force F [N] and couple K [N m] that extend a spring by `extension` [m] without turning its ends.

    Raises
    ------
    ValueError where the wire would have to be straight.
    """
    sine = helix.sine + extension / helix.length
    if not abs(sine) < 1.0:
        raise ValueError(f"an extension of {extension:g} m needs a longer wire than {helix.length:g} m")
    a = asin(sine)
    R = cos(a) / helix.rate
    bending = EI * (cos(a) ** 2 / R - helix.curvature)
    twisting = GJ * (sin(a) * cos(a) / R - helix.twist)
    return (twisting * cos(a) - bending * sin(a)) / R, twisting * sin(a) + bending * cos(a)


def close_coiled_stiffness(shear_modulus: float, wire: float, coil: float, turns: float) -> float:
    """G d^4/(8 D^3 n) [N/m] of a close-coiled spring, d and D the diameters of wire and coil [m] (Wahl 1944).

    The limit of `pulled_spring` for a -> 0 and a small extension.
    """
    return shear_modulus * wire**4 / (8.0 * coil**3 * turns)


def turns(helix: Helix) -> float:
    """Number of coils."""
    return helix.rate * helix.length / (2.0 * pi)
