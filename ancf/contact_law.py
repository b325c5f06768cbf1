r"""Contact without friction: a smooth penalty with multipliers (augmented Lagrangian), many points at once.

With the gap g of a point, its multiplier a [m] and its stiffness k [N/m] the normal force is

    p = k rho(a - g),    V = k sum psi(a - g),    psi' = rho,
    rho(x) = 0 (x < -d),  (x + d)^2/(4 d) (|x| < d),  x (x > d):

a ramp with a rounded corner, so V has two continuous derivatives and Newton does not chatter at the edge of a
contact. Between Newton runs a <- rho(a - g) (Simo and Laursen, Computers and Structures 42 (1992) 97). At the
end a point in contact has 0 <= g <= d whatever k is: k decides how fast, not what is found.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Of the radius of the rod's section: rounding of the corner, and what gaps may be off in the end. The issue
# asks for 1e-4.
ROUNDING = 2e-5
CLOSED = 5e-5
# A round that leaves more than SLOW of the error is followed by one with a stiffness GROWTH times as large.
SLOW, GROWTH = 0.25, 4.0


class PenaltyLaw:
    """Normal forces of points by their gaps, and the state that augmentation moves.

    Parameters
    ----------
    k : stiffness of each point [N/m], any shape
    radius : of the section at each point [m]
    """

    def __init__(self, k: Floats, radius: Floats) -> None:
        self.first_k = k
        self.radius = radius
        self.d = ROUNDING * radius  # m, rounding of the corner
        self.release()

    def release(self) -> None:
        """Forget the multipliers."""
        self.k = self.first_k
        self.a = np.zeros_like(self.k)
        self.error = np.inf

    def go_on(self, a: Floats, k: Floats) -> None:
        """Take up multipliers and stiffnesses of an earlier state; the next round is a first one."""
        self.a, self.k, self.error = a, k, np.inf

    def depth(self, g: Floats) -> Floats:
        """rho(a - g) [m], the depth that the force stands for."""
        x, d = self.a - g, self.d
        return np.where(x >= d, x, np.clip(x + d, 0.0, None) ** 2 / (4.0 * d))

    def slope(self, g: Floats) -> Floats:
        """rho'(a - g)."""
        return np.clip((self.a - g + self.d) / (2.0 * self.d), 0.0, 1.0)

    def energy(self, g: Floats) -> float:
        """V [J]."""
        x, d = self.a - g, self.d
        inside = np.clip(x + d, 0.0, None) ** 3 / (12.0 * d)
        return float(np.sum(self.k * np.where(x >= d, 0.5 * x**2 + d**2 / 6.0, inside)))

    def augment(self, g: Floats) -> bool:
        """Move the multipliers at the gaps g; whether there was anything to move."""
        depth = self.depth(g)
        error = float(np.max(np.abs(depth - self.a) / self.radius, initial=0.0, where=self.k > 0.0))
        if error <= CLOSED:
            return False
        slow = error > SLOW * self.error
        self.k, self.a = (GROWTH * self.k, depth / GROWTH) if slow else (self.k, depth)
        self.error = error
        return True
