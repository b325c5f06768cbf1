"""Rods and loads in a plane, their solutions with reductions and without, and dense tangents."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

import ancf
from ancf.materials import SaintVenantKirchhoff
from ancf.rotation import exp
from ancf.scene import (
    Force,
    Foundation,
    Gravity,
    LineLoad,
    LineMoment,
    Magnet,
    Moment,
    Pressure,
    Rod,
    Scene,
    Spring,
    Tendon,
)
from ancf.scene_plane import Plane, find_plane
from ancf.sections import Circle, Polygon

SOFT = SaintVenantKirchhoff(1e6, 0.3, 1000.0)
EI = 1e6 * np.pi * 0.01**4 / 4
LENGTH = 0.4
FORCE, MOMENT = EI / LENGTH**2, EI / LENGTH
OBLIQUE = exp(np.array([0.4, -0.7, 0.9]))


def arm(**changes: Any) -> Rod:
    return replace(Rod("arm", LENGTH, 6, Circle(0.01), SOFT), **changes)


def scene(rod: Rod, **loads: Any) -> Scene:
    return Scene((rod,), **{"forces": (Force("arm", 1.0, np.array([0.2, 3.0, 0.0]) * FORCE),), **loads})


def both(one: Scene, insist: bool = False) -> tuple[ancf.Solution, ancf.Solution]:
    """Solved with reductions, or with those of the plane whether they pay or not, and without."""
    full, planar = (replace(one, solver=replace(one.solver, reduction=r)) for r in ("full", "planar"))
    return ancf.solve(planar if insist else one), ancf.solve(full)


def distance(a: ancf.Solution, b: ancf.Solution) -> float:
    return a.model.largest_motion(a.q - b.q)


def is_planar(solution: ancf.Solution) -> bool:
    return any(sentence.startswith("planar:") for sentence in solution.reductions)


TRAPEZIUM = Polygon(((-0.01, -0.006), (0.01, -0.003), (0.01, 0.003), (-0.01, 0.006)))
LOADS: dict[str, dict[str, Any]] = {
    "moment": {"moments": (Moment("arm", 1.0, np.array([0, 0, 2.0]) * MOMENT),)},
    "vorticity": {"moments": (Moment("arm", 1.0, np.array([0, 0, 2.0]) * MOMENT, "fixed", "vorticity"),)},
    "follower moment": {"moments": (Moment("arm", 0.7, np.array([0, 0, 2.0]) * MOMENT, "follower"),)},
    "lever": {"forces": (Force("arm", 1.0, np.array([1.0, 2, 0]) * FORCE, np.array([0.008, 0.0])),)},
    "follower": {"forces": (Force("arm", 0.8, np.array([0.0, 2, 0]) * FORCE, direction="follower"),)},
    "line load": {"line_loads": (LineLoad("arm", np.array([0.0, 3, 0]) * FORCE / LENGTH),)},
    "follower line load": {
        "line_loads": (LineLoad("arm", np.array([0.0, 3, 0]) * FORCE / LENGTH, "follower"),)
    },
    "line moment": {"line_moments": (LineMoment("arm", np.array([0.0, 0, 2]) * MOMENT / LENGTH),)},
    "weight": {"gravity": Gravity(np.array([1.0, -2.0, 0.0]))},
    "magnet": {"magnets": (Magnet("arm", np.array([0.1, 0.02, 0]), np.array([0.01, 0.06, 0])),)},
    "tendon": {"tendons": (Tendon("arm", 1.0, np.array([[0.0, 0.006, 0], [0.6, 0.006, 0], [1, 0, 0]])),)},
    "springs": {
        "forces": (Force("arm", 1.0, np.array([0.2, 3.0, 0.0]) * FORCE),),
        "springs": (
            Spring("arm", 1.0, np.array([[2.0, 1, 0], [1, 4, 0], [0, 0, 3]]) * FORCE / LENGTH),
            Spring("arm", 0.5, np.eye(3) * FORCE / LENGTH, np.array([0.008, 0]), np.array([0.3, -0.2, 0])),
        ),
    },
    "bed": {
        "forces": (Force("arm", 1.0, np.array([0.2, 3.0, 0.0]) * FORCE),),
        "foundations": (Foundation("arm", np.array([1.0, 5, 2]) * FORCE / LENGTH**2, None, 0.2, 0.8),),
    },
    "chamber": {"pressures": (Pressure("arm", 2e4, np.array([0.004, 0.0]), 0.003, 0.2, 0.9),)},
}


def find(one: Scene) -> Plane:
    plane = find_plane(one)
    assert isinstance(plane, Plane), str(plane)
    return plane


def from_band(band: np.ndarray, b: int) -> np.ndarray:
    """Dense matrix of LAPACK's band with room for fill."""
    n = band.shape[1]
    K = np.zeros((n, n))
    for j in range(n):
        rows = np.arange(max(0, j - b), min(n, j + b + 1))
        K[rows, j] = band[2 * b + rows - j, j]
    return K
