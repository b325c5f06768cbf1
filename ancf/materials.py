"""Saint Venant-Kirchhoff material: the paper's full Hooke matrix and its enhanced split.

Stress and strain are 6-vectors in the order xx yy zz yz xz xy; strains carry the factor 2 in shear
(gamma = 2 E_gl), stresses do not. That factor is stated here and nowhere else.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

VOIGT = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))


@dataclass(frozen=True)
class SaintVenantKirchhoff:
    """S = D E_gl with constant D; Young's modulus [Pa], Poisson ratio [-], density [kg/m3] or None.

    Valid for small strain at any rotation: it softens in compression and has no energy barrier against
    det F = 0.
    """

    young_modulus: float
    poisson_ratio: float
    density: float | None = None

    @property
    def lame_mu(self) -> float:
        """Shear modulus G = mu = E / (2 (1 + nu)) [Pa]."""
        return self.young_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def lame_lambda(self) -> float:
        """First Lame constant E nu / ((1 + nu)(1 - 2 nu)) [Pa]."""
        nu = self.poisson_ratio
        return self.young_modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))

    def hooke(self) -> NDArray[np.float64]:
        """Full isotropic matrix D (6, 6) [Pa], the paper's E of eq. 16."""
        shape, volume = self.shape_and_volume()
        return shape + volume

    def shape_and_volume(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Parts (6, 6) [Pa] of D with the shear modulus and with lambda: mu E : E and lambda/2 (tr E)^2."""
        shape = self.lame_mu * np.diag([2.0, 2.0, 2.0, 1.0, 1.0, 1.0])
        volume = np.zeros((6, 6))
        volume[:3, :3] = self.lame_lambda
        return shape, volume

    def enhanced(
        self, shear_factors: tuple[float, float] = (1.0, 1.0)
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Split D = D0 + Dv: D0 (6, 6) for the volume, Dv (6, 6) for the axis only [Pa].

        D0 = diag(E, E, E, G, k_z G, k_y G) and Dv = lambda [[2 nu, 1, 1], [1, 2 nu, 1], [1, 1, 2 nu]] on the
        normal strains. At k = 1, D0 + Dv = Hooke; leaving Dv off the axis removes Poisson locking because
        a linear section cannot show the in-plane field that bending at nu > 0 demands.

        D0 is not isotropic when nu != 0: its strains belong in the section's own axes.

        Notes
        -----
        Gerstmayr, Matikainen, Mikkola, Multibody Syst. Dyn. 20 (2008) 359; Nachbagauer, Gruber, Gerstmayr,
        J. Comput. Nonlinear Dyn. 8 (2013) 021004.
        """
        k_y, k_z = shear_factors
        modulus, mu, nu = self.young_modulus, self.lame_mu, self.poisson_ratio
        volume = np.diag([modulus, modulus, modulus, mu, k_z * mu, k_y * mu])
        axis = np.zeros((6, 6))
        axis[:3, :3] = self.lame_lambda * (np.ones((3, 3)) + (2.0 * nu - 1.0) * np.eye(3))
        return volume, axis
