"""Architectures, the stacked training, and what trained models reach (issue: numbers)."""

from __future__ import annotations

import numpy as np
import pytest

from surrogate.architecture import (
    MAIN_CNN,
    PUBLISHED_SIZES,
    TABLE_1,
    Architecture,
    Convolution,
    Dense,
    Pooling,
)
from surrogate.arm import paper_arm
from surrogate.baselines import ClosedForm, Polynomial, RadialBasis
from surrogate.equivariant import RESIDUAL_MLP, EquivariantNetwork
from surrogate.evaluate import LeakWarning, designs, leak_guard, score
from surrogate.fit import fit
from surrogate.inverse import exact_inverse, gauss_newton
from surrogate.networks import Normaliser, PoseNetwork, image
from surrogate.problem import box_design, solved_problem

torch = pytest.importorskip("torch", reason="torch is not installed (extra `surrogate`)")

# The arm of the preset `paper`, on fewer and better elements: as thick, and its solves are cheaper.
ARM = paper_arm(elements=4, element="3333")
BOX = np.outer(np.ones(3), [-0.02, 0.02])  # N m, the range of the presets


@pytest.fixture(scope="module")
def sobol():
    return solved_problem(ARM, box_design(BOX, 1520, 0), {}, "sobol")


@pytest.fixture(scope="module")
def swept():
    """4 x 19 x 20, as the preset `paper`."""
    levels = [np.linspace(-0.02, 0.02, n) for n in (4, 19, 20)]
    moments = np.stack(np.meshgrid(*levels, indexing="ij"), axis=-1).reshape(-1, 3)
    return solved_problem(ARM, moments, {}, "paper")


def test_table_1_has_the_published_sizes():
    assert tuple(a.parameters for a in TABLE_1) == PUBLISHED_SIZES == (259, 187, 199, 651, 2515)


@pytest.mark.parametrize("architecture", [*TABLE_1, MAIN_CNN], ids=lambda a: a.name)
def test_the_forward_pass_is_that_of_torch_layers(architecture: Architecture):
    """torch's own Conv2d, AvgPool2d and Linear, on the same weights."""
    rng = np.random.default_rng(0)
    weights = architecture.unpack(rng.normal(size=architecture.parameters))
    x = rng.normal(size=(5, 12))
    t, left = torch.from_numpy(x).reshape(5, 1, 3, 4), iter(weights)
    for number, layer in enumerate(architecture.layers):
        last = number == len(architecture.layers) - 1
        if isinstance(layer, Pooling):
            t = torch.nn.functional.avg_pool2d(t, (layer.rows, layer.columns))
            continue
        W, b = (torch.from_numpy(np.ascontiguousarray(a)) for a in next(left))
        if isinstance(layer, Convolution):
            kernel = W.T.reshape(layer.kernels, layer.size, layer.size, -1).permute(0, 3, 1, 2)
            t = torch.nn.functional.conv2d(t, kernel, b)
        else:
            # Flattened with the channels last, as TensorFlow does.
            flat = t if t.dim() == 2 else t.permute(0, 2, 3, 1).reshape(5, -1)
            t = flat @ W + b
        t = t if last else torch.tanh(t)
    np.testing.assert_allclose(architecture.forward(weights, x), t.numpy(), atol=1e-12)


SMALL = Architecture("small", (Convolution(3), Pooling(1, 3), Dense(4), Dense(3)))


def rows_of(seed, sets, n=70):
    from surrogate.training import Rows

    rng = np.random.default_rng(seed)
    return Rows(rng.normal(size=(sets, n, 12)), rng.normal(size=(sets, n, 3)))


