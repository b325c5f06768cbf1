"""The gallery: scenes of the field, each with a picture by the program and one number against its source.

`python -m validation.report.gallery` draws all pictures into examples/gallery and writes examples/README.md;
tests/regression/test_gallery.py holds the numbers.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

import ancf
from ancf.solution import Solution
from validation.record import write_text
from validation.report.exhibits import EXAMPLES, EXHIBITS, Exhibit

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Comparison:
    """The number of an exhibit, what it should be, and their difference over its scale."""

    exhibit: Exhibit
    measured: Floats
    expected: Floats
    error: float


def compare(exhibit: Exhibit, solution: Solution) -> Comparison:
    """Hold the number of a solved scene against its source."""
    measured = np.atleast_1d(np.asarray(exhibit.measured(solution), float))
    expected = np.atleast_1d(np.asarray(exhibit.expected(solution.scene), float))
    size = float(np.linalg.norm(expected)) if exhibit.scale is None else exhibit.scale(solution.scene)
    return Comparison(exhibit, measured, expected, float(np.linalg.norm(measured - expected)) / size)


def page(comparisons: Sequence[Comparison]) -> str:
    """The text of examples/README.md."""
    lines = [
        "# Gallery",
        "",
        "Scenes of the field, solved and drawn by `python -m validation.report.gallery` (extra `pictures`).",
        "Each number is held against its source by `tests/regression/test_gallery.py`; differences are over",
        "the length, or over the number itself where it is no place. Grey and clear is the shape without",
        "loads; red arrows are forces, the grey one is gravity, dark plates are clamps, dark lines tendons,",
        "blue bodies chambers. `ancf solve SCENE.toml --view FILE.html` makes a page of any scene, to be",
        "turned with the mouse.",
        "",
    ]
    for result in comparisons:
        exhibit = result.exhibit
        lines += [
            f"## {exhibit.path.stem.replace('-', ' ').capitalize()}",
            "",
            f"![{exhibit.shows}](gallery/{exhibit.name}.png)",
            "",
            f"{exhibit.shows} [`{exhibit.name}.toml`]({exhibit.name}.toml)",
            "",
            f"| {exhibit.quantity} | expected | difference | limit |",
            "|---|---|---|---|",
            f"| {_numbers_text(result.measured)} {exhibit.unit} "
            f"| {_numbers_text(result.expected)} {exhibit.unit} "
            f"| {result.error:.1g} | {exhibit.limit:g}: {exhibit.reason} |",
            "",
            f"Source: {exhibit.source}.",
            "",
        ]
    return "\n".join(lines)


def _numbers_text(values: Floats) -> str:
    """Five digits of the largest component."""
    digits = max(0, 5 - math.ceil(math.log10(float(np.abs(values).max()))))
    texts = [f"{value:.{digits}f}".replace("-0." + digits * "0", "0." + digits * "0") for value in values]
    return f"({', '.join(texts)})" if len(texts) > 1 else texts[0]


def main(names: Sequence[str]) -> None:
    """Draw the pictures of these exhibits, all if none is named; write the page when all are drawn."""
    from ancf.view_3d import picture

    (EXAMPLES / "gallery").mkdir(exist_ok=True)
    chosen = [exhibit for exhibit in EXHIBITS if not names or exhibit.name in names]
    comparisons = []
    for exhibit in chosen:
        solution = ancf.solve(ancf.load_scene(exhibit.path))
        comparisons.append(compare(exhibit, solution))
        target = EXAMPLES / "gallery" / f"{exhibit.name}.png"
        picture(solution, target, exhibit.field, exhibit.view, exhibit.up, exhibit.ghost)
        print(f"{exhibit.name}: {solution.status}, difference {comparisons[-1].error:.2g}", file=sys.stderr)
    if not names:
        write_text(EXAMPLES / "README.md", page(comparisons))


if __name__ == "__main__":
    main(sys.argv[1:])
