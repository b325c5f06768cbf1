"""Manufactured solutions: a chosen smooth motion, and the loads under which it is the exact equilibrium.

Symbols: `X` reference position (..., 3) [m], `x` deformed position, `F` = dx/dX, `b` body force by reference
volume [N/m^3], `P_pk1` first Piola-Kirchhoff stress [Pa].
P. J. Roache, Code verification by the method of manufactured solutions, J. Fluids Eng. 124 (2002) 4.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.invariant_laws import COMPLEX_STEP, Field, InvariantLaw

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class WaveMotion:
    """Three waves, one after the other: x_i <- x_i + amplitude sin(wave_i . x + phase_i), i = 0, 1, 2.

    `amplitude` [m], `wave` (3, 3) [1/m], `phase` (3,) [-]. With a zero diagonal of `wave` every step is a
    simple shear that varies in space, so det F = 1 everywhere: a motion that no bulk modulus resists.
    """

    amplitude: float
    wave: Array
    phase: Array

    def position(self, X: Field) -> Field:
        """Deformed position x(X) (..., 3) [m]."""
        return self._steps(X)[0]

    def deformation_gradient(self, X: Field) -> Field:
        """F = dx/dX (..., 3, 3), by the chain rule of the three steps."""
        return self._steps(X)[1]

    def _steps(self, X: Field) -> tuple[Field, Field]:
        x = np.array(X)
        F = np.zeros((*x.shape, 3), x.dtype) + np.eye(3)
        for i in range(3):
            angle = x @ self.wave[i] + self.phase[i]
            slope = self.wave[i] @ F
            x[..., i] += self.amplitude * np.sin(angle)
            F[..., i, :] += self.amplitude * np.cos(angle)[..., None] * slope
        return x, F


def body_force(motion: WaveMotion, law: InvariantLaw, X: Array) -> Array:
    """Force that keeps the motion in equilibrium, b_i = -dP_iJ/dX_J (..., 3) [N/m^3].

    The derivatives are complex steps in X through motion and law: exact to rounding, and neither the
    tangent of the law under test nor its stress takes part.
    """
    b = np.zeros(X.shape)
    for axis in range(3):
        step = 1j * COMPLEX_STEP * np.eye(3)[axis]
        P_pk1 = law.stress(motion.deformation_gradient(X + step))
        b -= np.imag(P_pk1[..., axis]) / COMPLEX_STEP
    return b


def traction(motion: WaveMotion, law: InvariantLaw, X: Array, normal: Array) -> Array:
    """Force by reference area, t = P N (..., 3) [Pa], with the reference normal N (..., 3)."""
    P_pk1 = np.asarray(law.stress(motion.deformation_gradient(X)), float)
    return np.einsum("...iJ,...J->...i", P_pk1, normal)