def test_a_stack_trains_each_replica_as_if_it_were_alone():
    from surrogate.training import Rows, Schedule, train

    schedule, rows, check = Schedule(3, 32, double=True), rows_of(1, 3), rows_of(2, 3, 10)
    together = train([SMALL, TABLE_1[0]], rows, check, schedule, [4, 5, 6])
    for i, seed in enumerate((4, 5, 6)):
        alone_rows, alone_check = (Rows(r.x[i : i + 1], r.y[i : i + 1]) for r in (rows, check))
        for j, architecture in enumerate((SMALL, TABLE_1[0])):
            (alone,) = train([architecture], alone_rows, alone_check, schedule, [seed])
            np.testing.assert_allclose(together[j].flat[i], alone.flat[0], atol=1e-10)
            np.testing.assert_allclose(together[j].validation_loss[i], alone.validation_loss[0], rtol=1e-9)


def test_a_step_is_that_of_torch_adam():
    from surrogate.training import Schedule, _error, _start, stacked_forward, train

    rows, batch, epochs = rows_of(3, 1), 32, 4
    (found,) = train([SMALL], rows, rows, Schedule(epochs, batch, double=True), [7])
    flat = _start(SMALL, [7], torch.float64)
    optimiser = torch.optim.Adam([flat], lr=1e-2, eps=1e-7)
    rng, run = np.random.default_rng([7, 1]), stacked_forward(SMALL)
    X, Y = torch.from_numpy(rows.x), torch.from_numpy(rows.y)
    for _ in range(epochs):
        order = rng.permutation(70)
        for begin in range(0, 70, batch):
            optimiser.zero_grad()
            part = order[begin : begin + batch]
            _error(run, SMALL, flat, X[:, part], Y[:, part]).sum().backward()
            optimiser.step()
    # TensorFlow's epsilon stands beside the uncorrected root; at these sizes that is no difference.
    np.testing.assert_allclose(found.flat, flat.detach().numpy(), atol=1e-6)


def test_equal_seeds_give_equal_bytes(sobol):
    first, again, other = (fit(sobol, "cnn", [seed], 2).models[0] for seed in (3, 3, 4))
    assert (
        isinstance(first, PoseNetwork) and isinstance(again, PoseNetwork) and isinstance(other, PoseNetwork)
    )
    assert first.flat.tobytes() == again.flat.tobytes() != other.flat.tobytes()


def test_the_normaliser_sees_training_rows_only(sobol):
    (network,) = fit(sobol, "cnn", [0], 1).models
    assert isinstance(network, PoseNetwork)
    x = image(sobol.train.poses)
    np.testing.assert_array_equal(network.normaliser.mean, x.mean(axis=0))
    np.testing.assert_allclose(network.normaliser(x).std(axis=0), 1.0)
    assert (Normaliser.of(np.ones((4, 2))).deviation == 1.0).all()


def test_the_symmetry_of_the_arm_holds_whatever_the_weights(sobol):
    """Turned about its axis, and mirrored: poses Q r, Q J diag(..), moments det(Q) Q M (an axial vector)."""
    flat = np.random.default_rng(5).normal(size=RESIDUAL_MLP.parameters)
    network = EquivariantNetwork(ARM, flat, np.array([1.0, 2.0]), 0.1)
    body = ARM.body_poses(sobol.test.poses[:40])
    v = ARM.body_moments(network.predict(sobol.test.poses[:40]))
    a = 0.7
    turn = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    for Q in (turn, np.diag([1.0, 1.0, -1.0])):
        moved = Q @ body
        # The section's own axes turn with the world: gradients by the same material directions.
        moved[..., 1:] = moved[..., 1:] @ Q.T
        A_o, base = ARM.rod.base.rotation, ARM.rod.base.position
        moved[..., 0] *= ARM.length
        poses = A_o @ moved
        poses[..., 0] += base
        np.testing.assert_allclose(
            ARM.body_moments(network.predict(poses)), np.linalg.det(Q) * v @ Q.T, atol=1e-10
        )
    np.testing.assert_allclose(
        network.predict(sobol.test.poses[7]), network.predict(sobol.test.poses[7:8])[0], atol=1e-14
    )


