"""Exhibits of the gallery: each scene of the field with one number, where that comes from, and its limit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancf.obstacles import Cylinder
from ancf.scene import Scene
from ancf.solution import Solution
from reference.actuation import MU_0, magnet_tip
from reference.arch import Arch
from reference.arch_path import critical_points
from reference.arcs import Piece, chain_tip, concentric_curvature
from reference.buckling import euler_load
from reference.catenary import hanging_cable
from reference.elastica import buckled_tip
from reference.rod import RodLoads, RodProperties, solve_rod
from reference.spring import Helix, pulled_spring
from reference.tendon_arm import ArmSection, ArmTendon, tendon_arm_tip

Floats = NDArray[np.float64]

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
ARM_TOLERANCE = 1e-7  # of the shooting: far below the limits, and quick


@dataclass(frozen=True)
class Exhibit:
    """A scene of examples/ with what is measured on it, and against what.

    `measured` and `expected` are numbers or vectors in `unit`; their difference is divided by `scale`, a
    length, or by the size of `expected` if None. `view` and `up` point the camera, where the program's choice
    is bad.
    """

    name: str
    shows: str
    quantity: str
    unit: str
    measured: Callable[[Solution], ArrayLike]
    expected: Callable[[Scene], ArrayLike]
    scale: Callable[[Scene], float] | None
    source: str
    limit: float
    reason: str
    field: str | None = None
    view: tuple[float, float, float] | None = None
    up: tuple[float, float, float] | None = None
    ghost: bool = True

    @property
    def path(self) -> Path:
        """Scene file."""
        return EXAMPLES / f"{self.name}.toml"


@dataclass(frozen=True)
class Numbers:
    """Length, outer radius, Young's modulus, Poisson's ratio, area, EA and EI of a round rod, SI."""

    L: float
    R: float
    E: float
    nu: float
    A: float
    EA: float
    EI: float


def _numbers(rod: Any) -> Numbers:
    E, A = rod.material.young_modulus, rod.section.area
    nu, R = rod.material.poisson_ratio, rod.section.outer_radius
    return Numbers(rod.length, R, E, nu, A, E * A, E * rod.section.weaker_second_moment)


def _first(scene: Scene) -> Numbers:
    return _numbers(scene.rods[0])


def _tip(solution: Solution) -> Floats:
    return solution.tip().position


def _length(scene: Scene) -> float:
    return scene.rods[0].length


def _tendon_arm(scene: Scene) -> Floats:
    rod = scene.rods[0]
    parts: list[Any] = [(part.length, part.section, part.material) for part in rod.parts]
    sections = [
        ArmSection(length, section.outer_radius, m.young_modulus, m.poisson_ratio, m.density or 0.0)
        for length, section, m in parts
    ]
    tendons = [ArmTendon(tendon.tension or 0.0, tendon.path) for tendon in scene.tendons]
    gravity = np.zeros(3) if scene.gravity is None else scene.gravity.acceleration
    return tendon_arm_tip(sections, tendons, rod.base.rotation, gravity, ARM_TOLERANCE)[0]


def _concentric(scene: Scene) -> Floats:
    EI = [_numbers(rod).EI for rod in scene.rods]
    curvature = concentric_curvature(EI, [float(rod.curvature[2]) for rod in scene.rods])
    return chain_tip([Piece(_length(scene), (0.0, 0.0, curvature))], scene.rods[0].base.rotation)[0]


def _finger(scene: Scene) -> Floats:
    n, (chamber,) = _first(scene), scene.pressures
    thrust = chamber.value * math.pi * chamber.radius**2
    curvature = (0.0, 0.0, -thrust * float(chamber.centre[0]) / n.EI)
    bent = Piece((chamber.end - chamber.start) * n.L, curvature, 1.0 + thrust / n.EA)
    return chain_tip([Piece(chamber.start * n.L), bent, Piece((1.0 - chamber.end) * n.L)])[0]


def _cable_sag(scene: Scene) -> float:
    n, rod = _first(scene), scene.rods[0]
    assert scene.gravity is not None
    weight = (rod.material.density or 0.0) * n.A * float(np.linalg.norm(scene.gravity.acceleration))
    span = n.L + float(scene.joints[1].displacement[0])
    return -hanging_cable(n.L, span, weight, n.EA).sag


def _spring_force(scene: Scene) -> float:
    n, rod = _first(scene), scene.rod("spring")
    helix = Helix(n.L, float(rod.curvature[2]), float(rod.curvature[0]))
    GJ = n.EI / (1.0 + n.nu)  # G = E/(2 (1 + nu)), J = 2 I of a circle
    return pulled_spring(helix, n.EI, GJ, float(scene.joints[-1].displacement[2]))[0]


def _vine(scene: Scene) -> Floats:
    rod = scene.rods[-1]
    n = _numbers(rod)
    assert scene.gravity is not None
    properties = RodProperties.circle(
        n.L, n.R, n.E, n.nu, base_position=rod.base.position, base_rotation=rod.base.rotation
    )
    weight = (rod.material.density or 0.0) * n.A * scene.gravity.acceleration
    return solve_rod(properties, RodLoads(line_load=weight)).position[0]


def _catheter(scene: Scene) -> Floats:
    n, (magnet,) = _first(scene), scene.magnets
    size = float(np.linalg.norm(magnet.field))
    couple = float(magnet.remanence[0]) * size * n.A / MU_0
    return magnet_tip(n.L, n.EI, couple, math.atan2(magnet.field[1], magnet.field[0]))[0]


def _column(scene: Scene) -> Floats:
    n, (force,) = _first(scene), scene.forces
    tip = buckled_tip(float(np.linalg.norm(force.value)) / euler_load(n.EI, n.L))
    return n.L * np.array([tip.y, tip.x])


def _arch_load(scene: Scene) -> float:
    n, rod = _first(scene), scene.rods[0]
    opening = -float(rod.curvature[2]) * n.L
    return critical_points(Arch.circle(n.L, n.R, opening, n.E, n.nu))[0].load


def _arch_maximum(solution: Solution) -> float:
    assert solution.stability is not None
    point = next(p for p in solution.stability.critical_points if p.kind == "limit")
    return point.load_factor * float(np.linalg.norm(solution.scene.forces[0].value))


def _feet(solution: Solution) -> Floats:
    """Sum of the forces of the ground."""
    return np.sum([joint.force for joint in solution.joints if joint.joint.b is None], axis=0)


def _reach(solution: Solution) -> float:
    """Largest y of the arm's skin [m]: of its axis, which is parallel to the wall there, and its radius."""
    y = solution.displaced(None, np.linspace(0.0, 1.0, 401), np.zeros(1), np.zeros(1))[:, 1]
    return float(y.max()) + _first(solution.scene).R


