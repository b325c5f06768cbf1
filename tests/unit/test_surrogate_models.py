"""Models in files, without torch; the commands `ancf train`, `crossval`, `track`, `invert`, `reproduce`."""

from __future__ import annotations

import errno
import json
import math
import os
import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import ancf
from ancf.cli import main
from surrogate.architecture import MAIN_CNN, RAW_MLP
from surrogate.arm import Arm, paper_arm
from surrogate.baselines import Polynomial
from surrogate.conformal import ErrorRadius, radius_text
from surrogate.crossval import cross_validate, rescaled
from surrogate.dataset import load
from surrogate.equivariant import RESIDUAL_MLP, EquivariantNetwork
from surrogate.fit import BASELINES
from surrogate.model_file import (
    RECORD,
    WEIGHTS,
    load_model,
    read_safetensors,
    safetensors,
    save,
)
from surrogate.networks import Normaliser, PoseNetwork, image
from surrogate.problem import box_design, problem_of

DESIGN = """
title = "small"
[[rod]]
length = 0.4
elements = 4
section = { shape = "circle", radius = 0.01 }
material = { young_modulus = 1e6, poisson_ratio = 0.3 }
base = { x_axis = [0, 0, 1], y_axis = [0, 1, 0] }
[[moment]]
frame = "body"
value = [0, 0, 0]
[design]
sampling = "sobol"
count = 256
vary = [
  { load = "moment", component = "x", range = [-0.02, 0.02] },
  { load = "moment", component = "y", range = [-0.02, 0.02] },
  { load = "moment", component = "z", range = [-0.02, 0.02] },
]
"""
SCENE: dict[str, Any] = {
    "rod": [
        {
            "length": 0.4, "elements": 4, "section": {"shape": "circle", "radius": 0.01},
            "material": {"young_modulus": 1e6, "poisson_ratio": 0.3},
            "base": {"x_axis": [0, 0, 1], "y_axis": [0, 1, 0]},
        }
    ],
    "moment": [{"frame": "body", "value": [0, 0, 1.0]}],
}  # fmt: skip
ARM = paper_arm(elements=4, element="3333")
KEPT = {"scene": SCENE, "moment_range": [[-0.02, 0.02]] * 3, "certificate": "UNVALIDATED"}


def cnn(seed=0, architecture=MAIN_CNN):
    rng = np.random.default_rng(seed)
    normaliser = Normaliser(rng.normal(size=12), rng.uniform(0.5, 2.0, 12))
    return PoseNetwork(architecture, rng.normal(size=architecture.parameters), normaliser, 1e-3)


def mlp():
    return cnn(6, RAW_MLP)


def equivariant():
    flat = np.random.default_rng(1).normal(size=RESIDUAL_MLP.parameters)
    return EquivariantNetwork(ARM, flat, np.array([1.0, 2.0]), 0.1)


@pytest.fixture(scope="module")
def poses():
    return ARM.solve(box_design(np.outer(np.ones(3), [-0.02, 0.02]), 16, 3)).poses


@pytest.mark.parametrize("model", [cnn(), mlp(), equivariant()], ids=["cnn", "mlp", "equivariant"])
def test_a_model_comes_back_as_it_was(model, poses, tmp_path):
    save(tmp_path, model, KEPT)
    again = load_model(tmp_path)
    np.testing.assert_array_equal(again.model.predict(poses), model.predict(poses))
    np.testing.assert_allclose(again.model.predict(poses[3]), model.predict(poses)[3], atol=1e-15)
    assert again.bounds.shape == (3, 2)
    first = (tmp_path / WEIGHTS).read_bytes()
    save(tmp_path, model, KEPT)
    assert (tmp_path / WEIGHTS).read_bytes() == first


def test_the_weights_are_what_the_safetensors_package_reads(tmp_path):
    numpy_reader = pytest.importorskip("safetensors.numpy")
    arrays = {"b": np.arange(6.0).reshape(2, 3), "a": np.array([np.pi])}
    (tmp_path / "x.safetensors").write_bytes(safetensors(arrays))
    found = numpy_reader.load_file(tmp_path / "x.safetensors")
    assert set(found) == {"a", "b"}
    for name, value in arrays.items():
        np.testing.assert_array_equal(found[name], value)
    np.testing.assert_array_equal(read_safetensors(numpy_reader.save(arrays))["b"], arrays["b"])


@pytest.mark.parametrize("kept", [4, 40, -8])
def test_a_file_that_is_cut_off_is_named(kept):
    whole = safetensors({"a": np.arange(30.0)})
    with pytest.raises(ValueError, match=r"header|cut off|ends"):
        read_safetensors(whole[:kept])


