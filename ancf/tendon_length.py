r"""Tendons of controlled length: a drum takes in cable, and the tension is what that needs.

The path through the rod, of length l(e) and l_0 at the reference, may not be longer than the cable, which
comes to the wanted length L with the load factor f,

    l <= l_f = l_0 + f (L - l_0),   T >= 0,   T (l_f - l) = 0:

a tendon pulls or is slack. With one unknown m for both, the tension where it is positive and the slack (in
units of a compliance c, below) where it is negative (Robinson's normal map, Math. Oper. Res. 17 (1992) 691),

    T = max(m, 0),   l - l_f + c max(-m, 0) = 0,

are equations again. Newton's method keeps to one side of m = 0 for each tendon, the one on which it starts,
also where m crosses it. At the equilibrium that it comes to, tendons on the wrong side make it choose all
sides anew, by the linear problem above with the compliance of thin rods; of four tendons along a rod one is
slack, as only three lengths are independent. If that choice was tried, the first tendon on the wrong side
changes over alone, which comes to an end for linear equations of a positive definite compliance (Murty,
Linear Algebra Appl. 7 (1974) 109). A choice that comes again ends the step, which is cut (stepping.py).
Taking the side of m in every iteration instead goes back and forth: the axis of a slender rod is so stiff
that the tendons round it change over at the smallest error.

A taut tendon is the condition l = l_f with the multiplier T, symmetric, and the elements' blocks T d2l/de2
fit their band. A slack one acts on nothing: its column of the tangent is zero but for -c.

c is the compliance of the path of a straight rod, int 1/(E A) + (y^2 + z^2)/(E I) dx, I the smaller one.

With friction (tendon_rubbing_length.py) T is the tension at the pulled end, and less is left along the path.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ancf.constraints import Constraint, ConstraintTerms
from ancf.rod_model import RodModel
from ancf.scene import Rod, Scene, Tendon
from ancf.tendon_path import TendonPath

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

EPSILON = 1e-12  # of the trace: two tendons on one path are no condition more than one
COMPLIANCE_POINTS = 200  # of the trapezoidal rule for c, which only scales


def tendon_length(tendon: Tendon, rods: list[RodModel], first: int) -> TendonLength:
    """The constraint of one tendon of controlled length; its multiplier is the unknown `first`."""
    if tendon.friction > 0.0:
        from ancf.tendon_rubbing_length import RubbingTendonLength

        return RubbingTendonLength(tendon, rods, first)
    return TendonLength(tendon, rods, first)


class TendonLength(Constraint):
    """One tendon of controlled length."""

    name = "tendon"
    held_dofs = np.empty(0, dtype=np.intp)

    def __init__(self, tendon: Tendon, rods: list[RodModel], first: int) -> None:
        assert tendon.length is not None
        rod = next(model for model in rods if model.rod.name == tendon.rod)
        self.tendon = tendon
        self.path = self._path(rod)
        self.multipliers = np.array([first])
        self.dofs = np.append(self.path.dofs.ravel(), first)
        self.energy = rod.bending_stiffness / rod.rod.length
        self.gap_unit = np.array([rod.rod.length])
        self.l_0 = self.path.length(self._vectors(rod.q0.ravel()[self.dofs[:-1] - rod.first_dof]))
        self.change = tendon.length - self.l_0  # m, at load factor 1
        self.compliance = float(compliance(rod.rod, [tendon])[0, 0])  # m/N
        self.expected = 0.0  # N, estimate of m, see `estimated_multipliers`
        self.side: bool | None = None  # whether it is taken as taut; None: by the sign of m

    def _path(self, rod: RodModel) -> TendonPath:
        return TendonPath(rod, self.tendon.path)

    def _vectors(self, x: Floats) -> Floats:
        """Nodal vectors (m, nodal, 3) of the pieces of the path."""
        return x.reshape(len(self.path.dofs), -1, 3)

    @property
    def _blocks(self) -> Indices:
        """Unknowns (m, nd) of the blocks of `_pull`."""
        return self.path.dofs

    def _pull(self, e: Floats, slope: Floats) -> tuple[Floats, Floats]:
        """Pull of a unit tension on the pieces (m nd,), and the entries of its derivative in `_blocks`."""
        return slope, self.path.bend(e).ravel()

    @cached_property
    def rows(self) -> Indices:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Rows of the entries: the blocks of `_pull`, the pull as column, dl/de as row, the diagonal."""
        dofs, (first,) = self.path.dofs, self.multipliers
        blocks = np.repeat(self._blocks, self._blocks.shape[1], axis=1).ravel()
        return np.concatenate([blocks, dofs.ravel(), np.full(dofs.size, first), [first]])

    @cached_property
    def columns(self) -> Indices:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Columns of the entries."""
        dofs, (first,) = self.path.dofs, self.multipliers
        blocks = np.tile(self._blocks, self._blocks.shape[1]).ravel()
        return np.concatenate([blocks, np.full(dofs.size, first), dofs.ravel(), [first]])

    def terms(self, x: Floats, load_factor: float) -> ConstraintTerms:
        """See `Constraint.terms`."""
        e, m = self._vectors(x[:-1]), float(x[-1])
        g, rate = np.zeros(len(x)), np.zeros(len(x))
        g[-1] = self.path.length(e) - self.l_0 - load_factor * self.change
        rate[-1] = -self.change
        slope = self.path.slope(e).ravel()
        pull, pull_rate = self._pull(e, slope)
        if self.is_taut(m):
            g[:-1] = m * pull
            tangent = np.concatenate([m * pull_rate, pull, slope, [0.0]])
        else:
            g[-1] -= self.compliance * m
            tangent = np.concatenate([np.zeros(pull_rate.size + pull.size), slope, [-self.compliance]])
        return ConstraintTerms(g, rate, tangent)

    def is_taut(self, m: float) -> bool:
        """Whether the tendon is taken as taut."""
        return (m if m != 0.0 else self.expected) >= 0.0 if self.side is None else self.side

    def is_wrong(self, m: float, tolerance: float) -> bool:
        """Whether m lies on the other side than the one taken, by more than a tolerance in its unit."""
        return bool((-m if self.side else m) > tolerance * self.unit[0])

    def multiplier(self, q: Floats) -> float:
        """m [N] at the unknowns q (n,)."""
        return float(q[self.multipliers[0]])

    def tension(self, q: Floats) -> float:
        """Tension [N] at the unknowns q (n,)."""
        return max(self.multiplier(q), 0.0)

    def slack(self, q: Floats) -> float:
        """Length [m] by which the cable is longer than its path."""
        return self.compliance * max(-self.multiplier(q), 0.0)

    def end_tension(self, q: Floats) -> float:
        """Tension [N] at the last point of the path."""
        return self.tension(q)

    def length(self, q: Floats) -> float:
        """Length [m] of the path."""
        return self.path.length(self._vectors(q[self.dofs[:-1]]))


def estimated_multipliers(scene: Scene, controlled: list[TendonLength], q: Floats | None = None) -> Floats:
    """Unknowns m (k,) [N] of the tendons of controlled length by the linear theory of straight thin rods.

    On one rod the tensions T >= 0 minimise 1/2 T^T M T - need^T T, M the compliance of the paths: from the
    reference under the tendons of given tension and no other load, or about the equilibrium q (n,) for the
    sides that are taken there.
    """
    from scipy.optimize import nnls

    found = np.zeros(len(controlled))
    for name in {one.tendon.rod for one in controlled}:
        here = [index for index, one in enumerate(controlled) if one.tendon.rod == name]
        given = [t for t in scene.pulled_tendons if t.rod == name]
        M = compliance(scene.rod(name), [controlled[i].tendon for i in here] + given)
        k = len(here)
        if q is None:
            pulls = np.array([t.tension for t in given], float)
            need = -np.array([controlled[i].change for i in here]) - M[:k, k:] @ pulls
        else:
            m = np.array([q[controlled[i].multipliers[0]] for i in here])
            taut = np.array([controlled[i].side for i in here])
            need = np.where(taut, 0.0, np.diag(M)[:k] * m) + M[:k, :k] @ np.where(taut, m, 0.0)
        F = np.linalg.cholesky(M[:k, :k] + EPSILON * np.trace(M[:k, :k]) * np.eye(k))
        T, _ = nnls(F.T, np.linalg.solve(F, need))
        slack = M[:k, :k] @ T - need
        found[here] = np.where(T > 0.0, T, -slack.clip(min=0.0) / np.diag(M)[:k])
    return found


def compliance(rod: Rod, tendons: list[Tendon]) -> Floats:
    """Change of length of each path by the tension of each other one (k, k) [m/N], of a straight thin rod."""
    x = np.linspace(0.0, 1.0, COMPLIANCE_POINTS + 1)
    weight = np.full(len(x), rod.length / COMPLIANCE_POINTS)
    weight[[0, -1]] *= 0.5
    sections = [rod.section_at(float(at)) for at in x]
    young = np.array([rod.parts[rod.part_at(float(at))].material.young_modulus for at in x])
    area = np.array([section.area for section in sections])
    second = np.array([section.weaker_second_moment for section in sections])
    found = np.empty((len(tendons), 3, len(x)))
    for row, tendon in enumerate(tendons):
        at, y, z = tendon.path.T
        inside = (x >= at[0]) & (x <= at[-1])
        places = np.interp(x, at, y), np.interp(x, at, z)
        root = np.sqrt(weight / young) * inside
        found[row] = root / np.sqrt(area), *(root * place / np.sqrt(second) for place in places)
    lever = found.reshape(len(tendons), -1)
    return lever @ lever.T
