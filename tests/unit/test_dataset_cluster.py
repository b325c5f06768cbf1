"""Dask: a real scheduler and two workers in processes of their own, one of which is killed half-way."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ancf.cli import main
from ancf.errors import InputError
from surrogate import executors, gate, sweep
from surrogate.executors import opened
from surrogate.sweep import make
from tests.datasets import small, stale, valid

pytest.importorskip("distributed")

ROOT = Path(__file__).parents[2]
WAIT = 60.0  # seconds for a process of the cluster to come up on a busy machine


@pytest.fixture(autouse=True)
def _certified(monkeypatch):
    monkeypatch.setattr(gate, "verify", valid())


class Processes:
    """A scheduler and its workers."""

    def __init__(self, folder):
        self.folder, self.running = folder, []
        self.environment = {
            **os.environ, "PYTHONPATH": os.pathsep.join([str(ROOT), *filter(None, sys.path)]),
            "OPENBLAS_NUM_THREADS": "1",
        }  # fmt: skip
        told = folder / "scheduler.json"
        self.scheduler = self.start(
            "dask_scheduler", "--port", "0", "--no-dashboard", "--scheduler-file", str(told)
        )
        self.address = self.until(lambda: json.loads(told.read_text())["address"])

    def start(self, program, *args):
        command = [sys.executable, "-m", f"distributed.cli.{program}", *args, "--host", "127.0.0.1"]
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        process = subprocess.Popen(command, env=self.environment, cwd=self.folder, **quiet)
        self.running.append(process)
        return process

    def worker(self, name):
        options = ("--name", name, "--nthreads", "1", "--no-nanny", "--no-dashboard")
        return self.start("dask_worker", self.address, *options, "--local-directory", str(self.folder))

    def until(self, ask):
        """The answer, as soon as there is one."""
        last = time.monotonic() + WAIT
        while True:
            try:
                if answer := ask():
                    return answer
            except (OSError, ValueError, KeyError):
                pass
            assert time.monotonic() < last, "the cluster does not come up"
            time.sleep(0.1)

    def end(self):
        for process in self.running:
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path_factory):
    found = Processes(tmp_path_factory.mktemp("cluster"))
    yield found
    found.end()


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_a_worker_is_killed_half_way_and_the_bytes_are_the_same(cluster, tmp_path, monkeypatch):
    """One of two workers stands still with tasks in its hands, dies, and the other one does them."""
    design = small(count=1500)
    make(design, tmp_path / "alone")
    first, second = cluster.worker("first"), cluster.worker("second")
    assert cluster.until(lambda: _count(cluster.address) == 2)
    command = ["dataset", "--count", "300", "--allow-unvalidated", "--out"]
    assert main([*command, str(tmp_path / "one"), "--scheduler", cluster.address]) == 0
    assert main([*command, str(tmp_path / "two")]) == 0
    assert contents(tmp_path / "one") == contents(tmp_path / "two")
    with opened(scheduler=cluster.address) as executor:
        address = {pid: address for address, pid in executor.client.run(os.getpid).items()}
        assert set(address) == {first.pid, second.pid}
        first.send_signal(signal.SIGSTOP)
        held = []

        def kill(done, count):
            if done == 4:
                held.extend(executor.client.processing()[address[first.pid]])
                first.kill()

        make(design, tmp_path / "cluster", executor, progress=kill)
        assert held  # it did have work that was lost with it
        assert set(executor.client.nthreads()) == {address[second.pid]}
    assert contents(tmp_path / "cluster") == contents(tmp_path / "alone")

    # The last worker dies too: named, kept, and gone on with elsewhere.
    monkeypatch.setattr(sweep, "SILENCE", 0.5)
    with opened(scheduler=cluster.address) as executor, pytest.raises(InputError) as refused:
        make(design, tmp_path / "lost", executor, progress=lambda done, count: done == 2 and second.kill())
    message = refused.value.message
    assert message.value == f"no worker is left at {cluster.address}" and "nothing is lost" in message.advice
    kept = {path.name: path.read_bytes() for path in (tmp_path / "lost" / "blocks").glob("*.npz")}
    assert len(kept) >= 2
    make(design, tmp_path / "lost")
    assert contents(tmp_path / "lost") == contents(tmp_path / "alone")


def _count(address):
    from distributed import Client

    with Client(address, timeout="1 s", set_as_default=False) as client:
        return len(client.nthreads())


def test_a_scheduler_without_workers_and_one_that_is_gone(cluster, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(gate, "verify", stale)
    monkeypatch.setattr(executors, "PATIENCE", "1 s")
    command = [
        "dataset",
        "--out",
        str(tmp_path / "out"),
        "--allow-unvalidated",
        "--scheduler",
        cluster.address,
    ]
    assert main(command) == 2
    assert "The scheduler has no workers" in capsys.readouterr().err
    cluster.scheduler.kill()
    cluster.scheduler.wait()
    assert main(command) == 2
    told = capsys.readouterr().err
    assert told.startswith("The scheduler does not answer.") and f"--scheduler {cluster.address}" in told
    assert "Traceback" not in told
    assert main([*command[:-1], "nonsense://"]) == 2


@pytest.mark.parametrize("address", ["nonsense", "foo://host:1", "tcp://host:port"])
def test_an_address_that_is_none_leaves_no_client_behind(address, tmp_path):
    """In a process of its own: what is half made cries when Python ends."""
    command = [sys.executable, "-m", "ancf.cli", "dataset", "--out", str(tmp_path / "out")]
    ended = subprocess.run(
        [*command, "--allow-unvalidated", "--scheduler", address], capture_output=True, text=True, timeout=60,
        env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )  # fmt: skip
    assert ended.returncode == 2 and not (tmp_path / "out").exists()
    assert ended.stderr.startswith("The scheduler does not answer.")
    assert "Traceback" not in ended.stderr
