"""One measurement: the tip that a model finds, and what it cost. Times are CPU seconds of warm solves.

A warm solve begins with a scene already read and validated and includes everything else: meshing, set-up,
start, Newton, checks. One thread runs, so CPU time is the wall time of a quiet machine.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, TypeVar

import numpy as np

import ancf
from ancf.errors import InputError
from ancf.solution import Solution

T = TypeVar("T")

ENOUGH = 0.3  # s of CPU time for the repeats of one point


@dataclass(frozen=True)
class CostPoint:
    """One model on one mesh.

    Parameters
    ----------
    model, kind : ``3333``, ``exudyn ANCFCable2D``, ...; kind is beam, solid, section, rod or peer
    formulation : of a beam, with the name of a variant; elsewhere what distinguishes the model
    elements : elements (slices, cells) along the rod; mesh says it in words
    status : ``converged``, or why there is no answer; then `error` is None
    position : tip (3,) by the length
    error : distance of the tip from the reference, by the length
    discretisation : distance from the limit of this model's own ladder of meshes; None where not known
    fastest, median : CPU seconds over the repeats
    parts : CPU seconds by phase: setup, kinematics (strains, stresses, tangents of the elements), assembly
        (into the band), effects (loads), linear_solve, rest (predictor, checks)
    """

    model: str
    kind: str
    formulation: str
    elements: int
    mesh: str
    tangent: str
    predictor: str
    status: str
    position: list[float] = field(default_factory=list)
    unknowns: int = 0
    iterations: int = 0
    steps: int = 0
    error: float | None = None
    discretisation: float | None = None
    fastest: float = 0.0
    median: float = 0.0
    repeats: int = 0
    parts: dict[str, float] = field(default_factory=dict)

    @property
    def converged(self) -> bool:
        """Whether there is an answer."""
        return self.status == "converged"

    @property
    def setting(self) -> tuple[str, str, str, str]:
        """What a ladder of meshes has in common."""
        return self.model, self.formulation, self.tangent, self.predictor

    @property
    def label(self) -> str:
        """The setting in words; default solver settings are not named."""
        parts = [self.model]
        if self.formulation not in ("", "enhanced"):
            parts.append(self.formulation)
        if self.tangent == "finite-difference":
            parts.append("difference tangent")
        if self.predictor == "none":
            parts.append("no predictor")
        return ", ".join(parts)


def reached(points: Iterable[CostPoint], target: float) -> list[CostPoint]:
    """Points within a target that every finer mesh of their setting keeps: a coarse mesh may be lucky."""
    every = list(points)

    def within(point: CostPoint) -> bool:
        return point.converged and point.error is not None and point.error <= target

    return [
        p
        for p in every
        if all(within(q) for q in every if q.setting == p.setting and q.elements >= p.elements)
    ]


def timed(run: Callable[[], T], repeats: int) -> tuple[list[T], list[float]]:
    """Results and CPU seconds of warm runs.

    The first run warms up and is not counted, unless it alone takes as long as all repeats may.
    """
    results, seconds = [], []
    for _ in range(repeats + 1):
        started = time.process_time()
        results.append(run())
        seconds.append(time.process_time() - started)
        if seconds[0] > ENOUGH:
            return results, seconds
        if sum(seconds) > ENOUGH:
            break
    return results[1:], seconds[1:]


def beam_point(data: Mapping[str, Any], repeats: int) -> tuple[CostPoint, Solution | None]:
    """Solve a scene dictionary with one rod; its error is not known yet.

    A scene that an element refuses has the refusal as its status, and no solution.
    """
    rod, solver = data["rod"][0], data.get("solver", {})
    about = {
        "model": rod["element"],
        "kind": "beam",
        "formulation": rod.get("formulation", "enhanced"),
        "elements": rod["elements"],
        "mesh": elements_text(rod["elements"]),
        "tangent": solver.get("tangent", "analytic"),
        "predictor": solver.get("predictor", "auto"),
    }
    try:
        scene = ancf.scene_from_dict(data)
        solutions, seconds = timed(lambda: ancf.solve(scene), repeats)
    except InputError as error:
        message = error.message
        return CostPoint(**about, status=f"refused: {message.what} {message.value}"), None
    # The machine may have looked away: the phases are those of the run that it disturbed least.
    solution = min(solutions, key=lambda s: s.seconds["total"])
    cost: dict[str, Any] = {
        "unknowns": solution.unknowns,
        "iterations": solution.iterations,
        "steps": solution.steps,
        "fastest": min(seconds),
        "median": float(np.median(seconds)),
        "repeats": len(seconds),
        "parts": parts_of(solution, min(seconds)),
    }
    if solution.status is not ancf.Status.CONVERGED:
        return CostPoint(**about, **cost, status=f"{solution.status}: {solution.reason}"), solution
    position = solution.tip().position / rod["length"]
    return CostPoint(**about, **cost, status="converged", position=position.tolist()), solution


def parts_of(solution: Solution, seconds: float) -> dict[str, float]:
    """The time of a solve by phase, in shares of `seconds`, as `CostPoint.parts`."""
    total = solution.seconds["total"]
    elastic = solution.effects.get("elastic", {}).get("seconds", 0.0)
    effects = solution.seconds["assembly"] - elastic
    share = _kernel_share(solution)
    parts = {
        "setup": solution.seconds["setup"],
        "kinematics": share * elastic,
        "assembly": (1.0 - share) * elastic,
        "effects": effects,
        "linear_solve": solution.seconds["linear_solve"],
    }
    parts["rest"] = max(total - sum(parts.values()), 0.0)
    scale = seconds / sum(parts.values())
    return {name: scale * value for name, value in parts.items()}


def _kernel_share(solution: Solution) -> float:
    """Share of the elements' own work in what the elastic effect takes; the rest is assembly.

    Measured on the state found, once: `Solution.effects` counts both together.
    """
    model, q = solution.model, solution.q
    before = model.counters.seconds["elastic"]
    model.residual_and_tangent(q, solution.load_factor)
    both = model.counters.seconds["elastic"] - before
    if model.scene.solver.tangent == "finite-difference":
        return 1.0  # some fifty evaluations to one assembly
    started = time.perf_counter()
    for rod in model.rods:
        rod.elastic.force_and_tangent(rod.element_vectors(q))
    return min((time.perf_counter() - started) / both, 1.0) if both > 0.0 else 1.0


def elements_text(count: int) -> str:
    """The mesh in words."""
    return f"{count} element{'s' * (count != 1)}"


def point_dict(point: CostPoint) -> dict[str, Any]:
    """One measurement; numbers that are not finite become null."""
    found = {
        name: value for name, value in asdict(point).items() if name not in ("fastest", "median", "repeats")
    }
    found["seconds"] = {"fastest": point.fastest, "median": point.median, "repeats": point.repeats}
    for name in ("error", "discretisation"):
        if found[name] is not None and not math.isfinite(found[name]):
            found[name] = None
    return found


def milliseconds(seconds: float) -> str:
    """A time in words, two digits."""
    if seconds >= 0.9995:
        return f"{seconds:.2g} s"
    return f"{1e3 * seconds:.2g} ms" if seconds < 0.0995 else f"{1e3 * seconds:.0f} ms"
