"""Scene records: what a scene file says, validated, in SI units.

A scene is data. `scene_file.py` makes one from TOML (and is the only place that checks user input);
`model.py` turns it into arrays.

Symbols
-------
SCS  structure coordinate system, in which every vector of a scene is given unless it says ``frame = "body"``
BCS  body coordinate system of one rod: x along the rod at its base, y and z in the section (paper eq. 2-3)
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ancf.elements import ELEMENTS
from ancf.hyperelastic import Law
from ancf.sections import Section


@dataclass(frozen=True, eq=False)
class Frame:
    """Where a rod stands: origin of its BCS and the rotation A_o from BCS to SCS (paper eq. 2)."""

    position: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))  # (3,) m
    rotation: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))  # (3, 3), columns x, y, z axes


@dataclass(frozen=True)
class Support:
    """A support of one section: ``clamp``, ``pin`` or ``free_section_clamp`` at a fraction of the length."""

    at: float = 0.0
    kind: str = "clamp"


@dataclass(frozen=True, eq=False)
class Rod:
    """One prismatic rod: geometry, section, material, element and supports."""

    name: str
    length: float  # m
    elements: int
    section: Section
    material: Law
    element: str = "3333"
    formulation: str = ""  # absent: the default of the element
    axial_rule: str | int = "default"
    base: Frame = field(default_factory=Frame)
    supports: tuple[Support, ...] = (Support(),)
    curvature: NDArray[np.float64] = field(
        default_factory=lambda: np.zeros(3)
    )  # 1/m, twist, about y, about z
    shear_factors: tuple[float, float] = (1.0, 1.0)  # k_y, k_z

    def __post_init__(self) -> None:
        if not self.formulation:
            object.__setattr__(self, "formulation", ELEMENTS[self.element].formulations[0])


@dataclass(frozen=True, eq=False)
class Moment:
    """A point moment [N m] on a section; ``value`` in SCS (BCS input is converted when the scene is read)."""

    rod: str
    at: float
    value: NDArray[np.float64]
    direction: str = "fixed"
    definition: str = "section"


@dataclass(frozen=True, eq=False)
class Force:
    """A point force [N] at a point (y, z) of a section."""

    rod: str
    at: float
    value: NDArray[np.float64]
    offset: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2))  # m
    direction: str = "fixed"


@dataclass(frozen=True, eq=False)
class LineLoad:
    """A force per reference length [N/m] on the centre line of a whole rod."""

    rod: str
    value: NDArray[np.float64]
    direction: str = "fixed"


@dataclass(frozen=True, eq=False)
class Gravity:
    """Weight of every rod under one acceleration [m/s2]."""

    acceleration: NDArray[np.float64]


@dataclass(frozen=True)
class SolverOptions:
    """How the equilibrium is sought (interface: ``[solver]``)."""

    tolerance: float = 1e-10
    tangent: str = "analytic"
    method: str = "newton"
    predictor: str = "auto"
    reduction: str = "auto"
    max_steps: int = 200
    max_seconds: float = 600.0


@dataclass(frozen=True)
class StabilityOptions:
    """What to find out about stability (interface: ``[stability]``)."""

    modes: int = 3
    branch: str = "primary"


@dataclass(frozen=True, eq=False)
class Scene:
    """Rods, the effects that act on them, and solver options. What is not listed is not simulated."""

    rods: tuple[Rod, ...]
    moments: tuple[Moment, ...] = ()
    forces: tuple[Force, ...] = ()
    line_loads: tuple[LineLoad, ...] = ()
    gravity: Gravity | None = None
    solver: SolverOptions = SolverOptions()
    stability: StabilityOptions | None = None
    title: str = ""

    def rod(self, name: str) -> Rod:
        """Return the rod of that name; raises KeyError for an unknown one."""
        for rod in self.rods:
            if rod.name == name:
                return rod
        raise KeyError(f"the scene has no rod named {name!r}; it has {[r.name for r in self.rods]}")
