"""Load steps with cut-back: the solid solved from the unloaded shape, without a rod to start from."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from reference.solid_cost import check_cost
from reference.solid_newton import Newton
from reference.solid_problem import SolidProblem, SolidResult

Array = NDArray[np.float64]

STEP_ITERATIONS = 15  # more in one step mean that it was too long
GROWTH = 1.5  # of the step after one that took at most EASY iterations
EASY = 6
SMALLEST_STEP = 1 / 512


def solve_in_steps(
    problem: SolidProblem,
    steps: int = 4,
    *,
    begin: float | None = None,
    memory_limit: float | None = None,
    seconds_limit: float | None = None,
    report: Callable[[str], None] | None = None,
) -> SolidResult:
    """Raise all loads together from zero, halving a step that fails.

    Parameters
    ----------
    problem : SolidProblem
        Its guess is the unloaded shape, usually zeros.
    steps : int
        Number of equal steps to begin with.
    begin, memory_limit, seconds_limit, report
        As in `solve_solid`; the estimate is for `steps` solutions.

    Returns
    -------
    SolidResult
        At the full load with the iterations of all steps; else the last equilibrium reached, its status and
        reason those of the step that failed at the smallest size.

    Notes
    -----
    Each step starts from the polynomial through up to three last equilibria, quadratic in the load factor.
    """
    if steps < 1:
        raise ValueError(f"steps is {steps}; at least 1 is needed.")
    check_cost(
        problem.mesh,
        problem.formulation,
        solutions=steps,
        memory_limit=memory_limit,
        seconds_limit=seconds_limit,
        report=report,
    )
    newton = Newton(problem, perf_counter() if begin is None else begin)
    factors, shapes = [0.0], [problem.guess.astype(float)]
    step, iterations, p = 1 / steps, 0, newton.p
    while True:
        factor = min(1.0, factors[-1] + step)
        if 1 - factor < SMALLEST_STEP / 2:
            factor = 1.0
        part = replace(
            problem.with_load_factor(factor),
            guess=_extrapolated(factors[-3:], shapes[-3:], factor),
            max_iterations=min(problem.max_iterations, STEP_ITERATIONS),
        )
        newton.restart(part, p)
        result = newton.run()
        iterations += result.iterations
        if result.converged:
            if factor == 1.0:
                return replace(result, iterations=iterations, problem=problem)
            factors.append(factor)
            shapes.append(newton.u)
            p = newton.p
            if result.iterations <= EASY:
                step *= GROWTH
        else:
            step /= 2
            if step < SMALLEST_STEP:
                reason = (
                    f"load factor {factors[-1]:.4f} reached; a step of {2 * step:.1e} fails: {result.reason}"
                )
                newton.restart(replace(problem.with_load_factor(factors[-1]), guess=shapes[-1]), p)
                if not newton.form.inadmissible(newton.F):
                    newton.evaluate()
                failed = newton.result(result.status, reason)
                return replace(failed, iterations=iterations, problem=problem)


def _extrapolated(factors: list[float], shapes: list[Array], factor: float) -> Array:
    """Lagrange polynomial through the shapes at their load factors, at `factor`."""
    guess = np.zeros_like(shapes[0])
    for i, shape in enumerate(shapes):
        others = [f for k, f in enumerate(factors) if k != i]
        guess += np.prod([(factor - f) / (factors[i] - f) for f in others]) * shape
    return guess
