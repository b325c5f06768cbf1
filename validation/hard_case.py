"""A hard case as data: a scene at the edge of what may be asked, how it must end, limits with reasons."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.model import Model
from ancf.solution import Solution
from validation.criteria import Limit

Floats = NDArray[np.float64]

CONVERGED = ("converged",)
REFUSED = ("refused",)  # exit code 2: nothing was computed
# Statuses that say why there is no answer; `out_of_time` says only that nobody waited.
TYPED = ("not_converged", "limit_point", "inverted_element", "not_finite", "material_unstable")
BUDGET = 30.0  # s that a case may take; a case that needs more ends `out_of_time`, which no case expects


@dataclass(frozen=True)
class HardCase:
    """A scene, the statuses it may end in, and what is asked of its answer.

    Parameters
    ----------
    family, name : where it stands in the table; names are unique
    scene : dictionary in the format of a scene file
    meaning : what is hard about it, and why it must end so
    expected : statuses it may end in; ``refused`` is exit code 2
    said : words that the reason of a failure, a refusal or a warning must contain (regular expression)
    limits : of the deviation from an exact answer, of counts; one of a common quantity replaces the common
        limit
    deviation : distance of the tip from the exact answer, over L
    start : coordinates (n,) to begin from
    stable : whether the answer must be stable; None: it may be unstable if the result warns of it
    walk : ``quick`` or ``full``: in which run the load is also applied in a hundred steps
    drifts : ``quick`` or ``full``: in which run it is described otherwise; a followed path takes seconds
    budget : s
    not_asked : quantity -> why it says nothing about this scene
    """

    family: str
    name: str
    scene: dict[str, Any]
    meaning: str
    expected: tuple[str, ...] = CONVERGED
    said: str = ""
    limits: tuple[Limit, ...] = ()
    deviation: Callable[[Solution], float] | None = None
    start: Callable[[Model], Floats] | None = None
    stable: bool | None = None
    walk: str = "full"
    drifts: str = "quick"
    budget: float = BUDGET
    not_asked: Mapping[str, str] = field(default_factory=dict)

    @property
    def solvable(self) -> bool:
        """Whether it must converge; only then can its answer be held against anything."""
        return self.expected == CONVERGED

    @property
    def bounded(self) -> dict[str, Any]:
        """The scene with its budget of seconds."""
        return {**self.scene, "solver": {"max_seconds": self.budget, **self.scene.get("solver", {})}}
