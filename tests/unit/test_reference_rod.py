"""The rod boundary-value solver against initial-value integration, closed forms and published pins."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import reference.rod as rod_module
from reference import rotation as rot
from reference.analytic import elastica_tip_force, helix_tip_moment, space_moment
from reference.rod import RodLoads, RodNotSolved, RodProperties, solve_rod
from reference.rod_collocation import Collocation, RodEquations

STIFF = 1e12  # EA, GA over EI/L^2: extension and shear below 1e-11 at the loads used with it


def slender(EA=STIFF, GJ=1 / 1.3, **placement):
    return RodProperties(1.0, EA, EA, EA, GJ, 1.0, 1.0, **placement)


def general_case():
    """Nothing symmetric, nothing zero: every stiffness, curvature, base and load matters."""
    rod = RodProperties(
        1.4,
        EA=300.0,
        GA_y=90.0,
        GA_z=120.0,
        GJ=0.8,
        EI_y=1.0,
        EI_z=1.7,
        curvature=(0.4, -0.6, 0.9),
        base_position=(0.3, -2.0, 5.0),
        base_rotation=Rotation.from_rotvec([0.7, -1.1, 2.0]).as_matrix(),
    )
    loads = RodLoads(
        tip_force=(1.0, -2.0, 1.5),
        tip_moment=(0.3, 0.5, -0.4),
        follower_tip_force=(-0.8, 0.6, 0.9),
        follower_tip_moment=(0.5, -0.7, 0.2),
        line_load=(0.5, 1.5, -2.0),
    )
    return rod, loads


def integrate(rod, force, moment, loads, s):
    """Initial-value integration from the clamp in rotation matrices, nothing shared with the solver."""
    C_n, C_m = 1 / np.array([rod.EA, rod.GA_y, rod.GA_z]), 1 / np.array([rod.GJ, rod.EI_y, rod.EI_z])

    def slope(_, y):
        R, n, m = y[3:12].reshape(3, 3), y[12:15], y[15:]
        gamma = np.array([1.0, 0, 0]) + C_n * (R.T @ n)
        kappa = np.asarray(rod.curvature) + C_m * (R.T @ m)
        k = np.array([[0, -kappa[2], kappa[1]], [kappa[2], 0, -kappa[0]], [-kappa[1], kappa[0], 0]])
        return np.concatenate(
            [R @ gamma, (R @ k).ravel(), -np.asarray(loads.line_load), -np.cross(R @ gamma, n)]
        )

    start = np.concatenate([rod.base_position, np.asarray(rod.base_rotation).ravel(), force, moment])
    y = solve_ivp(slope, (0, rod.length), start, "DOP853", t_eval=s, rtol=1e-13, atol=1e-13).y.T
    return y[:, :3], y[:, 3:12].reshape(-1, 3, 3), y[:, 12:15], y[:, 15:]


def test_general_case_satisfies_the_equations_and_the_end_conditions():
    rod, loads = general_case()
    s = np.linspace(0, rod.length, 8)
    solution = solve_rod(rod, loads, s)
    assert solution.estimated_error < 1e-11
    position, frame, force, moment = integrate(rod, solution.force[0], solution.moment[0], loads, s)
    assert np.abs(solution.position - position).max() < 1e-10
    assert np.abs(solution.frame - frame).max() < 1e-10
    assert np.abs(solution.force - force).max() < 1e-9
    assert np.abs(solution.moment - moment).max() < 1e-9
    # Clamp, and the loads on the tip with followers turned by the tip rotation.
    assert np.abs(solution.position[0] - rod.base_position).max() < 1e-15
    assert np.abs(solution.frame[0] - rod.base_rotation).max() < 1e-14
    R = solution.rotation[-1]
    assert np.abs(force[-1] - (loads.tip_force + R @ loads.follower_tip_force)).max() < 1e-9
    assert np.abs(moment[-1] - (loads.tip_moment + R @ loads.follower_tip_moment)).max() < 1e-9
    assert np.linalg.norm(rot.log(R)) > 0.5  # the case is really nonlinear


def test_unstressed_rod_and_its_reference():
    rod, _ = general_case()
    s = np.linspace(0, rod.length, 5)
    solution = solve_rod(rod, RodLoads(), s)
    position, frame, *_ = integrate(rod, np.zeros(3), np.zeros(3), RodLoads(), s)
    assert np.abs(solution.position - position).max() < 1e-12
    assert np.abs(solution.reference_position - position).max() < 1e-12
    assert np.abs(rod.reference(s)[1] - frame).max() < 1e-12
    assert np.abs(solution.rotation - np.eye(3)).max() < 1e-13


def test_superposed_rotation_and_translation_carry_over():
    rod, loads = general_case()
    Q, shift = Rotation.from_rotvec([2.0, 1.0, -1.5]).as_matrix(), np.array([10.0, -3.0, 1.0])
    turned_rod = RodProperties(
        rod.length, rod.EA, rod.GA_y, rod.GA_z, rod.GJ, rod.EI_y, rod.EI_z, rod.curvature,
        Q @ rod.base_position + shift, Q @ rod.base_rotation,
    )  # fmt: skip
    turned_loads = RodLoads(*(Q @ np.asarray(v) for v in vars(loads).values()))
    first, second = solve_rod(rod, loads), solve_rod(turned_rod, turned_loads)
    assert np.abs(second.position - (first.position @ Q.T + shift)).max() < 1e-10
    assert np.abs(second.frame - Q @ first.frame).max() < 1e-10


def test_units_scale():
    """Metres to millimetres: lengths by 1e3, EA and forces unchanged, bending stiffness by 1e6."""
    rod, loads = general_case()
    small = solve_rod(rod, loads)
    large = solve_rod(
        RodProperties(
            rod.length * 1e3, rod.EA, rod.GA_y, rod.GA_z, rod.GJ * 1e6, rod.EI_y * 1e6, rod.EI_z * 1e6,
            np.asarray(rod.curvature) / 1e3, np.asarray(rod.base_position) * 1e3, rod.base_rotation,
        ),
        RodLoads(
            loads.tip_force, np.asarray(loads.tip_moment) * 1e3, loads.follower_tip_force,
            np.asarray(loads.follower_tip_moment) * 1e3, np.asarray(loads.line_load) / 1e3,
        ),
    )  # fmt: skip
    assert np.abs(large.position / 1e3 - small.position).max() < 1e-11


@pytest.mark.parametrize("direction", ["fixed", "follower"])
@pytest.mark.parametrize("size", [1.0, 2.5])
def test_helix_under_an_oblique_tip_moment(direction, size):
    v = size * np.array([0.6, 0.5, -0.8]) / np.linalg.norm([0.6, 0.5, -0.8])
    s = np.linspace(0, 1, 6)
    loads = RodLoads(tip_moment=v) if direction == "fixed" else RodLoads(follower_tip_moment=v)
    solution = solve_rod(slender(), loads, s)
    closed = helix_tip_moment(v, 1.0, 1.0, 1 / 1.3, s, direction=direction)
    assert np.abs(solution.position - closed.position).max() < 1e-12
    assert np.abs(solution.rotation - closed.rotation).max() < 1e-12
    # The section couple is the same at every s: M fixed, Exp(psi e) M_ref follower.
    assert np.abs(solution.moment - space_moment(v, 1, 1, 1 / 1.3, direction=direction)).max() < 1e-12


@pytest.mark.parametrize("load", [1.0, 10.0, 40.0])
def test_elastica_is_the_inextensible_limit(load):
    """Two stiffnesses extrapolated: the effect of extension and shear is linear in 1/EA."""
    exact = elastica_tip_force(load)
    tips = [solve_rod(slender(EA), RodLoads(tip_force=(0, load, 0))) for EA in (1e8, 2e8)]
    r = 2 * tips[1].position[0] - tips[0].position[0]
    assert (1 - r[0], r[1]) == pytest.approx((exact.u, exact.w), abs=2e-11)
    assert np.arctan2(tips[1].frame[0, 1, 0], tips[1].frame[0, 0, 0]) == pytest.approx(exact.angle, abs=2e-8)


def test_small_loads_give_linear_theory():
    """Timoshenko cantilever: P L^3/(3 EI) + P L/GA, q L^4/(8 EI) + q L^2/(2 GA), extension P L/EA, M L/GJ."""
    rod = RodProperties(2.0, EA=50.0, GA_y=30.0, GA_z=20.0, GJ=0.9, EI_y=1.3, EI_z=0.7)
    P = 1e-7  # the load's own second-order effect is some 1e2 P
    u = solve_rod(rod, RodLoads(tip_force=(P, P, P))).displacement[0] / P
    assert u == pytest.approx([2 / 50, 8 / 2.1 + 2 / 30, 8 / 3.9 + 2 / 20], rel=1e-4)
    u = solve_rod(rod, RodLoads(line_load=(P, P, P))).displacement[0] / P
    assert u == pytest.approx([4 / 100, 16 / 5.6 + 4 / 60, 16 / 10.4 + 4 / 40], rel=1e-4)
    turn = solve_rod(rod, RodLoads(tip_moment=(P, P, P))).rotation[0]
    assert rot.log(turn) / P == pytest.approx([2 / 0.9, 2 / 1.3, 2 / 0.7], rel=1e-4)


# Bathe and Bolourchi's bend: 8 digits by an independent Simo-Reissner code, J = I_p, shear factor 1.
@pytest.mark.parametrize(
    "nu, load, tip",
    [
        (0.0, 300.0, (58.77912, 22.24478, 40.19189)),
        (0.0, 600.0, (47.15044, 15.68480, 53.47486)),
        (0.3, 300.0, (58.389945, 22.026183, 40.655535)),
    ],
)
def test_45_degree_bend(nu, load, tip):
    rod = RodProperties.from_section(25 * np.pi, 1e7, nu, 1.0, 1 / 12, 1 / 12, curvature=(0, 0, 0.01))
    solution = solve_rod(rod, RodLoads(tip_force=(0, 0, load)))
    assert solution.position[0] == pytest.approx(tip, abs=6e-6)
    assert solution.reference_position[0] == pytest.approx((100 * 2**-0.5, 100 * (1 - 2**-0.5), 0))


def test_short_cantilever_pins():
    """L 2, h .5, w .1, E 2.07e11, nu .3, k .849673, by an independent rod code: 62.5 kN and 62.5 MN."""
    rod = RodProperties.from_section(
        2.0, 2.07e11, 0.3, 0.05, 0.5 * 0.1**3 / 12, 0.1 * 0.5**3 / 12, shear_factors=(0.849673, 0.849673)
    )
    light = solve_rod(rod, RodLoads(tip_force=(0, 62.5e3, 0))).displacement[0]
    assert light[1] == pytest.approx(8.0990325e-4, abs=2e-11)
    heavy = solve_rod(rod, RodLoads(tip_force=(0, 62.5e6, 0))).displacement[0]
    assert (-heavy[0], heavy[1]) == pytest.approx((0.1509711, 0.7105686), abs=6e-8)


@pytest.mark.parametrize("weight", [1.0, 5.0, 20.0])
def test_cantilever_under_its_weight(weight):
    """EI theta'' = -q (1 - s) cos theta, by shooting from the tip in the plane."""
    tip = solve_rod(slender(), RodLoads(line_load=(0, weight, 0)))
    angle = np.arctan2(tip.frame[0, 1, 0], tip.frame[0, 0, 0])

    def slope(x, y):  # x from the tip
        return [y[1], -weight * x * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]

    end = solve_ivp(slope, (0, 1), [angle, 0, 0, 0], "DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
    assert abs(end[0]) < 1e-9
    assert tip.position[0] == pytest.approx([end[2], end[3], 0], abs=1e-9)


def test_hanging_rod_is_stretched_and_a_moment_bends_it_less():
    """Weight along the rod: u = q L^2/(2 EA), straight; the tension stiffens against a tip moment."""
    rod = RodProperties(1.0, 400.0, 150.0, 150.0, 0.8, 1.0, 1.0)
    straight = solve_rod(rod, RodLoads(line_load=(20, 0, 0)))
    assert straight.displacement[0] == pytest.approx([20 / 800, 0, 0], abs=1e-13)
    deflection = [
        np.linalg.norm(
            solve_rod(rod, RodLoads(line_load=(q, 0, 0), tip_moment=(0.6, 0.5, -0.8))).position[0, 1:]
        )
        for q in (0.0, 5.0, 20.0)
    ]
    assert deflection[0] > deflection[1] > deflection[2] > 0.1


def test_stations_agree_with_each_other_and_cost_no_accuracy():
    rod, loads = general_case()
    many = solve_rod(rod, loads, np.linspace(0, rod.length, 57))
    tip = solve_rod(rod, loads)
    assert np.abs(many.position[-1] - tip.position[0]).max() < 1e-12
    tangent = np.gradient(many.position, many.s, axis=0, edge_order=2)[20]
    stretch = many.frame[20].T @ tangent
    strain = 1 / np.array([rod.EA, rod.GA_y, rod.GA_z]) * (many.frame[20].T @ many.force[20])
    assert stretch == pytest.approx(np.array([1.0, 0, 0]) + strain, abs=1e-3)  # a second-order difference


def equations_of(load=10.0):
    zero = np.zeros(3)
    return RodEquations(
        compliance_n=np.array([1e-3, 2e-3, 3e-3]),
        compliance_m=np.array([1.3, 1.0, 0.6]),
        kappa0=np.array([0.2, -0.3, 0.5]),
        tip_force=np.array([0.0, load, 0.3 * load]),
        tip_moment=zero,
        body_force=zero,
        body_moment=zero,
        line_load=zero,
    )


def test_right_hand_side_derivatives_are_second_order_in_the_difference():
    """Central differences of step h err by O(h^2): two steps show the order, so the derivative is exact."""
    equations = equations_of()
    rng = np.random.default_rng(1)
    y, n, dy, dn = rng.normal(size=7), rng.normal(size=3), rng.normal(size=7), rng.normal(size=3)
    _, df_dy, df_dn, _ = equations.slope(y, n)
    exact = df_dy @ dy + df_dn @ dn

    def error(h):
        plus, minus = equations.slope(y + h * dy, n + h * dn)[0], equations.slope(y - h * dy, n - h * dn)[0]
        return np.abs((plus - minus) / (2 * h) - exact).max()

    assert error(1e-4) < 1e-6
    assert np.log10(error(1e-2) / error(1e-3)) == pytest.approx(2.0, abs=0.05)


def test_collocation_is_of_order_eight():
    equations = equations_of(3.0)
    end = np.array([1.0])

    def tip(elements):
        mesh = Collocation(elements, np.eye(3))
        result = mesh.newton(mesh.unstressed(equations), equations)
        assert result.state is not None, result.reason
        return mesh.evaluate(result.state, equations, end).position[0]

    exact = tip(32)
    errors = [np.abs(tip(N) - exact).max() for N in (2, 4)]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(8.0, abs=1.0)
    assert errors[1] < 1e-8


def test_estimated_error_bounds_the_true_one():
    v = np.array([0.6, 0.5, -0.8]) * 2
    solution = solve_rod(slender(), RodLoads(tip_moment=v), tolerance=1e-6)
    closed = helix_tip_moment(v, 1.0, 1.0, 1 / 1.3, 1.0)
    assert np.abs(solution.position - closed.position).max() <= solution.estimated_error < 1e-6


def test_failures_say_where_and_why(monkeypatch):
    with pytest.raises(RodNotSolved, match=r"beyond load factor 0 .*turns by"):
        monkeypatch.setattr(rod_module, "LARGEST_TURN", 1e-9)
        solve_rod(slender(), RodLoads(tip_moment=(0, 0, 1)))
    monkeypatch.undo()
    with pytest.raises(RodNotSolved, match="estimated error above"):
        monkeypatch.setattr(rod_module, "MOST_ELEMENTS", 47)
        solve_rod(slender(), RodLoads(tip_force=(0, 10, 0)), tolerance=1e-30)
    monkeypatch.undo()
    with pytest.raises(RodNotSolved, match=r"no equilibrium beyond load factor 0 .*Newton"):
        monkeypatch.setattr(rod_module, "SMALLEST_STEP", 0.5)
        solve_rod(slender(EA=3.0), RodLoads(tip_force=(-500.0, 1.0, 0)))
    monkeypatch.undo()
    with pytest.raises(ValueError, match="rotation matrix"):
        solve_rod(slender(base_rotation=2 * np.eye(3)), RodLoads())
    with pytest.raises(ValueError, match="between 0 and the length"):
        solve_rod(slender(), RodLoads(), s=[0.5, 1.2])


def test_section_constructors():
    round_rod = RodProperties.circle(2.0, 0.1, 5.0, 0.25)
    area, moment = np.pi * 0.01, np.pi * 1e-4 / 4
    assert (round_rod.EA, round_rod.GA_y, round_rod.GA_z) == pytest.approx((5 * area, 2 * area, 2 * area))
    assert (round_rod.GJ, round_rod.EI_y, round_rod.EI_z) == pytest.approx(
        (4 * moment, 5 * moment, 5 * moment)
    )
    flat = RodProperties.from_section(1.0, 5.0, 0.25, 1.0, 2.0, 3.0, J_t=4.0, shear_factors=(0.5, 0.25))
    assert RodProperties.from_section(1.0, 5.0, 0.25, 1.0, 2.0, 3.0).GJ == 10.0  # G (I_y + I_z)
    assert (flat.GA_y, flat.GA_z, flat.GJ, flat.EI_y, flat.EI_z) == (1.0, 0.5, 8.0, 10.0, 15.0)
