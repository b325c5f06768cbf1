r"""Rotational springs on sections of a rod, of one place or spread along it.

    V = sum w/2 theta . k theta,   m = -L^T k theta,   theta = Log(R),

R the polar rotation of the section against its reference, k [N m/rad] in SCS, per length where the weights w
are lengths, and L the rate of theta with the spin (rotation_vector.py). k and the ground do not turn with
the rod: its axes are those of the reference.

theta is the shorter way round, so that the springs are known below half a turn, and a state that they would
take for less than it is has to be told: a section that has been turned once round seems not to be turned at
all. `turns` follows the rotation along the rod from where it is clamped, as it came about.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.joint_closing import nearest_turn
from ancf.rod_model import RodModel
from ancf.rod_shape import node_rotations
from ancf.rotation import hat, log
from ancf.rotation_vector import spring_moment, spring_moment_change
from ancf.section_couples import SectionCouples
from ancf.section_spin import SectionAxes

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

MOST_TURN = 3.0  # rad; a little less than half a turn, where the sense of theta is lost


class TurningSprings(SectionCouples):
    """Rotational springs on sections; blocks are elements.

    Parameters
    ----------
    dofs, N, W, weight : see `SectionCouples`; the weights 1 for springs of one place
    k : (m, points, 3, 3) stiffness [N m/rad] in SCS, per length where the weights are lengths
    """

    name = "spring"
    passive = True

    def __init__(
        self, model: RodModel, dofs: Indices, N: Floats, W: Floats, weight: Floats, k: Floats
    ) -> None:
        super().__init__(dofs, N, W, weight)
        self.model = model
        self.k = np.broadcast_to(k, (*weight.shape, 3, 3)).reshape(-1, 3, 3)

    def _theta(self, axes: SectionAxes) -> Floats:
        return log(axes.rotation(self.E))

    def couple(self, axes: SectionAxes) -> Floats:
        """See `SectionCouples.couple`."""
        m = spring_moment(self._theta(axes), self.k)
        return self.weight * (axes.rows @ m[..., None])[..., 0].T

    def couple_change(self, axes: SectionAxes, M: Floats) -> Floats:
        """See `SectionCouples.couple_change`: that of the moment in space, seen from axes that turn."""
        D = spring_moment_change(self._theta(axes), self.k)
        in_axes = axes.rows @ D @ np.swapaxes(axes.rows, -1, -2)
        return self.weight[:, None, None] * in_axes + hat(M.T)

    def potential(self, e: Floats) -> float:
        """See `Effect.potential`."""
        theta = self._theta(self.axes(e))
        return 0.5 * float(self.weight @ np.sum(theta * (self.k @ theta[..., None])[..., 0], axis=1))

    def rotation_vectors(self, e: Floats) -> Floats:
        """theta (m, points, 3) [rad] at the nodal vectors e (m, nodal, 3)."""
        return self._theta(self.axes(e)).reshape(len(self.dofs), -1, 3)

    def moment(self, e: Floats) -> Floats:
        """Sum (3,) [N m] of what the springs exert on the rod."""
        return self.weight @ spring_moment(self._theta(self.axes(e)), self.k)

    def turns(self, q: Floats) -> Floats:
        """Angles (m, points) [rad] of the sections at q (n,), as they came about."""
        nodes = _followed(self.model, q)
        first = (self.dofs[:, 0] - self.model.first_dof) // (3 * len(self.model.element.vectors))
        found = self.rotation_vectors(q[self.dofs].reshape(len(self.dofs), -1, 3))
        turned = [[nearest_turn(one, nodes[i]) for one in row] for i, row in zip(first, found, strict=True)]
        return np.linalg.norm(turned, axis=-1)

    def is_known(self, q: Floats) -> bool:
        """See `Effect.is_known`."""
        return bool(np.max(self.turns(q), initial=0.0) <= MOST_TURN)


def _followed(model: RodModel, q: Floats) -> Floats:
    """Rotation vectors (n_nodes, 3) [rad] of the nodes, each by whole turns nearest to the one before."""
    found = log(node_rotations(model, model.nodal(q)))
    start = 0 if model.rod.clamp is None else model.node_at(model.rod.clamp.at)
    for i in range(start + 1, len(found)):
        found[i] = nearest_turn(found[i], found[i - 1])
    for i in range(start - 1, -1, -1):
        found[i] = nearest_turn(found[i], found[i + 1])
    return found
