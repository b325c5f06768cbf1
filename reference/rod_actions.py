"""What may act on a straight rod at once: points, line loads, wires, chambers, fields, springs and beds.

Plain numbers in SI units, vectors in space at the unstressed rod. Dead values keep their direction; follower
values turn with their section, F = R R_ref^T F_ref. Springs and beds act fully from the beginning, all else
grows with the load factor.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]


def _zeros() -> Array:
    return np.zeros(3)


@dataclass(frozen=True, eq=False)
class PointAction:
    """On the point (0, y, z) of the section at the fraction `at`: forces [N], moments [N m], all (3,).

    `spring` (3, 3) [N/m] holds that point to its reference place: F = -k (c - c_0).
    """

    at: float = 1.0
    offset: ArrayLike = (0.0, 0.0)  # y, z [m]
    force: ArrayLike = field(default_factory=_zeros)
    follower_force: ArrayLike = field(default_factory=_zeros)
    moment: ArrayLike = field(default_factory=_zeros)
    follower_moment: ArrayLike = field(default_factory=_zeros)
    spring: ArrayLike = field(default_factory=lambda: np.zeros((3, 3)))


@dataclass(frozen=True, eq=False)
class Wire:
    """A pull [N] along a path (points, 3) of [fraction of the length, y, z] [-, m, m], straight in between.

    Along its own direction t ~ v + u x p + p' (a tendon without friction), or along the section normal, as a
    chamber of round section under the pressure p pulls, with -p A: its volume is A int e_x.(v + u x p) ds.
    """

    pull: float
    path: ArrayLike
    normal: bool = False


@dataclass(frozen=True, eq=False)
class Bed:
    """A Winkler bed of stiffness (3, 3) [N/m2] per reference length between two fractions of the length."""

    stiffness: ArrayLike
    start: float = 0.0
    end: float = 1.0


@dataclass(frozen=True, eq=False)
class RodActions:
    """All that acts on a rod; line values per reference length [N/m], [N m/m], all (3,).

    A magnetised rod takes the couple (R p) x B per length: `magnets` are pairs of p = A B_r/mu_0 (3,)
    [A m2/m] in section axes and B (3,) [T].
    """

    points: tuple[PointAction, ...] = ()
    wires: tuple[Wire, ...] = ()
    beds: tuple[Bed, ...] = ()
    line_force: ArrayLike = field(default_factory=_zeros)
    follower_line_force: ArrayLike = field(default_factory=_zeros)
    line_moment: ArrayLike = field(default_factory=_zeros)
    follower_line_moment: ArrayLike = field(default_factory=_zeros)
    magnets: tuple[tuple[ArrayLike, ArrayLike], ...] = ()
