"""Friction of contact with obstacles: closed forms, exact tangent, dissipation, objectivity, refusals."""

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

import ancf
from ancf.effects.contact import ObstacleContact
from ancf.effects.frictional_contact import FrictionalContact
from ancf.friction_law import derivative, traction
from ancf.model import Model
from ancf.rotation import exp
from reference.contact import propped_force
from reference.friction import belt_rate, pulled_end, rubbing_tip
from tests.effect_checks import blocks, check_derivatives

L, RADIUS, YOUNG = 1.0, 0.0025, 1e6
EI, EA = YOUNG * np.pi * RADIUS**4 / 4, YOUNG * np.pi * RADIUS**2
MU = 0.3

BARE = {
    "length": L, "elements": 8, "section": {"shape": "circle", "radius": RADIUS},
    "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3, "density": 1000.0},
}  # fmt: skip


def scene(rod=None, steps=None, **tables):
    if steps is not None:
        tables["solver"] = {"friction_steps": steps} | tables.get("solver", {})
    return ancf.scene_from_dict({"rod": [BARE | (rod or {})], **tables})


def plane(gap, radius=RADIUS, friction=MU):
    body = {"shape": "plane", "point": [0, 0, -gap - radius], "normal": [0, 0, 1]}
    return [{"with": body, "friction": friction}]


def rubbing(solution):
    """The one contact of a solution, which must have converged."""
    assert solution.status == "converged", solution.reason
    (contact,) = solution.as_dict()["contacts"]
    assert contact["penetration"] <= 1e-4 * RADIUS  # the issue
    assert solution.balance().relative <= 1e-9
    assert contact["friction"]["dissipated"] >= 0.0
    assert solution.stable is None  # no potential
    return contact


def test_a_tip_slides_along_a_plane():
    """Friction mu N against a force along the plane (reference/friction.py); N as without it."""
    P, across, clearance = 0.02 * EI / L**2, 0.01 * EI / L**2, 1e-3 * L
    solution = ancf.solve(scene(force=[{"value": [0, across, -P]}], contact=plane(clearance)))
    contact = rubbing(solution)
    N = propped_force(L, EI, P, L, clearance)
    friction = contact["friction"]
    assert contact["force"][2] == pytest.approx(N, rel=1e-3)
    assert np.hypot(*friction["force"][:2]) == pytest.approx(MU * contact["force"][2], rel=1e-12)
    assert friction["force"][1] == pytest.approx(-MU * N, rel=1e-3)
    assert (friction["sticking"], friction["slipping"], friction["coefficient"]) == (0, 1, MU)
    # The radius of the section, over which friction twists it, is 0.25 % of the length.
    exact = rubbing_tip(L, EI, across, MU, N)
    assert solution.tip().position[1] == pytest.approx(exact, rel=2e-3)
    # Friction works on the way along the plane while N grows from 0, in proportion after the touch.
    assert 0.3 * MU * N * exact < friction["dissipated"] < MU * N * exact


def test_a_tip_sticks_on_a_plane():
    """Under mu N it stays within a step of where it touched."""
    P, clearance = 0.02 * EI / L**2, 1e-4 * L
    across = 0.1 * P
    solution = ancf.solve(scene(force=[{"value": [0, across, -P]}], contact=plane(clearance)))
    contact = rubbing(solution)
    assert (contact["friction"]["sticking"], contact["friction"]["slipping"]) == (1, 0)
    assert contact["friction"]["force"][1] == pytest.approx(-across, rel=0.05)
    touched = clearance / (P * L**3 / (3 * EI))  # load factor
    free = across * L**3 / (3 * EI)
    assert abs(solution.tip().position[1] / free - touched) < 1 / 20


