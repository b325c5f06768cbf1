"""The numbers asked of the surrogate, beside those that a study found."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

LEAST_R2 = 0.995
CNN_OFF_GRID, CNN_TRAJECTORY = 3.0, 2.5  # % of L, mean
BEST = {"mean": 0.03, "p95": 0.1, "max": 0.5}  # % of L
POLYNOMIAL = 0.01  # % of L, mean, of 400 solves
ONE_STEP, TWO_STEPS = 1e-3, 1e-8  # % of L on every pose; the latter is the tolerance of the solver
LEAST_AUROC = 0.99
COVERAGE = (0.93, 0.97)
MOST_RATIO = 3.0  # of a mean error of table 1 to the published one, either way


def asked(record: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Rows {what, asked, found, met} of a study; `met` is null for times, which are not judged."""
    rows = [*_paper(record["reproduction"]), *_models(record["comparison"]), *_times(record)]
    return [dict(zip(("what", "asked", "found", "met"), row, strict=True)) for row in rows]


def _paper(found: Mapping[str, Any]) -> list[tuple[str, str, str, bool]]:
    table, r2 = found["table_1"], min(found["main_cnn"]["test_r2"])
    sizes = [(row["size"], row["published_size"]) for row in table["models"]]
    ratios = [row["ratio"] for row in table["models"]]
    lowest, highest = min(ratios), max(ratios)
    share = f"{100 * table['order_share']:.0f} % of resampled seeds"
    return [
        (
            "Table 1: numbers of parameters",
            ", ".join(str(published) for _, published in sizes),
            ", ".join(str(size) for size, _ in sizes),
            all(size == published for size, published in sizes),
        ),
        (
            "Table 1: mean MSE over the published one",
            "1/3 to 3",
            f"{lowest:.2f} to {highest:.2f}",
            lowest >= 1.0 / MOST_RATIO and highest <= MOST_RATIO,
        ),
        (
            "Table 1: order of the five models",
            table["published_order"],
            f"{table['order']}; the published one in {share}",
            table["order"] == table["published_order"],
        ),
        ("Main CNN: R^2 on its test split", f"at least {LEAST_R2:g}", f"{r2:.5f}", r2 >= LEAST_R2),
    ]


def _models(comparison: Mapping[str, Any]) -> list[tuple[str, str, str, bool]]:
    sobol, paper = ({m["kind"]: m for m in comparison[name]["models"]} for name in ("sobol", "paper"))
    best = sobol["equivariant"]
    off, track = (_tip(sobol["cnn"], name, "mean") for name in ("off_grid", "trajectory"))
    tips = {name: _tip(best, "off_grid", name) for name in BEST}
    few = _tip(sobol["polynomial, 400 solves"], "off_grid", "mean")
    first = best["gauss_newton"][0]["max_percent"]
    second, solved = best["gauss_newton"][1]["max_percent"], best["gauss_newton"][1]["solved"]
    covered = [model["coverage"][name] for model in sobol.values() for name in ("position", "moment")]
    auroc, leak = comparison["sobol"]["auroc"], bool(paper["cnn"]["leak"])
    return [
        ("CNN on Sobol samples: tip error off the grid", f"at most {CNN_OFF_GRID:g} %", f"{off:.2g} %",
         off <= CNN_OFF_GRID),
        ("CNN on Sobol samples: on the trajectory", f"at most {CNN_TRAJECTORY:g} %", f"{track:.2g} %",
         track <= CNN_TRAJECTORY),
        (
            "Best network: tip error mean, p95, max",
            f"at most {', '.join(f'{limit:g}' for limit in BEST.values())} %",
            f"{', '.join(f'{value:.2g}' for value in tips.values())} %",
            all(tips[name] <= limit for name, limit in BEST.items()),
        ),
        ("Polynomial of 400 solves: mean tip error", f"at most {POLYNOMIAL:g} %", f"{few:.2g} %",
         few <= POLYNOMIAL),
        ("One Gauss-Newton step from the best network, any pose", f"at most {ONE_STEP:g} %", f"{first:.1g} %",
         first <= ONE_STEP),
        (
            "Two steps",
            f"at most {TWO_STEPS:g} %, the solver's tolerance",
            f"{second:.1g} % on {100 * solved:g} % of the poses",
            second <= TWO_STEPS and solved == 1.0,
        ),
        ("Reachability: AUROC", f"at least {LEAST_AUROC:g}", f"{auroc:.4f}", auroc >= LEAST_AUROC),
        (
            "Coverage of the 95 % radius, all models, tip and moment",
            f"{100 * COVERAGE[0]:g} to {100 * COVERAGE[1]:g} %",
            f"{100 * min(covered):.1f} to {100 * max(covered):.1f} %",
            COVERAGE[0] <= min(covered) and max(covered) <= COVERAGE[1],
        ),
        ("Leak guard on the paper's sweep", "fires", "fires" if leak else "is silent", leak),
    ]  # fmt: skip


def _times(record: Mapping[str, Any]) -> list[tuple[str, str, str, None]]:
    models = {model["kind"]: model for model in record["comparison"]["sobol"]["models"]}
    cnn, best = (1e6 * models[kind]["latency"]["p50"] for kind in ("cnn", "equivariant"))
    main, table = record["reproduction"]["main_cnn"], record["reproduction"]["table_1"]
    trainings = 25 * table["cpu_seconds"] / table["trainings"]
    return [
        ("Inference p50, CPU time: CNN, best network", "30, 60 us", f"{cnn:.0f}, {best:.0f} us", None),
        ("Data set `paper`, CPU time", "3 s", f"{record['data']['paper']['cpu_seconds']:.2g} s", None),
        ("The 25 trainings of table 1, CPU time", "60 s", f"{trainings:.1f} s", None),
        ("Main CNN, CPU time", "20 s", f"{main['cpu_seconds']:.1f} s", None),
    ]


def _tip(model: Mapping[str, Any], where: str, name: str) -> float:
    """A tip error, % of L, mean over the seeds."""
    return model["sets"][where]["tip_percent"][name]["mean"]
