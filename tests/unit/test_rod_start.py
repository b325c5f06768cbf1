"""The Kirchhoff chain that starts Newton, against the elastica and against itself turned round."""

import math

import numpy as np
import pytest

import ancf.rod_start
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.predictor import load_start
from ancf.rod_start import Chain, NodalLoads, nodal_loads
from ancf.scene import Force, Frame, Gravity, LineLoad, Moment, Rod, Scene, Support
from ancf.sections import Circle
from reference.elastica import elastica_tip_force

L, EI, GJ = 2.0, 3.0, 2.0


def chain(count=40, held=0):
    h = np.full(count, L / count)
    R = np.tile(np.eye(3), (count + 1, 1, 1))
    return Chain(h, np.tile(np.diag([GJ, EI, EI]), (count, 1, 1)), np.zeros(3), R, held, EI / L)


def loads(count=40, **kinds):
    """Loads on the last node, or on the node given as (node, value)."""
    arrays = {k: np.zeros((count + 1, 3)) for k in ("force", "moment", "turning_force", "turning_moment")}
    for kind, value in kinds.items():
        arrays[kind][-1] = value
    return NodalLoads(**arrays, levers=[])


def tip(found, count=40):
    """Position of the last node, the first at the origin, of an inextensible chain."""
    assert found is not None
    R, _ = found
    theta = 0.5 * (R[:-1] + R[1:])[:, :, 0]
    return np.sum(theta / np.linalg.norm(theta, axis=1)[:, None], axis=0) * L / count


