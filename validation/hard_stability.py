"""Critical loads and paths beyond them: columns, strips, arches, against `reference/`.

The scene says what to look for: ``[stability]`` for a buckling load or a branch, ``method = "arclength"`` for
a path through limit points.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from ancf.scene import Scene as SceneRecord
from ancf.sections import Ellipse
from ancf.solution import Solution
from reference.arch import Arch, Ends
from reference.arch_path import critical_points
from reference.bifurcation import lateral_buckling, right_angle_frame
from reference.buckling import self_weight_load
from reference.critical_loads import column_load
from reference.rod import RodProperties
from validation.criteria import Limit
from validation.hard_case import TYPED, HardCase
from validation.hard_limits import WALKED, deviation
from validation.hard_scenes import (
    FULL_CIRCLE,
    LENGTH,
    UP,
    YOUNG,
    Deviation,
    Scene,
    arm,
    axial_stiffness,
    bending_stiffness,
    force,
    from_buckled,
    gravity,
    moment,
    rolled,
    standing,
)
from validation.scenes import reference_rod

EULER = math.pi**2 / 4  # buckling load of the clamped-free column in E I/L^2
ARC_LENGTH = {"method": "arclength", "max_steps": 400}
FOLLOWED = dict.fromkeys(
    WALKED, "the path is followed by its arc; equal load steps cannot pass a limit point"
)
SLENDER = 100.0
DRIFTS = ("units", "turned", "moved", "reversed", "renumbered", "one ulp", "threads")
NEUTRAL = "nothing but rounding holds a buckled round column in its plane: it may turn about its first axis"


def stability() -> Iterator[HardCase]:
    """Critical loads, branches, snaps."""
    yield from _columns()
    yield from _strip()
    yield from _arches()
    yield from _spatial()


def critical(value: float, reason: str) -> tuple[Limit, ...]:
    """Limit of the relative error of critical loads."""
    return (Limit("deviation", value, "of the load", reason, kind="non-regression"),)


def _columns() -> Iterator[HardCase]:
    family = "critical loads"
    EI, EA = bending_stiffness(SLENDER), axial_stiffness(SLENDER)
    exact = column_load(EI, EA, EA / 2.6, LENGTH) * LENGTH**2 / (EULER * EI)
    yield HardCase(
        family,
        "column, its buckling load",
        arm(SLENDER, force=[force([-EULER, 0, 0], SLENDER)], stability={}),
        "the factor on the Euler load, with compression and shear before buckling",
        limits=critical(1e-3, "required by the issue: Euler 0.1 %; reference.critical_loads"),
        deviation=from_factor(lambda _: exact),
        drifts="full",
        not_asked=FOLLOWED,
    )
    yield HardCase(
        family,
        "column, its buckling load from a unit load 1e-4 of it",
        arm(SLENDER, force=[force([-1e-4 * EULER, 0, 0], SLENDER)], stability={}),
        "a factor of ten thousand, as engineers ask for it",
        limits=critical(1e-3, "required by the issue: Euler 0.1 %; reference.critical_loads"),
        deviation=from_factor(lambda _: 1e4 * exact),
        drifts="full",
        not_asked=FOLLOWED,
    )
    yield HardCase(
        family,
        "column at 2 Euler loads, buckled branch",
        arm(
            SLENDER, elements=24, force=[force([-2 * EULER, 0, 0], SLENDER)], stability={"branch": "buckled"}
        ),
        "perfect: both eigenvalues of a round rod vanish together; it turns off to +y of its base",
        limits=(
            *deviation(5e-3, "buckled elastica; finite strain 1.4 (kappa R)^2 = 1e-3 at most, mesh"),
            *(Limit(f"drift, {name}", 1e-6, "L", NEUTRAL) for name in DRIFTS),
        ),
        deviation=from_buckled(2.0),
        stable=True,
        drifts="full",
        not_asked={**FOLLOWED, "condition number": "to turn about its first axis is a neutral motion"},
    )
    yield HardCase(
        family,
        "column at 2 Euler loads by arc length",
        arm(SLENDER, force=[force([-2 * EULER, 0, 0], SLENDER)], solver=ARC_LENGTH),
        "perfect: the primary branch goes on straight, and the result warns that it is unstable",
        said="unstable",
        limits=critical(1e-3, "required by the issue: Euler 0.1 %; reference.critical_loads"),
        deviation=from_factor(lambda _: 0.5 * exact),
        drifts="full",
        not_asked=FOLLOWED,
    )
    greenhill = self_weight_load(EI, LENGTH) * LENGTH**3 / EI
    yield HardCase(
        family,
        "upright, critical weight",
        arm(
            SLENDER, elements=24, gravity=gravity(1.0, [0, 0, -1.0], SLENDER), base=standing(UP), stability={}
        ),
        "Greenhill's 7.837: the weight at which a standing rod falls over",
        limits=critical(5e-3, "thin rod; shear and compression lower it by some (R/L)^2, the mesh by 1/n^2"),
        deviation=from_factor(lambda _: greenhill),
        drifts="full",
        not_asked=FOLLOWED,
    )
    scene = arm(SLENDER, force=[force([-20.05, 0, 0], SLENDER, direction="follower")], stability={})
    yield HardCase(
        family,
        "follower tip force at the flutter load",
        scene,
        "Beck's column: no static critical load exists, and none may be found; flutter is no static matter",
        limits=critical(0.0, "1 if a critical load was found"),
        deviation=no_critical_load,
        drifts="full",
        not_asked=FOLLOWED,
    )


def _strip() -> Iterator[HardCase]:
    """A narrow cantilever: 3363, whose torsion of an elliptic section is Saint-Venant's."""
    height = 0.005
    second = math.pi * height**3 * 0.1 * height / 4.0  # about z
    scene = {
        "rod": [{
            "length": 1.0, "elements": 12, "element": "3363",
            "section": {"shape": "ellipse", "semi_axis_y": height, "semi_axis_z": 0.1 * height},
            "material": {"young_modulus": 1e9, "poisson_ratio": 0.3},
        }],
        "force": [{"value": [0.0, 1e9 * second, 0.0]}],
        "stability": {},
    }  # fmt: skip
    yield HardCase(
        "critical loads",
        "narrow cantilever, lateral buckling",
        scene,
        "a strip 10:1 bent in its stiff plane: it turns aside; bending before buckling counts",
        limits=critical(1e-2, "required by the issue; the clamp holds the section, over its height"),
        deviation=from_factor(_lateral),
        drifts="full",
        not_asked=FOLLOWED,
    )

    for sign, word in ((1, "pulled"), (-1, "pushed")):
        yield HardCase(
            "critical loads",
            f"right-angle frame, {word} at its tip",
            _frame(sign),
            "two strips 10:1 in one plane: the frame leaves it; bending before buckling counts",
            limits=critical(1e-2, "required by the issue; the clamp holds the section, over its height"),
            deviation=from_factor(lambda solution, sign=sign: _frame_load(solution, sign)),
            drifts="full",
            not_asked={
                **FOLLOWED,
                "condition number": "forces of joints stand in rows of their own scale",
                "Newton order by steps below 2": "four iterations in all, two of them still settling",
            },
        )


