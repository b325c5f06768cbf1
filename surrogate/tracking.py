"""The reference trajectory followed by a model, in closed loop (paper sec. 4.2, fig. 9 and 10)."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surrogate.arm import Arm
from surrogate.evaluate import Spread
from surrogate.fit import AnyModel
from surrogate.inverse import exact_inverse, pose_mismatch
from surrogate.model_file import Loaded
from surrogate.trajectory import reference_trajectory, trajectory_moments

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Track:
    """Wanted poses, the moments of a model for them, and where ANCF ends with these."""

    arm: Arm
    wanted: Floats  # (n, 3, 4)
    moments: Floats  # (n, 3) N m
    poses: Floats  # (n, 3, 4)
    solved: NDArray[np.bool_]  # (n,)
    thin_moments: Floats  # (n, 3) N m, of the thin arm
    exact_moments: Floats  # (n, 3) N m, of the nearest pose that the arm has
    exact_poses: Floats  # (n, 3, 4)
    certificate: str

    @property
    def unsolved(self) -> int:
        """Rows whose moments have no equilibrium."""
        return int((~self.solved).sum())

    def as_dict(self) -> dict[str, Any]:
        """Plain data for JSON."""
        length = self.arm.length
        away, turned = pose_mismatch(self.arm, self.poses[self.solved], self.wanted[self.solved])
        exact, _ = pose_mismatch(self.arm, self.exact_poses, self.wanted)
        return {
            "certificate": self.certificate,
            "frame": self.arm.moment.frame,
            "unsolved": self.unsolved,
            "tip_percent": asdict(Spread.of(100.0 * away / length)),
            "angle_degrees": asdict(Spread.of(np.degrees(turned))),
            "exact_tip_percent": asdict(Spread.of(100.0 * exact / length)),
            "moments": self.moments.tolist(),
            "wanted": self.wanted.tolist(),
            "poses": self.poses.tolist(),
        }


def track(loaded: Loaded) -> Track:
    """`track_model` of a model from a folder."""
    return track_model(loaded.model, loaded.arm, loaded.bounds, loaded.record["certificate"])


def track_model(model: AnyModel, arm: Arm, bounds: Floats, certificate: str) -> Track:
    """Follow the trajectory as far as the moments of the training box bend the arm.

    The arc of constant curvature is the thin arm's; the nearest poses that the arm itself has, by the exact
    inverse, show how much of an error is the arm's thickness.
    """
    largest = arm.largest_bending(bounds)
    wanted = reference_trajectory(arm, largest)
    moments = model.predict(wanted)
    found = arm.solve(moments)
    exact = exact_inverse(arm, wanted)
    return Track(
        arm, wanted, moments, found.poses, found.status == "converged", trajectory_moments(arm, largest),
        exact.moments, exact.poses, certificate,
    )  # fmt: skip
