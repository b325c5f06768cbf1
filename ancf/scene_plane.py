r"""The plane of a scene: rods and loads that are their own mirror images in it stay in it.

With the unit normal n of a plane through the axes of all rods, the mirror image of a vector is a - 2 (a . n)
n. A scene is its own image if

    axes, forces, levers, anchors, tendons, chambers, magnets and their field lie in it    a . n = 0,
    curvatures and moments, axial vectors, stand across it                                 a x n = 0,
    stiffness matrices of springs and beds have n as a principal axis                      k n x n = 0,
    every section is its own image, and the element and the law see it so.

Then the energy of a shape and of its image are equal, so that the equilibrium that is in the plane stays
there, until another one turns off (planar_model.py looks for it).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ancf.elements import ELEMENTS
from ancf.errors import Message
from ancf.materials import SaintVenantKirchhoff
from ancf.rotation import hat
from ancf.scene import Rod, Scene
from ancf.sections import Annulus, Circle, Ellipse, Polygon, Section

Floats = NDArray[np.float64]

# Share of a vector that may point out of the plane: rounding of a turned base and of the normal.
ROUNDING = 16.0 * float(np.finfo(float).eps)


# What of a scene this module knows, or need not know; anything else may point anywhere.
KNOWN = frozenset(
    (
        *("rods", "moments", "forces", "line_loads", "line_moments", "gravity", "magnets", "tendons"),
        *("pressures", "springs", "foundations", "joints", "solver", "stability", "title"),
    )
)


UNKNOWN = tuple(field.name for field in fields(Scene) if field.name not in KNOWN)


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane by its axes (3, 3), as columns in SCS: two in the plane, then the normal."""

    axes: Floats

    @cached_property
    def rows(self) -> tuple[tuple[float, ...], ...]:
        """Rows of the axes."""
        return tuple(tuple(row) for row in self.axes.tolist())

    @property
    def normal(self) -> Floats:
        """Unit normal (3,)."""
        return self.axes[:, 2]

    def __str__(self) -> str:
        """The normal, to six digits."""
        return ", ".join(f"{component + 0.0:.6g}" for component in self.normal)

    def in_section(self, rod: Rod) -> tuple[float, float]:
        """The normal in the section axes (y, z) of a rod."""
        _, y, z = rod.base.rotation.T @ self.normal
        return float(y), float(z)

    def is_along_axis(self, rod: Rod) -> bool:
        """Whether the normal is along the y or the z axis of the sections of a rod."""
        return is_along_axis(self.in_section(rod))


def is_along_axis(normal: tuple[float, float]) -> bool:
    """Whether a normal in the section axes (y, z) is along one of them."""
    return min(map(abs, normal)) <= ROUNDING


@dataclass(frozen=True, eq=False)
class Part:
    """A vector (3,) of a scene in SCS and how it has to stand: in the plane, or across it."""

    where: str
    what: str
    vector: Floats
    across: bool = False


@dataclass(frozen=True, eq=False)
class Directions:
    """The vectors of a scene that are not zero, as unit vectors (n, 3), and which have to stand across."""

    parts: list[Part]
    units: Floats
    across: NDArray[np.bool_]

    def leave(self, plane: Plane) -> Floats:
        """Share (n,) of each vector on the wrong side, 0 to 1."""
        along = self.units @ plane.normal
        wrong = self.units - along[:, None] * plane.normal
        return np.where(self.across, np.sqrt(np.einsum("ni,ni->n", wrong, wrong)), np.abs(along))


def find_plane(scene: Scene) -> Plane | Message:
    """The plane in which a scene is its own mirror image, or what leaves the likeliest one."""
    directions = _directions(scene)
    first: Message | None = None
    for normal in _normals(scene, directions):
        plane = Plane(_axes(normal))
        reason = _leaving(scene, directions, plane)
        if reason is None:
            return plane
        first = first or reason
    assert first is not None
    return first


def _directions(scene: Scene) -> Directions:
    vectors = list(_vectors(scene))
    values = np.array([part.vector for part in vectors])
    size = np.abs(values).max(axis=1)
    there = np.flatnonzero(size > 0.0)
    units = values[there] / size[there, None]
    units /= np.sqrt(np.einsum("ni,ni->n", units, units))[:, None]
    parts = [vectors[i] for i in there]
    return Directions(parts, units, np.array([part.across for part in parts]))


