"""Sections in their own axes against the polar rotation by singular values (rotation.py)."""

import numpy as np
import pytest
from hypothesis import given, strategies as st
from scipy.spatial.transform import Rotation

from ancf.rotation import hat, section_rotation
from ancf.section_spin import SectionAxes, cross, section_map

POINTS, NODAL = 5, 4
FIELD = np.array([0.3, -0.5, 0.7])


class Sections:
    """Random sections: weights W (m4, of size 1), bent and sheared directors, and a vector (3,)."""

    def __init__(self, seed, thin=1.0, strain=0.2):
        rng = np.random.default_rng(seed)
        E = Rotation.random(POINTS, rng=rng).as_matrix()[:, :2]
        share = rng.uniform(-0.3, 0.3, (POINTS, NODAL, 2)) * [1.0, thin]
        share[:, 1:3] += np.diag([1.0, thin])
        self.W = share @ E
        self.d = np.zeros((POINTS, NODAL, 3))
        self.d[:, 1:3] = E @ Rotation.random(rng=rng).as_matrix()
        self.d += strain * rng.uniform(-1.0, 1.0, self.d.shape)
        self.a = rng.uniform(-1.0, 1.0, 3)
        self.to_b, self.E = section_map(np.broadcast_to(np.eye(NODAL), (POINTS, NODAL, NODAL)), self.W)
        self.axes = SectionAxes.of(self.to_b @ self.d)
        self.rotation = section_rotation(self.d, self.W)
        self.spin = self.rotation.spin().reshape(POINTS, 3, -1)

    def to_directors(self, change):
        """Blocks (p, 3 directors, 3 directors) from those on b (p, 6, 6)."""
        J = np.einsum("pbn,ac->pbanc", self.to_b, np.eye(3)).reshape(POINTS, 6, 3 * NODAL)
        return np.swapaxes(J, 1, 2) @ change.reshape(POINTS, 6, 6) @ J


seeds = given(st.integers(0, 2**20))


@seeds
def test_axes_turn_with_the_section(seed):
    """F = R E: with the axes E of the weights in the reference, the polar rotation."""
    s = Sections(seed)
    R = np.einsum("bip,pbj->pij", s.axes.F, s.E)
    np.testing.assert_allclose(R, s.rotation.R, rtol=0, atol=1e-13)
    np.testing.assert_allclose(np.linalg.det(s.E), 1.0, rtol=0, atol=1e-13)


@pytest.mark.parametrize("thin", [1e-2, 1e-4])
def test_thin_sections_lose_no_more_than_their_weights(thin):
    """One second moment so much smaller, about axes of any direction: rounding of the weights, eps of the
    larger one, turns the section by eps/thin in any algorithm."""
    for seed in range(20):
        s = Sections(seed, thin, strain=0.0)
        R = np.einsum("bip,pbj->pij", s.axes.F, s.E)
        np.testing.assert_allclose(R, s.rotation.R, rtol=0, atol=20.0 * np.finfo(float).eps / thin)


@seeds
def test_couples_by_their_kind(seed):
    """Forces and tangents of the three kinds of couples against `SectionRotation`."""
    s = Sections(seed)
    turning = (s.E @ s.a).T  # components of a vector that turns with the section
    in_space = np.einsum("bp,bip->pi", turning, s.axes.F)
    field = s.axes.local(FIELD)
    cases = {
        "fixed": (s.axes.local(s.a), hat(s.axes.local(s.a).T), np.tile(s.a, (POINTS, 1)), 0.0),
        "turning": (turning, None, in_space, -hat(in_space) @ s.spin),
        "magnetic": (
            cross(turning, field),
            hat(turning.T) @ hat(field.T),
            np.cross(in_space, FIELD),
            hat(FIELD) @ hat(in_space) @ s.spin,
        ),
    }
    for name, (M, A, couple, change) in cases.items():
        mu = s.axes.mu(M)
        Q = np.swapaxes(s.to_b, 1, 2) @ s.axes.couple(mu)
        np.testing.assert_allclose(Q, s.rotation.couple(couple), rtol=0, atol=1e-12, err_msg=name)
        K = s.to_directors(s.axes.couple_tangent(mu, A))
        expected = s.rotation.couple_tangent(couple, change, s.spin)
        np.testing.assert_allclose(K, expected, rtol=0, atol=1e-11, err_msg=name)


@seeds
def test_vectors_that_turn(seed):
    """f = R f_0 and df = dw x f."""
    s = Sections(seed)
    f = (s.E @ s.a).T
    expected = s.rotation.R @ s.a
    np.testing.assert_allclose(s.axes.vector(f), expected, rtol=0, atol=1e-13)
    J = np.einsum("pbn,ac->pbanc", s.to_b, np.eye(3)).reshape(POINTS, 6, 3 * NODAL)
    change = s.axes.vector_change(hat(f.T)).reshape(POINTS, 3, 6) @ J
    np.testing.assert_allclose(change, -hat(expected) @ s.spin, rtol=0, atol=1e-12)


def test_a_section_that_has_collapsed_is_not_finite():
    """Both vectors along one line: no plane, no rotation."""
    b = np.array([[[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]]])
    with np.errstate(divide="ignore", invalid="ignore"):
        assert not np.isfinite(SectionAxes.of(b).F).all()
