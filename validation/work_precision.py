"""Error against time: pure bending to 90 degrees with 3243, 3333 and a 3-D solid on the same axes.

The reference is the solid on a mesh far finer than the one timed here. Beams therefore end on a floor, their
model error, which no mesh removes; the solid ends on its own discretisation.
"""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

import ancf
from validation.criteria import Limit

LENGTH, RADIUS, YOUNG, POISSON = 0.4, 0.01, 1.0e6, 0.3
MOMENT = YOUNG * np.pi * RADIUS**4 / 4.0 * (np.pi / 2) / LENGTH

# Mean of the end face by reference.solid.solid_pure_bending(0.4, 0.01, 1e6, 0.3, MOMENT, core=4,
# rings=2, slices=60):
# 75 655 unknowns, 80 s. Error: axis 4e-6 by its h^4 law, section below 1e-5 from core 2, 3, 4.
FINE_SOLID_TIP = np.array([0.253941107, 0.254864415, 0.0])
FINE_SOLID_ERROR = 1e-5  # of L
FLOOR = Limit(
    "error of 3333, finest mesh", 1.2e-3, "L",
    "section behaviour of second order, 6e-4 to 9e-4 L at L/R = 40 and 90 degrees, is outside a "
    "linear section",
)  # fmt: skip


@dataclass(frozen=True)
class WorkPoint:
    """One mesh: error of the tip over L and seconds of a warm solve (smallest and median of the repeats)."""

    model: str
    mesh: str
    unknowns: int
    error: float
    fastest: float
    median: float
    repeats: int
    iterations: int


def beam_points(repeats: int = 5, full: bool = False) -> list[WorkPoint]:
    """Both beam elements over their meshes, set-up included."""
    meshes = (1, 2, 4, 8, 16, 32, *((64,) if full else ()))
    points = []
    for element in ("3243", "3333"):
        for elements in meshes:
            rod = {
                "length": LENGTH, "elements": elements, "element": element,
                "section": {"shape": "circle", "radius": RADIUS},
                "material": {"young_modulus": YOUNG, "poisson_ratio": POISSON},
            }  # fmt: skip
            scene = ancf.scene_from_dict({"rod": [rod], "moment": [{"value": [0.0, 0.0, MOMENT]}]})
            seconds, solution = [], ancf.solve(scene)  # the first solve is the warm-up
            for _ in range(repeats):
                started = time.perf_counter()
                solution = ancf.solve(scene)
                seconds.append(time.perf_counter() - started)
            error = float(np.linalg.norm(solution.tip().position - FINE_SOLID_TIP)) / LENGTH
            points.append(
                WorkPoint(
                    element, f"{elements} element{'s' if elements > 1 else ''}", solution.unknowns, error,
                    min(seconds), float(np.median(seconds)),
                    repeats, solution.iterations,
                )
            )  # fmt: skip
    return points


def solid_points(repeats: int = 2, full: bool = False) -> list[WorkPoint]:
    """The solid: hex27, two core quads a side, one ring, 20 slices; `full` adds a finer one."""
    from reference.solid import solid_pure_bending

    points = []
    for core, slices in ((2, 20), (3, 40)) if full else ((2, 20),):
        results = [
            solid_pure_bending(LENGTH, RADIUS, YOUNG, POISSON, MOMENT, core=core, rings=1, slices=slices)
            for _ in range(repeats)
        ]
        if not results[-1].converged:
            continue
        error = float(np.linalg.norm(results[-1].tip_position - FINE_SOLID_TIP)) / LENGTH
        seconds = [r.seconds for r in results]
        points.append(
            WorkPoint(
                "solid hex27", f"n = {core}, {slices} slices", results[-1].unknowns, error, min(seconds),
                float(np.median(seconds)), repeats, results[-1].iterations,
            )
        )  # fmt: skip
    return points
