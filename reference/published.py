"""Numbers published by others, with where they come from and how independent they are.

No number here was produced by this project. `rounding` is half a unit of the last digit that was printed.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Independence = Literal["closed form", "other code", "experiment"]


@dataclass(frozen=True)
class Published:
    """One row of a published table.

    case: unique name; conditions: what was computed or measured, in SI unless said; quantities and values, in
    `unit`, in the same order; rounding: half a unit of the last printed digit; source: author, year, table;
    independence: "closed form", "other code" or "experiment"; note: what to know before comparing.
    """

    case: str
    conditions: str
    quantities: tuple[str, ...]
    values: tuple[float, ...]
    unit: str
    rounding: float
    source: str
    independence: Independence
    note: str = ""

    def value(self, quantity: str) -> float:
        """Return one value by the name of its quantity; KeyError for another name."""
        if quantity not in self.quantities:
            raise KeyError(f"{self.case!r} gives {', '.join(self.quantities)}, not {quantity!r}")
        return self.values[self.quantities.index(quantity)]


_MATTIASSON = "Mattiasson 1981, Int. J. Numer. Methods Eng. 17:145-153, table 1"
_TIP = ("u/L", "w/L", "theta")
_CANTILEVER = "inextensible cantilever, dead transverse tip force, P L^2/EI = {}"


def _elastica(load: int, u: float, w: float, theta: float) -> Published:
    return Published(
        case=f"elastica {load}",
        conditions=_CANTILEVER.format(load),
        quantities=_TIP,
        values=(u, w, theta),
        unit="- (theta in rad)",
        rounding=5e-6,
        source=_MATTIASSON,
        independence="closed form",
        note="elliptic integrals, evaluated by the author",
    )


ELASTICA = (
    _elastica(1, 0.05643, 0.30172, 0.46135),
    _elastica(2, 0.16064, 0.49346, 0.78175),
    _elastica(5, 0.38763, 0.71379, 1.21537),
    _elastica(10, 0.55500, 0.81061, 1.43029),
)

BEND_45_DEGREES = (
    Published(
        case="45-degree bend 600",
        conditions=(
            "arc radius 100, 45 degrees, from the origin along x bending to +y, section 1 x 1, E 1e7, nu 0, "
            "dead tip force 600 along z (Bathe and Bolourchi 1979)"
        ),
        quantities=("x", "y", "z"),
        values=(47.23, 15.79, 53.37),
        unit="length unit of the problem",
        rounding=5e-3,
        source="Simo and Vu-Quoc 1986, Comput. Methods Appl. Mech. Eng. 58:79-116, example 7.5 (8 elements)",
        independence="other code",
        note=(
            "eight low-order elements, not mesh-converged: neither torsion constant (Saint-Venant's or I_p) "
            "gives these digits on a fine mesh; compare at 1 %"
        ),
    ),
)

_PIN = (
    "cantilever L 2, section h .5 (load direction) x w .1, E 2.07e11, nu .3, shear factor .849673, "
    "tip force 62.5e3, element {}"
)
_ECM_2013 = "Nachbagauer, Gruber, Gerstmayr 2013, J. Comput. Nonlinear Dyn. 8:021004, table 1"


def _pin(case: str, element: str, value: float, rounding: float, source: str, note: str = "") -> Published:
    return Published(
        case=case,
        conditions=_PIN.format(element),
        quantities=("u_y",),
        values=(value,),
        unit="m",
        rounding=rounding,
        source=source,
        independence="other code",
        note=note,
    )


_AGREED = "two implementations by others, agreeing to 1e-8 relative; unpublished"
FORMULATION_PINS = (
    _pin("pin 3333 full 4", "3333 ECM, full axial rule, 4 elements", 8.091623235e-4, 5e-14, _ECM_2013),
    _pin("pin 3333 default 4", "3333 ECM, 2 axial points, 4 elements", 8.0990327e-4, 5e-12, _AGREED),
    _pin("pin 3243 full 4", "3243 ECM, 5 x 3 x 3 points, 4 elements", 7.967371247e-4, 5e-14, _AGREED),
    _pin("pin 3243 full 8", "3243 ECM, 5 x 3 x 3 points, 8 elements", 8.063395159e-4, 5e-14, _AGREED),
    _pin("pin 3243 full 16", "3243 ECM, 5 x 3 x 3 points, 16 elements", 8.088762190e-4, 5e-14, _AGREED),
    _pin(
        "pin converged 2011",
        "converged",
        8.09900305e-4,
        5e-13,
        "Nachbagauer, Pechstein, Irschik, Gerstmayr 2011, Multibody Syst. Dyn. 26:245-263",
        "a rod without section deformation is 3.6e-6 relative away",
    ),
)

_PRINCETON = (
    "Princeton beam: L .508, 12.377e-3 (y) x 3.2024e-3 (z), E 71.7e9, nu .31, dead tip force {} N at "
    "angle {} degrees from y"
)
_OBREZKOV = "ANSYS beam elements, quoted by Obrezkov, Finkelshtein, Matikainen 2022"


def _princeton(force: float, angle: int, u_y: float, u_z: float) -> Published:
    return Published(
        case=f"princeton {force:g} {angle}",
        conditions=_PRINCETON.format(force, angle),
        quantities=("|u_y|", "|u_z|"),
        values=(u_y, u_z),
        unit="m",
        rounding=5e-12,
        source=_OBREZKOV,
        independence="other code",
        note="the experiment is Dowell and Traybar 1975; solids differ from beams by 3 %",
    )


PRINCETON = (
    _princeton(8.896, 0, 0.01071417630, 0.0),
    _princeton(8.896, 45, 0.00883722627, 0.108987937),
    _princeton(8.896, 90, 0.0, 0.146245978),
)

RIGHT_ANGLE_FRAME = (
    Published(
        case="right-angle frame",
        conditions="legs 240, section 30 x .6, E 71240, nu .31, one leg clamped, in-plane end load",
        quantities=("critical load",),
        values=(1.088,),
        unit="force unit of the problem",
        rounding=5e-4,
        source="Argyris et al. 1979; Simo and Vu-Quoc 1986, example 7.6",
        independence="other code",
        note="lateral buckling; compare at 2 %",
    ),
)

PUBLISHED = ELASTICA + BEND_45_DEGREES + FORMULATION_PINS + PRINCETON + RIGHT_ANGLE_FRAME


def published(case: str) -> Published:
    """Return the row of that name; KeyError lists the names."""
    for row in PUBLISHED:
        if row.case == case:
            return row
    raise KeyError(f"no published row {case!r}; there are: {', '.join(row.case for row in PUBLISHED)}")
