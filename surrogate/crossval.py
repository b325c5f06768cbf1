"""The five-fold table of the paper (table 1, fig. 11): five architectures, all trainings as one stack."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surrogate.architecture import PUBLISHED_MSE, PUBLISHED_SIZES, TABLE_1, Architecture
from surrogate.networks import UNITS, Normaliser, image, moment_unit
from surrogate.problem import Problem, Samples, random_split

Floats = NDArray[np.float64]

FOLDS, EPOCHS = 5, 100
# The print names neither batch nor range of moments of the table. Ours: TensorFlow's default batch, and the
# range (20 units are this many E I/L) at which all errors are within a factor 3 and the order is as near the
# published one as its scatter lets it: 3 and 2 differ by 12 % in print, by less than a deviation here. Of two
# sets of five seeds and folds one gave the published order, the other 2 before 3. Elsewhere, batch 32: 2.4
# and 2.9 put 4 before 1, 2.6 and 2.75 put 2 before 3, 2.8 depends on the seeds. Batch 64: 2 before 3 up to
# 2.7, 4 before 1 from 2.8. Half the torsion, or ranges below 2: errors too small by 3 to 100.
BATCH, TABLE_RANGE = 32, 2.7


@dataclass(frozen=True, eq=False)
class TableRow:
    """One architecture over all folds and seeds; errors on the rows that were left out."""

    architecture: Architecture
    published_size: int
    published_mse: float
    training_loss: Floats  # (folds x seeds, epochs) in units^2
    validation_loss: Floats  # (folds x seeds, epochs) in units^2
    unit: float  # N m
    variance: Floats  # (folds x seeds,) of the targets left out, units^2
    z_variance: Floats  # (folds x seeds,) of the training targets, units^2

    @property
    def mse(self) -> Floats:
        """(folds x seeds,) after the last epoch, in units^2."""
        return self.validation_loss[:, -1]

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "model": self.architecture.name,
            "size": self.architecture.parameters,
            "published_size": self.published_size,
            "published_mse": self.published_mse,
            "mse_mean": float(self.mse.mean()),
            "mse_deviation": float(self.mse.std()),
            "ratio": float(self.mse.mean() / self.published_mse),
            "mse_N2m2": float(self.mse.mean() * self.unit**2),
            "mse_z": float((self.mse / self.z_variance).mean()),
            "r2": float((1.0 - self.mse / self.variance).mean()),
        }


@dataclass(frozen=True, eq=False)
class Table:
    """Table 1 regenerated."""

    rows: list[TableRow]
    range: float  # of the moments, in E I/L
    trainings: int
    seeds: int
    seconds: float  # CPU time of all trainings
    certificate: str

    @property
    def rank_correlation(self) -> float:
        """Rank correlation (Spearman) of the five errors with the published ones."""
        ranks = np.argsort(np.argsort([row.mse.mean() for row in self.rows]))
        published = np.argsort(np.argsort([row.published_mse for row in self.rows]))
        return float(np.corrcoef(ranks, published)[0, 1])

    @property
    def runs(self) -> Floats:
        """Errors (models, seeds): each a mean over the folds, as the paper's one run is."""
        return np.array([row.mse.reshape(self.seeds, -1).mean(axis=1) for row in self.rows])

    def order_share(self, resamplings: int = 10_000, size: int | None = None) -> float:
        """How often the published order comes out when the seeds of each model are drawn with replacement.

        size : seeds of which each model's mean is made; None: as many as there are; 1: single runs
        """
        rng, runs = np.random.default_rng(0), self.runs
        drawn = rng.integers(self.seeds, size=(resamplings, len(runs), size or self.seeds))
        means = np.take_along_axis(runs[None], drawn, axis=2).mean(axis=2)
        published = np.argsort([row.published_mse for row in self.rows])
        return float((np.argsort(means, axis=1) == published).all(axis=1).mean())

    def neighbours(self) -> list[dict[str, Any]]:
        """Pairs of models that follow each other in the published order: by how much, there and here.

        Each {pair, published_gap, gap, share}: relative gaps of the errors, and the share of pairs of single
        runs, one of each model, that are in the published order.
        """
        runs, found = self.runs, []
        published = [row.published_mse for row in self.rows]
        first = np.argsort(published)
        for i, j in pairwise(first):
            found.append(
                {
                    "pair": f"{i + 1} < {j + 1}",
                    "published_gap": published[j] / published[i] - 1.0,
                    "gap": float(runs[j].mean() / runs[i].mean() - 1.0),
                    "share": float((runs[i][:, None] < runs[j][None]).mean()),
                }
            )
        return found

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        return {
            "range_EI_by_L": self.range,
            "units_of_largest_moment": UNITS,
            "seeds": self.seeds,
            "epochs": self.rows[0].training_loss.shape[1],
            "trainings": self.trainings,
            "cpu_seconds": self.seconds,
            "certificate": self.certificate,
            "rank_correlation": self.rank_correlation,
            "order": order([row.mse.mean() for row in self.rows]),
            "published_order": order([row.published_mse for row in self.rows]),
            "order_share": self.order_share(),
            "order_share_of_single_runs": self.order_share(size=1),
            "neighbours": self.neighbours(),
            "runs": self.runs.tolist(),
            "models": [row.as_dict() for row in self.rows],
        }


