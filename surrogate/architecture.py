"""Networks of the paper as data: layers on the 3 x 4 image of a pose, their sizes, and a NumPy forward pass.

Symbols
-------
h, w, c    rows, columns and channels of an image; a batch of images is kept flat, (.., h w c)
K          size of a square kernel, stride 1, no padding (paper sec. 4.3)

A convolution is a gather of patches and a product: x[.., index] (.., positions, K K c) @ W + b.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]

IMAGE = (3, 4, 1)  # fig. 5: columns r, r_x, r_y, r_z


@dataclass(frozen=True)
class Convolution:
    """`kernels` kernels of `size` x `size`, C_{kernels, size} of table 1; tanh."""

    kernels: int
    size: int = 2


@dataclass(frozen=True)
class Pooling:
    """Mean over windows of `rows` x `columns` that do not overlap."""

    rows: int
    columns: int


@dataclass(frozen=True)
class Dense:
    """A fully connected layer, F_units of table 1; tanh, except the last of a network."""

    units: int


Layer = Convolution | Pooling | Dense


@dataclass(frozen=True)
class Stage:
    """A layer between images of known shape: patches to gather and the shape of its weights."""

    layer: Layer
    index: Indices  # (positions, patch) places in the flat input; one position for a dense layer
    outputs: int  # per position; for a pooling, channels in all
    out_shape: tuple[int, int, int]

    @property
    def weights(self) -> tuple[int, int] | None:
        """Shape of W, or None of a pooling."""
        return None if isinstance(self.layer, Pooling) else (self.index.shape[1], self.outputs)


@dataclass(frozen=True)
class Architecture:
    """Layers from the image of a pose, or from `inputs` numbers, to three moments; the last is linear."""

    name: str
    layers: tuple[Layer, ...]
    inputs: int | None = None  # None: the 3 x 4 image

    @cached_property
    def stages(self) -> tuple[Stage, ...]:
        """The layers with their shapes."""
        shape = IMAGE if self.inputs is None else (1, 1, self.inputs)
        found = []
        for layer in self.layers:
            stage = _stage(layer, shape)
            found.append(stage)
            shape = stage.out_shape
        return tuple(found)

    @property
    def parameters(self) -> int:
        """Number of weights and biases."""
        return sum((w[0] + 1) * w[1] for w in (s.weights for s in self.stages) if w is not None)

    @property
    def shapes(self) -> tuple[tuple[int, int], ...]:
        """Shapes of the W of all layers that have one, in order; a bias (outputs,) belongs to each."""
        return tuple(w for w in (s.weights for s in self.stages) if w is not None)

    def unpack(self, flat: Floats) -> list[tuple[Floats, Floats]]:
        """W, b of each layer from one vector (parameters,)."""
        found, at = [], 0
        for rows, columns in self.shapes:
            W = flat[at : at + rows * columns].reshape(rows, columns)
            at += rows * columns
            found.append((W, flat[at : at + columns]))
            at += columns
        return found

    def forward(self, weights: Sequence[tuple[Floats, Floats]], x: Floats) -> Floats:
        """Outputs (.., 3) of normalised inputs (.., inputs)."""
        left = iter(weights)
        last = len(self.stages) - 1
        for number, stage in enumerate(self.stages):
            if isinstance(stage.layer, Pooling):
                x = x[..., stage.index].mean(axis=-1)
                continue
            W, b = next(left)
            if len(stage.index) > 1:
                x = x[..., stage.index] @ W
                x += b
                x = x.reshape(*x.shape[:-2], -1)
            else:
                x = x @ W
                x += b
            if number < last:
                np.tanh(x, out=x)
        return x


def _stage(layer: Layer, shape: tuple[int, int, int]) -> Stage:
    h, w, c = shape
    flat = np.arange(h * w * c).reshape(shape)
    if isinstance(layer, Dense):
        return Stage(layer, flat.reshape(1, -1), layer.units, (1, 1, layer.units))
    if isinstance(layer, Convolution):
        rows, columns = h - layer.size + 1, w - layer.size + 1
        index = np.array(
            [
                flat[i : i + layer.size, j : j + layer.size].ravel()
                for i in range(rows)
                for j in range(columns)
            ]
        )
        return Stage(layer, index, layer.kernels, (rows, columns, layer.kernels))
    rows, columns = h // layer.rows, w // layer.columns
    index = np.array(
        [
            flat[
                i * layer.rows : (i + 1) * layer.rows, j * layer.columns : (j + 1) * layer.columns, k
            ].ravel()
            for i in range(rows)
            for j in range(columns)
            for k in range(c)
        ]
    )
    return Stage(layer, index, len(index), (rows, columns, c))


# Table 1 of the paper; its sizes come out without pooling only.
TABLE_1 = (
    Architecture("1: F16, F3", (Dense(16), Dense(3))),
    Architecture("2: C8,2, F3", (Convolution(8), Dense(3))),
    Architecture("3: C8,2, C4,2, F3", (Convolution(8), Convolution(4), Dense(3))),
    Architecture("4: C16,2, C8,2, F3", (Convolution(16), Convolution(8), Dense(3))),
    Architecture("5: C32,2, C16,2, F8, F3", (Convolution(32), Convolution(16), Dense(8), Dense(3))),
)
PUBLISHED_SIZES = (259, 187, 199, 651, 2515)
PUBLISHED_MSE = (4.19, 8.17, 7.19, 4.54, 1.07)

# Fig. 6: convolution, pooling, flatten, dense. Printed: 16 (kernels; a kernel of size 16 does not fit a 3 x 4
# image), tanh. Left open, and chosen here: kernels of 2 x 2, mean pooling, a dense layer of 32.
MAIN_CNN = Architecture("CNN of fig. 6", (Convolution(16), Pooling(2, 1), Dense(32), Dense(3)))

# Not of the paper: the usual perceptron, on the raw pose or (`inputs`) on the six features of baselines.py.
RAW_MLP = Architecture("MLP 3 x 96", (Dense(96), Dense(96), Dense(96), Dense(3)))
LOG_MLP = Architecture("MLP 3 x 96 on the logarithm", RAW_MLP.layers, inputs=6)
