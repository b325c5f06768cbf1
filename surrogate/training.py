r"""Training of many networks at once: replicas of several architectures, stacked, one Adam step for all.

All parameters of the replicas of an architecture are one tensor (S, P); products are batched over S. The loss
is the sum of the mean squared errors of all replicas, so each gets its own gradient, and Adam works component
by component: the result is that of S separate trainings, without S times the overhead.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np
import torch  # pyright: ignore[reportMissingImports]
from numpy.typing import NDArray

from surrogate.architecture import Architecture, Convolution, Pooling, Stage

Floats = NDArray[np.float64]
Tensor = torch.Tensor

BETA_1, BETA_2, EPSILON = 0.9, 0.999, 1e-7  # Kingma and Ba 2014; epsilon of TensorFlow, which the paper used


@dataclass(frozen=True)
class Schedule:
    """How to train: the paper's batch, optimiser and rate by default."""

    epochs: int
    batch: int = 64
    rate: float = 1e-2
    decay: float = 1.0  # the rate falls to this share of itself, by a cosine, until the last epoch
    double: bool = False  # float64 in place of float32


@dataclass(frozen=True, eq=False)
class Rows:
    """Inputs (S, n, inputs) and targets (S, n, 3), normalised, a set for each replica."""

    x: Floats
    y: Floats


@dataclass(frozen=True, eq=False)
class Trained:
    """Weights (S, P) of an architecture, and losses (S, epochs) after each epoch."""

    architecture: Architecture
    flat: Floats
    training_loss: Floats
    validation_loss: Floats


Forward = Callable[[Sequence[tuple[Tensor, Tensor]], Tensor], Tensor]


def train(
    architectures: Sequence[Architecture],
    training: Rows,
    validation: Rows,
    schedule: Schedule,
    seeds: Sequence[int],
    forward: Callable[[Architecture], Forward] | None = None,
) -> list[Trained]:
    """Train every architecture on every set of rows; one stacked training.

    Parameters
    ----------
    training, validation : S sets of rows each
    seeds : (S,) of weights and order of the rows; equal seeds give equal weights on one machine
    forward : of an architecture, if not `stacked_forward`
    """
    dtype = torch.float64 if schedule.double else torch.float32
    X, Y, Xv, Yv = (
        torch.from_numpy(np.ascontiguousarray(a)).to(dtype)
        for a in (training.x, training.y, validation.x, validation.y)
    )
    with _one_thread():
        order = [np.random.default_rng([seed, 1]) for seed in seeds]
        flats = [_start(a, seeds, dtype) for a in architectures]
        runs = [(forward or stacked_forward)(a) for a in architectures]
        first, second = [torch.zeros_like(f) for f in flats], [torch.zeros_like(f) for f in flats]
        losses = np.zeros((2, len(architectures), len(seeds), schedule.epochs))
        sets, n = X.shape[:2]
        replica = torch.arange(sets)[:, None]
        step = 0
        for epoch in range(schedule.epochs):
            turn = 0.5 * (1.0 + np.cos(np.pi * epoch / schedule.epochs))
            rate = schedule.rate * (schedule.decay + (1.0 - schedule.decay) * turn)
            rows = torch.from_numpy(np.array([rng.permutation(n) for rng in order]))
            Xe, Ye = X[replica, rows], Y[replica, rows]
            for begin in range(0, n, schedule.batch):
                x, y = Xe[:, begin : begin + schedule.batch], Ye[:, begin : begin + schedule.batch]
                step += 1
                loss = torch.stack(
                    [
                        _error(run, a, flat, x, y).sum()
                        for run, a, flat in zip(runs, architectures, flats, strict=True)
                    ]
                ).sum()
                gradients = torch.autograd.grad(loss, flats)
                with torch.no_grad():
                    for flat, m, v, g in zip(flats, first, second, gradients, strict=True):
                        m.lerp_(g, 1.0 - BETA_1)
                        v.mul_(BETA_2).addcmul_(g, g, value=1.0 - BETA_2)
                        scale = (1.0 - BETA_2**step) ** 0.5
                        flat.addcdiv_(
                            m, v.sqrt().add_(EPSILON * scale), value=-rate * scale / (1.0 - BETA_1**step)
                        )
            with torch.no_grad():
                for i, (run, a, flat) in enumerate(zip(runs, architectures, flats, strict=True)):
                    losses[0, i, :, epoch] = _error(run, a, flat, X, Y).numpy()
                    losses[1, i, :, epoch] = _error(run, a, flat, Xv, Yv).numpy()
    return [
        Trained(a, f.detach().numpy().astype(float), losses[0, i], losses[1, i])
        for i, (a, f) in enumerate(zip(architectures, flats, strict=True))
    ]


