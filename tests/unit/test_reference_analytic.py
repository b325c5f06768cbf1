"""Closed forms of `reference/` against numerical integration, minimisation and each other."""

from math import cos, cosh, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

from reference import rotation as rot
from reference.analytic import (
    BendingSection,
    constant_curvature_moment,
    constant_curvature_pose,
    elastica_tip_force,
    euler_load,
    full_hooke_locking_factor,
    helix_inverse,
    helix_tip_moment,
    lateral_buckling_load,
    printed_eq47,
    pure_bending_curvature,
    pure_bending_moment,
    self_weight_load,
    space_moment,
    torsion_constant_bilinear_section,
    torsion_constant_circle,
    torsion_constant_ellipse,
    torsion_constant_linear_section,
    torsion_constant_rectangle,
    twist_angle,
    uniaxial_neo_hookean,
    uniaxial_saint_venant_kirchhoff,
)

vectors = st.tuples(*[st.floats(-3.4, 3.4)] * 3).map(np.array)


# ---- rotations ---------------------------------------------------------------------------------------------


@settings(deadline=None)
@given(vectors)
def test_exponential_is_scipys(v):
    """SciPy's Rotation is an independent implementation."""
    assert np.abs(rot.exp(v) - Rotation.from_rotvec(v).as_matrix()).max() < 1e-14


@settings(deadline=None)
@given(vectors)
def test_logarithm_inverts_the_exponential(v):
    assert np.abs(rot.exp(rot.log(rot.exp(v))) - rot.exp(v)).max() < 1e-14
    assert np.linalg.norm(rot.log(rot.exp(v))) <= pi + 1e-14
    assert np.abs(rot.matrix(rot.quaternion(rot.exp(v))) - rot.exp(v)).max() < 1e-14


@pytest.mark.parametrize("angle", [0.0, 1e-12, 1e-5, 0.999e-2, 1.001e-2, 0.5, 3.0, 6.0])
def test_integrated_exponential_by_quadrature(angle):
    """Gauss quadrature with 40 points is exact to rounding; both sides of the Taylor limit are visited."""
    v = angle * np.array([0.48, -0.6, 0.64])
    x, w = np.polynomial.legendre.leggauss(40)
    direct = np.einsum("i,iab->ab", w / 2, rot.exp((x[:, None] + 1) / 2 * v))
    assert np.abs(rot.exp_integral(v) - direct).max() < 2e-15 * 10


# ---- helix -------------------------------------------------------------------------------------------------


def integrate_round_rod(M, EI, GJ, e, length, s):
    """r' = t, R' = [kappa_space] R with kappa = R C^-1 R^T M, by DOP853: no closed form used."""
    P = np.outer(e, e)
    compliance = P / GJ + (np.eye(3) - P) / EI

    def slope(_, y):
        R = y[3:].reshape(3, 3)
        return np.concatenate([R @ e, (rot.hat(R @ compliance @ R.T @ M) @ R).ravel()])

    start = np.concatenate([np.zeros(3), np.eye(3).ravel()])
    y = solve_ivp(slope, (0, length), start, "DOP853", t_eval=s, rtol=1e-13, atol=1e-14).y.T
    return y[:, :3], y[:, 3:].reshape(-1, 3, 3)


@pytest.mark.parametrize("direction", ["fixed", "follower"])
def test_helix_solves_the_rod_equations(direction):
    EI, GJ, L = 0.7, 0.5, 1.3
    e = np.array([0.36, 0.48, 0.8])
    M_ref = np.array([1.1, -0.8, 0.9])
    s = np.linspace(0, L, 9)
    shape = helix_tip_moment(M_ref, L, EI, GJ, s, axis=e, direction=direction)
    M = M_ref if direction == "fixed" else shape.rotation[-1] @ M_ref  # the definition of a follower
    position, rotation = integrate_round_rod(M, EI, GJ, e, L, s)
    assert np.abs(shape.position - position).max() < 1e-12
    assert np.abs(shape.rotation - rotation).max() < 1e-12
    assert np.abs(space_moment(M_ref, L, EI, GJ, e, direction) - M).max() < 1e-14


