"""The data set as a Parquet table, a row for each sample, for tools that read nothing else.

data.npz stays the canonical form. The card travels in the metadata of the table under ``ancf.card``, the unit
of a column in that of its field.
"""

from __future__ import annotations

import json
from os import PathLike
from pathlib import Path

import numpy as np

from surrogate.dataset import ARRAYS, DataSet
from surrogate.whole_file import write_bytes

TABLE = "data.parquet"
METADATA = b"ancf.card"
POSE = tuple(f"{vector}.{axis}" for vector in ("r", "r_x", "r_y", "r_z") for axis in "xyz")


def write(found: DataSet, path: str | PathLike[str]) -> Path:
    """Write the table; raises OSError, and ModuleNotFoundError without pyarrow (extra "parquet")."""
    import pyarrow as pa  # pyright: ignore[reportMissingImports]
    import pyarrow.parquet as pq  # pyright: ignore[reportMissingImports]

    units = found.card["units"]
    fields, columns = [], []
    for name, column in _columns(found).items():
        kind = name.split(".")[0].split("[")[0]
        unit = {"moments": units["moments"], "r": "m"}.get(kind, "1")
        unit = next((load["unit"] for load in found.card["loads"] if load["name"] == name), unit)
        array = pa.array(column.tolist() if column.dtype.kind == "U" else column)
        fields.append(pa.field(name, array.type, nullable=False, metadata={"unit": unit}))
        columns.append(array)
    schema = pa.schema(fields, metadata={METADATA: json.dumps(found.card).encode()})
    sink = pa.BufferOutputStream()
    pq.write_table(pa.Table.from_arrays(columns, schema=schema), sink)
    return write_bytes(Path(path), sink.getvalue().to_pybytes())


def read(path: str | PathLike[str]) -> DataSet:
    """Read such a table back."""
    import pyarrow.parquet as pq  # pyright: ignore[reportMissingImports]

    table = pq.read_table(path)
    card = json.loads(table.schema.metadata[METADATA])
    names = [load["name"] for load in card["loads"]]

    def stacked(columns: list[str]) -> np.ndarray:
        return np.stack([table[name].to_numpy() for name in columns], axis=1)

    arrays = {name: table[name].to_numpy() for name in ("iterations", "residual", "load_factor", "group")}
    arrays |= {
        name: np.array(table[name].to_pylist(), card["arrays"][name]["dtype"]) for name in ("status", "split")
    }
    arrays["moments"] = stacked([f"moments.{axis}" for axis in "xyz"])
    arrays["stretch"] = stacked([f"stretch.{vector}" for vector in ("r_x", "r_y", "r_z")])
    arrays["loads"] = stacked(names)
    arrays["pose"] = stacked(list(POSE)).reshape(-1, 4, 3).swapaxes(1, 2)
    return DataSet(**{name: arrays[name] for name in ARRAYS}, card=card)


def _columns(found: DataSet) -> dict[str, np.ndarray]:
    columns = dict(zip((f"moments.{axis}" for axis in "xyz"), found.moments.T, strict=True))
    columns |= dict(zip((load["name"] for load in found.card["loads"]), found.loads.T, strict=True))
    columns |= dict(zip(POSE, found.pose.swapaxes(1, 2).reshape(-1, 12).T, strict=True))
    columns |= dict(
        zip((f"stretch.{vector}" for vector in ("r_x", "r_y", "r_z")), found.stretch.T, strict=True)
    )
    scalars = ("status", "iterations", "residual", "load_factor", "split", "group")
    return columns | {name: getattr(found, name) for name in scalars}
