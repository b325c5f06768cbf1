"""`accuracy` in `[solver]`: the program chooses element and mesh, and says how good the answer is.

A coarse mesh is solved and its error estimated (error_estimate.py). While that is too large, elements are cut
where the estimate says that it helps; where what the sections cannot do (model_error.py) is too large,
another element is taken, the cheapest that can. The answer returned is the one that was estimated, not the
finer one that it was compared with: of that one nothing is known.
"""

from __future__ import annotations

import time
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ancf.accuracy_record import Accuracy, Trial, elements_of
from ancf.element_choice import BETTER, CHOICE, candidates, choose, left_for_mesh
from ancf.elements import ELEMENTS
from ancf.error_estimate import ErrorEstimate, estimate_error, order_of
from ancf.model import Model
from ancf.model_error import model_errors
from ancf.refinement import SAFETY, carried, cut, pieces_for, prepared
from ancf.scene import Rod, Scene
from ancf.solution import Solution, Status
from ancf.solver import solve

Floats = NDArray[np.float64]

MOST_ELEMENTS = 2000  # of a scene: some seconds
MOST_ROUNDS = 12
ATTEMPTS = 3  # meshes in a row on which an equilibrium or its estimate may be missing
STALLED = 2  # rounds in a row that leave more than FALLING of the estimate
FALLING = 0.8
NEAR = 1e-3  # of the wanted accuracy: how near to equilibrium an estimate needs to be at least
LEAST_TIME = 1e-3  # s, of a solve that has run out of time


def solve_to_accuracy(scene: Scene) -> Solution:
    """Find the equilibrium on a mesh whose estimated tip error is within `scene.solver.accuracy`.

    Returns
    -------
    The solution on the mesh chosen, with its `accuracy`. Its `scene` holds that mesh and asks for no accuracy
    any more: solving it again gives the same answer. What could not be met is among its warnings.

    Notes
    -----
    Each mesh is solved and estimated; in all that takes two to four times the solve of the last one.
    """
    started = time.perf_counter()
    assert scene.solver.accuracy is not None
    search = _Search(scene.solver.accuracy, scene.solver.max_seconds, started)
    solution = search.run(prepared(scene))
    options = replace(solution.scene.solver, max_seconds=scene.solver.max_seconds)
    return replace(
        solution,
        scene=replace(solution.scene, solver=options),
        seconds={**solution.seconds, "total": time.perf_counter() - started},
        accuracy=search.account(solution),
    )


@dataclass(frozen=True)
class _Estimated:
    """A solution with the estimates of its errors; those of the model for each rod by element."""

    solution: Solution
    error: ErrorEstimate
    model: list[dict[str, float]]  # empty where they are not known

    @property
    def model_error(self) -> float | None:
        """The largest over the rods."""
        if not self.model:
            return None
        rods = self.solution.scene.rods
        return max(errors[rod.element] for rod, errors in zip(rods, self.model, strict=True))

    @property
    def total(self) -> float:
        """Both errors together."""
        return self.error.largest + (self.model_error or 0.0)

    @property
    def elements(self) -> str:
        """The elements of the rods."""
        return elements_of(self.solution.scene.rods)


