"""Scene records: what a scene file says, validated, in SI units.

A scene is data. `scene_file.py` makes one from TOML (and is the only place that checks user input);
`model.py` turns it into arrays.

Symbols
-------
SCS  structure coordinate system, in which every vector of a scene is given unless it says ``frame = "body"``
BCS  body coordinate system of one rod: x along the rod at its base, y and z in the section (paper eq. 2-3)
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.elements import ELEMENTS
from ancf.errors import refuse
from ancf.hyperelastic import Law
from ancf.scene_effects import (
    EFFECT_MODULES,
    AddedEffect as AddedEffect,
    Contact as Contact,
    Force as Force,
    Foundation as Foundation,
    Gravity as Gravity,
    LineLoad as LineLoad,
    LineMoment as LineMoment,
    Magnet as Magnet,
    Moment as Moment,
    Pressure as Pressure,
    Spring as Spring,
    Tendon as Tendon,
)
from ancf.sections import Section
from ancf.segments import Segment, starts

SAME_PLACE = 1e-9  # fractions of the length closer than this are one place


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
    """One rod: geometry, section, material, element and supports.

    A plain rod is prismatic, and `segments` is empty. A rod of several segments, or a tapered one, comes from
    `Rod.of_segments`: its `length` and `elements` are the sums, its `section` and `material` those at the
    base, and they cannot be changed one by one. `parts`, `section_at` and `prismatic` serve both kinds.
    """

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
    segments: tuple[Segment, ...] = ()
    breaks: tuple[float, ...] = ()  # fractions of the length where elements meet; absent: equal elements
    any_element: bool = False  # whether `SolverOptions.accuracy` may put another in the place of `element`

    def __post_init__(self) -> None:
        if not self.formulation:
            object.__setattr__(self, "formulation", ELEMENTS[self.element].formulations[0])
        if self.breaks and len(self.breaks) != self.elements + 1:
            raise ValueError(f"rod {self.name!r}: {len(self.breaks)} breaks and {self.elements} elements")
        if self.segments and _totals(self.segments) != {name: getattr(self, name) for name in _TOTALS}:
            raise ValueError(f"rod {self.name!r}: {', '.join(_TOTALS)} do not belong to its segments")

    @classmethod
    def of_segments(cls, name: str, segments: tuple[Segment, ...], **others: Any) -> Rod:
        """Rod of one segment after the other from its base; `others` are the further fields of `Rod`.

        A single prismatic segment makes a plain rod.
        """
        plain = len(segments) == 1 and not segments[0].tapered
        return cls(name=name, segments=() if plain else segments, **_totals(segments), **others)

    @property
    def clamp(self) -> Support | None:
        """The one support that holds position and orientation; None where there are others, or none."""
        return self.supports[0] if len(self.supports) == 1 and self.supports[0].kind != "pin" else None

    @cached_property
    def parts(self) -> tuple[Segment, ...]:
        """The segments, of a plain rod the one that it is."""
        return self.segments or (Segment(self.length, self.elements, self.section, self.material),)

    @cached_property
    def ends(self) -> NDArray[np.float64]:
        """Fractions of the length (n + 1,) between which the parts lie, from 0 to 1."""
        fractions = starts(self.parts) / self.length
        fractions[-1] = 1.0
        return fractions

    def check_place(self, at: float) -> None:
        """Refuse what is no fraction of the length; raises `InputError`."""
        if not 0.0 <= at <= 1.0:
            refuse(
                "There is no such place on the rod.",
                f"rod {self.name!r}, at = {at:g}",
                "0 <= at <= 1",
                "a length instead of a fraction of it",
                "divide by the length",
            )

    def part_at(self, at: float) -> int:
        """Which part the section at a fraction of the length belongs to: at a joint the larger of the two.

        The larger one has the face on which a load at the joint can act; read from the other end it is the
        same one.
        """
        after = int(np.clip(np.searchsorted(self.ends, at, side="right") - 1, 0, len(self.parts) - 1))
        here = {after}
        if at - self.ends[after] <= SAME_PLACE:
            here.add(max(after - 1, 0))
        if self.ends[after + 1] - at <= SAME_PLACE:
            here.add(min(after + 1, len(self.parts) - 1))
        return max(sorted(here), key=lambda part: self._section_in(part, at).area)

    def section_at(self, at: float) -> Section:
        """The section at a fraction of the length; at a joint of two parts the larger one."""
        return self._section_in(self.part_at(at), at) if self.segments else self.section

    def _section_in(self, part: int, at: float) -> Section:
        """The section of a part at a fraction of the rod's length."""
        first, last = self.ends[part], self.ends[part + 1]
        return self.parts[part].section_at(float((at - first) / (last - first)))

    def prismatic(self, section: Section, material: Law) -> Rod:
        """The plain rod that has this section and material all along: what the kernels see at one place."""
        return replace(self, section=section, material=material, segments=()) if self.segments else self


