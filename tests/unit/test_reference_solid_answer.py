"""The solid as a stored answer: its error bar, its fall-back, and every refusal."""

from __future__ import annotations

import numpy as np
import pytest

from reference import solid_answer as module
from reference.rotation import log
from reference.section_answer import NoAnswer, section_answer
from reference.solid_answer import solid_answer
from reference.solid_problem import SolidStatus

LENGTH, RADIUS = 0.2, 0.01
SVK = {"law": "saint-venant-kirchhoff", "young_modulus": 1e6, "poisson_ratio": 0.3}
CIRCLE = {"shape": "circle", "radius": RADIUS}
BENDING = {"moment": [0.0, 0.0, 1e6 * np.pi * RADIUS**4 / 4 * 0.8 / LENGTH]}


@pytest.fixture
def coarse(monkeypatch):
    """Two seconds instead of forty: three coarse meshes each."""
    monkeypatch.setattr(module, "CELLS", (1, 2, 3))
    monkeypatch.setattr(module, "SLICES", 12)


def test_the_error_bar_holds_against_the_section_problem(coarse):
    found = solid_answer(SVK, CIRCLE, LENGTH, BENDING)
    exact = section_answer(SVK, CIRCLE, LENGTH, BENDING["moment"])
    turned = np.linalg.norm(log(np.array(found["rotation"]) @ np.array(exact["rotation"]).T))
    ends = 0.8 * (0.04) ** 2 * RADIUS / LENGTH  # (kappa R)^2 R/L of the angle: the end couple's layer
    assert turned < found["angle_error"] + ends
    assert found["angle_error"] < 5e-3
    assert found["stress"]["axial"].shape == (len(found["stress"]["points"]),)


def test_a_start_that_fails_is_replaced_by_load_steps(coarse, monkeypatch):
    exact = solid_answer(SVK, CIRCLE, LENGTH, BENDING)
    solve = module.solve_solid

    def no_luck(problem, **limits):
        from dataclasses import replace

        return replace(solve(problem, **limits), status=SolidStatus.NOT_CONVERGED)

    monkeypatch.setattr(module, "solve_solid", no_luck)
    stepped = solid_answer(SVK, CIRCLE, LENGTH, BENDING)
    np.testing.assert_allclose(stepped["rotation"], exact["rotation"], atol=1e-8)


def test_refusals(monkeypatch):
    with pytest.raises(ValueError, match="support is 'hard'"):
        solid_answer(SVK, CIRCLE, LENGTH, BENDING, support="hard")
    with pytest.raises(ValueError, match="holds no torque"):
        solid_answer(SVK, CIRCLE, LENGTH, {"moment": [0.01, 0.0, 0.0]})
    with pytest.raises(NoAnswer, match="no rod to start the solid from"):
        solid_answer(SVK, CIRCLE, LENGTH, {"force": [0.0, 1e6, 0.0]})
    with pytest.raises(NoAnswer, match="was not started: estimated memory"):
        monkeypatch.setattr(module, "MEMORY_LIMIT", 1e8)
        solid_answer(SVK, CIRCLE, LENGTH, BENDING)
