"""How cost grows: ratio of the two tangents, and time and memory against the number of elements."""

from __future__ import annotations

import gc
import time
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf.finite_difference import RELATIVE_STEP
from ancf.model import Model
from ancf.scene import Scene
from validation.scenes import in_si

Floats = NDArray[np.float64]

RATIO_ELEMENTS = 12
COUNTS, COUNTS_FULL = (100, 1000), (100, 300, 1000, 3000, 10000)
QUICKEST = 5  # repeats of a short measurement; the fastest counts


@dataclass(frozen=True)
class TangentRatio:
    """CPU seconds with the analytic and with the finite-difference tangent, in one run.

    `assembly`: one residual and tangent of the model at the solution; `solve`: the whole of `ancf.solve`. The
    paper differentiates by one coordinate of the model after the other (eq. 38-41), `assembly_paper`; ours by
    all elements at once (finite_difference.py), `assembly_difference`.
    """

    element: str
    elements: int
    assembly: float
    assembly_difference: float
    assembly_paper: float
    solve: float
    solve_difference: float

    @property
    def assembly_ratio(self) -> float:
        """How many times faster the analytic tangent is than differences of all elements at once."""
        return self.assembly_difference / self.assembly

    @property
    def paper_ratio(self) -> float:
        """How many times faster it is than the paper's differences."""
        return self.assembly_paper / self.assembly

    @property
    def solve_ratio(self) -> float:
        """How many times faster the scene is solved."""
        return self.solve_difference / self.solve


@dataclass(frozen=True)
class ScalePoint:
    """One mesh: CPU seconds of a solve, peak memory [byte] that it allocated, iterations, status."""

    element: str
    elements: int
    unknowns: int
    seconds: float
    memory: int
    iterations: int
    status: str


def tangent_ratios(elements: int = RATIO_ELEMENTS) -> list[TangentRatio]:
    """Both tangents for the default and the paper's element: tip force P L^2/EI = 1, L/R = 40."""
    return [_ratio(element, elements) for element in ("3333", "3243")]


def scale(counts: tuple[int, ...], element: str = "3243") -> list[ScalePoint]:
    """The same force on ever finer meshes; the counts in ascending order."""
    fastest(lambda: ancf.solve(_scene(element, counts[0])), 2)
    return [_scale_point(element, count) for count in counts]


def fastest(run: Callable[[], Any], repeats: int = QUICKEST) -> float:
    """CPU seconds of the fastest of some runs."""
    found = []
    for _ in range(repeats):
        started = time.process_time()
        run()
        found.append(time.process_time() - started)
    return min(found)


def _scene(element: str, elements: int, tangent: str = "analytic") -> Scene:
    rod = {
        "length": 0.4, "elements": elements, "element": element,
        "section": {"shape": "circle", "radius": 0.01},
        "material": {"young_modulus": 1.0e6, "poisson_ratio": 0.3},
    }  # fmt: skip
    load = {"force": [{"value": [0.0, 1.0, 0.0]}]}
    return ancf.scene_from_dict(in_si({"rod": [rod], **load}) | {"solver": {"tangent": tangent}})


def _ratio(element: str, elements: int) -> TangentRatio:
    scene, difference = (_scene(element, elements, t) for t in ("analytic", "finite-difference"))
    q = ancf.solve(scene).q
    times = []
    for one in (scene, difference):
        model = Model(one)
        model.residual_and_tangent(q, 1.0)
        times.append(fastest(lambda model=model: model.residual_and_tangent(q, 1.0), 20))
    model = Model(scene)
    times.append(fastest(lambda: by_coordinates(model, q), 2))
    solves = [fastest(lambda one=one: ancf.solve(one)) for one in (scene, difference)]
    return TangentRatio(element, elements, *times, *solves)


def by_coordinates(model: Model, q: Floats) -> Floats:
    """The paper's tangent (n, n) at load factor 1: central differences by one coordinate after the other."""
    K = np.empty((model.n, model.n))
    for column in range(model.n):
        step = RELATIVE_STEP * model.unit[column]
        sides = []
        for sign in (1.0, -1.0):
            moved = q.copy()
            moved[column] += sign * step
            sides.append((model.residual(moved).at(1.0), moved[column]))
        (g_ahead, ahead), (g_behind, behind) = sides
        K[:, column] = (g_ahead - g_behind) / (ahead - behind)
    return K


def _scale_point(element: str, elements: int) -> ScalePoint:
    scene = _scene(element, elements)
    seconds = fastest(lambda: ancf.solve(scene), 3 if elements <= 1000 else 1)
    gc.collect()
    tracemalloc.start()
    solution = ancf.solve(scene)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return ScalePoint(
        element, elements, solution.unknowns, seconds, peak, solution.iterations, str(solution.status)
    )
