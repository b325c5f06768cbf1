"""Stored references: exact, tied to inputs and code, and never used when anything is wrong with them."""

from __future__ import annotations

import json
import shutil

import numpy as np
import pytest
from hypothesis import given, strategies as st

from reference import cache
from reference.cache import Cache, checksum, plain
from reference.code_digest import bare_code, code_digest

INPUTS = {"radius": 0.01, "law": "neo-hookean", "angles": [0.1, 0.2]}


@pytest.fixture
def code(tmp_path):
    """A small package `reference`: section imports rotation, solid imports nothing."""
    folder = tmp_path / "reference"
    folder.mkdir()
    (folder / "section.py").write_text(
        '"""Words."""\nfrom reference.rotation import turn\n\n\n'
        'def solve():\n    """Words."""\n    return turn(1)\n'
    )
    (folder / "rotation.py").write_text("def turn(x):\n    return x  # as it was\n")
    (folder / "solid.py").write_text("A = 1\n")
    return folder


@pytest.fixture
def make(tmp_path, code):
    """A new cache on the same folders, as the next program would open it."""
    return lambda fresh=False: Cache(tmp_path / "solved", fresh, tmp_path / "home", code)


class Solver:
    """Counts how often a result is computed."""

    def __init__(self, **result):
        self.result, self.calls = result or {"moment": 0.1 + 0.2, "axis": np.array([1.0, -0.0])}, 0

    def __call__(self):
        self.calls += 1
        return self.result


def only_file(tmp_path):
    (path,) = (tmp_path / "solved").iterdir()
    return path


def test_a_result_is_computed_once_and_found_again_exactly(make, tmp_path):
    solver = Solver()
    first = make()
    assert first.get("section", INPUTS, solver) == {"moment": 0.30000000000000004, "axis": [1.0, 0.0]}
    assert [e.what for e in first.events] == ["computed"]
    second = make()
    found = second.get("section", INPUTS, solver)
    assert (solver.calls, found["moment"]) == (1, 0.30000000000000004)
    assert str(found["axis"][1]) == "-0.0"
    assert ([e.what for e in second.events], second.warnings) == (["hit"], [])
    assert only_file(tmp_path).name.startswith("section-")


def test_other_inputs_or_another_kind_are_another_result(make):
    solver, store = Solver(), make()
    store.get("section", INPUTS, solver)
    store.get("section", {**INPUTS, "radius": np.nextafter(0.01, 1.0)}, solver)
    store.get("solid", INPUTS, solver)
    assert solver.calls == 3
    store.get("section", dict(reversed(INPUTS.items())), solver)  # the order of names does not matter
    assert solver.calls == 3


def test_a_caller_cannot_change_what_is_stored(make):
    store = make()
    store.get("section", INPUTS, Solver())["axis"].append(5.0)
    assert store.get("section", INPUTS, Solver())["axis"] == [1.0, 0.0]


def damage_value(data):
    data["result"]["moment"] = 0.5


def damage_inputs(data):
    data["inputs"]["radius"] = 0.02


def damage_code(data):
    data["code"] = ["section"]
    data["checksum"] = checksum({key: value for key, value in data.items() if key != "checksum"})


def damage_number(data):
    data["result"]["moment"] = float("nan")


@pytest.mark.parametrize(
    "damage", [damage_value, damage_inputs, lambda data: data.pop("code"), damage_code, damage_number]
)
def test_an_edited_file_is_named_and_computed_again(make, tmp_path, damage):
    make().get("section", INPUTS, Solver())
    path = only_file(tmp_path)
    data = json.loads(path.read_text())
    damage(data)
    path.write_text(json.dumps(data))
    store, solver = make(), Solver()
    assert store.get("section", INPUTS, solver)["moment"] == 0.30000000000000004
    assert (solver.calls, [e.what for e in store.events]) == (1, ["corrupted", "computed"])
    assert path.name in store.warnings[0]
    assert make().get("section", INPUTS, solver) and solver.calls == 1  # and it was mended


@pytest.mark.parametrize(
    "content", [b"", b"{", b"[]", b"\xff\xfe", b"null", b'{"schema": 1}', b"[" * 100_000], ids=range(7)
)
def test_a_truncated_file_is_named_and_computed_again(make, tmp_path, content):
    make().get("section", INPUTS, Solver())
    only_file(tmp_path).write_bytes(content)
    store, solver = make(), Solver()
    store.get("section", INPUTS, solver)
    assert (solver.calls, store.events[0].what) == (1, "corrupted")


