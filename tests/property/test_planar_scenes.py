"""Random planar scenes, turned in space: the planar model has the answer of the full one, and its blocks."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, event, given

import ancf
from ancf.elements import ELEMENTS
from ancf.errors import Message
from ancf.model import Model
from ancf.planar_model import PlanarModel
from ancf.reductions import has_potential, pays
from ancf.scene import (
    Force,
    Foundation,
    Frame,
    Gravity,
    LineLoad,
    LineMoment,
    Moment,
    Pressure,
    Rod,
    Scene,
    SolverOptions,
    Spring,
    Support,
    Tendon,
)
from ancf.scene_plane import Plane, find_plane
from ancf.sections import Annulus, Circle, Ellipse, Polygon, Rectangle, Section
from tests.planar_scenes import from_band
from tests.strategies import draws
from validation.random_rods import LAWS, random_law, random_rotation

every_element = pytest.mark.parametrize("element", ELEMENTS)

RADIUS, LENGTH = 0.01, 0.4
SUPPORTS = (
    (Support(0.0, "clamp"),),
    (Support(0.0, "free_section_clamp"),),
    (Support(1.0, "clamp"),),
    (Support(0.5, "clamp"),),
    (Support(0.0, "clamp"), Support(1.0, "pin")),
)
# Issue 6's limit; 2e-13 measured on 750 scenes: the same equations, rounded otherwise.
AGREE = 1e-12


def random_mirrored(source: Any, element: str) -> tuple[Section, float]:
    """A section, and the angle of the plane's normal in it, 0 along z, for which it is its own image."""
    if element == "cable":
        return Circle(RADIUS), source.number(0.0, 6.0)
    along = source.choice((0.0, 0.5 * np.pi))
    kinds = ("circle", "annulus", "ellipse", "rectangle", "trapezium", "turned circle")
    # r_yz alone has no image in planes between the axes.
    kind = source.choice(kinds[:-1] if element == "3343" else kinds)
    if kind == "turned circle":
        return Circle(RADIUS), source.number(0.0, 6.0)
    if kind == "trapezium":
        return Polygon(((-0.01, -0.006), (0.01, -0.003), (0.01, 0.003), (-0.01, 0.006))), 0.0
    shapes: dict[str, Section] = {
        "circle": Circle(RADIUS),
        "annulus": Annulus(RADIUS, 0.6 * RADIUS),
        "ellipse": Ellipse(RADIUS, 0.7 * RADIUS),
        "rectangle": Rectangle(1.2 * RADIUS, 1.8 * RADIUS),
    }
    return shapes[kind], along


def random_planar(source: Any, element: str) -> Scene:
    """A rod in a random plane with loads of some E I/L^2 in it."""
    section, angle = random_mirrored(source, element)
    turned = angle not in (0.0, 0.5 * np.pi)
    law = LAWS[0] if element == "cable" or turned else source.choice((*LAWS, LAWS[0]))
    material = random_law(source, law, source.number(0.0, 0.45))
    # Section axes in the plane's: x in the plane, y turned by the angle about x.
    c, s = np.cos(angle), np.sin(angle)
    axes = np.array([[1.0, 0, 0], [0, c, -s], [0, s, c]])  # rows: x, in the plane, normal
    if angle == 0.5 * np.pi:
        axes = np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]])
    turn = random_rotation(source)
    base = Frame(np.array([0.3, -0.2, 0.1]), turn @ axes)
    bends = element != "cable" and not turned and source.choice((False, True))
    curvature = axes.T @ [0, 0, source.number(-3.0, 3.0)] if bends else np.zeros(3)
    rod = Rod(
        "arm", LENGTH, source.choice((1, 3, 5)), section, material, element=element, base=base,
        curvature=curvature, supports=source.choice(SUPPORTS),
    )  # fmt: skip
    EI = material.young_modulus * section.weaker_second_moment
    force, moment = EI / LENGTH**2, EI / LENGTH

    def along() -> np.ndarray:
        return turn @ [source.number(-1.0, 1.0), source.number(-2.0, 2.0), 0.0]

    def place() -> np.ndarray:
        """(y, z) on the plane, inside every section here."""
        return 0.0035 * source.number(-1.0, 1.0) * axes[1, 1:]

    def across() -> np.ndarray:
        return turn @ [0.0, 0.0, source.number(-2.0, 2.0)]

    direction = "fixed" if element == "cable" else source.choice(("fixed", "follower"))
    loads: dict[str, Any] = {}
    kinds = ("force", "line_load", "weight", "springs", "bed")
    if element != "cable":
        kinds = (*kinds, "lever", "moment", "line_moment", "tendon", "chamber")
    for kind in {source.choice(kinds), source.choice(kinds)}:
        if kind == "force":
            loads["forces"] = (Force("arm", source.choice((1.0, 0.6)), force * along(), direction=direction),)
        elif kind == "lever":
            offset = place() if not isinstance(section, Annulus) else np.zeros(2)
            loads["forces"] = (Force("arm", 1.0, force * along(), offset),)
        elif kind == "line_load":
            loads["line_loads"] = (LineLoad("arm", force / LENGTH * along(), direction),)
        elif kind == "weight":
            loads["gravity"] = Gravity(force / LENGTH / ((material.density or 1.0) * section.area) * along())
        elif kind == "springs":
            along_axes = force / LENGTH * np.array([source.number(0.0, 9.0) for _ in range(3)])
            stiffness = (turn * along_axes) @ turn.T
            anchor = base.position + LENGTH * along()
            loads["springs"] = (Spring("arm", 1.0, stiffness), Spring("arm", 0.6, stiffness, anchor=anchor))
        elif kind == "bed":
            along_axes = force / LENGTH**2 * np.array([source.number(0.0, 9.0) for _ in range(3)])
            loads["foundations"] = (Foundation("arm", along_axes, turn, 0.0, 0.7),)
        elif kind == "moment":
            definition = source.choice(("section", "vorticity"))
            loads["moments"] = (Moment("arm", 0.8, moment * across(), direction, definition),)
        elif kind == "line_moment":
            loads["line_moments"] = (LineMoment("arm", moment / LENGTH * across(), direction),)
        elif kind == "tendon":
            path = np.array([[0.0, *place()], [0.5, *place()], [1.0, *place()]])
            loads["tendons"] = (Tendon("arm", force * source.number(0.0, 2.0), path),)
        else:
            pressure = moment / (np.pi * 0.002**2 * RADIUS) * source.number(0.0, 0.5)
            loads["pressures"] = (Pressure("arm", pressure, place(), 0.002),)
    return Scene((rod,), **loads)


