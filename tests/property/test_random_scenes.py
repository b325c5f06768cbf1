"""Random scenes are solved or end in a typed status; a solution is one by an independent count.

The long tier: ``HYPOTHESIS_PROFILE=long pytest tests/property/test_random_scenes.py`` draws 10 000 scenes and
as many broken files; the other profiles draw some.
"""

from __future__ import annotations

import json
import math
import time
from typing import Any

import numpy as np
from hypothesis import HealthCheck, event, example, given, settings, strategies as st

import ancf
from ancf.failure import element_turns
from ancf.hyperelastic import NeoHookean
from ancf.solution import Solution, Status
from tests.property.test_scene_fuzz import mutated, read
from validation.recheck import energy_error, work_error

SECONDS = 5.0  # budget of a scene
SLACK = 60.0  # what one step may take beyond it on a busy machine: a hang takes for ever
ENERGY = 1e-5
WORK = 1e-5
BALANCE = 1e-10  # issue "effects", numbers: of the larger of the load and E I/L^2, plus the float64 floor
# Rubber's energy is no polynomial, and its section rule is of degree 8: it leaves in energy and work 4e-9 at
# kappa R = 0.4, 1e-7 at 0.5, 2e-4 at 0.9, so c (kappa R)^10, until fibres vanish on the inside at 1.
RUBBER = 1e-2


# Counterexample to a recheck that integrated the following load by a finer rule than the load's own.
FOLLOWER_LINE_LOAD: dict[str, Any] = {
    "rod": [
        {
            "length": 1.0,
            "elements": 1,
            "section": {"shape": "circle", "radius": 0.1},
            "material": {"young_modulus": 100.0, "poisson_ratio": 0.0, "density": 1.0},
        }
    ],
    "line_load": [{"value": [0.0, 0.0, 0.07853981633974483], "direction": "follower"}],
    "solver": {"max_seconds": SECONDS, "max_steps": 60},
}

# Counterexample to limits that do not grow with the bending of rubber: kappa R = 0.9.
THICK_RUBBER: dict[str, Any] = {
    "rod": [
        {
            "length": 1.0,
            "elements": 2,
            "section": {"shape": "circle", "radius": 0.17783},
            "material": {"law": "neo-hookean", "young_modulus": 100.0, "poisson_ratio": 0.4999},
        }
    ],
    "moment": [{"value": [0.0, 0.0, 0.38645], "at": 0.125}],
    "solver": {"max_seconds": SECONDS, "max_steps": 60},
}

# Counterexample to a recheck whose steps turn an element of 1e-5 of the length inside out.
SHORT_ELEMENT: dict[str, Any] = {
    "rod": [
        {
            "length": 1.0,
            "elements": 3,
            "section": {"shape": "circle", "radius": 0.01},
            "material": {"law": "neo-hookean", "young_modulus": 195.6, "poisson_ratio": 0.0},
            "supports": [{"at": 0.0}, {"at": 1.0, "kind": "pin"}],
            "curvature": [0.0, 1.2094596825200927, -1.3650847223056093],
        }
    ],
    "force": [{"value": [0.0, 0.0, 1.5363884935980344e-06], "at": 0.99999}],
    "solver": {"max_seconds": SECONDS, "max_steps": 60},
}


def exponential(low: float, high: float) -> st.SearchStrategy[float]:
    """Numbers spread evenly over their magnitudes."""
    return st.floats(math.log10(low), math.log10(high)).map(lambda x: float(10.0**x))