def _frame(sign: int) -> Scene:
    """A leg along x, a second one along y, a force along x at its end; in the plane both are stiff."""
    height = 0.005
    leg: dict[str, Any] = {
        "length": 1.0, "elements": 8, "element": "3363",
        "section": {"shape": "ellipse", "semi_axis_y": height, "semi_axis_z": 0.1 * height},
        "material": {"young_modulus": 1e9, "poisson_ratio": 0.3},
    }  # fmt: skip
    base = {"position": [1.0, 0.0, 0.0], "x_axis": [0.0, 1.0, 0.0], "y_axis": [-1.0, 0.0, 0.0]}
    stiff = 1e9 * math.pi * height**3 * 0.1 * height / 4.0
    return {
        "rod": [{**leg, "name": "leg", "supports": [{"at": 0.0}]}, {**leg, "name": "arm", "base": base}],
        "joint": [{"kind": "rigid", "a": {"rod": "leg", "at": 1.0}, "b": {"rod": "arm", "at": 0.0}}],
        "force": [{"rod": "arm", "value": [1e-3 * sign * stiff, 0.0, 0.0]}],
        "stability": {},
    }


def _frame_load(solution: Solution, sign: int) -> float:
    load = abs(float(solution.scene.forces[0].value[0]))
    return right_angle_frame(_strip_properties(solution), sign).value / load


def _strip_properties(solution: Solution) -> RodProperties:
    """The first rod; torsion of the ellipse is Saint-Venant's, J = pi a^3 b^3/(a^2 + b^2)."""
    rod = solution.scene.rods[0]
    section, law = rod.section, rod.material
    assert isinstance(section, Ellipse)
    a, b = section.semi_axis_y, section.semi_axis_z
    known, _ = reference_rod(SceneRecord((rod,)))
    return replace(known, GJ=law.lame_mu * math.pi * a**3 * b**3 / (a**2 + b**2))


def _lateral(solution: Solution) -> float:
    return lateral_buckling(_strip_properties(solution)).value / float(solution.scene.forces[0].value[1])


