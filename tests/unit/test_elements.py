"""Shape functions: nodality, partition of unity, completeness, derivatives."""

from math import factorial

import numpy as np
import pytest

from ancf.elements import ELEMENTS, SECTION_ELEMENTS

# Polynomial degree along x that each director must reproduce: (axis, section vectors). Hermite cubic axis
# with two
# slopes and linear section vectors for 3243; three-node Lagrange for 3333, 3363
# (Nachbagauer, Gruber, Gerstmayr 2013).
DEGREES = {"3243": (3, 1), "3333": (2, 2), "3343": (2, 2), "3363": (2, 2), "cable": (3, 3)}
H = 0.37  # m, any length

every_element = pytest.mark.parametrize("element", ELEMENTS.values(), ids=lambda e: e.name)


def derivative(coefficients, order, x):
    return (
        np.polynomial.Polynomial(coefficients).deriv(order)(x)
        if order
        else np.polynomial.Polynomial(coefficients)(x)
    )


@every_element
def test_a_vector_is_its_own_value_at_its_node_and_zero_at_the_others(element):
    per_node = len(element.vectors)
    for order in {v[0] for v in element.vectors}:
        N = element.shape(np.array(element.node_xi), H, derivative=order)
        for node in range(len(element.node_xi)):
            for v, (x_order, j, k) in enumerate(element.vectors):
                if x_order != order:
                    continue
                expected = np.zeros(element.vectors_per_element)
                expected[node * per_node + v] = 1.0
                director = element.directors.index((j, k))
                np.testing.assert_allclose(N[node, director], expected, atol=1e-13)


@every_element
def test_positions_are_a_partition_of_unity(element):
    xi = np.linspace(-1.0, 1.0, 7)
    positions = [
        i
        for i in range(element.vectors_per_element)
        if element.vectors[i % len(element.vectors)] == (0, 0, 0)
    ]
    np.testing.assert_allclose(element.shape(xi, H)[:, 0, positions].sum(axis=1), 1.0, atol=1e-14)
    np.testing.assert_allclose(
        element.shape(xi, H, derivative=1)[:, 0, positions].sum(axis=1), 0.0, atol=1e-12
    )


@every_element
@pytest.mark.parametrize("order", [0, 1, 2])
def test_polynomials_are_reproduced_with_their_derivatives(element, order):
    rng = np.random.default_rng(1)
    xi = np.linspace(-1.0, 1.0, 9)
    nodes_x = 0.5 * H * (1.0 + np.array(element.node_xi))
    for director, monomial in enumerate(element.directors):
        coefficients = rng.normal(size=DEGREES[element.name][min(director, 1)] + 1)
        e = np.zeros(element.vectors_per_element)
        for node, x in enumerate(nodes_x):
            for v, (x_order, j, k) in enumerate(element.vectors):
                if (j, k) == monomial:
                    e[node * len(element.vectors) + v] = derivative(coefficients, x_order, x)
        found = element.shape(xi, H, derivative=order)[:, director] @ e
        expected = derivative(coefficients, order, 0.5 * H * (1.0 + xi))
        np.testing.assert_allclose(found, expected, atol=1e-11)


@every_element
def test_directors_interpolate_only_their_own_vectors(element):
    N = element.shape(np.array([-0.4, 0.8]), H)
    for director, monomial in enumerate(element.directors):
        foreign = [
            i
            for i in range(element.vectors_per_element)
            if element.vectors[i % len(element.vectors)][1:] != monomial
        ]
        assert not N[:, director, foreign].any()


@every_element
def test_section_monomials_are_taylor_terms(element):
    """phi = y^j z^k / (j! k!), so that the nodal vector is the derivative itself; slopes by differences."""
    y, z, t = 0.3, -0.7, 1e-6
    phi, phi_y, phi_z = element.section_monomials(np.array([y]), np.array([z]))
    expected = [y**j * z**k / (factorial(j) * factorial(k)) for j, k in element.directors]
    np.testing.assert_allclose(phi[0], expected, rtol=1e-15)
    ahead = element.section_monomials(np.array([y + t, y]), np.array([z, z + t]))[0]
    behind = element.section_monomials(np.array([y - t, y]), np.array([z, z - t]))[0]
    np.testing.assert_allclose(phi_y[0], (ahead - behind)[0] / (2 * t), atol=1e-9)
    np.testing.assert_allclose(phi_z[0], (ahead - behind)[1] / (2 * t), atol=1e-9)


def test_the_names_count_the_vectors():
    """Digital nomenclature: dimension, nodes, vectors a node, components (architecture.md, Names)."""
    for name, element in SECTION_ELEMENTS.items():
        assert name == element.name == f"3{len(element.node_xi)}{len(element.vectors)}3"


def test_default_axial_rules():
    """interface.md: 2 points for 3333, 3 for 3243; full is 3 points or more for 3333, 5 for 3243
    (benchmarks.md, pins).
    """
    assert (ELEMENTS["3333"].axial_points, ELEMENTS["3243"].axial_points) == (2, 3)
    assert ELEMENTS["3363"].axial_points == 2  # theory.md 3
    assert ELEMENTS["3333"].full_points >= 3
    assert ELEMENTS["3243"].full_points == 5
