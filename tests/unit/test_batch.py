"""`solve_batch`: every row is what `solve` finds for its scene, whatever the other rows are."""

import numpy as np
import pytest

import ancf
from ancf.batch_starts import STRIDE
from ancf.solution import Status

L, RADIUS, YOUNG = 0.4, 0.01, 1e6
EI = YOUNG * np.pi * RADIUS**4 / 4
MOMENT, FORCE = EI / L, EI / L**2


def scene(rod=None, **tables):
    data = {
        "name": "arm", "length": L, "elements": 6, "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3, "density": 1000.0},
    } | (rod or {})  # fmt: skip
    return ancf.scene_from_dict({"rod": [data], **tables})


def tip(solution):
    pose = solution.tip()
    return np.column_stack([pose.position, pose.r_x, pose.r_y, pose.r_z])


BASE = {"position": [1.0, 2.0, 3.0], "x_axis": [0.0, 0.0, 1.0], "y_axis": [1.0, 1.0, 0.0]}
NEO_HOOKE = {"law": "neo-hookean", "young_modulus": YOUNG, "poisson_ratio": 0.45}
MOONEY = {"law": "mooney-rivlin", "c10": 1e5, "c01": 5e4, "bulk_modulus": 1e7}
WEIGHT = {"gravity": {"acceleration": [0, 0, -9.81]}}


def moment(**keys):
    return {"moment": [{"value": [0.0, 0.0, 1.0], **keys}]}


def force(**keys):
    return {"force": [{"value": [0.0, 0.0, 1.0], **keys}]}


# The rod, the tables of the scene, and the size of the rows.
CASES = {
    "moment": ({}, moment(value=[0.0, 0.0, 0.0]), MOMENT),
    "moment in the body frame": ({"base": BASE}, moment(frame="body"), MOMENT),
    "follower moment": ({}, moment(direction="follower"), MOMENT),
    "vorticity, inside": ({"element": "3243"}, moment(definition="vorticity", at=0.4), MOMENT),
    "force": ({}, force(), 5 * FORCE),
    "follower and weight": ({"base": BASE}, force(direction="follower", frame="body") | WEIGHT, FORCE),
    "rubber": ({"material": NEO_HOOKE}, moment(), MOMENT),
    "curved 3363": ({"element": "3363", "curvature": [0.5, 0.0, 2.0]}, moment(), MOMENT),
    "rubber, curved": ({"curvature": [0.0, 1.0, 2.0], "material": MOONEY}, moment(), 0.5 * MOMENT),
    "differences": ({"elements": 2}, moment() | {"solver": {"tangent": "finite-difference"}}, MOMENT),
    "path": ({"elements": 2}, force() | {"solver": {"method": "arclength"}}, FORCE),
}
ONE_BY_ONE = ("differences", "path")


@pytest.mark.parametrize("engine", ["numpy", "auto"])
@pytest.mark.parametrize("name", CASES)
def test_a_row_is_what_solve_finds(name, engine):
    rod, tables, unit = CASES[name]
    kind = "moments" if "moment" in tables else "forces"
    rows = np.random.default_rng(1).uniform(-1, 1, (5, 3)) * unit
    if name in ONE_BY_ONE:
        engine = "auto"
    batch = ancf.solve_batch(scene(rod, **tables), **{kind: rows}, engine=engine)
    assert (batch.status == Status.CONVERGED).all() and batch.reason == [""] * 5
    for row, pose in zip(rows, batch.poses, strict=True):
        (load,) = tables[kind[:-1]]
        alone = ancf.solve(scene(rod, **{**tables, kind[:-1]: [load | {"value": row.tolist()}]}))
        assert alone.status == "converged"
        np.testing.assert_allclose(pose[:, 0], tip(alone)[:, 0], rtol=0, atol=1e-10 * L)
        np.testing.assert_allclose(pose, tip(alone), rtol=0, atol=1e-8)  # r_x is not of unit stiffness


def test_all_moments_and_forces_vary_together():
    tables = {
        "moment": [{"value": [0, 0, 1.0]}, {"value": [0, 1.0, 0], "at": 0.5}],
        "force": [{"value": [0, 1.0, 0]}],
    }
    rng = np.random.default_rng(2)
    moments, forces = rng.uniform(-1, 1, (3, 2, 3)) * MOMENT, rng.uniform(-1, 1, (3, 3)) * FORCE
    batch = ancf.solve_batch(scene(**tables), moments, forces=forces)
    for row in range(3):
        for table, value in zip(
            (*tables["moment"], *tables["force"]), (*moments[row], forces[row]), strict=True
        ):
            table["value"] = value.tolist()
        alone = ancf.solve(scene(**tables))
        np.testing.assert_allclose(batch.poses[row, :, 0], alone.tip().position, rtol=0, atol=1e-10 * L)


