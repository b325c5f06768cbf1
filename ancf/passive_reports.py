"""What springs, foundations and obstacles do in the end: their entries in the result.

An effect that has something to tell has `report(e)`, plain Python in SI units.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ancf.effects import blocks_of

if TYPE_CHECKING:
    from ancf.model import Model

# Name of the effect -> key of its list in the result.
KEYS = {"spring": "springs", "foundation": "foundations", "contact": "contacts"}


def passive_reports(model: Model, q: NDArray[np.float64]) -> dict[str, list[dict[str, Any]]]:
    """Lists by key, in the order of the scene; what the scene does not list has none."""
    found: dict[str, list[dict[str, Any]]] = {}
    for effect in model.effects:
        if effect.name in KEYS:
            entry = effect.report(blocks_of(q, effect.dofs))
            found.setdefault(KEYS[effect.name], []).append(entry)
    return found
