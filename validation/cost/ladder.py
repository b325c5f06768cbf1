r"""One scene: which element and mesh its tip needs for 1 %, 0.1 %, 0.01 % of the length, and its time.

The scene is solved on a ladder of meshes, each twice as fine, with every element that takes it. Nothing is
known but the ladder itself, so each element is judged by the limit of its own ladder (limits.py): an error is
the distance from that limit plus its error bar. It is a *discretisation* error. What an element cannot
show on any mesh is not in it; how far the limits of the elements lie apart is told beside it.
"""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf.elements import ELEMENTS
from ancf.errors import InputError, Message
from ancf.solution import Solution
from ancf.solver import prepare
from validation.cost.limits import LadderLimit, ladder_limit
from validation.cost.points import CostPoint, elements_text, parts_of, reached, timed

Floats = NDArray[np.float64]

TARGETS = (1e-2, 1e-3, 1e-4)  # of the length
FIRST, FINEST, FINEST_FULL = 2, 64, 256  # elements of the part that has most of them
BUDGET, BUDGET_FULL = 10.0, 60.0  # CPU seconds for one element's ladder: the next mesh is not begun beyond it
REPEATS = 5
# A ladder ends where its limit is known this many times better than the finest target.
CERTAIN = 0.1


@dataclass(frozen=True)
class ElementLadder:
    """One element on its meshes.

    Parameters
    ----------
    points : its `CostPoint`s; `position` holds the tips of all rods by their lengths, `error` the distance
        from the limit plus its error bar, `discretisation` the distance alone
    limit : None where fewer than two meshes converged
    distance : of its limit from that of the scene's own element, by the length; None for that element
        itself and where one of them has no limit
    """

    element: str
    formulation: str
    points: list[CostPoint]
    limit: LadderLimit | None
    distance: float | None = None

    def need(self, target: float) -> CostPoint | None:
        """The fastest mesh whose error, bar included, is within a target; None: the ladder shows none."""
        return min(reached(self.points, target), key=lambda p: p.median, default=None)


@dataclass(frozen=True)
class SceneCost:
    """All ladders of a scene, that of its own element first."""

    title: str
    rods: list[str]
    ladders: list[ElementLadder]
    omissions: list[str] = field(default_factory=list)
    warnings: list[str] = field(default_factory=list)

    @property
    def own(self) -> ElementLadder | None:
        """The ladder of the scene's own element, if it has a limit."""
        return next((k for k in self.ladders[:1] if k.limit is not None), None)

    @property
    def converged(self) -> bool:
        """Whether any mesh of any element was solved."""
        return any(p.converged for ladder in self.ladders for p in ladder.points)

    def best(self, target: float) -> tuple[ElementLadder, CostPoint] | None:
        """The fastest of the elements whose limit agrees with the scene's own within the target."""
        found = []
        for ladder in self.ladders:
            point = ladder.need(target)
            if point is not None and self._agrees(ladder, target):
                found.append((ladder, point))
        return min(found, key=lambda pair: pair[1].median, default=None)

    def _agrees(self, ladder: ElementLadder, target: float) -> bool:
        if self.own is None or ladder is self.own:
            return True
        return ladder.distance is not None and ladder.distance <= target


def scene_cost(
    path: Path, full: bool = False, progress: Callable[[str, int, int], None] | None = None
) -> SceneCost:
    """Measure one scene file.

    Raises
    ------
    SceneError : the file is refused as by `ancf solve`.
    InputError : its rods differ in what a ladder changes.
    """
    scene = ancf.load_scene(path)  # every refusal of `ancf solve`
    prepare(scene)
    with path.open("rb") as file:
        data = tomllib.load(file)
    kinds = {(rod.element, rod.formulation) for rod in scene.rods}
    if len(kinds) > 1:
        raise InputError(
            Message(
                "The rods of the scene have different elements.", f"file {path}",
                ", ".join(f"{rod.name}: {rod.element} {rod.formulation}" for rod in scene.rods),
                "a ladder refines one kind of element everywhere, else its limit says nothing",
                "give all rods one element and formulation",
            )
        )  # fmt: skip
    element, formulation = kinds.pop()
    wanted = [(element, formulation)]
    for name, other in ELEMENTS.items():
        kept = formulation if formulation in other.formulations else other.formulations[0]
        if (name, kept) not in wanted:
            wanted.append((name, kept))
    ladders: list[ElementLadder] = []
    omissions: list[str] = []
    for done, kind in enumerate(wanted):
        if progress is not None:
            progress(kind[0], done, len(wanted))
        ladder, refusal = _ladder(data, kind, kind == (element, formulation), full)
        if refusal:
            omissions.append(f"{kind[0]}, {kind[1]}: {refusal}")
        if ladder is not None:
            ladders.append(_beside(ladder, ladders[0] if ladders else None))
            omissions += [f"{p.label}, {p.mesh}: {p.status}" for p in ladder.points if not p.converged]
    solution = ancf.solve(scene)
    warnings = list(solution.warnings) if solution.status is ancf.Status.CONVERGED else []
    return SceneCost(scene.title, [rod.name for rod in scene.rods], ladders, omissions, warnings)