def test_the_residual_that_is_trained_is_the_one_that_answers():
    from surrogate.equivariant import _stacked, combined
    from surrogate.training import _unpack

    rng = np.random.default_rng(8)
    flat, x = rng.normal(size=(2, RESIDUAL_MLP.parameters)), rng.normal(size=(2, 9, 5))
    found = _stacked(RESIDUAL_MLP)(_unpack(RESIDUAL_MLP, torch.from_numpy(flat)), torch.from_numpy(x))
    for k in range(2):
        h = RESIDUAL_MLP.forward(RESIDUAL_MLP.unpack(flat[k]), x[k, :, :2])
        np.testing.assert_allclose(found[k].numpy(), combined(h, x[k]), atol=1e-13)


def test_the_best_network_and_the_polynomial_meet_their_numbers(sobol):
    """Issue: network at most .03 % mean, .1 % p95, .5 % max; polynomial with 400 solves at most .01 % mean;
    one Gauss-Newton step at most 1e-3 %, two to solver tolerance, on 100 % of the box.
    """
    tests, deviation = designs(sobol, 256), sobol.train.moments.std(axis=0)
    fitted = fit(sobol, "equivariant", [0, 1], 60)
    assert fitted.validation_loss is not None and fitted.validation_loss.shape == (2, 60)
    network = fitted.models[0]
    found = score(network.predict, ARM, tests.off_grid, deviation)
    assert found.unsolved == 0
    assert found.tip.mean < 0.03 and found.tip.p95 < 0.1 and found.tip.max < 0.5
    polynomial = Polynomial.fit(ARM, sobol.train.taken(np.arange(400)))
    assert polynomial.coefficients.shape == (84, 3)  # 252 numbers
    assert score(polynomial.predict, ARM, tests.off_grid, deviation).tip.mean < 0.01
    assert score(RadialBasis.fit(ARM, sobol.train).predict, ARM, tests.off_grid, deviation).tip.mean < 0.01
    assert score(ClosedForm(ARM).predict, ARM, tests.off_grid, deviation).tip.mean < 0.2  # (R/L)^2 (M L/EI)^2
    wanted = tests.off_grid.poses
    guess = network.predict(wanted)
    for steps, limit in ((1, 1e-3), (2, 1e-8)):  # % of L; 1e-8 is the tolerance of the solver
        poses = ARM.solve(gauss_newton(ARM, wanted, guess, steps)).poses
        away = np.linalg.norm(poses[:, :, 0] - wanted[:, :, 0], axis=1)
        assert 100.0 * away.max() / ARM.length < limit
    inverse = exact_inverse(ARM, wanted, guess=guess, bounds=BOX)
    assert inverse.reachable.all() and inverse.steps.max() <= 3


def test_the_cnn_of_the_paper_and_the_leak_of_its_design(sobol, swept):
    """Issue: R^2 >= .995 on the test split; on Sobol samples off the grid at most 3 % of L, trajectory at
    most 2.5 %; the guard fires on the swept design. A third of the 500 epochs is enough for it.
    """
    found = {}
    for problem in (sobol, swept):
        (network,) = fit(problem, "cnn", [0], 160).models
        tests, deviation = designs(problem, 256), problem.train.moments.std(axis=0)
        named = {name: getattr(tests, name) for name in ("split", "off_grid", "trajectory")}
        found[problem.name] = {k: score(network.predict, ARM, s, deviation) for k, s in named.items()}
    for scores in found.values():
        assert scores["split"].r2 > 0.995
    good, leaky = found["sobol"], found["paper"]
    assert good["off_grid"].tip.mean < 3.0 and good["trajectory"].tip.mean < 2.5
    assert leak_guard(good["split"], good["off_grid"], "cnn") == ""
    with pytest.warns(LeakWarning, match="leaks the design"):
        assert "trust the former" in leak_guard(leaky["split"], leaky["off_grid"], "cnn")
