"""The sweep of a data set: the same bytes whoever solves it, nothing lost when something breaks."""

from __future__ import annotations

import errno
import json
import os
import shutil
import signal
from concurrent.futures import Executor, Future, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ancf.errors import InputError
from surrogate import gate, npz, sweep
from surrogate.executors import opened
from surrogate.gate import Gate, ask
from surrogate.plan import Plan
from surrogate.store import OtherPlan
from surrogate.sweep import finished, make, merge, shard, sweep as solve_blocks
from tests.datasets import small, valid


@pytest.fixture(autouse=True)
def _certified(monkeypatch):
    monkeypatch.setattr(gate, "verify", valid())


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Bytes of the small data set, solved in this process without a break."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gate, "verify", valid())
        folder = tmp_path_factory.mktemp("whole")
        make(small(), folder)
        return contents(folder)


@pytest.fixture
def counted(monkeypatch):
    """Numbers of the blocks that are solved from here on."""
    numbers, solve = [], sweep.solve

    def counting(block):
        numbers.append(block.number)
        return solve(block)

    monkeypatch.setattr(sweep, "solve", counting)
    return numbers


def contents(folder):
    """Every file of a finished folder by name."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def parts(error):
    message = error.value.message
    assert all((message.what, message.where, message.value, message.cause, message.advice))
    return message


# --- the same bytes -------------------------------------------------------------------------------------


@pytest.mark.parametrize("workers", [2, 3])
def test_processes_make_the_same_bytes(tmp_path, whole, workers):
    with opened(workers) as executor:
        assert isinstance(executor, ProcessPoolExecutor)
        make(small(), tmp_path, executor)
    assert contents(tmp_path) == whole


class Backwards(Executor):
    """Answers the last task first."""

    def __init__(self):
        self.tasks = []

    def submit(self, fn, /, *args, **kwargs):
        future = Future()
        self.tasks.append((future, fn, args))
        if len(self.tasks) == 3:
            for waiting, task, arguments in reversed(self.tasks):
                waiting.set_result(task(*arguments))
        return future


def test_any_executor_and_any_order_make_the_same_bytes(tmp_path, whole, monkeypatch):
    make(small(), tmp_path / "backwards", Backwards())
    assert contents(tmp_path / "backwards") == whole
    monkeypatch.setattr(sweep, "IN_FLIGHT", 1)  # the queue is full all the time
    with ThreadPoolExecutor(2) as executor:
        make(small(), tmp_path / "threads", executor)
    assert contents(tmp_path / "threads") == whole


def test_shards_make_the_same_bytes(tmp_path, whole):
    plan = Plan(small(), ask())
    folders = [tmp_path / str(i) for i in range(2)]
    for i, folder in enumerate(folders):
        solve_blocks(plan, folder, shard(f"{i + 1}/2", plan.blocks))
    before = [contents(folder) for folder in folders]
    shutil.copytree(folders[0], tmp_path / "spare")
    merge(folders, tmp_path / "all")
    assert contents(tmp_path / "all") == whole
    assert [contents(folder) for folder in folders] == before
    (folders[0] / "blocks" / "000000.npz").write_bytes(b"damaged")
    merge([folders[1], tmp_path / "spare"], folders[0])  # into one of them, of which a block is broken
    assert contents(folders[0]) == whole


def test_progress_counts_blocks(tmp_path):
    seen = []
    make(small(), tmp_path, progress=lambda done, count: seen.append((done, count)))
    assert seen == [(1, 3), (2, 3), (3, 3)]


@pytest.mark.parametrize(
    ("text", "blocks"), [("1/1", [0, 1, 2, 3, 4]), ("1/2", [0, 2, 4]), ("2/2", [1, 3]), ("9/9", [])]
)
def test_blocks_of_a_shard(text, blocks):
    assert list(shard(text, 5)) == blocks


@given(st.integers(0, 200), st.integers(1, 30))
def test_shards_are_every_block_once(blocks, count):
    parts_ = [list(shard(f"{i + 1}/{count}", blocks)) for i in range(count)]
    assert sorted(number for part in parts_ for number in part) == list(range(blocks))
    assert max(map(len, parts_)) - min(map(len, parts_)) <= 1


@given(st.integers(1, 2000))
def test_blocks_are_every_row_once(count):
    plan = Plan(small(count=count), Gate(None))
    rows = [row for number in range(plan.blocks) for row in range(count)[plan.rows(number)]]
    assert rows == list(range(count))


@pytest.mark.parametrize("text", ["0/2", "3/2", "1", "1/0", "-1/2", "a/b", "1/2/3", "1/ 2"])
def test_no_such_shard(text):
    with pytest.raises(InputError) as refused:
        shard(text, 5)
    assert f"--shard {text}" == parts(refused).where


# --- something breaks -----------------------------------------------------------------------------------


class Broken(Exception):
    """Whatever ends a process from inside."""


def test_an_interrupted_sweep_goes_on(tmp_path, whole, counted, monkeypatch):
    def interrupt(done, count):
        if done == 2:
            raise Broken

    with pytest.raises(Broken):
        make(small(), tmp_path, progress=interrupt)
    assert not (tmp_path / "data.npz").exists()
    make(small(), tmp_path)
    assert counted == [0, 1, 2]  # each once
    assert contents(tmp_path) == whole
    make(small(), tmp_path)  # finished: nothing left to do
    assert counted == [0, 1, 2]


def _solve_or_die(block):
    if block.number == 1:
        os.kill(os.getpid(), signal.SIGKILL)
    from surrogate.blocks import solve

    return solve(block)


def test_a_killed_worker_is_named_and_nothing_is_lost(tmp_path, whole, counted, monkeypatch):
    with opened(2) as executor, monkeypatch.context() as patch:
        patch.setattr(sweep, "solve", _solve_or_die)
        patch.setattr(sweep, "IN_FLIGHT", 1)  # one after the other, so that the first is there for certain
        with pytest.raises(InputError) as refused:
            make(small(), tmp_path, executor)
    assert (
        "BrokenProcessPool" in parts(refused).value and "run the same command again" in parts(refused).advice
    )
    make(small(), tmp_path)
    assert counted == [1, 2]
    assert contents(tmp_path) == whole


def test_answers_that_came_with_a_failure_are_kept(tmp_path, counted):
    """Three tasks end at once, the first of them badly: two blocks are on disk."""

    class Cancelled(Executor):
        def submit(self, fn, /, block):
            future = Future()
            future.cancel() if block.number == 0 else future.set_result(fn(block))
            if block.number == 0:
                future.set_running_or_notify_cancel()
            return future

    with pytest.raises(InputError, match="workers were lost"):
        make(small(), tmp_path, Cancelled())
    assert sorted(path.name for path in (tmp_path / "blocks").glob("*.npz")) == ["000001.npz", "000002.npz"]


def test_a_full_disk_is_named_and_nothing_is_lost(tmp_path, whole, counted, monkeypatch):
    written, fsync = [], os.fsync

    def fill(handle):
        written.append(handle)
        if len(written) == 4:  # the plan, two blocks, and no room for the third
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        fsync(handle)

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", fill)
        with pytest.raises(InputError) as refused:
            make(small(), tmp_path)
    assert parts(refused).value == os.strerror(errno.ENOSPC)
    assert sorted(contents(tmp_path)) == ["blocks/000000.npz", "blocks/000001.npz", "blocks/plan.json"]
    make(small(), tmp_path)
    assert counted == [0, 1, 2, 2]
    assert contents(tmp_path) == whole


@pytest.mark.parametrize("last", [5, 6])
def test_a_disk_that_is_full_at_the_end(tmp_path, whole, counted, monkeypatch, last):
    """No room for data.npz, or for card.json: all blocks stay, and make it the next time."""
    written, fsync = [], os.fsync

    def fill(handle):
        written.append(handle)
        if len(written) == last:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        fsync(handle)

    with monkeypatch.context() as patch:
        patch.setattr(os, "fsync", fill)
        with pytest.raises(InputError, match="cannot be written"):
            make(small(), tmp_path)
    assert not (tmp_path / "card.json").exists()
    make(small(), tmp_path)
    assert counted == [0, 1, 2]
    assert contents(tmp_path) == whole


def half(folder):
    """Two of three blocks in a folder."""
    plan = Plan(small(), ask())
    solve_blocks(plan, folder, [0, 1])
    return plan


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (lambda path: path.write_bytes(path.read_bytes()[:-100]), "truncated or damaged"),
        (lambda path: path.write_bytes(b""), "truncated or damaged"),
        (lambda path: path.write_bytes(path.read_bytes()[:300] + b"\0" + path.read_bytes()[301:]), "damaged"),
        (lambda path: respoil(path, "plan", np.array("0" * 64)), "is of another plan"),
        (lambda path: respoil(path, "status", None), "lacks status"),
        (lambda path: respoil(path, "residual", np.zeros(3)), "rows instead of 128"),
    ],
)
def test_a_damaged_block_is_named_and_solved_again(tmp_path, whole, counted, capsys, spoil, words):
    half(tmp_path)
    spoil(tmp_path / "blocks" / "000001.npz")
    make(small(), tmp_path)
    told = capsys.readouterr().err
    assert "000001.npz" in told and words in told and "solved again" in told
    assert counted == [0, 1, 1, 2]
    assert contents(tmp_path) == whole


def respoil(path, name, value):
    arrays = npz.read(path)
    arrays.pop(name) if value is None else arrays.update({name: value})
    npz.write(path, arrays)


def test_a_truncated_shard_is_named_and_the_rest_is_kept(tmp_path, whole):
    plan = Plan(small(), ask())
    one, two, out = (tmp_path / name for name in ("one", "two", "out"))
    solve_blocks(plan, one, shard("1/2", plan.blocks))
    solve_blocks(plan, two, shard("2/2", plan.blocks))
    broken = two / "blocks" / "000001.npz"
    broken.write_bytes(broken.read_bytes()[:1000])
    with pytest.raises(InputError) as refused:
        merge([one, two], out)
    assert parts(refused).where == str(broken) and "truncated or damaged" in parts(refused).value
    solve_blocks(plan, two, shard("2/2", plan.blocks))  # as its advice says
    merge([two], out)
    assert contents(out) == whole


def test_a_missing_shard_is_named(tmp_path):
    half(tmp_path / "one")
    with pytest.raises(InputError) as refused:
        merge([tmp_path / "one"], tmp_path / "out")
    assert parts(refused).value == "blocks 2 of 3 are not there"
    with pytest.raises(InputError, match="No such file"):
        merge([tmp_path / "nowhere"], tmp_path / "out")


@pytest.mark.parametrize(
    ("key", "value", "words"),
    [
        ("certificate", "d" * 64, "the certificate differs: dddd"),
        ("solver", "e" * 64, "the code of the solver (digest of ancf/) differs: eeee"),
        ("versions", {"numpy": "1.0"}, "versions of packages differs"),
    ],
)
def test_shards_of_another_kind_are_refused_by_name(tmp_path, key, value, words):
    half(tmp_path / "one")
    shutil.copytree(tmp_path / "one", tmp_path / "two")
    path = tmp_path / "two" / "blocks" / "plan.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), key: value}))
    for parts_ in (["one", "two"], ["two", "one"]):
        with pytest.raises(OtherPlan) as refused:
            merge([tmp_path / name for name in parts_], tmp_path / "out")
        assert words in parts(refused).value and str(path) == parts(refused).where


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"schema": 2}'])
def test_a_plan_of_another_schema(tmp_path, text):
    half(tmp_path)
    (tmp_path / "blocks" / "plan.json").write_text(text)
    words = "this version knows 1" if text else "it is not JSON"
    with pytest.raises(InputError, match=words):
        merge([tmp_path], tmp_path / "out")
    with pytest.raises(InputError, match=words):
        make(small(), tmp_path)


def test_data_of_unknown_origin_are_left_alone(tmp_path):
    (tmp_path / "data.npz").write_text("somebody's")
    with pytest.raises(InputError, match="unknown origin"):
        make(small(), tmp_path)
    assert contents(tmp_path) == {"data.npz": b"somebody's"}


def test_a_folder_with_other_data_is_left_alone(tmp_path):
    half(tmp_path)
    before = contents(tmp_path)
    with pytest.raises(OtherPlan, match="the design differs"):
        make(small(seed=8), tmp_path)
    assert contents(tmp_path) == before
    make(small(), tmp_path)
    before = contents(tmp_path)
    with pytest.raises(OtherPlan, match="the design differs"):
        make(small(seed=8), tmp_path)
    with pytest.raises(OtherPlan, match="the design differs"):
        finished(Plan(small(count=3), ask()), tmp_path)
    assert contents(tmp_path) == before


def test_a_worker_with_other_code_is_refused(tmp_path, monkeypatch):
    solve = sweep.solve
    monkeypatch.setattr(sweep, "solve", lambda block: replace(solve(block), solver="0" * 64))
    with pytest.raises(InputError) as refused:
        make(small(), tmp_path)
    assert "digest of ancf/ 000000000000 there" in parts(refused).value
    assert not list((tmp_path / "blocks").glob("*.npz"))


def test_a_bug_in_a_worker_is_no_lost_worker(tmp_path, monkeypatch):
    def fail(block):
        raise ZeroDivisionError

    monkeypatch.setattr(sweep, "solve", fail)
    with ThreadPoolExecutor(1) as executor, pytest.raises(ZeroDivisionError):
        make(small(), tmp_path, executor)