def _ladder(
    data: Mapping[str, Any], kind: tuple[str, str], own: bool, full: bool
) -> tuple[ElementLadder | None, str]:
    """Solve on ever finer meshes until the limit is certain or the budget spent; a refusal in words."""
    points: list[CostPoint] = []
    seen: set[int] = set()
    budget, spent, refusal = BUDGET_FULL if full else BUDGET, 0.0, ""
    count = FIRST // 2
    while 2 * count <= (FINEST_FULL if full else FINEST) and spent < budget:
        count *= 2
        try:
            scene = ancf.scene_from_dict(refined_scene(data, count, *kind, own))
            total = sum(rod.elements for rod in scene.rods)
            if total in seen:
                continue
            seen.add(total)
            seconds_left = min(scene.solver.max_seconds, budget)
            scene = replace(scene, solver=replace(scene.solver, max_seconds=seconds_left))
            solutions, seconds = timed(lambda scene=scene: ancf.solve(scene), REPEATS)
        except InputError as error:  # a coarse mesh may have too few elements for its supports
            refusal = f"{error.message.what} {error.message.value}"
            continue
        points.append(_point(kind, total, solutions, seconds))
        spent += sum(seconds)
        limit = _limit(points)
        if limit is not None and limit.order is not None and limit.bar <= CERTAIN * TARGETS[-1]:
            break
    if not points:
        return None, refusal
    limit = _limit(points)
    return ElementLadder(*kind, [_judged(p, limit) for p in points], limit), ""


def refined_scene(
    data: Mapping[str, Any], count: int, element: str, formulation: str, own: bool
) -> dict[str, Any]:
    """The scene with another element and mesh: `count` elements where it has most, the others in proportion.

    `own`: it is the scene's own element; only then its axial rule and shear factors are kept.
    """
    scene = copy.deepcopy(dict(data))
    scene.get("solver", {}).pop("accuracy", None)  # here the ladder chooses
    parts = [part for rod in scene["rod"] for part in rod.get("segments", [rod])]
    most = max(int(part.get("elements", 1)) for part in parts)
    for part in parts:
        part["elements"] = max(1, round(int(part.get("elements", 1)) * count / most))
    for rod in scene["rod"]:
        rod["element"], rod["formulation"] = element, formulation
        if not own:
            rod.pop("axial_rule", None)
        if formulation != "enhanced":
            rod.pop("shear_factors", None)
    return scene


def _point(kind: tuple[str, str], total: int, solutions: list[Solution], seconds: list[float]) -> CostPoint:
    solution = min(solutions, key=lambda s: s.seconds["total"])
    solver = solution.scene.solver
    converged = solution.status is ancf.Status.CONVERGED
    tips = [solution.tip(rod.name).position / rod.length for rod in solution.scene.rods] if converged else []
    return CostPoint(
        model=kind[0],
        kind="beam",
        formulation=kind[1],
        elements=total,
        mesh=elements_text(total),
        tangent=solver.tangent,
        predictor=solver.predictor,
        status="converged" if converged else f"{solution.status}: {solution.reason}",
        position=[float(v) for tip in tips for v in tip],
        unknowns=solution.unknowns,
        iterations=solution.iterations,
        steps=solution.steps,
        fastest=min(seconds),
        median=float(np.median(seconds)),
        repeats=len(seconds),
        parts=parts_of(solution, min(seconds)),
    )


def _limit(points: list[CostPoint]) -> LadderLimit | None:
    """The limit of the meshes after the last that failed."""
    failed = [i for i, p in enumerate(points) if not p.converged]
    good = points[failed[-1] + 1 :] if failed else points
    return ladder_limit([p.elements for p in good], [np.array(p.position) for p in good])


def _judged(point: CostPoint, limit: LadderLimit | None) -> CostPoint:
    """The point with its error; the last mesh of a ladder without a limit has none."""
    if limit is None or not point.converged:
        return point
    distance = _worst(np.array(point.position) - limit.value)
    return replace(point, error=distance + limit.bar, discretisation=distance)


def _beside(ladder: ElementLadder, own: ElementLadder | None) -> ElementLadder:
    if own is None or own.limit is None or ladder.limit is None:
        return ladder
    return replace(ladder, distance=_worst(ladder.limit.value - own.limit.value))


def _worst(difference: Floats) -> float:
    """Largest distance between tips, over the rods."""
    return float(np.linalg.norm(difference.reshape(-1, 3), axis=1).max())
