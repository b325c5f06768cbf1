"""Bars in tension and compression by every law, and under their own weight."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq, minimize_scalar

from reference.hanging import hanging_bar, hanging_saint_venant_kirchhoff
from reference.homogeneous import (
    principal_mooney_rivlin,
    principal_neo_hookean,
    principal_saint_venant_kirchhoff,
    uniaxial,
)
from reference.invariant_laws import mooney_rivlin, neo_hookean, saint_venant_kirchhoff

LAWS = {
    "saint-venant-kirchhoff": (principal_saint_venant_kirchhoff(1e6, 0.1), saint_venant_kirchhoff(1e6, 0.1)),
    "neo-hookean": (principal_neo_hookean(1e6, 0.3), neo_hookean(1e6, 0.3)),
    "mooney-rivlin": (principal_mooney_rivlin(1.2e5, 4e4, 3e7), mooney_rivlin(1.2e5, 4e4, 3e7)),
}


def energy(law, stretch):
    """Smallest energy density over the lateral stretch, of the law in invariants: no stress is used."""

    def density(t):
        return float(law.energy(np.diag([stretch, t, t])))

    around = stretch**-0.5
    return minimize_scalar(
        density, bounds=(0.3 * around, 2 * around), method="bounded", options={"xatol": 1e-10}
    )


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("stretch", [3.0, 0.5])
def test_stress_at_large_stretch_is_the_slope_of_the_least_energy(name, stretch):
    """Stretch 3 and 1/2, sides free: fourth-order differences of the energy minimised over the sides."""
    principal, invariant = LAWS[name]
    found = uniaxial(principal, stretch)
    assert energy(invariant, stretch).x == pytest.approx(found.free, rel=1e-6)
    h = 2e-3 * stretch
    w = {k: energy(invariant, stretch + k * h).fun for k in (-2, -1, 1, 2)}
    slope = (8 * (w[1] - w[-1]) - (w[2] - w[-2])) / (12 * h)
    assert found.stress == pytest.approx(slope, rel=1e-7)


def test_saint_venant_kirchhoff_turns_soft_in_compression():
    """P = E lambda (lambda^2 - 1)/2 is least at 1/sqrt 3, -E/(3 sqrt 3); sides shrink to nothing
    at nu (lambda^2 - 1) = 1.
    """
    law = principal_saint_venant_kirchhoff(1.0, 0.3)
    least = minimize_scalar(lambda x: uniaxial(law, x).stress, bounds=(0.3, 0.9), method="bounded")
    assert least.x == pytest.approx(3**-0.5, abs=1e-5)
    assert least.fun == pytest.approx(-1 / (3 * 3**0.5), rel=1e-9)
    with pytest.raises(ValueError, match="no free stretch"):
        uniaxial(law, 3.0)


@pytest.mark.parametrize("name", LAWS)
@pytest.mark.parametrize("load", [1.5, 0.3, 1e-6, -0.15])
def test_hanging_bar_solves_its_equation(name, load):
    """x' = lambda(w (L - X)), the stretch from a root at every X, integrated from the free end."""
    law, _ = LAWS[name]
    length, weight = 0.7, load * 1e6 / 0.7
    bar = hanging_bar(law, weight, length)

    # Rising branches alone; the sides of the Saint Venant-Kirchhoff bar shrink to nothing at 3.3.
    most = 3.0 if name == "saint-venant-kirchhoff" else 8.0

    def slope(above, _):
        target = weight * above
        return [brentq(lambda x: uniaxial(law, x).stress - target, 0.65, most, xtol=1e-15, rtol=1e-14)]

    run = solve_ivp(slope, (0, length), [0.0], "DOP853", rtol=1e-12, atol=1e-14)
    assert bar.tip == pytest.approx(run.y[0, -1], rel=3e-12)
    assert bar.error < 1e-13
    assert law(bar.support_lateral, bar.support_lateral, bar.support_stretch) == pytest.approx(0, abs=1e-6)
    assert uniaxial(law, bar.support_stretch).stress == pytest.approx(
        weight * length, rel=1e-9, abs=1e-7
    )  # rounding of K, 3e7 Pa


@pytest.mark.parametrize("load", [2.5, 0.3, 1e-4, -0.1, -0.192])
def test_saint_venant_kirchhoff_closed_form(load):
    law = principal_saint_venant_kirchhoff(3e5, 0.1)
    weight = load * 3e5 / 2.0
    closed = hanging_saint_venant_kirchhoff(3e5, weight, 2.0)
    assert hanging_bar(law, weight, 2.0).tip == pytest.approx(closed, rel=1e-12)


@pytest.mark.parametrize("name", LAWS)
def test_light_bars_follow_hooke(name):
    """Displacement w L^2/(2 E): the difference falls with the weight."""
    law, _ = LAWS[name]
    mu = 2 * (1.2e5 + 4e4)  # 2 (c10 + c01), E = 9 K mu/(3 K + mu)
    E = 9 * 3e7 * mu / (3 * 3e7 + mu) if name == "mooney-rivlin" else 1e6
    off = [hanging_bar(law, w * E, 1.0).tip / (1 + w / 2) - 1 for w in (1e-3, 5e-4)]
    assert off[0] / off[1] == pytest.approx(4, rel=0.01)
    assert hanging_bar(law, 0.0, 1.3).tip == 1.3


def test_too_heavy_a_standing_bar_is_refused():
    law = principal_saint_venant_kirchhoff(1.0, 0.3)
    with pytest.raises(ValueError, match="no stretch carries"):
        hanging_bar(law, -0.193, 1.0)
    assert hanging_bar(law, -0.1924, 1.0).support_stretch == pytest.approx(3**-0.5, abs=0.02)
