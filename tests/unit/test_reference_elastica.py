"""Buckled column: against integration, a printed table and both limits."""

from math import cosh, pi, radians, sin, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipk

from reference.elastica import buckled_tip, elastica_closing_ratio, elastica_shortening


@pytest.mark.parametrize("k", [1.001, 1.1, 2.0, 2.18338, 5.0, 10.0])
def test_buckled_column_solves_its_equation(k):
    """theta'' = -P sin theta from the tip (theta' = 0), back to the clamp where theta = 0."""
    tip, P = buckled_tip(k), k * pi**2 / 4

    def slope(_, y):
        return [y[1], -P * np.sin(y[0]), np.cos(y[0]), np.sin(y[0])]

    end = solve_ivp(slope, (0, 1), [tip.angle, 0, 0, 0], "DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
    growth = cosh(sqrt(P))  # of an error in the tip angle where it is near pi
    assert abs(end[0]) < 1e-13 * growth
    assert (end[2], end[3]) == pytest.approx((tip.x, tip.y), abs=1e-13 * growth)


def test_buckled_column_table():
    """Timoshenko and Gere, Theory of Elastic Stability, table 2-4: angle at the tip, P/P_E, x/L, y/L, printed
    to three decimals; 2.541 is 1.3e-3 from the elliptic integral, the others half a unit or one.
    """
    rows = (
        (20, 1.015, 0.970, 0.220),
        (40, 1.063, 0.881, 0.422),
        (60, 1.152, 0.741, 0.593),
        (80, 1.293, 0.560, 0.719),
        (100, 1.518, 0.349, 0.792),
        (120, 1.884, 0.123, 0.803),
        (140, 2.541, -0.107, 0.750),
    )
    for angle, k, x, y in rows:
        exact = (2 / pi * float(ellipk(sin(radians(angle) / 2) ** 2))) ** 2
        tip = buckled_tip(exact)
        assert tip.angle == pytest.approx(radians(angle), abs=1e-12)
        assert exact == pytest.approx(k, abs=1.5e-3)
        assert (tip.x, tip.y) == pytest.approx((x, y), abs=1e-3)


def test_buckled_column_limits():
    """Straight up to Euler's load; above it shortening 2 (k - 1), deflection (4/pi) sqrt(2 (k - 1)); high
    loads turn the rod round: x -> 2/K - 1.
    """
    assert buckled_tip(1.0).x == 1.0 and buckled_tip(0.3).y == 0.0
    e = 1e-6
    assert elastica_shortening(1 + e) == pytest.approx(2 * e, rel=1e-5)
    assert buckled_tip(1 + e).y == pytest.approx(4 / pi * sqrt(2 * e), rel=1e-5)
    K = pi / 2 * sqrt(100.0)
    assert buckled_tip(100.0).x == pytest.approx(2 / K - 1, abs=1e-9)
    with pytest.raises(ValueError, match="beyond"):
        buckled_tip(300.0)


def test_ends_meet():
    """P/P_E = 2.18338, end angle 130.7 degrees (Love, Treatise, art. 263; Timoshenko and Gere, art. 2.7)."""
    k = elastica_closing_ratio()
    assert k == pytest.approx(2.18338, abs=5e-6)
    assert elastica_shortening(k) == pytest.approx(1, abs=1e-13)
    assert buckled_tip(k).angle == pytest.approx(radians(130.7), abs=radians(0.05))
