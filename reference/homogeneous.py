"""Homogeneous stretches of compressible rubber: uniaxial and equibiaxial, one implicit equation each.

Symbols: `lambda_` prescribed stretch, `t` the free one, `P` nominal stress of the prescribed ones [Pa].
Written in principal stretches, P_i = dW/dlambda_i: neither the tensors of the solid nor its code appear.
The free stretch solves P_free = 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import log

from reference.root import bracketed_root

PrincipalStress = Callable[[float, float, float], float]
FREE_RANGE = (0.2, 3.0)  # of the free stretch, searched from its incompressible value


@dataclass(frozen=True)
class HomogeneousStretch:
    """Free stretch [-] and nominal stress of the prescribed directions [Pa]."""

    free: float
    stress: float


def principal_saint_venant_kirchhoff(young_modulus: float, poisson_ratio: float) -> PrincipalStress:
    """P_1 = lambda_1 E/((1 + nu)(1 - 2 nu)) ((1 - nu) e_1 + nu (e_2 + e_3)), e_i = (lambda_i^2 - 1)/2."""
    nu = poisson_ratio
    factor = young_modulus / ((1 + nu) * (1 - 2 * nu))

    def stress(a: float, b: float, c: float) -> float:
        return a * factor / 2 * ((1 - nu) * (a**2 - 1) + nu * (b**2 + c**2 - 2))

    return stress


def principal_neo_hookean(young_modulus: float, poisson_ratio: float) -> PrincipalStress:
    """P_1 = (mu (lambda_1^2 - 1) + lambda ln J)/lambda_1."""
    mu = young_modulus / (2 * (1 + poisson_ratio))
    lam = 2 * mu * poisson_ratio / (1 - 2 * poisson_ratio)

    def stress(a: float, b: float, c: float) -> float:
        return (mu * (a**2 - 1) + lam * (log(a) + log(b) + log(c))) / a

    return stress


def principal_mooney_rivlin(c10: float, c01: float, bulk_modulus: float) -> PrincipalStress:
    """lambda_1 P_1 = 2/3 c10 (2 p - q - r) + 2/3 c01 (p q + p r - 2 q r) + K J (J - 1).

    p, q, r are the squares of the isochoric stretches J^(-1/3) lambda_i.
    """

    def stress(a: float, b: float, c: float) -> float:
        J = a * b * c
        p, q, r = (x * x / J ** (2 / 3) for x in (a, b, c))
        shape = c10 * (2 * p - q - r) + c01 * (p * q + p * r - 2 * q * r)
        return (2 / 3 * shape + bulk_modulus * J * (J - 1)) / a

    return stress


def uniaxial(stress: PrincipalStress, stretch: float) -> HomogeneousStretch:
    """One direction stretched, two free: P_2(lambda, t, t) = 0, P = P_1(lambda, t, t)."""
    free = _free_root(lambda t: stress(t, t, stretch), stretch**-0.5)
    return HomogeneousStretch(free, stress(stretch, free, free))


def equibiaxial(stress: PrincipalStress, stretch: float) -> HomogeneousStretch:
    """Two directions stretched, one free: P_3(lambda, lambda, t) = 0, P = P_1(lambda, lambda, t)."""
    free = _free_root(lambda t: stress(t, stretch, stretch), stretch**-2)
    return HomogeneousStretch(free, stress(stretch, stretch, free))


def _free_root(stress: Callable[[float], float], incompressible: float) -> float:
    """Root of the free stress around the incompressible stretch.

    Raises
    ------
    ValueError
        When the free direction has no equilibrium in `FREE_RANGE`.
    """
    low, high = (f * incompressible for f in FREE_RANGE)
    if stress(low) * stress(high) > 0:
        raise ValueError(
            f"no free stretch between {low:.3g} and {high:.3g}: the law has lost its equilibrium there; "
            "try a stretch closer to 1."
        )
    return bracketed_root(stress, low, high)