def test_follower_and_fixed_agree_iff_psi_is_a_whole_turn_or_no_bending():
    """psi = (M.e) L (1/GJ - 1/EI): one full turn of psi, or M along e, makes both shapes equal."""
    EI, L = 1.0, 1.0
    M = np.array([2.0, 1.0, 0.5])
    whole_turn_GJ = 1 / (1 + 2 * pi / 2.0)  # 1/GJ - 1 = pi, so psi = 2 pi at M.e = 2
    for moment, GJ, equal in (
        (M, whole_turn_GJ, True),
        (np.array([2.0, 0, 0]), 0.7, True),
        (M, 0.7, False),
        (np.array([0, 1.0, 0.5]), 0.7, True),
    ):
        fixed = helix_tip_moment(moment, L, EI, GJ, L)
        follower = helix_tip_moment(moment, L, EI, GJ, L, direction="follower")
        assert bool(np.abs(fixed.position - follower.position).max() < 1e-13) is equal
        assert bool(np.abs(fixed.rotation - follower.rotation).max() < 1e-13) is equal


def test_helix_position_does_not_see_the_torsional_stiffness_and_torsion_does_not_move_the_tip():
    M, s = np.array([0.9, 2.0, -1.0]), np.linspace(0, 1, 5)
    assert np.array_equal(
        helix_tip_moment(M, 1, 1, 0.4, s).position, helix_tip_moment(M, 1, 1, 0.9, s).position
    )
    twisted = helix_tip_moment([2.5, 0, 0], 1.0, 1.0, 0.5, 1.0)
    assert np.abs(twisted.position - [1, 0, 0]).max() < 1e-15
    assert np.abs(twisted.rotation[0] - rot.exp([5.0, 0, 0])).max() < 1e-15  # angle M L/GJ


def test_helix_is_smooth_through_zero():
    """Small loads: w = M L^2/(2 EI), linear theory, with a relative error of order angle^2/12."""
    for angle in (1e-300, 1e-9, 1e-4, 9.99e-3, 1.001e-2):
        tip = helix_tip_moment([0, 0, angle], 1.0, 1.0, 0.77, 1.0).position[0]
        assert tip[1] / angle == pytest.approx(0.5, rel=angle**2 / 11 + 1e-15)
    assert np.array_equal(helix_tip_moment([0, 0, 0], 1.0, 1.0, 0.7, 1.0).position[0], [1, 0, 0])


@settings(deadline=None, max_examples=40)
@given(vectors, st.sampled_from([0.0, 0.3, 0.499]), vectors.filter(lambda v: np.linalg.norm(v) > 0.1))
def test_inverse_recovers_the_moment(v, nu, e):
    """Every |v| up to 5.9 here; torsion alone (position independent of v) is left to its own test."""
    e = e / np.linalg.norm(e)
    if np.linalg.norm(np.cross(v, e)) < 1e-3:
        return
    EI, L = 2.0, 0.4
    tip = helix_tip_moment(v * EI / L, L, EI, EI / (1 + nu), L, axis=e)
    answer = helix_inverse(tip.position[0], tip.rotation[0], L, EI, EI / (1 + nu), axis=e)
    assert np.abs(answer.moment * L / EI - v).max() < 1e-9
    assert max(answer.rotation_mismatch, answer.position_mismatch) < 1e-12


@pytest.mark.parametrize(
    "v", [(0, 0, 0), (1.0, 0, 0), (0, 2 * pi, 0), (0, pi, 0), (3.0, 0, 5.520726184512091)]
)
def test_inverse_at_exceptional_poses(v):
    """No load, torsion, a closed circle, half a circle, a full turn of an inclined helix (|v| = 2 pi)."""
    tip = helix_tip_moment(v, 1.0, 1.0, 1 / 1.3, 1.0)
    answer = helix_inverse(tip.position[0], tip.rotation[0], 1.0, 1.0, 1 / 1.3)
    again = helix_tip_moment(answer.moment, 1.0, 1.0, 1 / 1.3, 1.0)
    assert np.abs(again.position - tip.position).max() < 1e-12
    assert np.abs(again.rotation - tip.rotation).max() < 1e-12
    assert np.linalg.norm(answer.moment) == pytest.approx(np.linalg.norm(v), abs=1e-12)


