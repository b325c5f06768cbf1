"""Data sets: what a design says, which rows it has, what their arrays are, and what a card tells of them."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import ancf
from ancf.errors import InputError, SceneError
from surrogate import dataset, gate, npz
from surrogate.blocks import ROWS
from surrogate.dataset import ARRAYS, DataError, load
from surrogate.design import design_from_dict, load_design, preset
from surrogate.gate import Gate
from surrogate.plan import Plan, differences
from surrogate.problem import problem_of
from surrogate.sampling import sample, split_sizes
from surrogate.sweep import make
from tests.datasets import SMALL, small, stale, tables
from validation.certificate import SHIPPED, load as load_certificate

EI = 1.0e6 * math.pi * 0.01**4 / 4.0


@pytest.fixture(autouse=True)
def _unvalidated(monkeypatch):
    """The shipped certificate may hold or not: these tests are not about it."""
    monkeypatch.setattr(gate, "verify", stale)


@pytest.fixture(scope="module")
def paper(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gate, "verify", stale)
        return make(preset("paper"), tmp_path_factory.mktemp("paper"), allow_unvalidated=True)


@pytest.fixture
def made(tmp_path):
    """A small data set and its folder."""
    return make(small(count=20), tmp_path / "data", allow_unvalidated=True), tmp_path / "data"


# --- the presets ----------------------------------------------------------------------------------------


def test_paper_is_the_sweep_of_the_paper(paper):
    """Section 3.1: 40 cm, 1520 poses, 70/15/15; 4 x 19 x 20 over torsion and bending, 12 elements 3243."""
    assert len(paper) == 1520
    assert [len(np.unique(column)) for column in paper.moments.T] == [4, 19, 20]
    assert len(np.unique(paper.moments, axis=0)) == 1520
    assert [(paper.split == name).sum() for name in ("train", "validation", "test")] == [1064, 228, 228]
    assert paper.card["arm"] == {
        "name": "arm", "length": 0.4, "radius": 0.01, "section": "circle", "young_modulus": 1.0e6,
        "poisson_ratio": 0.3, "law": "SaintVenantKirchhoff", "element": "3243", "elements": 12,
        "formulation": "enhanced", "bending_stiffness": pytest.approx(EI),
    }  # fmt: skip
    assert paper.card["seeds"] == {"sequences": [], "split": [[0, 3]]}
    assert paper.card["moment_range"] == [[-0.02, 0.02]] * 3
    assert paper.card["frames"]["base"]["rotation"] == [[0, 0, -1], [0, 1, 0], [1, 0, 0]]  # eq. 3
    assert set(paper.status) == {"converged"}


def test_its_slabs_are_the_levels_of_torsion(paper):
    levels = np.unique(paper.moments[:, 0])
    assert np.array_equal(levels[paper.group], paper.moments[:, 0])
    # A random split has every slab in every part.
    for name in ("train", "validation", "test"):
        assert set(paper.group[paper.split == name]) == {0, 1, 2, 3}


def test_its_poses_are_those_of_the_closed_form(paper):
    """theory.md 1: the tip of a thin rod under a fixed tip moment, exact up to (kappa R)^2, here 0.0019."""
    A_o = np.array(paper.card["frames"]["base"]["rotation"])
    v = paper.moments @ A_o.T * 0.4 / EI
    phi = np.linalg.norm(v, axis=1, keepdims=True)
    m, e = v / phi, np.array([0.0, 0.0, 1.0])
    along = m @ e[:, None]
    r = 0.4 * (m * along + np.sin(phi) / phi * (e - m * along) + (1 - np.cos(phi)) / phi * np.cross(m, e))
    assert np.abs(paper.pose[:, :, 0] - r).max() < 2 * 0.0019 * 0.4
    # R(L) = Exp(v) Exp(nu tau e) turns A_o, whose columns the gradients were; tau = v.e. The angles differ by
    # a few (kappa R)^2 |v|, the lengths by less; a wrong sign of nu or another frame would cost 0.6 or more.
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec(v) * Rotation.from_rotvec(0.3 * (v @ e)[:, None] * e)
    assert np.abs(paper.pose[:, :, 1:] - turn.as_matrix() @ A_o).max() < 0.03
    assert np.allclose(paper.stretch, np.linalg.norm(paper.pose[:, :, 1:], axis=1), rtol=1e-15)
    assert 1e-4 < np.abs(paper.stretch - 1.0).max() < 0.01


def test_the_presets_lie_inside_the_domain_of_the_shipped_certificate():
    """Whether it holds for the present code or not: its cases are at least as hard."""
    known = Gate(load_certificate(SHIPPED))
    for name in ("paper", "sobol"):
        design = preset(name)
        batch = ancf.solve_batch(design.scene, **design.values(sample(design).points))  # type: ignore[arg-type]
        assert known.outside(batch) == {}


# --- sampling -------------------------------------------------------------------------------------------


def test_sobol_fills_the_box_with_a_sequence_for_each_split():
    design = preset("sobol")
    found = sample(design)
    low, high = np.transpose([[v.low, v.high] for v in design.variables])
    assert ((found.points >= low) & (found.points <= high)).all()
    assert [(found.split == name).sum() for name in ("train", "validation", "test")] == [1064, 228, 228]
    assert np.array_equal(found.group, np.repeat([0, 1, 2], [1064, 228, 228]))
    # The first 2^k points of a Sobol sequence have 2^k/8 in each octant of the cube; three sequences differ.
    octants = (found.points[:1024] > 0.0) @ [1, 2, 4]
    assert np.array_equal(np.bincount(octants), [128] * 8)
    assert len(np.unique(found.points, axis=0)) == 1520


def test_a_design_and_its_seed_decide_the_rows():
    first, again, other = (sample(small(seed=seed)) for seed in (7, 7, 8))
    assert np.array_equal(first.points, again.points)
    assert not np.array_equal(first.points, other.points)
    grids = [sample(small_grid(seed=seed)) for seed in (1, 1, 2)]
    assert np.array_equal(grids[0].split, grids[1].split) and not np.array_equal(
        grids[0].split, grids[2].split
    )
    assert np.array_equal(grids[0].points, grids[2].points)


def small_grid(**design):
    vary = [
        {"load": "moment", "component": c, "range": [0.0, 1e-3], "steps": n} for c, n in (("x", 2), ("z", 5))
    ]
    found = tables(sampling="grid", split="random", vary=vary, **design)
    del found["design"]["count"]
    return design_from_dict(found)


def test_uniform_rows():
    found = sample(small(sampling="random", count=2000, split="random"))
    assert found.points.min() >= -0.01 and found.points.max() <= 0.01
    assert np.abs(found.points.mean(axis=0)).max() < 5 * 0.01 / math.sqrt(3 * 2000)  # 5 standard errors


@pytest.mark.parametrize(("count", "sizes"), [(1520, (1064, 228, 228)), (1, (1, 0, 0)), (20, (14, 3, 3))])
def test_sizes_of_the_splits(count, sizes):
    assert split_sizes(count) == sizes


# --- loads other than moments ---------------------------------------------------------------------------


def test_every_kind_of_load_varies():
    """Each row is what `solve` finds for the scene with its numbers written into it."""
    data = {
        **tables(), "moment": [{"value": [0, 0, 1e-3], "frame": "body"}, {"at": 0.5, "value": [0, 1e-3, 0]}],
        "force": [{"value": [0, 1e-3, 2e-3]}], "gravity": {"acceleration": [0, 0, 9.81]},
        "tendon": [{"tension": 0.1, "path": [[0, 0.005, 0], [1, 0.005, 0]]}],
        "design": {"count": 2, "vary": [
            {"load": "moment", "component": "y", "range": ["-2 N mm", "2 N mm"]},
            {"load": "moment", "index": 1, "component": "x", "range": [0.0, 1e-3]},
            {"load": "force", "component": "x", "range": [-1e-3, 1e-3]},
            {"load": "tendon", "range": [0.0, 0.3]},
        ]},
    }  # fmt: skip
    design = design_from_dict(data)
    plan = Plan(design, Gate(None))
    block = plan.block(0)
    from surrogate.blocks import solve

    found = solve(block)
    points = plan.sample.points
    assert [v.name for v in design.variables] == [
        "moment[0].y",
        "moment[1].x",
        "force[0].x",
        "tendon[0].tension",
    ]
    assert [v.unit for v in design.variables] == ["N m", "N m", "N", "N"]
    for row, (y, x, f, t) in enumerate(points):
        data["moment"][0]["value"], data["moment"][1]["value"] = [0, y, 1e-3], [x, 1e-3, 0]
        data["force"][0]["value"], data["tendon"][0]["tension"] = [f, 1e-3, 2e-3], t
        solution = ancf.solve(ancf.scene_from_dict({k: v for k, v in data.items() if k != "design"}))
        tip = solution.tip()
        expected = np.column_stack([tip.position, tip.r_x, tip.r_y, tip.r_z])
        assert np.abs(found.arrays["pose"][row] - expected).max() < 1e-8


def test_moments_that_do_not_vary_are_the_ones_of_the_scene(tmp_path):
    data = {
        **tables(),
        "moment": [{"value": [1e-3, 0, 2e-3], "frame": "body"}, {"value": [0, 1e-3, 0], "at": 0.5}],
        "force": [{"value": [0, 0, 0]}],
    }
    data["design"] = {"count": 3, "vary": [{"load": "force", "component": "y", "range": [0, 1e-3]}]}
    found = make(design_from_dict(data), tmp_path, allow_unvalidated=True)
    assert np.allclose(found.moments, [[1e-3, 0, 2e-3]] * 3, atol=1e-18)
    assert found.loads.shape == (3, 1)
    assert found.card["moment_range"] == [pytest.approx([m, m]) for m in (1e-3, 0, 2e-3)]
    design = {"count": 3, "vary": [{"load": "moment", "index": 1, "range": [0, 1e-3]}]}
    second = {**data, "design": design}
    found = make(design_from_dict(second), tmp_path / "second", allow_unvalidated=True)
    assert np.allclose(found.moments, [[1e-3, 0, 2e-3]] * 3, atol=1e-18)
    assert found.loads.min() > 0.0
    del data["moment"]
    found = make(design_from_dict(data), tmp_path / "none", allow_unvalidated=True)
    assert np.array_equal(found.moments, np.zeros((3, 3)))


def test_failed_rows_are_kept_with_their_status(tmp_path):
    data = tables(count=6, split="random", vary=[{"load": "force", "component": "x", "range": [-1e5, 1e5]}])
    data["force"] = [{"value": [0, 0, 0], "frame": "body"}]
    data["solver"] = {"max_steps": 3}
    found = make(design_from_dict(data), tmp_path, allow_unvalidated=True)
    failed = found.status != "converged"
    assert failed.any() and set(found.status[failed]) <= {str(s) for s in ancf.Status}
    assert found.card["rows_by_status"] == {
        s: int((found.status == s).sum()) for s in sorted(set(found.status))
    }
    assert (found.load_factor[failed] < 1.0).all() and (found.load_factor[~failed] == 1.0).all()
    assert np.isfinite(found.pose).all()
    rows = np.concatenate([found.rows(name) for name in ("train", "validation", "test")])
    assert not set(rows) & set(np.flatnonzero(failed))


# --- the files ------------------------------------------------------------------------------------------


def test_a_data_set_is_read_back(made):
    found, folder = made
    again = load(folder / "data.npz")
    for name in ARRAYS:
        assert np.array_equal(getattr(found, name), getattr(again, name))
    assert sorted(path.name for path in folder.iterdir()) == ["card.json", "data.npz"]
    shapes = {name: np.shape(getattr(found, name)) for name in ARRAYS}
    assert shapes == {
        "moments": (20, 3), "loads": (20, 3), "pose": (20, 3, 4), "stretch": (20, 3), "status": (20,),
        "iterations": (20,), "residual": (20,), "load_factor": (20,), "split": (20,), "group": (20,),
    }  # fmt: skip
    assert found.card["seeds"] == {"sequences": [[7, 0], [7, 1], [7, 2]], "split": []}
    assert not found.validated
    assert found.card["reasons"] == ["ancf/energy.py changed"]
    assert np.array_equal(
        np.sort(np.concatenate([found.rows(n) for n in dataset.SPLIT_NAMES])), np.arange(20)
    )


def test_its_rows_can_be_solved_again(made):
    found, folder = made
    design = load(folder).design
    batch = ancf.solve_batch(design.scene, found.moments)
    assert np.array_equal(batch.poses, found.pose)
    assert design.variables == small(count=20).variables


def test_equal_arrays_are_equal_bytes(tmp_path):
    arrays = {"b": np.arange(3.0), "a": np.array("text"), "c": np.arange(6).reshape(2, 3).T}
    first = npz.write(tmp_path / "first.npz", arrays).read_bytes()
    second = npz.write(tmp_path / "second.npz", dict(reversed(arrays.items()))).read_bytes()
    assert first == second
    found = npz.read(tmp_path / "first.npz")
    assert all(np.array_equal(found[name], array) for name, array in arrays.items())
    with np.load(tmp_path / "first.npz") as others:  # NumPy's own reader
        assert np.array_equal(others["c"], arrays["c"])
    assert npz.sha256(arrays["c"]) == npz.sha256(np.ascontiguousarray(arrays["c"]))
    assert npz.sha256(arrays["b"]) == npz.sha256(arrays["b"].astype(">f8"))
    assert npz.sha256(np.zeros(4)) != npz.sha256(np.zeros((2, 2)))


def spoil_card(folder, **changes):
    card = json.loads((folder / "card.json").read_text())
    (folder / "card.json").write_text(json.dumps({**card, **changes}))


def spoil_plan(folder, **changes):
    plan = json.loads((folder / "card.json").read_text())["plan"]
    spoil_card(folder, plan={**plan, **changes})


def restamp(folder, stamp):
    spoil_card(folder, certificate=stamp)
    spoil_data(folder, "certificate", lambda a: np.array(stamp))


def spoil_data(folder, name, change):
    arrays = npz.read(folder / "data.npz")
    arrays[name] = change(arrays[name])
    npz.write(folder / "data.npz", arrays)


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda f: (f / "card.json").unlink(), "The data card cannot be read"),
        (lambda f: (f / "data.npz").unlink(), "The data cannot be read"),
        (lambda f: (f / "card.json").write_text("{"), "is damaged"),
        (lambda f: spoil_card(f, schema=2), "schema 2, this version knows 1"),
        (lambda f: (f / "card.json").write_text("[]"), "schema None, this version knows 1"),
        (lambda f: spoil_card(f, plan=[], arrays=None), "arrays, plan missing or of another kind"),
        (lambda f: spoil_card(f, moment_range=[[0, 1]]), "not three pairs of numbers"),
        (lambda f: spoil_plan(f, solver="0" * 64), "plan_id is not the digest of plan"),
        (lambda f: spoil_card(f, certificate="f" * 64), "the data are stamped UNVALIDATED, the card ffff"),
        (lambda f: restamp(f, "f" * 64), "the card is stamped ffff.*, its plan UNVALIDATED"),
        (
            lambda f: (f / "data.npz").write_bytes((f / "data.npz").read_bytes()[:5000]),
            "truncated or damaged",
        ),
        (lambda f: spoil_data(f, "pose", lambda a: a + 1e-12), "'pose' is not the one of the card"),
        (lambda f: spoil_data(f, "status", lambda a: a[:3]), "'status' is not the one of the card"),
        (lambda f: spoil_data(f, "certificate", lambda a: np.array("f" * 64)), "stamped ffff"),
    ],
)
def test_damaged_data_are_named(made, spoil, words):
    _, folder = made
    spoil(folder)
    with pytest.raises(DataError, match=words) as refused:
        load(folder)
    assert str(folder) in refused.value.message.where


@pytest.mark.parametrize(
    ("name", "change", "words"),
    [
        ("pose", lambda a: a[:, :, :3], r"shape \(20, 3, 3\), must be \(n, 3, 4\)"),
        ("pose", lambda a: np.where(a == a[4, 0, 0], np.nan, a), "pose is not finite"),
        ("group", lambda a: a[:-1], "group has 19 rows, pose 20"),
        ("split", lambda a: np.full(20, "training"), "words other than train, validation, test"),
    ],
)
def test_numbers_that_cannot_be(made, name, change, words):
    """Data that agree with their card and are wrong all the same."""
    _, folder = made
    spoil_data(folder, name, change)
    described = json.loads((folder / "card.json").read_text())["arrays"]
    described[name] = npz.described(npz.read(folder / "data.npz")[name])
    spoil_card(folder, arrays=described)
    with pytest.raises(DataError, match=words):
        load(folder)


@pytest.mark.parametrize("value", [None, 0, 0.5, "x", [], {}, [[]]])
def test_a_card_with_any_entry_spoiled_is_refused_or_harmless(made, value):
    """Never another exception than an `InputError`, in the data set or in what is learned from it."""
    _, folder = made
    whole = json.loads((folder / "card.json").read_text())
    for key in whole:
        (folder / "card.json").write_text(json.dumps({**whole, key: value}))
        try:
            problem_of(load(folder))
        except InputError as error:
            assert error.message.cause


def test_parquet_holds_the_same(made, tmp_path):
    pq = pytest.importorskip("pyarrow.parquet")
    from surrogate import parquet

    found, _ = made
    again = parquet.read(parquet.write(found, tmp_path / "data.parquet"))
    table = pq.read_table(tmp_path / "data.parquet")  # by the names that others will read
    assert np.array_equal(table["r_x.z"], found.pose[:, 2, 1])
    assert np.array_equal(table["r.y"], found.pose[:, 1, 0])
    assert np.array_equal(table["moments.y"], found.moments[:, 1])
    assert np.array_equal(table["stretch.r_z"], found.stretch[:, 2])
    units = {field.name: field.metadata[b"unit"] for field in table.schema}
    assert [units[name] for name in ("moment[0].x", "r.x", "r_x.x")] == [b"N m", b"m", b"1"]
    for name in ARRAYS:
        assert np.array_equal(getattr(found, name), getattr(again, name)), name
        assert getattr(found, name).dtype == getattr(again, name).dtype
    assert again.card == found.card


# --- what a design may not say --------------------------------------------------------------------------


THREE = {"load": "moment", "range": [0, 1], "steps": 3}


def accurate():
    rod = {key: value for key, value in SMALL["rod"][0].items() if key != "elements"}
    return {"rod": [rod], "solver": {"accuracy": 1e-3}}


def without(key):
    found = tables()
    del found["design"][key]
    return found


@pytest.mark.parametrize(
    ("data", "where", "words"),
    [
        ({k: v for k, v in SMALL.items() if k != "design"}, "design", 'The key "design" is missing'),
        (without("count"), "design.count", '"count" is missing'),
        (without("vary"), "design.vary", "Nothing varies"),
        (tables(sampling="sobols"), "design.sampling", 'did you mean "sobol"'),
        (tables(cuont=3), "design.cuont", 'did you mean "count"'),
        (tables(count=0), "design.count", "out of range"),
        (tables(seed=-1), "design.seed", "out of range"),
        (tables(vary=[{"load": "moment", "range": [0.01, -0.01]}]), "vary[0].range", "smaller number"),
        (tables(vary=[{"load": "moment", "range": [0.0, "1 N"]}]), "vary[0].range[1]", "moment"),
        (tables(vary=[{"load": "moment", "range": [0.0, math.inf]}]), "vary[0].range[1]", "not finite"),
        (tables(vary=[{"load": "moment", "index": 1, "range": [0, 1]}]), "vary[0].index", "out of range"),
        (tables(vary=[{"load": "moment", "range": [0, 1]}] * 2), "vary", "moment[0].x varies twice"),
        (tables(vary=[{"load": "force", "range": [0, 1]}]), "vary[0].load", "no [[force]] table"),
        (tables(vary=[{"load": "pressure", "range": [0, 1]}]), "vary[0].load", "none of moment, force"),
        (tables(vary=[{"load": "moment", "range": [0, 1], "steps": 3}]), "vary[0].steps", "Only a grid"),
        (
            tables(sampling="grid", vary=[{**THREE, "component": c, "steps": 10**5} for c in "xy"]), "vary",
            "1e+10 rows, at most 1e+08",
        ),
        (tables(sampling="grid", vary=[THREE]), "count", "the steps give 3"),
        (
            tables(sampling="grid", split="design", count=3, vary=[THREE]), "split", "no independent designs",
        ),
        ({**tables(), **accurate()}, "solver.accuracy", "one mesh"),
        ({**tables(), "rods": []}, "rods", "did you mean"),
    ],
)  # fmt: skip
def test_a_design_that_cannot_be_used(data, where, words):
    with pytest.raises(SceneError) as refused:
        design_from_dict(data, "my.toml")
    assert words in str(refused.value)
    assert refused.value.message.where.startswith("my.toml") and where in refused.value.message.where


def test_a_design_is_a_scene_file_with_one_more_table(tmp_path):
    path = tmp_path / "design.toml"
    path.write_text(
        '[[rod]]\nlength = 0.4\nelements = 4\nsection = { shape = "circle", radius = 0.01 }\n'
        "material = { young_modulus = 1e6, poisson_ratio = 0.3 }\n[[moment]]\nvalue = [0, 0, 0]\n"
        '[design]\ncount = 4\nvary = [{ load = "moment", component = "z", range = ["0 N mm", "5 N mm"] }]\n'
    )
    design = load_design(path)
    assert (design.sampling, design.split, design.count, design.seed) == ("sobol", "design", 4, 0)
    assert (design.variables[0].low, design.variables[0].high) == (0.0, pytest.approx(5e-3))
    with pytest.raises(SceneError, match="cannot be read"):
        load_design(tmp_path / "none.toml")


def test_what_decides_the_bytes_is_compared_by_name():
    one, other = Plan(small(), Gate(None)), Plan(small(count=301), Gate(None))
    assert (one.blocks, [one.rows(n).stop for n in range(3)]) == (3, [ROWS, 2 * ROWS, 300])
    assert one.digest == Plan(small(), Gate(None)).digest != other.digest
    (difference,) = differences(one.record, other.record)
    assert difference.startswith("the design differs: design = ") and "301" in difference
    changed = {**one.record, "versions": {**one.record["versions"], "numpy": "1.0"}}
    (difference,) = differences(changed, one.record)
    assert difference == f"versions of packages differs: numpy = 1.0 there, numpy = {np.__version__} here"