def test_a_moment_takes_one_step():
    """Pure bending: kappa = M/EI in every interval, however far the tip turns."""
    steps = []
    original = Chain._step
    found = None
    try:
        Chain._step = lambda self, *a: (steps.append(1), original(self, *a))[1]
        found = chain().equilibrium(loads(moment=[0.0, 0.0, 1.5 * math.pi * EI / L]), chain().R_0)
    finally:
        Chain._step = original
    assert len(steps) == 1
    assert found is not None
    np.testing.assert_allclose(found[0][-1], [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-9)


@pytest.mark.parametrize("load", [1.0, 10.0, 50.0])
def test_a_tip_force_gives_the_elastica(load):
    """reference.elastica; the chain is of second order, 40 intervals are good to 1e-3."""
    P = load * EI / L**2
    exact = elastica_tip_force(load)
    found = chain().equilibrium(loads(force=[0.0, P, 0.0]), chain().R_0)
    position = tip(found)
    np.testing.assert_allclose(position / L, [1.0 - exact.u, exact.w, 0.0], atol=2e-3)


@pytest.mark.parametrize("k", [1.5, 4.0])
def test_a_column_pushed_aside_ever_so_little_buckles(k):
    """Downhill steps leave the straight shape, nearly an equilibrium, for the buckled one."""
    P = k * math.pi**2 / 4 * EI / L**2
    found = chain().equilibrium(loads(force=[-P, 1e-6 * P, 0.0]), chain().R_0)
    assert tip(found)[1] > 0.1 * L
    straight = chain().equilibrium(loads(force=[-P, 0.0, 0.0]), chain().R_0)
    assert abs(tip(straight)[1]) == 0.0


def test_follower_loads_turn_with_the_section():
    """A follower moment about z is the dead one; a follower force ends perpendicular to the tip."""
    moment = [0.0, 0.0, 2.0 * EI / L]
    dead = chain().equilibrium(loads(moment=moment), chain().R_0)
    turning = chain().equilibrium(loads(turning_moment=moment), chain().R_0)
    assert dead is not None
    assert turning is not None
    np.testing.assert_allclose(turning[0], dead[0], atol=1e-5)
    P = 4.0 * EI / L**2
    found = chain().equilibrium(loads(turning_force=[0.0, P, 0.0]), chain().R_0)
    assert found is not None
    R, axial = found
    # Moment at the clamp = arm x force, from the curvature of the first interval.
    arm, force = tip(found), P * R[-1][:, 1]
    angle = math.atan2(R[1][1, 0], R[1][0, 0])
    assert EI * angle / (L / 40) == pytest.approx(np.cross(arm, force)[2], rel=0.02)
    assert abs(axial[-1]) < 0.02 * P


@pytest.mark.parametrize("at", [0.0, 1.0])
def test_every_load_of_a_scene_is_taken(at):
    """Small loads of every kind: the start agrees with the elements' linear solution to a few percent."""
    rod = Rod("rod", 1.0, 8, Circle(0.02), SaintVenantKirchhoff(1e6, 0.3, density=1000.0),
              supports=(Support(at),), base=Frame(np.zeros(3), np.eye(3)))  # fmt: skip
    far, B = 1.0 - at, 1e6 * math.pi * 0.02**4 / 4
    kinds = [
        {"forces": (Force("rod", far, np.array([0.0, 0.02, 0.01]) * B),)},
        {"forces": (Force("rod", far, np.array([0.02, 0.0, 0.0]) * B, offset=np.array([0.01, 0.01])),)},
        {"forces": (Force("rod", far, np.array([0.0, 0.02, 0.0]) * B, direction="follower"),)},
        {"forces": (Force("rod", far, np.array([0.02, 0.0, 0.0]) * B, np.array([0.01, 0.01]), "follower"),)},
        {"line_loads": (LineLoad("rod", np.array([0.0, 0.03, 0.0]) * B),)},
        {"line_loads": (LineLoad("rod", np.array([0.0, 0.0, 0.03]) * B, direction="follower"),)},
        {"gravity": Gravity(np.array([0.0, 0.0, -1e-3]))},
        {"forces": (Force("rod", far, np.array([0.0, 0.02, 0.0]) * B),),
         "moments": (Moment("rod", 0.5, np.array([0.01, 0.0, 0.01]) * B),)},
    ]  # fmt: skip
    for kind in kinds:
        model = Model(Scene((rod,), **kind))
        forces, flat = model.residual_and_tangent(model.q0, 0.0)
        linear = model.rods[0].nodal(model.system.solve(model.system.factorise(flat), forces.Q_ext))[:, 0]
        start = load_start(model)
        assert start is not None
        found = model.rods[0].nodal(start - model.q0)[:, 0]
        size = np.max(np.linalg.norm(linear, axis=1))
        assert size > 1e-5
        assert np.max(np.linalg.norm(found - linear, axis=1)) < 0.05 * size, kind


def test_the_middle_may_be_held():
    """Two arms of half the length, one the mirror image of the other in x under a load across."""
    count = 20
    R = np.tile(np.eye(3), (count + 1, 1, 1))
    C = np.tile(np.diag([GJ, EI, EI]), (count, 1, 1))
    middle = Chain(np.full(count, L / count), C, np.zeros(3), R, count // 2, EI / L)
    force = np.zeros((count + 1, 3))
    force[[0, -1], 1] = 3.0 * EI / L**2
    zero = np.zeros_like(force)
    found = middle.equilibrium(NodalLoads(force, zero, zero, zero, []), R)
    assert found is not None
    mirror = np.diag([1.0, -1.0, 1.0])
    np.testing.assert_allclose(found[0], mirror @ found[0][::-1] @ mirror, atol=1e-6)
    assert found[0][-1][1, 0] > 0.1


def test_no_equilibrium_is_none(monkeypatch):
    monkeypatch.setattr(ancf.rod_start, "MOST_DOWNHILL", 1)
    assert chain().equilibrium(loads(force=[0.0, 50.0 * EI / L**2, 0.0]), chain().R_0) is None


def test_no_loads_have_no_start():
    rod = Rod("rod", 1.0, 4, Circle(0.02), SaintVenantKirchhoff(1e6, 0.3))
    model = Model(Scene((rod,), forces=(Force("rod", 1.0, np.zeros(3)),)))
    assert not nodal_loads(model.scene, model.rods[0]).forces
    assert load_start(model) is None


def counted(monkeypatch, load, count=40):
    """Equilibrium and the linear solves that it took."""
    solves = []
    original = Chain._step
    monkeypatch.setattr(Chain, "_step", lambda self, *a: (solves.append(1), original(self, *a))[1])
    found = chain(count).equilibrium(load, chain(count).R_0)
    assert found is not None
    return found, len(solves)


def test_bending_with_torsion_and_a_force_takes_few_solves(monkeypatch):
    """Newton with the exact turn of the interval moments; without it a dozen and more."""
    load = loads(moment=np.array([1.0, 3.0, 2.0]) * EI / L, force=np.array([0.0, 1.0, 0.3]) * EI / L**2)
    _, solves = counted(monkeypatch, load)
    assert solves <= 7


def test_no_step_goes_to_a_saddle(monkeypatch):
    """Upright under 128 times Greenhill's weight, pushed aside by 0.1 %: Newton alone stands it up again."""
    count = 48
    force = np.zeros((count + 1, 3))
    force[:, 0] = -1000.0 * EI / L**2 / count
    force[:, 1] = -1e-3 * force[:, 0]
    force[[0, -1]] /= 2.0
    zero = np.zeros_like(force)
    found, _ = counted(monkeypatch, NodalLoads(force, zero, zero, zero, []), count)
    assert found[0][-1][0, 0] < -0.9  # the tip points down
