"""Records of the effects that a scene lists, validated, in SI units; `scene.py` holds them all.

Vectors are in SCS unless said otherwise.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from ancf.obstacles import Obstacle

# Field of a scene -> name of the table in scene files, and of the module in ancf.effects that computes the
# effect; the module is imported only if the field is not empty.
EFFECT_MODULES = {
    "moments": "moment",
    "forces": "force",
    "line_loads": "line_load",
    "line_moments": "line_moment",
    "gravity": "gravity",
    "magnets": "magnet",
    "tendons": "tendon",
    "pressures": "pressure",
    "springs": "spring",
    "foundations": "foundation",
    "contacts": "contact",
}


@dataclass(frozen=True, eq=False)
class Moment:
    """A point moment [N m] on a section; ``value`` in SCS (BCS input is converted when the scene is read).

    `frame` is that of the scene file, in which sweeps and sensitivities count the value.
    """

    rod: str
    at: float
    value: NDArray[np.float64]
    direction: str = "fixed"
    definition: str = "section"
    frame: str = "structure"


@dataclass(frozen=True, eq=False)
class Force:
    """A point force [N] at a point (y, z) of a section; ``value`` and ``frame`` as in `Moment`."""

    rod: str
    at: float
    value: NDArray[np.float64]
    offset: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2))  # m
    direction: str = "fixed"
    frame: str = "structure"


@dataclass(frozen=True, eq=False)
class LineLoad:
    """A force per reference length [N/m] on the centre line of a whole rod; as in `Moment`."""

    rod: str
    value: NDArray[np.float64]
    direction: str = "fixed"
    frame: str = "structure"


@dataclass(frozen=True, eq=False)
class LineMoment:
    """A moment per reference length [N m/m] on the sections of a whole rod; as in `Moment`."""

    rod: str
    value: NDArray[np.float64]
    direction: str = "fixed"
    frame: str = "structure"


@dataclass(frozen=True, eq=False)
class Magnet:
    """A magnetised rod in a uniform field: remanence [T] in section axes, flux density [T] in SCS."""

    rod: str
    remanence: NDArray[np.float64]
    field: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Tendon:
    """A tendon along its path (points, 3) of [at, y, z], pulled at the first by a tension or to a length.

    `at` is a fraction of the reference length, rising; y and z [m] are coordinates in the section, linear in
    between. Just one of `tension` [N] and `length` [m] is given; `friction` is the capstan coefficient.
    """

    rod: str
    tension: float | None
    path: NDArray[np.float64]
    length: float | None = None
    friction: float = 0.0


@dataclass(frozen=True, eq=False)
class Pressure:
    """Gauge pressure [Pa] in a closed round chamber along a rod, between two fractions of its length.

    `centre` (2,) and `radius` [m] are those of the chamber in the reference section.
    """

    rod: str
    value: float
    centre: NDArray[np.float64]
    radius: float
    start: float = 0.0
    end: float = 1.0


@dataclass(frozen=True, eq=False)
class Spring:
    """A spring on the point (y, z) of a section, with the stiffness matrix (3, 3) [N/m] in SCS.

    Without an anchor it resists displacements from the reference; with one [m, SCS] it acts along the line to
    it, with the stiffness that its matrix has on the diagonal. `free_length` [m] is that without force, None
    the distance in the reference.
    """

    rod: str
    at: float
    stiffness: NDArray[np.float64]
    offset: NDArray[np.float64] = field(default_factory=lambda: np.zeros(2))  # m
    anchor: NDArray[np.float64] | None = None
    free_length: float | None = None


@dataclass(frozen=True, eq=False)
class Foundation:
    """An elastic bed under a part of a rod: stiffnesses (3,) [N/m2] per reference length along `axes`.

    `axes` (3, 3) are columns in SCS, None those of each reference section (x along the rod).
    """

    rod: str
    stiffness: NDArray[np.float64]
    axes: NDArray[np.float64] | None = field(default_factory=lambda: np.eye(3))
    start: float = 0.0
    end: float = 1.0


@dataclass(frozen=True, eq=False)
class Contact:
    """Contact of a rod with a rigid obstacle or with the rod `other`, which may be itself; no friction."""

    rod: str
    obstacle: Obstacle | None = None
    other: str | None = None


@dataclass(frozen=True, eq=False)
class Gravity:
    """Weight of every rod under one acceleration [m/s2]."""

    acceleration: NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class AddedEffect:
    """Records of a table that another package knows, and where its effect is (added_effects.py)."""

    table: str
    source: str  # "package.module" or "package.module:name"
    records: tuple[Any, ...]