def test_a_rod_is_pulled_over_a_plane():
    """Way of the end F^2/(2 E A mu w); slip reaches F/(mu w) (reference/friction.py)."""
    w = 2e-3 * EA / L
    F = 0.5 * MU * w * L
    rod = {"elements": 40, "length": L}
    tables = {"line_load": [{"value": [0, 0, -w]}], "force": [{"value": [F, 0, 0]}], "contact": plane(0.0)}
    solution = ancf.solve(scene(rod, **tables))
    contact = rubbing(solution)
    slipped, way = pulled_end(F, MU * w, EA)
    # Half an element's share of the weight at the end, F^2 spread over 80 points: 1/40 of the slipped half.
    assert solution.tip().position[0] - L == pytest.approx(way, rel=0.03)
    friction = contact["friction"]
    assert friction["force"][0] == pytest.approx(-F, rel=5e-3)
    assert friction["slipping"] / 80 == pytest.approx(slipped / L, abs=0.05)
    assert friction["slipping"] + friction["sticking"] == 80  # the clamp carries nothing
    # Load and weight grow together: int mu w l du dl = F^3/(12 E A mu w), and by steps of 1/20 a 20th more.
    assert friction["dissipated"] == pytest.approx(1.05 * F**3 / (12 * EA * MU * w), rel=0.02)


INCLINED = {
    "length": 0.2, "elements": 3, "supports": [], "section": {"shape": "circle", "radius": 0.02},
}  # fmt: skip


def inclined(slope, mu=MU, along=0.0, **tables):
    """A free rod on a plane inclined by atan(slope), seen in the axes of the plane; `along` turns the rod."""
    a = np.arctan(slope)
    g = 9.81 * np.array([np.sin(a) * np.cos(along), np.sin(a) * np.sin(along), -np.cos(a)])
    return scene(INCLINED, gravity={"acceleration": g.tolist()}, contact=plane(0.0, 0.02, mu), **tables)


@pytest.mark.parametrize("slope", [0.1, 0.98 * MU])
def test_a_rod_lies_on_an_inclined_plane(slope):
    """It stays where tan(alpha) < mu; normal force and friction carry its weight."""
    solution = ancf.solve(inclined(slope))
    contact = rubbing(solution)
    weight = 1000 * np.pi * 0.02**2 * 0.2 * 9.81
    a = np.arctan(slope)
    np.testing.assert_allclose(
        contact["force"], weight * np.array([-np.sin(a), 0, np.cos(a)]), atol=1e-9 * weight
    )
    assert contact["friction"]["sticking"] > 0
    # What it gives way by is elastic: 1e-3 of its radius.
    assert np.linalg.norm(solution.tip().position - [0.2, 0, 0]) < 1e-3 * 0.02


@pytest.mark.parametrize("slope", [1.02 * MU, 1.0])
def test_a_rod_slides_off_a_steeper_plane(slope):
    solution = ancf.solve(inclined(slope))
    assert solution.status == "not_converged" and solution.load_factor == 0.0
    assert "nothing but friction holds rod 'rod', and it slides" in solution.reason
    assert solution.message is not None and "`friction`" in solution.message.advice


def belt(steps=10, elements=12, **solver):
    """A rod whose own shape lies on a cylinder, pulled over it: at its base by a joint, at its end by T."""
    a, length, T = 0.2, 0.4, 1e-3 * EA
    rho = a + RADIUS
    end = np.array([np.cos(length / rho), 0, -np.sin(length / rho)])
    body = {"shape": "cylinder", "point": [0, 0, -rho], "axis": [0, 1, 0], "radius": a - 1e-6}
    joint = {"kind": "rigid", "a": {"at": 0.0}, "b": "ground", "displacement": [-0.004, 0, 0]}
    return scene(
        {"length": length, "elements": elements, "curvature": [0, 1 / rho, 0]},
        force=[{"value": (T * end).tolist()}],
        contact=[{"with": body, "friction": MU}],
        joint=[joint],
        solver={"friction_steps": steps} | solver,
    ), belt_rate(MU, a, rho)


