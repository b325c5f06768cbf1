r"""The problem families of `ancf cost`: a rod, its load, and a reference that shares no code with ancf.

Positions are by the length of the rod, which is clamped at the origin along x. A reference states its own
error and what it answers:

exact solid   three-dimensional elasticity at any strain (`reference/section.py`): what a beam misses on fine
              meshes is its model error, of order (kappa R)^2
rod           the Simo-Reissner rod with the same E A, k G A, E I, G J (`reference/rod.py`): terms of finite
              strain, of order (kappa R)^2, count as model error; these rods are thin, so that they are small
other code    a published number of another program: verification, no experiment
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reference import analytic
from reference.published import published
from validation.exact import answer
from validation.scenes import changed, in_si, stiffness_of

Floats = NDArray[np.float64]

OBLIQUE = (0.6, 0.5, -0.8)  # direction of the helix' moment: bending about two axes, and torsion
HELIX_TURN = 2.5  # |M| L/EI
FORCE = 10.0  # P L^2/EI
WEIGHT = 10.0  # rho g A L^3/EI
PRINCETON = "princeton 8.896 45"


@dataclass(frozen=True)
class Reference:
    """What the tip is compared with.

    Parameters
    ----------
    position : tip of the axis (3,) by the length; nan where a component is not known
    error : its own estimated error, by the length
    kind : ``exact solid``, ``rod`` or ``other code``
    thickness : distance, by the length, of the infinitely thin rod from it; None where that says nothing
    """

    position: tuple[float, ...]
    error: float
    kind: str
    name: str
    source: str
    thickness: float | None = None


@dataclass(frozen=True)
class Family:
    """A rod under one load.

    Parameters
    ----------
    scene : in SI units; its rod has no element and no mesh
    find_reference : gives the reference of the scene
    variants : further settings of the rod by name; each is a model of its own
    signed : whether the reference gives the signs of the components
    """

    name: str
    problem: str
    scene: Mapping[str, Any]
    find_reference: Callable[[Mapping[str, Any]], Reference]
    variants: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    signed: bool = True

    @property
    def length(self) -> float:
        """Length of the rod [m]."""
        return float(self.scene["rod"][0]["length"])

    def with_rod(self, solver: Mapping[str, Any] | None = None, **rod: Any) -> dict[str, Any]:
        """The scene with settings of its rod and of the solver."""
        return changed(self.scene, rod, **({"solver": dict(solver)} if solver else {}))

    def error(self, position: Floats, reference: Reference) -> float:
        """Distance of a tip (3,) [m] from the reference, by the length, over the components that it gives."""
        found, wanted = np.asarray(position, float) / self.length, np.array(reference.position)
        if not self.signed:
            found = np.abs(found)
        return float(np.linalg.norm((found - wanted)[~np.isnan(wanted)]))


def families() -> list[Family]:
    """All families in the order of the report."""
    thin_rod = "Simo-Reissner rod, collocation"
    return [
        Family(
            "pure bending",
            "couple at the tip, 90 degrees, L/R = 40, Saint Venant-Kirchhoff, ν = 0.3",
            _arm(40.0, moment=[{"value": [0.0, 0.0, math.pi / 2]}]),
            _exact_solid,
        ),
        Family(
            "helix",
            "oblique couple |M| L/EI = 2.5 along (.6, .5, -.8), L/R = 200, ν = 0.3",
            _arm(200.0, moment=[{"value": _along(OBLIQUE, HELIX_TURN)}]),
            _exact_solid,
        ),
        Family(
            "tip force",
            "dead force P L²/EI = 10 across the rod along (0, .8, .6), L/R = 200, ν = 0.3",
            _arm(200.0, force=[{"value": _along((0.0, 0.8, 0.6), FORCE)}]),
            lambda scene: _rod(scene, thin_rod),
        ),
        Family(
            "gravity",
            "own weight ρ g A L³/EI = 10 across the rod, L/R = 200, ν = 0.3",
            _heavy(_arm(200.0)),
            lambda scene: _rod(scene, thin_rod),
        ),
        Family(
            "45-degree bend",
            "arc of radius 100, square section 1 × 1, E = 1e7, ν = 0, dead tip force 600 out of its plane "
            "(Bathe and Bolourchi 1979)",
            {
                "rod": [
                    {
                        "length": 25.0 * math.pi,
                        "curvature": [0.0, 0.0, 0.01],
                        "section": {"shape": "rectangle", "height_y": 1.0, "width_z": 1.0},
                        "material": {"young_modulus": 1.0e7, "poisson_ratio": 0.0},
                    }
                ],
                "force": [{"value": [0.0, 0.0, 600.0]}],
            },
            lambda scene: _rod(scene, f"{thin_rod}, J = I_p"),
        ),
        Family(
            "neo-Hookean bending",
            "couple at the tip, 90 degrees, L/R = 40, neo-Hookean, ν = 0.49",
            _arm(40.0, "neo-hookean", 0.49, moment=[{"value": [0.0, 0.0, math.pi / 2]}]),
            _exact_solid,
        ),
        _princeton(),
    ]


def _arm(
    slenderness: float, law: str = "saint-venant-kirchhoff", nu: float = 0.3, **load: Any
) -> dict[str, Any]:
    """A round arm of 0.4 m, loads in units of E I/L and E I/L^2 turned into SI."""
    rod = {
        "length": 0.4,
        "section": {"shape": "circle", "radius": 0.4 / slenderness},
        "material": {"law": law, "young_modulus": 1.0e6, "poisson_ratio": nu},
    }
    return in_si({"rod": [rod | {"elements": 1}], **load}) | {"rod": [rod]}


def _along(direction: tuple[float, ...], size: float) -> list[float]:
    return [float(v) for v in size * np.array(direction) / np.linalg.norm(direction)]


def _heavy(scene: dict[str, Any]) -> dict[str, Any]:
    """The scene with a weight of `WEIGHT` along -z."""
    numbers = stiffness_of(changed(scene, {"elements": 1}))
    density, area = 1000.0, math.pi * numbers.radius**2
    acceleration = WEIGHT * numbers.EI / numbers.length**3 / (density * area)
    material = {**scene["rod"][0]["material"], "density": density}
    return changed(scene, {"material": material}, gravity={"acceleration": [0.0, 0.0, -acceleration]})


def _exact_solid(scene: Mapping[str, Any]) -> Reference:
    found = answer("section", changed(scene, {"elements": 1}))
    numbers = stiffness_of(changed(scene, {"elements": 1}))
    thin = analytic.helix_tip_moment(
        scene["moment"][0]["value"], numbers.length, numbers.EI, numbers.GJ, numbers.length
    )
    thickness = float(np.linalg.norm(thin.position[0] / numbers.length - found.position))
    return Reference(
        tuple(float(v) for v in found.position),
        found.position_error,
        "exact solid",
        "exact section problem",
        "reference/section.py; error: difference of two meshes of the section",
        thickness,
    )


def _rod(scene: Mapping[str, Any], name: str) -> Reference:
    found = answer("rod", changed(scene, {"elements": 1}))
    source = "reference/rod.py; error: against a mesh of half the elements"
    return Reference(tuple(float(v) for v in found.position), found.position_error, "rod", name, source)


def _princeton() -> Family:
    """The Princeton beam, against ANSYS beams as published; the experiment's own data are not at hand."""
    row = published(PRINCETON)
    length, height, width, young, nu = 0.508, 12.377e-3, 3.2024e-3, 71.7e9, 0.31
    exact = analytic.torsion_constant_rectangle(height, width)
    I_p = height * width * (height**2 + width**2) / 12.0
    force = 8.896 * math.sqrt(0.5)

    def reference(scene: Mapping[str, Any]) -> Reference:
        deflection = (row.value("|u_y|") / length, row.value("|u_z|") / length)
        return Reference(
            (math.nan, *deflection), row.rounding / length, "other code", "ANSYS beam elements, published",
            f"{row.source}; error: printed digits only. {row.note}",
        )  # fmt: skip

    return Family(
        "Princeton beam",
        "aluminium strip 12.377 × 3.2024 mm, L = 508 mm, 8.896 N at 45 degrees: deflections |u_y|, |u_z| "
        "against another code's beam, not against the experiment",
        {
            "rod": [
                {
                    "length": length,
                    "section": {"shape": "rectangle", "height_y": height, "width_z": width},
                    "material": {"young_modulus": young, "poisson_ratio": nu},
                }
            ],
            "force": [{"value": [0.0, force, force]}],
        },
        reference,
        {"shear factors J/I_p": {"shear_factors": [exact / I_p, exact / I_p]}},
        signed=False,
    )
