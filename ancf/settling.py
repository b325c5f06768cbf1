"""Augmentation round Newton: multipliers and pairs of contact move between runs until they stand still."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.model import Model
from ancf.newton import NewtonResult, Outcome, newton

Floats = NDArray[np.float64]

MOST_ROUNDS = 40
ITERATIONS = 25  # of a round; two or three are usual


def settled(model: Model, result: NewtonResult, deadline: float = np.inf) -> NewtonResult:
    """The equilibrium that a converged run leads to once contact has settled; the run itself without contact.

    The last run that did not converge where one does not, or the last one as OFF_PATH where a round moves a
    point through an obstacle.
    """
    history = list(result.history)
    for _ in range(MOST_ROUNDS):
        if not result.converged or not model.augment(result.q):
            return result
        before = result.q
        result = newton(model, before, result.load_factor, ITERATIONS, deadline)
        history += result.history
        result.history = list(history)
        if result.converged and model.room(before, result.q) < 1.0:
            result.outcome = Outcome.OFF_PATH
    result.outcome = Outcome.TOO_MANY
    return result
