"""The card of a model, written from its record: what it answers, how well, and where it must not be used."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from surrogate.conformal import radius_text

KIND_TEXT = {
    "equivariant": "closed form of the thin arm plus a residual network with the arm's symmetry built in",
    "cnn": "the paper's CNN (fig. 6): convolution, pooling, dense layers on the 3 x 4 image of the pose",
    "mlp": "perceptron of three hidden layers of 96 on the raw 3 x 4 pose",
    "polynomial": "cubic polynomial in position and unwrapped logarithm of the rotation",
}
SET_TEXT = {
    "split": "test rows of the data's own split",
    "off_grid": "independent Sobol design in the same box",
    "trajectory": "constant-curvature trajectory (eq. 47-48)",
    "noise": "independent design, poses disturbed by 0.1 % of L and 1e-3 in gradients",
    "outside": "moments up to 25 % beyond the box",
    "slab": "a fifth of the box left out of the training",
}


def model_card(record: Mapping[str, Any]) -> str:
    """Markdown text of a record as `surrogate.model_file.save` returns it."""
    low_high = "; ".join(f"{low:g} to {high:g}" for low, high in record["moment_range"])
    lines = [
        f"# Inverse model: {record['kind']}",
        "",
        f"What it is: {KIND_TEXT[record['kind']]}; {record['parameters']} parameters.",
        f"Certificate of its data: {record['certificate']}.",
        "",
        "## Use",
        "- In: tip pose 3 x 4, columns r [m], r_x, r_y, r_z, in structure axes. Out: tip moment [N m], in"
        f" {record['frame']} axes.",
        f"- Arm: {record['arm']}.",
        f"- Moments of the training box [N m]: {low_high}.",
        "- Not for: other arms, other loads, poses that no tip moment reaches. It cannot tell whether a pose"
        " can be reached; `ancf invert` tells by solving the equilibrium.",
        "",
        "## Errors, in closed loop (moments solved again by ANCF)",
        "| poses | rows | tip error, % of L: mean, median, p95, max | degrees, mean | MSE N^2 m^2 | MSE z |"
        " R^2 |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, s in record["scores"].items():
        tip = s["tip"]
        lines.append(
            f"| {SET_TEXT.get(name, name)} | {s['rows']} | {tip['mean']:.2g}, {tip['median']:.2g},"
            f" {tip['p95']:.2g}, {tip['max']:.2g} | {s['angle']['mean']:.2g} | {s['mse']:.2g} |"
            f" {s['mse_z']:.2g} | {s['r2']:.6f} |"
        )
    radius = record["error_radius"]
    lines += [
        "",
        f"Error radius at {100 * radius['level']:g} % (split conformal, {radius['rows']} rows):"
        f" {radius_text(radius)}. It holds for poses anywhere in the box, for {100 * radius['level']:g} +-"
        f" {100 * radius['deviation']:.1f} of 100, not for disturbed ones.",
    ]
    if record.get("leak"):
        lines += ["", f"WARNING: {record['leak']}."]
    training = record["training"]
    lines += [
        "",
        "## Training",
        f'{training["rows"]} rows of the data set "{record["data"]}", seed {training["seed"]},'
        f" {training['cpu_seconds']:.1f} s of one core. Equal seeds give equal weights on one machine.",
        f"One pose takes {1e6 * record['latency']['p50']:.0f} us (p50), {1e6 * record['latency']['p99']:.0f}"
        " us (p99), in NumPy.",
        "",
    ]
    return "\n".join(lines)
