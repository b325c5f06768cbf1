"""Load steps, budgets and starts: what `solve` does when Newton alone does not do it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import ancf
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.scene import Force, Frame, Moment, Rod, Scene, SolverOptions, Support
from ancf.sections import Circle, Rectangle

SOFT = SaintVenantKirchhoff(1e6, 0.3)


def arm(**changes: object) -> Rod:
    return replace(Rod("arm", 0.4, 8, Circle(0.01), SOFT), **changes)


def pushed(rod: Rod, value: tuple[float, float, float], **options: object) -> Scene:
    forces = (Force("arm", 1.0, np.array(value)),)
    return Scene((rod,), forces=forces, solver=SolverOptions(**options))  # type: ignore[arg-type]


def constraint_error(solution: ancf.Solution) -> float:
    model = solution.model
    return max(float(np.max(np.abs(s.rows @ (solution.q - model.q0)[s.dofs]))) for s in model.supports)


def test_a_start_from_elsewhere_is_brought_onto_the_supports():
    """The same arm solved with another base is no start for this one unless its clamp is put right first."""
    turned = arm(base=Frame(np.zeros(3), np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])))
    other = ancf.solve(pushed(turned, (0.0, 0.02, 0.0)))
    scene = pushed(arm(), (0.0, 0.02, 0.0))
    direct, resumed = ancf.solve(scene), ancf.solve(scene, start=other.q)
    assert direct.status == resumed.status == "converged"
    assert constraint_error(resumed) == 0.0
    assert resumed.tip().position == pytest.approx(direct.tip().position, abs=1e-10)


@pytest.mark.parametrize("kind", ["clamp", "free_section_clamp"])
def test_load_steps_keep_the_supports(kind):
    """I_y != I_z: the polar rotation at a free section may turn while r_y . z = r_z . y holds."""
    rod = arm(section=Rectangle(0.01, 0.005), supports=(Support(0.0, kind),))
    EI = 1e6 * 0.005 * 0.01**3 / 12
    value = (0.0, 4.0 * EI / 0.16, 3.0 * EI / 0.16)
    at_once = ancf.solve(pushed(rod, value))
    stepped = ancf.solve(pushed(rod, value, predictor="none"))
    assert stepped.steps > 1
    assert constraint_error(stepped) < 1e-15
    assert stepped.tip().position == pytest.approx(at_once.tip().position, abs=1e-9)


def test_used_up_steps_say_so():
    scene = pushed(arm(), (0.0, 0.3, 0.0), predictor="none", max_steps=1)
    solution = ancf.solve(scene)
    assert solution.status == "not_converged"
    assert 0.0 < solution.load_factor < 1.0 and solution.steps == 1
    assert solution.message is not None
    assert "max_steps = 1" in solution.message.value
    assert "max_steps" in solution.message.advice


def test_no_time_is_a_status():
    solution = ancf.solve(pushed(arm(), (0.0, 0.3, 0.0), max_seconds=1e-9))
    assert solution.status == "out_of_time"
    assert solution.load_factor == 0.0
    assert solution.message is not None and "max_seconds" in solution.message.value


def test_crushed_rod_is_an_unstable_material():
    """P = E A (s^3 - s) / 2 is least at s = 1/sqrt(3): -0.19245 E A; nu = 0 keeps the clamp out of it."""
    rod = arm(length=0.04, elements=2, material=SaintVenantKirchhoff(1e6, 0.0))
    solution = ancf.solve(pushed(rod, (-0.3e6 * np.pi * 1e-4, 0.0, 0.0)))
    assert solution.status == "material_unstable"
    assert solution.load_factor == pytest.approx(0.19245 / 0.3, rel=1e-3)


def test_elements_too_long_are_warned_about():
    """Two turns on 12 elements: 1.05 rad an element, tip 8e-3 L off the helix (L/R = 400)."""
    rod = arm(length=4.0, elements=12)
    EI = 1e6 * np.pi * 0.01**4 / 4
    for turns, warned in ((1.0, False), (2.0, True)):
        moment = Moment("arm", 1.0, np.array([0.0, 0.0, turns * 2 * np.pi * EI / 4.0]))
        solution = ancf.solve(Scene((rod,), moments=(moment,)))
        assert solution.status == "converged"
        assert any("too long" in text for text in solution.warnings) == warned


@pytest.mark.parametrize("element", ["3333", "3243"])
@pytest.mark.parametrize("definition", ["section", "vorticity"])
def test_moment_in_the_middle_is_antisymmetric(element, definition):
    """Both ends clamped, moment at mid-length: y(L/4) = -y(3L/4) by symmetry."""
    ends = (Support(0.0), Support(1.0))
    rod = arm(element=element, elements=4, supports=ends)
    moment = Moment("arm", 0.5, np.array([0.0, 0.0, 1e-3]), definition=definition)
    solution = ancf.solve(Scene((rod,), moments=(moment,)))
    left, right = (solution.pose("arm", at).position[1] for at in (0.25, 0.75))
    assert abs(left) > 1e-6
    assert left == pytest.approx(-right, rel=1e-6)


@pytest.mark.parametrize("effect", ["moments", "forces"])
def test_zero_magnitude_is_absence(effect):
    """Bit for bit, also where the load would have moved an element boundary."""
    scene = pushed(arm(), (0.0, 0.1, 0.05))
    zero = Moment("arm", 0.37, np.zeros(3)) if effect == "moments" else Force("arm", 0.37, np.zeros(3))
    with_zero = replace(scene, **{effect: (*getattr(scene, effect), zero)})
    assert np.array_equal(ancf.solve(scene).q, ancf.solve(with_zero).q)


def test_tangent_of_a_solution_is_regular_and_of_the_free_unknowns():
    solution = ancf.solve(pushed(arm(), (0.0, 0.1, 0.0)))
    K = solution.tangent()
    assert K.shape == (solution.unknowns, solution.unknowns)
    assert np.linalg.matrix_rank(K.toarray()) == solution.unknowns


def test_unstable_equilibrium_is_warned_about():
    """A column, weak in one plane, at 3 Euler loads (pi^2/4 E I/L^2): the straight shape is unstable."""
    rod = arm(section=Rectangle(0.01, 0.02))
    EI = 1e6 * 0.02 * 0.01**3 / 12
    euler = np.pi**2 / 4 * EI / 0.16
    for factor, warned in ((0.9, False), (3.0, True)):
        solution = ancf.solve(pushed(rod, (-factor * euler, 0.0, 0.0)))
        assert solution.status == "converged"
        assert any("unstable" in text for text in solution.warnings) == warned


@pytest.mark.parametrize("imperfection", [1e-2, 1e-3])
def test_a_strut_with_an_imperfection_takes_the_buckled_branch(imperfection):
    """P L^2/EI = 5 is 2.03 times Euler's load.

    Elastica (Timoshenko, Gere 1961, table 2-4): w/L = .792 at 1.884 and .803 at 2.541 times that load, never
    above .806; shear, axial strain and the imperfection are below .007.
    """
    EI = 1e6 * np.pi * 0.01**4 / 4
    P = 5.0 * EI / 0.16
    solution = ancf.solve(pushed(arm(), (-P, imperfection * P, 0.0)))
    assert solution.status == "converged" and solution.stable
    assert 0.785 < solution.tip().position[1] / 0.4 < 0.806


def test_calls_are_evaluations_not_loads():
    """Three forces on two rods are evaluated together: as many calls as of the elastic forces."""
    rods = (arm(), arm(name="other"))
    forces = tuple(
        Force(name, at, np.array([0.0, 0.01, 0.0])) for name, at in (("arm", 1), ("arm", 0.5), ("other", 1))
    )
    solution = ancf.solve(Scene(rods, forces=forces))
    assert solution.effects["force"]["calls"] == solution.effects["elastic"]["calls"]


def test_model_builds_only_listed_effects():
    assert [effect.name for effect in Model(pushed(arm(), (0.0, 0.1, 0.0))).effects] == ["force"]