def test_inverse_tells_an_unreachable_pose():
    tip = helix_tip_moment([0.3, 1.0, 0.5], 1.0, 1.0, 1 / 1.3, 1.0)
    answer = helix_inverse(tip.position[0] + [0, 0.1, 0], tip.rotation[0], 1.0, 1.0, 1 / 1.3)
    assert answer.rotation_mismatch < 1e-12
    assert answer.position_mismatch == pytest.approx(0.1, rel=1e-9)
    with pytest.raises(ValueError, match="no tip moment"):
        helix_inverse(tip.position[0], tip.rotation[0], 1.0, 1.0, 1 / 1.3, largest_angle=0.5)


# ---- constant curvature, paper eq. 47-48 -------------------------------------------------------------------


@pytest.mark.parametrize("theta, phi", [(0.0, 0.4), (1e-9, 2.0), (pi / 2, 0.9), (2 * pi, -2.2), (-1.3, 0.3)])
def test_constant_curvature_is_the_helix_without_torsion(theta, phi):
    L, EI = 0.4, 3.0
    pose = constant_curvature_pose(theta, phi, L)
    helix = helix_tip_moment(constant_curvature_moment(theta, phi, L, EI), L, EI, 2.1, L, axis=(0, 0, 1))
    assert np.abs(pose.position - helix.position).max() < 1e-15
    assert np.abs(pose.rotation - helix.rotation).max() < 1e-15
    # In the paper's frame (eq. 3) the same moment has no component along the arm.
    A_o = np.array([[0, 0, -1], [0, 1, 0], [1, 0, 0]])
    body = A_o.T @ constant_curvature_moment(theta, phi, L, EI)
    assert body == pytest.approx(EI * theta / L * np.array([0, -np.cos(phi), -np.sin(phi)]))


def test_printed_eq47_is_no_rotation():
    """As printed, R^T R - I has entries up to 1.3; corrected it vanishes."""
    worst = 0.0
    for theta in np.linspace(0, 2 * pi, 121):
        for phi in np.linspace(0, pi, 61):
            R = printed_eq47(theta, phi)
            worst = max(worst, float(np.abs(R.T @ R - np.eye(3)).max()))
            good = constant_curvature_pose(theta, phi, 1.0).rotation[0]
            assert np.abs(good.T @ good - np.eye(3)).max() < 1e-15 * 4
    assert worst == pytest.approx(1.3, abs=0.01)


# ---- finite-strain pure bending ----------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["rigid", "stretching"])
@pytest.mark.parametrize("shape", ["circle", "rectangle"])
def test_bending_minimises_the_energy(model, shape):
    """Energy by quadrature over the section and minimised over lambda (and a); moment by its derivative."""
    R = h = 1.0
    x, w = np.polynomial.legendre.leggauss(60)
    if shape == "circle":
        section = BendingSection.circle(R)
        y, weight = R * x, w * R * 2 * np.sqrt(R**2 - (R * x) ** 2)  # chords
        angle = (x + 1) * pi / 2  # y = R cos(angle) makes the chord integral smooth
        y, weight = R * np.cos(angle), w * pi / 2 * 2 * (R * np.sin(angle)) ** 2
    else:
        section = BendingSection.rectangle(h, 0.7)
        y, weight = h / 2 * x, w * h / 2 * 0.7

    def energy(unknowns, kappa):
        stretch, a = unknowns[0], (unknowns[1] if model == "stretching" else 1.0)
        along = ((stretch - kappa * a * y) ** 2 - 1) / 2
        return float(weight @ (along**2 + ((a**2 - 1) / 2) ** 2)) / 2

    def least(kappa):
        start = np.ones(2 if model == "stretching" else 1)
        return minimize(lambda u: 1e3 * energy(u, kappa), start, method="BFGS", options={"gtol": 1e-9})

    kappa, d = 0.2, 1e-3
    state = pure_bending_moment(kappa, 1.0, section, model)
    found = least(kappa).x
    assert state.axial_stretch == pytest.approx(found[0], abs=1e-7)
    if model == "stretching":
        assert state.section_stretch == pytest.approx(found[1], abs=1e-7)
    slopes = [(least(kappa + k * d).fun - least(kappa - k * d).fun) / (2 * k * d) / 1e3 for k in (1, 2)]
    assert state.moment == pytest.approx((4 * slopes[0] - slopes[1]) / 3, rel=1e-7)


