"""Cost of the solid reference before it starts, and its linear solvers."""

from dataclasses import replace
from importlib.util import find_spec

import numpy as np
import pytest

from reference import solid_cost, solid_linear
from reference.solid import SolidProblem, SolidTooLarge, bent_rod, soft_clamp, solve_solid
from reference.solid_cost import check_cost, estimate
from reference.solid_linear import BlockSolver, linear_solver
from reference.solid_mesh import circular_section, rod_mesh
from tests.solid_rods import LENGTH, NU, RADIUS, RUBBER, bending_moment


def problem(core=1, slices=4):
    mesh = rod_mesh(circular_section(RADIUS, core), LENGTH, slices)
    moment = np.array([0, 0, bending_moment(0.5)])
    return SolidProblem(mesh, RUBBER, soft_clamp(mesh), bent_rod(mesh, 0.5 / LENGTH, NU), moment=moment)


def test_estimate_counts_the_unknowns_and_grows_as_the_solver_does():
    mesh = problem(core=2, slices=20).mesh
    cost = estimate(mesh, "displacement")
    assert cost.unknowns == 7011  # reference study, core 2, 20 slices
    assert estimate(mesh, "mixed").seconds > cost.seconds
    assert estimate(mesh, "mixed").bytes > cost.bytes
    # a wide section is governed by the factorisation, the cube of its nodes
    wide, wider = (estimate(rod_mesh(circular_section(RADIUS, n), 1.0, 2), "displacement") for n in (8, 16))
    ratio = len(circular_section(RADIUS, 16).nodes) / len(circular_section(RADIUS, 8).nodes)
    assert ratio**2.5 < wider.seconds / wide.seconds < ratio**3


def test_estimated_memory_is_right_within_a_factor_of_two():
    # peak resident memory of a fresh process that bends the rod by 90 degrees [GB]
    for core, slices, formulation, measured in [
        (2, 20, "displacement", 0.203),
        (3, 40, "displacement", 0.525),
        (4, 40, "displacement", 0.731),
        (2, 20, "mixed", 0.220),
        (3, 40, "mixed", 0.568),
    ]:
        mesh = rod_mesh(circular_section(RADIUS, core), LENGTH, slices)
        assert measured / 2 < estimate(mesh, formulation).bytes / 1e9 < 2 * measured


def test_cost_is_told_before_the_work_when_asked():
    lines = []
    result = solve_solid(problem(), report=lines.append)
    assert result.converged
    assert len(lines) == 1
    assert lines[0].startswith("Solid of 4 slices with 25 nodes a section: 675 unknowns, about 0.")
    check_cost(problem().mesh, "displacement")  # silent by default


def test_a_long_solution_is_announced_without_being_asked(monkeypatch, capsys):
    mesh = problem().mesh
    check_cost(mesh, "displacement")
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(solid_cost, "ANNOUNCED", 0.0)
    check_cost(mesh, "displacement", solutions=4)
    assert "Solid of 4 slices" in capsys.readouterr().err


def test_the_memory_of_the_machine_is_the_limit_where_none_is_given(monkeypatch):
    monkeypatch.setattr(solid_cost, "machine_memory", lambda: 1e6)
    with pytest.raises(SolidTooLarge, match=r"GB > 0\.001 GB"):
        check_cost(problem().mesh, "displacement")


@pytest.mark.parametrize(
    ("limits", "message"),
    [
        ({"memory_limit": 1e6}, r"estimated memory 0\.\d+ GB > 0\.001 GB\. The cost grows"),
        ({"seconds_limit": 1e-6}, r"estimated time [\d.e-]+ s > 1e-06 s\. The cost grows"),
        ({"memory_limit": 1e6, "seconds_limit": 1e-6}, "GB and time"),
    ],
)
def test_too_large_a_solid_is_refused(limits, message):
    with pytest.raises(SolidTooLarge, match=message) as refusal:
        solve_solid(problem(), **limits)
    assert str(refusal.value).startswith("Solid of 4 slices with 25 nodes a section was not started")
    assert str(refusal.value).endswith("Take fewer slices or a coarser section, or raise the limit.")


def test_limits_that_hold_let_it_pass():
    assert solve_solid(problem(), memory_limit=1e12, seconds_limit=1e6).converged


def test_auto_takes_the_block_solver_where_pardiso_is_absent(monkeypatch):
    monkeypatch.setattr(solid_linear, "find_spec", lambda name: None)
    assert isinstance(linear_solver("auto", [0, 1]), BlockSolver)
    with pytest.raises(ValueError, match='linear_solver is "pardiso", but pypardiso is not installed'):
        linear_solver("pardiso", [0, 1])


def test_unknown_solver_is_refused():
    with pytest.raises(ValueError, match='linear_solver is "umfpack"; "block", "pardiso" and "auto"'):
        linear_solver("umfpack", [0, 1])  # pyright: ignore[reportArgumentType]


@pytest.mark.skipif(find_spec("pypardiso") is None, reason="pypardiso is not installed (extra: pardiso)")
def test_pardiso_agrees_with_the_block_solver():
    block, pardiso = (solve_solid(replace(problem(), linear_solver=name)) for name in ("block", "auto"))
    assert pardiso.converged, pardiso.reason
    np.testing.assert_allclose(pardiso.positions, block.positions, atol=1e-12 * LENGTH)
    singular = solid_linear.csr_array(np.zeros((4, 4)) + np.diag([1.0, 1, 0, 1]))
    x = linear_solver("pardiso", [0, 4])
    assert np.all(np.isfinite(x.solve(singular + solid_linear.csr_array(np.eye(4)), np.ones(4))))