def test_a_load_that_acts_in_some_rows_has_a_node_in_all():
    """The mesh of a batch is that of its loaded rows, wherever they stand."""
    rows = np.array([[0, 0, 0], [0, 0, MOMENT]])
    batch = ancf.solve_batch(scene(**moment(at=0.4)), rows)
    alone = ancf.solve(scene(**moment(at=0.4, value=[0, 0, MOMENT])))
    np.testing.assert_allclose(batch.poses[1, :, 0], alone.tip().position, rtol=0, atol=1e-10 * L)
    np.testing.assert_allclose(batch.poses[0, :, 0], [L, 0, 0], atol=1e-14)
    np.testing.assert_allclose(batch.poses[0, :, 1:], np.eye(3), atol=1e-14)


def test_a_load_that_is_not_given_keeps_its_value():
    tables = {"moment": [{"value": [0, 0, 1.0]}], "force": [{"value": [0, FORCE, 0]}]}
    batch = ancf.solve_batch(scene(**tables), np.zeros((1, 3)))
    alone = ancf.solve(scene(force=tables["force"]))
    np.testing.assert_allclose(batch.poses[0, :, 0], alone.tip().position, rtol=0, atol=1e-10 * L)
    assert abs(alone.tip().position[1]) > 0.1 * L


def test_one_bad_row_spoils_no_other():
    template = scene(force=[{"value": [0, 0, 1.0]}], solver={"max_steps": 20})
    rows = np.array([[0, 1.0, 0], [1e300, 0, 1e299], [0, 0, 2.0], [-0.9e6, 0, 0], [0, 0, 0]]) * FORCE
    batch = ancf.solve_batch(template, forces=rows)
    good = ancf.solve_batch(template, forces=rows[[0, 2, 4]])
    assert [str(s) for s in batch.status[[0, 2, 4]]] == ["converged"] * 3
    assert batch.status[1] != "converged" and batch.status[3] != "converged"
    assert batch.reason[1] and batch.reason[3] and batch.load_factor[1] < 1.0
    assert np.isfinite(batch.poses).all() and np.isfinite(batch.residual).all()
    np.testing.assert_array_equal(batch.poses[[0, 2, 4]], good.poses)


def test_an_unstable_row_is_left_for_the_stable_branch():
    """Beyond Euler's load a strut with a small push takes the buckled branch, as in `solve`."""
    euler = np.pi**2 / 4 * FORCE
    rows = np.array([[-1.5 * euler, 0.0, 1e-3 * FORCE]])
    straight = ancf.solve(scene()).q  # Newton leads from it to the unstable equilibrium, almost straight
    batch = ancf.solve_batch(scene(**force()), forces=rows, start=straight)
    assert batch.status[0] == "converged" and abs(batch.poses[0, 2, 0]) > 0.3 * L
    alone = ancf.solve(scene(force=[{"value": rows[0].tolist()}]))
    np.testing.assert_allclose(batch.poses[0, :, 0], alone.tip().position, rtol=0, atol=1e-9 * L)
    assert batch.iterations[0] > alone.iterations  # what led to the unstable one is counted too


def test_a_sweep_starts_from_its_neighbours(monkeypatch):
    """One row in STRIDE starts from nothing; rows that are far from each other all do."""
    cold = []
    monkeypatch.setattr("ancf.batch_starts.load_start", lambda model, deadline: cold.append(1))
    sweep = np.linspace(0.0, 2.0, 2 * STRIDE)[:, None] * np.array([0.0, 1.0, 0.5]) * FORCE
    near = ancf.solve_batch(scene(**force()), forces=sweep, engine="numpy")
    assert len(cold) == 2 and (near.status == "converged").all()
    far = ancf.solve_batch(
        scene(**force()), forces=(-1.0) ** np.arange(2 * STRIDE)[:, None] * sweep[-1] / 2, engine="numpy"
    )
    assert len(cold) > 2 and (far.status == "converged").all()


def test_rows_that_are_solved_one_by_one_take_a_start_too():
    template = scene({"elements": 2}, **moment(), solver={"tangent": "finite-difference"})
    rows = np.array([[0, 0, MOMENT], [0, MOMENT, 0]])
    batch = ancf.solve_batch(template, rows)
    assert batch.engine == "solve" and batch.iterations.min() > 2
    assert ancf.solve_batch(template, rows, start=batch.q).iterations.max() <= 2


