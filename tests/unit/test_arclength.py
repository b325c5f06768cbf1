"""Paths through limit points and onto other branches: what holds whatever the reference."""

import json
import math

import numpy as np
import pytest

import ancf
from ancf.continuation import _between, follow
from ancf.model import Model
from ancf.newton import newton
from ancf.spectrum import Spectrum
from validation.hard_cases import hard_cases

R, L = 0.01, 1.0
EI = 1e9 * math.pi * R**4 / 4


def arch(load=50.0, angle=0.6, elements=8, element="3333", at=0.5, **tables):
    """Circular arch clamped at both ends, pushed down at a fraction of its length by load EI/L^2."""
    half = angle / 2
    rod = {
        "length": L, "elements": elements, "element": element, "section": {"shape": "circle", "radius": R},
        "material": {"young_modulus": 1e9, "poisson_ratio": 0.3},
        "curvature": [0, 0, -angle / L],
        "base": {
            "x_axis": [math.cos(half), math.sin(half), 0],
            "y_axis": [-math.sin(half), math.cos(half), 0],
        },
        "supports": [{"at": 0.0}, {"at": 1.0}],
    }  # fmt: skip
    return {"rod": [rod], "force": [{"at": at, "value": [0, -load * EI / L**2, 0]}], **tables}


def column(load, slenderness=100.0, push=0.0, **tables):
    """Clamped column under load times the Euler load, and a share of that across it."""
    P = load * math.pi**2 / 4 * 1e6 * math.pi * (0.4 / slenderness) ** 4 / 4 / 0.4**2
    rod = {
        "length": 0.4, "elements": 8, "section": {"shape": "circle", "radius": 0.4 / slenderness},
        "material": {"young_modulus": 1e6, "poisson_ratio": 0.3},
    }  # fmt: skip
    return {"rod": [rod], "force": [{"value": [-P, push * P, 0]}], **tables}


def followed(scene, to=1.0, **options):
    model = Model(ancf.scene_from_dict(scene))
    return model, follow(model, to, 200, math.inf, **options)


def limits(found):
    return [c.load_factor for c in found.critical if c.kind == "limit"]


@pytest.fixture(scope="module")
def snap():
    return followed(arch())


def test_every_point_of_a_path_is_an_equilibrium(snap):
    """Residual at the point's own load factor, against the floor that Newton reported."""
    model, found = snap
    assert found.reached
    assert found.points[-1].load_factor == pytest.approx(1.0, abs=1e-12)
    for point in found.points:
        g = model.system.project(model.residual(point.q).at(point.load_factor))
        assert np.max(np.abs(g / model.force_unit)) <= max(10 * point.floor, 1e-9)


