"""Critical loads in closed form: column with compression and shear, frame, shaft, ring, follower force.

Symbols
-------
EI, GJ    bending and torsional stiffness, [N m2]; EA, GA stiffness in extension and shear, [N]
P_E       Euler's load of the inextensible, shear-free column, [N]
n, w      force in the rod; rotation of the sections in the mode. K, mu: see `perturbation`
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, cosh, pi, sin, sinh, sqrt, tan
from typing import Any

from scipy.optimize import minimize_scalar

from reference.buckling import euler_load
from reference.root import bracketed_root

EVEN_ENDS = ("clamped-free", "pinned-pinned", "clamped-clamped", "clamped-guided")


@dataclass(frozen=True)
class RingTwist:
    """Critical torque [N m] of a ring, and the angle [rad] by which its ends were turned before joining."""

    moment: float
    angle: float


@dataclass(frozen=True)
class Flutter:
    """Critical follower force P L^2/EI and the frequency there, omega L^2 sqrt(mass per length/EI), [-]."""

    load: float
    frequency: float


def column_load(EI: float, EA: float, GA: float, length: float, ends: str = "clamped-free") -> float:
    """Critical axial force of a column that is compressed and sheared, geometrically exact rod [N].

    P (1 - P/EA + P/GA) = P_E: the rod of length (1 - P/EA) L under P has, by a rotation w of the section, the
    lateral slope u' = w (1 - P/EA + P/GA) and EI w'' = -P u'. For EA -> infinity Haringx's formula, since the
    shear force is that along the section (not Engesser's, P_E/(1 + P_E/GA), normal to the axis; both agree
    to first order).

    Parameters
    ----------
    EI : [N m2]
    EA, GA : [N]; `math.inf` where there is no extension, no shear
    length : [m], unstressed
    ends : "clamped-free", "pinned-pinned", "clamped-clamped" or "clamped-guided": no lateral reaction in the
        mode

    Raises
    ------
    ValueError for other ends, and where 4 P_E (1/EA - 1/GA) > 1: compression comes before buckling.

    Notes
    -----
    Reissner 1972, ZAMP 23:795, and 1982; Haringx 1948; extensible: Magnusson, Ristinmaa, Ljung 2001, Int. J.
    Solids Struct. 38:8441.
    """
    if ends not in EVEN_ENDS:
        raise ValueError(f"ends must be one of {', '.join(EVEN_ENDS)}, got {ends!r}")
    euler = euler_load(EI, length, ends)
    square = 1 + 4 * euler * (1 / GA - 1 / EA)
    if square < 0:
        raise ValueError(f"no critical load: 4 P_E (1/EA - 1/GA) = {1 - square:.6g} exceeds 1")
    return 2 * euler / (1 + sqrt(square))


def hinged_frame_moment(EI: float, GJ: float, length: float) -> float:
    """Critical end moment of the hinged right-angle frame, M = pi sqrt(EI GJ)/L [N m], either sign.

    EI [N m2] is the weak stiffness, length [m] that of a leg; bending before buckling neglected
    (`bifurcation.hinged_frame` has it). With n = 0 and uniform mu = (0, mu_y, 0) in the even mode,
    K^-1 w' = mu + M e_z x w. The solution from w = 0 circles the constant (e_z x mu)/M, along x, at the rate
    M/sqrt(EI GJ); after half a turn it stands at twice that, so w_y = 0 at the corner, whatever the angle of
    the legs. Argyris et al. 1979 (622.2 in their units).
    """
    return pi * sqrt(EI * GJ) / length


def shaft_torque(EI: float, length: float, ends: str = "pinned-pinned") -> float:
    """Critical axial torque of a straight shaft of equal bending stiffnesses, M = k EI/L [N m].

    k = 2 pi pinned-pinned, 2 x = 8.98682 clamped-clamped (tan x = x). With the torque along the unbent axis
    and no lateral moment at pinned ends, EI w' = -w x M e_1: the tilt w turns at the rate M/EI and its
    integral, the deflection, must vanish. The torque keeps its direction in space ("axial torque"); with
    pinned ends such a torque is not conservative and this is the load of static bifurcation alone. Torsion
    before buckling does not matter for equal stiffnesses. Greenhill 1883; Ziegler, Principles of Structural
    Stability, 1968; Timoshenko and Gere, art. 2.22.
    """
    factors = {"pinned-pinned": 2 * pi, "clamped-clamped": 2 * bracketed_root(lambda x: tan(x) - x, 4.4, 4.6)}
    if ends not in factors:
        raise ValueError(f"ends must be one of {', '.join(factors)}, got {ends!r}")
    return factors[ends] * EI / length


def ring_twist(EI: float, GJ: float, radius: float) -> RingTwist:
    """Critical torque of a ring bent from a straight rod of equal bending stiffnesses, mode 2.

    M = sqrt(3) EI/R, angle = 2 pi R M/GJ = 2 pi sqrt(3) EI/GJ; mode k (period 2 pi R/k) at
    sqrt(k^2 - 1) EI/R. In the twisted ring m = M t + (EI/R) b, n = (M/R) b; no extension, no shear. A ring
    that is unstressed as a ring has another load. EI, GJ [N m2], radius [m]. Michell 1889; Zajac 1962, J.
    Appl. Mech. 29:136; Goriely 2006, J. Elasticity 84:281.
    """
    moment = sqrt(3) * EI / radius
    return RingTwist(moment, 2 * pi * radius * moment / GJ)


def beck_flutter() -> Flutter:
    """Cantilever under a tip force that turns with the tip (Beck's column): flutter, P = 20.0510 EI/L^2.

    p^2 + 2 w^2 (1 + cosh a cos b) + p w sinh a sin b = 0, a^2, b^2 = sqrt(p^2/4 + w^2) -+ p/2, w frequency:
    the two lowest roots w meet at the critical p. At w = 0 the left side is p^2: no load has a second static
    equilibrium, so a static analysis must find no critical load at all. Beck 1952, ZAMP 3:225; Bolotin 1963.
    """

    def lowest(p: float) -> tuple[float, float]:
        def left(w: float) -> float:
            root = sqrt(p * p / 4 + w * w)
            a, b = sqrt(root - p / 2), sqrt(root + p / 2)
            return p * p + 2 * w * w * (1 + cosh(a) * cos(b)) + p * w * sinh(a) * sin(b)

        best: Any = minimize_scalar(left, bounds=(5.0, 17.0), method="bounded", options={"xatol": 1e-9})
        return float(best.fun), float(best.x)

    load = bracketed_root(lambda p: lowest(p)[0], 18.0, 22.0)
    return Flutter(load, lowest(load)[1])
