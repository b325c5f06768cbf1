r"""Moments for wanted tip poses, without a model: Levenberg-Marquardt on ANCF by its exact sensitivities.

With the pose p(M) of the equilibrium in units (position over L, gradients as they are) and the wanted p*,

    minimise |p(M) - p*|^2,   (J^T J + lambda diag(J^T J)) dM = -J^T (p(M) - p*),   J = -P_q K^-1 dg/dM,

lambda = 0 at first: a Gauss-Newton step. It grows where a step does not bring the pose nearer or finds no
equilibrium, and returns to 0. The start is the closed form of the thin arm (helix.py) or any other guess,
such as a surrogate's.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NoReturn

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancf.batch import BatchSolution
from ancf.errors import InputError, Message
from ancf.rotation import log
from ancf.sensitivity import sensitivity
from surrogate.arm import Arm
from surrogate.helix import helix_inverses, section_axes

Floats = NDArray[np.float64]

# A step of E I/L times this ends the search: the pose then moves by less than the solver's tolerance.
TOLERANCE = 1e-9
# Relative fall of |p - p*|^2 below which a pose that cannot be met has been approached as far as it goes.
FLAT = 1e-10
FIRST_DAMPING, DAMPING_FACTOR, MOST_DAMPING = 1e-3, 10.0, 1e8
MOST_STEPS = 40
# No step turns the tip by more than this [rad]: beyond, the linear pose says nothing.
LONGEST_STEP = 1.5
# A pose is reachable when the arm comes this near: of the length, and [rad].
REACH_POSITION, REACH_ROTATION = 1e-3, 5e-3
# A number of a pose beyond this is as good as infinite: its square may overflow.
TOO_LARGE = 1e100
# Slack of the bounds of the moments, of their size.
BOUND_SLACK = 1e-6


@dataclass(frozen=True, eq=False)
class Inverse:
    """Moments found for wanted poses, and how near the arm comes to them."""

    moments: Floats  # (B, 3) N m, in the frame of the scene's moment
    poses: Floats  # (B, 3, 4) of these moments
    converged: NDArray[np.bool_]  # (B,) the search has ended
    position_mismatch: Floats  # (B,) m, between the poses and the wanted ones
    rotation_mismatch: Floats  # (B,) rad, of the sections
    within_bounds: NDArray[np.bool_]  # (B,)
    steps: NDArray[np.intp]  # (B,) steps taken
    solves: NDArray[np.intp]  # (B,) equilibria solved
    reach_position: float  # m
    reach_rotation: float  # rad

    @property
    def reachable(self) -> NDArray[np.bool_]:
        """(B,) the search has ended at the wanted pose, with moments inside the bounds."""
        near = (self.position_mismatch <= self.reach_position) & (
            self.rotation_mismatch <= self.reach_rotation
        )
        return self.converged & near & self.within_bounds

    def score(self) -> Floats:
        """How far (B,) the arm stays away, in units of what counts as reached; grows out of the workspace."""
        return np.maximum(
            self.position_mismatch / self.reach_position, self.rotation_mismatch / self.reach_rotation
        )

    def reason(self, row: int) -> str:
        """Why a pose is not reachable, in one sentence; empty if it is."""
        if self.reachable[row]:
            return ""
        if not self.converged[row]:
            return f"the search did not end in {self.steps[row]} steps"
        if not self.within_bounds[row]:
            return "the moments it needs are outside the bounds"
        return (
            f"the arm stays {self.position_mismatch[row]:.3g} m and {self.rotation_mismatch[row]:.3g} rad"
            f" away, more than {self.reach_position:.3g} m or {self.reach_rotation:.3g} rad"
        )


def check_poses(poses: ArrayLike) -> Floats:
    """Poses (B, 3, 4) of one pose or many; raises `InputError` unless they are finite and of that shape.

    Also refused: gradients r_y, r_z that do not span a section.
    """
    try:
        values = np.asarray(poses, dtype=float)
    except (TypeError, ValueError, OverflowError) as error:
        _refuse("The pose is not a table of numbers.", "pose", str(error))
    if values.ndim == 2:
        values = values[None]
    if values.ndim != 3 or values.shape[1:] != (3, 4) or len(values) == 0:
        _refuse(
            "The pose has the wrong shape.", "pose", f"shape {np.shape(poses)}, must be (3, 4) or (n, 3, 4)"
        )
    bad = np.flatnonzero(~(np.abs(values) < TOO_LARGE).all(axis=(1, 2)))
    if len(bad):
        _refuse(
            "The pose is not finite.", f"pose {bad[0]}",
            f"{len(bad)} of {len(values)} poses; all numbers must be below {TOO_LARGE:g}",
        )  # fmt: skip
    across = np.linalg.norm(np.cross(values[:, :, 2], values[:, :, 3]), axis=1)
    flat = np.flatnonzero(~((across > 1e-6) & (across < 1e6)))
    if len(flat):
        _refuse(
            "The gradients of the pose span no section.",
            f"pose {flat[0]}",
            f"|r_y x r_z| = {across[flat[0]]:.3g}, must be near 1",
        )
    return values


def pose_mismatch(arm: Arm, poses: Floats, wanted: Floats) -> tuple[Floats, Floats]:
    """Distances (B,) [m] of the tips and angles (B,) [rad] between the sections of poses (B, 3, 4)."""
    away = np.linalg.norm(poses[..., 0] - wanted[..., 0], axis=-1)
    turn = np.swapaxes(_sections(arm.body_poses(wanted)), 1, 2) @ _sections(arm.body_poses(poses))
    return away, np.linalg.norm(log(turn), axis=-1)


def closed_form(arm: Arm, wanted: Floats) -> Floats:
    """Moments (B, 3) [N m] of the thin arm for wanted poses (B, 3, 4); no equilibrium is solved."""
    v, _, _ = helix_inverses(arm.body_poses(wanted), arm.twist_ratio)
    return arm.moments(v)


def gauss_newton(arm: Arm, wanted: Floats, guess: Floats, steps: int = 1) -> Floats:
    """Moments (B, 3) [N m] after plain Gauss-Newton steps from a guess; rows without equilibrium stay."""
    moments = np.array(guess, dtype=float)
    for _ in range(steps):
        found = arm.solve(moments)
        for row in np.flatnonzero(found.status == "converged"):
            J, gap = _linear(arm, found, int(row), wanted[row])
            moments[row] -= arm.unit * np.linalg.lstsq(J, gap, rcond=None)[0]
    return moments


def exact_inverse(
    arm: Arm,
    wanted: ArrayLike,
    *,
    guess: ArrayLike | None = None,
    bounds: ArrayLike | None = None,
    reach: tuple[float, float] = (REACH_POSITION, REACH_ROTATION),
    most_steps: int = MOST_STEPS,
) -> Inverse:
    """Moments at the tip for wanted poses, by Levenberg-Marquardt on ANCF.

    Parameters
    ----------
    wanted : (3, 4) or (B, 3, 4) [m, -], columns r, r_x, r_y, r_z in SCS
    guess : (B, 3) [N m] to begin from; None: the closed form of the thin arm
    bounds : (3, 2) [N m] lowest and highest moments that count as possible; they do not confine the search
    reach : what counts as reached: position over L, rotation [rad]
    most_steps : after which a row is given up

    Raises
    ------
    InputError : poses that are not finite or not 3 x 4.

    Notes
    -----
    Quadratic where the pose can be met: three steps from the closed form, each 1.3 ms for 12 elements and a
    solved equilibrium.
    """
    wanted = check_poses(wanted)
    rows = len(wanted)
    moments = closed_form(arm, wanted) if guess is None else np.array(guess, dtype=float).reshape(rows, 3)
    found = arm.solve(moments)
    for row in np.flatnonzero(found.status != "converged"):  # a guess beyond what the arm can bear
        moments[row] = 0.0
    if (found.status != "converged").any():
        found = arm.solve(moments)
    poses = found.poses.copy()
    cost = _cost(arm, poses, wanted)
    damping, ended = np.zeros(rows), np.zeros(rows, bool)
    steps, solves = np.zeros(rows, np.intp), np.ones(rows, np.intp)
    # Equilibrium and Jacobian of each row; a row keeps its own until a step is accepted.
    linear = {row: _linear(arm, found, row, wanted[row]) for row in range(rows)}
    for _ in range(most_steps):
        going = np.flatnonzero(~ended)
        if not len(going):
            break
        trial = moments[going].copy()
        size = np.empty(len(going))
        for place, row in enumerate(map(int, going)):
            step = _step(*linear[row], damping[row])
            size[place] = np.abs(step).max()
            trial[place] += arm.unit * step
        tried = arm.solve(trial)
        steps[going] += 1
        solves[going] += 1
        new_cost = np.where(tried.status == "converged", _cost(arm, tried.poses, wanted[going]), np.inf)
        for place, row in enumerate(map(int, going)):
            settled = size[place] <= TOLERANCE
            if new_cost[place] <= cost[row]:
                flat = cost[row] - new_cost[place] <= FLAT * cost[row] and damping[row] == 0.0
                moments[row], poses[row], cost[row] = trial[place], tried.poses[place], new_cost[place]
                ended[row] = settled or flat
                damping[row] = 0.0 if damping[row] <= FIRST_DAMPING else damping[row] / DAMPING_FACTOR
                if not ended[row]:
                    linear[row] = _linear(arm, tried, place, wanted[row])
            else:
                # At the bottom rounding decides whether a step is down: a tiny one has arrived.
                ended[row] = settled or damping[row] >= MOST_DAMPING
                damping[row] = max(FIRST_DAMPING, damping[row] * DAMPING_FACTOR)
    away, turned = pose_mismatch(arm, poses, wanted)
    return Inverse(
        moments, poses, ended, away, turned, _inside(moments, bounds), steps, solves,
        reach[0] * arm.length, reach[1],
    )  # fmt: skip


def _linear(arm: Arm, found: BatchSolution, row: int, wanted: Floats) -> tuple[Floats, Floats]:
    """J (12, 3) per unit moment and p - p* (12,) of a row of a batch."""
    model = found.loads.under(found.model, row)
    J = arm.unit * sensitivity(model, found.q[row], found.load_factor[row], "moment", found.rod)
    gap = (found.poses[row] - wanted).T.ravel()
    J[:3] /= arm.length
    gap[:3] /= arm.length
    return J, gap


def _step(J: Floats, gap: Floats, damping: float) -> Floats:
    """Dimensionless step of the moments (3,), no longer than `LONGEST_STEP`."""
    if damping == 0.0:
        step = -np.linalg.lstsq(J, gap, rcond=None)[0]
    else:
        normal = J.T @ J
        step = -np.linalg.solve(normal + damping * np.diag(np.diag(normal)), J.T @ gap)
    return np.asarray(step, dtype=float) * min(1.0, LONGEST_STEP / max(float(np.linalg.norm(step)), 1e-300))


def _cost(arm: Arm, poses: Floats, wanted: Floats) -> Floats:
    gap = poses - wanted
    gap[..., 0] /= arm.length
    return np.einsum("bij,bij->b", gap, gap)


def _sections(body_poses: Floats) -> Floats:
    """Section rotations (B, 3, 3) of poses (B, 3, 4)."""
    axes = [section_axes(d_y, d_z) for _, _, d_y, d_z in np.swapaxes(body_poses, 1, 2).tolist()]
    return np.swapaxes(np.array(axes), 1, 2)


def _inside(moments: Floats, bounds: ArrayLike | None) -> NDArray[np.bool_]:
    if bounds is None:
        return np.ones(len(moments), bool)
    low, high = np.asarray(bounds, dtype=float).T
    slack = BOUND_SLACK * np.maximum(np.abs(low), np.abs(high))
    return ((moments >= low - slack) & (moments <= high + slack)).all(axis=1)


def _refuse(what: str, where: str, value: str) -> NoReturn:
    raise InputError(
        Message(
            what,
            where,
            value,
            "a wrong file, or a pose written row by row in another order",
            "give 3 rows of 4 numbers: columns r [m], r_x, r_y, r_z in structure axes",
        )
    )
