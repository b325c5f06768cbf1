"""What the tendons of a solution do: tension and length of each, and whether it is slack."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.effects.tendon import PulledTendon
from ancf.model import Model
from ancf.scene import Tendon

Floats = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class TendonState:
    """Tension [N] by which a tendon is pulled, what friction leaves of it, and length [m] of its path.

    slack: the cable of a tendon of controlled length is longer than the path by this much [m]; 0 where it
    pulls, None for a tendon of given tension.
    """

    tendon: Tendon
    tension: float
    length: float
    slack: float | None
    end_tension: float  # N, at the last point of the path

    def as_dict(self) -> dict[str, Any]:
        """Plain Python."""
        found = {"rod": self.tendon.rod, "tension": self.tension, "length": self.length}
        if self.tendon.friction:
            found["end_tension"] = self.end_tension
        return found if self.slack is None else {**found, "slack": self.slack}


def tendon_states(model: Model, q: Floats, load_factor: float) -> list[TendonState]:
    """The tendons of a model at the unknowns q (n,), in the order of the scene."""
    pulled = (effect for effect in model.effects if isinstance(effect, PulledTendon))
    controlled = iter([] if model.constraints is None else model.constraints.tendons)
    found = []
    for tendon in model.scene.tendons:
        if tendon.tension is None:
            one = next(controlled)
            found.append(TendonState(tendon, one.tension(q), one.length(q), one.slack(q), one.end_tension(q)))
        else:
            effect = next(pulled)
            e, tension = q[effect.dofs].reshape(len(effect.dofs), -1, 3), load_factor * tendon.tension
            left = tension * effect.end_share(e)
            found.append(TendonState(tendon, tension, effect.length(e), None, left))
    return found


def held_cable_warnings(model: Model, q: Floats) -> list[str]:
    """A sentence for each tendon with friction that pulls at q (n,) though its cable is not taken in."""
    controlled = [] if model.constraints is None else model.constraints.tendons
    return [
        f"rod {one.tendon.rod!r}: a tendon rubs and pulls at length = {one.tendon.length:.6g} m, no less"
        f" than the {one.l_0:.6g} m of its path in the reference: friction is that of a cable that slides"
        " to the first point of its path, and one that is held or let out has less tension there"
        for one in controlled
        if one.tendon.friction and one.change >= 0.0 and one.tension(q) > 0.0
    ]
