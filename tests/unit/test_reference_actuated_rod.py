"""Multiple shooting with all loads at once against solvers for some of them, and the section law."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from reference.actuated_rod import solve_actuated_rod
from reference.actuation import magnet_tip
from reference.foundation import end_of_long_beam, propped_cantilever_tip
from reference.rod import RodLoads, RodNotSolved, RodProperties, solve_rod
from reference.rod_actions import Bed, PointAction, RodActions, Wire
from reference.rotation import exp, exp_integral, log
from reference.round_law import NUMBERS, RoundLaw, fitted
from reference.section_answer import section_answer
from reference.tendon_arm import ArmSection, ArmTendon, tendon_arm_tip

L, R, E, NU = 0.4, 0.01, 1.0e6, 0.3
A, EI = np.pi * R**2, E * np.pi * R**4 / 4.0
TURNED = exp([0.3, -0.5, 0.9])
ROD = RodProperties.circle(L, R, E, NU, base_position=[0.1, 0.2, 0.3], base_rotation=TURNED)
PATH = [[0, 0.008, 0], [0.5, -0.004, 0.006], [1, 0, -0.008]]


def test_dead_and_follower_loads_against_collocation():
    force, moment = np.array([-1, 1.0, 2.0]) * EI / L**2, np.array([0.3, 0.5, -0.4]) * EI / L
    weight = np.array([0, -2, 1.0]) * EI / L**3
    tip = PointAction(1.0, force=force, follower_force=-force / 3, moment=moment / 2, follower_moment=moment)
    found = solve_actuated_rod(ROD, RodActions((tip,), line_force=weight))
    exact = solve_rod(ROD, RodLoads(force, moment / 2, -force / 3, moment, weight))
    np.testing.assert_allclose(found.position, exact.position[0], rtol=0, atol=1e-7 * L)
    np.testing.assert_allclose(found.rotation, exact.rotation[0], rtol=0, atol=1e-6)
    assert found.position_error < 1e-7 * L and found.angle_error < 1e-6


def test_tendons_under_weight_against_single_shooting():
    """Two tendons, one of them along a part of the rod; the other solver takes the strains as it goes."""
    gravity = np.array([0, 0, -2.5])
    wires = (Wire(1.0, PATH), Wire(0.7, [[0.2, 0, 0.005], [0.8, 0.003, 0.005]]))
    found = solve_actuated_rod(ROD, RodActions(wires=wires, line_force=1070.0 * A * gravity))
    tendons = [ArmTendon(wire.pull, wire.path) for wire in wires]
    exact, error = tendon_arm_tip([ArmSection(L, R, E, NU, 1070.0)], tendons, TURNED, gravity)
    np.testing.assert_allclose(
        found.position - np.array([0.1, 0.2, 0.3]), exact, rtol=0, atol=1e-7 * L + error
    )


def test_forces_between_the_ends_and_off_the_axis():
    """A force at the half is one on the end of half a rod; off the axis it brings a follower couple."""
    force = np.array([0.0, 0.0, 1.5 * EI / L**2])
    half = RodProperties.circle(L / 2, R, E, NU)
    whole = RodProperties.circle(L, R, E, NU)
    at_half = solve_actuated_rod(whole, RodActions((PointAction(0.5, force=force),)))
    short = solve_actuated_rod(half, RodActions((PointAction(1.0, force=force),)))
    beyond = short.position + short.rotation @ [L / 2, 0, 0]
    np.testing.assert_allclose(at_half.position, beyond, rtol=0, atol=1e-8 * L)
    offset = np.array([0.0, 0.004, -0.006])
    pull = np.array([0.3, 0.0, 0.0]) * EI / L**2
    off = solve_actuated_rod(whole, RodActions((PointAction(1.0, offset[1:], follower_force=pull),)))
    couple = PointAction(1.0, follower_force=pull, follower_moment=np.cross(offset, pull))
    same = solve_actuated_rod(whole, RodActions((couple,)))
    np.testing.assert_allclose(off.position, same.position, rtol=0, atol=1e-9 * L)


def test_springs_and_beds_at_small_loads():
    slender = RodProperties.circle(1.0, 0.0025, E, 0.0)
    stiffness, small = slender.EI_z, 1e-6 * slender.EI_z
    spring = PointAction(0.6, spring=np.diag([0.0, 5.0 * stiffness, 0.0]))
    found = solve_actuated_rod(slender, RodActions((PointAction(1.0, force=[0, small, 0]), spring)))
    exact = propped_cantilever_tip(1.0, stiffness, small, 5.0 * stiffness, 0.6)
    assert found.position[1] == pytest.approx(exact, rel=2e-5)  # shear: E I/(G A L^2) = 3e-6
    k = 4.0 * 5.0**4 * stiffness  # beta L = 5: the clamp is felt by exp(-5)
    bed = Bed(np.diag([0.0, k, 0.0]))
    found = solve_actuated_rod(slender, RodActions((PointAction(1.0, force=[0, small, 0]),), beds=(bed,)))
    w, _ = end_of_long_beam([0.0], k, stiffness, small, 0.0, slender.GA_y)
    assert found.position[1] == pytest.approx(float(w[0]), rel=2.0 * np.exp(-10.0))


def test_a_magnet_against_the_pendulum_equation():
    slender = RodProperties.circle(L, 0.0004, E, NU)  # inextensible to 1e-6
    couple, angle = 3.0 * slender.EI_z / L**2, 1.9
    field = 2.0 * np.array([np.cos(angle), np.sin(angle), 0.0])
    found = solve_actuated_rod(slender, RodActions(magnets=(([couple / 2.0, 0, 0], field),)))
    exact, error = magnet_tip(L, slender.EI_z, couple, angle)
    np.testing.assert_allclose(found.position, exact, rtol=0, atol=3e-6 * L + error)


def test_line_moments_add_up():
    """A couple per length about z bends by m (L - s): the tip turns by m L^2/(2 E I), also as a follower."""
    value = [0, 0, 1.6 * EI / L**2]
    for actions in (RodActions(line_moment=value), RodActions(follower_line_moment=value)):
        found = solve_actuated_rod(RodProperties.circle(L, R, E, NU), actions)
        assert log(found.rotation)[2] == pytest.approx(0.8, abs=1e-9)


def test_a_line_load_that_turns_bends_further_than_a_dead_one():
    """It stays across the rod where the dead one comes to pull along it."""
    load = np.array([0.0, 2.0, 0.0]) * EI / L**3
    dead, follower = (
        solve_actuated_rod(RodProperties.circle(L, R, E, NU), actions)
        for actions in (RodActions(line_force=load), RodActions(follower_line_force=load))
    )
    assert follower.position[0] < dead.position[0] and log(follower.rotation)[2] > log(dead.rotation)[2]


LAW = RoundLaw(1.2, 0.54, 0.5, -0.2, 0.4, -0.01, -0.9, 0.3)


def constant_state(wires, law):
    """v and u (3,) of a rod with straight wires only, whose strains are the same everywhere."""
    found = solve_actuated_rod(RodProperties.circle(L, R, E, NU), RodActions(wires=wires), law)
    u = log(found.rotation) / L
    return np.linalg.solve(exp_integral(u * L), found.position / L), u


def energy(v, u, law):
    """W of the law per length, in SI, written out as in its docstring."""
    e, g, t, b = v[0] - 1.0, v[1:], u[0], u[1:]
    G = E / 2.0 / (1.0 + NU)
    b2 = b @ b
    return (
        E * A * (e**2 / 2 + law.a_3 * e**3) + EI * b2 / 2 + G * np.pi * R**4 / 4 * t**2
        + e * EI * (law.a_1 * b2 + law.a_2 * t**2)
        + EI * R**2 * (law.a_4 * b2**2 + law.a_5 * b2 * t**2 + law.a_6 * t**4)
        + G * A * (g @ g) / 2 + law.a_7 * EI * t * (g @ b)
    )  # fmt: skip


@pytest.mark.parametrize("law", [RoundLaw(), RoundLaw(poisson_ratio=0.3), LAW])
def test_strains_make_the_energy_of_rod_and_wires_stationary(law):
    """Rod with two wires, T/(E A) = 1 %, and a chamber: the gradient vanishes to differences."""
    wires = (
        Wire(3.0, [[0, 0.008, 0.001], [1, 0.008, 0.001]]),
        Wire(1.0, [[0, -0.004, 0.006], [1, -0.004, 0.006]]),
        Wire(-0.5, [[0, 0.002, 0.005], [1, 0.002, 0.005]], normal=True),
    )  # fmt: skip
    nu = law.poisson_ratio

    def total(x):
        v, u = x[:3], x[3:] / R
        W = energy(v, u, law)
        for wire in wires:
            _, y, z = (float(x) for x in np.asarray(wire.path)[0])
            e = v[0] - 1.0
            if wire.normal:
                W += (1 - 2 * nu) * wire.pull * (v[0] + u[1] * z - u[2] * y)
                continue
            dy = nu * (-e * y + u[2] * (y * y - z * z) / 2 - u[1] * y * z)
            dz = nu * (-e * z + u[2] * y * z + u[1] * (y * y - z * z) / 2)
            W += wire.pull * np.linalg.norm(v + np.cross(u, [0.0, y + dy, z + dz]))
        return W

    v, u = constant_state(wires, law)
    x, h = np.concatenate([v, u * R]), 1e-5
    gradient = [(total(x + h * d) - total(x - h * d)) / (2 * h) for d in np.eye(6)]
    np.testing.assert_allclose(gradient, np.zeros(6), atol=3e-6 * E * A * 0.01)


def test_strains_of_the_law_are_those_of_its_energy():
    """Force and moment are its derivatives, by differences, and give the strains back; each number counts."""
    v, u = np.array([1.004, 0.002, -0.003]), np.array([2.0, -1.5, 2.5])  # kappa R = 0.03, twist 0.02
    x, h = np.concatenate([v, u * R]), 1e-5
    G = E / 2.0 / (1.0 + NU)
    K_n, K_m = np.array([E, G, G]) * A * L**2 / EI, np.array([1.0 / (1.0 + NU), 1.0, 1.0])

    def found(law):
        slope = [
            (
                energy((x + h * d)[:3], (x + h * d)[3:] / R, law)
                - energy((x - h * d)[:3], (x - h * d)[3:] / R, law)
            )
            / (2 * h)
            for d in np.eye(6)
        ]
        n, m = np.array(slope[:3]) * L**2 / EI, np.array(slope[3:]) * R * L / EI
        scaled = LAW.scaled(E * A * L**2 / EI, R**2 / L**2)
        near = np.array([1.0, 0.0, 0.0]), np.zeros(3)
        for _ in range(3):
            near = scaled.strains(n, m, K_n, K_m, *near)
        return np.concatenate([near[0], near[1] * R / L])

    np.testing.assert_allclose(found(LAW), x, rtol=0, atol=2e-9)
    for name in NUMBERS:
        other = replace(LAW, **{name: 2.0 * getattr(LAW, name)})
        assert np.abs(found(other) - x).max() > 1e-8, name


@pytest.mark.parametrize(("law", "nu"), [("saint-venant-kirchhoff", 0.3), ("neo-hookean", 0.45)])
def test_the_fitted_law_against_the_exact_section_problem(law, nu):
    """Bent and twisted by 1.8 rad, kappa R = 0.045: 5e-6 L and 3e-5 rad; without the law 2e-3 and 6e-3."""
    material = {"law": law, "young_modulus": E, "poisson_ratio": nu}
    moment = np.array([1.03, 0.8, 1.1]) * EI / L
    exact = section_answer(material, {"shape": "circle", "radius": R}, L, list(moment))
    rod, actions = RodProperties.circle(L, R, E, nu), RodActions((PointAction(1.0, moment=moment),))
    numbers = fitted({**material, "young_modulus": 1.0})
    found = solve_actuated_rod(rod, actions, numbers)
    assert np.linalg.norm(found.position / L - exact["position"]) < 1.5e-5
    assert np.linalg.norm(log(found.rotation @ np.array(exact["rotation"]).T)) < 6e-5
    linear = solve_actuated_rod(rod, actions)
    assert np.linalg.norm(linear.position / L - exact["position"]) > 2e-4
    assert all(abs(getattr(numbers, name)) < 2.0 for name in NUMBERS)


def test_what_cannot_be_solved_is_refused(monkeypatch):
    with pytest.raises(ValueError, match="straight"):
        solve_actuated_rod(RodProperties.circle(L, R, E, NU, curvature=[0, 0, 1.0]), RodActions())
    monkeypatch.setattr("reference.actuated_rod.SMALLEST_STEP", 0.2)  # or it takes a minute to give up
    wire = Wire(2.0 * E * A, [[0, 0.008, 0], [1, 0.008, 0]])  # it would shorten the rod to nothing
    with pytest.raises(RodNotSolved, match="no equilibrium beyond load factor"):
        solve_actuated_rod(RodProperties.circle(L, R, E, NU), RodActions(wires=(wire,)))
