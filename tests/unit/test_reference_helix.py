"""Rotations, the helix under a tip moment, its inverse and the constant-curvature pose of `reference/`."""

from math import cos, pi, sin

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from reference import rotation as rot
from reference.analytic import (
    constant_curvature_moment,
    constant_curvature_pose,
    helix_inverse,
    helix_tip_moment,
    printed_eq47,
    space_moment,
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


@pytest.mark.parametrize(
    "v, e",
    [
        # Two roots of v.e = tau closer than the search grid (found in a random search, nu = .45).
        ((-3.70864429576, -3.87538290400, 1.38998246462), (-0.16429459263, -1.07436485823, 0.87304215262)),
        ((-3.09311035594, 2.78965189257, 2.40285734716), (2.22738608091, -0.05251938229, 1.20340283581)),
        # A double root: d(v.e - tau)/d tau = 0, so tau alone is known to the root of rounding only.
        ((5.84177863338 * cos(0.5), 3.50506718003 * sin(0.5), 4.67342290670 * sin(0.5)), (1, 0, 0)),
        ((4.92663448895 * cos(1.1), 2.95598069337 * sin(1.1), 3.94130759116 * sin(1.1)), (1, 0, 0)),
    ],
)
def test_inverse_at_nearly_double_roots(v, e):
    tip = helix_tip_moment(v, 1.0, 1.0, 1 / 1.45, 1.0, axis=e)
    answer = helix_inverse(tip.position[0], tip.rotation[0], 1.0, 1.0, 1 / 1.45, axis=e)
    assert np.abs(answer.moment - v).max() < 1e-12


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
