r"""A small network on what the closed form leaves, with the symmetry of the round arm built in.

Symbols
-------
e            the x axis of the body
v = tau e + v_t    closed form of the thin arm for the pose (helix.py), beta = |v_t|
d            what is missing: M L/(E I) - v, of second order in (curvature x radius)

A round arm knows no direction across e and no handedness. Turning the world about e turns d with v, and a
mirror through e changes the signs of tau and of the axial vector v_t across it, so

    d = tau h_0 e + h_1 v_t + tau h_2 e x v_t,     h = h(tau^2, beta^2):

three smooth functions of two invariants, a perceptron of two hidden layers. The symmetry holds exactly,
whatever the weights.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surrogate.architecture import Architecture, Dense
from surrogate.arm import Arm
from surrogate.helix import helix_inverse, helix_inverses
from surrogate.networks import NetworkFit
from surrogate.problem import Problem, Samples

if TYPE_CHECKING:
    import torch  # pyright: ignore[reportMissingImports]

Floats = NDArray[np.float64]

RESIDUAL_MLP = Architecture("equivariant residual MLP", (Dense(24), Dense(24), Dense(3)), inputs=2)
EPOCHS, BATCH, RATE, DECAY = 400, 64, 1e-2, 1e-3


@dataclass(frozen=True, eq=False)
class EquivariantNetwork:
    """Closed form plus a learned residual; metres in, newton metres out, without torch."""

    arm: Arm
    flat: Floats  # (parameters,)
    largest: Floats  # (2,) of tau^2 and beta^2 in the training rows
    scale: float  # of d
    architecture: Architecture = RESIDUAL_MLP

    @cached_property
    def weights(self) -> list[tuple[Floats, Floats]]:
        """W, b of the layers."""
        return self.architecture.unpack(self.flat)

    @cached_property
    def _frame(self) -> tuple[Floats, Floats, float]:
        """Rotation to body axes over its scales, base, and L: what `_one` needs, made once."""
        return self.arm.rod.base.rotation.T, self.arm.rod.base.position, self.arm.length

    def predict(self, poses: Floats) -> Floats:
        """Moments (n, 3) [N m] of poses (n, 3, 4) [m, -]; one pose (3, 4) gives (3,)."""
        if np.ndim(poses) == 2:
            return self._one(poses)
        v, _, _ = helix_inverses(self.arm.body_poses(poses), self.arm.twist_ratio)
        x = inputs(v, self.largest)
        h = self.scale * self.architecture.forward(self.weights, x[:, :2])
        return self.arm.moments(v + combined(h, x))

    def _one(self, pose: Floats) -> Floats:
        """`predict` of one pose, with few array calls."""
        A_T, base, length = self._frame
        body = A_T @ pose
        r = A_T @ (pose[:, 0] - base) / length
        answer = helix_inverse(
            tuple(r.tolist()), tuple(body[:, 2].tolist()), tuple(body[:, 3].tolist()), self.arm.twist_ratio
        )
        tau, y, z = answer.v
        a, b = self.largest
        s = np.array((2.0 * tau * tau / a - 1.0, 2.0 * (y * y + z * z) / b - 1.0))
        h_0, h_1, h_2 = (self.scale * self.architecture.forward(self.weights, s)).tolist()
        across = 1.0 + h_1
        v = (tau * (1.0 + h_0), across * y - tau * h_2 * z, across * z + tau * h_2 * y)
        return self.arm.moments(np.array(v))


def inputs(v: Floats, largest: Floats) -> Floats:
    """Rows (n, 5): the two invariants, scaled to [-1, 1], and v itself."""
    tau2, beta2 = v[:, 0] ** 2, v[:, 1] ** 2 + v[:, 2] ** 2
    return np.column_stack([2.0 * tau2 / largest[0] - 1.0, 2.0 * beta2 / largest[1] - 1.0, v])


def combined(h: Floats, x: Floats) -> Floats:
    """The residual d (n, 3) of h (n, 3) and inputs x (n, 5)."""
    (h_0, h_1, h_2), (tau, y, z) = h.T, x[:, 2:].T
    return np.column_stack([tau * h_0, h_1 * y - tau * h_2 * z, h_1 * z + tau * h_2 * y])


def fit_equivariant(
    problem: Problem, seeds: Sequence[int], epochs: int = EPOCHS
) -> NetworkFit[EquivariantNetwork]:
    """Networks of several seeds, trained at once; their losses are in units of `scale`^2."""
    from surrogate.training import Schedule, train_seeds

    arm = problem.arm
    v, d = _residual(arm, problem.train)
    largest = np.maximum([np.max(v[:, 0] ** 2), np.max(v[:, 1] ** 2 + v[:, 2] ** 2)], 1e-12)
    scale = float(np.sqrt(np.mean(d**2)) / np.sqrt(np.mean(v**2))) or 1.0

    def rows(v: Floats, d: Floats) -> tuple[Floats, Floats]:
        return inputs(v, largest), d / scale

    validation = rows(*_residual(arm, problem.validation))
    schedule = Schedule(epochs, BATCH, RATE, DECAY, double=True)
    trained = train_seeds(RESIDUAL_MLP, rows(v, d), validation, schedule, seeds, _stacked)
    networks = [EquivariantNetwork(arm, flat, largest, scale) for flat in trained.flat]
    return NetworkFit(networks, trained.training_loss, trained.validation_loss)


def _residual(arm: Arm, samples: Samples) -> tuple[Floats, Floats]:
    v, _, _ = helix_inverses(arm.body_poses(samples.poses), arm.twist_ratio)
    return v, arm.body_moments(samples.moments) - v


def _stacked(architecture: Architecture) -> Any:
    """`Architecture.forward` on the invariants, then `combined`, for stacked weights."""
    import torch  # pyright: ignore[reportMissingImports]

    from surrogate.training import stacked_forward

    run = stacked_forward(architecture)

    def whole(weights: Sequence[tuple[torch.Tensor, torch.Tensor]], x: torch.Tensor) -> torch.Tensor:
        h, (tau, y, z) = run(weights, x[..., :2]), x[..., 2:].unbind(-1)
        h_0, h_1, h_2 = h.unbind(-1)
        return torch.stack([tau * h_0, h_1 * y - tau * h_2 * z, h_1 * z + tau * h_2 * y], dim=-1)

    return whole
