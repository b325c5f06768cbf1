"""Contact of rods with rods and with themselves: crossing cantilevers, derivatives, balance, refusals."""

import numpy as np
import pytest

import ancf
from ancf.coupled_system import CoupledSystem
from ancf.effects import blocks_of
from ancf.effects.rod_contact import RodContact
from ancf.model import Model
from reference.contact import crossing_force

L, RADIUS, YOUNG = 1.0, 0.005, 1e6
EI = YOUNG * np.pi * RADIUS**4 / 4
ROUND = {"section": {"shape": "circle", "radius": RADIUS}}
BARE = ROUND | {"material": {"young_modulus": YOUNG, "poisson_ratio": 0.3}}


def crossed(force, elements=10, length=0.8, gap=0.0, beyond=0.05, angle=90.0, **tables):
    """A cantilever along x over another one in the plane z = -2 R - gap; the ends cross."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    end = np.array([L - beyond, 0.0, -2 * RADIUS - gap])
    base = end - (length - beyond) * np.array([c, s, 0.0])
    rods = [
        BARE | {"name": "upper", "length": L, "elements": elements},
        BARE
        | {
            "name": "lower",
            "length": length,
            "elements": elements,
            "base": {"position": base.tolist(), "x_axis": [c, s, 0.0], "y_axis": [-s, c, 0.0]},
        },
    ]
    contact = [{"rod": "upper", "with": {"shape": "rod", "name": "lower"}}]
    return ancf.scene_from_dict({"rod": rods, "force": [{"value": force}], "contact": contact, **tables})


def pairs_of(model):
    (effect,) = model.settling
    assert isinstance(effect, RodContact)
    return effect


@pytest.mark.parametrize("angle", [90.0, 60.0])
def test_crossing_cantilevers_share_the_load(angle):
    """R = P k_2/(k_1 + k_2) between two ends (reference/contact.py); ends cross 0.1 mm before them."""
    P = 0.02 * EI / L**2
    solution = ancf.solve(crossed([0, 0, -P], beyond=1e-4, angle=angle))
    assert solution.status == "converged" and solution.stable
    (contact,) = solution.as_dict()["contacts"]
    assert contact["force"][2] == pytest.approx(crossing_force(P, L, EI, 0.8, EI), rel=1e-3)
    assert contact["penetration"] <= 1e-4 * RADIUS
    assert (contact["rod"], contact["with"], contact["points"]) == ("upper", "lower", 1)
    upper, lower = solution.reaction("upper"), solution.reaction("lower")
    # What one rod takes the other gives.
    atol = (1e-10 + solution.residual_floor) * EI / L**2
    np.testing.assert_allclose(lower[0], contact["force"], atol=10 * atol)
    np.testing.assert_allclose(upper[0] + lower[0] + [0, 0, -P], 0.0, atol=10 * atol)


def test_the_lower_rod_may_as_well_look_at_the_upper():
    """Who looks at whom does not matter where they touch in one point, but for the normal between points."""
    P = 0.02 * EI / L**2
    one = crossed([0, 0, -P])
    other = ancf.scene_from_dict(
        {
            "rod": [
                BARE | {"name": "upper", "length": L, "elements": 10},
                BARE
                | {
                    "name": "lower",
                    "length": 0.8,
                    "elements": 10,
                    "base": {
                        "position": [0.95, -0.75, -2 * RADIUS],
                        "x_axis": [0, 1, 0],
                        "y_axis": [-1, 0, 0],
                    },
                },
            ],
            "force": [{"value": [0, 0, -P]}],
            "contact": [{"rod": "lower", "with": {"shape": "rod", "name": "upper"}}],
        }
    )
    first, second = (ancf.solve(s) for s in (one, other))
    forces = [s.as_dict()["contacts"][0]["force"][2] for s in (first, second)]
    assert forces[1] == pytest.approx(-forces[0], rel=1e-3)
    np.testing.assert_allclose(first.tip("upper").position, second.tip("upper").position, atol=1.5e-4 * L)


def coil(elements=15):
    """A helix of one and a half turns, 0.1 m round its axis, rising by 4.8 radii a turn, and its axis."""
    a, b = 0.1, 4.8 * RADIUS / (2 * np.pi)
    w = a * a + b * b
    curvature = [b / w, 0.0, a / w]
    rod = BARE | {"length": 3 * np.pi * np.sqrt(w), "elements": elements, "curvature": curvature}
    return rod, np.array([b, 0.0, a]) / np.sqrt(w)


def test_a_coil_is_pressed_onto_itself():
    """The end comes to lie on the turn below, two radii away; the reaction is that of the load alone."""
    rod, axis = coil()
    P = 1e-3
    push = {"force": [{"value": (-P * axis).tolist()}]}
    contact = [{"with": {"shape": "rod", "name": "rod"}}]
    free = ancf.solve(ancf.scene_from_dict({"rod": [rod], **push}))
    closed = ancf.solve(ancf.scene_from_dict({"rod": [rod], **push, "contact": contact}))
    assert closed.status == "converged", closed.reason
    at = np.linspace(0.0, 1.0, 601)

    def nearest(solution):
        r = solution.displaced(None, at, 0.0, 0.0)
        distance = np.linalg.norm(r[:, None] - r[None], axis=2)
        distance[np.abs(at[:, None] - at[None]) < 0.3] = np.inf
        return distance.min()

    assert nearest(free) < RADIUS  # without contact it goes through
    assert nearest(closed) == pytest.approx(2 * RADIUS, rel=0.01)  # 601 points, 1.6 mm apart
    (entry,) = closed.as_dict()["contacts"]
    assert entry["penetration"] <= 1e-4 * RADIUS and entry["force"] == [0.0, 0.0, 0.0]
    assert entry["zone"] == pytest.approx([1 / 3, 1.0], abs=0.02)  # a turn lies between
    np.testing.assert_allclose(closed.reaction()[0], P * axis, atol=1e-9 * P)


@pytest.mark.parametrize("kind", ["two rods", "itself"])
def test_force_and_tangent_are_derivatives(kind):
    """Q = -dV/de and K = dQ/de at a random state, the closest point moving along."""
    if kind == "two rods":
        model = Model(crossed([0, 0, 0.0], elements=4, angle=70.0))
    else:
        contact = [{"with": {"shape": "rod", "name": "rod"}}]
        model = Model(ancf.scene_from_dict({"rod": [coil(8)[0]], "contact": contact}))
    effect = pairs_of(model)
    effect.law.d = np.full_like(effect.law.radius, 0.3)
    effect.law.a = np.linspace(0.0, 0.1, effect.law.k.size).reshape(effect.law.k.shape)
    rng = np.random.default_rng(5)
    q = model.q0 + 0.002 * rng.uniform(-1, 1, model.n) * model.unit
    effect.search(q)
    e, unit = blocks_of(q, effect.dofs), blocks_of(model.unit, effect.dofs)
    way, h = rng.uniform(-1, 1, e.shape) * unit, 1e-6
    Q, K = effect.force_and_tangent(e)
    assert len(K) > 3
    np.testing.assert_array_equal(Q, effect.force(e))
    change = (effect.force(e + h * way) - effect.force(e - h * way)) / (2 * h)
    found = np.einsum("mij,mj->mi", K, way.reshape(len(K), -1)).reshape(change.shape)
    np.testing.assert_allclose(found, change, rtol=0, atol=1e-6 * np.abs(change).max())
    np.testing.assert_allclose(K, np.swapaxes(K, 1, 2), rtol=0, atol=1e-12 * np.abs(K).max())
    slope = (effect.potential(e + h * way) - effect.potential(e - h * way)) / (2 * h)
    assert -np.sum(Q * way) == pytest.approx(slope, rel=1e-6)


def test_gaps_are_distances_of_the_axes():
    """Against a fine sampling of the other axis, at a random state."""
    scene = crossed([0, 0, 0.0], elements=4, angle=70.0, gap=0.01)
    model = Model(scene)
    effect = pairs_of(model)
    q = model.q0 + 0.02 * np.random.default_rng(7).uniform(-1, 1, model.n) * model.unit
    xi = np.linspace(-1.0, 1.0, 2001)
    upper, lower = model.rods
    axis = lower.element.shape(xi, float(lower.mesh.h[0]))[:, 0] @ lower.element_vectors(q)
    axis = axis.reshape(-1, 3) + lower.rod.base.position
    points = (effect.points.N @ upper.element_vectors(q)).reshape(-1, 3) + upper.rod.base.position
    exact = np.array([np.linalg.norm(axis - r, axis=1).min() for r in points]) - 2 * RADIUS
    near = exact < 0.05
    assert near.sum() > 10
    # Samples of the other axis are 0.1 mm apart: the distance is too large by s^2/(8 distance) at most.
    np.testing.assert_allclose(effect.gaps(q).ravel()[near], exact[near], atol=2e-6)


def test_blocks_change_between_runs():
    """Pairs are those near at the state that is looked at; the system takes them as they are."""
    model = Model(crossed([0, 0, 0.0], gap=100 * RADIUS))
    effect = pairs_of(model)
    assert isinstance(model.system, CoupledSystem)
    model.search(model.q0)
    assert len(effect.dofs) == 0 and effect.report(blocks_of(model.q0, effect.dofs))["gap"] is None
    down = model.q0.reshape(-1, 3).copy()
    down[: len(model.rods[0].q0.reshape(-1, 3)) : 3, 2] -= 100 * RADIUS
    model.search(down.ravel())
    assert len(effect.dofs) > 0
    _, flat = model.residual_and_tangent(down.ravel(), 0.0)
    model.system.factorise(flat)
    # A step that takes one rod through the other is too long.
    further = down.copy()
    further[: len(model.rods[0].q0.reshape(-1, 3)) : 3, 2] -= 8 * RADIUS
    assert model.room(down.ravel(), further.ravel()) < 1.0 < model.room(model.q0, down.ravel())


def test_batches_solve_row_by_row():
    P = 0.02 * EI / L**2
    base = crossed([0, 0, -P], elements=6)
    batch = ancf.solve_batch(base, forces=[[0, 0, -P], [0, 0, P]])
    assert batch.engine == "solve" and all(status == "converged" for status in batch.status)
    alone = ancf.solve(base)
    np.testing.assert_allclose(batch.poses[0, :, 0], alone.tip("upper").position, atol=1e-4 * RADIUS)
    assert batch.poses[1, 2, 0] == pytest.approx(P * L**3 / (3 * EI), rel=1e-3)  # lifted, nothing touches


def test_rods_in_each_other_are_refused():
    with pytest.raises(ancf.SceneError) as refused:
        Model(crossed([0, 0, 0.0], gap=-0.5 * RADIUS))
    for part in ("from the beginning", "'lower'", "contact[0]", "gap -0.002"):
        assert part in str(refused.value)


def test_the_other_rod_must_be_known():
    for body in (
        {"shape": "rod", "name": "leg"},
        {"shape": "rod"},
        {"shape": "rod", "name": "rod", "radius": 1},
    ):
        with pytest.raises(ancf.SceneError):
            ancf.scene_from_dict({"rod": [BARE | {"length": L, "elements": 4}], "contact": [{"with": body}]})
