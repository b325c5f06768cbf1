"""Generalised forces of a model as what stays and what grows with the load factor."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Residual:
    """Generalised forces (n,) of the rods and what is passive, and of the loads at load factor 1."""

    Q_int: Floats
    Q_ext: Floats

    def at(self, load_factor: float) -> Floats:
        """g = Q_int - load_factor Q_ext; at 0 the load does not count, even where it overflows."""
        if load_factor == 0.0:
            return self.Q_int
        return self.Q_int - load_factor * self.Q_ext
