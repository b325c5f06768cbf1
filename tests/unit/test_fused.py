"""The fused kernel at single loads: closed forms, starts, refusals."""

from dataclasses import replace

import numpy as np
import pytest

import ancf
from ancf import fused
from ancf.hyperelastic import NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.newton import newton
from ancf.scene import Force, Gravity, LineLoad, Moment, Rod, Scene, Support
from ancf.sections import Circle
from reference.helix import helix_tip_moment

pytest.importorskip("numba")

LAW = SaintVenantKirchhoff(1e6, 0.3, 1000.0)
ROD = Rod("rod", 1.0, 8, Circle(0.025), LAW)
TIP = Moment("rod", 1.0, np.array([0.0, 0.0, 1.0]))
NO_FORCES = np.empty((1, 0, 3))
NO_MOMENTS = np.empty((1, 0, 3))


def model(rod=ROD, **loads):
    return Model(Scene((rod,), **loads))


def unit(of):
    return of.rods[0].bending_stiffness / of.rods[0].rod.length


def test_a_batch_of_spatial_tip_moments_ends_on_helices():
    """issue 5, NUMBERS: no sample lost at L/R = 40 and 500, nu = .3 and .49; tip to 3e-4 L in the median.

    The helix is the thin limit (theory.md 1); at L/R = 500 finite strain leaves 1e-5.
    """
    for slenderness, poisson_ratio, closed in ((40, 0.3, False), (500, 0.49, True)):
        law = SaintVenantKirchhoff(1e6, poisson_ratio)
        tip = model(replace(ROD, section=Circle(1.0 / slenderness), material=law), moments=(TIP,))
        draws = np.random.default_rng(0).uniform(-1.0, 1.0, (1520, 1, 3)) * [0.8, 3.0, 3.0]
        found = fused.solve_rows(tip, draws * unit(tip), np.empty((1520, 0, 3)))
        assert found.converged.all()
        assert np.all(found.residual <= np.maximum(1e-10, found.floor))
        if closed:
            positions = found.q.reshape(1520, -1, 3, 3)[:, -1, 0]
            exact = np.array([helix_tip_moment(v, 1.0, 1.0, 1.0, 1.0).position[0] for v in draws[:, 0]])
            assert np.median(np.linalg.norm(positions - exact, axis=1)) <= 3e-4


@pytest.mark.parametrize("direction", ["fixed", "follower"])
def test_the_tangent_of_moments_is_whole(direction):
    """Near an equilibrium Newton's error squares, from 1e-5 to rounding in a few steps; a term that is
    missing from the tangent of a large moment leaves linear convergence, and many more.
    """
    for row in np.random.default_rng(2).uniform(-1.0, 1.0, (6, 3)) * [0.5, 1.5, 1.5]:
        tip = model(moments=(replace(TIP, direction=direction),))
        moments = (row * unit(tip)).reshape(1, 1, 3)
        exact = fused.solve_rows(tip, moments, NO_FORCES)
        assert exact.converged[0]
        noise = np.random.default_rng(3).uniform(-1e-5, 1e-5, tip.n) * tip.unit
        assert fused.solve_rows(tip, moments, NO_FORCES, exact.q[0] + noise).iterations[0] <= 4


@pytest.mark.parametrize("load", [1.0, 5.0, 10.0])
@pytest.mark.parametrize("slenderness", [40.0, 400.0])
def test_a_tip_force_is_found_from_the_straight_shape(load, slenderness):
    """theory.md 6: P L^2/(E I) = 1, 5, 10 take 5, 7, 8 iterations (mixed-integration-point tangent)."""
    scene = Scene(
        (replace(ROD, section=Circle(1.0 / slenderness)),),
        forces=(Force("rod", 1.0, np.array([0.0, 1.0, 0.0])),),
    )
    tip = Model(scene)
    value = np.array([[[0.0, load * unit(tip), 0.0]]])
    found = fused.solve_rows(tip, NO_MOMENTS, value)
    assert found.converged[0] and found.iterations[0] <= 9
    solution = ancf.solve(replace(scene, forces=(replace(scene.forces[0], value=value[0, 0]),)))
    assert tip.largest_motion(found.q[0] - solution.q) <= 1e-11


def test_without_load_the_reference_is_kept():
    still = model(moments=(TIP,))
    found = fused.solve_rows(still, np.zeros((1, 1, 3)), NO_FORCES)
    assert found.converged[0] and found.iterations[0] == 1
    assert still.largest_motion(found.q[0] - still.q0) <= 1e-15


def test_no_rows_are_no_work():
    found = fused.solve_rows(model(moments=(TIP,)), np.empty((0, 1, 3)), np.empty((0, 0, 3)))
    assert found.q.shape == (0, model(moments=(TIP,)).n) and not len(found.converged)


def test_a_start_may_be_one_shape_for_all_or_one_for_each():
    tip = model(moments=(TIP,))
    moments = np.array([[[0.0, 0.0, 0.5]], [[0.0, 0.1, 0.5]]]) * unit(tip)
    none = np.empty((2, 0, 3))
    cold = fused.solve_rows(tip, moments, none)
    each = fused.solve_rows(tip, moments, none, start=cold.q)
    both = fused.solve_rows(tip, moments, none, start=cold.q[0])
    np.testing.assert_array_equal(each.iterations, [1, 1])
    assert both.iterations[0] == 1 < both.iterations[1]
    assert tip.largest_motion((both.q - cold.q)[1]) <= 1e-11


