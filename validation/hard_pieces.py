"""Rods of unlike pieces: tapers, jumps of stiffness, elements of very unlike length."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import quad

from ancf.solution import Solution
from validation.hard_case import HardCase
from validation.hard_limits import deviation
from validation.hard_scenes import LENGTH, QUARTER, YOUNG, Deviation, Scene, tip_distance

RADIUS = 0.002  # m, at the base: L/R = 200, so that finite strain stays below the mesh


def pieces() -> Iterator[HardCase]:
    """All of them under a tip moment, for which the shape is known whatever the stiffness along the rod."""
    family = "unlike pieces"
    thin = {"shape": "circle", "radius": 0.1 * RADIUS}
    thick = {"shape": "circle", "radius": RADIUS}
    cone = [
        # Half a radian an element at most: graded, most elements where the rod is thin.
        _piece(0.4 * LENGTH, 8, thick, section_end={"shape": "circle", "radius": 0.64 * RADIUS}),
        _piece(0.4 * LENGTH, 24, {"shape": "circle", "radius": 0.64 * RADIUS},
               section_end={"shape": "circle", "radius": 0.28 * RADIUS}),
        _piece(0.2 * LENGTH, 48, {"shape": "circle", "radius": 0.28 * RADIUS}, section_end=thin),
    ]  # fmt: skip
    yield _turned(
        family, "taper 10:1", cone, QUARTER,
        "bending stiffness falls by 1e4 along the rod, nearly all of the turn is in the last tenth", 2e-3,
    )  # fmt: skip
    jump = [
        _piece(0.5 * LENGTH, 6, thick, young=1e4 * YOUNG),
        _piece(0.5 * LENGTH, 6, thick),
    ]
    yield _turned(
        family, "stiffness jump 1e4", jump, QUARTER, "a stiff half carries a soft one", 1e-3
    )  # fmt: skip
    unlike = [
        _piece(0.5 * LENGTH, 6, thick),
        _piece(1e-5 * LENGTH, 1, thick),
        _piece((0.5 - 1e-5) * LENGTH, 6, thick),
    ]
    yield _turned(
        family, "neighbouring elements 1:1e4 as segments", unlike, 2.0 * QUARTER,
        "an element 1e4 times shorter than its neighbours, half a circle", 1e-3,
    )  # fmt: skip
    both = [
        _piece(0.5 * LENGTH, 6, thick, young=1e4 * YOUNG),
        _piece(1e-5 * LENGTH, 1, thick),
        _piece((0.5 - 1e-5) * LENGTH, 6, thick),
    ]
    yield _turned(
        family, "stiffness jump 1e4 at an element 1e4 times shorter", both, QUARTER, "both at once", 1e-3
    )


def _piece(length: float, elements: int, section: Scene, young: float = YOUNG, **more: Any) -> Scene:
    material = {"young_modulus": young, "poisson_ratio": 0.3, "density": 1070.0}
    return {"length": length, "elements": elements, "section": section, "material": material, **more}


def _turned(
    family: str, name: str, segments: list[Scene], angle: float, meaning: str, limit: float
) -> HardCase:
    """A rod of segments whose tip a moment turns by `angle`."""
    value = angle / quad(lambda x: 1.0 / stiffness(segments, x), 0.0, LENGTH, points=_joints(segments))[0]
    scene = {
        "rod": [{"segments": segments}],
        "moment": [{"value": [0.0, 0.0, value]}],
    }
    reason = "thin rod of the same stiffness; mesh, finite strain 1.4 (kappa R)^2, contraction at the joints"
    return HardCase(
        family, name, scene, meaning, limits=deviation(limit, reason), deviation=from_moment(segments, value)
    )


def stiffness(segments: list[Scene], x: float) -> float:
    """E I [N m2] of a rod of round segments at x [m]."""
    start = 0.0
    for segment in segments:
        if x <= start + segment["length"] or segment is segments[-1]:
            break
        start += segment["length"]
    first = segment["section"]["radius"]
    last = segment.get("section_end", segment["section"])["radius"]
    radius = first + (last - first) * (x - start) / segment["length"]
    return segment["material"]["young_modulus"] * math.pi * radius**4 / 4.0


def from_moment(segments: list[Scene], value: float) -> Deviation:
    """From the thin rod under a tip moment: theta' = M/(E I(x)), r' = (cos theta, sin theta)."""

    def deviation(solution: Solution) -> float:
        marks = [0.0, *_joints(segments), LENGTH]
        angle, r = 0.0, np.zeros(3)
        t, w = np.polynomial.legendre.leggauss(60)
        for a, b in pairwise(marks):
            x = 0.5 * (a + b) + 0.5 * (b - a) * t
            turn = np.array([quad(lambda s: value / stiffness(segments, s), a, p)[0] for p in x]) + angle
            r += 0.5 * (b - a) * np.array([w @ np.cos(turn), w @ np.sin(turn), 0.0])
            angle += quad(lambda s: value / stiffness(segments, s), a, b)[0]
        return tip_distance(solution, r)

    return deviation


def _joints(segments: list[Scene]) -> list[float]:
    """Where one segment ends and the next begins [m]."""
    return np.cumsum([segment["length"] for segment in segments])[:-1].tolist()
