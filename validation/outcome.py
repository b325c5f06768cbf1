"""What running a case gives: deviations by name, the numbers side by side, and a solution to draw."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ancf.solution import Solution


@dataclass(frozen=True)
class Row:
    """One number found beside its reference; None where there is nothing to put beside it."""

    label: str
    found: float | None
    reference: float | None
    unit: str


@dataclass(frozen=True)
class Outcome:
    """Result of a problem.

    Parameters
    ----------
    observed : deviation from the reference by quantity; each is held against the limit of that name
    rows : numbers found and their references, for the reader
    solution : the last solution, for the sketch; None where nothing was solved
    scene : the scene that was solved (SI), for the reader to repeat
    reference_error : estimated error of the reference by quantity, where it differs from the case's own
    """

    observed: Mapping[str, float]
    rows: list[Row]
    solution: Solution | None = None
    scene: Mapping[str, Any] | None = None
    reference_error: Mapping[str, float] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