def order(errors: Sequence[float]) -> str:
    """Numbers of the models from the smallest error to the largest, such as ``5 < 1 < 4 < 3 < 2``."""
    return " < ".join(str(place + 1) for place in np.argsort(errors))


def rescaled(problem: Problem, largest: float = TABLE_RANGE) -> Problem:
    """The same design with its largest moment at `largest` E I/L, solved here; the gate is asked again."""
    from surrogate.gate import UNVALIDATED, ask

    factor = largest * problem.arm.unit / float(np.abs(problem.bounds).max())
    moments = problem.all.moments * factor
    found = problem.arm.solve(moments)
    gate, good = ask(allow_unvalidated=True), found.status == "converged"
    stamp = UNVALIDATED if problem.certificate != gate.id or gate.outside(found) else gate.id
    rows = Samples(found.poses[good], moments[good])
    parts = (rows.taken(part) for part in random_split(len(rows), 0))
    split = dict(zip(("train", "validation", "test"), parts, strict=True))
    return replace(problem, bounds=problem.bounds * factor, certificate=stamp, **split)


def cross_validate(
    problem: Problem,
    architectures: Sequence[Architecture] = TABLE_1,
    *,
    folds: int = FOLDS,
    seeds: Sequence[int] = (0,),
    epochs: int = EPOCHS,
    batch: int = BATCH,
) -> Table:
    """Train every architecture on every fold with every seed, as one stacked training.

    Inputs are z-scored by the training rows of each fold; targets are not (networks.py, UNITS).
    """
    from surrogate.training import Rows, Schedule, train

    samples, unit = problem.all, moment_unit(problem.bounds)
    pairs = [_fold(samples, fold, folds, seed) for seed in seeds for fold in range(folds)]
    kept, left = [[_rows(s, n, unit) for s, n in part] for part in zip(*pairs, strict=True)]
    training, validation = (
        Rows(np.array([x for x, _ in part]), np.array([y for _, y in part])) for part in (kept, left)
    )
    started = time.process_time()
    names = [1000 * seed + fold for seed in seeds for fold in range(folds)]
    trained = train(architectures, training, validation, Schedule(epochs, batch), names)
    seconds = time.process_time() - started
    variance, z_variance = (part.y.var(axis=1).mean(axis=1) for part in (validation, training))
    known = {
        a.name: (size, mse) for a, size, mse in zip(TABLE_1, PUBLISHED_SIZES, PUBLISHED_MSE, strict=True)
    }
    rows = [
        TableRow(
            t.architecture, *known.get(t.architecture.name, (0, np.nan)), t.training_loss, t.validation_loss,
            unit, variance, z_variance,
        )
        for t in trained
    ]  # fmt: skip
    largest = float(np.abs(problem.bounds).max() / problem.arm.unit)
    return Table(rows, largest, len(architectures) * len(pairs), len(seeds), seconds, problem.certificate)


def _fold(samples: Samples, fold: int, folds: int, seed: int) -> Any:
    """Rows kept and rows left out, each with the normaliser of those kept; folds are of equal size."""
    size = len(samples) // folds
    order = np.random.default_rng([seed, 9]).permutation(len(samples))[: size * folds]
    out = order[fold * size : (fold + 1) * size]
    kept, left = samples.taken(np.setdiff1d(order, out)), samples.taken(out)
    normaliser = Normaliser.of(image(kept.poses))
    return (kept, normaliser), (left, normaliser)


def _rows(samples: Samples, normaliser: Normaliser, unit: float) -> tuple[Floats, Floats]:
    return normaliser(image(samples.poses)), samples.moments / unit