def test_a_rod_slips_round_a_cylinder_as_a_belt():
    """T grows as exp(c s) (reference/friction.py); Euler's rope is 1.4 % off, the share of the lever."""
    tables, exact = belt()
    solution = ancf.solve(tables)
    contact = rubbing(solution)
    assert contact["friction"]["sticking"] == 0
    forces = solution.section_forces()
    T = np.einsum("ia,ia->i", forces.force, solution.section_axes()[:, :, 0])
    inside = (forces.at > 0.2) & (forces.at < 0.8)  # away from the ends
    rate = -np.polyfit(forces.x[inside], np.log(T[inside]), 1)[0]
    # 2.5e-3 with 12 elements, 1.3e-3 with 24: T is constant between points.
    assert rate == pytest.approx(exact, rel=4e-3)
    assert abs(rate / (MU / 0.2025) - 1.0) > 0.008


def test_more_steps_lead_to_coulombs_law():
    """A tip that sticks once it has touched: off by no more than what it moves freely in a step."""
    P, clearance = 0.02 * EI / L**2, 1e-3 * L
    ways, counts, free = [], np.array([4, 8, 16, 32]), 0.1 * P * L**3 / (3 * EI)
    for steps in (*counts, 256):
        tables = {"force": [{"value": [0, 0.1 * P, -P]}], "contact": plane(clearance)}
        solution = ancf.solve(scene({"elements": 4}, int(steps), solver={"max_steps": 1000}, **tables))
        rubbing(solution)
        ways.append(solution.tip().position[1])
    errors = np.abs(np.array(ways[:-1]) - ways[-1])
    assert np.all(errors < 1.05 * free / counts) and errors[-1] < 0.3 * errors[0]


def test_no_friction_is_the_contact_without():
    """`friction = 0` builds the same effect and gives the same bits."""
    tables = {"force": [{"value": [0, 0.01 * EI, -0.02 * EI]}]}
    without = plane(1e-3)
    del without[0]["friction"]
    zero = ancf.solve(scene(contact=plane(1e-3, friction=0.0), **tables))
    bare = ancf.solve(scene(contact=without, **tables))
    np.testing.assert_array_equal(zero.q, bare.q)
    (effect,) = zero.model.settling
    assert type(effect) is ObstacleContact and not zero.model.path_dependent
    assert "friction" not in zero.as_dict()["contacts"][0]


@pytest.mark.parametrize("shape", ["plane", "cylinder"])
def test_everything_turned_is_the_solution_turned(shape):
    """Rod, force and obstacle turned and moved together: the same friction, the same shape."""
    turn, shift = exp(np.array([0.4, -0.9, 0.3])), np.array([0.3, -0.2, 0.7])

    def solved(R, t):
        if shape == "plane":
            body = {
                "shape": "plane",
                "point": (R @ [0, 0, -1e-3 - RADIUS] + t).tolist(),
                "normal": R[:, 2].tolist(),
            }
        else:
            middle = R @ [0.9 * L, 0, -0.1 - 1e-3 - RADIUS] + t
            body = {"shape": "cylinder", "point": middle.tolist(), "axis": R[:, 1].tolist(), "radius": 0.1}
        base = {"position": t.tolist(), "x_axis": R[:, 0].tolist(), "y_axis": R[:, 1].tolist()}
        force = (R @ [0, 0.01 * EI, -0.02 * EI]).tolist()
        contact = [{"with": body, "friction": MU}]
        return ancf.solve(scene({"base": base}, 8, force=[{"value": force}], contact=contact))

    plain, turned = solved(np.eye(3), np.zeros(3)), solved(turn, shift)
    friction = [np.array(rubbing(s)["friction"]["force"]) for s in (plain, turned)]
    assert np.linalg.norm(friction[0]) > 1e-3 * EI
    np.testing.assert_allclose(
        friction[1], turn @ friction[0], atol=1e-6 * float(np.linalg.norm(friction[0]))
    )
    place = plain.tip().position
    np.testing.assert_allclose(turned.tip().position, turn @ place + shift, atol=1e-8 * L)


OBSTACLES = {
    "plane": {"shape": "plane", "point": [0, 0, -0.003], "normal": [0.2, 0.3, 1.0]},
    "sphere": {"shape": "sphere", "centre": [0.5, 0.01, -0.1], "radius": 0.09},
    "cylinder": {"shape": "cylinder", "point": [0.5, 0.3, -0.1], "axis": [0.4, 1.0, 0.1], "radius": 0.09},
}


