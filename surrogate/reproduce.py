"""Sections 3 and 4 of the paper in one go: figures 4 to 11 and table 1, beside the published values."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from surrogate.architecture import MAIN_CNN
from surrogate.crossval import EPOCHS, TABLE_RANGE, cross_validate, rescaled
from surrogate.fit import MAIN_EPOCHS, Fit, fit
from surrogate.networks import PoseNetwork, moment_unit
from surrogate.problem import Problem
from surrogate.published import DECISIONS, FIGURES
from surrogate.tracking import track_model
from surrogate.trajectory import arc_rotation

SHOWN = 100  # test samples of fig. 8
TABLE_SEEDS = (0, 1, 2, 3, 4)


def reproduce(
    problem: Problem, folder: Path, seed: int = 0, epochs: int = MAIN_EPOCHS, table_epochs: int = EPOCHS
) -> dict[str, Any]:
    """Train, follow the trajectory, cross-validate, draw; returns the record of it all."""
    from surrogate import figures_paper as figures
    from surrogate.figures import save_figure

    main = fit(problem, "cnn", [seed], epochs)
    (network,) = main.models
    assert isinstance(network, PoseNetwork)
    followed = track_model(network, problem.arm, problem.bounds, problem.certificate)
    table = cross_validate(rescaled(problem), seeds=TABLE_SEEDS, epochs=table_epochs)
    own = cross_validate(problem, epochs=table_epochs)
    for name, figure in {
        "fig4": figures.workspace(problem),
        "fig5": figures.pose_image(problem),
        "fig6": figures.network(MAIN_CNN),
        "fig7": figures.losses(main),
        "fig8": figures.test_samples(network, problem, SHOWN),
        "fig9": figures.reference(followed, problem),
        "fig10": figures.tracking(followed),
        "fig11": figures.folds(table),
    }.items():
        stamp = table.certificate if name == "fig11" else problem.certificate
        save_figure(figure, folder / f"{name}.png", stamp)
    record = {
        "schema": 1,
        "data": problem.name,
        "certificate": problem.certificate,
        "main_cnn": _main(network, main, problem),
        "trajectory": {k: v for k, v in followed.as_dict().items() if k.endswith(("percent", "degrees"))},
        "printed_eq47": _printed(),
        "table_1": table.as_dict(),
        "table_1_range_of_the_data": own.as_dict(),
        "decisions": [dict(zip(("item", "paper", "here"), row, strict=True)) for row in DECISIONS],
    }
    return {**record, "figures": _figures(record, problem)}


def _figures(record: Mapping[str, Any], problem: Problem) -> list[dict[str, str]]:
    """Title of each figure, what the paper shows, what ours shows."""
    main, tip = record["main_cnn"], record["trajectory"]["tip_percent"]
    exact, table = record["trajectory"]["exact_tip_percent"], record["table_1"]
    lowest = float(problem.all.poses[:, 2, 0].min())
    bend = problem.arm.largest_bending(problem.bounds)
    error = ", ".join(f"{1e3 * value:.2g}" for value in main["test_mean_absolute_error"])
    here = {
        "fig4": f"{len(problem.all)} tips; each moment up to {bend:.2f} E I/L, z of the tip down to"
        f" {lowest:.2f} m.",
        "fig5": "The first training row, before its z-score.",
        "fig6": f"{main['parameters']} parameters; widths and pooling are ours.",
        "fig7": f"After {main['epochs']} epochs {main['training_mse_units2']:.2g} (training) and"
        f" {main['validation_mse_units2']:.2g} (validation) units^2, 20 units being the largest moment.",
        "fig8": f"Mean absolute errors {error} N mm; R^2 {min(main['test_r2']):.4f} and more. The split is"
        " drawn from the training grid, so this says nothing about poses between its points.",
        "fig9": "As far as the moments of the data bend the arm; eq. 47 with sin^2 phi in (2,2).",
        "fig10": f"Tip error {tip['mean']:.2g} % of L in the mean, {tip['max']:.2g} % at most. The exact"
        f" inverse comes within {exact['max']:.1g} %: the centimetres are the network's and its training"
        " grid's, not the models'.",
        "fig11": f"{table['trainings']} networks; 20 units at {table['range_EI_by_L']:.2g} E I/L. See table"
        " 1.",
    }
    return [
        {"name": name, "title": title, "paper": paper, "here": here[name]}
        for name, (title, paper) in FIGURES.items()
    ]


def _main(network: PoseNetwork, fitted: Fit, problem: Problem) -> dict[str, Any]:
    unit, test = moment_unit(problem.bounds), problem.test
    gap = network.predict(test.poses) - test.moments
    r2 = 1.0 - (gap**2).mean(axis=0) / test.moments.var(axis=0)
    assert fitted.training_loss is not None and fitted.validation_loss is not None
    return {
        "parameters": network.architecture.parameters,
        "epochs": fitted.training_loss.shape[1],
        "cpu_seconds": fitted.seconds,
        "training_mse_units2": float(fitted.training_loss[0, -1]),
        "validation_mse_units2": float(fitted.validation_loss[0, -1]),
        "test_mse_units2": float(np.mean(gap**2) / unit**2),
        "test_mean_absolute_error": np.abs(gap).mean(axis=0).tolist(),
        "test_r2": r2.tolist(),
    }


def _printed() -> dict[str, float]:
    """How far eq. 47 is from a rotation, as printed and corrected: largest entry of R^T R - I."""
    angles = np.linspace(0.0, np.pi, 181)
    theta, phi = np.meshgrid(angles, 2.0 * angles)
    found = {}
    for name, printed in (("printed", True), ("corrected", False)):
        R = arc_rotation(theta.ravel(), phi.ravel(), printed)
        found[name] = float(np.abs(np.swapaxes(R, 1, 2) @ R - np.eye(3)).max())
    return found


def _order(table: Mapping[str, Any]) -> str:
    """The order of the models in one sentence."""
    return (
        f"Order {table['order']}, in print {table['published_order']}: that comes out in"
        f" {100 * table['order_share']:.0f} % of resamplings of {table['seeds']} seeds, in"
        f" {100 * table['order_share_of_single_runs']:.0f} % of single runs, of which the print shows one;"
        f" rank correlation {table['rank_correlation']:.2f}."
    )


def report(record: Mapping[str, Any]) -> str:
    """The record as Markdown."""
    main, tip = record["main_cnn"], record["trajectory"]["tip_percent"]
    exact, eq47 = record["trajectory"]["exact_tip_percent"], record["printed_eq47"]
    lines = [
        "# Sections 3 and 4 of the paper, regenerated",
        "",
        f'Data set "{record["data"]}"; certificate: {record["certificate"]}.',
        "",
        f"Main CNN (fig. 6, 7, 8): {main['parameters']} parameters, {main['epochs']} epochs in"
        f" {main['cpu_seconds']:.1f} s of one core; R^2 on its test split"
        f" {', '.join(f'{value:.5f}' for value in main['test_r2'])}. That split is drawn from the training"
        " grid and hides the error off it: `ancf train` measures both.",
        "",
        f"Trajectory (fig. 9, 10): tip error mean {tip['mean']:.3g}, p95 {tip['p95']:.3g}, max"
        f" {tip['max']:.3g} % of L. The exact inverse comes within {exact['mean']:.2g} % (max"
        f" {exact['max']:.2g}): the constant-curvature model and ANCF differ by the thickness of the arm"
        " alone, and the centimetres of the paper's fig. 10 are the network's.",
        "",
        f"Eq. 47: largest entry of R^T R - I is {eq47['printed']:.3g} as printed, {eq47['corrected']:.1g}"
        " with sin^2 phi in (2,2).",
        "",
    ]
    for key, title in (
        ("table_1", f"Table 1, with 20 units at {TABLE_RANGE:g} E I/L"),
        ("table_1_range_of_the_data", "The same networks at the range of the data set"),
    ):
        table = record[key]
        lines += [
            f"## {title}",
            f"{table['trainings']} trainings as one stack, {table['cpu_seconds']:.1f} s of one core; mean"
            " and deviation over folds and seeds.",
            "",
            "| model | size | published size | MSE, units^2 | published | ratio | N^2 m^2 | z-units | R^2 |",
            "|---|---|---|---|---|---|---|---|---|",
        ]
        lines += [
            f"| {row['model']} | {row['size']} | {row['published_size']} | {row['mse_mean']:.3g} +-"
            f" {row['mse_deviation']:.2g} | {row['published_mse']:.3g} | {row['ratio']:.2f} |"
            f" {row['mse_N2m2']:.2e} | {row['mse_z']:.2e} | {row['r2']:.5f} |"
            for row in table["models"]
        ]
        lines += ["", _order(table), ""]
    lines += [
        "## Decisions where the print is wrong or silent",
        "",
        "| item | paper | here |",
        "|---|---|---|",
    ]
    lines += [f"| {row['item']} | {row['paper']} | {row['here']} |" for row in record["decisions"]]
    return "\n".join(lines) + "\n"
