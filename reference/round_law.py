r"""Section law of a round rod to the order that finite strain adds: W in stretch, bending and twist.

With e the stretch of the axis less 1, b the size of the curvature, t the twist and R the radius,

    W = EA (e^2/2 + a_3 e^3) + EI b^2/2 + GJ t^2/2 + e EI (a_1 b^2 + a_2 t^2)
        + EI R^2 (a_4 b^4 + a_5 b^2 t^2 + a_6 t^4) + GA g.g/2 + a_7 EI t g.b,

g and b the vectors of shear and curvature: all terms that are of the same order when e ~ g ~ (b R)^2, and the
cubic one of a rod in thrust. By a_7 the axis of a bent and twisted rod leans from the normal of its sections.
The numbers depend on material law and Poisson ratio alone; `fitted` takes them from the exact section problem
(section.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROUNDS = 8  # of the fixed point: it contracts by (b R)^2 and e
NUMBERS = tuple(f"a_{k}" for k in range(1, 8))
CELLS = 2  # quads across the core of the bar


@dataclass(frozen=True)
class RoundLaw:
    """The numbers a_1 .. a_7 [-], and the rod that they belong to.

    poisson_ratio : of the section's lateral contraction, which moves what runs in it
    stretch_unit, radius_2 : EA L^2/EI and R^2/L^2
    """

    a_1: float = 0.0
    a_2: float = 0.0
    a_3: float = 0.0
    a_4: float = 0.0
    a_5: float = 0.0
    a_6: float = 0.0
    a_7: float = 0.0
    poisson_ratio: float = 0.0
    stretch_unit: float = 1.0
    radius_2: float = 0.0

    @property
    def linear(self) -> bool:
        """Whether nothing is added to the linear law."""
        return not any(getattr(self, name) for name in NUMBERS)

    def scaled(self, stretch_unit: float, radius_2: float) -> RoundLaw:
        """The same law in the units of a rod: EI = L = 1."""
        return replace(self, stretch_unit=stretch_unit, radius_2=radius_2)

    def strains(self, n: Array, m: Array, K_n: Array, K_m: Array, v: Array, u: Array) -> tuple[Array, Array]:
        """v and u (..., 3) that carry n and m (..., 3), from strains near them; units EI = L = 1."""
        new_v, new_u = np.array([1.0, 0.0, 0.0]) + n / K_n, m / K_m
        if self.linear:
            return new_v, new_u
        e, g = v[..., 0] - 1.0, v[..., 1:]
        t, b = u[..., 0], u[..., 1:]
        for _ in range(ROUNDS):
            b2 = np.sum(b * b, axis=-1)
            e = (n[..., 0] - self.a_1 * b2 - self.a_2 * t**2) / self.stretch_unit - 3.0 * self.a_3 * e**2
            g = (n[..., 1:] - self.a_7 * t[..., None] * b) / K_n[1:]
            bending = 1.0 + 2.0 * self.a_1 * e + self.radius_2 * (4.0 * self.a_4 * b2 + 2.0 * self.a_5 * t**2)
            twisting = K_m[0] + 2.0 * self.a_2 * e
            twisting = twisting + self.radius_2 * (2.0 * self.a_5 * b2 + 4.0 * self.a_6 * t**2)
            t, b = (
                (m[..., 0] - self.a_7 * np.sum(g * b, axis=-1)) / twisting,
                (m[..., 1:] - self.a_7 * t[..., None] * g) / bending[..., None],
            )
        return np.concatenate([1.0 + e[..., None], g], axis=-1), np.concatenate([t[..., None], b], axis=-1)


LINEAR = RoundLaw()


def fitted_numbers(material: Mapping[str, Any]) -> dict[str, float]:
    """`fitted` as numbers that can be stored, by the names of `RoundLaw`."""
    law = fitted(material)
    return {name: float(getattr(law, name)) for name in (*NUMBERS, "poisson_ratio")}


def fitted(material: Mapping[str, Any], strain: float = 0.02) -> RoundLaw:
    """The numbers of a law, from bars of radius 1 in extension, bending, torsion and both at once.

    material : table of a scene file (`rod_inputs`)
    strain : kappa R of these states [-]; its square is what the numbers err by, relatively
    """
    from reference.rod_inputs import law_of, section_of
    from reference.section import bend, bend_and_twist, extend, stiffness, twist

    law, mesh = law_of(material), section_of({"shape": "circle", "radius": 1.0}, CELLS)
    K = stiffness(mesh, law)
    EA, EI, GJ = K.EA, K.EI_z, K.GJ
    pulled = [float(extend(mesh, law, stretch=1.0 + e).force[0]) for e in (strain, -strain)]
    a_3 = (pulled[0] + pulled[1]) / (6.0 * EA * strain**2)
    bent = bend(mesh, law, curvature=strain)
    a_1 = -(bent.axial_stretch - 1.0) * EA / EI / strain**2
    e = bent.axial_stretch - 1.0
    a_4 = (float(bent.couple[2]) / (EI * strain) - 1.0 - 2.0 * a_1 * e) / (4.0 * strain**2)
    turned = twist(mesh, law, twist=strain)
    e = turned.axial_stretch - 1.0
    a_2 = -e * EA / EI / strain**2
    a_6 = ((float(turned.couple[0]) / strain - GJ) / EI - 2.0 * a_2 * e) / (4.0 * strain**2)
    both = bend_and_twist(mesh, law, np.array([GJ, 0.0, EI]) * strain)
    b, t, e = both.curvature, both.twist, both.axial_stretch - 1.0
    across = float(np.hypot(both.couple[1], both.couple[2]))
    tangent = both.velocity + np.cross(both.screw, both.centre)
    lean = float(tangent[1:] @ both.screw[1:]) / (t * b**2)  # g = lean t b without a force across
    a_7 = -lean * EA / (2.0 * (1.0 + law.poisson_ratio)) / EI
    rest = across / (EI * b) - 1.0 - 2.0 * a_1 * e - 4.0 * a_4 * b**2 - a_7 * lean * t**2
    return RoundLaw(a_1, a_2, a_3, a_4, rest / (2.0 * t**2), a_6, a_7, law.poisson_ratio)
