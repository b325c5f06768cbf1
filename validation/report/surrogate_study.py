"""The chapter on the surrogate: what `ancf study` has measured, read from the files that it writes.

Nothing of surrogate/ is imported. The contract is study.json of schema 1 and the pictures beside it; whether
its data were made under the certificate that holds for this run is judged here.
"""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

FOLDER, RECORD, SCHEMA = "surrogate", "study.json", 1
UNVALIDATED = "UNVALIDATED"
COMMAND = "ancf report --surrogate"


def study_chapter(folder: Path, certificate: str | None) -> dict[str, Any]:
    """What the template shows of a study in the folder of a report, or why there is nothing to show.

    Parameters
    ----------
    folder : of the report; the study lies in its folder ``surrogate``
    certificate : id of the certificate that holds for the run, or None

    Returns
    -------
    Plain data: `missing` (a sentence, or ""); else `record`, `gate` {state, text}, `pictures` by name (data
    addresses), `kinds`, the models on the Sobol design, and `leaky`, those on the paper's sweep.
    """
    path = folder / FOLDER / RECORD
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(record, dict) or record.get("schema") != SCHEMA:
            return {"missing": f"{RECORD} is of another schema than {SCHEMA}."}
        pictures = {
            figure["name"]: _address(path.parent / f"{figure['name']}.png")
            for figure in record["reproduction"]["figures"]
        }
        return {
            "missing": "",
            "record": record,
            "gate": gate(record, certificate),
            "pictures": pictures,
            "models": record["comparison"]["sobol"]["models"],
            "leaky": record["comparison"]["paper"]["models"],
        }
    except FileNotFoundError as error:
        if error.filename == str(path):
            return {"missing": "Not in this run."}
        return {"missing": f"A picture of the study is missing: {Path(error.filename).name}."}
    except (OSError, ValueError, KeyError, TypeError) as error:
        return {"missing": f"{RECORD} cannot be read: {type(error).__name__}: {error}."}


def gate(record: dict[str, Any], certificate: str | None) -> dict[str, str]:
    """State of the gate, as a verdict and in words."""
    stamp = record["certificate"]
    if stamp == UNVALIDATED:
        reasons = "; ".join(record["reasons"][:3]) or "asked for with --allow-unvalidated"
        return {"state": "FAIL", "text": f"These data are UNVALIDATED: {reasons}."}
    if any(data["certificate"] != stamp for data in record["data"].values()):
        return {"state": "FAIL", "text": "Data of this study are UNVALIDATED: rows lie outside the domain."}
    if stamp != certificate:
        held = f"the one of this run is {certificate[:12]}" if certificate else "none holds for this run"
        return {
            "state": "WARN",
            "text": f"The data were made under certificate {stamp[:12]}; {held}. Measure again: {COMMAND}.",
        }
    return {
        "state": "PASS",
        "text": f"All data passed the gate under the certificate that holds for this run, {stamp[:12]}.",
    }


def _address(path: Path) -> str:
    return "data:image/png;base64," + base64.b64encode(path.read_bytes()).decode()