def arch(opening: float, load: float, ends: tuple[Ends, Ends], elements: int) -> tuple[Scene, Arch, float]:
    """Circular arch with its chord along x, force down at its crown [E I/L^2]; the reference's; that unit."""
    L, R, young, nu, half = 1.0, 0.004, 1e9, 0.3, 0.5 * opening
    EI = young * math.pi * R**4 / 4.0
    kinds = {"clamped": "clamp", "pinned": "pin"}
    rod = {
        "length": L,
        "elements": elements,
        "section": {"shape": "circle", "radius": R},
        "material": {"young_modulus": young, "poisson_ratio": nu},
        "curvature": [0.0, 0.0, -opening / L],
        "base": {
            "x_axis": [math.cos(half), math.sin(half), 0.0],
            "y_axis": [-math.sin(half), math.cos(half), 0.0],
        },
        "supports": [{"at": float(i), "kind": kinds[end]} for i, end in enumerate(ends)],
    }
    scene = {
        "rod": [rod],
        "force": [{"at": 0.5, "value": [0.0, -load * EI / L**2, 0.0]}],
        "solver": ARC_LENGTH,
        "stability": {"modes": 1},
    }
    exact = Arch(L, opening, EI, 4.0 * EI / R**2, 4.0 * EI / R**2 / (2.0 * (1.0 + nu)), ends=ends)
    return scene, exact, EI / L**2


def _arches() -> Iterator[HardCase]:
    yield _snap(
        "shallow clamped arch, snap-through",
        "the load falls from its maximum to its minimum and rises again: both limit loads",
        arch(0.6, 50.0, ("clamped", "clamped"), 16),
        50.0,
        2,
    )
    yield _snap(
        "high arch, one end pinned, snap-back",
        "between the limit loads the crown itself turns back twice",
        arch(2.0, 60.0, ("clamped", "pinned"), 24),
        60.0,
        4,
    )


def _snap(name: str, meaning: str, made: tuple[Scene, Arch, float], load: float, count: int) -> HardCase:
    """An arch under `load` units, held against the first `count` limit loads of the reference."""
    scene, exact, unit = made
    law = "Saint Venant-Kirchhoff for the linear law of the reference: 1.5 times the axial strain, 1e-3"
    return HardCase(
        "snap",
        name,
        scene,
        meaning,
        limits=critical(5e-3, f"required by the issue; {law}"),
        deviation=from_limit_loads(exact, count, load * unit),
        drifts="full",
        not_asked=FOLLOWED,
    )


def _spatial() -> Iterator[HardCase]:
    family = "snap"
    loads: dict[str, Any] = {
        "moment": [moment([0, 0, FULL_CIRCLE], SLENDER)],
        "force": [force([0, 0, 10.0], SLENDER)],
    }
    yield HardCase(
        family,
        "full circle with a force out of its plane, load steps",
        arm(SLENDER, **loads, solver={"predictor": "none"}),
        "the path turns back at 0.66 of the loads; load steps end there and say what to try",
        expected=("limit_point",),
        said="limit point",
    )
    yield HardCase(
        family,
        "full circle with a force out of its plane, arc length",
        arm(SLENDER, **loads, solver=ARC_LENGTH),
        "the same path through both limit points",
        drifts="full",
        not_asked=FOLLOWED,
    )
    yield HardCase(
        family,
        "four turns beyond the largest moment of the section",
        rolled(4 * FULL_CIRCLE, 40.0, YOUNG, elements=48, solver={**ARC_LENGTH, "max_steps": 150}),
        "Saint Venant-Kirchhoff carries 0.41 E I/R (theory.md 2): the load factor turns back for good",
        TYPED,
        said="limit point",
    )


# --- exact answers: relative errors of load factors --------------------------------------------------------


def from_factor(exact: Callable[[Solution], float]) -> Deviation:
    """Relative error of the buckling factor."""

    def error(solution: Solution) -> float:
        assert solution.stability is not None
        found = solution.stability.buckling_factor
        return math.nan if found is None else abs(found / exact(solution) - 1.0)

    return error


def no_critical_load(solution: Solution) -> float:
    """0 if no critical load was found, as it must be."""
    assert solution.stability is not None
    return 0.0 if solution.stability.buckling_factor is None else 1.0


def from_limit_loads(arch: Arch, count: int, load: float) -> Deviation:
    """Largest relative error of the first limit loads; `load` [N] is that of the scene."""

    def error(solution: Solution) -> float:
        assert solution.stability is not None
        exact = [p.load / load for p in critical_points(arch) if p.kind in ("load maximum", "load minimum")]
        found = [c.load_factor for c in solution.stability.critical_points if c.kind == "limit"]
        if len(found) < count or len(exact) < count:
            return math.nan
        return max(abs(f / e - 1.0) for f, e in zip(found[:count], exact[:count], strict=True))

    return error
