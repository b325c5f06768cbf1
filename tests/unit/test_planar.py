"""Planar scenes on planar unknowns: the same answer and the same stability."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import ancf
from ancf.elements import ELEMENTS
from ancf.hyperelastic import MooneyRivlin, NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.mirror_system import Parity
from ancf.mirror_unknowns import turned_vectors
from ancf.model import Model
from ancf.planar_model import PlanarModel
from ancf.planar_start import in_plane
from ancf.predictor import _chain as chain_of
from ancf.reductions import chosen, has_potential, reduced
from ancf.rod_start import nodal_loads
from ancf.rotation import exp
from ancf.scene import (
    Force,
    Frame,
    LineLoad,
    Moment,
    Rod,
    Scene,
    SolverOptions,
    Support,
)
from ancf.sections import Circle, Polygon, Rectangle
from ancf.segments import Segment
from tests.planar_scenes import (
    FORCE,
    LENGTH,
    LOADS,
    OBLIQUE,
    SOFT,
    TRAPEZIUM,
    arm,
    both,
    distance,
    find,
    from_band,
    is_planar,
    scene,
)


def moved(one: Scene, turn: np.ndarray) -> Scene:
    """A scene of one rod and one force, turned in space."""
    rod, force = one.rods[0], one.forces[0]
    base = Frame(turn @ rod.base.position, turn @ rod.base.rotation)
    return replace(one, rods=(replace(rod, base=base),), forces=(replace(force, value=turn @ force.value),))


RODS = {
    **{f"{name} {formulation}": arm(element=name, formulation=formulation)
       for name, element in ELEMENTS.items() for formulation in element.formulations},
    "full rule": arm(axial_rule="full"),
    "rectangle": arm(section=Rectangle(0.02, 0.01)),
    "trapezium": arm(section=TRAPEZIUM),
    "shear factors": arm(shear_factors=(0.8, 0.9)),
    "curved": arm(curvature=np.array([0.0, 0.0, 3.0])),
    "rubber": arm(material=NeoHookean(1e6, 0.45)),
    "curved rubber": arm(material=MooneyRivlin(1.2e5, 5e4, 2e6), curvature=np.array([0.0, 0.0, -2.0])),
    "quadratic rubber": arm(element="3363", material=NeoHookean(1e6, 0.45), elements=3),
    "free section": arm(supports=(Support(0.0, "free_section_clamp"),)),
    "taper": Rod.of_segments("arm", (Segment(LENGTH, 6, Circle(0.012), SOFT, Circle(0.008)),)),
    "two materials": Rod.of_segments(
        "arm", (Segment(0.2, 3, Circle(0.01), SOFT), Segment(0.2, 2, Circle(0.01), NeoHookean(2e6, 0.4)))
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", RODS)
@pytest.mark.parametrize("way", ["along z", "along y", "turned"])
def test_rods_bend_in_the_plane_as_they_do_in_space(name: str, way: str):
    """The normal along z, then along y of the section, then the first in a plane that is none of the axes."""
    rod = RODS[name]
    if way == "along y":
        if np.any(rod.curvature) or isinstance(rod.section, Polygon):
            rod = replace(rod, base=Frame(np.zeros(3), np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]).T))
        one = scene(rod, forces=(Force("arm", 1.0, np.array([0.2, 0.0, 3.0]) * FORCE),))
        if rod.base.rotation[1, 1] != 1.0:
            one = scene(rod, forces=(Force("arm", 1.0, np.array([0.2, 0.0, 3.0]) * FORCE),))
    else:
        one = scene(rod)
    if way == "turned":
        one = moved(one, OBLIQUE)
    planar, full = both(one)
    assert is_planar(planar) and not full.reductions
    assert planar.status == full.status == "converged"
    assert planar.stable is full.stable is True
    assert planar.iterations == full.iterations
    assert distance(planar, full) < 1e-12


@pytest.mark.parametrize("name", ["3333", "3243", "3363", "cable"])
@pytest.mark.parametrize("angle", [0.3, 2.2])
def test_round_rods_have_a_plane_in_every_direction(name: str, angle: float):
    one = scene(arm(element=name), forces=(
        Force("arm", 1.0, 3.0 * FORCE * np.array([0.0, np.cos(angle), np.sin(angle)])),
    ))  # fmt: skip
    planar, full = both(one)
    assert is_planar(planar)
    assert distance(planar, full) < 1e-12


@pytest.mark.parametrize("load", LOADS)
@pytest.mark.parametrize("name", ["3333", "3363"])
def test_loads_in_the_plane_do_what_they_do_in_space(load: str, name: str):
    one = scene(arm(element=name), **{"forces": (), **LOADS[load]})
    planar, full = both(one, insist=True)
    assert is_planar(planar)
    assert planar.status == full.status == "converged"
    assert planar.stable is full.stable
    assert planar.iterations == full.iterations
    assert distance(planar, full) < 1e-12


@pytest.mark.parametrize("load", LOADS)
def test_tangents_are_the_two_blocks_of_the_full_one(load: str):
    """F^T K F of both parities, and nothing between them; at a shape in the plane that is no equilibrium."""
    one = scene(arm(elements=3), **{"forces": (), **LOADS[load]})
    model = Model(one)
    planar = reduced(model, chosen(replace(one, solver=SolverOptions(reduction="planar"))))
    assert isinstance(planar, PlanarModel)
    rng = np.random.default_rng(3)
    sides = [planar.in_plane, planar.across]
    u = sides[0].of(model.q0) + 0.03 * sides[0].system.unit * rng.uniform(-1, 1, sides[0].n)
    before = u + 0.01 * sides[0].system.unit * rng.uniform(-1, 1, sides[0].n)
    q, q_before = sides[0].to_full(u), sides[0].to_full(before)
    full = dense(model, model.residual_and_tangent(q, 0.7, q_before)[1])
    forces, flat = planar.residual_and_tangent(q, 0.7, q_before)
    F, G = (np.column_stack([side.to_full(row) for row in np.eye(side.n)]) for side in sides)
    scale = np.outer(model.force_unit, 1.0 / model.unit)
    mixed = F.T @ (full / scale) @ G
    assert np.abs(mixed).max() < 1e-12 * np.abs(full / scale).max()
    np.testing.assert_allclose(
        dense_of(sides[0], flat), F.T @ full @ F, rtol=0, atol=1e-13 * np.abs(F.T @ full @ F).max()
    )
    here = dense(model, model.residual_and_tangent(q, 0.7)[1])
    np.testing.assert_allclose(
        dense_of(sides[1], planar.across_tangent(q, 0.7)), G.T @ here @ G, rtol=0,
        atol=1e-13 * np.abs(G.T @ here @ G).max(),
    )  # fmt: skip
    exact = model.residual(q)
    for mine, its in ((forces.Q_int, exact.Q_int), (forces.Q_ext, exact.Q_ext)):
        np.testing.assert_allclose(mine, its, rtol=0, atol=1e-13 * np.abs(its).max())
    symmetric = F.T @ full @ F
    if has_potential(one, find(one)):
        assert np.abs(symmetric - symmetric.T).max() < 1e-13 * np.abs(symmetric).max()
    else:
        assert load in ("vorticity", "follower", "follower line load")


def dense(model: Model, flat: np.ndarray) -> np.ndarray:
    return from_band(model.pattern.banded(flat), model.pattern.b)


def dense_of(side: Parity, flat: np.ndarray) -> np.ndarray:
    return from_band(side.pattern.banded(flat), side.pattern.b)


def test_rods_of_several_elements_share_a_plane():
    """One turned in the plane and standing beside it, one with the normal along y of its section."""
    turned = exp(np.array([0.0, 0.0, 1.1]))
    other = Frame(np.array([0.1, 0.2, 0.3]), turned @ np.array([[1.0, 0, 0], [0, 0, -1], [0, 1, 0]]))
    rods = (arm(), arm(name="other", element="3243", section=Rectangle(0.02, 0.01), base=other), arm(
        name="third", element="cable", supports=(Support(0.0, "clamp"), Support(1.0, "pin"))
    ))  # fmt: skip
    loads = (
        LineLoad("other", np.array([2.0, 1, 0]) * FORCE / LENGTH),
        LineLoad("third", np.array([0, 9.0, 0])),
    )
    planar, full = both(Scene(rods, forces=scene(arm()).forces, line_loads=loads))
    assert is_planar(planar) and planar.status == full.status == "converged"
    assert planar.stable is full.stable is True
    assert distance(planar, full) < 1e-12
    # 12 nodes of 5 of 9, 6 of 7 of 12, 6 of 4 of 6 less the pin
    assert "124 of 213 unknowns" in planar.reductions[0]


def test_load_steps_in_the_plane_are_those_in_space():
    one = scene(arm(), solver=SolverOptions(predictor="none"))
    planar, full = both(one)
    assert is_planar(planar) and planar.steps == full.steps > 1
    assert planar.history[-1].iteration == full.history[-1].iteration
    assert distance(planar, full) < 1e-12


@pytest.mark.parametrize("load", ["lever", "line load", "line moment"])
def test_steps_of_the_planar_chain_are_newtons(load: str):
    """The change of the unbalanced moments along a step undoes them, in first order of its size."""
    one = scene(arm(curvature=np.array([0.0, 0.0, 2.0])), **{"forces": (), **LOADS[load]})
    rod = Model(one).rods[0]
    chain, loads = in_plane(chain_of(rod), nodal_loads(one, rod), find(one))
    # Arms as long as the rod, or their couple would be lost beside its stiffness.
    loads = replace(loads, levers=[(node, 50.0 * arm, F) for node, arm, F in loads.levers])
    # A pull that stiffens the intervals as much as they are stiff.
    loads = replace(
        loads, force=loads.force + 3.0 * chain._stiffness.max() / chain.h.max() * (loads.force != 0)
    )
    angles = chain._state(chain.R_0) + 0.3 * np.sin(np.arange(len(chain.R_0)))
    angles[0] = chain._state(chain.R_0)[0]
    g, parts = chain._residual(angles, loads)
    # With dead forces alone a step from a shape that is no minimum is refused.
    loads = replace(loads, dead_forces_only=False)
    w = chain._step(g, parts, loads, angles, 0.0)
    assert w is not None
    small = 1e-6 / np.abs(w).max()
    ahead, behind = (chain._residual(angles + sign * small * w, loads)[0] for sign in (1.0, -1.0))
    change = (ahead - behind) / (2.0 * small)
    # sinc, by which a chord is shorter than its arc, is taken as it stands.
    np.testing.assert_allclose(change, -g, atol=2e-2 * np.abs(g).max())


@pytest.mark.parametrize("load", ["lever", "follower", "line load", "line moment", "weight"])
@pytest.mark.parametrize("at", [0.0, 0.5])
def test_the_planar_chain_bends_as_the_one_in_space(load: str, at: float):
    """Frames and axial forces of two codes, one of angles and complex numbers, the other of rotations."""
    rod = arm(curvature=np.array([0.0, 0.0, 2.0]), supports=(Support(at, "clamp"),))
    one = scene(rod, **{"forces": (), **LOADS[load]})
    model = Model(one).rods[0]
    chain, loads = chain_of(model), nodal_loads(one, model)
    planar, turned = in_plane(chain, loads, find(one))
    spatial, found = chain.equilibrium(loads, chain.R_0), planar.equilibrium(turned, planar.R_0)
    assert spatial is not None and found is not None
    # Both end once their unbalanced moments are below 1e-6 E I/L.
    np.testing.assert_allclose(found[0], spatial[0], atol=1e-6)
    np.testing.assert_allclose(found[1], spatial[1], atol=1e-5 * FORCE)
    assert np.abs(found[0] - chain.R_0).max() > 0.01


def strip(share: float, **options: Any) -> Scene:
    """A cantilever strip, 2 mm thick and 40 mm high, under a share of its lateral buckling load, in plane.

    4.012599344 sqrt(EI GJ)/L^2 (Timoshenko, Gere 1961, art. 6.3), J of linear sections: int (y^2 + z^2) dA.
    """
    height, thickness = 0.04, 0.002
    rod = Rod("arm", 0.5, 8, Rectangle(height, thickness), SaintVenantKirchhoff(1e9, 0.0))
    second = thickness**3 * height / 12
    torsion = second + height**3 * thickness / 12
    load = 4.012599344 * np.sqrt(1e9 * second * 0.5e9 * torsion) / 0.5**2
    forces = (Force("arm", 1.0, np.array([0.0, share * load, 0.0])),)
    return Scene((rod,), forces=forces, solver=SolverOptions(**options))


@pytest.mark.parametrize(("share", "stable"), [(0.5, True), (2.0, False)])
def test_a_strip_that_buckles_sideways_is_unstable(share: float, stable: bool):
    """In the plane it is an equilibrium below and above the critical load: only the other block knows."""
    planar, full = both(strip(share))
    assert planar.status == full.status == "converged"
    assert planar.stable is full.stable is stable
    assert is_planar(planar) is stable  # the full model decides where the rod would leave the plane
    assert distance(planar, full) < 1e-10
    assert any("unstable" in text for text in planar.warnings) is not stable
    forced = ancf.solve(strip(share, reduction="planar"))
    assert forced.status == "converged" and is_planar(forced)
    assert forced.stable is stable
    assert np.all(forced.nodes()[:, 2] == 0.0)


def test_without_a_potential_the_determinant_out_of_the_plane_counts():
    """A moment that does next to nothing leaves the sign of the determinant only, and it is negative."""
    height = strip(2.0).forces[0].value[1]
    moments = (Moment("arm", 1.0, np.array([0.0, 0.0, 1e-6 * height])),)
    for share, stable in ((0.5, None), (2.0, False)):
        planar, full = both(replace(strip(share), moments=moments))
        assert planar.status == full.status == "converged"
        assert planar.stable is full.stable is stable
        assert is_planar(planar) is (stable is None)
        forced = ancf.solve(replace(strip(share, reduction="planar"), moments=moments))
        assert is_planar(forced) and forced.stable is stable


@pytest.mark.parametrize("reduction", ["auto", "full"])
def test_a_start_out_of_the_plane_is_followed_there(reduction: str):
    one = strip(2.0)
    tilted = np.array([[1.0, 0, 0], [0, 1, 0.01], [0, 0, 1]])
    lateral = replace(one.forces[0], value=one.forces[0].value @ tilted)
    buckled = ancf.solve(replace(one, forces=(lateral,)))
    again = ancf.solve(replace(one, solver=SolverOptions(reduction=reduction)), start=buckled.q)
    assert again.status == "converged" and again.stable
    assert np.abs(again.nodes()[:, 2]).max() > 0.01
    assert not is_planar(again)


def test_a_start_decides_whether_the_plane_will_do():
    one = scene(arm())
    first = ancf.solve(one)
    aside = first.q.copy().reshape(-1, 3)
    aside[-2, 2] += 1e-9  # z of r_y at the tip
    assert is_planar(ancf.solve(one, start=first.q))
    assert not is_planar(ancf.solve(one, start=aside.ravel()))


def test_turned_vectors_are_derivatives_along_turned_axes():
    """Of f = y^2 z + 3 y z + z^2 - 2 y at the origin, by differentiating along the turned axes twice."""
    element = ELEMENTS["3363"]
    c, s = np.cos(0.6), np.sin(0.6)
    by_axes = dict(zip(element.vectors, np.zeros(6), strict=True))
    by_axes |= {(0, 1, 0): -2.0, (0, 0, 1): 0.0, (0, 1, 1): 3.0, (0, 0, 2): 2.0}
    values = turned_vectors(element, c, s) @ np.array(list(by_axes.values()))
    gradient, hessian = np.array([-2.0, 0.0]), np.array([[0.0, 3.0], [3.0, 2.0]])
    a, b = np.array([c, s]), np.array([-s, c])
    expected = {(0, 0, 0): 0.0, (0, 1, 0): a @ gradient, (0, 0, 1): b @ gradient}
    expected |= {(0, 2, 0): a @ hessian @ a, (0, 1, 1): a @ hessian @ b, (0, 0, 2): b @ hessian @ b}
    np.testing.assert_allclose(values, [expected[v] for v in element.vectors], atol=1e-15)
