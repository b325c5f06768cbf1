"""Support conditions, their projector and the paper's B_2."""

import numpy as np
import pytest
from hypothesis import given

from ancf.elements import ELEMENTS, SECTION_ELEMENTS
from ancf.rotation import hat
from ancf.supports import NodeSupport, support_rows
from tests.strategies import rotations

KINDS = ("clamp", "pin", "free_section_clamp")


def conditions_of(kind, element):
    """interface.md: a clamp fixes all unknowns of the node, a free section clamp x of higher vectors."""
    higher = sum(order[0] == 0 and sum(order) > 1 for order in element.vectors)
    return {"clamp": 3 * len(element.vectors), "pin": 3, "free_section_clamp": 6 + higher}[kind]


every_element = pytest.mark.parametrize("element", ELEMENTS.values(), ids=lambda e: e.name)
every_section = pytest.mark.parametrize("element", SECTION_ELEMENTS.values(), ids=lambda e: e.name)


def support(kind, element, frame=None):
    rows = support_rows(kind, element, np.eye(3) if frame is None else frame)
    return NodeSupport(np.arange(rows.shape[1]), rows)


def motion(element, **vectors):
    """Unknowns (3 n_v,) of a node from its vectors by name."""
    names = {(0, 0, 0): "r", (1, 0, 0): "r_x", (0, 1, 0): "r_y", (0, 0, 1): "r_z"}
    names |= {(0, 2, 0): "r_yy", (0, 1, 1): "r_yz", (0, 0, 2): "r_zz"}
    return np.concatenate([np.asarray(vectors.get(names[v], np.zeros(3)), float) for v in element.vectors])


@every_section
@pytest.mark.parametrize("kind", KINDS)
@given(frame=rotations())
def test_basis_and_projector(element, kind, frame):
    """B_2 is orthonormal, C B_2 = 0, and P = B_2 B_2^T projects on all motions that C allows."""
    s = support(kind, element, frame)
    nd = 3 * len(element.vectors)
    conditions = conditions_of(kind, element)
    assert s.rows.shape == (conditions, nd)
    assert s.basis.shape == (nd, nd - conditions)
    np.testing.assert_allclose(s.basis.T @ s.basis, np.eye(nd - conditions), atol=1e-13)
    np.testing.assert_allclose(s.rows @ s.basis, 0.0, atol=1e-13)
    C = s.rows
    np.testing.assert_allclose(s.projector, np.eye(nd) - C.T @ np.linalg.solve(C @ C.T, C), atol=1e-12)


@every_element
def test_clamp_holds_everything_and_pin_the_position(element):
    assert support("clamp", element).basis.size == 0
    pin = support("pin", element)
    np.testing.assert_array_equal(
        pin.rows @ motion(element, r=[1, 2, 3], r_y=[4, 5, 6], r_z=[7, 8, 9]), [1, 2, 3]
    )
    assert set(np.unique(pin.basis)) == {0.0, 1.0}  # unit vectors, exactly


@every_section
@given(frame=rotations())
def test_free_section_clamp_allows_contraction_and_nothing_rigid(element, frame):
    """interface.md: r = 0, r_y.x = r_z.x = 0, r_y.z = r_z.y in the base frame; r_x and the stretches free."""
    s = support("free_section_clamp", element, frame)
    _, y, z = frame.T
    for free in (
        motion(element, r_y=y),  # stretches
        motion(element, r_z=z),
        motion(element, r_y=z, r_z=y),  # in-plane shear of the section, without turning it
        motion(element, r_x=[0.3, -0.2, 0.7]),
    ):
        np.testing.assert_allclose(s.rows @ free, 0.0, atol=1e-14)
        np.testing.assert_allclose(s.projector @ free, free, atol=1e-14)
    for w in np.eye(3):  # rigid rotations, and translations
        spin = hat(w)
        assert np.abs(s.rows @ motion(element, r_y=spin @ y, r_z=spin @ z)).max() > 0.1
        assert np.abs(s.rows @ motion(element, r=w)).max() > 0.1


@given(frame=rotations())
def test_free_section_clamp_keeps_quadratic_sections_plane(frame):
    """interface.md: for 3363 also the x-components of the second-order vectors; the others are free."""
    element = ELEMENTS["3363"]
    s = support("free_section_clamp", element, frame)
    x, y, z = frame.T
    for name in ("r_yy", "r_yz", "r_zz"):
        held, free = motion(element, **{name: x}), motion(element, **{name: y - 2.0 * z})
        np.testing.assert_allclose(s.projector @ held, 0.0, atol=1e-14)
        np.testing.assert_allclose(s.projector @ free, free, atol=1e-14)


def test_unknown_kind():
    with pytest.raises(ValueError, match="unknown support kind 'glue'"):
        support_rows("glue", ELEMENTS["3333"], np.eye(3))
