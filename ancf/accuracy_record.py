"""What a solve to a wanted accuracy reports: estimates, the meshes tried, and what could not be met."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ancf.scene import Rod


@dataclass(frozen=True)
class Trial:
    """One mesh on the way: its size, its cost, and its estimates where they are known."""

    element: str  # of the rods; several are joined by "+"
    elements: int
    unknowns: int
    status: str
    iterations: int
    estimate_iterations: int  # of the finer equilibrium that the estimate compares with
    estimate: float | None
    model_error: float | None


@dataclass(frozen=True)
class Accuracy:
    """What was wanted, what is estimated, and what was chosen.

    `estimate` is the error of the tip's position by the discretisation, over the length of its rod: against
    the same element on an infinitely fine mesh. `model_error` is what the known limits of its sections add,
    against the solid. Both are the largest of the rods, and None where they are not known.
    """

    wanted: float
    estimate: float | None
    model_error: float | None
    rods: tuple[Rod, ...]
    tried: tuple[Trial, ...]
    limit: str = ""  # what ended the search before the estimate was small enough
    advice: str = ""  # what would let the program do better

    @property
    def met(self) -> bool:
        """Whether both estimates together are within what was wanted."""
        return self.estimate is not None and self.estimate + (self.model_error or 0.0) <= self.wanted

    @property
    def warnings(self) -> list[str]:
        """Why the accuracy is not met, one sentence each; empty where it is."""
        if self.met:
            return []
        what = f"accuracy = {self.wanted:g} is not met"
        if self.estimate is None:
            return [f"{what}: no error estimate, {self.limit}"]
        found = []
        if self.limit:
            found.append(
                f"{what}: the estimated tip error is {self.estimate:.2g} of the length; {self.limit}"
            )
        if self.model_error is not None and self.estimate + self.model_error > self.wanted >= self.estimate:
            names = " and ".join(dict.fromkeys(rod.element for rod in self.rods))
            found.append(
                f"{what}: the sections of {names} move the tip by about {self.model_error:.2g} of the length "
                f"against the solid, at every mesh; the mesh adds {self.estimate:.2g}"
                + (f"; {self.advice}" if self.advice else "")
            )
        return found or [
            f"{what}: estimated tip error {self.estimate:.2g}, of the model {self.model_error:.2g}"
        ]

    def as_dict(self) -> dict[str, Any]:
        """Plain Python; breaks are fractions of the length where elements meet."""
        chosen = {
            rod.name: {
                "element": rod.element,
                "formulation": rod.formulation,
                "elements": rod.elements,
                "breaks": list(rod.breaks),
            }
            for rod in self.rods
        }
        return {
            "wanted": self.wanted,
            "met": self.met,
            "estimate": self.estimate,
            "model_error": self.model_error,
            "rods": chosen,
            "tried": [asdict(trial) for trial in self.tried],
        }


def elements_of(rods: Sequence[Rod]) -> str:
    """Names of the elements of some rods, each once."""
    return "+".join(dict.fromkeys(rod.element for rod in rods))
