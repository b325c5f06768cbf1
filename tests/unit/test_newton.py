"""One Newton iteration at a time: what counts as converged, and how a failure is named."""

from dataclasses import replace

import numpy as np
import pytest

from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.newton import Outcome, newton
from ancf.scene import Force, Rod, Scene, SolverOptions, Support
from ancf.sections import Circle
from validation.solution_measures import bending_stiffness, solved

ROD = Rod("rod", 1.0, 8, Circle(0.0025), SaintVenantKirchhoff(1e6, 0.3))
LOAD = 3.0 * bending_stiffness(ROD)


def scene(factor=1.0, **options):
    force = Force("rod", 1.0, np.array([0.0, factor * LOAD, 0.0]))
    return Scene((ROD,), forces=(force,), solver=SolverOptions(**options))


def test_a_small_step_with_a_large_residual_is_not_converged():
    """theory.md 6: step *and* residual. From 99.9 % of the load the first step is below 1e-2, but it
    stretches the rod by its square, and A L^2/I = 6e5 turns that into a residual of 0.1.
    """
    model, near = Model(scene(tolerance=1e-2)), solved(scene(0.999)).q
    one = newton(model, near, 1.0, 1)
    assert one.history[0].step < 1e-2
    assert one.residual > 1e-2
    assert one.outcome is Outcome.TOO_MANY
    more = newton(model, near, 1.0, 10)
    assert more.outcome is Outcome.CONVERGED
    assert more.residual <= 1e-2


def test_an_equilibrium_needs_one_iteration():
    model, q = Model(scene()), solved(scene()).q
    result = newton(model, q, 1.0, 5)
    assert result.converged
    assert len(result.history) == 1
    np.testing.assert_allclose(result.q, q, atol=1e-11)


def test_the_start_is_brought_onto_the_supports():
    """Base displaced and turned: the conditions are linear and hold from the first iterate on."""
    model = Model(scene())
    result = newton(model, model.q0 + 0.01 * model.unit, 0.0, 20)
    assert result.converged
    support = model.supports[0]
    np.testing.assert_array_equal(result.q[support.dofs], model.q0[support.dofs])


@pytest.mark.parametrize(("value", "outcome"), [(np.inf, Outcome.NOT_FINITE), (1e300, Outcome.DIVERGED)])
def test_hopeless_starts_are_named(value, outcome):
    model = Model(scene())
    with np.errstate(all="ignore"):
        model.effects[0].Q[...] = value  # pyright: ignore
        found = newton(model, model.q0, 1.0, 25)
    assert found.outcome in (outcome, Outcome.NOT_FINITE)
    assert np.isfinite(found.q).all()


def test_a_rod_on_one_pin_is_singular():
    """Three rigid rotations are left: no unique answer. (Scene files with it are refused.)"""
    rod = replace(ROD, supports=(Support(0.0, "pin"),))
    model = Model(Scene((rod,), forces=(Force("rod", 1.0, np.array([0.0, LOAD, 0.0])),)))
    assert newton(model, model.q0, 1.0, 25).outcome is not Outcome.CONVERGED
