"""Friction between rods: crossing cantilevers, exact tangent, rigid motions, forces on both, a coil."""

from dataclasses import replace

import numpy as np
import pytest

import ancf
from ancf.effects import blocks_of
from ancf.effects.frictional_rod_contact import FrictionalRodContact
from ancf.effects.rod_contact import RodContact
from ancf.model import Model
from ancf.rotation import exp
from reference.contact import crossing_force
from reference.friction import rubbing_tip
from tests.unit.test_rod_contact import BARE, EI, RADIUS, L, coil, crossed

MU = 0.3


def rubbed(scene, friction=MU, **solver):
    """The scene with friction in its contacts, by its records."""
    contacts = tuple(replace(contact, friction=friction) for contact in scene.contacts)
    return replace(scene, contacts=contacts, solver=replace(scene.solver, **solver))


def effect_of(model):
    (effect,) = model.settling
    assert isinstance(effect, FrictionalRodContact)
    return effect


def anchors_of(effect):
    assert effect.anchors is not None
    return effect.anchors


def test_a_rod_slides_along_another():
    """Friction mu N against a force along the lower rod, which does not give way (reference/friction.py)."""
    P = 0.02 * EI / L**2
    across = 0.5 * P
    solution = ancf.solve(rubbed(crossed([0, -across, -P], beyond=1e-4)))
    assert solution.status == "converged", solution.reason
    (contact,) = solution.as_dict()["contacts"]
    N, friction = crossing_force(P, L, EI, 0.8, EI), contact["friction"]
    assert contact["penetration"] <= 1e-4 * RADIUS
    # On its way it comes 0.2 % nearer to the lower rod's base, which is 0.4 % stiffer there.
    assert friction["force"][1] == pytest.approx(MU * N, rel=6e-3)
    assert friction["force"][1] == pytest.approx(MU * contact["force"][2], rel=3e-3)
    assert (friction["sticking"], friction["slipping"]) == (0, 1)
    way = -solution.tip("upper").position[1]
    assert way == pytest.approx(rubbing_tip(L, EI, across, MU, N), rel=0.02)
    # Loads grow together from the touch on: half of force times way, by steps of 1/20 a 20th more.
    assert friction["dissipated"] == pytest.approx(1.05 * MU * N * way / 2, rel=0.03)
    assert solution.balance().relative <= 1e-9 and solution.stable is None
    # What friction does to one rod it does to the other.
    np.testing.assert_allclose(solution.reaction("lower")[0], contact["force"], atol=1e-9 * P)


def test_a_rod_sticks_to_another():
    P = 0.02 * EI / L**2
    free, held = (
        ancf.solve(rubbed(crossed([0, -0.1 * P, -P], beyond=1e-4), friction)) for friction in (0.0, MU)
    )
    (contact,) = held.as_dict()["contacts"]
    assert (contact["friction"]["sticking"], contact["friction"]["slipping"]) == (1, 0)
    assert abs(held.tip("upper").position[1]) < 0.05 * abs(free.tip("upper").position[1])
    assert contact["friction"]["force"][1] == pytest.approx(0.1 * P, rel=0.05)


def test_no_friction_is_the_contact_without():
    P = 0.02 * EI / L**2
    scene = crossed([0, 0, -P])
    zero, bare = ancf.solve(rubbed(scene, 0.0)), ancf.solve(scene)
    np.testing.assert_array_equal(zero.q, bare.q)
    assert type(zero.model.settling[0]) is RodContact


def shaken(kind, shift=0.0):
    """A model, its effect with anchors of one state, and another state; `shift` changes elements."""
    if kind == "two rods":
        model = Model(rubbed(crossed([0, 0, 0.0], elements=4, angle=70.0)))
    else:
        contact = [{"with": {"shape": "rod", "name": "rod"}}]
        model = Model(rubbed(ancf.scene_from_dict({"rod": [coil(8)[0]], "contact": contact})))
    effect = effect_of(model)
    effect.law.d = np.full_like(effect.law.radius, 0.3)
    effect.law.a = np.linspace(0.0, 0.1, effect.law.k.size).reshape(effect.law.k.shape)
    rng = np.random.default_rng(5)
    q = model.q0 + 0.002 * rng.uniform(-1, 1, model.n) * model.unit
    effect.search(q)
    effect.commit(q)
    effect.multiplier = 0.02 * effect.law.k.max() * rng.uniform(-1, 1, effect.multiplier.shape)
    anchors_of(effect).near[:] = True
    q = q + 0.002 * rng.uniform(-1, 1, model.n) * model.unit
    if shift:
        for rod in model.rods[1:]:  # along itself
            nodes = q[rod.first_dof : rod.first_dof + rod.size].reshape(-1, 3)
            nodes[::3] += shift * rod.rod.base.rotation[:, 0]
    effect.search(q)
    return model, effect, q


