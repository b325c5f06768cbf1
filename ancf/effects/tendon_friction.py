r"""Tendons with friction: the tension falls along the path by the capstan law.

A tendon that is pulled at the first point of its path slides towards it, and friction with the coefficient mu
takes from the tension as it turns (Euler, Eytelwein; quasi-static pulling, no reversal),

    T(s) = T exp(-mu theta(s)),   Q = -int T(s) a t^T dx,

theta(s) the turning of the tangent t from the first point to s, the kinks of the path among it. It is the sum
of the angles between the tangents at neighbouring integration points, and on both sides of a kink; exact
where the path bends in a plane to one side. Q has no potential, and the tension at a point depends on all
nodal vectors before it:

    dQ/de = -int T(s) (d2l/de2 of ds) + mu int T(s) a t^T (x) dtheta(s)/de dx,

one block over the whole path, not symmetric; its size is the square of the number of unknowns on the path.
Where two neighbours are parallel the angle has no derivative; zero stands for it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.effects import without_potential
from ancf.effects.tendon import PulledTendon
from ancf.rod_model import RodModel
from ancf.scene import Tendon

Floats = NDArray[np.float64]

PARALLEL = 1e-9  # rad below which an angle counts as none


class RubbingTendon(PulledTendon):
    """A tendon of given tension with friction, pulled at the first point of its path."""

    coupled = True

    def __init__(self, model: RodModel, tendon: Tendon) -> None:
        super().__init__(model, tendon)
        self.friction = tendon.friction
        unknowns = np.unique(self.path.dofs)
        self.dofs = unknowns[None]
        self.places = np.searchsorted(unknowns, self.path.dofs)  # (m, nd), of the pieces in the block
        # Weights of the tangents in order: at the first point, points of integration and the last one, and
        # on both sides of a kink of the path, which is not to be cut short.
        along, piece_of, inner = [], [], []
        count = len(self.path.a)
        for piece in range(count):
            if self.path.starts[piece]:
                along.append(self.path.ends[piece, 0])
            inner.append(len(along) + np.arange(self.path.a.shape[1]))
            along += list(self.path.a[piece])
            if piece == count - 1 or self.path.starts[piece + 1]:
                along.append(self.path.ends[piece, 1])
            piece_of += [piece] * (len(along) - len(piece_of))
        self.along, self.piece_of = np.array(along), np.array(piece_of)
        self.inner = np.concatenate(inner)  # which are points of integration

    def _pieces(self, e: Floats) -> Floats:
        """Nodal vectors (m, nodal, 3) of the pieces from those of the block e (1, nodes, 3)."""
        return e.ravel()[self.places].reshape(len(self.places), -1, 3)

    def length(self, e: Floats) -> float:
        """See `PulledTendon.length`."""
        return self.path.length(self._pieces(e))

    def _turning(self, pieces: Floats) -> tuple[Floats, Floats]:
        """c' (k, 3) at the k points of `along`, and the angle (k,) from the one before, 0 first."""
        c = np.einsum("kn,kna->ka", self.along, pieces[self.piece_of])
        t = c / np.linalg.norm(c, axis=1, keepdims=True)
        apart, together = (np.linalg.norm(t[1:] + s * t[:-1], axis=1) for s in (-1.0, 1.0))
        return c, np.concatenate([[0.0], 2.0 * np.arctan2(apart, together)])

    def shares(self, e: Floats) -> Floats:
        """T(s)/T (k,) at the k points of `along`, from the first of the path to its last."""
        _, angle = self._turning(self._pieces(e))
        return np.asarray(np.exp(-self.friction * np.cumsum(angle)), dtype=float)

    def end_share(self, e: Floats) -> float:
        """See `PulledTendon.end_share`."""
        return float(self.shares(e)[-1])

    def _inner(self, shares: Floats) -> Floats:
        """Those at the points of integration (m, points)."""
        return shares[self.inner].reshape(self.path.weight.shape)

    def force(self, e: Floats) -> Floats:
        """See `Effect.force`."""
        slope = self.path.slope(self._pieces(e), self._inner(self.shares(e)))
        total = np.bincount(self.places.ravel(), slope.ravel())
        return -self.tension * np.asarray(total, dtype=float).reshape(e.shape)

    def force_and_tangent(self, e: Floats) -> tuple[Floats, Floats]:
        """See `Effect.force_and_tangent`; K (1, nd, nd)."""
        pieces, shares = self._pieces(e), self.shares(e)
        size = self.dofs.size
        K = np.zeros((size, size))
        bend = self.path.bend(pieces, self._inner(shares))
        np.add.at(K, (self.places[:, :, None], self.places[:, None, :]), -self.tension * bend)
        pull = np.zeros((len(self.inner), size))  # of each point, dl/de
        t, _ = self.path.tangents(pieces)
        each = np.einsum("mp,mpn,mpa->mpna", self.path.weight, self.path.a, t)
        inner = self.places[self.piece_of[self.inner]]
        np.add.at(pull, (np.arange(len(pull))[:, None], inner), each.reshape(len(pull), -1))
        turned = np.cumsum(self._turning_rates(pieces), axis=0)[self.inner]
        K += self.tension * self.friction * (shares[self.inner, None] * pull).T @ turned
        return self.force(e), K[None]

    def _turning_rates(self, pieces: Floats) -> Floats:
        """Derivative (k, nd) of the angles of `_turning` by the unknowns of the block."""
        c, angle = self._turning(pieces)
        stretch = np.linalg.norm(c, axis=1, keepdims=True)
        t = c / stretch
        rates = np.zeros((len(c), self.dofs.size))
        for one, other in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
            # dphi = -n . dt, n the unit vector across t towards the other tangent; dt across t is dc'/|c'|.
            away = t[other] - np.sum(t[other] * t[one], axis=1, keepdims=True) * t[one]
            norm = np.linalg.norm(away, axis=1, keepdims=True)
            n = np.where(angle[1:, None] > PARALLEL, away / np.maximum(norm, PARALLEL), 0.0)
            each = -self.along[one][:, :, None] * (n / stretch[one])[:, None, :]
            rows = np.arange(1, len(c))[:, None]
            np.add.at(rates, (rows, self.places[self.piece_of[one]]), each.reshape(len(each), -1))
        return rates

    def potential(self, e: Floats) -> float | None:
        """See `Effect.potential`: friction has none."""
        return without_potential(self.tension)
