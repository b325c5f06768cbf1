"""The rod of the benchmarks, and one thread for the linear algebra."""

from __future__ import annotations

import os
from typing import Any

for _name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(_name, "1")

import pytest  # noqa: E402  (threads are pinned before anything loads numpy)

LENGTH, RADIUS, YOUNG = 0.4, 0.01, 1.0e6
EI = YOUNG * 3.141592653589793 * RADIUS**4 / 4.0


@pytest.fixture
def make_scene():
    """A round rod, L/R = 40, ν = 0.3; forces and moments in units of E I/L^2 and E I/L."""
    import ancf

    def make(
        elements: int, element: str = "3333", solver: dict[str, Any] | None = None, **load: list[float]
    ) -> Any:
        rod = {
            "length": LENGTH, "elements": elements, "element": element,
            "section": {"shape": "circle", "radius": RADIUS},
            "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3},
        }  # fmt: skip
        unit = {"moment": EI / LENGTH, "force": EI / LENGTH**2}
        loads = {name: [{"value": [unit[name] * v for v in value]}] for name, value in load.items()}
        return ancf.scene_from_dict({"rod": [rod], "solver": solver or {}, **loads})

    return make