def test_a_folder_that_is_no_model_is_refused(tmp_path):
    with pytest.raises(ancf.InputError, match="cannot be read"):
        load_model(tmp_path)
    save(tmp_path, cnn(), KEPT)
    weights, record = (tmp_path / WEIGHTS).read_bytes(), json.loads((tmp_path / RECORD).read_text())
    (tmp_path / WEIGHTS).write_bytes(weights[:-1] + b"\0")
    with pytest.raises(ancf.InputError, match="not those of the record"):
        load_model(tmp_path)
    (tmp_path / WEIGHTS).write_bytes(weights)
    for change, word in (
        ({"schema": 9}, "another schema"),
        ({"scene": {}}, "rod"),
        ({"kind": "x"}, "damaged"),
    ):
        (tmp_path / RECORD).write_text(json.dumps({**record, **change}))
        with pytest.raises(ancf.InputError, match=word):
            load_model(tmp_path)


def test_models_answer_without_torch(tmp_path, poses):
    save(tmp_path, cnn(), KEPT)
    np.save(tmp_path / "poses.npy", poses)
    code = (
        "import sys, numpy as np; from pathlib import Path; from surrogate.model_file import load_model;"
        f" m = load_model(Path({str(tmp_path)!r})).model.predict(np.load({str(tmp_path / 'poses.npy')!r}));"
        " print(m.shape, [n for n in ('torch', 'numba', 'matplotlib', 'onnx') if n in sys.modules])"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "(16, 3) []"


def polynomial(arm=ARM):
    rng = np.random.default_rng(3)
    return Polynomial(arm, Normaliser(rng.normal(size=6), rng.uniform(0.5, 2.0, 6)), rng.normal(size=(84, 3)))


FOLLOWER = Arm.of(
    ancf.scene_from_dict(
        {
            **SCENE,
            "rod": [
                {
                    **SCENE["rod"][0],
                    "base": {"position": [1, -2, 0.5], "x_axis": [1, 2, 0.5], "y_axis": [0, 1, 1]},
                }
            ],
            "moment": [{"value": [0, 0, 1.0], "direction": "follower"}],
        }
    )
)


@pytest.mark.parametrize(
    ("model", "arm"),
    [
        (cnn(2), ARM),
        (mlp(), ARM),
        (equivariant(), ARM),
        (EquivariantNetwork(FOLLOWER, equivariant().flat, np.array([1.0, 2.0]), 0.1), FOLLOWER),
        (polynomial(), ARM),
        (polynomial(FOLLOWER), FOLLOWER),
    ],
    ids=["cnn", "mlp", "equivariant", "equivariant, follower", "polynomial", "polynomial, follower"],
)
def test_the_onnx_graph_agrees_with_numpy(model, arm):
    """By the reference evaluator of the package onnx: metres in, newton metres out; |v| up to 4."""
    reference = pytest.importorskip("onnx.reference")
    from surrogate.onnx_graph import onnx_model

    v = np.concatenate(
        [np.zeros((1, 3)), 1e-6 * np.eye(3), np.random.default_rng(4).uniform(-2.3, 2.3, (60, 3))]
    )
    poses = arm.solve(arm.moments(v)).poses
    (found,) = reference.ReferenceEvaluator(onnx_model(model)).run(None, {"pose": poses})
    expected = model.predict(poses)
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-11 * np.abs(expected).max())


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    folder = tmp_path_factory.mktemp("data")
    (folder / "design.toml").write_text(DESIGN)
    arguments = ["dataset", str(folder / "design.toml"), "--out", str(folder / "d"), "--allow-unvalidated"]
    assert main(arguments) == 0
    return folder / "d"


def test_data_without_certificate_are_refused(data, capsys, tmp_path):
    assert main(["train", str(data), "--out", str(tmp_path / "m")]) == 4
    assert "certificate" in capsys.readouterr().err and not (tmp_path / "m").exists()
    assert main(["crossval", str(data)]) == 4


def test_few_rows_leave_the_radius_unknown():
    """Of 9 rows none is the 95 % quantile (19 are needed): the radius is infinite."""
    radius = ErrorRadius(0.95, 9, math.inf, math.inf).as_dict()
    assert radius["position"] is None
    assert radius["moment"] is None
    assert "unknown from 9 rows" in radius_text(radius)


