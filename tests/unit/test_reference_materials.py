"""The laws of the solid reference against differences of their energies and against exact statements."""

from __future__ import annotations

import numpy as np
import pytest

from reference.rotation import exp
from reference.solid_materials import MooneyRivlin, NeoHookean, SaintVenantKirchhoff, SolidMaterial

LAWS: list[SolidMaterial] = [
    SaintVenantKirchhoff(3.0, 0.4),
    NeoHookean(3.0, 0.4),
    NeoHookean(3.0, -0.3),
    MooneyRivlin(0.7, 0.3, 9.0),
]
each_law = pytest.mark.parametrize(
    "law", LAWS, ids=lambda law: f"{type(law).__name__}-{law.poisson_ratio:.2g}"
)
IDENTITY = np.eye(3)


def gradients(count: int = 6, size: float = 0.25) -> np.ndarray:
    """Deformation gradients of large strain with positive determinant."""
    F = IDENTITY + size * np.random.default_rng(3).normal(size=(4 * count, 3, 3))
    return F[np.linalg.det(F) > 0.2][:count]


def difference(function, F: np.ndarray, h: float) -> np.ndarray:
    """Central difference of a function of F, the two indices of F last."""
    columns = []
    for k in range(3):
        for L in range(3):
            step = np.zeros((3, 3))
            step[k, L] = h
            columns.append((function(F + step) - function(F - step)) / (2 * h))
    return np.stack(columns, axis=-1).reshape(*columns[0].shape, 3, 3)


@each_law
def test_stress_and_tangent_are_derivatives_and_the_difference_error_is_of_second_order(law):
    F = gradients()
    for part in (law, law.shape):
        for function, exact in ((part.energy, part.stress(F)), (part.stress, part.tangent(F))):
            errors = [np.abs(difference(function, F, h) - exact).max() for h in (1e-3, 5e-4)]
            assert errors[1] < 1e-3
            # The energy of Saint Venant-Kirchhoff is a polynomial, but of degree four: order 2 as well.
            assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.05)


@each_law
def test_a_law_is_its_shape_part_and_the_energy_of_its_volume(law):
    F = gradients()
    g, g_F, g_FF = law.volume_measure(F)
    U, U_1, U_2 = law.volume_energy(g)
    np.testing.assert_allclose(law.energy(F), law.shape.energy(F) + U, rtol=1e-13)
    pair = np.einsum("nij,nkl->nijkl", g_F, g_F)
    stress = law.shape.stress(F) + U_1[:, None, None] * g_F
    tangent = (
        law.shape.tangent(F) + U_2[:, None, None, None, None] * pair + U_1[:, None, None, None, None] * g_FF
    )
    np.testing.assert_allclose(law.stress(F), stress, atol=1e-13 * np.abs(stress).max())
    np.testing.assert_allclose(law.tangent(F), tangent, atol=1e-13 * np.abs(tangent).max())
    np.testing.assert_allclose(difference(lambda x: law.volume_measure(x)[0], F, 1e-6), g_F, atol=1e-8)


@each_law
def test_small_strain_is_hooke_and_the_reference_is_free_of_stress(law):
    mu, lame = law.lame_mu, law.lame_lambda
    E, nu = law.young_modulus, law.poisson_ratio
    hooke = lame * np.einsum("iJ,kL->iJkL", IDENTITY, IDENTITY)
    hooke += mu * np.einsum("ik,JL->iJkL", IDENTITY, IDENTITY) + mu * np.einsum(
        "iL,Jk->iJkL", IDENTITY, IDENTITY
    )
    np.testing.assert_allclose(law.tangent(IDENTITY), hooke, atol=1e-13 * E)
    np.testing.assert_allclose(law.stress(IDENTITY), 0.0, atol=1e-15 * E)
    assert law.energy(IDENTITY) == pytest.approx(0.0, abs=1e-15 * E)
    assert mu == pytest.approx(E / (2 * (1 + nu)), rel=1e-14)
    assert lame == pytest.approx(E * nu / ((1 + nu) * (1 - 2 * nu)), rel=1e-13)


@each_law
def test_a_rotation_turns_the_stress_and_leaves_the_energy(law):
    F, Q = gradients(), exp(np.array([0.4, -1.1, 0.7]))
    np.testing.assert_allclose(law.energy(Q @ F), law.energy(F), rtol=1e-13)
    np.testing.assert_allclose(law.stress(Q @ F), Q @ law.stress(F), atol=1e-12)
    np.testing.assert_allclose(law.stress(F @ Q), law.stress(F) @ Q, atol=1e-12)  # isotropy


def test_incompressible_uniaxial_stress_of_mooney_rivlin():
    """P = 2 (lambda - lambda^-2)(c10 + c01/lambda) (Mooney 1940), the pressure taken from the free side."""
    stretch, law = 1.7, MooneyRivlin(0.7, 0.3, 1.0)
    side = stretch**-0.5
    P = law.shape.stress(np.diag([stretch, side, side]))
    found = P[0, 0] - P[1, 1] * side / stretch
    assert found == pytest.approx(2 * (stretch - stretch**-2) * (0.7 + 0.3 / stretch), rel=1e-13)


@pytest.mark.parametrize(
    ("make", "word"),
    [
        (lambda: NeoHookean(-1.0, 0.3), "young_modulus"),
        (lambda: NeoHookean(1.0, 0.5), "poisson_ratio"),
        (lambda: MooneyRivlin(0.1, -0.2, 1.0), "c10 [+] c01"),
        (lambda: MooneyRivlin(0.1, 0.2, 0.0), "bulk_modulus"),
    ],
)
def test_constants_out_of_range_are_refused(make, word):
    with pytest.raises(ValueError, match=word):
        make()
