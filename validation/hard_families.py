"""Hard shapes: slender rods, many turns, Poisson ratios, moduli, meshes, torsion, far bases, other starts."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ancf.model import Model
from validation.criteria import Limit
from validation.hard_case import TYPED, Floats, HardCase
from validation.hard_scenes import (
    FULL_CIRCLE,
    QUARTER,
    arm,
    force,
    from_arc,
    from_helix,
    from_reference,
    moment,
    rolled,
)

# Finite strain of Saint Venant-Kirchhoff turns a rod further than a thin one by 1.375 (kappa R)^2 (theory.md 2);
# the tip of a full circle then misses its base by about as many rod lengths.
FINITE_STRAIN = 1.375
# What 12 elements 3333 leave of a full circle, and of a quarter: theory.md 3 and README.md, with room for 2.
MESH_CIRCLE, MESH_QUARTER = 1e-3, 1e-4
COMING = 60  # iterations in all that the issue allows from the straight shape, without predictor


def deviation(value: float, reason: str) -> tuple[Limit, ...]:
    """Limit of the tip's distance from the exact answer; a bound on the model, met or not."""
    return (Limit("deviation", value, "L", reason, kind="non-regression"),)


def thin(angle: float, slenderness: float, mesh: float) -> tuple[Limit, ...]:
    """Limit of the distance from the thin arc or helix: finite strain, then the mesh."""
    strain = 1.5 * FINITE_STRAIN * (angle / slenderness) ** 2
    value = float(f"{strain + mesh:.1e}")
    return deviation(
        value, f"finite strain 1.375 (kappa R)^2 = {strain / 1.5:.1e}, mesh {mesh:.0e}; half as much again"
    )


def shapes() -> Iterator[HardCase]:
    """All families of this module."""
    yield from _slender()
    yield from _turns()
    yield from _materials()
    yield from _meshes()
    yield from _torsion()
    yield from _starts()


def _slender() -> Iterator[HardCase]:
    family = "slenderness"
    yield HardCase(
        family,
        "full circle, L/R = 5",
        rolled(FULL_CIRCLE, 5),
        "kappa R = 1.26: the moment exceeds the largest that the section of Saint Venant-Kirchhoff carries",
        TYPED,
    )
    said = {
        40: "the tip comes back to the base; finite strain turns it further",
        400: "the same, a hundred times less finite strain",
        4000: "float64 positions leave a residual of 6e-7 here; the floor is reported",
    }
    for slenderness, meaning in said.items():
        limits = thin(FULL_CIRCLE, slenderness, MESH_CIRCLE)
        name = f"full circle, L/R = {slenderness}"
        scene = rolled(FULL_CIRCLE, slenderness)
        yield HardCase(family, name, scene, meaning, limits=limits, deviation=from_arc(FULL_CIRCLE))
    yield HardCase(
        family,
        "full circle, L/R = 40000",
        rolled(FULL_CIRCLE, 40000, elements=24),
        "axial over bending stiffness 6e9: the floor of the residual is 1e-4, the answer is still an arc",
        limits=thin(FULL_CIRCLE, 40000, MESH_CIRCLE),
        deviation=from_arc(FULL_CIRCLE),
    )


def _turns() -> Iterator[HardCase]:
    for turns in (2, 4):
        angle = turns * FULL_CIRCLE
        yield HardCase(
            "turns",
            f"{turns} turns, L/R = 400",
            rolled(angle, 400, elements=12 * turns),
            "twelve elements a turn; the tip comes back to the base each time",
            limits=thin(angle, 400, MESH_CIRCLE),
            deviation=from_arc(angle),
        )


def _materials() -> Iterator[HardCase]:
    near = deviation(2e-3, "1.375 (kappa R)^2 = 2.1e-3 in angle; less where nu changes the section's part")
    for nu in (0.0, 0.3, 0.49, 0.4999, 0.499999):
        yield HardCase(
            "Poisson ratio",
            f"nu = {nu:g}, 90 degrees",
            rolled(QUARTER, nu=nu),
            "no Poisson locking with the enhanced law, however near to incompressible",
            limits=near,
            deviation=from_arc(QUARTER),
        )
    for young in (1e2, 1e4, 1e8, 1e10, 1e12):
        yield HardCase(
            "modulus",
            f"E = {young:.0e} Pa, 90 degrees".replace("e+0", "e").replace("e+", "e"),
            rolled(QUARTER, young=young),
            "the tolerance is dimensionless: same digits",
            limits=near,
            deviation=from_arc(QUARTER),
        )


