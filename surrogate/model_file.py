"""Models in files: weights as safetensors, everything else as JSON, read without torch.

A model's folder holds ``model.safetensors`` (weights and normaliser, float64), ``model.json`` (kind, scene,
box of moments, scores, error radius, certificate), ``MODEL_CARD.md`` and ``model.onnx``.

The safetensors format (huggingface/safetensors, README): eight bytes with the length of a header, the header
in JSON with dtype, shape and place of each tensor, then the bytes of the tensors, little-endian.
"""

from __future__ import annotations

import hashlib
import json
import math
import struct
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from ancf.errors import InputError, Message
from ancf.scene_file import scene_from_dict
from surrogate.architecture import Architecture, Convolution, Dense, Layer, Pooling
from surrogate.arm import Arm
from surrogate.baselines import Polynomial
from surrogate.equivariant import EquivariantNetwork
from surrogate.fit import AnyModel
from surrogate.networks import Normaliser, PoseNetwork
from surrogate.whole_file import write_together

Floats = NDArray[np.float64]

SCHEMA = 1
WEIGHTS, RECORD, CARD, GRAPH = "model.safetensors", "model.json", "MODEL_CARD.md", "model.onnx"
LAYERS: dict[str, type[Layer]] = {"convolution": Convolution, "pooling": Pooling, "dense": Dense}


@dataclass(frozen=True, eq=False)
class Loaded:
    """A model from a folder, its arm, and the record beside it."""

    model: AnyModel
    arm: Arm
    record: dict[str, Any]

    @property
    def bounds(self) -> Floats:
        """Box (3, 2) [N m] of the moments it was trained on."""
        return np.array(self.record["moment_range"], dtype=float)


def safetensors(tensors: Mapping[str, Floats]) -> bytes:
    """Float64 arrays by name as the bytes of a file. Equal arrays give equal bytes."""
    header, blocks, at = {}, [], 0
    for name in sorted(tensors):
        data = np.ascontiguousarray(tensors[name], dtype="<f8")
        header[name] = {"dtype": "F64", "shape": list(data.shape), "data_offsets": [at, at + data.nbytes]}
        blocks.append(data.tobytes())
        at += data.nbytes
    text = json.dumps(header, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 8)
    return struct.pack("<Q", len(text)) + text + b"".join(blocks)


def read_safetensors(whole: bytes) -> dict[str, Floats]:
    """Float64 arrays by name; raises ValueError for bytes that are none of ours."""
    if len(whole) < 8:
        raise ValueError("the file has no header")
    (length,) = struct.unpack("<Q", whole[:8])
    if length > len(whole) - 8:
        raise ValueError("the file ends inside its header")
    header, data = json.loads(whole[8 : 8 + length]), whole[8 + length :]
    found = {}
    for name, entry in header.items():
        if name == "__metadata__":
            continue
        begin, end = entry["data_offsets"]
        if entry["dtype"] != "F64" or end > len(data) or end - begin != 8 * math.prod(entry["shape"]):
            raise ValueError(f"tensor {name!r} is not float64, or the file is cut off")
        found[name] = np.frombuffer(data[begin:end], dtype="<f8").reshape(entry["shape"]).astype(float)
    return found


def save(folder: Path, model: AnyModel, record: Mapping[str, Any]) -> dict[str, Any]:
    """Write weights and record; returns the record with kind, architecture and the digest of the weights.

    record : must hold `scene` (tables of a scene file), `moment_range` and `certificate`
    """
    folder.mkdir(parents=True, exist_ok=True)
    tensors, kind = _tensors(model)
    weights = safetensors(tensors)
    whole = {"schema": SCHEMA, **kind, "weights_sha256": hashlib.sha256(weights).hexdigest(), **record}
    text = json.dumps(whole, indent=1, allow_nan=False) + "\n"
    write_together({folder / WEIGHTS: weights, folder / RECORD: text.encode()})
    return whole


