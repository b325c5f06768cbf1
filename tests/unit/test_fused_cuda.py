"""The fused kernel on a GPU: in numba's simulator, compiled for one that is not there, and on one that is."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import ancf
from ancf import fused
from ancf.batch import LARGE
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.scene import Moment, Rod, Scene
from ancf.sections import Circle
from tests.property.test_fused_scenes import AGREE, loads_of, random_scene
from validation.random_rods import RngDraws

pytest.importorskip("numba")

ROOT = Path(__file__).parents[2]
TIP = Scene(
    (Rod("rod", 1.0, 8, Circle(0.025), SaintVenantKirchhoff(1e6, 0.3)),),
    moments=(Moment("rod", 1.0, np.array([0.0, 0.0, 1.0])),),
)
UNIT = Model(TIP).rods[0].bending_stiffness  # E I/L
# Seeds whose scenes have a moment and a force; weight, line load and pin; a free-section clamp and a moment;
# followers; one element.
RANDOM = (("3243", 29), ("3333", 11), ("3333", 10), ("3243", 2), ("3333", 37))
ROWS = 2

no_gpu = pytest.mark.skipif(bool(fused.no_gpu()), reason=fused.no_gpu())


def moments_of(rows: int, seed: int = 0):
    """Tip moments of issue 5's batch (rows, 3)."""
    return np.random.default_rng(seed).uniform(-1.0, 1.0, (rows, 3)) * [0.8, 3.0, 3.0] * UNIT


def random_problems():
    """Models that the kernel takes, with a few rows of loads each."""
    for element, seed in RANDOM:
        scene = random_scene(RngDraws(np.random.default_rng(seed)), element)
        model = Model(scene)
        assert not fused.unsupported(model), (element, seed, fused.unsupported(model))
        share = np.linspace(0.2, 0.8, ROWS).reshape(-1, 1, 1)
        yield model, *(share * values for values in loads_of(scene, ROWS))


def solve_in_the_simulator(path: str) -> None:
    """What the test below runs in a process of its own: with the compilers of numba off."""
    from ancf.fused_cuda import solve_rows

    np.seterr(all="ignore")
    found = [solve_rows(*problem) for problem in random_problems()]
    batch = ancf.solve_batch(TIP, moments_of(2), engine="cuda")
    assert batch.engine == "cuda"
    np.savez(
        path,
        *(result.q for result in found),
        converged=[result.converged for result in found],
        iterations=[result.iterations for result in found],
        batch=batch.q,
    )


def test_the_simulator_finds_what_the_cpu_finds(tmp_path):
    """issue 5: to 1e-11 on random scenes. The kernel is launched as on a GPU and runs as Python."""
    environment = os.environ | {"NUMBA_ENABLE_CUDASIM": "1", "NUMBA_DISABLE_JIT": "1"}
    path = str(tmp_path / "found.npz")
    code = f"from tests.unit.test_fused_cuda import solve_in_the_simulator as f; f({path!r})"
    subprocess.run([sys.executable, "-c", code], env=environment, cwd=ROOT, check=True)
    simulated = np.load(path)
    for index, (model, moments, forces) in enumerate(random_problems()):
        expected = fused.solve_rows(model, moments, forces)
        assert expected.converged.any()
        np.testing.assert_array_equal(simulated["converged"][index], expected.converged)
        np.testing.assert_array_equal(simulated["iterations"][index], expected.iterations)
        for q, other in zip(simulated[f"arr_{index}"], expected.q, strict=True):
            assert model.largest_motion(q - other) <= AGREE
    batch = ancf.solve_batch(TIP, moments_of(2), engine="fused")
    assert batch.model.largest_motion(np.abs(simulated["batch"] - batch.q).max(axis=0)) <= AGREE


def test_it_compiles_for_a_gpu_in_double_precision(monkeypatch):
    """To PTX, which needs NVVM but no GPU."""
    pytest.importorskip("numba_cuda", reason="numba-cuda (extra `cuda`) is not installed")
    from numba import cuda, typeof
    from numba.cuda import dispatcher
    from numba.cuda.cudadrv import nvvm

    try:
        nvvm.NVVM()
    except Exception as missing:
        pytest.skip(f"NVVM is not installed: {missing}")
    from ancf import fused_cuda
    from ancf.fused_lane import tile_arrays

    class Hopper:
        compute_capability = (9, 0)

    # The functions that a kernel calls are compiled for the GPU that is present.
    monkeypatch.setattr(dispatcher, "get_current_device", Hopper)
    model = Model(TIP)
    tables = fused.tables_of(model, fused.FEW)
    moments = moments_of(2)[:, None]
    problem = fused.problem_of(model, moments, np.empty((2, 0, 3)), None, None, tables.floor, 25)
    found = fused.Found(np.empty((2, model.n)), np.zeros(2, bool), np.empty(2), np.zeros(2, np.int64))
    arrays = (problem, found, model.unit, *tables[:6], *tile_arrays(tables, 1, np.zeros))
    ptx, _ = cuda.compile_ptx(fused_cuda.kernel, tuple(map(typeof, arrays)), cc=(9, 0))
    assert ptx.count(".entry") == 1 and "fma.rn.f64" in ptx
    assert "f32" not in ptx  # float64 everywhere


@no_gpu
@pytest.mark.parametrize("rows", [1, 1520, 20_000])
def test_a_gpu_finds_what_the_cpu_finds(rows):
    """issue 5: to 1e-11, no sample lost."""
    moments = moments_of(rows)
    found = ancf.solve_batch(TIP, moments, engine="cuda")
    expected = ancf.solve_batch(TIP, moments, engine="fused")
    assert found.engine == "cuda" and np.all(found.status == "converged")
    np.testing.assert_array_equal(found.iterations, expected.iterations)
    assert found.model.largest_motion(np.abs(found.q - expected.q).max(axis=0)) <= AGREE


@no_gpu
def test_a_gpu_solves_random_scenes():
    """issue 5: to 1e-11."""
    from ancf.fused_cuda import solve_rows

    for model, moments, forces in random_problems():
        found, expected = (solve(model, moments, forces) for solve in (solve_rows, fused.solve_rows))
        np.testing.assert_array_equal(found.converged, expected.converged)
        for q, other in zip(found.q, expected.q, strict=True):
            assert model.largest_motion(q - other) <= AGREE


def test_a_gpu_that_is_not_there_is_said(monkeypatch):
    monkeypatch.setattr(fused, "no_gpu", lambda: "No CUDA GPU and driver were found.")
    with pytest.raises(ancf.InputError) as refused:
        ancf.solve_batch(TIP, moments_of(2), engine="cuda")
    message = refused.value.message
    assert "'cuda'" in message.what and "No CUDA GPU" in message.cause
    assert all((message.what, message.where, message.value, message.cause, message.advice))


def test_only_large_batches_look_for_a_gpu(monkeypatch):
    from ancf.batch import _engine

    model = Model(TIP)
    for reason, large in (("", "cuda"), ("none", "fused")):
        monkeypatch.setattr(fused, "no_gpu", lambda reason=reason: reason)
        assert _engine(model, "auto", LARGE) == large
        assert _engine(model, "auto", LARGE - 1) == "fused"
        assert _engine(model, "fused", LARGE) == "fused"
