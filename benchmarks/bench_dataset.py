"""The paper's data set of 1520 poses, in this process and as the command in a process of its own."""

import shutil
import subprocess
import sys

import pytest

from surrogate.design import preset
from surrogate.gate import Gate
from surrogate.plan import Plan
from surrogate.sweep import assemble, sweep
from validation.certificate import SHIPPED, load


@pytest.mark.parametrize("name", ["paper", "sobol"])
def bench_preset(benchmark, tmp_path, name):
    """Solved, judged by the domain of the shipped certificate, written (asked: at most 3 s)."""

    def make():
        plan = Plan(preset(name), Gate(load(SHIPPED)))
        sweep(plan, tmp_path, range(plan.blocks))
        assemble(plan, tmp_path)

    def clear():
        shutil.rmtree(tmp_path)
        tmp_path.mkdir()

    benchmark.pedantic(make, setup=clear, rounds=5, warmup_rounds=1)


@pytest.mark.parametrize("workers", [1, 2])
def bench_command(benchmark, tmp_path, workers):
    """`ancf dataset --preset paper`, start and certificate included (asked: at most 6 s)."""
    options = ["--preset", "paper", "--workers", str(workers), "--out", str(tmp_path / "out")]
    command = [sys.executable, "-m", "ancf.cli", "dataset", *options, "--allow-unvalidated"]

    def run():
        assert subprocess.run(command, capture_output=True).returncode == 0

    def clear():
        shutil.rmtree(tmp_path / "out", ignore_errors=True)

    benchmark.pedantic(run, setup=clear, rounds=3, warmup_rounds=1)
