"""What the claims about the surrogate rest on, measured in one go: the record that a report shows.

The data of both presets are made behind the gate and not kept (`ancf dataset` gives the same bytes), the
paper's figures and table are regenerated, all models compared.
``study.json`` and the pictures beside it are all that the validation report reads; it imports none of this.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from surrogate.asked import asked
from surrogate.compare import SEEDS, compare, compare_errors
from surrogate.dataset import DataSet
from surrogate.design import PRESETS, preset
from surrogate.gate import ask
from surrogate.model_card import SET_TEXT
from surrogate.problem import problem_of
from surrogate.reproduce import reproduce
from surrogate.sweep import make

SCHEMA = 1
RECORD = "study.json"
ON_THE_SWEEP = ("closed form", "polynomial", "cnn", "equivariant")  # enough to see that its split leaks


def study(
    folder: Path,
    seeds: Sequence[int] = SEEDS,
    epochs: int | None = None,
    *,
    count: int | None = None,
    allow_unvalidated: bool = False,
    told: Callable[[str], None] = lambda text: None,
) -> dict[str, Any]:
    """Make both data sets, measure everything, draw figures 4 to 11 into `folder`; returns the record.

    Parameters
    ----------
    epochs, count : shorter trainings, smaller Sobol design; for tests
    told : called with what is done next

    Raises
    ------
    NotValidated, InputError : as `surrogate.sweep.make`.
    """
    data, seconds = {}, {}
    with TemporaryDirectory(dir=folder, prefix=".data-") as place:
        for name in PRESETS:
            told(f"data set {name}")
            begin = time.process_time()
            design = preset(name, None if name == "paper" else count)
            data[name] = make(design, Path(place) / name, allow_unvalidated=allow_unvalidated)
            seconds[name] = time.process_time() - begin
    problems = {name: problem_of(found) for name, found in data.items()}
    told("models on sobol")
    comparisons = {"sobol": compare(problems["sobol"], seeds, epochs)}
    told("models on paper")
    comparisons["paper"] = compare_errors(problems["paper"], seeds, epochs, ON_THE_SWEEP)
    told("figures 4 to 11, table 1")
    short = {} if epochs is None else {"epochs": epochs, "table_epochs": epochs}
    paper = reproduce(problems["paper"], folder, **short)
    gate = ask(allow_unvalidated=True)
    record = {
        "schema": SCHEMA,
        "certificate": gate.id,
        "reasons": list(gate.reasons),
        "data": {name: _told(found, seconds[name]) for name, found in data.items()},
        "comparison": comparisons,
        "reproduction": paper,
        "sets": SET_TEXT,
        "numpy": data["sobol"].card["versions"]["numpy"],
    }
    return {**record, "asked": asked(record)}


def _told(data: DataSet, seconds: float) -> dict[str, Any]:
    """What a data set is, from its card."""
    kept = ("certificate", "reasons", "rows", "rows_by_split", "rows_by_status", "moment_range", "arm")
    card = {key: data.card[key] for key in (*kept, "sampling", "plan_id")}
    return {**card, "cpu_seconds": seconds}