@pytest.mark.parametrize("theta, growth", [(pi / 4, 1.002131), (pi / 2, 1.008652), (pi, 1.036886)])
def test_bending_values_of_an_independent_derivation(theta, growth):
    """kappa L/theta at L/R = 20, nu = 0, worked out by others before this code existed (six digits)."""
    L, section = 20.0, BendingSection.circle(1.0)
    state = pure_bending_curvature(theta * section.second_moment / L, 1.0, section)
    assert state.curvature * L / theta == pytest.approx(growth, abs=6e-7)


def test_bending_limits_signs_and_inverse():
    section = BendingSection.circle(1.0)
    EI = section.second_moment
    for model, coefficient in (("stretching", 1.375), ("rigid", 0.875)):
        state = pure_bending_curvature(1e-3 * EI, 1.0, section, model)
        assert (state.curvature / 1e-3 - 1) / 1e-6 == pytest.approx(coefficient, rel=2e-5)
        assert pure_bending_curvature(-1e-3 * EI, 1.0, section, model).curvature == -state.curvature
        assert pure_bending_curvature(0.0, 1.0, section, model).curvature == 0.0
        strong = pure_bending_curvature(0.2 * EI, 1.0, section, model)
        assert pure_bending_moment(strong.curvature, 1.0, section, model).moment == pytest.approx(0.2 * EI)
        with pytest.raises(ValueError, match="exceeds the largest"):
            pure_bending_curvature(0.9 * EI, 1.0, section, model)
    box = pure_bending_moment(0.1, 1.0, BendingSection.rectangle(1.0, 1.0), "rigid")
    assert box.moment == pytest.approx(0.1 / 12 * (1 - 0.30 * 0.01), rel=1e-14)
    along, across, angle = box.tip(7.0)
    radius = box.axial_stretch / box.curvature
    assert (along, across) == pytest.approx((radius * sin(angle), radius * (1 - cos(angle))), rel=1e-14)


# ---- elastica ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("load", [1e-4, 0.2999, 0.3001, 1.0, 5.0, 10.0, 40.0])
def test_elastica_solves_its_equation(load):
    """theta'' = -P cos theta from the tip (theta' = 0) must reach theta = 0 at the clamp."""
    tip = elastica_tip_force(load)

    def slope(_, y):
        return [y[1], -load * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]

    end = solve_ivp(slope, (0, 1), [tip.angle, 0, 0, 0], "DOP853", rtol=1e-13, atol=1e-16).y[:, -1]
    assert abs(end[0]) < 1e-12 * cosh(sqrt(load))  # growth of an error in the tip angle
    assert 1 - end[2] == pytest.approx(tip.u, abs=1e-12)
    assert end[3] == pytest.approx(tip.w, abs=1e-12)


def test_elastica_values_of_an_independent_code():
    """Ten printed digits by others; their w is 2e-10, 5e-10, 1.0e-9 too large at loads 2, 5, 10."""
    rows = {
        1: (0.0564332363, 0.3017207739, 0.4613519497),
        2: (0.1606417208, 0.4934574806, 0.7817498316),
        5: (0.3876283607, 0.7137915241, 1.2153681176),
        10: (0.5549955978, 0.8106090259, 1.4302855388),
    }
    for load, row in rows.items():
        tip = elastica_tip_force(load)
        assert (tip.u, tip.angle) == pytest.approx((row[0], row[2]), abs=1e-10)
        assert tip.w == pytest.approx(row[1], abs=2e-9)


def test_elastica_limits():
    """Linear theory (P/3, P^2/15, P/2) below; w -> 1 - (2 - sqrt 2)/alpha, u -> 1 - sqrt 2/alpha above."""
    small = elastica_tip_force(1e-5)
    assert (small.w, small.angle, small.u) == pytest.approx((1e-5 / 3, 5e-6, 1e-10 / 15), rel=1e-9)
    large = elastica_tip_force(1e4)
    assert (large.w, large.u) == pytest.approx((1 - (2 - sqrt(2)) / 100, 1 - sqrt(2) / 100), abs=1e-12)
    assert elastica_tip_force(-3.0).w == -elastica_tip_force(3.0).w
    assert elastica_tip_force(-3.0).u == elastica_tip_force(3.0).u
    assert elastica_tip_force(0.0).w == 0.0


# ---- torsion -----------------------------------------------------------------------------------------------


