"""Random rods, loads and deformed states for the property checks, from any source of numbers.

A property is measured on what a `Draws` hands out: NumPy's generator in the report, Hypothesis in the tests,
so that both
look at the same rods and Hypothesis can shrink the counterexample.

Symbols
-------
L, n_el   length of the rod [m], number of elements
R         largest radius of the section [m]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ancf.elements import ELEMENTS
from ancf.hyperelastic import Law, MooneyRivlin, NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.rod_model import RodModel, make_rod_model
from ancf.scene import Force, Frame, Gravity, LineLoad, Moment, Rod, Scene, Support
from ancf.sections import Annulus, Circle, Ellipse, Polygon, Rectangle, Section

Floats = NDArray[np.float64]
T = TypeVar("T")

LAWS = ("saint-venant-kirchhoff", "neo-hookean", "mooney-rivlin")
SHAPES = ("circle", "annulus", "ellipse", "rectangle", "polygon", "angle")
# Section quadrature of curved rods is exact to 1e-12 up to this curvature x radius (section_energy.py).
LARGEST_CURVATURE = 0.1
LARGEST_TURN = 0.5  # rad of reference curvature in one element
# Section vectors linear along an element (3243) shorten to cos(turn/2) between its ends, and det F in twist
# to the square: 0.1 here; at pi it is 0 or less, which the solver refuses, and rubber has no digits left.
LARGEST_BEND = 2.5  # rad by which one element of a state is bent and twisted, reference curvature included


class Draws(Protocol):
    """A source of random choices."""

    def number(self, low: float, high: float) -> float:
        """A number in [low, high]."""
        ...

    def choice(self, options: Sequence[T]) -> T:
        """One of the options."""
        ...


@dataclass(frozen=True)
class RngDraws:
    """Draws from a NumPy generator."""

    rng: np.random.Generator

    def number(self, low: float, high: float) -> float:
        """See `Draws.number`."""
        return float(self.rng.uniform(low, high))

    def choice(self, options: Sequence[T]) -> T:
        """See `Draws.choice`."""
        return options[int(self.rng.integers(len(options)))]


def random_vector(draws: Draws, size: float = 1.0) -> Floats:
    """Vector (3,) with components in [-size, size]."""
    return np.array([draws.number(-size, size) for _ in range(3)])


def random_rotation(draws: Draws) -> Floats:
    """Rotation matrix (3, 3) from a unit quaternion; written without ancf.rotation on purpose."""
    w, x, y, z = (draws.number(-1.0, 1.0) for _ in range(4))
    norm = np.sqrt(w * w + x * x + y * y + z * z)
    if norm < 1e-3:
        return np.eye(3)
    w, x, y, z = w / norm, x / norm, y / norm, z / norm
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def random_section(draws: Draws, size: float, shape: str | None = None) -> Section:
    """Section of about the given radius [m]; `angle` is a polygon that is neither convex nor symmetric."""
    shape = shape or draws.choice(SHAPES)
    ratio = draws.number(0.5, 0.95)
    if shape == "circle":
        return Circle(size)
    if shape == "annulus":
        return Annulus(size, ratio * size)
    if shape == "ellipse":
        return Ellipse(size, ratio * size)
    if shape == "rectangle":
        return Rectangle(2.0 * ratio * size, size)
    if shape == "angle":
        leg = 0.4 * size
        corners = [
            (0, 0),
            (2 * size, 0),
            (2 * size, leg),
            (leg, leg),
            (leg, 2 * ratio * size),
            (0, 2 * ratio * size),
        ]
        return Polygon(tuple((float(y), float(z)) for y, z in corners))
    count = draws.choice((3, 4, 5, 7))
    angle = 2.0 * np.pi * (np.arange(count) + [draws.number(-0.2, 0.2) for _ in range(count)]) / count
    radius = size * np.array([draws.number(0.6, 1.0) for _ in range(count)])
    far = draws.number(-3.0, 3.0) * size  # the centroid is found by the section
    return Polygon(
        tuple((float(far + r * np.cos(a)), float(r * np.sin(a))) for r, a in zip(radius, angle, strict=True))
    )


def random_law(draws: Draws, law: str, poisson_ratio: float) -> Law:
    """Material of any stiffness and density with the given Poisson ratio at small strain."""
    young, density = 10.0 ** draws.number(4.0, 11.0), draws.number(500.0, 8000.0)
    if law == "saint-venant-kirchhoff":
        return SaintVenantKirchhoff(young, poisson_ratio, density)
    if law == "neo-hookean":
        return NeoHookean(young, poisson_ratio, density)
    # mu = 2 (c10 + c01) = E/(2 (1 + nu)), K = E/(3 (1 - 2 nu)): interface.md, Scene file
    half_shear, share = young / (4.0 * (1.0 + poisson_ratio)), draws.number(0.0, 1.0)
    bulk = young / (3.0 * (1.0 - 2.0 * poisson_ratio))
    return MooneyRivlin(share * half_shear, (1.0 - share) * half_shear, bulk, density)


@dataclass(frozen=True)
class RodRange:
    """What a random rod may be; an element that knows no drawn formulation takes its own."""

    elements: tuple[int, ...] = (1, 2, 3, 5)
    slenderness: tuple[float, float] = (8.0, 150.0)  # L / R
    poisson_ratio: tuple[float, float] = (-0.5, 0.4999)
    curved: tuple[bool, ...] = (False, True)
    shapes: tuple[str, ...] = SHAPES
    laws: tuple[str, ...] = LAWS
    formulations: tuple[str, ...] = ("enhanced", "continuum")
    rules: tuple[str | int, ...] = ("default", "full", 4)
    supports: tuple[str, ...] = ("clamp",)
    shear_factors: tuple[bool, ...] = (False, True)


# What a cable may be (scene_cable.py).
CABLES: dict[str, Any] = {
    "curved": (False,),
    "shapes": ("circle", "annulus"),
    "laws": ("saint-venant-kirchhoff",),
    "shear_factors": (False,),
}


def random_rod(draws: Draws, element: str, allowed: RodRange | None = None) -> Rod:
    """Rod of the given element: any size, stiffness, section, base and stress-free curvature within
    `allowed`.
    """
    allowed = allowed or RodRange()
    if not ELEMENTS[element].has_section:
        allowed = replace(allowed, **CABLES)
    length = 10.0 ** draws.number(-2.0, 1.0)
    slenderness = draws.number(*allowed.slenderness)
    section = random_section(draws, length / slenderness, draws.choice(allowed.shapes))
    count = draws.choice(allowed.elements)
    curvature = np.zeros(3)
    if draws.choice(allowed.curved):
        most = min(LARGEST_TURN * count / length, LARGEST_CURVATURE / section.outer_radius)
        curvature = random_vector(draws, most / np.sqrt(3.0))
    formulation = draws.choice(allowed.formulations)
    if formulation not in ELEMENTS[element].formulations:
        formulation = ELEMENTS[element].formulations[0]
    factors = (1.0, 1.0)
    if formulation == "enhanced" and draws.choice(allowed.shear_factors):
        factors = (draws.number(0.6, 1.0), draws.number(0.6, 1.0))
    return Rod(
        name="rod",
        length=length,
        elements=count,
        section=section,
        material=random_law(draws, draws.choice(allowed.laws), draws.number(*allowed.poisson_ratio)),
        element=element,
        formulation=formulation,
        axial_rule=draws.choice(allowed.rules),
        base=Frame(random_vector(draws, 2.0 * length), random_rotation(draws)),
        supports=(Support(0.0, draws.choice(allowed.supports)),),
        curvature=curvature,
        shear_factors=factors,
    )


def random_model(draws: Draws, element: str, allowed: RodRange | None = None) -> RodModel:
    """Arrays of a random rod whose elements are unequal: a load stands off the uniform grid."""
    rod = random_rod(draws, element, allowed)
    marks = (Force(rod.name, draws.number(0.1, 0.9), np.ones(3)),) if draws.choice((False, True)) else ()
    return make_rod_model(Scene((rod,), forces=marks), rod, 0)


def bent_state(model: RodModel, turn: Floats) -> Floats:
    """Nodal vectors (n_nodes, vectors, 3) of a rod whose sections turn by up to `turn` (3,) [rad]."""
    fraction = model.mesh.node_x / model.rod.length
    rotations = _rodrigues(fraction[:, None] * turn)
    middle = _rodrigues(0.5 * (fraction[1:] + fraction[:-1])[:, None] * turn)
    q = np.einsum("nij,nvj->nvi", rotations, model.q0)
    steps = np.einsum("nij,nj->ni", middle, np.diff(model.q0[:, 0], axis=0))
    q[:, 0] = np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    return q


def random_turn(draws: Draws, model: RodModel, size: float = 2.0) -> Floats:
    """Rotation vector (3,) [rad] for `bent_state`, components in [-size, size], within `LARGEST_BEND`."""
    turn = random_vector(draws, size)
    most = LARGEST_BEND / float(np.max(model.mesh.h)) - float(np.linalg.norm(model.rod.curvature))
    return turn / max(1.0, float(np.linalg.norm(turn)) / (most * model.rod.length))


def random_state(draws: Draws, model: RodModel, strain: float = 0.05) -> Floats:
    """Nodal vectors (n_nodes, vectors, 3): bent, twisted, turned, and strained by about `strain`."""
    q = bent_state(model, random_turn(draws, model))
    h, radius = float(np.min(model.mesh.h)), model.rod.section.outer_radius
    # Second-order section vectors c strain by R c and by R^2 c/h: small enough for both.
    second = min(radius, h) / radius**2
    per_vector = np.array(
        [second if j + k == 2 else h ** (1 - i - j - k) for i, j, k in model.element.vectors]
    )
    # From a drawn seed: hundreds of single draws would be slow, and could all be zero.
    noise = np.random.default_rng(draws.choice(range(2**16))).uniform(-1.0, 1.0, q.shape)
    return (q + 0.5 * strain * noise * per_vector[:, None]) @ random_rotation(draws).T


def random_loads(draws: Draws, rod: Rod, size: float = 1.0, kinds: tuple[str, ...] = ()) -> Scene:
    """Scene with the rod and one to three loads of about `size` E I / L (moments), E I / L^2 (forces).

    kinds : of ``moment``, ``force``, ``line_load``, ``gravity`` (dead) and ``follower``; by default all that
        the element carries
    """
    on_axis = not ELEMENTS[rod.element].has_section
    kinds = kinds or ("moment", "force", "line_load", "gravity", "follower")[on_axis : 4 if on_axis else 5]
    I = float(np.linalg.eigvalsh(rod.section.second_moments)[0])  # noqa: E741
    moment = size * rod.material.young_modulus * I / rod.length
    force = moment / rod.length
    scene = {"moments": (), "forces": (), "line_loads": (), "gravity": None}
    for _ in range(draws.choice((1, 2, 3))):
        kind, at = draws.choice(kinds), draws.choice((1.0, 0.7, 0.45))
        direction = "follower" if kind == "follower" else "fixed"
        what = draws.choice(("moments", "forces", "line_loads")) if kind == "follower" else kind + "s"
        if what == "moments":
            scene[what] += (Moment(rod.name, at, random_vector(draws, moment), direction),)
        elif what == "forces":
            offset = np.array([draws.number(-0.3, 0.3), draws.number(-0.3, 0.3)]) * rod.section.outer_radius
            offset *= not on_axis
            scene[what] += (Force(rod.name, at, random_vector(draws, force), offset, direction),)
        elif what == "line_loads":
            scene[what] += (LineLoad(rod.name, random_vector(draws, force / rod.length), direction),)
        else:
            density = rod.material.density or 1.0
            weight = density * rod.section.area * rod.length
            scene["gravity"] = Gravity(random_vector(draws, force / weight))
    return Scene((rod,), **scene)


def _rodrigues(v: Floats) -> Floats:
    """Rotations (n, 3, 3) of rotation vectors v (n, 3)."""
    angle = np.linalg.norm(v, axis=1)
    axis = v / np.where(angle > 0.0, angle, 1.0)[:, None]
    x, y, z = axis.T
    zero = np.zeros_like(x)
    K = np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
    sine, cosine = np.sin(angle)[:, None, None], np.cos(angle)[:, None, None]
    return np.eye(3) + sine * K + (1.0 - cosine) * (K @ K)