def test_a_file_renamed_to_another_key_is_foreign(make, tmp_path):
    make().get("section", {**INPUTS, "radius": 0.02}, Solver())
    old = only_file(tmp_path)
    make().get("section", INPUTS, Solver())
    (new,) = set((tmp_path / "solved").iterdir()) - {old}
    shutil.copy(old, new)
    store, solver = make(), Solver()
    store.get("section", INPUTS, solver)
    assert (solver.calls, store.events[0].what) == (1, "foreign")


@pytest.mark.parametrize(
    ("module", "text", "stale"),
    [
        ("section.py", '"""Other words."""\nfrom reference.rotation import turn\n\ndef solve():\n'
         '    """And here."""\n    return turn(1)  # said\n', False),
        ("rotation.py", "def turn(x):\n    return x\n", False),
        ("section.py", "from reference.rotation import turn\ndef solve():\n    return turn(2)\n", True),
        ("rotation.py", "def turn(x):\n    return -x\n", True),  # imported, not named
        ("solid.py", "A = 2\n", False),  # not imported
    ],
)  # fmt: skip
def test_an_edit_of_the_code_makes_it_stale_and_better_wording_does_not(make, code, module, text, stale):
    make().get("section", INPUTS, Solver())
    (code / module).write_text(text)
    store, solver = make(), Solver()
    store.get("section", INPUTS, solver)
    assert solver.calls == int(stale)
    if stale:
        assert f"reference/{module}" in store.warnings[0]


def test_another_scikit_fem_makes_it_stale(make, monkeypatch):
    make().get("section", INPUTS, Solver())
    monkeypatch.setattr(cache, "scikit_fem_version", lambda: "13")
    store, solver = make(), Solver()
    store.get("section", INPUTS, solver)
    assert (solver.calls, store.events[0].what) == (1, "stale")


def test_fresh_computes_once_and_stores_anew(make):
    make().get("section", INPUTS, Solver())
    store, solver = make(fresh=True), Solver(moment=2.0)
    store.get("section", INPUTS, solver)
    store.get("section", INPUTS, solver)
    assert solver.calls == 1
    assert make().get("section", INPUTS, Solver()) == {"moment": 2.0}


def test_a_folder_that_cannot_be_written_sends_results_home(make, tmp_path):
    (tmp_path / "solved").write_text("a file, not a folder")
    solver = Solver()
    make().get("section", INPUTS, solver)
    assert [path.suffix for path in (tmp_path / "home").iterdir()] == [".json"]
    make().get("section", INPUTS, solver)
    assert solver.calls == 1


def test_no_folder_at_all_is_named_and_the_result_is_given(make, tmp_path):
    for name in ("solved", "home"):
        (tmp_path / name).write_text("a file, not a folder")
    store = make()
    assert store.get("section", INPUTS, Solver())["moment"] == 0.30000000000000004
    assert store.events[-1].what == "not stored"
    assert "not kept" in store.warnings[0]


@pytest.mark.parametrize("value", [np.nan, np.inf, object(), {1.0}, 1j])
def test_what_json_cannot_hold_is_refused_by_name(make, value):
    with pytest.raises(ValueError, match=r"result\.deep\[1\]"):
        make().get("section", INPUTS, Solver(deep=[1.0, value]))
    with pytest.raises(ValueError, match=r"inputs\.radius"):
        make().get("section", {"radius": value}, Solver())


def test_a_computation_that_raises_leaves_nothing(make, tmp_path):
    def failing():
        raise RuntimeError("no equilibrium")

    with pytest.raises(RuntimeError):
        make().get("section", INPUTS, failing)
    assert not (tmp_path / "solved").exists()


def test_an_unknown_kind_is_refused(make):
    with pytest.raises(ValueError, match=r"reference/sektion\.py"):
        make().get("sektion", INPUTS, Solver())


@given(st.lists(st.floats(allow_nan=False, allow_infinity=False)))
def test_floats_keep_every_bit(values):
    through = json.loads(json.dumps(plain({"values": np.array(values)}, "here")))["values"]
    assert np.array(through).tobytes() == np.array(values).tobytes()
    assert checksum(through) == checksum(values)


def test_bare_code_keeps_strings_that_are_no_docstrings():
    source = 'def f():\n    "ä doc"  # c\n    x = """a # b\n\n  c"""  # d\n    return x\n'
    assert bare_code(source) == 'def f():\n    x = """a # b\n  c"""\n    return x'


def test_the_digest_follows_imports_in_this_package():
    found = code_digest("solid")
    assert {"solid", "solid_mesh", "solid_newton", "rotation"} <= set(found)
    assert "helix" not in found