def ritz_torsion_constant(a, b, degree=14):
    """Largest of (int phi)^2/int |grad phi|^2 over (1 - x^2)(1 - y^2) times polynomials: J = 4 x that."""
    x, w = np.polynomial.legendre.leggauss(40)
    bubble, slope = 1 - x**2, -2 * x
    P = [np.polynomial.legendre.Legendre.basis(k) for k in range(0, degree, 2)]
    f = np.array([bubble * p(x) for p in P])
    df = np.array([slope * p(x) + bubble * p.deriv()(x) for p in P])
    mass, stiff, mean = (f * w) @ f.T, (df * w) @ df.T, f @ w
    K = np.kron(stiff, mass) * (b / a) + np.kron(mass, stiff) * (a / b)
    F = np.kron(mean, mean) * a * b / 4
    return 4 * float(F @ np.linalg.solve(K, F))


@pytest.mark.parametrize("a, b, printed", [(1.0, 1.0, 0.140577), (2.0, 1.0, 0.22868), (10.0, 1.0, 0.3123)])
def test_rectangle_torsion_by_ritz(a, b, printed):
    """Prandtl's stress function by a polynomial Ritz method; printed: Timoshenko and Goodier, table 7."""
    J = torsion_constant_rectangle(a, b)
    assert pytest.approx(ritz_torsion_constant(a, b), rel=1e-6 if a < 5 else 2e-4) == J
    assert J / (a * b**3) == pytest.approx(printed, abs=6e-5)
    assert torsion_constant_rectangle(b, a) == J


def test_other_torsion_constants():
    assert torsion_constant_rectangle(1, 1) == pytest.approx(0.1405770149551536, abs=1e-13)
    R = 0.3
    assert torsion_constant_circle(R) == pytest.approx(torsion_constant_ellipse(R, R), rel=1e-15)
    assert torsion_constant_circle(R, 0.299) == pytest.approx(
        2 * pi * 0.2995**3 * 0.001, rel=1e-5
    )  # thin tube
    assert torsion_constant_circle(R) == pytest.approx(
        torsion_constant_linear_section(pi * R**4 / 4, pi * R**4 / 4)
    )
    # 2:1 rectangle, a = 2, b = 1: I_y = 1/6, I_z = 2/3; warping c y z minimises the energy
    c = np.linspace(-1, 1, 200001)
    least = ((c - 1) ** 2 / 6 + (c + 1) ** 2 * 2 / 3).min()
    assert torsion_constant_bilinear_section(1 / 6, 2 / 3) == pytest.approx(least, rel=1e-9)
    assert torsion_constant_bilinear_section(1 / 6, 2 / 3) / 2 == pytest.approx(0.266667, abs=1e-6)
    assert torsion_constant_linear_section(1 / 12, 1 / 12) == pytest.approx(0.166667, abs=1e-6)
    assert twist_angle(3.0, 2.0, 4.0) == 1.5


# ---- buckling ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "ends", ["clamped-free", "pinned-pinned", "clamped-pinned", "clamped-clamped", "clamped-guided"]
)
def test_euler_load_is_the_first_singular_load(ends):
    """w'''' + k^2 w'' = 0 with w = 1, x, cos kx, sin kx: the boundary rows are singular at P, not below."""

    def rows(k):
        c, s = np.cos(k), np.sin(k)
        at = {
            "w0": [1, 0, 1, 0],
            "d0": [0, 1, 0, k],
            "m0": [0, 0, -(k**2), 0],
            "w1": [1, 1, c, s],
            "d1": [0, 1, -k * s, k * c],
            "m1": [0, 0, -(k**2) * c, -(k**2) * s],
            "q1": [0, k**2, 0, 0],  # w''' + k^2 w'
        }
        names = {
            "clamped-free": "w0 d0 m1 q1",
            "pinned-pinned": "w0 m0 w1 m1",
            "clamped-pinned": "w0 d0 w1 m1",
            "clamped-clamped": "w0 d0 w1 d1",
            "clamped-guided": "w0 d0 d1 q1",
        }[ends]
        return np.linalg.det(np.array([at[n] for n in names.split()], float))

    k = sqrt(euler_load(1.0, 1.0, ends))
    below = [rows(x) for x in np.linspace(0.2, 0.98, 60) * k]
    assert abs(rows(k)) < 1e-9 * max(map(abs, below))
    assert min(map(abs, below)) > 1e-6 * max(map(abs, below))
    assert euler_load(3.0, 2.0, ends) == pytest.approx(k**2 * 0.75)


