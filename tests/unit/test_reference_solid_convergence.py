"""Richardson extrapolation and error bars of the solid's meshes, on sequences with a known limit."""

import numpy as np
import pytest

from reference.solid_convergence import corrected, richardson


def sequence(sizes, limit=2.0, c=0.3, p=4.0, tail=0.0):
    return [limit + c * h**p + tail * h ** (p + 2) for h in sizes]


@pytest.mark.parametrize("sizes", [(1, 1 / 2, 1 / 4), (1, 1 / 2, 1 / 3), (3, 2, 1.5)])
@pytest.mark.parametrize("p", [1.5, 4.0])
def test_a_pure_power_is_extrapolated_to_its_limit(sizes, p):
    result = richardson(sequence(sizes, p=p), sizes, formal_order=4)
    assert result.order == pytest.approx(p, rel=1e-8)
    assert result.extrapolated == pytest.approx(2.0, abs=1e-9)
    assert result.asymptotic
    # Roache: 1.25 times the estimated error
    assert result.error == pytest.approx(1.25 * abs(result.value - 2.0), rel=1e-7)


def test_two_meshes_take_the_formal_order_and_a_factor_of_three():
    sizes = (1, 0.5)
    result = richardson(sequence(sizes), sizes, formal_order=4)
    assert result.extrapolated == pytest.approx(2.0, abs=1e-13)
    assert result.order is None
    assert not result.asymptotic
    assert result.error == pytest.approx(3 * abs(result.value - 2.0), rel=1e-12)


def test_an_order_above_the_formal_one_is_not_trusted():
    sizes = (1, 0.5, 0.25)
    result = richardson(sequence(sizes, p=6.0), sizes, formal_order=4)
    assert result.order == pytest.approx(6, rel=1e-8)
    assert result.error == pytest.approx(1.25 * abs(0.3 * (1 / 16) ** 3 - 0.3 / 64) / 15, rel=1e-9)
    assert result.error > abs(result.value - 2.0)


def test_error_bar_covers_the_error_with_higher_terms():
    sizes = (1, 0.5, 0.25)
    for tail in (-0.1, 0.1, 0.3):
        result = richardson(sequence(sizes, tail=tail), sizes, formal_order=4)
        assert abs(result.value - 2.0) < result.error


def test_error_bar_of_the_limit_covers_its_error_and_is_far_below_that_of_the_mesh():
    sizes = (1 / 2, 1 / 3, 1 / 4)
    for tail in (-0.1, 0.1):
        result = richardson(sequence(sizes, tail=tail), sizes, formal_order=4)
        assert abs(result.extrapolated - 2.0) < result.extrapolated_error < result.error
    # Order 3 where 4 is formal: the pairs do not agree, and the bar grows with their difference.
    third = richardson(sequence(sizes, p=3.0), sizes, formal_order=4)
    pairs = [richardson(sequence(sizes, p=3.0)[i : i + 2], sizes[i : i + 2], 4).extrapolated for i in (0, 1)]
    moved = max(abs(pairs[1] - pairs[0]), abs(third.extrapolated - pairs[1]))
    assert third.extrapolated_error == pytest.approx(3 * moved, rel=1e-9)


def test_oscillating_and_diverging_meshes_are_not_asymptotic():
    for values in ([1.0, 1.2, 1.1], [1.0, 1.1, 1.3]):
        result = richardson(values, (1, 0.5, 0.25), formal_order=4)
        assert not result.asymptotic
        assert result.extrapolated == values[-1]
        assert result.error >= 3 * abs(values[2] - values[1])


def test_vectors_share_one_order():
    sizes, c = (1, 1 / 2, 1 / 3), np.array([0.3, -0.4, 0.0])
    result = richardson([np.ones(3) + c * h**3 for h in sizes], sizes, formal_order=4)
    assert result.order == pytest.approx(3, rel=1e-8)
    np.testing.assert_allclose(result.extrapolated, np.ones(3), atol=1e-10)
    assert result.error == pytest.approx(1.25 * 0.5 / 27, rel=1e-8)
    assert result.relative == pytest.approx(result.error / np.linalg.norm(result.value))


def test_values_that_do_not_change_have_no_order():
    result = richardson([2.0, 2.0, 2.0], (1, 0.5, 0.25), formal_order=4)
    assert (result.order, result.error, result.asymptotic) == (None, 0.0, True)
    assert np.isinf(richardson([0.0, 0.0], (1, 0.5), 4).relative)


def test_two_directions_are_corrected_apart():
    # f = 2 + 0.3 a^4 + 0.1 b^3: section size a, slice size b
    def f(a, b):
        return 2 + 0.3 * a**4 + 0.1 * b**3

    sizes = (1, 0.5, 0.25)
    section = richardson([f(a, 1.0) for a in sizes], sizes, 4)
    axis = richardson([f(1.0, b) for b in sizes], sizes, 4)
    result = corrected(f(0.25, 0.25), [section, axis])
    assert result.extrapolated == pytest.approx(2.0, abs=1e-9)
    assert result.order == pytest.approx(3, rel=1e-6)
    assert result.error == pytest.approx(1.25 * (0.3 / 4**4 + 0.1 / 4**3), rel=1e-6)
    assert result.asymptotic


@pytest.mark.parametrize(
    ("values", "sizes", "message"),
    [
        ([1.0], (1,), "1 values with 1 mesh sizes were given; two or three"),
        ([1.0, 2.0], (1, 0.5, 0.25), "2 values with 3 mesh sizes"),
        ([1.0, 2.0], (0.5, 1), "must be positive and fall from coarse to fine"),
        ([1.0, np.nan], (1, 0.5), "A value is not finite"),
    ],
)
def test_impossible_sequences_are_refused(values, sizes, message):
    with pytest.raises(ValueError, match=message):
        richardson(values, sizes, 4)


def test_meshes_that_swing_have_the_largest_difference_for_an_error():
    """|f_2 - f_1| = .1 is worth .1/2^4 on the next mesh, |f_3 - f_2| = .05: safety 3 times the larger."""
    found = richardson([1.0, 1.1, 1.05], [4.0, 2.0, 1.0], 4.0)
    assert not found.asymptotic
    assert found.error == pytest.approx(0.15)
    assert found.extrapolated == 1.05
