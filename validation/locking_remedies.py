"""What removes locking: axial rules and assumed strains on every element, by slenderness.

Each remedy is an `Element` descriptor. It is judged by its zero modes (a rule with fewer points leaves more
than rigid motions) and by its tip error at slenderness L/R under a tip force P L^2/EI = 10 and an oblique tip
moment |M| L/EI = 2.5, against the integrated rod with shear and stretch, and against the thin helix.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf.elements import ELEMENTS, GAUSS_2, R_X, R_Y, R_Z, Element, R
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.scene import Force, Moment, Rod, Scene, SolverOptions
from ancf.sections import Circle
from reference.helix import helix_tip_moment
from reference.rod import RodLoads, RodProperties, solve_rod
from validation.criteria import largest

Floats = NDArray[np.float64]

YOUNG, NU = 1.0e9, 0.3
FORCE = 10.0  # P L^2/EI
MOMENT = 2.5 * np.array([0.6, 0.5, -0.8]) / np.linalg.norm([0.6, 0.5, -0.8])  # M L/EI
FORCE_CASES = ((200, 12), (500, 12), (2000, 12), (500, 24))  # L/R, elements
MOMENT_CASES = ((200, 12), (500, 12), (500, 24))
BOUNDS = {12: 5e-4, 24: 1e-4}  # of the length: what the best element has to meet
BEST = ("3343", "cable")
ZERO = 1e-13  # of the largest eigenvalue per unknown: below it a mode is free
NODES, GAUSS = (-1.0, 0.0, 1.0), (-GAUSS_2, GAUSS_2)
CABLE = ("cable", 5)  # its name and rigid motions: when straight, spin about its axis moves no cable


@dataclass(frozen=True)
class Remedy:
    """One element with one rule: modes besides rigid motions, tip errors over L (None: not solved)."""

    element: str
    rule: str
    default: bool  # whether it is what the element does by itself
    spurious: int
    force: list[float | None]  # of FORCE_CASES
    moment: list[float | None]  # of MOMENT_CASES; none of a cable

    @property
    def best(self) -> bool:
        """Whether it is what an element of `BEST` does by itself."""
        return self.default and self.element in BEST

    @property
    def excess(self) -> float:
        """Largest error at L/R = 500 and beyond over its bound; infinite with spurious modes."""
        cases = [*zip(FORCE_CASES, self.force, strict=True), *zip(MOMENT_CASES, self.moment, strict=False)]
        errors = [error / BOUNDS[n] for (ratio, n), error in cases if ratio >= 500 and error is not None]
        solved = all(error is not None for error in self.force)
        return largest(*errors) if solved and self.spurious == 0 else math.inf


def trials() -> list[tuple[Element, str, bool]]:
    """Descriptors, what they do, and whether it is the default of the element of that name."""
    quadratic, hermite, sheared = (ELEMENTS[name] for name in ("3333", "3243", "3343"))
    slopes = replace(quadratic, name="3 nodes with r_x", vectors=(R, R_X, R_Y, R_Z))
    cable = replace(ELEMENTS["cable"], assumed=())
    at_nodes = "section at nodes"
    return [
        (hermite, "3 points", True),
        (_rule(hermite, 2), "2 points", False),
        (_rule(hermite, 3, section=(-1.0, 1.0)), f"3 points, {at_nodes}", False),
        (_rule(hermite, 3, section=(-1.0, 1.0), curvature=(0.0,)), f"{at_nodes}, curvature at 1", False),
        (_rule(quadratic, 5), "5 points (full)", False),
        (quadratic, "2 points", True),
        (_rule(quadratic, 2, section=NODES), f"2 points, {at_nodes}", False),
        (_rule(sheared, 5), "5 points (full)", False),
        (_rule(sheared, 2), "2 points", False),
        (sheared, f"2 points, {at_nodes}", True),
        (_rule(slopes, 2), "2 points", False),
        (_rule(slopes, 3), "3 points", False),
        (_rule(slopes, 5), "5 points", False),
        (_rule(slopes, 5, section=NODES, curvature=GAUSS), f"5, {at_nodes}, curvature at 2", False),
        (ELEMENTS["3363"], "2 points", True),
        (_rule(cable, 2), "2 points", False),
        (_rule(cable, 5), "5 points (full)", False),
        (_rule(cable, 3, axial=NODES), "3 points, stretch at nodes and middle", False),
        (ELEMENTS["cable"], "the same, curvature at 2", True),
    ]


def _rule(element: Element, points: int, **assumed: tuple[float, ...]) -> Element:
    return replace(element, axial_points=points, locks_from=99, assumed=tuple(assumed.items()))


def remedies() -> list[Remedy]:
    """Measure every trial."""
    return [_measured(*trial) for trial in trials()]


def _measured(element: Element, rule: str, default: bool) -> Remedy:
    with _known(element) as name:
        spurious = _zero_modes(name) - (CABLE[1] if element.name == CABLE[0] else 6)
        if spurious > 0:
            return Remedy(element.name, rule, default, spurious, [None] * len(FORCE_CASES), [])
        force = [_error(name, ratio, n, moment=False) for ratio, n in FORCE_CASES]
        turned = MOMENT_CASES if element.has_section else ()
        return Remedy(
            element.name, rule, default, spurious, force,
            [_error(name, ratio, n, moment=True) for ratio, n in turned],
        )  # fmt: skip


@contextmanager
def _known(element: Element) -> Iterator[str]:
    """Make scenes know a trial element for a while, under a name that no file can ask for meanwhile."""
    name = f"{element.name}, on trial"
    ELEMENTS[name] = replace(element, name=name)
    try:
        yield name
    finally:
        del ELEMENTS[name]


def _rod(name: str, ratio: float, elements: int) -> Rod:
    section = Circle(1.0 / ratio)
    return Rod("rod", 1.0, elements, section, SaintVenantKirchhoff(YOUNG, NU), name)


def _zero_modes(name: str) -> int:
    """Zero modes of the unsupported, unstressed tangent of two elements, scaled to a unit diagonal."""
    rod = Model(Scene((_rod(name, 40.0, 2),))).rods[0]
    K = np.zeros((rod.size, rod.size))
    for dofs, K_e in zip(rod.dofs, rod.elastic.force_and_tangent(rod.e0)[1], strict=True):
        K[np.ix_(dofs, dofs)] += K_e
    scale = 1.0 / np.sqrt(np.maximum(np.diag(K), 1e-14 * np.max(np.diag(K))))
    values = np.abs(np.linalg.eigvalsh(K * scale * scale[:, None]))
    return int(np.count_nonzero(values < ZERO * rod.size * values.max()))


def _error(name: str, ratio: float, elements: int, moment: bool) -> float | None:
    """Distance of the tip from the thin rod's, over L; None without an equilibrium."""
    rod = _rod(name, ratio, elements)
    EI = YOUNG * rod.section.weaker_second_moment
    scene = Scene((rod,), solver=SolverOptions(max_steps=20))
    if moment:
        scene = replace(scene, moments=(Moment("rod", 1.0, EI * MOMENT),))
        exact: Sequence[float] = helix_tip_moment(EI * MOMENT, 1.0, EI, EI / (1.0 + NU), [1.0]).position[0]
    else:
        scene = replace(scene, forces=(Force("rod", 1.0, np.array([0.0, FORCE * EI, 0.0])),))
        exact = _forced(ratio)
    found = ancf.solve(scene)
    if found.status is not ancf.Status.CONVERGED:
        return None
    return float(np.linalg.norm(found.tip().position - exact))


@lru_cache(maxsize=8)
def _forced(ratio: float) -> tuple[float, ...]:
    """Tip of the integrated rod under the force."""
    section = Circle(1.0 / ratio)
    second = section.weaker_second_moment
    rod = RodProperties.from_section(1.0, YOUNG, NU, section.area, second, second)
    loads = RodLoads(tip_force=np.array([0.0, FORCE * YOUNG * second, 0.0]))
    return tuple(solve_rod(rod, loads).position[0])