def _vectors(scene: Scene) -> Iterator[Part]:
    """All that has a direction, the rods first; loads of zero magnitude are in every plane."""
    rods = {rod.name: rod for rod in scene.rods}
    for i, rod in enumerate(scene.rods):
        A_o = rod.base.rotation
        yield Part(f"rod[{i}].base", "the axis of the rod", A_o[:, 0])
        yield Part(f"rod[{i}].curvature", "the curvature of the rod", A_o @ rod.curvature, across=True)
    for i, moment in enumerate(scene.moments):
        yield Part(f"moment[{i}]", "the moment", moment.value, across=True)
    for i, force in enumerate(scene.forces):
        yield Part(f"force[{i}]", "the force", force.value)
        if np.any(force.value):
            yield Part(f"force[{i}].offset", "its lever", rods[force.rod].base.rotation[:, 1:] @ force.offset)
    for i, load in enumerate(scene.line_loads):
        yield Part(f"line_load[{i}]", "the line load", load.value)
    for i, load in enumerate(scene.line_moments):
        yield Part(f"line_moment[{i}]", "the line moment", load.value, across=True)
    if scene.gravity is not None:
        yield Part("gravity", "the weight", scene.gravity.acceleration)
    for i, magnet in enumerate(scene.magnets):
        if np.any(magnet.remanence) and np.any(magnet.field):
            remanence = rods[magnet.rod].base.rotation @ magnet.remanence
            yield Part(f"magnet[{i}].remanence", "the remanence", remanence)
            yield Part(f"magnet[{i}].field", "the field", magnet.field)
    for i, tendon in enumerate(scene.tendons):
        section_axes = rods[tendon.rod].base.rotation[:, 1:]
        for point in tendon.path if tendon.tension else []:
            yield Part(f"tendon[{i}].path", "a point of the tendon", section_axes @ point[1:])
    for i, chamber in enumerate(scene.pressures):
        if chamber.value:
            centre = rods[chamber.rod].base.rotation[:, 1:] @ chamber.centre
            yield Part(f"pressure[{i}].chamber", "the chamber", centre)
    for i, spring in enumerate(scene.springs):
        base = rods[spring.rod].base
        if np.any(spring.stiffness):
            yield Part(f"spring[{i}].offset", "its lever", base.rotation[:, 1:] @ spring.offset)
            if spring.anchor is not None:
                yield Part(f"spring[{i}].anchor", "the anchor", spring.anchor - base.position)


def _stiffnesses(scene: Scene) -> Iterator[tuple[str, Floats]]:
    """Stiffness matrices (3, 3) of springs to the reference and of beds, at the base of their rods."""
    for i, spring in enumerate(scene.springs):
        if spring.anchor is None:
            yield f"spring[{i}].stiffness", spring.stiffness
    for i, bed in enumerate(scene.foundations):
        axes = scene.rod(bed.rod).base.rotation if bed.axes is None else bed.axes
        yield f"foundation[{i}].stiffness", (axes * bed.stiffness) @ axes.T


def _normals(scene: Scene, directions: Directions) -> Iterator[Floats]:
    """Normals (3,) of the planes that a scene could have, the likeliest first.

    That of the first vector off the axis of the first rod, then that of the one farthest off, which is told
    best; of a rod loaded along its axis alone the planes of its sections' axes.
    """
    units = directions.units
    axis = scene.rods[0].base.rotation[:, 0]
    off = units - (units @ axis)[:, None] * axis
    normals = np.where(directions.across[:, None], off, units @ hat(axis).T)
    normals -= (normals @ axis)[:, None] * axis  # digits that a vector near the axis has lost
    sizes = np.sqrt(np.einsum("ni,ni->n", normals, normals))
    told = np.flatnonzero(sizes > ROUNDING)
    if len(told):
        yield normals[told[0]] / sizes[told[0]]
        best = int(np.argmax(sizes))
        yield normals[best] / sizes[best]
    yield scene.rods[0].base.rotation[:, 2]
    yield scene.rods[0].base.rotation[:, 1]