@pytest.mark.parametrize(("kind", "shift"), [("two rods", 0.0), ("two rods", 0.15), ("itself", 0.0)])
@pytest.mark.parametrize("stickiness", [0.02, 1.0])
def test_the_tangent_is_exact(kind, shift, stickiness):
    """K = dQ/de by central differences, summed over the unknowns: a block may name an element twice."""
    model, effect, q = shaken(kind, shift)
    effect.stickiness = stickiness
    e = blocks_of(q, effect.dofs)
    touch = effect._touch(e)
    assert touch.friction.slips.any()
    if shift:
        assert np.any(anchors_of(effect).element[effect.pairs.point] != effect.pairs.element)
    rng = np.random.default_rng(6)
    way, h = rng.uniform(-1, 1, e.shape) * blocks_of(model.unit, effect.dofs), 1e-7
    Q, K = effect.force_and_tangent(e)
    np.testing.assert_array_equal(Q, effect.force(e))
    change = (effect.force(e + h * way) - effect.force(e - h * way)) / (2 * h)
    found = np.einsum("mij,mj->mi", K, way.reshape(len(K), -1)).reshape(change.shape)
    np.testing.assert_allclose(found, change, rtol=0, atol=2e-6 * np.abs(change).max())
    assert effect.potential(e) is None and not model.conservative


def test_forces_on_both_rods_balance():
    """Surface points that touch are one: no resultant force, and no moment but the gap's."""
    model, effect, q = shaken("two rods")
    effect.law.d = np.full_like(effect.law.radius, 1e-3)
    effect.commit(q)  # anchors here: nothing has slipped
    e = blocks_of(q, effect.dofs)
    touch = effect._touch(e)
    assert np.abs(touch.friction.T).max() > 0.0
    tangential = effect._summed(np.einsum("pn,pc->pnc", touch.W, touch.friction.T), np.arange(len(touch.W)))
    scale = np.abs(touch.friction.T).sum()
    np.testing.assert_allclose(tangential[:, ::3].sum(axis=(0, 1)), 0.0, atol=1e-12 * scale)
    base = effect.base
    first = 3 * len(model.rods[0].element.node_xi)
    moment = np.cross(e, tangential).sum(axis=(0, 1))
    moment += np.cross(base, tangential[:, :first:3].sum(axis=(0, 1)))
    gap = touch.g.ravel()[effect.pairs.point]
    expected = np.cross(gap[:, None] * touch.found.n, touch.friction.T).sum(axis=0)
    np.testing.assert_allclose(moment, expected, atol=1e-10 * scale)


def test_a_rigid_motion_does_not_slip():
    """Both rods turned and moved together after the last equilibrium: what is between them is the gap."""
    model, effect, q = shaken("two rods")
    effect.commit(q)
    turn, shift = exp(np.array([0.7, -0.4, 1.1])), np.array([0.3, 0.1, -0.2])
    moved = np.empty_like(q)
    for rod in model.rods:
        here = slice(rod.first_dof, rod.first_dof + rod.size)
        nodes, base = q[here].reshape(-1, 3).copy(), rod.rod.base.position
        nodes[::3] += base
        nodes = nodes @ turn.T
        nodes[::3] += shift - base
        moved[here] = nodes.ravel()
    effect.search(moved)
    touch = effect._touch(blocks_of(moved, effect.dofs))
    n, u = touch.found.n, touch.u
    assert len(u) > 3
    slip = u - np.sum(n * u, axis=1)[:, None] * n
    np.testing.assert_allclose(slip[touch.found.free], 0.0, atol=1e-10 * L)


def test_a_coil_rubs_on_itself():
    """Pressed onto the turn below and turned a little: forces of a rod on itself leave the reaction alone."""
    rod, axis = coil(9)
    P = 1e-3
    contact = [{"with": {"shape": "rod", "name": "rod"}, "friction": MU}]
    scene = {"rod": [rod], "force": [{"value": (-P * axis).tolist()}], "contact": contact}
    solution = ancf.solve(ancf.scene_from_dict(scene | {"solver": {"friction_steps": 4}}))
    assert solution.status == "converged", solution.reason
    (entry,) = solution.as_dict()["contacts"]
    friction = entry["friction"]
    assert entry["points"] > 0 and entry["penetration"] <= 1e-4 * RADIUS
    assert entry["force"] == friction["force"] == [0.0, 0.0, 0.0]
    assert friction["sticking"] + friction["slipping"] > 0 and friction["dissipated"] >= 0.0
    np.testing.assert_allclose(solution.reaction()[0], P * axis, atol=1e-9 * P)


def test_rods_need_no_sections():
    """Of cables friction acts on the axis."""
    rods = [BARE | {"length": L, "elements": 4, "element": "cable", "name": name} for name in ("one", "two")]
    rods[1]["base"] = {"position": [0.0, 0.0, -2 * RADIUS]}
    contact = [{"rod": "one", "with": {"shape": "rod", "name": "two"}, "friction": MU}]
    effect = effect_of(Model(ancf.scene_from_dict({"rod": rods, "contact": contact})))
    np.testing.assert_array_equal(anchors_of(effect).W_A, effect._N)
