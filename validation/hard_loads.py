"""Hard loads: gravity, follower forces, stretch and compression by law, absurd loads, supports, buckling."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from reference.homogeneous import (
    PrincipalStress,
    principal_mooney_rivlin,
    principal_neo_hookean,
    principal_saint_venant_kirchhoff,
)
from reference.homogeneous import uniaxial as uniaxial_state
from validation.hard_case import REFUSED, TYPED, HardCase
from validation.hard_families import deviation
from validation.hard_scenes import (
    BOTH_ENDS,
    DOWN,
    UP,
    YOUNG,
    Scene,
    arm,
    axial_stiffness,
    force,
    from_buckled,
    from_own_weight,
    from_reference,
    from_rod,
    from_stretch,
    gravity,
    moment,
    standing,
)

EULER = 2.4674011002723395  # pi^2/4: buckling load of the clamped-free column in E I/L^2 (Euler 1744)
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
    yield from _absurd()
    yield from _supports()
    yield from _buckling()


def _gravity() -> Iterator[HardCase]:
    family = "gravity"
    for number in (1, 10, 100, 1000):
        yield HardCase(
            family,
            f"hanging, rho g A L3/EI = {number}",
            arm(gravity=gravity(number, DOWN), base=standing(DOWN)),
            "stretches under its own weight, no bending",
            limits=deviation(1e-4, "clamp end effect and mesh of a linear stretch field, of 2 % at most"),
            deviation=from_own_weight,
        )
    for number in (1, 10, 100, 1000):
        stable = number < GREENHILL
        yield HardCase(
            family,
            f"upright, rho g A L3/EI = {number}",
            arm(gravity=gravity(number, DOWN), base=standing(UP)),
            "below Greenhill's 7.84: stands" if stable else
            "past Greenhill's 7.84: the perfect column stands unstably, and the result says so",
            said="" if stable else "unstable",
            limits=deviation(1e-4, "as hanging; the straight shape of a perfect column is an equilibrium"),
            deviation=from_own_weight,
        )  # fmt: skip
    for number in (10, 100, 1000):
        yield HardCase(
            family,
            f"sideways, rho g A L3/EI = {number}",
            arm(gravity=gravity(number, DOWN)),
            "the rod sags until it hangs; a boundary layer of bending at the clamp",
            limits=deviation(2e-2, "finite strain and a boundary layer of L/sqrt(number) on 12 elements"),
            deviation=from_rod,
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
    )
    for number in (BECK, 30.0):
        squeeze = number / (4.0 * 40.0**2)  # P/(E A) = number I/(A L^2)
        yield HardCase(
            family,
            f"follower compression, P L2/EI = {number:g}",
            arm(force=[force([-number, 0, 0], direction="follower")]),
            "Beck's column flutters from 20.05; as a static path the straight shape goes on",
            limits=deviation(1e-4, "uniaxial compression of 0.5 %; the clamp holds the section over R"),
            deviation=from_stretch(_stable_stretch(-squeeze)),
        )
    yield HardCase(
        family,
        "follower compression past flutter, pushed sideways",
        arm(force=[force([-30, 0.1, 0], direction="follower")]),
        "no static branch turns off: a small lateral force bends it a little",
        limits=deviation(2e-2, "finite strain of the rod in bending"),
        deviation=from_rod,
    )


def _stable_stretch(force_over_EA: float) -> float:
    """Largest root of l^3 - l = 2 F/(E A), uniaxial Saint Venant-Kirchhoff."""
    from validation.hard_scenes import largest_root

    return largest_root(2.0 * force_over_EA)


def _pulled(stress: PrincipalStress, stretch: float, material: dict[str, Any], slenderness: float) -> Scene:
    """A rod free to contract under the dead tip force at which its law has the stretch."""
    area = axial_stiffness(slenderness, 1.0)
    P = uniaxial_state(stress, stretch).stress * area
    return arm(
        slenderness,
        material=material,
        supports=[{"at": 0.0, "kind": "free_section_clamp"}],
        elements=4,
        force=[{"value": [P, 0.0, 0.0]}],
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
            supports=[{"at": 0.0, "kind": "free_section_clamp"}],
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
        _pulled(principal_saint_venant_kirchhoff(YOUNG, 0.3), 0.5, {"young_modulus": YOUNG, "poisson_ratio": 0.3}, 1.5),
        "the force falls beyond stretch 0.577: a dead load reaches the other root, 0.651",
        limits=exact,
        deviation=from_stretch(_stable_stretch(0.5 * (0.5**3 - 0.5))),
    )  # fmt: skip
    yield HardCase(
        family,
        "Saint Venant-Kirchhoff, compression 0.2 E A",
        arm(1.5, elements=4, supports=[{"at": 0.0, "kind": "free_section_clamp"}],
            force=[{"value": [-0.2 * axial_stiffness(1.5), 0.0, 0.0]}]),
        "more than 0.19245 E A has no equilibrium (stretch 0.577)",
        expected=("material_unstable",),
        said="0.577",
    )  # fmt: skip


def _absurd() -> Iterator[HardCase]:
    family = "absurd loads"
    still = deviation(1e-15, "nothing is divided by the load")
    yield HardCase(
        family, "no load at all", arm(), "nothing is divided by the load", limits=still, deviation=from_reference
    )
    for size in ("0", "1e-300"):
        yield HardCase(
            family,
            f"tip force {size} N",
            arm(force=[{"value": [0.0, float(size), 0.0]}]),
            "nothing is divided by the load",
            limits=still,
            deviation=from_reference,
        )
    huge: dict[str, Any] = {
        "tip force 1e300 N": arm(force=[{"value": [0.0, 1e300, 0.0]}]),
        "tip moment 1e300 N m": arm(moment=[{"value": [0.0, 0.0, 1e300]}]),
        "follower force 1e300 N": arm(force=[{"value": [0.0, 1e300, 0.0], "direction": "follower"}]),
        "gravity 1e300 m/s2": arm(gravity={"acceleration": [0.0, 0.0, -1e300]}),
        "line load 1e300 N/m": arm(line_load=[{"value": [0.0, 0.0, -1e300]}]),
    }
    for name, scene in huge.items():
        yield HardCase(
            family, name, scene, "overflows: a typed reason, nothing that is not finite", TYPED, "stiffness|overflow"
        )


def _supports() -> Iterator[HardCase]:
    family = "supports"
    yield HardCase(
        family,
        "clamped at both ends, moment at the middle",
        arm(moment=[moment([0, 0, 10.0], at=0.5)], supports=BOTH_ENDS),
        "statically indeterminate, no predictor; by symmetry the middle does not move",
    )
    yield HardCase(
        family,
        "pinned at one end only",
        arm(supports=[{"at": 0.0, "kind": "pin"}], force=[{"value": [0, 0.01, 0]}]),
        "a mechanism: refused before anything is computed (exit code 2)",
        REFUSED,
        "rigid body",
    )
    yield HardCase(
        family,
        "clamp and pin on the same section",
        arm(supports=[{"at": 0.0, "kind": "clamp"}, {"at": 0.0, "kind": "pin"}]),
        "contradictory supports are refused (exit code 2)",
        REFUSED,
        "same section",
    )
    yield HardCase(
        family,
        "more supports than elements can hold",
        arm(elements=1, supports=[{"at": at, "kind": "pin"} for at in (0.0, 0.5, 1.0)]),
        "supports closer than elements are refused (exit code 2)",
        REFUSED,
        "element",
    )


def _buckling() -> Iterator[HardCase]:
    family = "buckling"
    yield HardCase(
        family,
        "perfect column at 3 Euler loads",
        arm(force=[force([-3 * EULER, 0, 0])]),
        "the straight shape is an equilibrium, and the result warns that it is unstable",
        said="unstable",
        limits=deviation(1e-4, "uniaxial compression; the clamp holds the section over R"),
        deviation=from_stretch(_stable_stretch(-3 * EULER / (4.0 * 40.0**2))),
    )
    yield HardCase(
        family,
        "column with 0.1 % lateral load at 3 Euler loads",
        arm(force=[force([-3 * EULER, 3e-3 * EULER, 0])]),
        "one long step would land on the unstable, nearly straight shape; the path takes the buckled one",
        limits=deviation(3e-2, "buckled elastica; finite strain, kappa R = 0.1, and the lateral load"),
        deviation=from_buckled(3.0),
    )
    yield HardCase(
        family,
        "column with 1e-6 lateral load at 2 Euler loads",
        arm(400, force=[force([-2 * EULER, 2e-6 * EULER, 0], 400)]),
        "a tiny imperfection: the path turns off within 1e-4 of the buckling load",
        limits=deviation(1e-3, "buckled elastica; finite strain (kappa R)^2 = 1e-4, mesh"),
        deviation=from_buckled(2.0),
    )
    yield HardCase(
        family,
        "clamped at both ends, pushed together from the middle",
        arm(100, force=[force([60, 0.06, 0], 100, at=0.5)], supports=BOTH_ENDS),
        "one half is pulled, the other pushed by 30 E I/L^2 and more; 0.1 % lateral load",
    )
    yield HardCase(
        family,
        "clamped at both ends, pushed past buckling",
        arm(100, force=[force([400, 0.4, 0], 100, at=0.5)], supports=BOTH_ENDS),
        "the pushed half carries 200 E I/L^2, its buckling load is 4 pi^2 E I/(L/2)^2 = 158",
    )


WAITING = (
    ("taper 10:1 and a stiffness jump of 1e4", "segments"),
    ("right-angle frame, ring", "joints"),
    ("shallow arch: snap-through and snap-back", 'method = "arclength"'),
    ("lateral buckling of a strip, branch switching", "[stability]"),
)
