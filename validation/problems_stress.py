"""Axial stress of the section at mid-length: beam against section problem and 3-D solid.

sigma = n . Cauchy stress . n, n the normal of the turned section: what a gauge along a fibre would feel.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from reference.rod_inputs import law_of, section_of
from reference.section import bend
from reference.section_answer import CELLS
from validation.cases import Case
from validation.exact import answer
from validation.outcome import Outcome, Row
from validation.problems_cross import loaded
from validation.scenes import solve

if TYPE_CHECKING:
    from ancf.solution import Solution

Floats = NDArray[np.float64]

SOURCES = ("section", "solid")


@dataclass(frozen=True)
class MiddleStress:
    """Axial stress of the references at points of the middle section of a rod in pure bending.

    Parameters
    ----------
    scene : one rod under a moment about z, in SI
    points : (n, 2) [m]
    solid : (n,) [Pa], of the solid's finest mesh; empty where it has no answer
    reason : why not
    """

    scene: Mapping[str, Any]
    points: Floats
    solid: Floats
    reason: str

    @cached_property
    def section(self) -> Floats:
        """Axial stress (n,) [Pa] by the section problem."""
        return self._section(CELLS[1])

    @property
    def largest(self) -> float:
        """Largest axial stress of the section problem [Pa]."""
        return float(np.max(np.abs(self.section)))

    @cached_property
    def errors(self) -> dict[str, float]:
        """Own error of each source [largest]: of two meshes; of the solid, its distance from the first."""
        coarse = _distance(self._section(CELLS[0]), self.section)
        solid = _distance(self.solid, self.section) + coarse if self.solid.size else np.inf
        return {"section": coarse / self.largest, "solid": solid / self.largest}

    def _section(self, cells: int) -> Floats:
        rod = self.scene["rod"][0]
        state = bend(
            section_of(rod["section"], cells),
            law_of(rod["material"]),
            moment=self.scene["moment"][0]["value"][2],
        )
        return state.stress(self.points).cauchy[:, 0, 0]


def middle_stress(scene: Mapping[str, Any]) -> MiddleStress:
    """References for the middle section of a scene's rod."""
    solid = answer("solid", scene)
    if solid.reason:
        radius = float(scene["rod"][0]["section"]["radius"])
        return MiddleStress(scene, radius * np.array([[1.0, 0.0], [-1.0, 0.0]]), np.empty(0), solid.reason)
    stored = solid.values["stress"]
    return MiddleStress(scene, np.array(stored["points"]), np.array(stored["axial"]), "")


def beam_stress(solution: Solution, points: Floats) -> Floats:
    """Axial stress (n,) [Pa] of the beam's middle section at points (n, 2) [m]."""
    return solution.section_stress(None, 0.5, points[:, 0], points[:, 1])[:, 0, 0]


def section_stress(case: Case) -> Outcome:
    """Largest difference of the axial stress, by its largest value, for each angle and each reference."""
    observed, errors, rows, notes = {}, {}, [], []
    solution = scene = None
    for size in case.parameters["sizes"]:
        scene = loaded(case.scene, "bending", size)
        exact = middle_stress(scene)
        solution = solve(scene)
        found = beam_stress(solution, exact.points)
        for source in SOURCES:
            label = f"axial stress, {size:g}, {source}"
            wanted = getattr(exact, source)
            observed[label] = _distance(found, wanted) / exact.largest if wanted.size else np.nan
            errors[label] = exact.errors[source]
        modulus = law_of(case.rod["material"]).young_modulus
        for name, i in [("tension", np.argmax(exact.section)), ("compression", np.argmin(exact.section))]:
            here, wanted = float(found[i]) / modulus, float(exact.section[i]) / modulus
            rows.append(Row(f"{size:g}: largest {name}/E", here, wanted, "-"))
        if exact.reason:
            notes.append(f"{size:g}: {exact.reason}")
    return Outcome(observed, rows, solution, scene, errors, notes)


def _distance(a: Floats, b: Floats) -> float:
    return float(np.max(np.abs(a - b)))