def test_warm_starts_save_iterations():
    sweep = np.linspace(0.0, 4.0, 3 * STRIDE)[:, None] * np.array([0.0, 1.0, 0.5]) * FORCE
    template = scene(force=[{"value": [0, 0, 1.0]}])
    batch = ancf.solve_batch(template, forces=sweep)
    again = ancf.solve_batch(template, forces=sweep, start=batch.q)
    assert (batch.status == "converged").all()
    assert again.iterations.max() <= 2 and batch.iterations.mean() > 3.0
    np.testing.assert_allclose(again.poses[..., 0], batch.poses[..., 0], rtol=0, atol=1e-10 * L)
    one = ancf.solve_batch(template, forces=sweep[:3], start=batch.q[1])
    np.testing.assert_allclose(one.poses[..., 0], batch.poses[:3, :, 0], rtol=0, atol=1e-10 * L)


def test_a_row_as_a_solution():
    batch = ancf.solve_batch(scene(moment=[{"value": [0, 0, 1.0]}]), np.array([[0, MOMENT, 0]]))
    solution = batch.solution(0)
    assert solution.status == "converged" and solution.iterations <= 2
    np.testing.assert_allclose(solution.reaction()[1], [0, -MOMENT, 0], atol=1e-9 * MOMENT)
    assert len(batch) == 1 and batch.rod == "arm"


def test_the_mesh_of_a_batch_by_accuracy():
    """One mesh for all rows, by the largest: each row is as good as was asked."""
    material = {"young_modulus": YOUNG, "poisson_ratio": 0.3}
    data = {"length": L, "section": {"shape": "circle", "radius": 1e-3}, "material": material}
    wanted = ancf.scene_from_dict({"rod": [data], **moment(), "solver": {"accuracy": 1e-3}})
    thin = YOUNG * np.pi * 1e-12 / 4 / L
    rows = np.array([[0, 0, 0.1], [0, 2.0, 1.0], [0.5, 0, -1.0]]) * thin
    batch = ancf.solve_batch(wanted, rows)
    assert (batch.status == "converged").all()
    fine = ancf.solve_batch(ancf.scene_from_dict({"rod": [data | {"elements": 48}], **moment()}), rows)
    error = np.linalg.norm(batch.poses[..., 0] - fine.poses[..., 0], axis=1)
    assert error.max() <= 1e-3 * L
    assert batch.model.rods[0].rod.elements < 16


def test_threads_share_a_scene():
    """Batches of one scene in several threads at once are what they are alone."""
    from concurrent.futures import ThreadPoolExecutor

    shared = scene(**moment())
    rows = np.random.default_rng(5).uniform(-1, 1, (6, 40, 3)) * MOMENT
    with ThreadPoolExecutor(3) as pool:
        together = list(pool.map(lambda part: ancf.solve_batch(shared, part).poses, rows))
    for part, poses in zip(rows, together, strict=True):
        np.testing.assert_array_equal(poses, ancf.solve_batch(scene(**moment()), part).poses)


MOMENTS = {"moment": [{"value": [0, 0, 1.0]}]}
BAD = {
    "nothing": (MOMENTS, {}, "no rows"),
    "no rows": (MOMENTS, {"moments": np.zeros((0, 3))}, "no rows"),
    "one row without its axis": (MOMENTS, {"moments": np.zeros(3)}, "values[None]"),
    "wrong components": (MOMENTS, {"moments": np.zeros((4, 2))}, "(B, 3)"),
    "too many loads": (MOMENTS, {"moments": np.zeros((4, 2, 3))}, "(B, 1, 3)"),
    "text": (MOMENTS, {"moments": [["a", "b", "c"]]}, "no numbers"),
    "ragged": (MOMENTS, {"moments": [[1.0], [1.0, 2.0]]}, "no numbers"),
    "not a number": (MOMENTS, {"moments": [[0, 0, 0], [0, 0, np.nan]]}, "moments[1]"),
    "infinite": (MOMENTS, {"moments": [[0, 0, np.inf]]}, "not finite"),
    "no force in the scene": (MOMENTS, {"forces": np.zeros((1, 3))}, "[[force]]"),
    "rows that do not match": (
        MOMENTS | force(), {"moments": np.zeros((2, 3)), "forces": np.zeros((3, 3))},
        "2 rows of moments, 3 rows of forces",
    ),
    "no such engine": (MOMENTS, {"moments": np.zeros((1, 3)), "engine": "abacus"}, "abacus"),
    "another start": (MOMENTS, {"moments": np.zeros((1, 3)), "start": np.zeros(7)}, "start"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_batches_are_refused(name):
    tables, arguments, hint = BAD[name]
    with pytest.raises(ancf.InputError) as refused:
        ancf.solve_batch(scene(**tables), **arguments)
    message = refused.value.message
    assert hint in str(message)
    assert all((message.what, message.where, message.value, message.cause, message.advice))
