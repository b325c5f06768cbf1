"""Every model on every set of poses, over several seeds, and what it is worth in solved equilibria."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surrogate.conformal import calibrated, coverage
from surrogate.evaluate import Scores, designs, latency, leak_guard, score, slab
from surrogate.fit import BASELINES, KINDS, AnyModel, fit
from surrogate.inverse import Inverse, closed_form, exact_inverse
from surrogate.model_card import SET_TEXT
from surrogate.problem import Problem, Samples, box_design, solved

Floats = NDArray[np.float64]

SEEDS = (0, 1, 2, 3, 4)
ROWS = 200  # of the independent design that are inverted exactly
COVERED = 2000  # new rows for the coverage of the error radius
FAR = 1e6  # score of a pose that needs moments outside the bounds


def compare(problem: Problem, seeds: Sequence[int] = SEEDS, epochs: int | None = None) -> dict[str, Any]:
    """Fit all models and measure them.

    Returns
    -------
    Plain data: models[] = {kind, seeds, training_cpu_seconds, latency, sets {name: {tip_percent, ...}},
    coverage, solves, leak}, each number of a set with its mean and deviation over the seeds; `start` =
    equilibria solved by the exact inverse from the straight arm; `auroc` of reachability.

    Notes
    -----
    `epochs` shortens the trainings of networks, for tests.
    """
    sets = designs(problem)
    rest, cut = problem.without(slab(problem.bounds))
    fresh = solved(problem.arm, box_design(problem.bounds, COVERED, 31))
    few = sets.off_grid.taken(np.arange(min(ROWS, len(sets.off_grid))))
    models = []
    for kind in (*BASELINES, *reversed(KINDS)):
        if kind in ("closed form", "equivariant") and problem.arm.without_closed_form:
            continue
        fitted, without = fit(problem, kind, seeds, epochs), fit(rest, kind, seeds, epochs)
        found = {
            name: [score(m.predict, problem.arm, samples, problem.deviation) for m in fitted.models]
            for name, samples in sets.named().items()
        }
        found["slab"] = [score(m.predict, problem.arm, cut, rest.deviation) for m in without.models]
        models.append(
            {
                "kind": kind,
                "seeds": len(fitted.models),
                "training_cpu_seconds": fitted.seconds,
                "latency": dict(zip(("p50", "p99"), _latency(fitted.models[0], sets.split), strict=True)),
                "sets": {name: _spread(scores) for name, scores in found.items()},
                "coverage": _coverage(fitted.models, problem, fresh),
                "solves": _solves(problem, few, fitted.models[0].predict(few.poses)),
                "leak": leak_guard(found["split"][0], found["off_grid"][0], kind),
            }
        )
    return {
        "schema": 1,
        "data": problem.name,
        "certificate": problem.certificate,
        "training_rows": len(problem.train),
        "models": models,
        "start": {
            "straight arm": _solves(problem, few, np.zeros_like(few.moments)),
            "closed form": _solves(problem, few, closed_form(problem.arm, few.poses)),
        },
        "auroc": reachability(problem),
    }


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


def _coverage(models: Sequence[AnyModel], problem: Problem, fresh: Samples) -> dict[str, float]:
    """Shares of new rows of the box inside the radii of position and moment, mean over the seeds."""
    held = [
        coverage(calibrated(m.predict, problem.arm, problem.validation), m.predict, problem.arm, fresh)
        for m in models
    ]
    position, moment = np.mean(held, axis=0)
    return {"position": float(position), "moment": float(moment)}


def _latency(model: AnyModel, samples: Samples) -> tuple[float, float]:
    return latency(model.predict, samples.poses)


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


def report(record: Mapping[str, Any]) -> str:
    """The record as Markdown, with what follows from it."""
    sets = [name for name in SET_TEXT if name in record["models"][0]["sets"]]
    lines = [
        "# Models of the inverse, in closed loop",
        "",
        f'Data set "{record["data"]}", {record["training_rows"]} training rows; certificate:'
        f" {record['certificate']}.",
        "",
        "Tip error in % of L: mean over poses (+- deviation over the seeds) / largest.",
        "",
        f"| model | {' | '.join(sets)} |",
        "|---" * (len(sets) + 1) + "|",
    ]
    for model in record["models"]:
        cells = []
        for name in sets:
            tip = model["sets"][name]["tip_percent"]
            cells.append(
                f"{tip['mean']['mean']:.2g} +- {tip['mean']['deviation']:.1g} / {tip['max']['mean']:.2g}"
            )
        lines.append(f"| {model['kind']} ({model['seeds']}) | {' | '.join(cells)} |")
    lines += ["", *(f"* {name}: {SET_TEXT[name]}" for name in sets), ""]
    lines += [
        "| model | degrees | R^2 | MSE, N^2 m^2 | training, s | p50, us | p99, us | coverage at 95 %"
        " | solves to converge |",
        "|---" * 9 + "|",
    ]
    for model in record["models"]:
        off = model["sets"]["off_grid"]
        lines.append(
            f"| {model['kind']} | {off['angle_degrees']['mean']['mean']:.2g} | {off['r2']['mean']:.6f} |"
            f" {off['mse']['mean']:.2g} | {model['training_cpu_seconds']:.2g} |"
            f" {1e6 * model['latency']['p50']:.0f} | {1e6 * model['latency']['p99']:.0f} |"
            f" {100 * model['coverage']['position']:.1f} % | {model['solves']['mean']:.2f} |"
        )
    straight, thin = (record["start"][name]["mean"] for name in ("straight arm", "closed form"))
    best = min(m["solves"]["mean"] for m in record["models"])
    lines += [
        "",
        f"Reachability by the converged mismatch and the bounds: AUROC {record['auroc']:.4f}.",
        "",
        "## Is a surrogate worth having?",
        "",
        f"Levenberg-Marquardt on the equilibria needs {thin:.2f} solves from the closed form of the thin arm,"
        f" {straight:.2f} from the straight arm; from the best model here {best:.2f}. A model thus saves"
        f" {thin - best:.2f} solves of some 2 ms each (with their sensitivities) against the closed form,"
        f" {straight - best:.2f} against no guess at all; it cost {record['training_rows']} solves and"
        " training. It is worth having where its own answer, unrefined, is accurate enough and microseconds"
        " count; it is not where poses may be disturbed, out of reach or outside its box, where other loads"
        " act, or where a millisecond does not matter: there the exact inverse is better.",
    ]
    lines += ["", *(f"WARNING: {m['leak']}" for m in record["models"] if m["leak"])]
    return "\n".join(lines).rstrip() + "\n"
