"""What reaching an accuracy costs: uniform meshes of each element beside the mesh that the program chooses.

``python -m validation.accuracy_cost`` prints the table. For each case and accuracy: the smallest uniform mesh
of an element whose true error (against the same element on a far finer mesh) is small enough and the CPU time
of one cold solve on it; the same of the mesh that `accuracy` chooses, and of choosing it.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

import ancf
from ancf.refinement import with_elements
from ancf.scene import Scene
from ancf.solution import Solution
from validation.cases import load_cases
from validation.problems_accuracy import in_units

ACCURACIES = (1e-2, 1e-3, 1e-4)
ELEMENTS = ("3333", "3243", "3363")
MESHES = (2, 3, 4, 5, 6, 7, 8, 10, 12, 14, 16, 20, 24, 28, 32, 40, 48, 56, 64, 80, 96, 128)
FINEST = 256  # elements of the mesh that counts as exact for its element
REPEATS = 3


@dataclass(frozen=True)
class Price:
    """Elements and CPU milliseconds of one solve; None where no mesh of the list is fine enough."""

    elements: int | None
    milliseconds: float | None


@dataclass(frozen=True)
class CostRow:
    """One case and accuracy: uniform meshes by element, the mesh chosen, and the whole of choosing it."""

    case: str
    accuracy: float
    uniform: dict[str, Price]
    chosen: Price
    search: float  # CPU milliseconds


def cost_table(names: tuple[str, ...] = ()) -> Iterator[CostRow]:
    """Rows of all thin cases of `accuracy`, or of those named."""
    for case in load_cases():
        if case.problem != "estimated error" or (names and case.id not in names):
            continue
        scene = in_units(case.scene)
        uniform = {element: _errors(scene, element) for element in ELEMENTS}
        for wanted in ACCURACIES:
            prices = {element: _cheapest(scene, element, uniform[element], wanted) for element in ELEMENTS}
            asked = ancf.scene_from_dict({**scene, "solver": {"accuracy": wanted}})
            chosen = ancf.solve(asked)
            count = sum(rod.elements for rod in chosen.scene.rods)
            price = Price(count, _milliseconds(lambda scene=chosen.scene: ancf.solve(scene)))
            yield CostRow(
                case.id, wanted, prices, price, _milliseconds(lambda scene=asked: ancf.solve(scene))
            )


def _meshed(scene: Mapping[str, Any], element: str, count: int) -> Scene:
    """The scene on a uniform mesh; each segment has its share of the elements."""
    asked = ancf.scene_from_dict({**scene, "solver": {"accuracy": 0.1}})
    rods = []
    for rod in asked.rods:
        shares = [max(round(count * part.length / rod.length), 1) for part in rod.parts]
        new = replace(rod, element=element, formulation="")
        rods.append(with_elements(new, shares))
    return replace(asked, rods=tuple(rods), solver=replace(asked.solver, accuracy=None))


def _errors(scene: Mapping[str, Any], element: str) -> dict[int, float]:
    """Tip error over length by the number of elements; infinite where there is no equilibrium."""
    exact = _tip(_meshed(scene, element, FINEST))
    found = {}
    for count in MESHES:
        tip = _tip(_meshed(scene, element, count))
        found[count] = np.inf if tip is None or exact is None else float(np.linalg.norm(tip - exact))
    return found


def _tip(scene: Scene) -> Any:
    solution = ancf.solve(scene)
    return solution.tip().position / scene.rods[0].length if solution.status == "converged" else None


def _cheapest(scene: Mapping[str, Any], element: str, errors: dict[int, float], wanted: float) -> Price:
    """The smallest mesh from which on every one of the list is fine enough."""
    fine = [n for n in MESHES if all(error <= wanted for count, error in errors.items() if count >= n)]
    if not fine:
        return Price(None, None)
    meshed = _meshed(scene, element, fine[0])
    return Price(fine[0], _milliseconds(lambda: ancf.solve(meshed)))


def _milliseconds(work: Callable[[], Solution]) -> float:
    """CPU time of the fastest of some runs."""
    seconds = []
    for _ in range(REPEATS):
        started = time.process_time()
        work()
        seconds.append(time.process_time() - started)
    return 1e3 * min(seconds)


def main() -> None:
    """Print the table."""
    print(
        f"{'case':16} {'accuracy':>8}  " + "  ".join(f"{name + ' uniform':>16}" for name in ELEMENTS), end=""
    )
    print(f"  {'chosen':>16}  {'search':>8}   (elements, CPU ms)")
    for row in cost_table():
        cells = [*(row.uniform[element] for element in ELEMENTS), row.chosen]
        texts = [
            f"{'-':>16}" if cell.elements is None else f"{cell.elements:>7} {cell.milliseconds:8.1f}"
            for cell in cells
        ]
        print(f"{row.case:16} {row.accuracy:8g}  " + "  ".join(texts) + f"  {row.search:8.1f}", flush=True)


if __name__ == "__main__":
    main()