def rubbed(name, element, stickiness):
    """A model whose points all touch, with multipliers, at the beginning of a step."""
    model = Model(
        scene({"element": element, "elements": 4}, contact=[{"with": OBSTACLES[name], "friction": MU}])
    )
    (effect,) = model.effects
    assert isinstance(effect, FrictionalContact)
    effect.law.d = np.full_like(effect.law.radius, 0.05)
    effect.law.a = np.linspace(0.05, 0.1, effect.law.k.size).reshape(effect.law.k.shape)
    effect.commit(model.q0)
    rng = np.random.default_rng(8)
    effect.multiplier = 0.02 * effect.law.k.max() * rng.uniform(-1, 1, effect.anchors.x.shape)
    effect.anchors.near[:] = True
    effect.stickiness = stickiness
    return model, effect


@pytest.mark.parametrize("element", ["3333", "3243", "3343", "cable"])
@pytest.mark.parametrize("name", OBSTACLES)
@pytest.mark.parametrize("stickiness", [0.1, 1.0])
def test_the_tangent_is_exact(name, element, stickiness):
    """Central differences; unsymmetric where points slip."""
    model, effect = rubbed(name, element, stickiness)
    check_derivatives(model, strain=0.02, step=1e-7)
    e = blocks(model, effect) + 0.02 * np.random.default_rng(3).uniform(-1, 1, (4, 1, 1)) * blocks(
        model, effect, model.unit
    )
    touch = effect._touch(e)
    assert touch.friction.slips.any()
    K = effect.force_and_tangent(e)[1]
    assert np.abs(K - np.swapaxes(K, 1, 2)).max() > 1e-3 * np.abs(K).max()
    assert effect.potential(e) is None and not model.conservative


def test_friction_acts_on_the_surface():
    """On the axis it has the moment (-R n) x T about it."""
    model, effect = rubbed("plane", "3333", 1.0)
    q = model.q0
    e = blocks(model, effect)
    Q = effect.force(e) - ObstacleContact.force(effect, e)
    touch = effect._touch(e)
    T, arm = touch.friction.T, -RADIUS * touch.n
    assert np.abs(T).max() > 0.0
    place = effect.places(e)
    moment = np.cross(place + arm, T).sum(axis=(0, 1))
    found = np.cross(e, Q).sum(axis=(0, 1))
    np.testing.assert_allclose(found, moment, atol=1e-12 * np.abs(T).max())
    np.testing.assert_allclose(Q[:, ::3].sum(axis=(0, 1)), T.sum(axis=(0, 1)), atol=1e-12 * np.abs(T).max())
    assert q is model.q0


vectors = st.tuples(*[st.floats(-3, 3)] * 3).map(np.array)


@settings(deadline=None)
@given(vectors, vectors, vectors, st.floats(0.0, 2.0), st.floats(0.1, 5.0))
@example(np.zeros(3), np.zeros(3), np.array([0, 0, 1.0]), 0.0, 1.0)
def test_slip_dissipates(u, start, direction, limit, k):
    """Rounds of augmentation at a given slip end at a force against it, at the limit or without slip."""
    n = direction / max(np.linalg.norm(direction), 1e-9)
    if np.linalg.norm(direction) < 1e-9:
        n = np.array([0, 0, 1.0])
    T = start
    for _ in range(400):
        found = traction(np.array(limit), np.array(k), n, u, T)
        T = found.T
        assert abs(n @ T) <= 1e-12 * (1 + np.linalg.norm(T))
        assert np.linalg.norm(T) <= limit * (1 + 1e-12)
    slip = u - n * (n @ u)
    if np.linalg.norm(slip) > 0.1:  # from the opposite direction it turns round slowly
        assert T @ u == pytest.approx(-limit * np.linalg.norm(slip), rel=1e-2, abs=1e-9)
    assert T @ u <= 1e-9


