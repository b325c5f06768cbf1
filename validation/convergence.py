"""Observed order of convergence: the promise is data, the slope fitted, the finest error bounded.

Five problems (bending, tip force, torsion, stretch, curved reference) for each element. Where the beam
model has a
closed form the error is taken against it; elsewhere against 256 elements of the same kind, which shows the
order
of the discretisation and nothing about the model.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from reference import analytic
from validation.criteria import Finding, Limit, Verdict, judge, worst
from validation.scenes import solve

Floats = NDArray[np.float64]

LENGTH, RADIUS, YOUNG = 0.4, 0.01, 1.0e6  # m, m, Pa: the arm of the other cases
EI = YOUNG * np.pi * RADIUS**4 / 4.0
EA = YOUNG * np.pi * RADIUS**2
FINE = 256  # elements of the self-reference
SHORTFALL = 0.3  # of the order: what a fit over finite meshes may miss


@dataclass(frozen=True)
class Study:
    """One problem on one element, with its promised order and the bound of the finest error."""

    name: str
    element: str
    error: Callable[[str, int], float]
    promised: float
    why: str
    reference: str
    meshes: tuple[int, ...]
    finest: float


@dataclass(frozen=True)
class StudyResult:
    """Errors of a study, the fitted slope, and its two checks."""

    study: Study
    errors: list[float]
    slope: float
    findings: list[Finding] = field(default_factory=list)
    seconds: float = 0.0

    @property
    def verdict(self) -> Verdict:
        """Worst of the checks."""
        return worst(finding.verdict for finding in self.findings)

    @property
    def steps(self) -> list[float]:
        """Order between neighbouring meshes."""
        n, e = np.array(self.study.meshes, float), np.array(self.errors)
        return (np.diff(np.log(e)) / -np.diff(np.log(n))).tolist()


def _scene(element: str, elements: int, nu: float, **loads: object) -> dict:
    """The arm with a section free to contract, so that the exact state has no boundary layer at the clamp."""
    rod = {
        "length": LENGTH, "elements": elements, "element": element,
        "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": nu},
        "supports": [{"at": 0.0, "kind": "free_section_clamp"}],
    }  # fmt: skip
    curvature = loads.pop("curvature", None)
    if curvature is not None:
        rod["curvature"] = curvature
    return {"rod": [rod], **loads}


def _tip(element: str, elements: int, nu: float, **loads: object) -> Floats:
    return solve(_scene(element, elements, nu, **loads)).tip().position


def bending(element: str, elements: int) -> float:
    """Tip error/L at 90 degrees, nu = 0, against the finite-strain closed form."""
    moment = EI * (np.pi / 2) / LENGTH
    along, across, _ = analytic.pure_bending_curvature(
        moment, YOUNG, analytic.BendingSection.circle(RADIUS)
    ).tip(LENGTH)
    tip = _tip(element, elements, 0.0, moment=[{"value": [0.0, 0.0, moment]}])
    return float(np.linalg.norm(tip - [along, across, 0.0])) / LENGTH


@lru_cache(maxsize=64)
def _force_tip(element: str, elements: int) -> Floats:
    return _tip(element, elements, 0.0, force=[{"value": [0.0, 5.0 * EI / LENGTH**2, 0.0]}])


def tip_force(element: str, elements: int) -> float:
    """Tip error/L at P L^2/EI = 5, against the fine mesh."""
    return float(np.linalg.norm(_force_tip(element, elements) - _force_tip(element, FINE))) / LENGTH


@lru_cache(maxsize=64)
def _torsion_tip(element: str, elements: int) -> Floats:
    moment = EI / 1.3 * (np.pi / 2) / LENGTH  # G J = E I/(1 + nu) of a circle
    return solve(_scene(element, elements, 0.3, moment=[{"value": [moment, 0.0, 0.0]}])).tip().rotation


def torsion(element: str, elements: int) -> float:
    """Error of the tip rotation at 90 degrees of twist, against the fine mesh [rad]."""
    return float(np.linalg.norm(_torsion_tip(element, elements) - _torsion_tip(element, FINE))) / np.sqrt(2.0)


def stretch(element: str, elements: int) -> float:
    """Tip error/L of a rod stretched by an axial line load of 0.3 E A in all, nu = 0, against quadrature.

    u = int (lambda(x) - 1) dx with lambda^3 - lambda = 2 q (L - x)/(E A).
    """
    load = 0.3 * EA / LENGTH
    x, weight = np.polynomial.legendre.leggauss(40)
    x, weight = 0.5 * LENGTH * (1 + x), 0.5 * LENGTH * weight
    area = EA / YOUNG
    stretches = [
        analytic.uniaxial_saint_venant_kirchhoff(load * (LENGTH - s), YOUNG, 0.0, area).axial for s in x
    ]
    tip = _tip(element, elements, 0.0, line_load=[{"value": [load, 0.0, 0.0]}])
    return abs(float(tip[0] - weight @ np.array(stretches))) / LENGTH


@lru_cache(maxsize=64)
def _curved_tip(element: str, elements: int) -> Floats:
    force = [{"value": [0.0, 0.0, 2.0 * EI / LENGTH**2]}]
    return _tip(element, elements, 0.3, force=force, curvature=[0.0, 0.0, np.pi / 2 / LENGTH])


def curved(element: str, elements: int) -> float:
    """Tip error/L of a quarter-circle arm loaded out of its plane, P L^2/EI = 2, against the fine mesh."""
    return float(np.linalg.norm(_curved_tip(element, elements) - _curved_tip(element, FINE))) / LENGTH


_3333 = "quadratic axis and sections, two Gauss points: fourth order at the nodes"
_3243 = "linear section vectors: second order; faster before, while locking (fourth order) still dominates"
_CUBIC = "cubic axis: fourth order, more at the end node"
_3343 = "as 3333, with the strains of its sections from the nodes"
_CABLE = "cubic axis, stretch at nodes and middle, curvature at two Gauss points"
_OWN = f"{FINE} elements of the same kind"


def studies(full: bool = False) -> list[Study]:
    """All studies; `full` adds one finer mesh."""
    more = (64,) if full else ()
    short, usual = (2, 4, 8, 16, 32, *more), (4, 8, 16, 32, *more)
    bent, line = "finite-strain closed form", "closed form, integrated along the rod"
    return [
        Study("bending", "3333", bending, 4, _3333, bent, short, 1e-7),
        Study("bending", "3243", bending, 2, _3243, bent, usual, 5e-4),
        Study("tip force", "3333", tip_force, 4, _3333, _OWN, usual, 2e-6),
        Study("tip force", "3243", tip_force, 2, _3243, _OWN, usual, 1e-3),
        Study("torsion", "3333", torsion, 4, _3333, _OWN, short, 5e-7),
        Study("torsion", "3243", torsion, 2, _3243, _OWN, usual, 3e-3),
        Study("bending", "3343", bending, 4, _3343, bent, short, 2e-7),
        Study("tip force", "3343", tip_force, 4, _3343, _OWN, usual, 1e-6),
        Study("torsion", "3343", torsion, 4, _3343, _OWN, short, 5e-7),
        Study("curved reference", "3343", curved, 4, _3343, _OWN, usual, 1e-6),
        Study("tip force", "cable", tip_force, 4, _CABLE, _OWN, usual, 1e-6),
        Study("stretch", "cable", stretch, 4, _CABLE, line, (2, 4, 8, 16), 2e-8),
        Study("stretch", "3333", stretch, 4, _3333, line, (2, 4, 8, 16), 1e-8),
        Study("stretch", "3243", stretch, 4, _CUBIC, line, (1, 2, 4, 8), 1e-9),
        Study("curved reference", "3333", curved, 4, _3333, _OWN, usual, 1e-6),
        Study("curved reference", "3243", curved, 2, _3243, _OWN, usual, 1e-3),
    ]  # fmt: skip


def run_study(study: Study) -> StudyResult:
    """Errors on all meshes; checks that the fitted order keeps its promise and the finest error its bound."""
    started = time.perf_counter()
    errors = [study.error(study.element, n) for n in study.meshes]
    slope = -float(np.polyfit(np.log(study.meshes), np.log(errors), 1)[0])
    order = Limit("order below its promise", SHORTFALL, "-", f"promised {study.promised:g}: {study.why}")
    bound = Limit(
        f"error with {study.meshes[-1]} elements",
        study.finest,
        "L or rad",
        "keeps the constant, not just the order",
    )
    findings = [
        judge(order, order.quantity, max(study.promised - slope, 0.0)),
        judge(bound, bound.quantity, errors[-1]),
    ]
    return StudyResult(study, errors, slope, findings, time.perf_counter() - started)


def run(full: bool = False) -> Iterator[StudyResult]:
    """Run all studies, one result at a time."""
    for study in studies(full):
        yield run_study(study)
