"""Hard starts and places: far bases, perturbed starts, absurd loads, contradictory supports."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from ancf.model import Model
from validation.hard_case import REFUSED, TYPED, Floats, HardCase
from validation.hard_limits import MESH_CIRCLE, MESH_QUARTER, deviation, thin
from validation.hard_scenes import (
    BOTH_ENDS,
    FULL_CIRCLE,
    QUARTER,
    arm,
    force,
    from_arc,
    from_reference,
    moment,
    rolled,
)


def starts() -> Iterator[HardCase]:
    """All families of this module."""
    yield from _starts()
    yield from _absurd()
    yield from _supports()


def _starts() -> Iterator[HardCase]:
    family = "start and place"
    yield HardCase(
        family,
        "base 1e6 m away, full circle",
        rolled(FULL_CIRCLE, 40, base={"position": [1e6, 1e6, -1e6]}),
        "same digits as at the origin",
        limits=thin(FULL_CIRCLE, 40, MESH_CIRCLE),
        deviation=from_arc(FULL_CIRCLE),
    )
    for name, start, meaning in (
        ("noise of 1 % L", _noise, "every coordinate of the start is wrong; the answer is unique"),
        ("the rod bent the wrong way", _mirrored, "the start is the answer of the opposite load"),
    ):
        yield HardCase(
            family,
            f"quarter circle from {name}",
            rolled(QUARTER, 400),
            meaning,
            limits=thin(QUARTER, 400, MESH_QUARTER),
            deviation=from_arc(QUARTER),
            start=start,
        )
    yield HardCase(
        family,
        "no load, from a quarter circle",
        arm(400),
        "a rod let go returns to its reference",
        limits=deviation(1e-9, "exact: nothing but rounding is left"),
        deviation=from_reference,
        start=_quarter,
    )
    yield HardCase(
        family,
        "two opposite tip forces",
        arm(force=[force([0, 50, 0]), force([0, -50, 0])]),
        "contradictory loads cancel exactly",
        limits=deviation(1e-12, "the loads cancel to the last bit"),
        deviation=from_reference,
    )


def _absurd() -> Iterator[HardCase]:
    family = "absurd loads"
    still = deviation(1e-15, "nothing is divided by the load")
    yield HardCase(
        family,
        "no load at all",
        arm(),
        "nothing is divided by the load",
        limits=still,
        deviation=from_reference,
    )
    for size in ("0", "1e-300"):
        yield HardCase(
            family,
            f"tip force {size} N",
            arm(force=[{"value": [0.0, float(size), 0.0]}]),
            "nothing is divided by the load",
            limits=still,
            deviation=from_reference,
        )
    huge: dict[str, Any] = {
        "tip force 1e300 N": arm(force=[{"value": [0.0, 1e300, 0.0]}]),
        "tip moment 1e300 N m": arm(moment=[{"value": [0.0, 0.0, 1e300]}]),
        "follower force 1e300 N": arm(force=[{"value": [0.0, 1e300, 0.0], "direction": "follower"}]),
        "gravity 1e300 m/s2": arm(gravity={"acceleration": [0.0, 0.0, -1e300]}),
        "line load 1e300 N/m": arm(line_load=[{"value": [0.0, 0.0, -1e300]}]),
    }
    for name, scene in huge.items():
        yield HardCase(
            family,
            name,
            scene,
            "overflows: a typed reason, nothing that is not finite",
            TYPED,
            "stiffness|overflow",
        )


def _supports() -> Iterator[HardCase]:
    family = "supports"
    yield HardCase(
        family,
        "clamped at both ends, moment at the middle",
        arm(moment=[moment([0, 0, 10.0], at=0.5)], supports=BOTH_ENDS),
        "statically indeterminate, no predictor",
        walk="quick",
    )
    yield HardCase(
        family,
        "clamped at both ends, twisted and bent at the middle",
        arm(400, moment=[moment([6.0, 0, 6.0], 400, at=0.5)], supports=BOTH_ENDS),
        "bending and torsion at once in a rod that cannot move its ends",
    )
    yield HardCase(
        family,
        "pinned at one end only",
        arm(supports=[{"at": 0.0, "kind": "pin"}], force=[{"value": [0, 0.01, 0]}]),
        "a mechanism: refused before anything is computed (exit code 2)",
        REFUSED,
        "rigid body",
    )
    yield HardCase(
        family,
        "clamp and pin on the same section",
        arm(supports=[{"at": 0.0, "kind": "clamp"}, {"at": 0.0, "kind": "pin"}]),
        "contradictory supports are refused (exit code 2)",
        REFUSED,
        "same section",
    )
    yield HardCase(
        family,
        "more supports than elements can hold",
        arm(elements=1, supports=[{"at": at, "kind": "clamp"} for at in (0.0, 0.5, 1.0)]),
        "supports closer than elements are refused (exit code 2)",
        REFUSED,
        "element",
    )


def _noise(model: Model) -> Floats:
    """The reference with noise of 1 % in every dimensionless coordinate; seeded."""
    return model.q0 + 0.01 * model.unit * np.random.default_rng(20230811).uniform(-1.0, 1.0, model.n)


def _bent(model: Model, angle: float) -> Floats:
    """All rods, along x, on the arc that turns by `angle` about z, section vectors with them."""
    found = []
    for rod in model.rods:
        x = rod.mesh.node_x / rod.rod.length
        turn = angle * x
        q = rod.q0.copy()
        cosine, sine = np.cos(turn)[:, None], np.sin(turn)[:, None]
        q[..., 0], q[..., 1] = cosine * q[..., 0] - sine * q[..., 1], sine * q[..., 0] + cosine * q[..., 1]
        along, across = np.sinc(turn / np.pi), np.sin(turn / 2) * np.sinc(turn / (2 * np.pi))
        q[:, 0] = (rod.rod.length * x)[:, None] * np.stack([along, across, 0.0 * x], axis=-1)
        found.append(q.ravel())
    return np.concatenate(found)


def _mirrored(model: Model) -> Floats:
    return _bent(model, -QUARTER)


def _quarter(model: Model) -> Floats:
    return _bent(model, QUARTER)
