"""The record of `surrogate.compare` as Markdown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from surrogate.model_card import SET_TEXT


def compare_text(record: Mapping[str, Any]) -> str:
    """Tables of all models on all sets, what they cost, and when one is worth having."""
    sets = [name for name in SET_TEXT if name in record["models"][0]["sets"]]
    lines = [
        "# Models of the inverse, in closed loop",
        "",
        f'Data set "{record["data"]}", {record["training_rows"]} training rows; certificate:'
        f" {record['certificate']}.",
        "",
        "Tip error in % of L: mean over poses (+- deviation over the seeds), median, p95, largest.",
        "",
        f"| model (seeds) | {' | '.join(sets)} |",
        "|---" * (len(sets) + 1) + "|",
    ]
    for model in record["models"]:
        cells = []
        for name in sets:
            tip = model["sets"][name]["tip_percent"]
            rest = ", ".join(f"{tip[k]['mean']:.2g}" for k in ("median", "p95", "max"))
            cells.append(f"{tip['mean']['mean']:.2g} (+- {tip['mean']['deviation']:.1g}), {rest}")
        lines.append(f"| {model['kind']} ({model['seeds']}) | {' | '.join(cells)} |")
    lines += ["", *(f"* {name}: {SET_TEXT[name]}" for name in sets), ""]
    lines += [
        "| model | parameters | degrees | R^2 | MSE, N^2 m^2 | MSE, z-units | training, s | p50, us | p99,"
        " us | coverage at 95 % | radius, % of L | solves to converge | after one, two Gauss-Newton steps,"
        " max % |",
        "|---" * 13 + "|",
    ]
    for model in record["models"]:
        off = model["sets"]["off_grid"]
        stepped = ", ".join(f"{s['max_percent']:.1g}" for s in model["gauss_newton"])
        lines.append(
            f"| {model['kind']} | {model['parameters']} | {off['angle_degrees']['mean']['mean']:.2g} |"
            f" {off['r2']['mean']:.6f} | {off['mse']['mean']:.2g} | {off['mse_z']['mean']:.2g} |"
            f" {model['training_cpu_seconds']:.2g} | {1e6 * model['latency']['p50']:.0f} |"
            f" {1e6 * model['latency']['p99']:.0f} | {100 * model['coverage']['position']:.1f} % |"
            f" {model['coverage']['radius_percent']:.2g} | {model['solves']['mean']:.2f} | {stepped} |"
        )
    deviation = 100 * record["models"][0]["coverage"]["deviation"]
    lines += [
        "",
        f"Training: all seeds together, CPU time of one core. Error radius from {record['calibration_rows']}"
        f" rows of their own; coverage on new rows is 95 +- {deviation:.1f} %.",
        f"Reachability by the converged mismatch and the bounds: AUROC {record['auroc']:.4f}.",
        "",
        record["owed"],
        "",
        "## Is a surrogate worth having?",
        "",
        *record["worth"]["text"],
        "",
        *(f"WARNING: {m['leak']}" for m in record["models"] if m["leak"]),
    ]
    return "\n".join(lines).rstrip() + "\n"