def test_the_load_turns_back_twice(snap):
    """Up to the first limit point, down to the second, up again; the crown goes down all the way."""
    model, found = snap
    upper, lower = limits(found)
    assert upper > 1.5 * lower
    loads = np.array([p.load_factor for p in found.points])
    assert loads[:-1].max() < 1.0
    peak = next(i for i, load in enumerate(loads) if load == upper)
    assert np.all(loads[:peak] < upper)
    assert np.any(loads[peak:] <= lower * (1 + 1e-9))
    crown = [model.rods[0].nodal(p.q)[len(model.rods[0].q0) // 2, 0, 1] for p in found.points]
    assert np.all(np.diff(crown) < 0.0)
    assert crown[-1] < 0.0 < crown[0]


def test_the_tangent_of_a_path_points_along_it(snap):
    """Down between the limit points, up elsewhere: the sign of dl/ds is that of the change of load."""
    _, found = snap
    limit = [c.point for c in found.critical if c.kind == "limit"]
    inner = [p for p in found.points if limit[0].arc < p.arc < limit[1].arc]
    assert inner
    assert all(p.tangent[1] < 0.0 for p in inner)
    assert all(p.tangent[1] > 0.0 for p in found.points if p.arc < limit[0].arc or p.arc > limit[1].arc)


def test_a_load_is_crossed_from_either_side():
    assert _between(2.0, 1.0, 0.5)
    assert _between(0.5, 1.0, 2.0)
    assert not _between(1.5, 1.0, 2.0)


def test_at_a_limit_point_the_load_is_stationary(snap):
    """dl/ds = 0 and an eigenvalue = 0 to the accuracy of the location, against those of the unloaded arch."""
    model, found = snap
    for critical in (c for c in found.critical if c.kind == "limit"):
        assert abs(critical.point.tangent[1]) < 1e-3
        f, _ = Spectrum(model).lowest(critical.point.q, critical.load_factor, 6)
        unloaded, _ = Spectrum(model).lowest(model.q0, 0.0, 1)
        assert np.min(np.abs(f)) < 1e-3 * unloaded[0]


def test_the_size_of_the_load_only_scales_the_load_factor(snap):
    """Ten times the load, a tenth of the factor: the path does not jump over the snap."""
    _, other = followed(arch(load=500.0))
    np.testing.assert_allclose(np.array(limits(other)) * 10.0, limits(snap[1]), rtol=1e-6)


def test_newton_at_a_load_before_the_limit_meets_the_path(snap):
    """The same shape by load steps: the path is that of the equilibria, not one of its own."""
    solution = ancf.solve(ancf.scene_from_dict(arch(load=10.0)))
    _, found = followed(arch(load=10.0))
    assert solution.status == "converged"
    np.testing.assert_allclose(found.points[-1].q, solution.q, atol=1e-8)


def test_newton_ends_at_the_limit_point_and_says_what_to_try():
    """Load control cannot pass a snap; if Newton lands beyond it, that is another equilibrium, also right."""
    solution = ancf.solve(ancf.scene_from_dict(arch(load=20.0, solver={"predictor": "none"})))
    assert solution.status in ("limit_point", "converged")
    if solution.status == "limit_point":
        assert "arclength" in solution.message.advice


@pytest.mark.parametrize("branch", ["primary", "buckled"])
def test_a_column_beyond_its_buckling_load(branch):
    """Straight and unstable, or bent to +y, stable and one of two that are mirror images."""
    solution = ancf.solve(ancf.scene_from_dict(column(1.5, stability={"branch": branch})))
    assert solution.status == "converged"
    assert solution.stability is not None
    # Engesser: shear and compression lower the load by (pi^2/4)(R/2L)^2 (1 - E/G), here by 0.02 %.
    assert solution.stability.buckling_factor == pytest.approx(1 / 1.5, rel=5e-4)
    first = solution.stability.critical_points[0]
    assert (first.kind, len(first.modes)) == ("bifurcation", 2)
    tip = solution.tip().position
    if branch == "primary":
        assert solution.stability.negative_pivots == 2
        assert abs(tip[1]) < 1e-9
    else:
        assert solution.stability.negative_pivots == 0
        assert solution.stable is True
        assert tip[1] > 0.2
        assert abs(tip[2]) < 1e-6
        # The same shape is found with a small push to +y and without any branch.
        pushed = ancf.solve(ancf.scene_from_dict(column(1.5, push=1e-6)))
        np.testing.assert_allclose(tip, pushed.tip().position, atol=1e-5)


def test_the_result_holds_path_and_stability():
    scene = column(1.5, solver={"method": "arclength"}, stability={"modes": 4})
    solution = ancf.solve(ancf.scene_from_dict(scene))
    result = json.loads(json.dumps(solution.as_dict(), allow_nan=False))
    assert result["stability"].keys() == {
        "negative_pivots", "buckling_factor", "modes", "critical_points", "note"
    }  # fmt: skip
    assert len(result["stability"]["modes"]) == 4
    shape = np.array(result["stability"]["modes"][0]["shape"]["rod"])
    assert np.max(np.abs(shape)) == 1.0
    assert result["path"][0]["load_factor"] == 0.0
    assert result["path"][-1]["load_factor"] == pytest.approx(1.0)
    arcs = [p["arc"] for p in result["path"]]
    assert arcs == sorted(arcs)
    assert result["steps"] + result["cutbacks"] >= len(result["path"]) - 2
    bare = ancf.solve(ancf.scene_from_dict(column(0.5)))
    assert "stability" not in bare.as_dict()
    assert "path" not in bare.as_dict()


def test_no_bifurcation_before_the_load_leaves_the_primary_branch():
    solution = ancf.solve(ancf.scene_from_dict(column(0.5, stability={"branch": "buckled"})))
    assert solution.status == "converged"
    assert abs(solution.tip().position[1]) < 1e-9
    assert solution.stability is not None
    assert solution.stability.buckling_factor == pytest.approx(2.0, rel=5e-4)


def test_a_follower_force_does_not_buckle_in_statics():
    """Beck's column: flutter at 20.05 EI/L^2 and no static critical load; the note says so."""
    scene = column(20.05 * 4 / math.pi**2, stability={})
    scene["force"][0]["direction"] = "follower"
    solution = ancf.solve(ancf.scene_from_dict(scene))
    assert solution.status == "converged"
    assert solution.stability is not None
    assert solution.stability.negative_pivots == 0
    assert "flutter cannot be seen" in solution.stability.note
    # From 60 times on compressed elements buckle by themselves; that is no critical load of the rod.
    assert solution.stability.buckling_factor is None


def test_the_budget_ends_a_path_that_does_not_come_back():
    """A roll beyond the largest moment of the section: the load factor turns back for good."""
    EI_soft = 1e6 * math.pi * 0.08**4 / 4
    rod = {
        "length": 0.4, "elements": 12, "section": {"shape": "circle", "radius": 0.08},
        "material": {"young_modulus": 1e6, "poisson_ratio": 0.3},
    }  # fmt: skip
    scene = {
        "rod": [rod], "moment": [{"value": [0, 0, 2 * math.pi * EI_soft / 0.4]}],
        "solver": {"method": "arclength", "max_steps": 80},
    }  # fmt: skip
    solution = ancf.solve(ancf.scene_from_dict(scene))
    assert solution.status in ("limit_point", "inverted_element", "material_unstable")
    assert 0.0 < solution.load_factor < 1.0
    assert solution.message is not None
    json.dumps(solution.as_dict(), allow_nan=False)


@pytest.mark.parametrize("method", ["newton", "arclength"])
@pytest.mark.parametrize("size", [0.0, 1e-300, 1e300])
def test_loads_of_any_size_end_in_a_status(method, size):
    scene = column(0.0, solver={"method": method}, stability={})
    scene["force"][0]["value"] = [0.0, size, 0.0]
    solution = ancf.solve(ancf.scene_from_dict(scene))
    assert solution.status == ("not_finite" if size > 1.0 else "converged")
    json.dumps(solution.as_dict(), allow_nan=False)
    assert solution.stability is not None
    assert solution.stability.buckling_factor is None
    assert solution.stability.note


def test_a_point_of_the_path_is_refined_by_newton_at_its_load(snap):
    """Plain Newton at the same load factor does not move a point of the path."""
    model, found = snap
    point = found.points[1]
    result = newton(model, point.q, point.load_factor, 10)
    assert result.converged
    assert np.max(np.abs((result.q - point.q) / model.unit)) < 1e-8


@pytest.mark.parametrize("load", [1.0005, 1.001, 1.05])
def test_a_load_just_past_buckling_is_met_on_the_branch(load):
    """The branch is entered a little way, which may already lie past the loads: it is gone back to them."""
    solution = ancf.solve(ancf.scene_from_dict(column(load, stability={"branch": "buckled"})))
    assert solution.status == "converged"
    assert solution.load_factor == pytest.approx(1.0, abs=1e-12)
    assert solution.tip().position[1] > 1e-3
    arcs = [point.arc for point in solution.path]
    assert arcs == sorted(arcs)


def test_a_branch_that_is_not_met_is_said():
    solution = ancf.solve(ancf.scene_from_dict(column(0.5, stability={"branch": "buckled"})))
    assert solution.stability is not None
    assert "primary branch" in solution.stability.note


def test_many_unknowns_see_the_same_spectrum(monkeypatch):
    """Far beyond buckling several eigenvalues are negative: Lanczos must find the lowest, not the nearest."""
    model = Model(ancf.scene_from_dict(column(150.0)))
    q = newton(model, model.q0, 1.0, 30).q
    band, _ = Spectrum(model).lowest(q, 1.0, 3)
    assert np.count_nonzero(Spectrum(model).lowest(q, 1.0, 20)[0] < 0.0) >= 10
    monkeypatch.setattr("ancf.spectrum.SMALL", 0)
    np.testing.assert_allclose(Spectrum(model).lowest(q, 1.0, 3)[0], band, rtol=1e-6)


def test_a_moment_that_overflows_ends_in_a_status_with_stability_asked():
    scene = column(0.0, stability={})
    scene["moment"] = [{"value": [0.0, 0.0, 1e308]}]
    solution = ancf.solve(ancf.scene_from_dict(scene))
    assert solution.status == "not_finite"
    json.dumps(solution.as_dict(), allow_nan=False)


def test_a_critical_point_is_located_to_rounding():
    """A narrow frame, shaken by rounding: there the eigenvalue is 1e-5 of the unloaded."""
    case = next(c for c in hard_cases() if c.name.startswith("right-angle frame, pushed"))
    solution = ancf.solve(ancf.scene_from_dict(case.scene))
    assert solution.stability is not None
    model = solution.model
    unloaded, _ = Spectrum(model).lowest(model.q0, 0.0, 1)
    assert abs(solution.stability.modes[0].eigenvalue) < 1e-5 * unloaded[0]