@dataclass
class _Search:
    """The search for a mesh: budget, what was tried, and the best of it."""

    wanted: float
    max_seconds: float
    started: float
    tried: list[Trial] = field(default_factory=list)
    best: _Estimated | None = None
    limit: str = ""
    missing: int = 0  # meshes in a row without an equilibrium or without an estimate
    rounds: int = 0  # of refinement by an estimate
    stalled: int = 0
    barred: set[str] = field(default_factory=set)  # elements that found no equilibrium

    @property
    def deadline(self) -> float:
        """Value of time.perf_counter() at which the budget is used up."""
        return self.started + self.max_seconds

    def run(self, scene: Scene) -> Solution:
        """Solve, estimate and refine until the accuracy is met or a limit is; the best answer."""
        start = None
        while True:
            left = max(self.deadline - time.perf_counter(), LEAST_TIME)
            solution = solve(replace(scene, solver=replace(scene.solver, max_seconds=left)), start)
            estimated = self._estimated(solution)
            if estimated is None:
                following, start = self._without_estimate(solution)
            else:
                self._keep(estimated)
                following, start = self._following(estimated)
            if following is None:
                return solution if self.best is None else self.best.solution
            scene = following

    def _estimated(self, solution: Solution) -> _Estimated | None:
        """Estimate the errors of a solution and enter it among what was tried."""
        error, model = None, []
        if solution.status is Status.CONVERGED:
            error = estimate_error(solution, NEAR * self.wanted, self.deadline)
        if error is not None:
            rods = solution.scene.rods
            names = {name for rod in rods for name in (rod.element, *(CHOICE if rod.any_element else ()))}
            model = model_errors(error, tuple(sorted(names)))
        found = None if error is None else _Estimated(solution, error, model)
        self.tried.append(
            Trial(
                elements_of(solution.scene.rods),
                sum(rod.elements for rod in solution.scene.rods),
                solution.unknowns,
                str(solution.status),
                solution.iterations,
                0 if error is None else error.iterations,
                None if error is None else error.largest,
                None if found is None else found.model_error,
            )
        )
        return found

    def _without_estimate(self, solution: Solution) -> tuple[Scene | None, Floats | None]:
        """Go on from a mesh without equilibrium or estimate: on a finer one, with another element, or not."""
        self.missing += 1
        if self._out_of_time():
            return None, None
        scene = solution.scene
        switched = self.best is not None and self.best.elements != elements_of(scene.rods)
        if self.missing < ATTEMPTS:
            return replace(scene, rods=tuple(cut(rod, 2) for rod in scene.rods)), None
        if switched and self.best is not None:  # back to what was found with the other element
            kept = {rod.element for rod in self.best.solution.scene.rods}
            self.barred |= {rod.element for rod in scene.rods} - kept
            return self._following(self.best)
        self.limit = "no equilibrium was found on the finer mesh that an estimate needs"
        if solution.status is not Status.CONVERGED:
            count = self.tried[-1].elements
            self.limit = f"the next mesh, of {count} elements, has no equilibrium ({solution.status})"
        return None, None

    def _keep(self, estimated: _Estimated) -> None:
        """Remember the better answer, and how often the estimate did not become smaller."""
        best, self.missing = self.best, 0
        if best is not None and best.elements == estimated.elements:
            fell = estimated.error.largest <= FALLING * best.error.largest
            self.stalled = 0 if fell else self.stalled + 1
            better = estimated.error.largest <= best.error.largest
        else:
            better = best is None or estimated.total <= best.total
        if better:
            self.best = estimated

    def _following(self, estimated: _Estimated) -> tuple[Scene | None, Floats | None]:
        """The scene with its next mesh and a start on it; None: it is good enough, or a limit is met."""
        scene, finer = estimated.solution.scene, estimated.error.finer
        self.rounds += 1
        rods = [self._refined(estimated, index) for index in range(len(scene.rods))]
        if all(new is rod for new, rod in zip(rods, scene.rods, strict=True)) or self._at_limit(rods):
            return None, None
        following = replace(scene, rods=tuple(rods))
        if elements_of(rods) != estimated.elements:
            # The vectors are others: its own start serves better.
            return replace(following, rods=tuple(replace(rod, any_element=False) for rod in rods)), None
        return following, carried(finer.model, finer.q, Model(following))

    def _refined(self, estimated: _Estimated, index: int) -> Rod:
        """A rod with its next element and mesh; the same object where it may stay."""
        scene = estimated.solution.scene
        rod = scene.rods[index]
        concerned = slice(None) if scene.joints else slice(index, index + 1)
        error, element, model = max(estimated.error.of_rod[concerned]), rod.element, 0.0
        if estimated.model:
            errors = {
                name: max(of_rod[name] for of_rod in estimated.model[concerned])
                for name in candidates(scene, rod)
                if name not in self.barred
            }
            element = choose(errors, self.wanted)
            model = errors[element]
        target = left_for_mesh(self.wanted, model)
        if error > target:
            # A prediction that failed is believed less.
            reduction = SAFETY ** min(self.rounds, 2) * target / error
            rod = cut(rod, pieces_for(estimated.error.contributions[index], reduction, order_of(rod.element)))
        if element != rod.element:
            rod = replace(rod, element=element, formulation=ELEMENTS[element].formulations[0])
        return rod

    def _out_of_time(self) -> bool:
        if time.perf_counter() <= self.deadline:
            return False
        self.limit = f"max_seconds = {self.max_seconds:g} s is used up"
        return True

    def _at_limit(self, rods: list[Rod]) -> bool:
        """Whether the budget forbids the next mesh, and which part of it."""
        if self._out_of_time():
            return True
        count = sum(rod.elements for rod in rods)
        if count > MOST_ELEMENTS:
            self.limit = (
                f"it would take {count} elements, and the program chooses {MOST_ELEMENTS} at the most"
            )
        elif self.stalled >= STALLED:
            self.limit = "finer meshes no longer reduce it: rounding, or a place that no mesh resolves"
        elif len(self.tried) >= MOST_ROUNDS:
            self.limit = f"{MOST_ROUNDS} meshes were tried"
        return bool(self.limit)

    def account(self, solution: Solution) -> Accuracy:
        """The record of the answer."""
        best = self.best
        return Accuracy(
            wanted=self.wanted,
            estimate=None if best is None else best.error.largest,
            model_error=None if best is None else best.model_error,
            rods=solution.scene.rods,
            tried=tuple(self.tried),
            limit=self.limit,
            advice=self._advice(),
        )

    def _advice(self) -> str:
        """What would let the program take an element with better sections; empty where nothing would."""
        if self.best is None:
            return ""
        scene = self.best.solution.scene
        for rod, errors in zip(scene.rods, self.best.model, strict=False):
            barred = set(CHOICE) - set(candidates(scene, rod)) if rod.any_element else set()
            better = [name for name in barred if errors[name] < BETTER * errors[rod.element]]
            if better and any(support.kind == "clamp" for support in rod.supports):
                return (
                    f'with kind = "free_section_clamp" in place of "clamp" the program may take {better[0]}, '
                    f"whose sections leave {errors[better[0]]:.2g}"
                )
        return ""
