"""Pure bending at finite strain of a Saint Venant-Kirchhoff rod.

Symbols
-------
kappa     change of angle per reference length, [1/m]
lambda_   stretch of the axis (line through the centroids), [-]
a         stretch of the section in the plane of bending, [-]
A, I, I4  area, second and fourth moment of the section, int dA, int y^2 dA, int y^4 dA, y in the plane
          of bending, [m2], [m4], [m6]; the section is symmetric about y = 0
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt

import numpy as np
from scipy.optimize import minimize_scalar

from reference.root import bracketed_root


@dataclass(frozen=True)
class BendingSection:
    """Moments of a section symmetric about the bending axis: A [m2], I = int y^2 [m4], I4 = int y^4 [m6]."""

    area: float
    second_moment: float
    fourth_moment: float

    @classmethod
    def circle(cls, radius: float) -> BendingSection:
        """Circle: A = pi R^2, I = pi R^4/4, I4 = pi R^6/8."""
        return cls(pi * radius**2, pi * radius**4 / 4, pi * radius**6 / 8)

    @classmethod
    def rectangle(cls, height: float, width: float) -> BendingSection:
        """Rectangle, height in the plane of bending: A = w h, I = w h^3/12, I4 = w h^5/80."""
        return cls(width * height, width * height**3 / 12, width * height**5 / 80)


@dataclass(frozen=True)
class BendingState:
    """Uniformly bent rod: curvature [1/m], stretch of axis and of section in the plane [-], moment [N m]."""

    curvature: float
    axial_stretch: float
    section_stretch: float
    moment: float

    def tip(self, length: float) -> tuple[float, float, float]:
        """Return (along [m], across [m], angle [rad]) of the tip: arc of length lambda L, angle kappa L."""
        angle = self.curvature * length
        arc = self.axial_stretch * length
        return (
            arc * float(np.sinc(angle / pi)),
            arc * float(np.sin(angle / 2) * np.sinc(angle / (2 * pi))),
            angle,
        )


def _moment_of_fibres(c: float, young_modulus: float, section: BendingSection) -> float:
    """M0(c) = E I c [1 - (9/2) c^2 I/A + c^2 I4/(2 I)], fibre stretch lambda - c y, axial force zero.

    P = E f (f^2 - 1)/2 with f = lambda - c y; int P dA = 0 gives lambda^2 = 1 - 3 c^2 I/A, and
    M0 = -int y P dA = (E I c/2)(3 lambda^2 - 1 + c^2 I4/I). [N m]
    """
    A, I2, I4 = section.area, section.second_moment, section.fourth_moment
    return young_modulus * I2 * c * (1 - 4.5 * c * c * I2 / A + c * c * I4 / (2 * I2))


def _axial_stretch(c: float, section: BendingSection) -> float:
    square = 1 - 3 * c * c * section.second_moment / section.area
    if square <= 0:
        raise ValueError(f"curvature {c:.6g} 1/m is too large: no axial stretch gives zero axial force")
    return sqrt(square)


def _section_stretch(c: float, young_modulus: float, section: BendingSection) -> float:
    """Stretch a in terms of c = kappa a: c M0(c) + (EA/2)(a^2 - 1) a^2 = 0, a quadratic in a^2."""
    g = 2 * c * _moment_of_fibres(c, young_modulus, section) / (young_modulus * section.area)
    if g > 0.25:
        raise ValueError(f"the section collapses: no in-plane stretch balances kappa a = {c:.6g} 1/m")
    return sqrt(0.5 + sqrt(0.25 - g))


def _state(c: float, young_modulus: float, section: BendingSection, model: str) -> BendingState:
    if model not in ("rigid", "stretching"):
        raise ValueError(f'section_model must be "rigid" or "stretching", got {model!r}')
    a = 1.0 if model == "rigid" else _section_stretch(c, young_modulus, section)
    moment = a * _moment_of_fibres(c, young_modulus, section)
    return BendingState(c / a, _axial_stretch(c, section), a, moment)


def _largest_c(young_modulus: float, section: BendingSection, model: str) -> float:
    """Return c = kappa a at which the moment is largest; beyond it a dead moment has no stable answer."""
    # dM0/dc = 0; M = a M0 turns earlier because a falls.
    slope = 4.5 * section.second_moment / section.area - section.fourth_moment / (2 * section.second_moment)
    c = min(1 / sqrt(3 * slope), sqrt(section.area / (3 * section.second_moment)) * (1 - 1e-9))
    if model == "rigid":
        return c
    while 2 * c * _moment_of_fibres(c, young_modulus, section) > 0.25 * young_modulus * section.area:
        c *= 0.9
    best = minimize_scalar(
        lambda x: -_state(x, young_modulus, section, model).moment,
        bounds=(0.0, c),
        options={"xatol": 1e-10 * c},
    )
    return float(best.x)  # pyright: ignore[reportAttributeAccessIssue]


def pure_bending_moment(
    curvature: float, young_modulus: float, section: BendingSection, section_model: str = "stretching"
) -> BendingState:
    """Moment of a Saint Venant-Kirchhoff rod (nu = 0) bent to a given curvature without axial force.

    "rigid": the section keeps its shape, M = M0(kappa); circle M = EI kappa [1 - (7/8)(kappa R)^2], rectangle
    M = EI kappa [1 - 0.30 (kappa h)^2]. "stretching": it may stretch by `a` in the plane of bending, and the
    energy U(kappa, a) = W(kappa a) + EA (a^2 - 1)^2/8 gives M = a M0(kappa a) and
    kappa M0(kappa a) + (EA/2)(a^2 - 1) a = 0.

    Parameters
    ----------
    curvature : [1/m] of the axis, per reference length
    young_modulus : [Pa]
    section : BendingSection
    section_model : "stretching" (what r_y of an ANCF element allows) or "rigid"

    Returns
    -------
    BendingState

    Raises
    ------
    ValueError beyond the curvature of the largest moment.

    Notes
    -----
    Derived here from E = (F^T F - I)/2, F = (lambda - kappa a y) t x e_x + a n x e_y + e_z x e_z (tensor
    products). Exact for these kinematics; a solid also warps its section, an effect of order (kappa R)^2.
    """
    if section_model == "rigid":
        c = curvature
    else:

        def gap(x: float) -> float:
            return x / _section_stretch(x, young_modulus, section) - abs(curvature)

        top = _largest_c(young_modulus, section, section_model)
        if gap(top) < 0:
            raise ValueError(f"curvature {curvature:.6g} 1/m lies beyond the largest moment of this section")
        c = float(np.copysign(bracketed_root(gap, 0.0, top), curvature))
    return _state(c, young_modulus, section, section_model)


def pure_bending_curvature(
    moment: float, young_modulus: float, section: BendingSection, section_model: str = "stretching"
) -> BendingState:
    """Curvature of a Saint Venant-Kirchhoff rod (nu = 0) under a given bending moment.

    Solves a M0(kappa a) = M on the branch that starts at zero (see `pure_bending_moment`). For a circle
    kappa = kappa_0 (1 + 1.375 (kappa_0 R)^2 + ...) when the section stretches, 0.875 when it is rigid,
    kappa_0 = M/EI.

    Parameters
    ----------
    moment : [N m]
    young_modulus : [Pa]
    section : BendingSection
    section_model : "stretching" or "rigid"

    Returns
    -------
    BendingState

    Raises
    ------
    ValueError when `moment` exceeds the largest moment the section can carry (the material softens).
    """
    top = _largest_c(young_modulus, section, section_model)
    largest = _state(top, young_modulus, section, section_model).moment
    if abs(moment) > largest:
        raise ValueError(f"moment {moment:.6g} N m exceeds the largest of this section, {largest:.6g} N m")

    def gap(c: float) -> float:
        return _state(c, young_modulus, section, section_model).moment - abs(moment)

    c = 0.0 if moment == 0 else bracketed_root(gap, 0.0, top)
    return _state(float(np.copysign(c, moment)), young_modulus, section, section_model)
