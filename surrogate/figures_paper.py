"""Figures 4 to 11 of the paper, from our numbers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from surrogate.architecture import Architecture, Convolution, Dense, Pooling
from surrogate.crossval import Table
from surrogate.figures import BLUE, FRAME_COLOURS, GREY, RED, new_figure
from surrogate.fit import Fit
from surrogate.networks import PoseNetwork
from surrogate.problem import Problem
from surrogate.tracking import Track

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Floats = NDArray[np.float64]

COMPONENTS = ("x", "y", "z")
FRAMES, ARROW = 12, 0.04  # frames drawn along a set of poses, and the length of their axes over L


def workspace(problem: Problem) -> Figure:
    """Fig. 4: tips of all samples, with frames at some of them."""
    figure = new_figure(6.0, 5.0)
    axes: Any = figure.add_subplot(projection="3d")
    poses = problem.all.poses
    axes.scatter(*poses[:, :, 0].T, s=2, color=GREY)
    _frames(axes, poses[:: max(1, len(poses) // 40)], ARROW * problem.arm.length)
    _space(axes, f"{len(poses)} samples of the workspace")
    return figure


def pose_image(problem: Problem) -> Figure:
    """Fig. 5: a pose as the 3 x 4 image that the networks see."""
    figure = new_figure(4.5, 3.2)
    axes = figure.add_subplot()
    pose = problem.train.poses[0].copy()
    shown = axes.imshow(pose, cmap="RdBu", vmin=-1.0, vmax=1.0)
    for row, column in np.ndindex(3, 4):
        axes.text(column, row, f"{pose[row, column]:.2f}", ha="center", va="center", fontsize=9)
    axes.set_xticks(range(4), ["r [m]", "r_x", "r_y", "r_z"])
    axes.set_yticks(range(3), ["X", "Y", "Z"])
    axes.set_title("A tip pose, before its z-score")
    figure.colorbar(shown)
    return figure


def network(architecture: Architecture) -> Figure:
    """Fig. 6: layers of a network with the shapes between them."""
    figure = new_figure(8.0, 2.2)
    axes = figure.add_subplot()
    axes.axis("off")
    boxes = ["pose\n3 x 4 x 1"]
    for stage in architecture.stages:
        layer, shape = stage.layer, " x ".join(map(str, stage.out_shape))
        if isinstance(layer, Convolution):
            text = f"convolution\n{layer.kernels} of {layer.size} x {layer.size}, tanh"
        elif isinstance(layer, Pooling):
            text = f"mean pooling\n{layer.rows} x {layer.columns}"
        else:
            assert isinstance(layer, Dense)
            text = f"dense {layer.units}\n{'linear' if stage is architecture.stages[-1] else 'tanh'}"
        boxes.append(f"{text}\n{shape}")
    for place, text in enumerate(boxes):
        axes.text(
            place, 0.0, text, ha="center", va="center", fontsize=9,
            bbox={"boxstyle": "round", "facecolor": "white", "edgecolor": BLUE},
        )  # fmt: skip
        if place:
            axes.annotate("", (place - 0.38, 0.0), (place - 0.62, 0.0), arrowprops={"arrowstyle": "->"})
    axes.set_xlim(-0.6, len(boxes) - 0.4)
    axes.set_ylim(-1.0, 1.0)
    axes.set_title(f"{architecture.name}: {architecture.parameters} parameters")
    return figure


def losses(main: Fit) -> Figure:
    """Fig. 7: training and validation loss of the main CNN."""
    figure = new_figure(6.0, 4.0)
    axes = figure.add_subplot()
    assert main.training_loss is not None and main.validation_loss is not None
    axes.semilogy(main.training_loss[0], color=BLUE, label="training")
    axes.semilogy(main.validation_loss[0], color=RED, linewidth=0.8, label="validation")
    axes.set_xlabel("epoch")
    axes.set_ylabel("MSE, units$^2$")
    axes.legend()
    return figure


def test_samples(model: PoseNetwork, problem: Problem, count: int) -> Figure:
    """Fig. 8: target and estimate of the first test samples, and the absolute error with its mean."""
    figure = new_figure(10.0, 7.0)
    axes = figure.subplots(3, 2, sharex=True)
    target = 1e3 * problem.test.moments
    estimate = 1e3 * model.predict(problem.test.poses)
    error = np.abs(estimate - target)
    for k, name in enumerate(COMPONENTS):
        axes[k, 0].plot(target[:count, k], color=GREY, label="target")
        axes[k, 0].plot(estimate[:count, k], ".", markersize=3, color=BLUE, label="estimate")
        axes[k, 0].set_ylabel(f"M{name}, N mm")
        axes[k, 1].plot(error[:count, k], color=BLUE, linewidth=0.8)
        axes[k, 1].axhline(error[:, k].mean(), color=RED, label=f"mean {error[:, k].mean():.2g}")
        axes[k, 1].set_ylabel("absolute error, N mm")
        axes[k, 1].legend(loc="upper right", fontsize=8)
    axes[0, 0].legend(loc="upper right", fontsize=8)
    for axis in axes[2]:
        axis.set_xlabel("test sample")
    return figure


def reference(found: Track, problem: Problem) -> Figure:
    """Fig. 9: the reference trajectory among the samples, and two projections."""
    figure = new_figure(11.0, 4.0)
    tips, path = problem.all.poses[:, :, 0], found.wanted[:, :, 0]
    axes: Any = figure.add_subplot(1, 3, 1, projection="3d")
    axes.scatter(*tips.T, s=1, color=GREY)
    axes.plot(*path.T, color="orange", linewidth=2)
    _frames(axes, found.wanted[:: len(path) // FRAMES], ARROW * problem.arm.length)
    _space(axes, "eq. 47 (corrected) and 48")
    for place, (i, j) in enumerate(((0, 2), (0, 1)), start=2):
        flat = figure.add_subplot(1, 3, place)
        flat.plot(tips[:, i], tips[:, j], ".", markersize=1, color=GREY)
        flat.plot(path[:, i], path[:, j], color="orange", linewidth=2)
        flat.set_xlabel(f"{'XYZ'[i]}, m")
        flat.set_ylabel(f"{'XYZ'[j]}, m")
        flat.set_aspect("equal")
    return figure


def tracking(found: Track) -> Figure:
    """Fig. 10: where ANCF ends with the moments of the model, and these moments."""
    figure = new_figure(11.0, 7.0)
    axes = figure.subplots(3, 2, sharex=True)
    at = np.linspace(0.0, 1.0, len(found.wanted))
    for k, name in enumerate(COMPONENTS):
        axes[k, 0].plot(at, found.wanted[:, k, 0], color="orange", linewidth=3, label="reference (CCM)")
        axes[k, 0].plot(at, found.poses[:, k, 0], color=BLUE, label="model, through ANCF")
        axes[k, 0].plot(at, found.exact_poses[:, k, 0], ":", color="black", label="exact inverse")
        axes[k, 0].set_ylabel(f"{'XYZ'[k]} of the tip, m")
        axes[k, 1].plot(at, 1e3 * found.thin_moments[:, k], color="orange", linewidth=3, label="thin arm")
        axes[k, 1].plot(at, 1e3 * found.moments[:, k], color=BLUE, label="model")
        axes[k, 1].plot(at, 1e3 * found.exact_moments[:, k], ":", color="black", label="exact inverse")
        axes[k, 1].set_ylabel(f"M{name}, N mm")
    for column in (0, 1):
        axes[0, column].legend(fontsize=8)
        axes[2, column].set_xlabel("along the trajectory")
    tip = found.as_dict()["tip_percent"]
    figure.suptitle(f"tip error: mean {tip['mean']:.3g} %, max {tip['max']:.3g} % of L")
    return figure


def folds(table: Table) -> Figure:
    """Fig. 11: training losses of all folds, and mean and deviation of the error left out."""
    figure = new_figure(11.0, 4.5)
    curves, bars = figure.subplots(1, 2)
    sizes = [row.architecture.parameters for row in table.rows]
    place = np.arange(len(table.rows))
    for row in table.rows:
        shade = 0.25 + 0.75 * sorted(sizes).index(row.architecture.parameters) / (len(sizes) - 1)
        colour = (0.65 * shade + 0.35, 0.85 * (1.0 - shade), 0.85 * (1.0 - shade))
        for number, loss in enumerate(row.training_loss):
            curves.semilogy(
                loss, color=colour, linewidth=0.8, label=row.architecture.name if number == 0 else None
            )
    curves.set_xlabel("epoch")
    curves.set_ylabel("training MSE, units$^2$")
    curves.legend(fontsize=8)
    means, deviations = ([f(row.mse) for row in table.rows] for f in (np.mean, np.std))
    bars.bar(place - 0.2, means, 0.4, yerr=deviations, color=BLUE, label="here, mean and deviation")
    bars.bar(place + 0.2, [row.published_mse for row in table.rows], 0.4, color=GREY, label="published")
    bars.set_xticks(place, [f"{k + 1}\n({size})" for k, size in enumerate(sizes)])
    bars.set_ylabel("MSE left out, units$^2$")
    bars.legend(fontsize=8)
    return figure


def _frames(axes: Any, poses: Floats, size: float) -> None:
    """Section axes as arrows: x red, y green, z blue."""
    for column, colour in zip((1, 2, 3), FRAME_COLOURS, strict=True):
        axes.quiver(*poses[:, :, 0].T, *(size * poses[:, :, column]).T, color=colour, linewidth=0.8)


def _space(axes: Any, title: str) -> None:
    axes.set_xlabel("X, m")
    axes.set_ylabel("Y, m")
    axes.set_zlabel("Z, m")
    axes.set_aspect("equal")
    axes.set_title(title, fontsize=10)
