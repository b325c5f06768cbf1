"""Rods with tendons, chambers and magnets of `reference/`: limits that are known otherwise."""

import numpy as np
import pytest

from reference.actuation import (
    chamber_arc,
    closed_tube_strain,
    frictional_arc,
    frictional_curvature,
    magnet_tip,
    tendon_rod,
    tendon_rod_of_length,
)

L, R, YOUNG = 0.5, 0.0025, 1e6
AREA, SECOND = np.pi * R**2, np.pi * R**4 / 4


def test_a_straight_tendon_makes_an_arc_of_the_shortened_axis():
    """kappa = T d/(E I (1 - T/E A)) per length, axis shorter by T/(E A): exact for a constant state."""
    tension, d = 1e-4 * YOUNG * AREA, 0.8 * R
    tip, error = tendon_rod(L, R, YOUNG, 0.3, tension, [[0, d, 0], [1, d, 0]])
    u = tension * d / (YOUNG * SECOND)
    stretch = 1.0 - tension / (YOUNG * AREA)
    exact = stretch / u * np.array([np.sin(u * L), 1.0 - np.cos(u * L), 0.0])
    assert error < 1e-9 * L
    np.testing.assert_allclose(tip, exact, rtol=0, atol=1e-9 * L)


def test_the_tension_of_a_length_and_back():
    """Constant state: |t| = v - u d, so T = (L - l)/(L (1/E A + d^2/E I))."""
    d, tension = 0.8 * R, 1e-4 * YOUNG * AREA
    wanted = L * (1 - tension / (YOUNG * AREA) - tension * d**2 / (YOUNG * SECOND))
    tip, error, found = tendon_rod_of_length(L, R, YOUNG, 0.3, wanted, [[0, d, 0], [1, d, 0]])
    assert found == pytest.approx(tension, rel=1e-10) and error < 1e-9 * L
    exact, _ = tendon_rod(L, R, YOUNG, 0.3, tension, [[0, d, 0], [1, d, 0]])
    np.testing.assert_allclose(tip, exact, rtol=0, atol=1e-11 * L)


def test_friction_makes_a_spiral():
    """The closed form of an inextensible rod, but for the thrust T/(E A) = 1e-4; by quadrature as well."""
    d, tension = 0.8 * R, 1e-4 * YOUNG * AREA
    kappa = tension * d / (YOUNG * SECOND)
    for friction in (0.3, 2.0):
        s = (np.arange(20000) + 0.5) * L / 20000
        phi = np.log1p(friction * kappa * s) / friction
        exact = L * np.array([np.mean(np.cos(phi)), np.mean(np.sin(phi)), 0.0])
        np.testing.assert_allclose(frictional_arc(L, kappa, friction), exact, rtol=0, atol=1e-9 * L)
        tip, error = tendon_rod(L, R, YOUNG, 0.3, tension, [[0, d, 0], [1, d, 0]], friction)
        assert error < 1e-9 * L
        np.testing.assert_allclose(tip, exact, rtol=0, atol=1.05e-4 * L)


def test_friction_and_a_length_give_a_tension():
    """The same end as from the tension that a length needs; straight, kappa_0 E I = T d in closed form."""
    d, tension = 0.8 * R, 1e-4 * YOUNG * AREA
    for friction in (0.3, 2.0):
        turn = np.log1p(friction * tension * d / (YOUNG * SECOND) * L) / friction
        wanted = L - (d + R**2 / (4 * d)) * turn  # i = R/2
        kappa = frictional_curvature(L, wanted, d, R / 2, friction)
        assert kappa == pytest.approx(tension * d / (YOUNG * SECOND), rel=1e-12)
        tip, error, found = tendon_rod_of_length(L, R, YOUNG, 0.3, wanted, [[0, d, 0], [1, d, 0]], friction)
        # The tendon turns with the path, which the thrust shortens by 1e-4.
        assert found == pytest.approx(tension, rel=3e-4) and error < 1e-9 * L
        exact, _ = tendon_rod(L, R, YOUNG, 0.3, found, [[0, d, 0], [1, d, 0]], friction)
        np.testing.assert_array_equal(tip, exact)


def test_a_tendon_on_the_axis_only_shortens():
    tension = 1e-2 * YOUNG * AREA
    tip, _ = tendon_rod(L, R, YOUNG, 0.3, tension, [[0, 0, 0], [1, 0, 0]])
    np.testing.assert_allclose(tip, [L * (1 - 1e-2), 0, 0], rtol=0, atol=1e-12)


