"""The rows of a design: values of its variables, and which of them are for training, validation and test.

Every process makes the whole table, whatever part of it it solves: a row does not depend on the workers.
"""

from __future__ import annotations

import inspect
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from surrogate.design import Design

Floats = NDArray[np.float64]

SPLIT_NAMES = ("train", "validation", "test")
SHARES = (0.70, 0.15, 0.15)  # of the paper, section 3.1


@dataclass(frozen=True, eq=False)
class Sample:
    """Rows of a design."""

    points: Floats  # (n, k) values of the variables
    split: NDArray[np.str_]  # (n,) "train" | "validation" | "test"
    group: NDArray[np.int64]  # (n,) level of the first variable of a grid, sequence of a Sobol design

    def __len__(self) -> int:
        return len(self.points)


def sample(design: Design) -> Sample:
    """All rows of a design, a function of the design and its seed alone.

    grid: every combination, the first variable slowest. sobol: scrambled Sobol points. random: uniform.
    Under the split "design" training, validation and test rows come one after the other, each from a
    sequence of its own; under "random" they are drawn from all rows, as in the paper.
    """
    bounds = design.bounds
    sizes = split_sizes(design.count)
    if design.sampling == "grid":
        levels = [np.linspace(v.low, v.high, v.steps) for v in design.variables]
        points = np.stack(np.meshgrid(*levels, indexing="ij"), axis=-1).reshape(-1, len(levels))
        group = np.arange(design.count) // (design.count // design.variables[0].steps)
    else:
        parts = sizes if design.split == "design" else (design.count,)
        units = [
            _unit(design, seed, size) for seed, size in zip(seeds(design)["sequences"], parts, strict=True)
        ]
        points = bounds[:, 0] + np.concatenate(units) * (bounds[:, 1] - bounds[:, 0])
        group = np.repeat(np.arange(len(parts)), parts)
    names = np.repeat(np.array(SPLIT_NAMES), sizes)
    if design.split == "random":
        (seed,) = seeds(design)["split"]
        order = np.random.default_rng(seed).permutation(design.count)
        shuffled = np.empty_like(names)
        shuffled[order] = names
        names = shuffled
    return Sample(points, names, group.astype(np.int64))


def seeds(design: Design) -> dict[str, list[list[int]]]:
    """Entropies of the generators (numpy.random.default_rng): of each sequence of rows, and of the split."""
    sequences = 0 if design.sampling == "grid" else len(SPLIT_NAMES) if design.split == "design" else 1
    return {
        "sequences": [[design.seed, number] for number in range(sequences)],
        "split": [[design.seed, len(SPLIT_NAMES)]] if design.split == "random" else [],
    }


def split_sizes(count: int) -> tuple[int, int, int]:
    """Rows for training, validation and test: 70/15/15, rounded in favour of training."""
    validation, test = (math.floor(share * count + 1e-9) for share in SHARES[1:])
    return count - validation - test, validation, test


def _unit(design: Design, seed: list[int], size: int) -> Floats:
    """Points (size, k) in the unit cube, one sequence of a design."""
    generator = np.random.default_rng(seed)
    dimension = len(design.variables)
    if design.sampling == "random":
        return generator.random((size, dimension))
    return sobol_points(generator, size, dimension)


def sobol_points(generator: np.random.Generator, size: int, dimension: int) -> Floats:
    """The first points (size, dimension) of a scrambled Sobol sequence in the unit cube."""
    from scipy.stats import qmc

    name = "rng" if "rng" in inspect.signature(qmc.Sobol).parameters else "seed"  # before SciPy 1.15
    engine = qmc.Sobol(dimension, scramble=True, **{name: generator})  # pyright: ignore[reportArgumentType]
    # Drawn to the next power of two: that is the count for which the points are balanced; others warn.
    return engine.random_base2(max(0, math.ceil(math.log2(max(size, 1)))))[:size]
