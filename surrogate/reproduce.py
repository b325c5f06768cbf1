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
from surrogate.tracking import track_model
from surrogate.trajectory import arc_rotation

SHOWN = 100  # test samples of fig. 8
TABLE_SEEDS = (0, 1, 2, 3, 4)

# What the paper prints, what is done here, and why.
DECISIONS = (
    (
        "radius, E, range of moments (sec. 3.1)",
        "unpublished",
        "those of the data set; 20 units are its largest moment",
    ),
    ("formulation (eq. 11-16)", "continuum", "enhanced: continuum is too stiff in bending at every mesh"),
    (
        "grid of 1520 samples (sec. 3.1)",
        "unpublished",
        "4 x 19 x 20 over torsion and bending about both axes",
    ),
    ("test samples (sec. 4.1)", "512", "15 % of 1520 is 228"),
    ('"kernel size 16" (sec. 3.2)', "does not fit a 3 x 4 image", "16 kernels of 2 x 2"),
    ("pooling and dense widths (fig. 6)", "not printed", "mean over 2 x 1; dense 32, tanh; dense 3, linear"),
    (
        "scale of the targets",
        "not printed; MSE > 1 excludes z-scores",
        "units of which the largest moment has 20",
    ),
    ("batch of the five-fold table", "not printed", "64, as for the main CNN"),
    (
        "order of table 1",
        "5 < 1 < 4 < 3 < 2, one run",
        "5 < 4 < 1 < 2 < 3; model 3 scatters by 40 % over folds and seeds, 1 and 4 cross as the range grows",
    ),
    ("eq. 47, entry (2,2)", "cos^2 phi: no rotation", "sin^2 phi"),
    (
        "fig. 10, mismatch of CCM and ANCF",
        "explained by the models",
        "the arc is the thin arm's; what remains is (R/L)^2",
    ),
)


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
        save_figure(figure, folder / f"{name}.png", problem.certificate)
    return {
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
        f"Trajectory (fig. 9, 10): tip error mean {tip['mean']:.3g}, p95 {tip['p95']:.3g},"
        f" max {tip['max']:.3g} % of L. The exact inverse comes within {exact['mean']:.2g} %"
        f" (max {exact['max']:.2g}): the constant-curvature model and ANCF differ by the thickness of the arm"
        " alone, and the centimetres of the paper's fig. 10 are the network's.",
        "",
        f"Eq. 47: largest entry of R^T R - I is {eq47['printed']:.3g} as printed,"
        f" {eq47['corrected']:.1g} with sin^2 phi in (2,2).",
        "",
    ]
    for key, title in (
        ("table_1", f"Table 1, with 20 units at {TABLE_RANGE:g} E I/L"),
        ("table_1_range_of_the_data", "The same networks at the range of the data set"),
    ):
        table = record[key]
        lines += [
            f"## {title}",
            f"{table['trainings']} trainings as one stack, {table['cpu_seconds']:.1f} s of one core; mean and"
            " deviation over folds and seeds.",
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
        lines += ["", f"Rank correlation with the published errors: {table['rank_correlation']:.2f}.", ""]
    lines += [
        "## Decisions where the print is wrong or silent",
        "",
        "| item | paper | here |",
        "|---|---|---|",
    ]
    lines += [f"| {row['item']} | {row['paper']} | {row['here']} |" for row in record["decisions"]]
    return "\n".join(lines) + "\n"