def test_a_turned_tendon_turns_the_answer():
    tension, path = (
        1e-4 * YOUNG * AREA,
        np.array([[0, 0.6 * R, 0.1 * R], [0.4, -0.2 * R, 0.7 * R], [1, 0, 0.5 * R]]),
    )
    c, s = np.cos(0.7), np.sin(0.7)
    turned = np.column_stack([path[:, 0], path[:, 1:] @ np.array([[c, s], [-s, c]])])
    tip, _ = tendon_rod(L, R, YOUNG, 0.3, tension, path)
    other, _ = tendon_rod(L, R, YOUNG, 0.3, tension, turned)
    np.testing.assert_allclose(other, np.array([[1, 0, 0], [0, c, -s], [0, s, c]]) @ tip, rtol=0, atol=1e-12)


def test_a_helical_tendon_twists_the_rod():
    """To first order the torque is T d^2 p, p the turn per length: the couple p x n along the axis.

    m_x = (p x n)_x = y n_z - z n_y with n = -T (1, -p z, p y): -T p d^2; twist -T p d^2/(G J), so a second,
    straight tendon's bending plane turns by it. Seen in the slope of the tip with the winding.
    """
    d, tension = 0.8 * R, 1e-4 * YOUNG * AREA
    a = np.linspace(0, 1, 257)
    found = []
    for turns in (0.25, -0.25):
        angle = 2 * np.pi * turns * a
        path = np.column_stack([a, d * np.cos(angle), d * np.sin(angle)])
        found.append(tendon_rod(L, R, YOUNG, 0.3, tension, path)[0])
    np.testing.assert_allclose(found[0] * [1, 1, -1], found[1], rtol=0, atol=1e-12)  # mirrored
    # Curvature kappa (cos, sin): the deflection by two integrations, small angles.
    kappa = tension * d / (YOUNG * SECOND)
    x = (np.arange(2000) + 0.5) * L / 2000
    y, z = (np.sum((L - x) * f(0.5 * np.pi * x / L)) * L / 2000 * kappa for f in (np.cos, np.sin))
    np.testing.assert_allclose(found[0][1:], [y, z], rtol=2e-3)


def test_a_steep_helix_pulls_along_itself():
    """Many turns bend little; the thrust along the axis is T cos, with tan = d p of the winding (statics)."""
    d, tension, turns = 0.8 * R, 1e-3 * YOUNG * AREA, 40
    a = np.linspace(0, 1, 40 * turns + 1)
    angle = 2 * np.pi * turns * a
    path = np.column_stack([a, d * np.cos(angle), d * np.sin(angle)])
    tip, _ = tendon_rod(L, R, YOUNG, 0.3, tension, path)
    slope = d * 2 * np.pi * turns / L
    assert slope > 0.9
    shortening = tension / (YOUNG * AREA) / np.sqrt(1 + slope**2)
    assert 1.0 - tip[0] / L == pytest.approx(shortening, rel=2e-2)  # each turn bends and twists a little


def test_a_thick_tube():
    """An incompressible tube does not stretch; a thin one by p R/(2 E t) less nu p R/(E t) of the hoop."""
    assert closed_tube_strain(0.006, 0.01, YOUNG, 0.5, 1e3) == 0.0
    thin = closed_tube_strain(0.01, 0.01001, YOUNG, 0.3, 1.0)
    assert thin == pytest.approx(0.01 / (2 * 1e-5 * YOUNG) * (1 - 2 * 0.3), rel=2e-3)


def test_arcs():
    tip = chamber_arc(1.0, 2.0, np.pi)  # a quarter circle
    np.testing.assert_allclose(tip, [2 / np.pi, 2 / np.pi, 0.0], atol=1e-15)
    np.testing.assert_allclose(chamber_arc(1.0, 2.0, -np.pi), tip * [1, -1, 1], atol=1e-15)


def test_a_weak_magnet_is_linear_and_a_strong_one_points_along_the_field():
    """Small c: theta = c sin(a) (L x - x^2/2)/(E I); large: straight along the field but for sqrt(E I/c)."""
    weak, error = magnet_tip(1.0, 1.0, 1e-3, 0.7)
    assert error < 1e-8
    assert weak[1] == pytest.approx(1e-3 * np.sin(0.7) / 3, rel=1e-3)
    strong, _ = magnet_tip(1.0, 1.0, 1e4, 0.7)
    np.testing.assert_allclose(strong, [np.cos(0.7), np.sin(0.7), 0], atol=2e-2)