_TOTALS = ("length", "elements", "section", "material")


def _totals(segments: tuple[Segment, ...]) -> dict[str, Any]:
    """Length and elements of all segments; section and material at the base."""
    first = segments[0]
    elements = sum(segment.elements for segment in segments)
    values = (float(starts(segments)[-1]), elements, first.section, first.material)
    return dict(zip(_TOTALS, values, strict=True))


@dataclass(frozen=True)
class Place:
    """A section of a rod by its fraction of the reference length."""

    rod: str
    at: float


@dataclass(frozen=True, eq=False)
class Joint:
    """A connection of the section `a` with the section `b`, or with the ground where b is None.

    ``rigid`` holds position and rotation against each other, ``hinge`` leaves the rotation about `axis` (SCS,
    unit vector, at the reference), ``twist`` holds that alone, ``ball`` leaves every rotation. The position
    is held `along` unit vectors (k, 3), as a rule all three; `hold` are the components that a motion lists
    (scene_motions.py). Against the ground the section may be moved: by `displacement` [m] and by the rotation
    vector `rotation` [rad, SCS], both times the load factor. Two sections that are `apart` in the reference
    are brought together by the load factor.
    """

    kind: str
    a: Place
    b: Place | None = None
    axis: NDArray[np.float64] = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    displacement: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    rotation: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    apart: bool = False
    along: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))
    hold: tuple[str, ...] = ()

    @property
    def across(self) -> NDArray[np.float64]:
        """Two unit vectors (2, 3) across the axis, rotations about which a hinge holds and a twist leaves."""
        return np.linalg.svd(self.axis[None])[2][1:]

    @property
    def places(self) -> tuple[Place, ...]:
        """The sections that it holds."""
        return (self.a,) if self.b is None else (self.a, self.b)


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
    friction_steps: int = 20  # fewest load steps where a contact has friction
    accuracy: float | None = None  # wanted tip error / length; the program then chooses the mesh


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
    line_moments: tuple[LineMoment, ...] = ()
    magnets: tuple[Magnet, ...] = ()
    gravity: Gravity | None = None
    tendons: tuple[Tendon, ...] = ()
    pressures: tuple[Pressure, ...] = ()
    springs: tuple[Spring, ...] = ()
    foundations: tuple[Foundation, ...] = ()
    contacts: tuple[Contact, ...] = ()
    joints: tuple[Joint, ...] = ()
    added: tuple[AddedEffect, ...] = ()  # effects of other packages
    solver: SolverOptions = SolverOptions()
    stability: StabilityOptions | None = None
    title: str = ""

    @property
    def listed(self) -> dict[str, tuple[Any, ...]]:
        """Records of the effects that are listed, by the name of their table."""
        records = {table: getattr(self, name) for name, table in EFFECT_MODULES.items()}
        records |= {added.table: added.records for added in self.added}
        return {
            table: found if isinstance(found, tuple) else (found,)
            for table, found in records.items()
            if found
        }

    @property
    def follows_path(self) -> bool:
        """Whether the whole path of equilibria from the reference is wanted."""
        buckled = self.stability is not None and self.stability.branch == "buckled"
        return self.solver.method == "arclength" or buckled

    @property
    def pulled_tendons(self) -> tuple[Tendon, ...]:
        """The tendons of given tension."""
        return tuple(tendon for tendon in self.tendons if tendon.tension is not None)

    @property
    def controlled_tendons(self) -> tuple[Tendon, ...]:
        """The tendons of controlled length."""
        return tuple(tendon for tendon in self.tendons if tendon.length is not None)

    @property
    def constrained(self) -> bool:
        """Whether there are conditions on the motion beside the supports."""
        return bool(self.joints or self.controlled_tendons)

    def load_axes(self, load: Moment | Force | LineLoad | LineMoment) -> NDArray[np.float64]:
        """Axes (3, 3), as columns in SCS, in which a load's value was given: a value v acts as axes @ v."""
        return self.rod(load.rod).base.rotation if load.frame == "body" else np.eye(3)

    @property
    def held_on_the_way(self) -> bool:
        """Whether springs or foundations resist the loads besides the rods."""
        return any(held.holds for held in (*self.springs, *self.foundations))

    def rod(self, name: str) -> Rod:
        """Return the rod of that name; raises KeyError for an unknown one."""
        for rod in self.rods:
            if rod.name == name:
                return rod
        raise KeyError(f"the scene has no rod named {name!r}; it has {[r.name for r in self.rods]}")
