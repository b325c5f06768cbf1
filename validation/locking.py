"""Two tables the report keeps: EI_eff/EI over Poisson's ratio, and the loss of accuracy with slenderness."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from reference import analytic
from reference.rod import RodLoads, RodProperties, solve_rod
from validation.criteria import largest
from validation.scenes import bending_angle, solve

POISSON = (0.0, 0.1, 0.2, 0.3, 0.4, 0.45, 0.48, 0.49, 0.495, 0.499)
SMALL_ANGLE = 1e-4  # rad


@dataclass(frozen=True)
class LockingPoint:
    """EI_eff/EI of one element and formulation at one Poisson ratio, and its closed form."""

    element: str
    formulation: str
    poisson_ratio: float
    ratio: float
    exact: float


def locking_curve() -> list[LockingPoint]:
    """Bending stiffness of the paper's element and law beside the enhanced law, in the linear range."""
    points = []
    for element, formulation in (("3243", "continuum"), ("3243", "enhanced"), ("3333", "enhanced")):
        for nu in POISSON:
            exact = analytic.full_hooke_locking_factor(nu) if formulation == "continuum" else 1.0
            points.append(
                LockingPoint(element, formulation, nu, _stiffness_ratio(element, formulation, nu), exact)
            )
    return points


def _stiffness_ratio(element: str, formulation: str, nu: float) -> float:
    length, radius, young_modulus = 0.4, 0.01, 1.0e6
    moment = SMALL_ANGLE * young_modulus * np.pi * radius**4 / 4.0 / length
    rod = {
        "length": length, "elements": 2, "element": element, "formulation": formulation,
        "section": {"shape": "circle", "radius": radius},
        "material": {"young_modulus": young_modulus, "poisson_ratio": nu},
    }  # fmt: skip
    solution = solve({"rod": [rod], "moment": [{"value": [0.0, 0.0, moment]}]})
    return SMALL_ANGLE / bending_angle(solution.tip().rotation, 0.0)


# Error of the deflection against the rod, as documented before the project began: full axial rules.
# (L/H, P L^2/EI) -> 3243 with 12, 24 elements, 3333 with 12, 24; None where nothing is documented.
DOCUMENTED: dict[tuple[int, int], tuple[float | None, ...]] = {
    (20, 1): (-1.8e-3, -1.2e-4, -2.7e-4, 3.1e-4),
    (20, 10): (-3.2e-3, 4.7e-4, -3.3e-4, 1.1e-3),
    (50, 1): (-4.4e-3, -5.3e-4, -2.7e-3, -1.7e-4),
    (50, 10): (-1.4e-2, -1.1e-3, -7.3e-3, -3.8e-4),
    (100, 1): (-1.2e-2, -1.0e-3, -8e-3, None),
    (100, 10): (-3.6e-2, -3.3e-3, -2.3e-2, None),
}
VARIANTS = (("3243", "full", 12), ("3243", "full", 24), ("3333", "full", 12), ("3333", "full", 24),
            ("3333", "default", 12), ("3333", "default", 24))  # fmt: skip


@dataclass(frozen=True)
class SlendernessRow:
    """Relative errors of the tip deflection for one slenderness and load, in the order of `VARIANTS`."""

    slenderness: int
    load: int
    errors: list[float]
    documented: list[float | None]

    @property
    def disagreement(self) -> float:
        """Largest distance from a documented number, over 2e-4 + 10 % of it (two printed "
        "digits, another clamp)."""
        pairs = zip(self.errors, self.documented, strict=False)
        return largest(*(abs(e - d) / (2e-4 + 0.1 * abs(d)) for e, d in pairs if d is not None))


def slenderness_table() -> list[SlendernessRow]:
    """Square cantilever of height H, nu = 0, tip force: error of the deflection against the "
    "integrated rod."""
    rows = []
    for (slenderness, load), documented in DOCUMENTED.items():
        height, young_modulus = 1.0 / slenderness, 1.0e9
        second = height**4 / 12.0
        force = [0.0, load * young_modulus * second, 0.0]
        rod = RodProperties.from_section(1.0, young_modulus, 0.0, height**2, second, second)
        exact = solve_rod(rod, RodLoads(tip_force=force)).position[0][1]
        errors = []
        for element, rule, elements in VARIANTS:
            table = {
                "length": 1.0, "elements": elements, "element": element, "axial_rule": rule,
                "section": {"shape": "rectangle", "height_y": height, "width_z": height},
                "material": {"young_modulus": young_modulus, "poisson_ratio": 0.0},
            }  # fmt: skip
            tip = solve({"rod": [table], "force": [{"value": force}]}).tip().position
            errors.append(float(tip[1] / exact - 1.0))
        rows.append(SlendernessRow(slenderness, load, errors, list(documented)))
    return rows