@pytest.mark.parametrize("kind", ["polynomial", "equivariant", "cnn", "mlp"])
def test_ancf_train_track_and_invert(data, capsys, tmp_path, kind, poses):
    if kind != "polynomial":
        pytest.importorskip("torch")
    out = tmp_path / "m"
    arguments = ["train", str(data), "--model", kind, "--out", str(out), "--allow-unvalidated", "--json"]
    assert main([*arguments, "--epochs", "30"]) == 0
    record = json.loads(capsys.readouterr().out)
    assert record["kind"] == kind and record["certificate"] == "UNVALIDATED"
    assert set(record["scores"]) == {"split", "off_grid", "trajectory", "noise", "outside", "slab"}
    assert "UNVALIDATED" in (out / "MODEL_CARD.md").read_text()
    assert main(["track", str(out), "--json"]) == 0
    tracked = json.loads(capsys.readouterr().out)
    assert tracked["unsolved"] == 0 and tracked["exact_tip_percent"]["max"] < 0.1
    assert len(tracked["moments"]) == 100
    np.save(tmp_path / "poses.npy", poses[:3])
    assert main(["invert", str(out), "--pose", str(tmp_path / "poses.npy"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["method"].startswith(kind) and found["certificate"] == "UNVALIDATED"
    assert found["error_radius"]["level"] == 0.95 and found["warnings"] == []
    assert all(answer["reachable"] and len(answer["predicted"]) == 3 for answer in found["poses"])
    assert main(["invert", str(out), "--pose", str(tmp_path / "poses.npy"), "--exact", "--json"]) == 0
    exact = json.loads(capsys.readouterr().out)
    assert exact["method"] == "levenberg-marquardt" and exact["error_radius"] is None
    for a, b in zip(found["poses"], exact["poses"], strict=True):
        np.testing.assert_allclose(a["moment"], b["moment"], atol=1e-10)


def test_data_in_which_other_loads_vary_are_refused(tmp_path, capsys):
    text = DESIGN.replace("[design]", "[[force]]\nvalue = [0, 0, 0]\n[design]").replace(
        "count = 256", "count = 16"
    )
    text = text.replace("]\n}", "").replace(
        "vary = [", 'vary = [ { load = "force", component = "y", range = [-0.01, 0.01] },'
    )
    (tmp_path / "design.toml").write_text(text)
    data = tmp_path / "d"
    assert main(["dataset", str(tmp_path / "design.toml"), "--out", str(data), "--allow-unvalidated"]) == 0
    assert main(["train", str(data), "--model", "polynomial", "--allow-unvalidated"]) == 2
    assert "force[0].y" in capsys.readouterr().err


def test_a_model_that_does_not_fit_the_arm_is_refused(tmp_path, capsys):
    gravity = "[gravity]\nacceleration = [0, 0, 3.0]\n[[moment]]"
    text = DESIGN.replace("[[moment]]", gravity).replace("0.3 }", "0.3, density = 1000.0 }")
    (tmp_path / "design.toml").write_text(text.replace("count = 256", "count = 200"))
    data = tmp_path / "d"
    assert main(["dataset", str(tmp_path / "design.toml"), "--out", str(data), "--allow-unvalidated"]) == 0
    assert main(["train", str(data), "--allow-unvalidated"]) == 2
    assert "gravity" in capsys.readouterr().err
    assert main(["train", str(data), "--model", "polynomial", "--allow-unvalidated", "--json"]) == 0
    scores = json.loads(capsys.readouterr().out)["scores"]
    assert scores["off_grid"]["tip"]["mean"] < 0.05  # %; 0.6 % without the effect of the weight


def test_bad_arguments_are_refused(data, capsys, tmp_path):
    (tmp_path / "file").write_text("")
    polynomial = ["train", str(data), "--model", "polynomial", "--allow-unvalidated"]
    for arguments, word in (
        (["train", str(data), "--model", "magic"], "no such model"),
        (["train", str(tmp_path)], "card"),
        (["crossval", str(data), "--range", "9", "--allow-unvalidated"], "range"),
        (["track", str(tmp_path)], "cannot be read"),
        ([*polynomial, "--out", str(tmp_path / "file" / "x")], "cannot be written"),
    ):
        assert main(arguments) == 2
        assert word in capsys.readouterr().err


def test_a_full_disk_leaves_no_part_of_a_file(data, capsys, tmp_path, monkeypatch):
    import surrogate.whole_file

    def full(handle):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(surrogate.whole_file.os, "fsync", full)
    arguments = ["train", str(data), "--model", "polynomial", "--out", str(tmp_path / "m")]
    assert main([*arguments, "--allow-unvalidated"]) == 2
    assert "No space left on device" in capsys.readouterr().err
    assert not list((tmp_path / "m").iterdir())


def test_a_full_disk_leaves_the_old_model(poses, tmp_path, monkeypatch):
    """The second of two files does not fit: the first is not replaced either."""
    import surrogate.whole_file

    save(tmp_path, cnn(0), KEPT)
    calls = []

    def full(handle):
        calls.append(handle)
        if len(calls) == 2:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(surrogate.whole_file.os, "fsync", full)
    with pytest.raises(OSError, match="No space"):
        save(tmp_path, cnn(1), KEPT)
    np.testing.assert_array_equal(load_model(tmp_path).model.predict(poses), cnn(0).predict(poses))
    assert sorted(path.name for path in tmp_path.iterdir()) == [RECORD, WEIGHTS]


def test_the_table_is_one_stack_of_folds(data, capsys):
    pytest.importorskip("torch")
    problem = rescaled(problem_of(load(data)), 2.0)
    assert np.abs(problem.bounds).max() == pytest.approx(2.0 * problem.arm.unit)
    table = cross_validate(problem, epochs=3, seeds=(0, 1))
    assert table.trainings == 50 and len(table.rows) == 5 and table.range == pytest.approx(2.0)
    for row in table.rows:
        assert row.mse.shape == (10,) and row.training_loss.shape == (10, 3)
        assert row.as_dict()["mse_N2m2"] == pytest.approx(row.mse.mean() * row.unit**2)
    assert main(["crossval", str(data), "--epochs", "2", "--allow-unvalidated", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [m["size"] for m in found["models"]] == [259, 187, 199, 651, 2515]
    assert found["trainings"] == 25
    assert main(["crossval", str(data), "--epochs", "1", "--allow-unvalidated"]) == 0
    assert "25 trainings" in capsys.readouterr().err


def test_every_row_is_left_out_once_and_never_trained_on_then(data):
    from surrogate.crossval import _fold

    samples = problem_of(load(data)).all
    seen = []
    for fold in range(5):
        (kept, normaliser), (left, same) = _fold(samples, fold, 5, 3)
        first, out = ({m.tobytes() for m in part.moments} for part in (kept, left))
        assert not first & out and len(first) == 204 and len(out) == 51  # of 256
        assert normaliser is same
        np.testing.assert_array_equal(normaliser.mean, image(kept.poses).mean(axis=0))
        seen += out
    assert len(seen) == len(set(seen)) == 255


def test_the_paper_is_regenerated_with_every_figure(data, tmp_path):
    pytest.importorskip("torch")
    pytest.importorskip("matplotlib")
    from surrogate.reproduce import report, reproduce

    record = reproduce(problem_of(load(data)), tmp_path, epochs=5, table_epochs=2)
    assert sorted(p.name for p in tmp_path.iterdir()) == sorted(f"fig{k}.png" for k in range(4, 12))
    assert record["printed_eq47"]["printed"] == pytest.approx(1.3, abs=0.05)  # paper-map.md
    text = report(record)
    assert "| 5: C32,2, C16,2, F8, F3 | 2515 | 2515 |" in text and "UNVALIDATED" in text


def test_models_are_compared(data, tmp_path, capsys):
    pytest.importorskip("torch")
    arguments = ["compare", str(data), "--seeds", "2", "--epochs", "2", "--allow-unvalidated"]
    assert main([*arguments, "--out", str(tmp_path)]) == 0
    assert "Is a surrogate worth having?" in capsys.readouterr().err
    record = json.loads((tmp_path / "compare.json").read_text())
    kinds = [m["kind"] for m in record["models"]]
    assert kinds == [*BASELINES, "polynomial", "mlp", "cnn", "equivariant"]
    for model in record["models"]:
        assert set(model["sets"]) == {"split", "off_grid", "trajectory", "noise", "outside", "slab"}
        assert model["solves"]["reached"] == 1.0 and model["sets"]["off_grid"]["unsolved"] == 0
    assert record["auroc"] >= 0.99  # issue
    assert (tmp_path / "compare.md").read_text().count("| equivariant") == 2


def test_a_model_carries_the_certificate_of_its_data(data, tmp_path, monkeypatch, capsys):
    """Data of the valid certificate pass; of another one only unvalidated, and the stamp says so."""
    from dataclasses import replace

    import surrogate.dataset
    import surrogate.gate
    from surrogate.gate import Gate
    from validation.certificate import Certificate

    known = load(data)
    certified = replace(known, card={**known.card, "certificate": "abc"})
    monkeypatch.setattr(surrogate.dataset, "load", lambda path: certified)
    arguments = ["train", str(data), "--model", "polynomial", "--out", str(tmp_path), "--json"]
    for valid, extra, code, stamp in (
        ("abc", [], 0, "abc"),
        ("other", [], 4, None),
        ("other", ["--allow-unvalidated"], 0, "UNVALIDATED"),
    ):
        gate = Gate(Certificate({"id": valid, "predicate": {"domain": {}}}))
        monkeypatch.setattr(surrogate.gate, "ask", lambda allow_unvalidated=False, gate=gate: gate)
        assert main([*arguments, *extra]) == code
        streams = capsys.readouterr()
        if stamp is None:
            assert "abc" in streams.err and "other" in streams.err
        else:
            assert json.loads(streams.out)["certificate"] == stamp
