r"""Section law of a round rod to the order that finite strain adds: W in stretch, bending and twist.

With e the stretch of the axis less 1, b the size of the curvature, t the twist and R the radius,

    W = EA (e^2/2 + a_3 e^3) + EI b^2/2 + GJ t^2/2 + e EI (a_1 b^2 + a_2 t^2)
        + EI R^2 (a_4 b^4 + a_5 b^2 t^2 + a_6 t^4) + shear,

all terms that are of the same order when e ~ (b R)^2, and the cubic one of a rod in thrust. The numbers depend
on material law and Poisson ratio alone; `fitted` takes them from the exact section problem (section.py).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROUNDS = 8  # of the fixed point: it contracts by (b R)^2 and e
CELLS = 2  # quads across the core of the bar


@dataclass(frozen=True)
class RoundLaw:
    """The numbers a_1 .. a_6 [-]; stretch_unit EA L^2/EI and radius_2 R^2/L^2 in the units of the rod."""

    a_1: float = 0.0
    a_2: float = 0.0
    a_3: float = 0.0
    a_4: float = 0.0
    a_5: float = 0.0
    a_6: float = 0.0
    poisson_ratio: float = 0.0
    stretch_unit: float = 1.0
    radius_2: float = 0.0

    @property
    def linear(self) -> bool:
        """Whether nothing is added to the linear law."""
        return not any((self.a_1, self.a_2, self.a_3, self.a_4, self.a_5, self.a_6))

    def scaled(self, stretch_unit: float, radius_2: float) -> RoundLaw:
        """The same law in the units of a rod: EI = L = 1."""
        return replace(self, stretch_unit=stretch_unit, radius_2=radius_2)

    def strains(
        self, n: Array, m: Array, K_n: Array, K_m: Array, v: Array, u: Array
    ) -> tuple[Array, Array]:
        """v and u (..., 3) that carry n and m (..., 3), from strains near them; units EI = L = 1."""
        new_v, new_u = np.array([1.0, 0.0, 0.0]) + n / K_n, m / K_m
        if self.linear:
            return new_v, new_u
        e, t, b2 = v[..., 0] - 1.0, u[..., 0], u[..., 1] ** 2 + u[..., 2] ** 2
        for _ in range(ROUNDS):
            e = (n[..., 0] - self.a_1 * b2 - self.a_2 * t**2) / self.stretch_unit - 3.0 * self.a_3 * e**2
            bending = 1.0 + 2.0 * self.a_1 * e + self.radius_2 * (4.0 * self.a_4 * b2 + 2.0 * self.a_5 * t**2)
            twisting = K_m[0] + 2.0 * self.a_2 * e
            twisting = twisting + self.radius_2 * (2.0 * self.a_5 * b2 + 4.0 * self.a_6 * t**2)
            t, across = m[..., 0] / twisting, m[..., 1:] / bending[..., None]
            b2 = np.sum(across**2, axis=-1)
        return (
            np.concatenate([1.0 + e[..., None], new_v[..., 1:]], axis=-1),
            np.concatenate([t[..., None], across], axis=-1),
        )


LINEAR = RoundLaw()


def fitted_numbers(material: Mapping[str, Any]) -> dict[str, float]:
    """`fitted` as numbers that can be stored."""
    law = fitted(material)
    names = ("a_1", "a_2", "a_3", "a_4", "a_5", "a_6", "poisson_ratio")
    return {name: float(getattr(law, name)) for name in names}


def fitted(material: Mapping[str, Any], strain: float = 0.02) -> RoundLaw:
    """The numbers of a law, from bars of radius 1 in extension, bending, torsion and both at once.

    material : table of a scene file (`rod_inputs`); strain : kappa R of these states [-], whose square is what
    the numbers err by, relatively
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
    a_5 = (across / (EI * b) - 1.0 - 2.0 * a_1 * e - 4.0 * a_4 * b**2) / (2.0 * t**2)
    return RoundLaw(a_1, a_2, a_3, a_4, a_5, a_6, law.poisson_ratio)