def _axes(normal: Floats) -> Floats:
    """Axes (3, 3) of a plane; exactly those of the SCS where the plane is one of its own."""
    main = int(np.argmax(np.abs(normal)))
    if max(abs(float(normal[main - 1])), abs(float(normal[main - 2]))) <= ROUNDING:
        return np.eye(3)[:, [(main + 1) % 3, (main + 2) % 3, main]]
    first = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(normal, first), normal]).astype(float)


def _leaving(scene: Scene, directions: Directions, plane: Plane) -> Message | None:
    """What keeps a scene from being its own image in a plane; None where nothing does."""
    if scene.joints:
        cause = "scenes with joints are solved in space"
        return _message("joint[0]", "joints = " + str(len(scene.joints)), cause, plane)
    for i, tendon in enumerate(scene.tendons):
        if tendon.length is not None or tendon.friction > 0.0:
            cause = "tendons with friction or of given length are solved in space"
            return _message(f"tendon[{i}]", f"rod {tendon.rod!r}", cause, plane)
    for name in UNKNOWN:
        if getattr(scene, name):
            cause = "nothing is known of its mirror image"
            return _message(name, f"the scene lists {name}", cause, plane)
    shares = directions.leave(plane)
    if np.max(shares) > ROUNDING:
        first = int(np.argmax(shares > ROUNDING))
        part = directions.parts[first]
        side = "in the plane" if part.across else "out of the plane"
        value = f"{shares[first]:.3g} of {part.what} points {side} across ({plane}), must be 0"
        cause = f"{part.what} leaves the plane of what comes before it"
        return _message(part.where, value, cause, plane)
    for where, k in _stiffnesses(scene):
        k_n = k @ plane.normal
        aside = float(np.abs(k_n - (plane.normal @ k_n) * plane.normal).max())
        if aside > ROUNDING * np.abs(k).max():
            cause = "the stiffness joins motions in the plane and out of it"
            return _message(where, f"{aside:.3g} of the stiffness, must be 0", cause, plane)
    for i, rod in enumerate(scene.rods):
        cause = _seen_in_space(rod, plane)
        if cause:
            return _message(f"rod[{i}].section", f"rod {rod.name!r}", cause, plane)
    return None


def _message(where: str, value: str, cause: str, plane: Plane) -> Message:
    advice = f'move it into the plane across ({plane}), or take reduction = "auto" or "full"'
    return Message("The scene is not planar.", where, value, cause, advice)


def _seen_in_space(rod: Rod, plane: Plane) -> str:
    """Why section, element or law of a rod have no mirror image in the plane; empty where they have."""
    direction = plane.in_section(rod)
    for part in rod.parts:
        for section in (part.section, part.section_end):
            if section is not None and not is_mirrored(section, direction):
                return "the section is not its own mirror image in the plane"
    if is_along_axis(direction) or not ELEMENTS[rod.element].has_section:
        return ""
    # A plane between the axes of a round section.
    directors = set(ELEMENTS[rod.element].directors)
    degree = max(j + k for j, k in directors)
    if {(j, d - j) for d in range(degree + 1) for j in range(d + 1)} != directors:
        return f"the vectors of element {rod.element} have mirror images only along the axes of the section"
    if rod.shear_factors[0] != rod.shear_factors[1]:
        return "the shear factors distinguish the axes of the section"
    if np.any(rod.curvature) or not all(isinstance(p.material, SaintVenantKirchhoff) for p in rod.parts):
        return (
            "curved rods and rubber are integrated on points that mirror each other along the section's axes"
        )
    return ""


def is_mirrored(section: Section, normal: tuple[float, float]) -> bool:
    """Whether a section is its own mirror image in a line through its centroid across `normal` (y, z)."""
    if isinstance(section, Circle | Annulus):
        return True
    if isinstance(section, Ellipse) and section.semi_axis_y == section.semi_axis_z:
        return True
    if not isinstance(section, Polygon):
        return is_along_axis(normal)  # rectangles and ellipses
    corners = section.corners
    image = corners - 2.0 * np.outer(corners @ normal, normal)
    distance = np.linalg.norm(corners[:, None] - image, axis=-1).min(axis=0)
    return bool(np.max(distance) <= ROUNDING * section.outer_radius)