def test_euler_load_names_the_choices():
    with pytest.raises(ValueError, match="clamped-free"):
        euler_load(1.0, 1.0, "free-free")


def test_self_weight_and_lateral_buckling_by_integration():
    """The linear equations from the free end: the clamp condition is met at the load, and not before it."""

    def first_sign(power, load):
        def slope(x, y):
            return [y[1], -load * x**power * y[0]]

        run = solve_ivp(slope, (0, 1), [1.0, 0.0], "DOP853", rtol=1e-12, atol=1e-14, dense_output=True)
        return run.y[0, -1], run.sol(np.linspace(0, 0.99, 100))[0].min()

    end, before = first_sign(1, self_weight_load(1.0, 1.0))
    assert abs(end) < 1e-10 and before > 0
    end, before = first_sign(2, lateral_buckling_load(1.0, 1.0, 1.0) ** 2)
    assert abs(end) < 1e-10 and before > 0
    assert self_weight_load(1.0, 1.0) == pytest.approx(7.8373, abs=5e-5)  # Greenhill 1881
    assert lateral_buckling_load(1.0, 1.0, 1.0) == pytest.approx(4.012599344, abs=1e-9)  # Prandtl 1899: 4.013
    assert self_weight_load(2.0, 3.0) == pytest.approx(7.8373474 * 2 / 27, rel=1e-7)
    assert lateral_buckling_load(2.0, 8.0, 2.0) == pytest.approx(4.012599344)


# ---- uniaxial ----------------------------------------------------------------------------------------------


@settings(deadline=None)
@given(st.floats(-0.19, 3.0), st.floats(0.0, 0.2))
def test_saint_venant_kirchhoff_stretch_minimises_the_energy(f, nu):
    """Full three-dimensional energy: both derivatives by the stretches vanish."""
    stretch = uniaxial_saint_venant_kirchhoff(f, 1.0, nu, 1.0)
    lam, mu = nu / ((1 + nu) * (1 - 2 * nu)), 1 / (2 * (1 + nu))
    along, across = (stretch.axial**2 - 1) / 2, (stretch.lateral**2 - 1) / 2
    trace = along + 2 * across
    assert stretch.axial * (lam * trace + 2 * mu * along) == pytest.approx(f, abs=1e-13)
    assert lam * trace + 2 * mu * across == pytest.approx(0, abs=1e-13)
    assert stretch.axial >= 1 / sqrt(3)


def test_uniaxial_limits():
    assert uniaxial_saint_venant_kirchhoff(0.0, 1.0, 0.3, 1.0).axial == pytest.approx(1.0, abs=1e-15)
    with pytest.raises(ValueError, match="no equilibrium"):
        uniaxial_saint_venant_kirchhoff(-0.2, 1.0, 0.3, 1.0)
    with pytest.raises(ValueError, match="shrinks"):
        uniaxial_saint_venant_kirchhoff(3.0, 1.0, 0.4, 1.0)
    # mu = 9e5 Pa, A = .01 m2, 9500 N: lambda - lambda^-2 = 1.0556 at lambda = 1.5
    assert uniaxial_neo_hookean(9500.0, 9e5, 0.01).axial == pytest.approx(1.5, abs=1e-14)
    for f in (-5.0, -0.1, 0.0, 4.0):
        x = uniaxial_neo_hookean(f, 1.0, 1.0)
        assert x.axial - x.axial**-2 == pytest.approx(f, abs=1e-12)
        assert x.axial * x.lateral**2 == pytest.approx(1.0)


def test_locking_factor_is_the_oedometric_modulus():
    """Hooke's matrix with zero lateral strain; the numbers were measured by others on elements."""
    for nu, printed in ((0.3, 1.3462), (0.45, 3.7931), (0.49, 17.114)):
        compliance = np.full((3, 3), -nu) + (1 + nu) * np.eye(3)
        assert full_hooke_locking_factor(nu) == pytest.approx(np.linalg.inv(compliance)[0, 0], rel=1e-12)
        assert full_hooke_locking_factor(nu) == pytest.approx(printed, rel=5e-5)
    assert full_hooke_locking_factor(0.0) == 1.0
