"""Every model on every set of poses, over several seeds, and what it is worth in solved equilibria."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surrogate.conformal import calibrated, calibration, coverage
from surrogate.evaluate import Designs, Scores, designs, latency, leak_guard, score, slab
from surrogate.fit import BASELINES, CLOSED_FORM_KINDS, KINDS, AnyModel, Fit, fit
from surrogate.inverse import Inverse, closed_form, exact_inverse, gauss_newton, pose_mismatch
from surrogate.problem import Problem, Samples, box_design, solved
from surrogate.worth import owed, worth

Floats = NDArray[np.float64]

SEEDS = (0, 1, 2, 3, 4)
ALL_KINDS = (*BASELINES, *reversed(KINDS))
ROWS = 200  # of the independent design that are inverted exactly
COVERED = 2000  # new rows for the coverage of the error radius
FAR = 1e6  # score of a pose that needs moments outside the bounds


def compare(
    problem: Problem,
    seeds: Sequence[int] = SEEDS,
    epochs: int | None = None,
    kinds: Sequence[str] = ALL_KINDS,
) -> dict[str, Any]:
    """Fit all models and measure them.

    Returns
    -------
    Plain data: models[] as `compare_errors` gives them, with coverage, solves and gauss_newton; `start` =
    equilibria solved by the exact inverse from the straight arm and from the closed form; `auroc` of
    reachability; `worth` (worth.py).

    Notes
    -----
    `epochs` shortens the trainings of networks, for tests.
    """
    sets = designs(problem)
    calibrating, fresh = calibration(problem), solved(problem.arm, box_design(problem.bounds, COVERED, 31))
    few = sets.off_grid.taken(np.arange(min(ROWS, len(sets.off_grid))))
    models = []
    for fitted, errors in _errors(problem, sets, seeds, epochs, kinds):
        guess = fitted.models[0].predict(few.poses)
        more = {
            "coverage": _coverage(fitted.models, problem, calibrating, fresh),
            "solves": _solves(problem, few, guess),
            "gauss_newton": [_stepped(problem, few, guess, steps) for steps in (1, 2)],
        }
        models.append({**errors, **more})
    start = {
        "straight arm": _solves(problem, few, np.zeros_like(few.moments)),
        "closed form": _solves(problem, few, closed_form(problem.arm, few.poses)),
    }
    return {
        **_head(problem),
        "calibration_rows": len(calibrating),
        "models": models,
        "start": start,
        "auroc": reachability(problem),
        "owed": owed(models),
        "worth": worth(problem, few, models, start, len(calibrating)),
    }


def compare_errors(
    problem: Problem,
    seeds: Sequence[int] = SEEDS,
    epochs: int | None = None,
    kinds: Sequence[str] = ALL_KINDS,
) -> dict[str, Any]:
    """The errors of `compare` alone.

    Returns
    -------
    Plain data: models[] = {kind, seeds, parameters, training_cpu_seconds, latency, sets {name: {tip_percent,
    ...}}, leak}, each number of a set with its mean and deviation over the seeds.
    """
    found = _errors(problem, designs(problem), seeds, epochs, kinds)
    return {**_head(problem), "models": [errors for _, errors in found]}


def _head(problem: Problem) -> dict[str, Any]:
    return {
        "schema": 1,
        "data": problem.name,
        "certificate": problem.certificate,
        "training_rows": len(problem.train),
    }


def _errors(
    problem: Problem, sets: Designs, seeds: Sequence[int], epochs: int | None, kinds: Sequence[str]
) -> Iterator[tuple[Fit, dict[str, Any]]]:
    """Each kind fitted, and its errors on all sets."""
    rest, cut = problem.without(slab(problem.bounds))
    for kind in kinds:
        if kind in CLOSED_FORM_KINDS and problem.arm.without_closed_form:
            continue
        fitted, without = fit(problem, kind, seeds, epochs), fit(rest, kind, seeds, epochs)
        found = {
            name: [score(m.predict, problem.arm, samples, problem.deviation) for m in fitted.models]
            for name, samples in sets.named().items()
        }
        found["slab"] = [score(m.predict, problem.arm, cut, rest.deviation) for m in without.models]
        p50, p99 = latency(fitted.models[0].predict, sets.split.poses)
        yield (
            fitted,
            {
                "kind": kind,
                "seeds": len(fitted.models),
                "parameters": _parameters(fitted),
                "training_cpu_seconds": fitted.seconds,
                "latency": {"p50": p50, "p99": p99},
                "sets": {name: _spread(scores) for name, scores in found.items()},
                "leak": leak_guard(found["split"][0], found["off_grid"][0], kind),
            },
        )


def reachability(problem: Problem, rows: int = 60, seed: int = 5) -> float:
    """Area under the receiver's curve of telling poses of the box from others by the exact inverse.

    Others: positions moved by 2 % of L, rotations of other poses, moments beyond the box by more than 2.5 %.
    """
    rng, bounds = np.random.default_rng(seed), problem.bounds
    good = solved(problem.arm, box_design(bounds, rows, seed)).poses
    moved, turned = good.copy(), good.copy()
    moved[:, :, 0] += 0.02 * problem.arm.length * rng.normal(size=(len(good), 3))
    turned[:, :, 1:] = np.roll(turned[:, :, 1:], 1, axis=0)
    wide, margin = box_design(bounds, 8 * rows, seed + 1, 1.3), 0.0125 * np.ptp(bounds, axis=1)
    beyond = ((wide < bounds[:, 0] - margin) | (wide > bounds[:, 1] + margin)).any(axis=1)
    bad = np.concatenate([moved, turned, solved(problem.arm, wide[beyond][:rows]).poses])
    found = exact_inverse(problem.arm, np.concatenate([good, bad]), bounds=bounds)
    return auroc(_reach_score(found), np.arange(len(found.moments)) >= len(good))


def auroc(scores: Floats, positive: NDArray[np.bool_]) -> float:
    """Share of pairs of a positive and a negative that the scores put in order; ties count half."""
    gap = scores[positive][:, None] - scores[~positive][None]
    return float(np.mean((gap > 0) + 0.5 * (gap == 0)))


def _reach_score(found: Inverse) -> Floats:
    return found.score() + FAR * ~found.within_bounds


def _solves(problem: Problem, samples: Samples, guess: Floats) -> dict[str, float]:
    """Equilibria that the exact inverse solves from a guess until it has converged."""
    found = exact_inverse(problem.arm, samples.poses, guess=guess, bounds=problem.bounds)
    return {
        "mean": float(found.solves.mean()),
        "max": float(found.solves.max()),
        "reached": float(found.reachable.mean()),
    }


def _stepped(problem: Problem, samples: Samples, guess: Floats, steps: int) -> dict[str, float]:
    """Largest tip error, % of L, after Gauss-Newton steps, and the share of rows with an equilibrium."""
    arm = problem.arm
    found = arm.solve(gauss_newton(arm, samples.poses, guess, steps))
    good = found.status == "converged"
    away, _ = pose_mismatch(arm, found.poses[good], samples.poses[good])
    return {
        "steps": steps,
        "max_percent": float(100.0 * away.max() / arm.length),
        "solved": float(good.mean()),
    }


def _coverage(
    models: Sequence[AnyModel], problem: Problem, calibrating: Samples, fresh: Samples
) -> dict[str, float]:
    """Shares of new rows of the box inside the radii of position and moment, mean over the seeds."""
    radii = [calibrated(m.predict, problem.arm, calibrating) for m in models]
    held = [coverage(r, m.predict, problem.arm, fresh) for r, m in zip(radii, models, strict=True)]
    position, moment = np.mean(held, axis=0)
    return {
        "position": float(position),
        "moment": float(moment),
        "radius_percent": float(100.0 * np.mean([r.position for r in radii]) / problem.arm.length),
        "deviation": radii[0].deviation,
    }


def _parameters(fitted: Fit) -> int:
    """Numbers that a model learned."""
    model = fitted.models[0]
    for name in ("flat", "coefficients", "targets"):
        if hasattr(model, name):
            return int(getattr(model, name).size)
    return 0


def _spread(scores: Sequence[Scores]) -> dict[str, Any]:
    """Mean and deviation over the seeds of every number."""

    def of(values: list[float]) -> dict[str, float]:
        return {"mean": float(np.mean(values)), "deviation": float(np.std(values))}

    names = ("mean", "median", "p95", "max")
    return {
        "tip_percent": {n: of([getattr(s.tip, n) for s in scores]) for n in names},
        "angle_degrees": {n: of([getattr(s.angle, n) for s in scores]) for n in names},
        "mse": of([s.mse for s in scores]),
        "mse_z": of([s.mse_z for s in scores]),
        "r2": of([s.r2 for s in scores]),
        "unsolved": sum(s.unsolved for s in scores),
    }
