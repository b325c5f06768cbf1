"""Scenes of the hard cases: one soft arm, its loads in units of its stiffness, and exact answers for its tip.

Symbols
-------
L, R, EI   length [m], radius [m], bending stiffness [N m2] of the arm
kappa      curvature [1/m]; a tip moment EI angle/L bends a thin rod to an arc of that angle [rad]
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import ellipe, ellipk

from ancf.mesh import reference_axis
from ancf.solution import Solution
from reference.helix import helix_tip_moment
from reference.rod import solve_rod
from reference.root import bracketed_root
from validation.scenes import reference_rod

Floats = NDArray[np.float64]
Scene = dict[str, Any]
Deviation = Callable[[Solution], float]

LENGTH, YOUNG, DENSITY = 0.4, 1.0e6, 1070.0  # m, Pa, kg/m3: the silicone arm of README.md
FULL_CIRCLE, QUARTER = 2.0 * math.pi, 0.5 * math.pi
TABLES = ("moment", "force", "line_load", "gravity", "pressure", "solver", "stability")
DOWN, UP = [0.0, 0.0, -1.0], [0.0, 0.0, 1.0]
FREE_SECTION = [{"at": 0.0, "kind": "free_section_clamp"}]
BOTH_ENDS = [{"at": 0.0, "kind": "clamp"}, {"at": 1.0, "kind": "clamp"}]


def arm(slenderness: float = 40.0, young: float = YOUNG, nu: float = 0.3, **changes: Any) -> Scene:
    """The arm with L/R = `slenderness`, clamped at 0; `changes` go to the rod, or are load tables."""
    tables = {key: changes.pop(key) for key in TABLES if key in changes}
    rod = {
        "length": LENGTH,
        "elements": 12,
        "element": "3333",
        "section": {"shape": "circle", "radius": LENGTH / slenderness},
        "material": {"young_modulus": young, "poisson_ratio": nu, "density": DENSITY},
        **changes,
    }
    return {"rod": [rod], **tables}


def bending_stiffness(slenderness: float = 40.0, young: float = YOUNG) -> float:
    """E I [N m2] of the arm."""
    return young * math.pi * (LENGTH / slenderness) ** 4 / 4.0


def axial_stiffness(slenderness: float = 40.0, young: float = YOUNG) -> float:
    """E A [N] of the arm."""
    return young * math.pi * (LENGTH / slenderness) ** 2


def moment(value: ArrayLike, slenderness: float = 40.0, young: float = YOUNG, **more: Any) -> Scene:
    """A moment given in E I/L, at the tip unless `at` says otherwise."""
    unit = bending_stiffness(slenderness, young) / LENGTH
    return {"value": (np.asarray(value, float) * unit).tolist(), **more}


def force(value: ArrayLike, slenderness: float = 40.0, young: float = YOUNG, **more: Any) -> Scene:
    """A force given in E I/L^2."""
    unit = bending_stiffness(slenderness, young) / LENGTH**2
    return {"value": (np.asarray(value, float) * unit).tolist(), **more}


def rolled(angle: float, slenderness: float = 40.0, young: float = YOUNG, **changes: Any) -> Scene:
    """The arm under the tip moment that rolls a thin rod by `angle` [rad] about z."""
    return arm(slenderness, young, moment=[moment([0, 0, angle], slenderness, young)], **changes)


def gravity(number: float, direction: ArrayLike, slenderness: float = 40.0) -> Scene:
    """Acceleration for a gravity number rho g A L^3/(E I), in a direction of unit length."""
    A = math.pi * (LENGTH / slenderness) ** 2
    size = number * bending_stiffness(slenderness) / (DENSITY * A * LENGTH**3)
    return {"acceleration": (size * np.asarray(direction, float)).tolist()}


def standing(axis: list[float]) -> Scene:
    """Base of an arm along `axis`, which is not y."""
    return {"position": [0.0, 0.0, 0.0], "x_axis": axis, "y_axis": [0.0, 1.0, 0.0]}


# --- exact answers: distance of the tip, over L -----------------------------------------------------------


def tip_distance(solution: Solution, exact: ArrayLike) -> float:
    """Distance of the tip of the first rod from an exact place given relative to its base [m], over L."""
    rod = solution.scene.rods[0]
    found = solution.model.rods[0].nodal(solution.q)[-1, 0]
    return float(np.linalg.norm(found - np.asarray(exact, float))) / rod.length


def from_arc(angle: float) -> Deviation:
    """From the tip of the inextensible arc that turns by `angle` about z; Euler, sinc forms at 0."""
    along, across = np.sinc(angle / np.pi), math.sin(angle / 2) * np.sinc(angle / (2 * np.pi))
    return lambda solution: tip_distance(solution, LENGTH * np.array([along, across, 0.0]))


def from_helix(direction: str = "fixed") -> Deviation:
    """From the helix of the thin round rod under the tip moment of the scene (theory.md 1)."""

    def deviation(solution: Solution) -> float:
        properties, loads = reference_rod(solution.scene)
        value = loads.tip_moment if direction == "fixed" else loads.follower_tip_moment
        exact = helix_tip_moment(
            value, LENGTH, properties.EI_z, properties.GJ, LENGTH, direction=direction
        ).position
        return tip_distance(solution, np.reshape(exact, 3))

    return deviation


def from_rod(solution: Solution) -> float:
    """From the Simo-Reissner rod under the same loads, integrated by collocation in reference/."""
    properties, loads = reference_rod(solution.scene)
    exact = solve_rod(properties, loads).position[-1]
    return tip_distance(solution, exact - solution.scene.rods[0].base.position)


def from_reference(solution: Solution) -> float:
    """From the reference shape: the loads cancel or vanish."""
    rod = solution.scene.rods[0]
    position, _ = reference_axis(np.array([rod.length]), rod.curvature)
    return tip_distance(solution, rod.base.rotation @ position[0])


def from_stretch(stretch: float) -> Deviation:
    """From the tip of a straight rod stretched evenly; its lateral contraction does not matter."""

    def deviation(solution: Solution) -> float:
        rod = solution.scene.rods[0]
        return tip_distance(solution, stretch * rod.length * rod.base.rotation[:, 0])

    return deviation


def from_own_weight(solution: Solution) -> float:
    """From the straight rod under its own weight: l^3 - l = 2 q (L - x)/(E A) at every section, q [N/m].

    Dead axial force q (L - x), uniaxial Saint Venant-Kirchhoff F = E A (l^3 - l)/2 at every section; the
    extension int (l - 1) dx by Gauss quadrature, exact to rounding for this analytic integrand.
    """
    rod, weight = solution.scene.rods[0], solution.scene.gravity
    assert weight is not None and rod.material.density is not None
    along = float(weight.acceleration @ rod.base.rotation[:, 0])
    pull = 2.0 * rod.material.density * along * rod.length / rod.material.young_modulus
    t, w = np.polynomial.legendre.leggauss(40)
    stretch = [largest_root(pull * (1.0 - 0.5 * (1.0 + x))) for x in t]
    exact = 0.5 * rod.length * float(w @ stretch)
    return tip_distance(solution, exact * rod.base.rotation[:, 0])


def from_buckled(ratio: float) -> Deviation:
    """From the buckled elastica, clamped-free, at `ratio` Euler loads; it bends in the x-y plane, to +y.

    P/P_cr = (2 K/pi)^2 with K, E complete elliptic integrals of p = sin(tip angle/2); tip x/L = 2 E/K - 1,
    y/L = 2 p/K. Timoshenko and Gere, Theory of Elastic Stability, art. 2.7.
    """

    def deviation(solution: Solution) -> float:
        m = bracketed_root(lambda m: (2.0 * float(ellipk(m)) / math.pi) ** 2 - ratio, 0.0, 1.0 - 1e-12)
        x, y = 2.0 * float(ellipe(m) / ellipk(m)) - 1.0, 2.0 * math.sqrt(m) / float(ellipk(m))
        return tip_distance(solution, LENGTH * np.array([x, y, 0.0]))

    return deviation


def largest_root(load: float) -> float:
    """Largest root l of l^3 - l = load: the stable uniaxial stretch of Saint Venant-Kirchhoff."""
    roots = np.roots([1.0, 0.0, -1.0, -load])
    return float(np.max(roots[np.abs(roots.imag) < 1e-9].real))


def stable_stretch(force_over_EA: float) -> float:
    """Stretch under a dead axial force: the largest root of l^3 - l = 2 F/(E A)."""
    return largest_root(2.0 * force_over_EA)