def _gap(solution: Solution) -> list[float]:
    """Least distance [m] of the axis of each finger from that of its cylinder."""
    found = []
    for contact in solution.scene.contacts:
        body = contact.obstacle
        assert isinstance(body, Cylinder)
        axis = solution.displaced(contact.rod, np.linspace(0.0, 1.0, 801), np.zeros(1), np.zeros(1))
        found.append(float(np.linalg.norm(np.cross(axis - body.point, body.axis), axis=1).min()))
    return found


EXHIBITS = (
    Exhibit(
        "tendon-arm",
        "A hanging silicone arm with a straight and a helical tendon (dark lines), and its weight.",
        "tip", "m", _tip, _tendon_arm, _length,
        "rod boundary-value problem by shooting, reference/tendon_arm.py (Rucker, Webster 2011)",
        4e-3, "rubber under 2 % of compression is stiffer than the rod's linear law by about as much",
        view=(0.75, -1.0, 0.25),
    ),
    Exhibit(
        "two-section-arm",
        "Two sections of different thickness, each with its own tendon: bent in two planes.",
        "tip", "m", _tip, _tendon_arm, _length,
        "rod boundary-value problem by shooting, reference/tendon_arm.py; two arcs (Webster, Jones 2010)",
        1.5e-2, "rubber under 1 % of compression is stiffer than the rod's linear law by about as much",
        field="curvature", view=(-1.0, -0.55, 0.5),
    ),
    Exhibit(
        "concentric-tubes",
        "A pre-curved wire in a tube that is curved the other way: they meet at the stiffer one's side.",
        "tip", "m", _tip, _concentric, _length,
        "sum(EI k)/sum(EI), reference/arcs.py (Webster, Romano, Cowan 2009)",
        1e-3, "the radius of the tube times its curvature, squared",
        field="axial strain", view=(1.0, 0.25, 0.2), up=(0.0, 0.0, 1.0),
    ),
    Exhibit(
        "pneumatic-finger",
        "A closed chamber (blue) off the axis: its thrust bends and stretches the finger.",
        "tip", "m", _tip, _finger, _length,
        "thin rod: an arc of curvature p A_c d/(E I) and stretch 1 + p A_c/(E A), reference/arcs.py",
        5e-2, "a finger of 1:5 at 10 % of strain: second order in both",
    ),
    Exhibit(
        "arm-pushing-wall",
        "A tendon bends the arm against a wall; the tip slides along it.",
        "reach of the skin", "m", _reach, lambda scene: 0.06, lambda scene: 0.006,
        "geometry: the wall is 6 cm from the root",
        1e-3, "penetration, of the radius, also between the points that contact looks at",
        view=(1.0, 0.2, 0.25),
    ),
    Exhibit(
        "gripper",
        "Three fingers, each closed by a tendon, hold a cylinder.",
        "distance of the axes from the cylinder's", "m", _gap, lambda scene: [0.031] * 3,
        lambda scene: 0.006,
        "geometry: the radii of cylinder and finger",
        1e-3, "penetration, of the radius, also between the points that contact looks at",
        view=(1.0, 0.25, 0.3),
    ),
    Exhibit(
        "hanging-cable",
        "A cable between two hinges that were moved together while it sagged.",
        "height of the middle", "m", lambda s: float(s.pose(None, 0.5).position[2]), _cable_sag, _length,
        "elastic catenary (Irvine 1981), reference/catenary.py",
        1e-3, "bending stiffness, which a catenary has not, and 1 % of strain",
        field="stress",
    ),
    Exhibit(
        "helical-spring",
        "Five coils, a rod that is a helix when free, pulled along their axis by half their length.",
        "force", "N", lambda s: float(s.joints[-1].force[2]), _spring_force, None,
        "Kirchhoff's and Love's helix under a wrench (Love, art. 271), reference/spring.py",
        2e-2, "the arms at its ends keep their length where the coils become narrower: an effect of 1/coils",
        field="stress", view=(0.6, -1.0, 0.35),
    ),
    Exhibit(
        "growing-vine",
        "One vine at five lengths, started at 60 degrees: short it stands, long it hangs.",
        "tip of the longest", "m", lambda s: s.tip("vine5").position, _vine,
        lambda scene: scene.rods[-1].length,
        "rod boundary-value problem, reference/rod.py",
        3e-3, "up to 7 % of strain at the root, where the law departs from a linear one",
        field="curvature", view=(-0.15, -1.0, 0.25), ghost=False,
    ),
    Exhibit(
        "magnetic-catheter",
        "A catheter magnetised along its axis in a uniform field (arrows) across it.",
        "tip", "m", _tip, _catheter, _length,
        "inextensible rod by collocation, reference/actuation.py",
        1e-3, "mesh of 12 elements where the rod turns within a quarter of its length",
        field="curvature", view=(0.25, -0.35, 1.0), up=(0.0, 1.0, 0.0),
    ),
    Exhibit(
        "parallel-robot",
        "Three rods carry a platform; their feet are moved up and down, which tilts it.",
        "sum of the ground's forces", "N", _feet, lambda scene: -scene.forces[0].value, None,
        "statics: the ground carries the load",
        1e-9, "equilibrium to the solver's tolerance",
        field="curvature", view=(1.0, -1.3, 0.55),
    ),
    Exhibit(
        "buckled-column",
        "A perfect column a third above its Euler load, on its buckled branch.",
        "tip across and along", "m", lambda s: np.abs(_tip(s)[1:]), _column, _length,
        "elastica in elliptic integrals, reference/elastica.py",
        2e-3, "the column shortens and is 1:50 thick, and has 16 elements",
        field="curvature", view=(1.0, 0.35, 0.15),
    ),
    Exhibit(
        "shallow-arch",
        "A clamped arch snaps through: the path is followed by its arc to the full load.",
        "first maximum of the load", "N", _arch_maximum, _arch_load, None,
        "spectral collocation of the arch, reference/arch_path.py",
        2e-3, "mesh of 16 elements",
        field="curvature", view=(0.2, 0.45, 1.0), up=(0.0, 1.0, 0.0),
    ),
)  # fmt: skip