def load_model(folder: Path) -> Loaded:
    """Read a model; nothing is trained or imported from torch.

    Raises
    ------
    InputError : files missing, damaged, of another schema, or weights that are not those of the record.
    """
    try:
        record = json.loads((folder / RECORD).read_text())
        whole = (folder / WEIGHTS).read_bytes()
    except (OSError, ValueError) as error:
        _refuse(folder, "The model cannot be read.", str(error))
    if not isinstance(record, dict) or record.get("schema") != SCHEMA:
        _refuse(folder / RECORD, "The model is of another schema.", f"this version knows {SCHEMA}")
    if hashlib.sha256(whole).hexdigest() != record.get("weights_sha256"):
        _refuse(folder / WEIGHTS, "The weights are not those of the record.", "their SHA-256 differs")
    try:
        arm = Arm.of(scene_from_dict(record["scene"]))
        return Loaded(_model(record, read_safetensors(whole), arm), arm, record)
    except (KeyError, TypeError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        _refuse(folder, "The model is damaged.", f"{type(error).__name__}: {error}")


def _tensors(model: AnyModel) -> tuple[dict[str, Floats], dict[str, Any]]:
    """Arrays of a model, and its kind with what else it needs."""
    if isinstance(model, Polynomial):
        arrays = {"coefficients": model.coefficients, **_normaliser(model.normaliser)}
        return arrays, {"kind": "polynomial", "parameters": model.coefficients.size}
    if isinstance(model, PoseNetwork):
        arrays = {**_layers(model.weights), **_normaliser(model.normaliser)}
        arrays["moment_unit"] = np.array([model.moment_unit])
        kind = "mlp" if all(isinstance(layer, Dense) for layer in model.architecture.layers) else "cnn"
        return arrays, {"kind": kind, **_architecture(model.architecture)}
    if isinstance(model, EquivariantNetwork):
        arrays = {**_layers(model.weights), "largest": model.largest, "scale": np.array([model.scale])}
        return arrays, {"kind": "equivariant", **_architecture(model.architecture)}
    raise TypeError(f"models of the kind {type(model).__name__} are not saved")


def _model(record: dict[str, Any], tensors: dict[str, Floats], arm: Arm) -> AnyModel:
    kind = record["kind"]
    if kind == "polynomial":
        return Polynomial(arm, _read_normaliser(tensors), tensors["coefficients"])
    described = record["architecture"]
    layers = tuple(LAYERS[entry["layer"]](**entry["sizes"]) for entry in described["layers"])
    architecture = Architecture(described["name"], layers, described["inputs"])
    names = [f"layer{i}.{part}" for i in range(len(architecture.shapes)) for part in ("weight", "bias")]
    flat = np.concatenate([tensors[name].ravel() for name in names])
    if flat.size != architecture.parameters:
        raise ValueError(f"{flat.size} weights, the architecture has {architecture.parameters}")
    if kind in ("cnn", "mlp"):
        return PoseNetwork(architecture, flat, _read_normaliser(tensors), float(tensors["moment_unit"][0]))
    if kind == "equivariant":
        return EquivariantNetwork(arm, flat, tensors["largest"], float(tensors["scale"][0]), architecture)
    raise ValueError(f"kind {kind!r}")


def _layers(weights: list[tuple[Floats, Floats]]) -> dict[str, Floats]:
    pairs = [(f"layer{i}.weight", W) for i, (W, _) in enumerate(weights)]
    return dict(pairs + [(f"layer{i}.bias", b) for i, (_, b) in enumerate(weights)])


def _normaliser(normaliser: Normaliser) -> dict[str, Floats]:
    return {"mean": normaliser.mean, "deviation": normaliser.deviation}


def _read_normaliser(tensors: dict[str, Floats]) -> Normaliser:
    return Normaliser(tensors["mean"], tensors["deviation"])


def _architecture(architecture: Architecture) -> dict[str, Any]:
    names = {kind: name for name, kind in LAYERS.items()}
    layers = [{"layer": names[type(layer)], "sizes": asdict(layer)} for layer in architecture.layers]
    described = {"name": architecture.name, "inputs": architecture.inputs, "layers": layers}
    return {"architecture": described, "parameters": architecture.parameters}


def _refuse(path: Path, what: str, value: str) -> NoReturn:
    raise InputError(
        Message(
            what,
            str(path),
            value,
            "an interrupted copy, an edit by hand, or a folder that holds no model",
            "train it again with `ancf train DIR`, or name a scene file for the exact inverse",
        )
    )
