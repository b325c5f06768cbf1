"""Save and resume."""

from dataclasses import replace

import numpy as np
import pytest

import ancf
from ancf.materials import SaintVenantKirchhoff
from ancf.scene import Moment, Rod, Scene, Support
from ancf.sections import Circle, Rectangle
from validation.solution_measures import solved

EI = 1e6 * np.pi * 0.02**4 / 4


def scene(factor=1.0, elements=6, **changes):
    rod = replace(Rod("rod", 1.0, elements, Circle(0.02), SaintVenantKirchhoff(1e6, 0.3)), **changes)
    return Scene((rod,), moments=(Moment("rod", 1.0, factor * np.array([0.3, -0.5, 2.0]) * EI),))


def test_a_neighbour_starts_from_the_state(tmp_path):
    path = tmp_path / "state.npz"
    solved(scene()).save(path)
    assert list(tmp_path.iterdir()) == [path]  # no temporary file left
    near = ancf.resume(scene(1.02), path)
    np.testing.assert_allclose(near.q, solved(scene(1.02)).q, atol=1e-10)
    assert near.iterations <= 5


def test_supports_hold_after_resuming_under_another_support(tmp_path):
    """The saved base section is contracted and sheared; under a clamp it must stand as in the reference."""
    path = tmp_path / "state.npz"
    section = Rectangle(0.05, 0.03)
    solved(scene(section=section, supports=(Support(0.0, "free_section_clamp"),))).save(path)
    clamped = scene(section=section)
    resumed = ancf.resume(clamped, path)
    support = resumed.model.supports[0]
    np.testing.assert_allclose(resumed.q[support.dofs], resumed.model.q0[support.dofs], atol=1e-13)
    np.testing.assert_allclose(resumed.q, solved(clamped).q, atol=1e-9)


def test_a_state_of_another_mesh_is_refused(tmp_path):
    path = tmp_path / "state.npz"
    solved(scene()).save(path)
    with pytest.raises(ancf.InputError, match="does not belong to this scene"):
        ancf.resume(scene(elements=7), path)
    with pytest.raises(ancf.InputError, match="does not belong to this scene"):
        ancf.resume(scene(element="3243"), path)


def test_a_broken_file_is_refused(tmp_path):
    path = tmp_path / "state.npz"
    solved(scene()).save(path)
    path.write_bytes(path.read_bytes()[:100])
    with pytest.raises(ancf.InputError, match="cannot be read"):
        ancf.resume(scene(), path)
    with pytest.raises(ancf.InputError, match="cannot be read"):
        ancf.resume(scene(), tmp_path / "missing.npz")