@st.composite
def scenes(draw: st.DrawFn) -> dict[str, Any]:
    """One rod of any slenderness, stiffness and support under loads of its own scale, and how to solve it."""
    length = draw(exponential(1e-3, 1e2))
    radius = length / draw(exponential(5.0, 2000.0))
    young = draw(exponential(1e2, 1e12))
    shape = draw(st.sampled_from(["circle", "rectangle", "annulus"]))
    section, second, area = {
        "circle": ({"shape": "circle", "radius": radius}, math.pi * radius**4 / 4, math.pi * radius**2),
        "rectangle": (
            {"shape": "rectangle", "height_y": 2 * radius, "width_z": radius},
            radius**4 / 6,
            2 * radius**2,
        ),
        "annulus": (
            {"shape": "annulus", "radius": radius, "inner_radius": 0.5 * radius},
            math.pi * radius**4 * (1 - 0.5**4) / 4,
            math.pi * radius**2 * 0.75,
        ),
    }[shape]
    element = draw(st.sampled_from(["3333", "3333", "3243", "3343", "3363"]))
    rod: dict[str, Any] = {
        "length": length,
        "elements": draw(st.integers(1, 16)),
        "element": element,
        "section": section,
        "material": {
            "law": draw(st.sampled_from(["saint-venant-kirchhoff", "saint-venant-kirchhoff", "neo-hookean"])),
            "young_modulus": young,
            "poisson_ratio": draw(st.one_of(st.floats(-0.3, 0.49), st.just(0.4999))),
            "density": draw(exponential(1.0, 1e4)),
        },
        "supports": draw(
            st.sampled_from(
                [
                    [{"at": 0.0}],
                    [{"at": 0.0, "kind": "free_section_clamp"}],
                    [{"at": 1.0}],
                    [{"at": 0.4}],
                    [{"at": 0.0}, {"at": 1.0, "kind": "pin"}],
                    [{"at": 0.0}, {"at": 1.0}],
                ]
            )
        ),
    }
    if draw(st.booleans()):
        rod["base"] = {
            "position": draw(st.lists(st.floats(-1e3, 1e3), min_size=3, max_size=3)),
            "x_axis": [1.0, draw(st.floats(-1, 1)), draw(st.floats(-1, 1))],
            "y_axis": [0.0, 1.0, draw(st.floats(-1, 1))],
        }
    if draw(st.booleans()):
        most = 1.0 * rod["elements"] / length
        rod["curvature"] = [draw(st.floats(-1, 1)) * min(most, 3.0 / length) * 0.5 for _ in range(3)]
    EI = young * second
    vectors = st.lists(st.floats(-1, 1), min_size=3, max_size=3).map(np.array)
    places = st.one_of(st.sampled_from([0.5, 1.0]), st.floats(0.0, 1.0))
    directions = st.sampled_from(["fixed", "fixed", "follower"])
    scene: dict[str, Any] = {"rod": [rod]}
    sizes = st.one_of(exponential(1e-3, 30.0), st.just(0.0), exponential(1e-300, 1e300))
    for name, unit in (("force", EI / length**2), ("moment", EI / length), ("line_load", EI / length**3)):
        scene[name] = []
        for _ in range(draw(st.sampled_from([0, 0, 1, 1, 2]))):
            with np.errstate(over="ignore"):
                value = draw(sizes) * unit * draw(vectors)
            load: dict[str, Any] = {
                "value": np.clip(value, -1e308, 1e308).tolist(),
                "direction": draw(directions),
            }
            if name != "line_load":
                load["at"] = draw(places)
            scene[name].append(load)
    if draw(st.integers(0, 3)) == 0:
        size = draw(exponential(1e-2, 300.0)) * EI / (rod["material"]["density"] * area * length**3)
        scene["gravity"] = {"acceleration": (size * draw(vectors)).tolist()}
    scene["solver"] = {
        "max_seconds": SECONDS,
        "max_steps": 60,
        "predictor": draw(st.sampled_from(["auto", "auto", "none"])),
        "method": draw(st.sampled_from(["newton", "newton", "newton", "arclength"])),
    }
    if draw(st.integers(0, 3)) == 0:
        scene["stability"] = {"modes": 2, "branch": draw(st.sampled_from(["primary", "buckled"]))}
    return scene


def section_rule_error(solution: Solution) -> float:
    """What the section rule may leave of the energy of bent rubber."""
    largest = 0.0
    for rod in solution.model.rods:
        if isinstance(rod.rod.material, NeoHookean):
            bending = rod.rod.section.outer_radius * np.max(element_turns(rod, solution.q) / rod.mesh.h)
            largest = max(largest, RUBBER * min(1.0, float(bending)) ** 10)
    return largest


def check(solution: Solution, seconds: float) -> None:
    """What holds of every result, and of a converged one."""
    json.dumps(solution.as_dict(), allow_nan=False)
    assert np.isfinite(solution.q).all()
    assert seconds < SECONDS + SLACK
    assert solution.balance().relative <= BALANCE + solution.residual_floor
    if solution.status is not Status.CONVERGED:
        message = solution.message
        assert message is not None
        assert all((message.what, message.where, message.value, message.cause, message.advice))
        assert abs(solution.load_factor) >= 0.0
        return
    assert solution.load_factor == 1.0 or abs(solution.load_factor - 1.0) < 1e-12
    assert solution.residual <= max(1e-10, solution.residual_floor)
    coarse = section_rule_error(solution)
    assert energy_error(solution) <= ENERGY + coarse
    # What rounding leaves of the residual works along a motion of order one.
    limit = max(WORK + coarse, 100.0 * solution.residual_floor)
    assert work_error(solution, np.random.default_rng(0), motions=1) <= limit


@settings(suppress_health_check=list(HealthCheck), deadline=None)
@given(scenes())
@example(FOLLOWER_LINE_LOAD)
@example(THICK_RUBBER)
@example(SHORT_ELEMENT)
def test_random_scenes_end_as_they_must(data: dict[str, Any]):
    """No crash, no number that is not finite, no search beyond its budget, no wrong `converged`."""
    try:
        scene = ancf.scene_from_dict(data)
        started = time.perf_counter()
        solution = ancf.solve(scene)
    except ancf.SceneError as error:  # a mesh too coarse for its curvature, a rod too slender for float64
        event("refused")
        assert error.message.advice
        return
    event(str(solution.status))
    check(solution, time.perf_counter() - started)


@settings(suppress_health_check=list(HealthCheck), deadline=None)
@given(mutated())
def test_broken_scenes_are_refused_or_solved(data: dict[str, Any]):
    """A file with up to three values replaced, removed, doubled or added; what is read is solved as well."""
    scene = read(data)
    if scene is None:
        event("refused")
        return
    if sum(rod.elements for rod in scene.rods) > 300 or scene.solver.max_seconds > 60.0:
        return  # legal, and slow
    started = time.perf_counter()
    try:
        solution = ancf.solve(scene)
    except ancf.SceneError:
        return
    seconds = time.perf_counter() - started
    event(str(solution.status))
    json.dumps(solution.as_dict(), allow_nan=False)
    assert seconds < scene.solver.max_seconds + SLACK
