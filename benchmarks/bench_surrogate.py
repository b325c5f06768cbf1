"""What the surrogate costs: training as one stack, answers one by one, against the solver's own time.

    OPENBLAS_NUM_THREADS=1 python benchmarks/bench_surrogate.py

The arm and box of the presets, 1520 Sobol rows, made outside the gate. CPU times of one core; every ratio is
within one run, so that it says the same on a busy machine. Asked: answers in 30 us (CNN) and 60 us (best
network), 25 trainings of 100 epochs in 60 s, the main CNN in 20 s. The data set has bench_dataset.py.
"""

from __future__ import annotations

import time
from collections.abc import Callable

import numpy as np

from surrogate.architecture import TABLE_1
from surrogate.arm import paper_arm
from surrogate.crossval import cross_validate
from surrogate.fit import KINDS, fit
from surrogate.inverse import closed_form, exact_inverse
from surrogate.problem import Problem, box_design, solved_problem
from surrogate.training import Rows, Schedule, train

BOX = np.outer(np.ones(3), [-0.02, 0.02])  # N m
CALLS, SOLVES, EPOCHS = 500, 50, 10


def problem() -> Problem:
    """1520 rows of the arm of the preset `sobol`."""
    return solved_problem(paper_arm(element="3333"), box_design(BOX, 1520, 0), {}, "sobol")


def cpu_seconds(call: Callable[[], object]) -> float:
    """CPU time [s] of a call."""
    started = time.process_time()
    call()
    return time.process_time() - started


def median_seconds(call: Callable[[int], object], calls: int) -> float:
    """Median CPU time [s] of calls with their numbers, after one that warms up."""
    call(0)
    return float(np.median([cpu_seconds(lambda k=k: call(k)) for k in range(calls)]))


def stacked() -> tuple[float, float]:
    """CPU time [s] of 25 trainings of `EPOCHS` epochs, as one stack and one after the other."""
    rng = np.random.default_rng(0)
    rows, left = (Rows(rng.normal(size=(5, n, 12)), rng.normal(size=(5, n, 3))) for n in (1216, 304))
    schedule = Schedule(EPOCHS, 64)
    together = cpu_seconds(lambda: train(TABLE_1, rows, left, schedule, range(5)))

    def alone() -> None:
        for k in range(5):
            first, second = (Rows(part.x[k : k + 1], part.y[k : k + 1]) for part in (rows, left))
            for architecture in TABLE_1:
                train([architecture], first, second, schedule, [k])

    return together, cpu_seconds(alone)


def main() -> None:
    """Print the tables."""
    given = problem()
    arm, poses, moments = given.arm, given.test.poses, given.test.moments
    solve = median_seconds(lambda k: arm.solve(moments[k : k + 1]), SOLVES)
    batch = median_seconds(lambda _: arm.solve(given.train.moments), 3) / len(given.train)
    print(f"one equilibrium {1e3 * solve:.3f} ms; in a batch {solve / batch:.1f} times less")
    together, alone = stacked()
    print(f"25 networks, {EPOCHS} epochs: {together:.2f} s as one stack, alone {alone / together:.1f} times")
    table = cross_validate(given)
    data = len(given.all) * batch
    print(f"25 trainings of table 1: {table.seconds:.1f} s, {table.seconds / data:.0f} times their data")
    print("model             training, s  /data   answer, us  /equilibrium  /exact inverse")
    starts = closed_form(arm, poses)
    exact = median_seconds(lambda k: exact_inverse(arm, poses[k], guess=starts[k : k + 1]), SOLVES)
    for kind in (*KINDS, "closed form"):
        fitted = fit(given, kind)
        model = fitted.models[0].predict
        answer = median_seconds(lambda k, model=model: model(poses[k % len(poses)]), CALLS)
        print(
            f"{kind:16s} {fitted.seconds:12.2f} {fitted.seconds / data:6.1f} {1e6 * answer:12.1f}"
            f" {answer / solve:13.4f} {answer / exact:15.5f}"
        )
    print(f"exact inverse from the closed form: {1e3 * exact:.2f} ms, {exact / solve:.1f} equilibria")


if __name__ == "__main__":
    main()
