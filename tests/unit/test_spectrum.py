"""Eigenvalues of band matrices and of rods, against dense linear algebra."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

import ancf.spectrum
from ancf.band import BandPattern, negative_eigenvalues
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.newton import newton
from ancf.scene import Force, Rod, Scene, Support
from ancf.sections import Circle
from ancf.spectrum import Spectrum

EI = 1e6 * math.pi * 0.02**4 / 4


def band(n, b, seed, shift):
    """Random symmetric band matrix, dense and in flat band storage."""
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n))
    A = np.where(np.abs(np.subtract.outer(np.arange(n), np.arange(n))) <= b, A + A.T, 0.0) + shift * np.eye(n)
    pattern = BandPattern(n, b)
    flat = np.zeros(pattern.entries)
    rows, columns = np.nonzero(A)
    flat[pattern.slots(rows, columns)] = A[rows, columns]
    return A, pattern, flat


@given(n=st.integers(1, 40), b=st.integers(0, 9), seed=st.integers(0, 10_000), shift=st.floats(-4.0, 4.0))
def test_negative_eigenvalues_are_counted(n, b, seed, shift):
    """Haynsworth's theorem; `eigvalsh` is the reference. The last block may be shorter."""
    A, pattern, flat = band(n, min(b, n - 1), seed, shift)
    f = np.linalg.eigvalsh(A)
    if np.min(np.abs(f)) > 1e-9:
        assert negative_eigenvalues(pattern, flat) == np.count_nonzero(f < 0.0)


def cantilever(slenderness=50.0, force=(0.0, 0.0, 0.0), kind="clamp", direction="fixed", elements=8):
    rod = Rod(
        "rod",
        1.0,
        elements,
        Circle(1.0 / slenderness),
        SaintVenantKirchhoff(1e6, 0.3),
        supports=(Support(0.0, kind),),
    )
    return Model(Scene((rod,), forces=(Force("rod", 1.0, np.array(force), direction=direction),)))


def test_the_softest_modes_bend_the_rod_in_either_plane():
    """The clamped rod's lowest modes are two of equal stiffness, across the axis, largest at the tip."""
    model = cantilever()
    f, modes = Spectrum(model).lowest(model.q0, 0.0, 3)
    assert f[0] == pytest.approx(f[1], rel=1e-6)
    assert 0.0 < f[0] < 0.1 * f[2]
    for mode in modes[:, :2].T:
        shape = model.rods[0].nodal(mode)[:, 0]
        assert np.max(np.abs(shape[:, 0])) < 1e-6 * np.max(np.abs(shape))
        assert np.argmax(np.linalg.norm(shape, axis=1)) == len(shape) - 1
        assert np.max(np.abs(model.admissible(model.q0 + mode) - model.q0 - mode)) < 1e-12


@pytest.mark.parametrize("kind", ["clamp", "free_section_clamp"])
def test_lanczos_finds_what_the_dense_solver_finds(monkeypatch, kind):
    model = cantilever(force=(-3.0 * EI, 0.0, 0.0), kind=kind)
    q = newton(model, model.q0, 1.0, 20).q
    dense, _ = Spectrum(model).lowest(q, 1.0, 4)
    monkeypatch.setattr(ancf.spectrum, "SMALL", 0)
    sparse, modes = Spectrum(model).lowest(q, 1.0, 4)
    assert sparse[1] < 0.0
    np.testing.assert_allclose(sparse, dense, rtol=1e-6, atol=1e-9)
    S = Spectrum(model).matrix(model.q0, 1.0)
    assert modes.shape == (model.n, 4)
    assert S.shape[0] == model.unknowns


def test_held_motions_leave_the_low_spectrum():
    """Holding the first mode of a pair leaves the other; nothing else changes."""
    model = cantilever()
    spectrum = Spectrum(model)
    f, modes = spectrum.lowest(model.q0, 0.0, 4)
    held, _ = spectrum.lowest(model.q0, 0.0, 3, modes[:, :1].T)
    np.testing.assert_allclose(held, f[1:], rtol=1e-6)


@pytest.mark.parametrize("dense", [1000, 0])
def test_nearest_zero_of_a_follower_load(monkeypatch, dense):
    """Without its force the eigenvalue nearest zero is the lowest one; with it the tangent is unsymmetric."""
    monkeypatch.setattr(ancf.spectrum, "TINY", dense)
    model = cantilever(force=(-2.0 * EI, 0.0, 0.0), direction="follower")
    spectrum = Spectrum(model)
    f, mode = spectrum.nearest_zero(model.q0, 0.0)
    assert f == pytest.approx(spectrum.lowest(model.q0, 0.0, 1)[0][0], rel=1e-6)
    assert np.max(np.abs(mode)) > 0.0
    S = spectrum.matrix(model.q0, 1.0).toarray()
    assert np.max(np.abs(S - S.T)) > 1.0


@pytest.mark.parametrize("element", ["3333", "3243", "3363"])
def test_eigenvalues_do_not_depend_on_units(element):
    """S is dimensionless: a rod ten times as long, thick and 3000 times as stiff has the same spectrum."""
    found = []
    for size, young in ((1.0, 1e6), (10.0, 3e9)):
        rod = Rod("rod", size, 8, Circle(0.02 * size), SaintVenantKirchhoff(young, 0.3), element=element)
        model = Model(Scene((rod,)))
        found.append(Spectrum(model).lowest(model.q0, 0.0, 40)[0])
    np.testing.assert_allclose(found[1], found[0], rtol=1e-6)


@pytest.mark.parametrize("left", [False, True])
def test_modes_of_an_unsymmetric_tangent(left):
    """S psi = f psi from the right, S^T psi = f psi from the left."""
    model = cantilever(force=(-30.0 * EI, 4.0 * EI, 0.0), direction="follower")
    q = newton(model, model.q0, 0.3, 30).q
    spectrum = Spectrum(model)
    f, mode = spectrum.nearest_zero(q, 0.3, left=left)
    S = spectrum.matrix(q, 0.3)
    psi = (spectrum._B.T @ mode) / spectrum._D
    matrix = S.T if left else S
    size = abs(f) * np.linalg.norm(psi)
    assert np.linalg.norm(matrix @ psi - f * psi) < 1e-6 * size
    assert np.linalg.norm(matrix.T @ psi - f * psi) > 1e-3 * size


def test_held_motions_of_many_unknowns(monkeypatch):
    """Bordered Lanczos against the projected dense matrix, on a column whose modes come in pairs."""
    model = cantilever(force=(-3.0 * EI, 0.0, 0.0))  # beyond the Euler load of 2.47
    q = newton(model, model.q0, 1.0, 20).q
    spectrum = Spectrum(model)
    f, modes = spectrum.lowest(q, 1.0, 1)
    assert f[0] < 0.0
    monkeypatch.setattr(ancf.spectrum, "TINY", 1000)
    dense, _ = spectrum.lowest(q, 1.0, 4, modes.T)
    assert spectrum.negative_across(q, 1.0, modes.T) == 1
    monkeypatch.setattr(ancf.spectrum, "TINY", 0)
    sparse, found = spectrum.lowest(q, 1.0, 4, modes.T)
    np.testing.assert_allclose(sparse, dense, rtol=1e-6)
    assert spectrum.negative_across(q, 1.0, modes.T) == 1
    assert found.shape == (model.n, 4)