@settings(deadline=None)
@given(vectors, vectors, st.floats(0.1, 2.0))
def test_the_return_mapping_has_an_exact_derivative(u, multiplier, mu):
    """By the slip at a fixed place; by the place through the normal of a ball and the normal force."""
    r, h, k, slope = np.array([0.3, -0.4, 1.0]), 1e-6, np.array(1.7), np.array(2.1)

    def of(u, r):
        size = np.linalg.norm(r)
        return traction(np.array(mu * (3.0 - slope * (size - 1.0))), k, r / size, u, multiplier)

    found = of(u, r)
    if abs(found.size - found.limit) < 1e-3 or found.size < 1e-2:
        return  # the corner, and a direction that is not defined
    size = np.linalg.norm(r)
    n = r / size
    by_u, by_n, by_p = derivative(found, mu, k, n)
    by_r = by_n @ (np.eye(3) - np.outer(n, n)) / size - slope * np.outer(by_p, n)
    steps = h * np.eye(3)
    change = [[(of(u + d, r).T - of(u - d, r).T) / (2 * h) for d in steps],
              [(of(u, r + d).T - of(u, r - d).T) / (2 * h) for d in steps]]  # fmt: skip
    np.testing.assert_allclose(by_u, np.array(change[0]).T, atol=1e-5)
    np.testing.assert_allclose(by_r, np.array(change[1]).T, atol=1e-5)


def test_a_failed_step_leaves_no_trace():
    """`restart` forgets what augmentation did since the last accepted equilibrium."""
    model, effect = rubbed("plane", "3333", 1.0)
    effect.commit(model.q0)
    before = effect.force(blocks(model, effect))
    moved = model.q0 + 1e-3 * np.random.default_rng(1).uniform(-1, 1, model.n) * model.unit
    assert effect.augment(moved)
    assert np.abs(effect.force(blocks(model, effect)) - before).max() > 1e-3 * np.abs(before).max()
    effect.restart()
    np.testing.assert_array_equal(effect.force(blocks(model, effect)), before)


BAD = {
    "negative": ({"contact": plane(0.1, friction=-0.3)}, ("friction", "must be >= 0")),
    "no number": ({"contact": plane(0.1, friction=float("nan"))}, ("friction",)),
    "infinite": ({"contact": plane(0.1, friction=float("inf"))}, ("friction",)),
    "arc length": ({"contact": plane(0.1), "solver": {"method": "arclength"}}, ("solver.method",)),
    "stability": ({"contact": plane(0.1), "stability": {}}, ("stability",)),
    "no steps": ({"contact": plane(0.1), "solver": {"friction_steps": 0}}, ("friction_steps",)),
}


@pytest.mark.parametrize("name", BAD)
def test_what_friction_does_not_serve_is_refused(name):
    tables, hints = BAD[name]
    with pytest.raises(ancf.SceneError) as refused:
        scene(**tables)
    for hint in hints:
        assert hint in str(refused.value)


def test_accuracy_and_sensitivities_are_refused():
    bare = {k: v for k, v in BARE.items() if k != "elements"}
    with pytest.raises(ancf.SceneError, match="not in this version"):
        ancf.scene_from_dict({"rod": [bare], "solver": {"accuracy": 1e-3}, "contact": plane(0.1)})
    tables = {"force": [{"value": [0, 0, -0.02 * EI]}], "contact": plane(1e-3)}
    with pytest.raises(ancf.InputError, match="touches"):
        ancf.solve(scene(steps=2, **tables)).sensitivity("force")


def test_a_free_rod_needs_friction():
    with pytest.raises(ancf.SceneError, match="no support"):
        scene(INCLINED, contact=plane(0.0, 0.02, 0.0))


def test_a_start_is_not_taken():
    """The way from the reference counts, whatever the start."""
    tables = {"force": [{"value": [0, 0.01 * EI, -0.02 * EI]}], "contact": plane(1e-3)}
    first = ancf.solve(scene(steps=4, **tables))
    again = ancf.solve(scene(steps=4, **tables), start=first.q)
    np.testing.assert_array_equal(first.q, again.q)
