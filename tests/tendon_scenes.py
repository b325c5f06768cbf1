"""A slender rod with tendons, for the tests of their lengths."""

from __future__ import annotations

import numpy as np

import ancf

L, RADIUS, YOUNG = 0.5, 2.5e-3, 1e6
EI, EA = YOUNG * np.pi * RADIUS**4 / 4, YOUNG * np.pi * RADIUS**2
D = 0.8 * RADIUS


def scene(tendons, rod=None, **tables):
    data = {
        "length": L, "elements": 8, "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3, "density": 1000.0},
    } | (rod or {})  # fmt: skip
    return ancf.scene_from_dict({"rod": [data], "tendon": tendons, **tables})


def tendon(angle=0.0, **keys):
    y, z = D * np.cos(angle), D * np.sin(angle)
    return {"path": [[0.0, y, z], [1.0, y, z]], **keys}
