"""Hard loads: gravity, follower forces, stretch and compression by law."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from reference.homogeneous import (
    PrincipalStress,
    principal_mooney_rivlin,
    principal_neo_hookean,
    principal_saint_venant_kirchhoff,
    uniaxial as uniaxial_state,
)
from validation.criteria import Limit
from validation.hard_case import HardCase
from validation.hard_families import deviation
from validation.hard_scenes import (
    DOWN,
    FREE_SECTION,
    LENGTH,
    UP,
    YOUNG,
    Scene,
    arm,
    axial_stiffness,
    force,
    from_own_weight,
    from_rod,
    from_stretch,
    gravity,
    stable_stretch,
    standing,
)

GREENHILL = 7.83735  # gravity number at which an upright column loses stability (Greenhill 1881)
BECK = 20.05  # P L^2/EI at which a follower compression makes a column flutter (Beck 1952)
UNIFORM = 1e-9  # a uniform state is in the space of the element: only rounding and the tolerance are left
RUBBER_C10, RUBBER_C01 = 1.2e5, 4.0e4  # Pa: mu = 2 (c10 + c01) = 3.2e5 Pa, near E = 1 MPa
RUBBER_BULK = 1.5e7  # Pa: nu = 0.489


def loads() -> Iterator[HardCase]:
    """All families of this module."""
    yield from _gravity()
    yield from _follower()
    yield from _uniaxial()
    yield from _pressed()


def _gravity() -> Iterator[HardCase]:
    family = "gravity"
    weight = deviation(1e-4, "stretch varies by 15 % at most, nearly linearly, over 12 elements")
    for number in (1, 10, 100, 1000):
        yield HardCase(
            family,
            f"hanging, rho g A L3/EI = {number}",
            arm(gravity=gravity(number, DOWN), base=standing(DOWN), supports=FREE_SECTION),
            "stretches under its own weight, no bending",
            limits=weight,
            deviation=from_own_weight,
        )
    for number in (1, 10, 100, 1000):
        stable = number < GREENHILL
        yield HardCase(
            family,
            f"upright, rho g A L3/EI = {number}",
            arm(gravity=gravity(number, DOWN), base=standing(UP), supports=FREE_SECTION),
            "below Greenhill's 7.84: stands" if stable else
            "past Greenhill's 7.84: the perfect column stands unstably, and the result says so",
            said="" if stable else "unstable",
            limits=weight,
            deviation=from_own_weight,
        )  # fmt: skip
    for number in (10, 100, 1000):
        own = deviation(2e-2, "finite strain and a boundary layer of L/sqrt(number) on 12 elements")
        steep = Limit(
            "energy balance",
            5e-3,
            "U",
            "nine tenths of the sag happen in the first five steps of a hundred",
            kind="non-regression",
        )
        yield HardCase(
            family,
            f"sideways, rho g A L3/EI = {number}",
            arm(gravity=gravity(number, DOWN)),
            "the rod sags until it hangs; a boundary layer of bending at the clamp",
            limits=(*own, steep) if number == 1000 else own,
            deviation=from_rod,
            walk="quick" if number == 100 else "full",
        )


def _follower() -> Iterator[HardCase]:
    family = "follower"
    yield HardCase(
        family,
        "follower tip force, P L2/EI = 10",
        arm(force=[force([0, 10, 0], direction="follower")]),
        "unsymmetric load tangent, no closed-form start",
        limits=deviation(2e-2, "finite strain, kappa R = 0.25 at the clamp"),
        deviation=from_rod,
        walk="quick",
    )
    for number in (BECK, 30.0):
        squeeze = number / (4.0 * 40.0**2)  # P/(E A) = number I/(A L^2)
        yield HardCase(
            family,
            f"follower compression, P L2/EI = {number:g}",
            arm(force=[force([-number, 0, 0], direction="follower")]),
            "Beck's column flutters from 20.05; as a static path the straight shape goes on",
            limits=deviation(1e-4, "uniaxial compression of 0.5 %; the clamp holds the section over R"),
            deviation=from_stretch(stable_stretch(-squeeze)),
        )
    yield HardCase(
        family,
        "follower compression past flutter, pushed sideways",
        arm(force=[force([-30, 0.1, 0], direction="follower")]),
        "no static branch turns off: a small lateral force bends it a little",
        limits=deviation(2e-2, "finite strain of the rod in bending"),
        deviation=from_rod,
    )


def _pulled(stress: PrincipalStress, stretch: float, material: dict[str, Any], slenderness: float) -> Scene:
    """A rod free to contract under the dead tip force at which its law has the stretch."""
    area = axial_stiffness(slenderness, 1.0)
    P = uniaxial_state(stress, stretch).stress * area
    return arm(
        slenderness,
        material=material,
        supports=FREE_SECTION,
        elements=4,
        force=[{"value": [P, 0.0, 0.0]}],
    )


def _pressed() -> Iterator[HardCase]:
    """Pressure over the whole section and on both ends: every stretch is s, U(s^3) the energy per volume.

    dU = p d(s^3) gives p = [mu (s - 1/s) + 3 lambda ln s / s]/s^2 for the neo-Hookean law and p = 3 K (s^2 -
    1)/(2 s) for Saint Venant-Kirchhoff, E = (s^2 - 1)/2 I, U = 9 K/2 ((s^2 - 1)/2)^2.
    """
    nu, slenderness = 0.3, 10.0
    mu, lame = YOUNG / (2.0 * (1.0 + nu)), YOUNG * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    bulk = lame + 2.0 * mu / 3.0
    laws = {
        "neo-hookean": lambda s: (mu * (s - 1.0 / s) + 3.0 * lame * math.log(s) / s) / s**2,
        "saint-venant-kirchhoff": lambda s: 3.0 * bulk * (s**2 - 1.0) / (2.0 * s),
    }
    for law, pressure in laws.items():
        for stretch in (1.2, 0.8):
            yield HardCase(
                "stretch by law",
                f"{law}, uniform section pressure, stretch {stretch:g}",
                arm(
                    slenderness,
                    material={"law": law, "young_modulus": YOUNG, "poisson_ratio": nu},
                    supports=FREE_SECTION,
                    elements=4,
                    pressure=[{"value": pressure(stretch), "chamber": {"radius": LENGTH / slenderness}}],
                ),
                "a chamber as wide as the section, under pressure or vacuum: hydrostatic, in closed form",
                limits=deviation(UNIFORM, "a uniform state is exact on every mesh (README.md)"),
                deviation=from_stretch(stretch),
                walk="full",
            )


def _uniaxial() -> Iterator[HardCase]:
    family = "stretch by law"
    nu = 0.45
    rubbers = {
        "neo-Hookean": (
            principal_neo_hookean(YOUNG, nu),
            {"law": "neo-hookean", "young_modulus": YOUNG, "poisson_ratio": nu},
        ),
        "Mooney-Rivlin": (
            principal_mooney_rivlin(RUBBER_C10, RUBBER_C01, RUBBER_BULK),
            {"law": "mooney-rivlin", "c10": RUBBER_C10, "c01": RUBBER_C01, "bulk_modulus": RUBBER_BULK},
        ),
    }
    exact = deviation(UNIFORM, "a uniform state is exact on every mesh (README.md)")
    for law, (stress, material) in rubbers.items():
        # L/R = 1.5: a slender strut would have buckled long before half its length.
        for stretch, slenderness in ((3.0, 40.0), (0.5, 1.5)):
            yield HardCase(
                family,
                f"{law}, stretch {stretch:g}",
                _pulled(stress, stretch, material, slenderness),
                "dead tip force from the law's own uniaxial relation",
                limits=exact,
                deviation=from_stretch(stretch),
                walk="quick" if (law, stretch) == ("neo-Hookean", 3.0) else "full",
            )
    linear = {"young_modulus": YOUNG, "poisson_ratio": 0.1}
    kirchhoff = principal_saint_venant_kirchhoff(YOUNG, 0.1)
    yield HardCase(
        family,
        "Saint Venant-Kirchhoff, stretch 3, nu = 0.1",
        _pulled(kirchhoff, 3.0, linear, 40.0),
        "lateral stretch sqrt(1 - nu (9 - 1)) = 0.45: far beyond the law's use, and still an equilibrium",
        limits=exact,
        deviation=from_stretch(3.0),
    )
    yield HardCase(
        family,
        "Saint Venant-Kirchhoff, stretch 3, nu = 0.3",
        arm(
            supports=FREE_SECTION,
            elements=4,
            force=[{"value": [12.0 * axial_stiffness(), 0, 0]}],
        ),
        "1 - nu (9 - 1) < 0: the section has shrunk to nothing before (at stretch 2.08)",
        expected=("inverted_element", "material_unstable"),
        said="inside out|det F|section",
    )
    yield HardCase(
        family,
        "Saint Venant-Kirchhoff, force of stretch 0.5",
        _pulled(principal_saint_venant_kirchhoff(YOUNG, 0.3), 0.5, {**linear, "poisson_ratio": 0.3}, 1.5),
        "the force falls beyond stretch 0.577: a dead load reaches the other root, 0.651",
        limits=exact,
        deviation=from_stretch(stable_stretch(0.5 * (0.5**3 - 0.5))),
    )  # fmt: skip
    yield HardCase(
        family,
        "Saint Venant-Kirchhoff, compression 0.2 E A",
        arm(1.5, elements=4, supports=FREE_SECTION,
            force=[{"value": [-0.2 * axial_stiffness(1.5), 0.0, 0.0]}]),
        "more than 0.19245 E A has no equilibrium (stretch 0.577)",
        expected=("material_unstable",),
        said="0.577",
    )  # fmt: skip