def test_a_row_that_runs_out_of_iterations_is_marked():
    tip = model(moments=(TIP,))
    found = fused.solve_rows(tip, np.array([[[0.0, 0.0, 3.0]]]) * unit(tip), NO_FORCES, max_iterations=2)
    assert not found.converged[0] and found.iterations[0] == 2 and np.isfinite(found.q).all()


def test_a_compressed_column_is_not_left_straight():
    """Beyond Euler's load pi^2/4 E I/L^2 the straight shape is an equilibrium, but no minimum."""
    push = model(forces=(Force("rod", 1.0, np.array([-1.0, 0.0, 0.0])),))
    critical = np.pi**2 / 4.0 * unit(push)
    for share, found in ((0.9, True), (1.1, False)):
        result = fused.solve_rows(push, NO_MOMENTS, np.array([[[-share * critical, 0.0, 0.0]]]))
        assert result.converged[0] == found


def test_a_follower_moment_that_bends_about_one_axis_is_a_fixed_one():
    """theory.md 4: they agree where psi = 0."""
    fixed, follower = model(moments=(TIP,)), model(moments=(replace(TIP, direction="follower"),))
    value = np.array([[[0.0, 0.0, 2.0]]]) * unit(fixed)
    one, other = (fused.solve_rows(m, value, NO_FORCES) for m in (fixed, follower))
    assert one.converged[0] and other.converged[0]
    assert fixed.largest_motion(one.q[0] - other.q[0]) <= 1e-11


@pytest.mark.parametrize(
    ("scene", "words"),
    [
        (Scene((replace(ROD, material=NeoHookean(1e6, 0.3)),), moments=(TIP,)), "Saint Venant-Kirchhoff"),
        (Scene((ROD, replace(ROD, name="other"))), "one rod"),
        (Scene((ROD,), moments=(replace(TIP, definition="vorticity"),)), "rotation"),
        (Scene((ROD,), line_loads=(LineLoad("rod", np.ones(3), "follower"),)), "dead line loads"),
        (Scene((replace(ROD, elements=1),), moments=(replace(TIP, at=0.3), TIP)), "between elements"),
        (
            Scene(
                (replace(ROD, supports=(Support(0.0, "free_section_clamp"),)),),
                moments=(replace(TIP, at=0.0),),
            ),
            "free-section clamp",
        ),
    ],
)
def test_what_it_cannot_take_is_said(scene, words):
    assert words in fused.unsupported(Model(scene))


def test_weight_and_line_loads_are_constant_forces():
    scene = Scene(
        (ROD,),
        line_loads=(LineLoad("rod", np.array([0.0, 0.2, 0.0])),),
        gravity=Gravity(np.array([0.0, 0.0, -0.1])),
    )
    assert fused.unsupported(Model(scene)) == ""
    found = fused.solve_rows(Model(scene), NO_MOMENTS, NO_FORCES)
    solution = ancf.solve(scene)
    assert found.converged[0] and np.abs(solution.q - Model(scene).q0).max() > 0.1
    assert Model(scene).largest_motion(found.q[0] - solution.q) <= 1e-11


def test_numba_is_loaded_by_the_first_solve_only():
    import subprocess
    import sys

    code = "import sys, ancf, ancf.fused; assert 'numba' not in sys.modules"
    subprocess.run([sys.executable, "-c", code], check=True)


def test_a_section_turned_inside_out_is_no_solution():
    """An arc in the x-y plane, pinned at three points and mirrored in z, has no strain and det F = -1."""
    pins = tuple(Support(at, "pin") for at in (0.0, 0.5, 1.0))
    arc = model(replace(ROD, curvature=np.array([0.0, 0.0, 1.0]), supports=pins))
    mirrored = arc.q0.reshape(-1, 3, 3) * np.array([[1.0], [1.0], [-1.0]])
    for start, sound in ((arc.q0, True), (mirrored.ravel(), False)):
        assert fused.solve_rows(arc, NO_MOMENTS, NO_FORCES, start).converged[0] == sound


def test_follower_forces_and_their_tangent_are_those_of_the_readable_kernel():
    """Two of them off the axis, one inside the rod; the step of the linear system shows a wrong tangent."""
    loads = (
        Force("rod", 0.5, np.array([0.0, 0.1, 0.2]), np.array([0.01, 0.0]), "follower"),
        Force("rod", 1.0, np.array([0.1, 0.1, 0.1]), np.array([0.0, 0.01]), "follower"),
    )
    push = model(forces=loads)
    values = np.array([[load.value for load in loads]])
    found = fused.solve_rows(push, NO_MOMENTS, values)
    solution = ancf.solve(push.scene)
    assert found.converged[0] and push.largest_motion(found.q[0] - solution.q) <= 1e-11
    start = push.admissible(solution.q + 1e-5 * np.random.default_rng(0).uniform(-1.0, 1.0, push.n))
    step = fused.solve_rows(push, NO_MOMENTS, values, start, max_iterations=1).q[0] - start
    expected = newton(push, start, 1.0, 1).q - start
    # Stiffness ratio 4 (L/R)^2 times a few elements squared, times rounding.
    assert push.largest_motion(step - expected) <= 1e-9 * push.largest_motion(expected)
