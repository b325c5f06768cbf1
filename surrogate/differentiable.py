"""Tip poses of a scene as a differentiable torch operation of its loads: forward a batch, backward exact.

The derivative of a pose by the loads comes from the tangent at the equilibrium (ancf.sensitivity), so that a
network may be trained through the solver, or a pose be sought by gradients.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import torch  # pyright: ignore[reportMissingImports]

import ancf

if TYPE_CHECKING:
    from ancf.batch import BatchSolution
    from ancf.scene import Scene


class UnsolvedRowsError(RuntimeError):
    """Rows of the batch have no equilibrium; `rows` lists them, `solution` is the whole batch."""

    def __init__(self, rows: list[int], solution: BatchSolution) -> None:
        first = rows[0]
        super().__init__(
            f"{len(rows)} rows have no equilibrium, the first is {first}: {solution.reason[first]}"
        )
        self.rows = rows
        self.solution = solution


def tip_poses(scene: Scene, loads: torch.Tensor, kind: str = "moment") -> torch.Tensor:
    """Tip poses (B, 3, 4), columns r, r_x, r_y, r_z, of the values (B, 3) of the first load of a kind.

    Parameters
    ----------
    loads : (B, 3) [N m] or [N] in the frame of the load; any floating dtype, solved in float64
    kind : "moment" or "force"

    Raises
    ------
    UnsolvedRowsError : a row has no equilibrium. InputError : as `ancf.solve_batch`.

    Notes
    -----
    dL/dload = (dP/dload)^T dL/dP with dP/dload = -P_q K^-1 dg/dload; second derivatives are not defined.
    """
    poses = _TipPoses.apply(loads, scene, kind)
    assert isinstance(poses, torch.Tensor)
    return poses


class _TipPoses(torch.autograd.Function):
    @staticmethod
    def forward(ctx: Any, loads: torch.Tensor, scene: Scene, kind: str) -> torch.Tensor:
        values = loads.detach().to("cpu", torch.float64).numpy()
        moments, forces = (values, None) if kind == "moment" else (None, values)
        batch = ancf.solve_batch(scene, moments, forces=forces)
        bad = [row for row, status in enumerate(batch.status) if status != "converged"]
        if bad:
            raise UnsolvedRowsError(bad, batch)
        ctx.batch, ctx.kind = batch, kind
        return torch.from_numpy(batch.poses).to(loads)

    @staticmethod
    @torch.autograd.function.once_differentiable
    def backward(ctx: Any, *gradients: torch.Tensor) -> tuple[torch.Tensor, None, None]:
        (gradient,) = gradients
        derivative = torch.from_numpy(ctx.batch.sensitivity(ctx.kind))  # (B, 12, 3)
        by_pose = gradient.detach().to("cpu", torch.float64).transpose(1, 2).reshape(len(gradient), 12, 1)
        return (derivative * by_pose).sum(dim=1).to(gradient), None, None
