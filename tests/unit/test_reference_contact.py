"""Closed forms of rods on beds and against bodies: limits and integrations that are known otherwise."""

import numpy as np
import pytest
from scipy.integrate import solve_bvp, solve_ivp

from reference.contact import crossing_force, level_end_span, lifted_span, propped_force, wrapped_tip
from reference.foundation import end_of_long_beam, middle_of_long_beam, propped_cantilever_tip
from reference.friction import belt_rate, pulled_end, rubbing_tip


def test_without_shear_it_is_hetenyis_beam():
    """w(0) = 2 P beta/k, w'(0) = -2 P beta^2/k; by a couple w = -2 M beta^2/k, w' = 4 M beta^3/k."""
    k, EI = 3.0, 2.0
    beta = (k / (4 * EI)) ** 0.25
    w, phi = end_of_long_beam([0.0], k, EI, 1.0, 0.0)
    assert (w[0], phi[0]) == pytest.approx((2 * beta / k, -2 * beta**2 / k), rel=1e-12)
    w, phi = end_of_long_beam([0.0], k, EI, 0.0, 1.0)
    assert (w[0], phi[0]) == pytest.approx((-2 * beta**2 / k, 4 * beta**3 / k), rel=1e-12)


def test_a_beam_on_a_bed_by_collocation():
    """V' = k w, M' = -V, phi' = M/EI, w' = phi + V/S on a long beam, V(0) = -P, M(0) = -M_0."""
    k, EI, S, P, M_0 = 3.0, 2.0, 4.0, 1.3, 0.4
    x = np.linspace(0.0, 25.0, 200)
    found = solve_bvp(
        lambda x, y: np.array([y[1] + y[3] / S, y[2] / EI, -y[3], k * y[0]]),
        lambda a, b: np.array([a[3] + P, a[2] + M_0, b[0], b[1]]),
        x,
        np.zeros((4, len(x))),
        tol=1e-8,
        max_nodes=20000,
    )
    at = np.array([0.0, 0.5, 1.7])
    w, phi = end_of_long_beam(at, k, EI, P, M_0, S)
    np.testing.assert_allclose(found.sol(at)[:2], [w, phi], atol=1e-6)


def test_the_middle_is_two_ends():
    """Half of a beam under P/2, its end held level by a couple: the deflections of both sum up."""
    k, EI, P = 3.0, 2.0, 1.0
    beta = (k / (4 * EI)) ** 0.25
    x = np.array([0.0, 0.3, 1.1])
    half = end_of_long_beam(x, k, EI, P / 2, P / (4 * beta))
    assert half[1][0] == pytest.approx(0.0, abs=1e-15)
    np.testing.assert_allclose(half[0], middle_of_long_beam(x, k, EI, P), rtol=1e-12)


def test_a_spring_at_the_end():
    """k and 3 E I/L^3 side by side; a rigid one leaves nothing."""
    L, EI, P, k = 2.0, 5.0, 0.7, 1.1
    assert propped_cantilever_tip(L, EI, P, k, L) == pytest.approx(P / (k + 3 * EI / L**3), rel=1e-14)
    assert propped_cantilever_tip(L, EI, P, 1e15, L) == pytest.approx(0.0, abs=1e-12)
    assert propped_force(L, EI, P, L, 0.0) == pytest.approx(P, rel=1e-14)
    assert propped_force(L, EI, P, L, 10.0) == 0.0
    assert crossing_force(P, L, EI, L, EI) == P / 2


@pytest.mark.parametrize(("span", "level"), [(level_end_span, True), (lifted_span, False)])
def test_spans_over_a_plane(span, level):
    """y of the docstring meets the height, and at the end no slope (level) or no moment (lifted)."""
    h, EI, w = 0.01, 2.0, 0.3
    s = span(h, EI, w)
    V = w * s / 3 if level else w * s / 2
    assert (V * s**3 / 6 - w * s**4 / 24) / EI == pytest.approx(h, rel=1e-12)
    end = V * s**2 / 2 - w * s**3 / 6 if level else V * s - w * s**2 / 2
    assert end == pytest.approx(0.0, abs=1e-12)


def test_a_rod_wrapped_ever_tighter_becomes_a_rope():
    """Under a large force it lies on a quarter of the cylinder and hangs straight down from there."""
    EI, rho, L = 1.0, 0.2, 1.0
    end, phi = wrapped_tip(L, EI, 400.0, rho)
    # P sin(theta) + E I theta'^2/2 is constant, and the rod ends all but straight down.
    assert np.sin(phi) == pytest.approx(1.0 - EI / (2 * 400.0 * rho**2), rel=1e-9)
    np.testing.assert_allclose(end, [rho, rho + L - 0.5 * np.pi * rho], atol=0.007)


def test_the_wrapped_rod_is_an_elastica():
    """The pendulum equation from the cylinder on, integrated: it ends without moment at the same place."""
    EI, rho, L, P = 1.0, 0.2, 1.0, 50.0
    end, phi = wrapped_tip(L, EI, P, rho)
    found = solve_ivp(
        lambda s, y: [y[1], -P / EI * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])],
        (rho * phi, L),
        [phi, 1.0 / rho, rho * np.sin(phi), rho * (1.0 - np.cos(phi))],
        rtol=1e-11,
        atol=1e-12,
    ).y[:, -1]
    np.testing.assert_allclose(found[1:], [0.0, *end], atol=1e-6)
    with pytest.raises(ValueError, match="does not lie"):
        wrapped_tip(L, EI, 4.0, rho)


@pytest.mark.parametrize(("mu", "a", "R"), [(0.3, 0.2, 0.0025), (0.8, 1.0, 0.5)])
def test_a_belt_balances(mu, a, R):
    """T = exp(c s), V = R mu p: T' = mu p - V/rho and V' = T/rho - p; a rope where R is nothing."""
    rho = a + R
    c = belt_rate(mu, a, rho)
    p = c / (mu * (1.0 - R / rho))  # T' = mu p (1 - R/rho) at T = 1
    V = R * mu * p
    assert V * c == pytest.approx(1.0 / rho - p, rel=1e-12)
    # About the centre of the cylinder friction alone has a moment: (T rho)' = mu p a.
    assert c * rho == pytest.approx(mu * p * a, rel=1e-12)
    assert belt_rate(mu, a, a) == pytest.approx(mu / a, rel=1e-14)


def test_a_pulled_rod_by_its_energy():
    """Half of the work of F is strain energy and half friction, where the weight was there before."""
    F, held, EA = 0.7, 1.9, 3.1
    slipped, way = pulled_end(F, held, EA)
    strain = held**2 * slipped**3 / (6 * EA)  # int T^2/(2 EA), T = held x
    assert slipped * held == pytest.approx(F) and way == pytest.approx(F * slipped / (2 * EA))
    friction = held * held * slipped**3 / (6 * EA)  # int held u at the end of a growing slip
    work = F**3 / (3 * held * EA)  # int F dway = F^3/(3 EA held)
    assert work == pytest.approx(strain + friction, rel=1e-12)
    assert rubbing_tip(2.0, 5.0, 0.7, 0.3, 1.0) == pytest.approx(0.4 * 8 / 15)
    assert rubbing_tip(2.0, 5.0, 0.7, 0.8, 1.0) == 0.0