def train_seeds(
    architecture: Architecture,
    training: tuple[Floats, Floats],
    validation: tuple[Floats, Floats],
    schedule: Schedule,
    seeds: Sequence[int],
    forward: Callable[[Architecture], Forward] | None = None,
) -> Trained:
    """`train` one architecture with several seeds on the same rows: inputs (n, inputs), targets (n, 3)."""
    first, second = (
        Rows(*(np.repeat(a[None], len(seeds), axis=0) for a in part)) for part in (training, validation)
    )
    (trained,) = train([architecture], first, second, schedule, seeds, forward)
    return trained


def stacked_forward(architecture: Architecture) -> Forward:
    """Outputs (S, n, 3) of weights (S, ..) and inputs (S, n, inputs), as `Architecture.forward`."""
    stages = [(s, torch.from_numpy(s.index)) for s in architecture.stages]

    def run(weights: Sequence[tuple[Tensor, Tensor]], x: Tensor) -> Tensor:
        left = iter(weights)
        for number, (stage, index) in enumerate(stages):
            sets, n = x.shape[:2]
            if isinstance(stage.layer, Pooling):
                x = x[:, :, index].mean(dim=-1)
                continue
            W, b = next(left)
            if len(index) > 1:
                patches = x[:, :, index].reshape(sets, n * len(index), -1)
                x = torch.baddbmm(b[:, None], patches, W).reshape(sets, n, -1)
            else:
                x = torch.baddbmm(b[:, None], x, W)
            if number < len(stages) - 1:
                x = torch.tanh(x)
        return x

    return run


def _error(run: Forward, architecture: Architecture, flat: Tensor, x: Tensor, y: Tensor) -> Tensor:
    """Mean squared errors (S,), paper eq. 46."""
    return (run(_unpack(architecture, flat), x) - y).square().mean(dim=(1, 2))


def _unpack(architecture: Architecture, flat: Tensor) -> list[tuple[Tensor, Tensor]]:
    shapes = architecture.shapes
    parts = torch.split(flat, [size for r, c in shapes for size in (r * c, c)], dim=1)
    return [
        (W.reshape(len(flat), r, c), b) for (r, c), W, b in zip(shapes, parts[::2], parts[1::2], strict=True)
    ]


def _start(architecture: Architecture, seeds: Sequence[int], dtype: torch.dtype) -> Tensor:
    """Glorot's uniform weights, zero biases (the defaults of TensorFlow)."""
    flat = np.zeros((len(seeds), architecture.parameters))
    for row, seed in enumerate(seeds):
        rng, at = np.random.default_rng([seed, 0]), 0
        for stage in architecture.stages:
            if stage.weights is None:
                continue
            fan_in, fan_out = stage.weights
            # Glorot counts the whole receptive field on both sides; a dense layer has one position.
            field = fan_in // _channels(stage) if len(stage.index) > 1 else 1
            limit = np.sqrt(6.0 / (fan_in + fan_out * field))
            flat[row, at : at + fan_in * fan_out] = rng.uniform(-limit, limit, fan_in * fan_out)
            at += (fan_in + 1) * fan_out
    return torch.from_numpy(flat).to(dtype).requires_grad_(True)


def _channels(stage: Stage) -> int:
    """Channels of the image that a convolution reads."""
    assert isinstance(stage.layer, Convolution)
    return stage.index.shape[1] // stage.layer.size**2


@contextmanager
def _one_thread() -> Iterator[None]:
    """One thread: the products are too small for more, and their sums then always have one order."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)