def _meshes() -> Iterator[HardCase]:
    family = "mesh"
    one = deviation(5e-2, "one quadratic element for a quarter circle: 2.8e-3 with two (theory.md 3)")
    fine = thin(QUARTER, 400, MESH_QUARTER)
    exact = from_arc(QUARTER)
    for elements, limits in ((1, one), (200, fine), (1000, fine)):
        yield HardCase(
            family,
            f"{elements} elements, 90 degrees".replace("1 elements", "1 element"),
            rolled(QUARTER, 400, elements=elements),
            "cost grows linearly, the floor with the number of elements" if elements > 1 else "the coarsest mesh",
            limits=limits,
            deviation=exact,
        )
    short = 0.5 / 6 * 1e-4  # of the length: 1e-4 of its neighbours, 6 elements on half a rod
    couple = [
        moment([0, 0, QUARTER], 400),
        moment([0, 0, 1.0], 400, at=0.5),
        moment([0, 0, -1.0], 400, at=0.5 + short),
    ]
    yield HardCase(
        family,
        "neighbouring elements 1 : 1e4",
        arm(400, moment=couple, elements=13),
        "two moments that cancel stand 8e-6 L apart, and an element between them; they turn the rod by as much",
        limits=thin(QUARTER, 400, MESH_QUARTER),
        deviation=exact,
    )
    for element, limit, why in (
        ("3363", thin(FULL_CIRCLE, 400, MESH_CIRCLE)[0].value, "as 3333"),
        ("3243", 0.5, "curvature-thickness locking (theory.md 3): not the limit of a good element"),
    ):
        yield HardCase(
            family,
            f"full circle, element {element}",
            rolled(FULL_CIRCLE, 400, element=element, elements=24),
            "the other elements",
            limits=deviation(limit, why),
            deviation=from_arc(FULL_CIRCLE),
        )


def _torsion() -> Iterator[HardCase]:
    family = "torsion"
    # Four turns in all: |M| L/EI = 8 pi, in no special direction.
    oblique = 8.0 * math.pi * np.array([0.48, 0.6, 0.64])
    for direction in ("fixed", "follower"):
        yield HardCase(
            family,
            f"oblique {direction} moment, 4 turns",
            arm(400, moment=[moment(oblique, 400, direction=direction)], elements=48),
            "bending and twist together; the moment "
            + ("is fixed in space" if direction == "fixed" else "turns with the section"),
            limits=thin(8.0 * math.pi, 400, MESH_CIRCLE),
            deviation=from_helix(direction),
        )
    iterations = Limit(
        "iterations", COMING, "-", "required by the issue: from the straight shape, without predictor",
        kind="non-regression",
    )  # fmt: skip
    for slenderness in (40, 400):
        load = moment([1.5, 0.0, FULL_CIRCLE], slenderness)
        yield HardCase(
            family,
            f"full circle with torsion, no predictor, L/R = {slenderness}",
            arm(slenderness, moment=[load], solver={"predictor": "none"}),
            "from the straight shape: the first full step stretches axis and sections",
            limits=(*thin(math.hypot(1.5, FULL_CIRCLE), slenderness, MESH_CIRCLE), iterations),
            deviation=from_helix(),
        )


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


def _noise(model: Model) -> Floats:
    """The reference with noise of 1 % in every dimensionless coordinate; seeded."""
    return model.q0 + 0.01 * model.unit * np.random.default_rng(20230811).uniform(-1.0, 1.0, model.n)


def _bent(model: Model, angle: float) -> Floats:
    """The rod on the arc that turns by `angle` about z: positions, and section vectors turned with it."""
    rod = model.rods[0]
    x = rod.mesh.node_x / rod.rod.length
    turn = angle * x
    along = x * np.sinc(turn / np.pi)
    across = x * np.sin(turn / 2) * np.sinc(turn / (2 * np.pi))
    q = rod.q0.copy()
    cosine, sine = np.cos(turn), np.sin(turn)
    for k in range(1, q.shape[1]):
        q[:, k, 0], q[:, k, 1] = cosine * q[:, k, 0] - sine * q[:, k, 1], sine * q[:, k, 0] + cosine * q[:, k, 1]
    q[:, 0] = rod.rod.length * np.stack([along, across, 0.0 * x], axis=-1)
    return q.ravel()


def _mirrored(model: Model) -> Floats:
    return _bent(model, -0.5 * math.pi)


def _quarter(model: Model) -> Floats:
    return _bent(model, 0.5 * math.pi)