@every_element
@given(source=draws())
def test_auto_is_full(source, element: str):
    """Pose, status and stability; no scene is missed in which the plane pays, as each is its own image."""
    one = random_planar(source, element)
    auto = ancf.solve(one)
    full = ancf.solve(replace(one, solver=SolverOptions(reduction="full")))
    event(
        f"{full.status}, stable {full.stable}, {auto.reductions[0].split(':')[0] if auto.reductions else '-'}"
    )
    assert auto.status == full.status
    if full.status != "converged":
        return
    assert auto.stable is full.stable
    if full.stable and pays(one) and not isinstance(find_plane(one), Message):
        assert auto.reductions and auto.reductions[0].startswith("planar:")
    assert auto.model.largest_motion(auto.q - full.q) <= AGREE


@every_element
@given(source=draws())
def test_both_parities_are_the_full_tangent(source, element: str):
    """F^T K F and F^T g on both, nothing between them, at random shapes in the plane and a step behind."""
    one = random_planar(source, element)
    assume(one.rods[0].elements < 5)
    model = Model(one)
    plane = find_plane(one)
    # Where the loads leave the plane undetermined but for rounding another one through the axis is found, in
    # which rubber, curved rods and 3343 are not solved: the full model is taken then.
    assume(isinstance(plane, Plane))
    assert isinstance(plane, Plane)
    planar = PlanarModel(model, plane, has_potential(one, plane))
    inside, across = planar.in_plane, planar.across
    rng = np.random.default_rng(int(1e6 * source.number(0.0, 1.0)))
    u = inside.of(model.q0) + 0.02 * inside.system.unit * rng.uniform(-1, 1, inside.n)
    before = u + 0.01 * inside.system.unit * rng.uniform(-1, 1, inside.n)
    q, q_before = inside.to_full(u), inside.to_full(before)
    assume(not model.inside_out(q) and not model.inside_out(q_before))
    F, G = (np.column_stack([side.to_full(row) for row in np.eye(side.n)]) for side in (inside, across))
    exact, flat = model.residual_and_tangent(q, 0.7, q_before)
    forces, reduced_flat = planar.residual_and_tangent(q, 0.7, q_before)
    K = from_band(model.pattern.banded(flat), model.pattern.b)
    largest = scaled(F.T @ K @ F, inside)
    assert_close(scaled(from_band(inside.pattern.banded(reduced_flat), inside.pattern.b), inside), largest)
    mixed = (F.T @ K @ G) * (inside.system.unit[:, None] * across.system.unit)
    assert np.abs(mixed).max() <= 1e-10 * np.abs(largest).max()
    here = from_band(model.pattern.banded(model.residual_and_tangent(q, 0.7)[1]), model.pattern.b)
    odd = from_band(across.pattern.banded(planar.across_tangent(q, 0.7)), across.pattern.b)
    assert_close(scaled(odd, across), scaled(G.T @ here @ G, across))
    for mine, its in ((forces.Q_int, exact.Q_int), (forces.Q_ext, exact.Q_ext)):
        assert_close(inside.force_of(mine) * inside.system.unit, inside.force_of(its) * inside.system.unit)
        assert np.abs(across.force_of(its) * across.system.unit).max() <= 1e-10 * max(
            np.abs(exact.Q_int * model.unit).max(), np.abs(its * model.unit).max()
        )


def scaled(K: np.ndarray, side: Any) -> np.ndarray:
    """Dimensionless but for the energy."""
    return K * np.outer(side.system.unit, side.system.unit)


def assert_close(found: np.ndarray, expected: np.ndarray) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-11 * max(np.abs(expected).max(), 1e-300))
