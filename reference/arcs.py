"""Chain of pieces of constant curvature: the closed form of arms whose sections are bent evenly."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference import rotation as rot

Array = NDArray[np.float64]

STRAIGHT = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


@dataclass(frozen=True)
class Piece:
    """A piece: length [m], twist and curvatures about y and z per length (3,) [1/m], stretch of the axis."""

    length: float
    curvature: ArrayLike = (0.0, 0.0, 0.0)
    stretch: float = 1.0


def chain_tip(pieces: Sequence[Piece], base: ArrayLike = STRAIGHT) -> tuple[Array, Array]:
    """Tip (3,) [m] from the base, and its frame (3, 3), of pieces one after the other.

    r_{i+1} = r_i + R_i stretch int_0^l Exp(s k) e_x ds,  R_{i+1} = R_i Exp(l k)  (Webster, Jones, Int. J.
    Robotics Res. 29 (2010) 1661, there in arc parameters). `base`: axes of the first section as columns.
    """
    r, R = np.zeros(3), np.asarray(base, dtype=float)
    for piece in pieces:
        turn = piece.length * np.asarray(piece.curvature, dtype=float)[None]
        r = r + R @ (piece.stretch * piece.length * rot.exp_integral(turn)[0, :, 0])
        R = R @ rot.exp(turn)[0]
    return r, R


def concentric_curvature(EI: Sequence[float], curvature: Sequence[float]) -> float:
    """Curvature [1/m] of plane tubes inside one another that may not turn: sum(EI k)/sum(EI).

    Their moments EI_i (kappa - k_i) cancel (Webster, Romano, Cowan, IEEE Trans. Robotics 25 (2009) 67).
    """
    return float(np.dot(EI, curvature) / np.sum(EI))
