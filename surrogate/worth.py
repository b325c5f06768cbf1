"""What a model of the inverse saves, in solved equilibria and in milliseconds, and what it has cost.

The alternatives need no data: the closed form of the thin arm, and Levenberg-Marquardt on the equilibria from
there (`exact_inverse`). Times are CPU times of one core on the machine that measured them.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surrogate.inverse import closed_form, exact_inverse, gauss_newton
from surrogate.problem import Problem, Samples

Floats = NDArray[np.float64]

POSES = 50  # that are inverted one by one for a time


def worth(
    problem: Problem,
    samples: Samples,
    models: Sequence[Mapping[str, Any]],
    start: Mapping[str, Mapping[str, float]],
    calibration_rows: int,
) -> dict[str, Any]:
    """Times of the alternatives, what the best model saves against them, when it has paid, and that in words.

    Parameters
    ----------
    samples : poses of an independent design, with their moments
    models, start : as `surrogate.compare.compare` returns them; the best has the smallest error off the grid

    Returns
    -------
    Plain data; `text` holds the sentences. Times in milliseconds a pose.
    """
    arm, few = problem.arm, samples.taken(np.arange(min(POSES, len(samples))))
    known = {m["kind"]: m for m in models}
    learned = {kind: m for kind, m in known.items() if kind not in ("closed form", "polynomial, 400 solves")}
    best = min(learned.values(), key=_percent)
    straight, thin = np.zeros_like(few.moments), closed_form(arm, few.poses)
    rows = samples.moments
    found = {
        "best": best["kind"],
        "best_percent": _percent(best),
        "best_percent_of_noisy_poses": _percent(best, "noise"),
        "model_ms": 1e3 * best["latency"]["p50"],
        "solve_ms": _each(lambda k: arm.solve(few.moments[k : k + 1]), len(few)),
        "solve_in_batch_ms": _each(lambda _: arm.solve(rows), 3) / len(rows),
        "step_ms": _each(lambda k: gauss_newton(arm, few.poses[k : k + 1], thin[k : k + 1]), len(few)),
        "inverse_ms": {
            name: _each(
                lambda k, guess=guess: exact_inverse(arm, few.poses[k], guess=guess[k : k + 1]), len(few)
            )
            for name, guess in (("straight arm", straight), ("closed form", thin))
        },
        "solves": {name: entry["mean"] for name, entry in start.items()} | {"best": best["solves"]["mean"]},
        "data_solves": len(problem.all) + calibration_rows,
        "training_seconds": best["training_cpu_seconds"] / best["seeds"],
    }
    networks = [m for m in learned.values() if m["kind"] not in ("polynomial", "rbf")]
    for name, model in (("closed form", known.get("closed form")), ("network", min(networks, key=_percent))):
        if model is not None:
            found[name] = {
                "kind": model["kind"],
                "percent": _percent(model),
                "ms": 1e3 * model["latency"]["p50"],
                "training_seconds": model["training_cpu_seconds"] / model["seeds"],
            }
    cost = 1e-3 * found["data_solves"] * found["solve_in_batch_ms"] + found["training_seconds"]
    found["cost_seconds"] = cost
    exact = found["inverse_ms"]["closed form"]
    saved = {name: found["solves"][name] - found["solves"]["best"] for name in start}
    found["saved_solves"] = saved
    # A saved solve of the search comes with its sensitivities; unrefined, the whole search is saved.
    guess_ms = saved["closed form"] * found["step_ms"] - found["model_ms"]
    found["pays_after"] = {
        "unrefined": _poses(cost, exact - found["model_ms"]),
        "as a guess": _poses(cost, guess_ms),
    }
    return {**found, "text": sentences(found)}


def sentences(found: Mapping[str, Any]) -> list[str]:
    """When a surrogate is worth having and when it is not, with the numbers of `worth`."""
    solves, saved, inverse = found["solves"], found["saved_solves"], found["inverse_ms"]
    thin_ms, straight_ms, network = inverse["closed form"], inverse["straight arm"], found["network"]
    own = (
        f"The model's own answer takes {1e3 * found['model_ms']:.0f} us, {thin_ms / found['model_ms']:.0f}"
        f" times less than the exact inverse, and errs by {found['best_percent']:.2g} % of L in the mean."
    )
    if "closed form" in found:
        closed = found["closed form"]
        own += (
            f" The closed form takes {1e3 * closed['ms']:.0f} us and no data, and errs by"
            f" {closed['percent']:.2g} %."
        )
    if network["kind"] != found["best"]:
        own += (
            f" A network is not needed for that: the best one ({network['kind']}) errs by"
            f" {network['percent']:.2g} % after {network['training_seconds']:.2g} s of training."
        )
    return [
        f"The exact inverse, Levenberg-Marquardt on the equilibria, needs {solves['closed form']:.2f} solves"
        f" ({thin_ms:.2g} ms a pose) from the closed form of the thin arm and {solves['straight arm']:.2f}"
        f" ({straight_ms:.2g} ms) from the straight arm; from the answer of the best model ({found['best']})"
        f" {solves['best']:.2f}. As a first guess the model saves {saved['closed form']:.2f} solves against"
        f" the closed form and {saved['straight arm']:.2f} against none, each {found['step_ms']:.2g} ms with"
        " its sensitivities.",
        own,
        f"The model cost {found['data_solves']} solves, {found['solve_in_batch_ms']:.2g} ms each in a batch"
        f" ({found['solve_ms']:.2g} ms one by one), and {found['training_seconds']:.2g} s of training."
        " Against the exact inverse its unrefined answers pay that back"
        f" {_after(found['pays_after']['unrefined'])}, its answers as first guesses"
        f" {_after(found['pays_after']['as a guess'])}.",
        "Worth having: where answers are wanted in microseconds, thousands of them, for one arm, inside the"
        " box and for clean poses; or where the arm has no closed form from which a search could start.",
        "Not worth having: where a few milliseconds do not matter; where poses are measured, as their noise"
        f" then decides and not the model ({found['best_percent_of_noisy_poses']:.2g} % of L with poses"
        " disturbed by 0.1 %); where they may be out of reach or outside the box; where loads, length or"
        " material change, as each arm needs data of its own. There the exact inverse is better, and it"
        " alone tells whether a pose can be reached.",
    ]


def owed(models: Sequence[Mapping[str, Any]]) -> str:
    """What is owed to training, architecture and features: models that differ in one of them at a time."""
    known = {model["kind"]: _percent(model) for model in models}
    steps = (
        ("cnn", "the paper's CNN in the paper's training"),
        ("cnn, decayed rate", "the same with a rate that decays"),
        ("mlp", "a perceptron of 3 x 96 on the raw pose, trained so"),
        ("log mlp", "the same perceptron on position and unwrapped logarithm"),
        ("equivariant", "a small one on the residual of the closed form, with the arm's symmetry"),
        ("polynomial", "a cubic polynomial in position and logarithm"),
    )
    shown = [f"{text} {known[kind]:.2g} %" for kind, text in steps if kind in known]
    return "One change at a time, mean tip error off the grid: " + "; ".join(shown) + "."


def _after(poses: float | None) -> str:
    return "never" if poses is None else f"after {poses:,.0f} poses"


def _percent(model: Mapping[str, Any], name: str = "off_grid") -> float:
    """Mean tip error on a set, % of L."""
    return model["sets"][name]["tip_percent"]["mean"]["mean"]


def _poses(cost: float, saved_ms: float) -> float | None:
    """Number of poses after which a cost [s] is paid back; None where nothing is saved."""
    return cost / (1e-3 * saved_ms) if saved_ms > 0.0 else None


def _each(call: Any, count: int) -> float:
    """CPU time [ms] of one of `count` calls with their numbers, after one that warms up."""
    call(0)
    begin = time.process_time()
    for number in range(count):
        call(number)
    return 1e3 * (time.process_time() - begin) / count
