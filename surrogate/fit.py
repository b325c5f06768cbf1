"""The kinds of models that `ancf train` knows, each fitted to a problem with several seeds."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancf.errors import InputError, Message
from surrogate.architecture import MAIN_CNN
from surrogate.baselines import ClosedForm, Polynomial, RadialBasis
from surrogate.equivariant import EPOCHS, EquivariantNetwork, fit_equivariant
from surrogate.networks import PoseNetwork, fit_networks
from surrogate.problem import Problem

Floats = NDArray[np.float64]
AnyModel = PoseNetwork | EquivariantNetwork | Polynomial | RadialBasis | ClosedForm

KINDS = ("equivariant", "cnn", "polynomial")  # that can be saved; the first is the best
BASELINES = ("closed form", "rbf")
MAIN_EPOCHS = 500  # paper sec. 4.1


@dataclass(frozen=True, eq=False)
class Fit:
    """Models of one kind, one for each seed; a kind without chance in it has one."""

    kind: str
    models: list[AnyModel]
    seconds: float  # CPU time of the training
    training_loss: Floats | None = None  # (seeds, epochs)
    validation_loss: Floats | None = None


def fit(problem: Problem, kind: str, seeds: Sequence[int] = (0,), epochs: int | None = None) -> Fit:
    """Fit a kind of model to the training rows.

    Parameters
    ----------
    kind : one of `KINDS` or `BASELINES`
    epochs : None: 500 of the CNN, those of equivariant.py

    Raises
    ------
    InputError : the kind needs the closed form, which the arm has not.
    """
    if kind in ("closed form", "equivariant") and problem.arm.without_closed_form:
        raise InputError(
            Message(
                f"The model {kind!r} does not fit this arm.",
                f"data set {problem.name!r}",
                problem.arm.without_closed_form,
                "it is built on the thin round arm under a tip moment",
                "take --model polynomial or cnn",
            )
        )
    started = time.process_time()
    training_loss = validation_loss = None
    if kind == "cnn":
        found = fit_networks(problem, MAIN_CNN, seeds, epochs or MAIN_EPOCHS)
        models: list[AnyModel] = [*found.networks]
        training_loss, validation_loss = found.training_loss, found.validation_loss
    elif kind == "equivariant":
        networks, training_loss, validation_loss = fit_equivariant(problem, seeds, epochs or EPOCHS)
        models = [*networks]
    elif kind == "polynomial":
        models = [Polynomial.fit(problem.arm, problem.train)]
    elif kind == "rbf":
        models = [RadialBasis.fit(problem.arm, problem.train)]
    elif kind == "closed form":
        models = [ClosedForm(problem.arm)]
    else:
        raise ValueError(f"no model is called {kind!r}; known are {KINDS + BASELINES}")
    return Fit(kind, models, time.process_time() - started, training_loss, validation_loss)
