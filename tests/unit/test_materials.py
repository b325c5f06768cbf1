"""Hooke's law in Voigt form against the tensor formula, and the enhanced split."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ancf.materials import VOIGT, SaintVenantKirchhoff

poisson_ratios = st.floats(-0.99, 0.4999)
strains = st.lists(st.floats(-0.1, 0.1), min_size=6, max_size=6).map(np.array)


def tensor(strain):
    """Symmetric strain tensor of a Voigt vector whose shears are doubled."""
    E = np.zeros((3, 3))
    for value, (a, b) in zip(strain, VOIGT, strict=True):
        E[a, b] = E[b, a] = value if a == b else value / 2
    return E


@given(poisson_ratios, strains)
def test_full_hooke_is_lambda_trace_plus_two_mu(nu, strain):
    """S = lambda tr(E) I + 2 mu E (Saint Venant-Kirchhoff), order xx yy zz yz xz xy."""
    young = 7.0
    lame, mu = young * nu / ((1 + nu) * (1 - 2 * nu)), young / (2 * (1 + nu))
    E = tensor(strain)
    S = lame * np.trace(E) * np.eye(3) + 2 * mu * E
    found = SaintVenantKirchhoff(young, nu).hooke() @ strain
    np.testing.assert_allclose(found, [S[a, b] for a, b in VOIGT], atol=1e-12 * max(lame, young, mu))


@given(poisson_ratios)
def test_the_enhanced_split_adds_up_to_hooke(nu):
    material = SaintVenantKirchhoff(7.0, nu)
    volume, axis = material.enhanced()
    np.testing.assert_allclose(volume + axis, material.hooke(), atol=1e-12 * np.abs(material.hooke()).max())


def test_the_enhanced_parts_as_published():
    """theory.md 3: D0 = diag(E, E, E, G, k_z G, k_y G); Dv = E nu/((1+nu)(1-2nu))
    [[2nu,1,1],[1,2nu,1],[1,1,2nu]].
    """
    E, nu = 210.0, 0.3
    volume, axis = SaintVenantKirchhoff(E, nu).enhanced((0.7, 0.9))
    G = E / 2.6
    np.testing.assert_allclose(volume, np.diag([E, E, E, G, 0.9 * G, 0.7 * G]), rtol=1e-14)
    block = E * nu / (1.3 * 0.4) * np.array([[0.6, 1, 1], [1, 0.6, 1], [1, 1, 0.6]])
    np.testing.assert_allclose(axis[:3, :3], block, rtol=1e-14)
    assert not axis[3:].any()
    assert not axis[:, 3:].any()


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.499])
def test_uniaxial_stress_has_youngs_modulus_and_poissons_ratio(nu):
    """The compliance of Hooke's law: strain (1, -nu, -nu) sigma / E."""
    compliance = np.linalg.inv(SaintVenantKirchhoff(5.0, nu).hooke())
    np.testing.assert_allclose(compliance[0, :3], [0.2, -0.2 * nu, -0.2 * nu], rtol=1e-10, atol=1e-15)
