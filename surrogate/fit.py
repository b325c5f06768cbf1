"""The kinds of models that are compared, each fitted to a problem with several seeds."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancf.errors import InputError, Message
from surrogate.architecture import MAIN_CNN, RAW_MLP
from surrogate.baselines import ClosedForm, LogNetwork, Polynomial, RadialBasis, fit_log_networks
from surrogate.equivariant import BATCH, DECAY, EPOCHS, RATE, EquivariantNetwork, fit_equivariant
from surrogate.networks import NetworkFit, PoseNetwork, fit_networks
from surrogate.problem import Problem

Floats = NDArray[np.float64]
AnyModel = PoseNetwork | EquivariantNetwork | Polynomial | RadialBasis | ClosedForm | LogNetwork

KINDS = ("equivariant", "cnn", "mlp", "polynomial")  # that can be saved; the first is the best
# To compare with. The last two tell what is owed to the features and to the training: the perceptron on the
# features in place of the raw pose, and the paper's CNN trained as the perceptrons are.
BASELINES = ("closed form", "rbf", "polynomial, 400 solves", "log mlp", "cnn, decayed rate")
FEW_ROWS = 400  # of "polynomial, 400 solves"
CLOSED_FORM_KINDS = ("closed form", "equivariant")  # of a thin round arm under a tip moment only
MAIN_EPOCHS = 500  # paper sec. 4.1
MLP_EPOCHS = 200


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
    epochs : None: 500 of the CNN, 400 of the equivariant network, 200 of the perceptrons

    Raises
    ------
    InputError : the kind needs the closed form, which the arm has not.
    """
    if kind in CLOSED_FORM_KINDS and problem.arm.without_closed_form:
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
    if kind == "polynomial":
        models: list[AnyModel] = [Polynomial.fit(problem.arm, problem.train)]
    elif kind == "polynomial, 400 solves":
        models = [
            Polynomial.fit(problem.arm, problem.train.taken(np.arange(min(FEW_ROWS, len(problem.train)))))
        ]
    elif kind == "rbf":
        models = [RadialBasis.fit(problem.arm, problem.train)]
    elif kind == "closed form":
        models = [ClosedForm(problem.arm)]
    else:
        found = _networks(problem, kind, seeds, epochs)
        seconds = time.process_time() - started
        return Fit(kind, [*found.networks], seconds, found.training_loss, found.validation_loss)
    return Fit(kind, models, time.process_time() - started)


def _networks(
    problem: Problem, kind: str, seeds: Sequence[int], epochs: int | None
) -> NetworkFit[PoseNetwork] | NetworkFit[EquivariantNetwork] | NetworkFit[LogNetwork]:
    from surrogate.training import Schedule

    if kind == "equivariant":
        return fit_equivariant(problem, seeds, epochs or EPOCHS)
    own = MAIN_EPOCHS if kind.startswith("cnn") else MLP_EPOCHS
    decayed = Schedule(epochs or own, BATCH, RATE, DECAY)
    if kind == "cnn":
        return fit_networks(problem, MAIN_CNN, seeds, Schedule(epochs or MAIN_EPOCHS))
    if kind == "cnn, decayed rate":
        return fit_networks(problem, MAIN_CNN, seeds, decayed, units=1.0)
    if kind == "mlp":
        return fit_networks(problem, RAW_MLP, seeds, decayed, units=1.0)
    if kind == "log mlp":
        return fit_log_networks(problem, seeds, decayed)
    raise ValueError(f"no model is called {kind!r}; known are {KINDS + BASELINES}")
