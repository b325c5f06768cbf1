r"""The path of a tendon with friction: what is left of the tension at each point, and what that pulls.

A tendon that is pulled at the first point of its path slides towards it, and friction with the coefficient mu
takes from the tension as it turns (Euler, Eytelwein; quasi-static pulling, no reversal),

    T(s) = T exp(-mu theta(s)),   P = int exp(-mu theta(s)) a t^T dx,

P the pull on the nodal vectors for T = 1, dl/de without friction, and theta(s) the turning of the tangent t
from the first point to s, the kinks of the path among it. It is the sum of the angles between the tangents at
neighbouring integration points, and on both sides of a kink; exact where the path bends in a plane to one
side. P has no potential, and the tension at a point depends on all nodal vectors before it:

    dP/de = int exp(-mu theta(s)) (d2l/de2 of ds) - mu int exp(-mu theta(s)) a t^T (x) dtheta(s)/de dx,

one block over the whole path, not symmetric; its size is the square of the number of unknowns on the path.
Where two neighbours are parallel the angle has no derivative; zero stands for it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancf.rod_model import RodModel
from ancf.tendon_path import TendonPath

Floats = NDArray[np.float64]

PARALLEL = 1e-9  # rad below which an angle counts as none


class CapstanPath(TendonPath):
    """A path with friction, pulled at its first point.

    Attributes
    ----------
    unknowns : (nd,) of the whole path, in order; `places` (m, nd of an element) of the pieces among them
    along : (k, nodal) weights of the tangents in order: at the first point, the points of integration and the
        last one, and on both sides of a kink of the path, which is not to be cut short
    piece_of : (k,) the piece of each
    inner : (m points,) which of them are points of integration
    """

    def __init__(self, model: RodModel, points: Floats, friction: float) -> None:
        super().__init__(model, points)
        self.friction = friction
        self.unknowns, places = np.unique(self.dofs, return_inverse=True)
        self.places = places.reshape(self.dofs.shape)
        along, piece_of, inner = [], [], []
        count = len(self.a)
        for piece in range(count):
            if self.starts[piece]:
                along.append(self.ends[piece, 0])
            inner.append(len(along) + np.arange(self.a.shape[1]))
            along += list(self.a[piece])
            if piece == count - 1 or self.starts[piece + 1]:
                along.append(self.ends[piece, 1])
            piece_of += [piece] * (len(along) - len(piece_of))
        self.along, self.piece_of = np.array(along), np.array(piece_of)
        self.inner = np.concatenate(inner)

    def _turning(self, e: Floats) -> tuple[Floats, Floats]:
        """c' (k, 3) at the k points of `along`, and the angle (k,) from the one before, 0 first."""
        c = np.einsum("kn,kna->ka", self.along, e[self.piece_of])
        t = c / np.linalg.norm(c, axis=1, keepdims=True)
        apart, together = (np.linalg.norm(t[1:] + s * t[:-1], axis=1) for s in (-1.0, 1.0))
        return c, np.concatenate([[0.0], 2.0 * np.arctan2(apart, together)])

    def shares(self, e: Floats) -> Floats:
        """T(s)/T (k,) at the k points of `along`, from the first of the path to its last."""
        _, angle = self._turning(e)
        return np.asarray(np.exp(-self.friction * np.cumsum(angle)), dtype=float)

    def end_share(self, e: Floats) -> float:
        """T(s)/T at the last point of the path."""
        return float(self.shares(e)[-1])

    def _inner(self, shares: Floats) -> Floats:
        """Those at the points of integration (m, points)."""
        return shares[self.inner].reshape(self.weight.shape)

    def pull(self, e: Floats) -> Floats:
        """P (m, nodal, 3) of the pieces, at the nodal vectors e (m, nodal, 3)."""
        return self.slope(e, self._inner(self.shares(e)))

    def pull_rate(self, e: Floats) -> Floats:
        """dP/de (nd, nd) by the unknowns of the path."""
        shares = self.shares(e)
        size = len(self.unknowns)
        K = np.zeros((size, size))
        bend = self.bend(e, self._inner(shares))
        np.add.at(K, (self.places[:, :, None], self.places[:, None, :]), bend)
        t, _ = self.tangents(e)
        each = np.einsum("mp,mpn,mpa->mpna", self.weight, self.a, t)
        pull = np.zeros((len(self.inner), size))  # of each point, dl/de
        inner = self.places[self.piece_of[self.inner]]
        np.add.at(pull, (np.arange(len(pull))[:, None], inner), each.reshape(len(pull), -1))
        turned = np.cumsum(self._turning_rates(e), axis=0)[self.inner]
        return K - self.friction * (shares[self.inner, None] * pull).T @ turned

    def _turning_rates(self, e: Floats) -> Floats:
        """Derivative (k, nd) of the angles of `_turning` by the unknowns of the path."""
        c, angle = self._turning(e)
        stretch = np.linalg.norm(c, axis=1, keepdims=True)
        t = c / stretch
        rates = np.zeros((len(c), len(self.unknowns)))
        for one, other in ((slice(1, None), slice(None, -1)), (slice(None, -1), slice(1, None))):
            # dphi = -n . dt, n the unit vector across t towards the other tangent; dt across t is dc'/|c'|.
            away = t[other] - np.sum(t[other] * t[one], axis=1, keepdims=True) * t[one]
            norm = np.linalg.norm(away, axis=1, keepdims=True)
            n = np.where(angle[1:, None] > PARALLEL, away / np.maximum(norm, PARALLEL), 0.0)
            each = -self.along[one][:, :, None] * (n / stretch[one])[:, None, :]
            rows = np.arange(1, len(c))[:, None]
            np.add.at(rates, (rows, self.places[self.piece_of[one]]), each.reshape(len(each), -1))
        return rates
