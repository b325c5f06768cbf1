"""Sideways buckling of a cantilever and of right-angle frames, with the deformation before buckling.

The rod has extension, shear, torsion and bending, all linear, exact in the rotations. On its plane
equilibrium the sideways perturbations (u_z, w_x, w_y, nu_z, mu_x, mu_y) obey linear equations of their own;
the load is critical where these have a solution that meets the end conditions.

Symbols
-------
P, M     load; plane of the load x-y, its moment about z
EI_y     weak stiffness (sideways), EI_z strong, GJ; units of length and moment L, EI_y/L
T        transfer matrix of `perturbation`, rows and columns (u, w, nu, mu)
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import pi

import numpy as np
from numpy.typing import NDArray

from reference.buckling import lateral_buckling_load
from reference.critical_loads import hinged_frame_moment
from reference.perturbation import TOLERANCE, Leg, LegState, cantilever, transfer
from reference.rod import RodProperties
from reference.root import bracketed_root

Array = NDArray[np.float64]

ROUGH = 1e-9  # a second, looser tolerance of the integration: its determinant at the root bounds the error
NEAR = 1e-4  # relative step for the slope of the determinant
SCAN = 0.1  # step of the search for the first critical load, in units of the classical one
FARTHEST = 6.0
W_Y, NU_Z, MU_X, MU_Y, W_X, U_Z = 4, 8, 9, 10, 3, 2  # places in (u, w, nu, mu)
QUARTER_TURN = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


@dataclass(frozen=True)
class CriticalLoad:
    """First critical load [N or N m] and its estimated error, same unit."""

    value: float
    error: float


def lateral_buckling(rod: RodProperties) -> CriticalLoad:
    """First tip force at which a cantilever leaves the plane x-y in which it is bent.

    Dead force along y at the centroid of the tip: mu_x = mu_y = 0 there, hence det T[(mu_x, mu_y), same] = 0
    on the bent rod.

    Parameters
    ----------
    rod : RodProperties, straight, EI_y < EI_z; its base is not used

    Returns
    -------
    CriticalLoad [N]

    Raises
    ------
    ValueError for EI_y >= EI_z (bending about the softer axis stays plane), or when there is none below 6
    times 4.0126 sqrt(EI_y GJ)/L^2 (seen from EI_y/EI_z = 0.5 on, GJ = 1.2 EI_y).

    Notes
    -----
    For EI_y, GJ << EI_z and no extension or shear the limit is 4.0126 sqrt(EI_y GJ)/L^2 (Michell, Prandtl
    1899). Bending before buckling raises it, in first order as 1/sqrt((1 - EI_y/EI_z)(1 - GJ/EI_z)) does
    (Reissner 1979; Hodges and Peters 1975, Int. J. Solids Struct. 11:1269), by 1.16 times as much for GJ =
    1.2 EI_y: that formula is exact for pure bending. Some 1 s.
    """
    if rod.EI_y >= rod.EI_z:
        raise ValueError(f"EI_y = {rod.EI_y:.6g} N m2 must be below EI_z = {rod.EI_z:.6g} N m2")
    legs = [_leg(rod, np.eye(3))]
    scale = lateral_buckling_load(rod.EI_y, rod.GJ, rod.length)
    force = np.array([0.0, 1.0, 0.0])
    return _first(lambda tolerance: _Sideways(legs, force, tolerance), scale, rod.EI_y / rod.length**2)


def right_angle_frame(rod: RodProperties, sign: int = 1) -> CriticalLoad:
    """First tip force at which a cantilever of two legs at a right angle leaves its plane.

    First leg from the clamp along x, second along y, both like `rod`; dead force `sign` P along x at the tip.

    Parameters
    ----------
    rod : RodProperties of either leg, straight, EI_y < EI_z (strong in the plane)
    sign : +1 pulls the first leg, -1 pushes it

    Returns
    -------
    CriticalLoad [N], positive

    Raises
    ------
    ValueError when there is none below 6 sqrt(EI_y GJ)/L^2 times 4.0126.

    Notes
    -----
    Argyris et al. 1979, Comput. Methods Appl. Mech. Eng. 20:105; Simo and Vu-Quoc 1986, example 7.6, strip of
    30 x 0.6, L = 240, E = 71240, nu = 0.31: 1.0875 pulled, 0.6804 pushed. Some 0.5 s.
    """
    legs = [_leg(rod, np.eye(3)), _leg(rod, QUARTER_TURN)]
    scale = lateral_buckling_load(rod.EI_y, rod.GJ, rod.length)
    force = np.array([float(sign), 0.0, 0.0])
    return _first(lambda tolerance: _Sideways(legs, force, tolerance), scale, rod.EI_y / rod.length**2)


def hinged_frame(rod: RodProperties, sign: int = 1) -> CriticalLoad:
    """First end moment at which a hinged right-angle frame leaves its plane (mode even about its middle).

    Hinges turn about z only and slide along the line that joins them; equal and opposite moments M about z.
    Half the frame: a leg in pure bending, n = 0, from the hinge (u_z = w_x = w_y = 0) to the corner, where by
    symmetry w_y = nu_z = mu_x = 0 (the plane of symmetry is y-z); the corner keeps its direction.

    Parameters
    ----------
    rod : RodProperties of either leg, straight
    sign : +1 drives the hinges apart, -1 together

    Returns
    -------
    CriticalLoad [N m], positive

    Notes
    -----
    Without bending before buckling M = pi sqrt(EI_y GJ)/L for either sign: `hinged_frame_moment`.
    Argyris et al. 1979; Simo and Vu-Quoc 1986. The first odd mode is higher (1.01 M).
    """
    legs = [_leg(rod, np.eye(3))]
    bend = rod.EI_y / rod.EI_z

    def determinant(tolerance: float) -> Callable[[float], float]:
        def at(M: float) -> float:
            # The leg climbs at 45 degrees at the corner; it has turned by M L/EI_z on the way there.
            angle = pi / 4 - sign * M * bend
            c, s = np.cos(angle), np.sin(angle)
            frame = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
            start = LegState(np.zeros(3), frame, np.zeros(3), np.array([0.0, 0.0, sign * M]))
            _, T = transfer(legs, start, tolerance)
            return float(np.linalg.det(T[np.ix_([W_Y, NU_Z, MU_X], [NU_Z, MU_X, MU_Y])]))

        return at

    scale = hinged_frame_moment(rod.EI_y, rod.GJ, rod.length)
    return _first(determinant, scale, rod.EI_y / rod.length)


def _leg(rod: RodProperties, turn: Array) -> Leg:
    """Leg in units of L and EI_y."""
    if np.any(np.asarray(rod.curvature)):
        raise ValueError("the rod must be straight")
    unit = rod.EI_y / rod.length**2
    return Leg(
        length=1.0,
        compliance_n=unit / np.array([rod.EA, rod.GA_y, rod.GA_z]),
        compliance_m=rod.EI_y / np.array([rod.GJ, rod.EI_y, rod.EI_z]),
        turn=turn,
    )


class _Sideways:
    """Determinant of the moments (mu_x, mu_y) at the tip by those at the clamp, by the load P (nu = 0).

    The clamp moment of the load before is the guess for the next: asked for loads that grow by small steps
    from a light one, it keeps to the equilibrium that starts at zero load.
    """

    def __init__(self, legs: list[Leg], direction: Array, tolerance: float) -> None:
        self.legs, self.direction, self.tolerance = legs, direction, tolerance
        self.arm: Array | None = None  # clamp moment over load

    def __call__(self, P: float) -> float:
        guess = None if self.arm is None else P * self.arm
        start, _, T = cantilever(self.legs, P * self.direction, guess, self.tolerance)
        self.arm = start.moment / P
        return float(np.linalg.det(T[np.ix_([MU_X, MU_Y], [MU_X, MU_Y])]))


def _first(
    determinant: Callable[[float], Callable[[float], float]], scale: float, unit: float
) -> CriticalLoad:
    """First zero of determinant(tolerance)(load/unit), sought from SCAN times `scale` on."""
    fine, rough = determinant(TOLERANCE), determinant(ROUGH)
    step = SCAN * scale / unit
    low = step
    sign = np.sign(fine(low))
    while low < FARTHEST * scale / unit:
        high = low + step
        if np.sign(fine(high)) != sign:
            root = bracketed_root(fine, low, high, absolute=1e-12 * high)
            slope = (fine(root * (1 + NEAR)) - fine(root * (1 - NEAR))) / (2 * NEAR * root)
            return CriticalLoad(root * unit, (abs(rough(root) / slope) + 1e-11 * root) * unit)
        low = high
    raise ValueError(f"no critical load below {FARTHEST:g} times the classical one, {scale:.6g}")
