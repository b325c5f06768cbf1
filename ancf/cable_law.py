r"""Energy of a cable: stretch and bending of its axis, no shear, no torsion, no section of its own.

With a = r_x . r_x, b = r_x . r_xx, c = r_xx . r_xx, per reference length

    U = 1/2 E A eps^2 + 1/2 E I K^2,    eps = (a - 1)/2,    K^2 = |r_x x r_xx|^2/|r_x|^4 = (a c - b^2)/a^2.

eps is the Green-Lagrange strain of the axis, K the rotation of the tangent per *reference* length, so that a
fibre at the distance y has the strain eps - y K and U = int E/2 (eps - y K)^2 dA on sections that bend alike
about every axis. (Berzeri, Shabana, J. Sound Vib. 235 (2000) 539; Gerstmayr, Shabana, Nonlinear Dyn. 45
(2006) 109, who explain why K and not the curvature by present length.)

Arrays as in section_law.py, with the three products a - 1, b, c in the place of the pairs.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class CableSection:
    """E A [N m] and E I [N m3] times the axial weight, (n_el or 1, points)."""

    stretching: Floats
    bending: Floats

    def energy(self, gamma: Floats) -> float:
        """See `SectionLaw.energy`."""
        a, b, c = _products(gamma)
        square = c / a - (b / a) ** 2
        return float(np.sum(self.stretching * gamma[..., 0] ** 2 / 8.0 + 0.5 * self.bending * square))

    def resultants(self, gamma: Floats) -> Floats:
        """See `SectionLaw.resultants`."""
        a, b, c = _products(gamma)
        half = 0.5 * self.bending
        return np.stack(
            [
                self.stretching * gamma[..., 0] / 4.0 + half * (2.0 * b**2 / a - c) / a**2,
                -2.0 * half * b / a**2,
                half / a,
            ],
            axis=-1,
        )

    def response(self, gamma: Floats) -> tuple[Floats, Floats]:
        """See `SectionLaw.response`."""
        a, b, c = _products(gamma)
        half = 0.5 * self.bending
        H = np.zeros((*gamma.shape, 3))
        H[..., 0, 0] = self.stretching / 4.0 + half * (2.0 * c - 6.0 * b**2 / a) / a**3
        H[..., 0, 1] = H[..., 1, 0] = 4.0 * half * b / a**3
        H[..., 0, 2] = H[..., 2, 0] = -half / a**2
        H[..., 1, 1] = -2.0 * half / a**2
        return self.resultants(gamma), H

    def predicted(self, gamma_previous: Floats, gamma: Floats) -> Floats:
        """See `SectionLaw.predicted`."""
        T, H = self.response(gamma_previous)
        return T + (H @ (gamma - gamma_previous)[..., None])[..., 0]

    def smallest_volume(self, v: Floats) -> None:
        """See `SectionLaw.smallest_volume`: a cable has no volume to invert."""
        return


def _products(gamma: Floats) -> tuple[Floats, Floats, Floats]:
    return 1.0 + gamma[..., 0], gamma[..., 1], gamma[..., 2]
