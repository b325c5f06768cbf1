"""What acts on the rods of a scene and what holds them, as coloured pyvista meshes at the deformed shape.

Arrows show direction, and size among loads of one kind: the largest is ARROW of the picture's size.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancf.obstacles import Cylinder, Plane, Sphere
from ancf.view_skin import OUTLINE_POINTS, box, closed_skin, widest

if TYPE_CHECKING:
    from ancf.scene import Pressure, Rod, Tendon
    from ancf.solution import Solution

Floats = NDArray[np.float64]

LOAD, WEIGHT, MAGNETIC = "#c0392b", "#7f8c8d", "#7d5ba6"
TENDON, CHAMBER, HELD, JOINT = "#1b2631", "#2e86c1", "#5d6d7e", "#1b2631"
OBSTACLE = "#d4b483"

ARROW = 0.16  # of the picture's size
SHORTEST = 0.45  # of the longest arrow of a kind: smaller loads stay visible
ALONG = 9  # arrows of a load along a rod
TURN = np.deg2rad(290.0)  # of the circle that shows a moment
POINTS_BETWEEN = 60  # along a tendon or a chamber


@dataclass(frozen=True)
class Mark:
    """A mesh (pyvista PolyData) with its colour; `inside` marks lie in a rod, which then has to be clear."""

    mesh: Any
    colour: str
    opacity: float = 1.0
    inside: bool = False


def marks(solution: Solution, size: float) -> list[Mark]:
    """All marks of a scene; `size` [m] is that of the picture."""
    found: list[Mark] = []
    for draw in (_holds, _joints, _tendons, _chambers, _point_loads, _distributed, _fields, _obstacles):
        found += draw(solution, size)
    return found


def _holds(solution: Solution, size: float) -> Iterator[Mark]:
    """A disc behind a clamped section, or one that a rigid joint holds to the ground; a ball at a pin."""
    held = [(rod, s.at, s.kind != "pin") for rod in solution.scene.rods for s in rod.supports]
    held += [(solution.scene.rod(j.a.rod), j.a.at, j.kind == "rigid") for j in _to_ground(solution)]
    for rod, at, fixed in held:
        pose, radius = solution.pose(rod.name, at), widest(rod, at)
        if fixed:
            radius = max(1.7 * radius, 0.018 * size)
            outwards = pose.rotation @ _tangent(solution, rod, at) * (1.0 if at > 0.5 else -1.0)
            yield Mark(_disc(pose.position + 0.17 * radius * outwards, outwards, radius), HELD)
        else:
            yield Mark(_ball(pose.position, max(1.4 * radius, 0.012 * size)), HELD)


def _joints(solution: Solution, size: float) -> Iterator[Mark]:
    """A ball at joints that leave rotations free."""
    for joint in solution.scene.joints:
        if joint.b is not None and joint.kind != "rigid":
            radius = widest(solution.scene.rod(joint.a.rod), joint.a.at)
            centre = solution.pose(joint.a.rod, joint.a.at).position
            yield Mark(_ball(centre, max(1.4 * radius, 0.012 * size)), JOINT)


def _tendons(solution: Solution, size: float) -> Iterator[Mark]:
    """Each tendon along its path, inside the rod."""
    for tendon in solution.scene.tendons:
        radius = max(0.10 * widest(solution.scene.rod(tendon.rod), 0.0), 0.0015 * size)
        yield Mark(_tube(_tendon_line(solution, tendon), radius), TENDON, inside=True)


def _tendon_line(solution: Solution, tendon: Tendon) -> Floats:
    """Points (n, 3) of the deformed path."""
    corners = tendon.path[:, 0]
    at = np.union1d(np.linspace(corners[0], corners[-1], POINTS_BETWEEN), corners)
    y, z = (np.interp(at, corners, tendon.path[:, k]) for k in (1, 2))
    return solution.displaced(tendon.rod, at, y, z)


def _chambers(solution: Solution, size: float) -> Iterator[Mark]:
    """Each chamber under pressure, inside the rod."""
    for pressure in solution.scene.pressures:
        yield Mark(_chamber(solution, pressure), CHAMBER, opacity=0.75, inside=True)


def _chamber(solution: Solution, pressure: Pressure) -> Any:
    """Skin of a chamber."""
    at = np.linspace(pressure.start, pressure.end, POINTS_BETWEEN)[:, None]
    angle = np.linspace(0.0, 2.0 * np.pi, OUTLINE_POINTS, endpoint=False)
    y, z = (
        centre + pressure.radius * turn
        for centre, turn in zip(pressure.centre, (np.cos(angle), np.sin(angle)), strict=True)
    )
    return closed_skin(solution.displaced(pressure.rod, at, y, z))


def _point_loads(solution: Solution, size: float) -> Iterator[Mark]:
    """Straight arrows for forces, turning ones for moments."""
    scene = solution.scene
    for load, share in zip(scene.forces, _shares([f.value for f in scene.forces]), strict=True):
        rotation = solution.pose(load.rod, load.at).rotation
        direction = _unit(rotation @ load.value if load.direction == "follower" else load.value)
        place = solution.displaced(load.rod, load.at, load.offset[0], load.offset[1]).reshape(3)
        yield Mark(_outer_arrow(solution, load.rod, place, share * ARROW * size * direction), LOAD)
    for load, share in zip(scene.moments, _shares([m.value for m in scene.moments]), strict=True):
        pose = solution.pose(load.rod, load.at)
        axis = _unit(pose.rotation @ load.value if load.direction == "follower" else load.value)
        radius = max(0.35 * share * ARROW * size, 1.6 * widest(scene.rod(load.rod), load.at))
        yield Mark(_turning_arrow(pose.position, axis, radius), LOAD)


def _distributed(solution: Solution, size: float) -> Iterator[Mark]:
    """Rows of arrows for line loads, of turning arrows for line moments, one arrow for gravity."""
    scene, places = solution.scene, np.linspace(0.5 / ALONG, 1.0 - 0.5 / ALONG, ALONG)
    for load, share in zip(scene.line_loads, _shares([v.value for v in scene.line_loads]), strict=True):
        for at in places:
            pose = solution.pose(load.rod, float(at))
            direction = _unit(pose.rotation @ load.value if load.direction == "follower" else load.value)
            arrow = 0.6 * share * ARROW * size * direction
            yield Mark(_outer_arrow(solution, load.rod, pose.position, arrow), LOAD)
    for load, share in zip(scene.line_moments, _shares([v.value for v in scene.line_moments]), strict=True):
        for at in places:
            pose = solution.pose(load.rod, float(at))
            axis = _unit(pose.rotation @ load.value if load.direction == "follower" else load.value)
            radius = max(0.2 * share * ARROW * size, 1.6 * widest(scene.rod(load.rod), float(at)))
            yield Mark(_turning_arrow(pose.position, axis, radius), LOAD)


def _fields(solution: Solution, size: float) -> Iterator[Mark]:
    """Arrows of gravity beside the rods, and of magnetic fields around them."""
    low, high = box(solution)
    scene, middle = solution.scene, 0.5 * (low + high)
    if scene.gravity is not None and np.any(scene.gravity.acceleration):
        down = _unit(scene.gravity.acceleration)
        away = middle + 0.5 * np.abs(high - low) @ np.abs(_across(down)) * _across(down)
        yield Mark(_arrow(away + 0.10 * size * _across(down), ARROW * size * down), WEIGHT)
    directions = {tuple(np.round(_unit(m.field), 6)): m for m in scene.magnets if np.any(m.field)}
    for direction in directions:
        along = np.array(direction)
        side = _across(along)
        reach = 0.5 * np.abs(high - low) @ np.abs(side)
        for share in (-1.0, -0.5, 0.0, 0.5, 1.0):
            start = middle + share * reach * side - 0.25 * size * along
            yield Mark(_arrow(start, 0.5 * size * along, 0.35, 0.14), MAGNETIC, opacity=0.35)


def _to_ground(solution: Solution) -> list[Any]:
    return [joint for joint in solution.scene.joints if joint.b is None]


def _obstacles(solution: Solution, size: float) -> Iterator[Mark]:
    """Planes, spheres and cylinders that rods may touch."""
    for contact in solution.scene.contacts:
        body = contact.obstacle
        if isinstance(body, Plane):
            yield Mark(_plate(solution, body.point, body.normal, size), OBSTACLE, opacity=0.55)
        elif isinstance(body, Sphere):
            yield Mark(_ball(body.centre, body.radius), OBSTACLE, opacity=0.6)
        elif isinstance(body, Cylinder):
            yield Mark(_log(solution, body.point, body.axis, body.radius), OBSTACLE, opacity=0.6)


def _plate(solution: Solution, point: Floats, normal: Floats, size: float) -> Any:
    """The part of a plane beside the rods; its face lies in the plane."""
    import pyvista

    low, high = box(solution)
    normal = _unit(normal)
    middle = 0.5 * (low + high)
    centre = middle - (normal @ (middle - point)) * normal
    first = _across(normal)
    second = np.cross(normal, first)
    reach = [float(0.5 * np.abs(high - low) @ np.abs(side)) + 0.05 * size for side in (first, second)]
    thickness = 0.012 * size
    slab = pyvista.Box((-thickness, 0.0, -reach[0], reach[0], -reach[1], reach[1]))
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = np.column_stack([normal, first, second]), centre
    return slab.transform(matrix, inplace=False)


def _log(solution: Solution, point: Floats, axis: Floats, radius: float) -> Any:
    """The part of an endless cylinder beside the rods."""
    import pyvista

    low, high = box(solution)
    axis = _unit(axis)
    centre = point + (axis @ (0.5 * (low + high) - point)) * axis
    length = float(np.abs(high - low) @ np.abs(axis)) + radius
    return pyvista.Cylinder(center=centre, direction=axis, radius=radius, height=length, resolution=72)


def _tangent(solution: Solution, rod: Rod, at: float) -> Floats:
    """Unit tangent (3,) of the reference axis in SCS."""
    step = 1e-3
    start, end = (min(max(at + d, 0.0), 1.0) for d in (-step, step))
    ends = solution.reference(rod.name, np.array([start, end]), np.zeros(1), np.zeros(1))
    return _unit(ends[1] - ends[0])


def _shares(values: list[Floats]) -> list[float]:
    """Lengths of arrows of one kind, of the longest: from SHORTEST to 1; a load of zero has none."""
    sizes = [float(np.linalg.norm(value)) for value in values]
    largest = max(sizes, default=0.0) or 1.0
    return [max(size / largest, SHORTEST) if size else 0.0 for size in sizes]


def _unit(vector: ArrayLike) -> Floats:
    vector = np.asarray(vector, float)
    return vector / (np.linalg.norm(vector) or 1.0)


def _across(direction: Floats) -> Floats:
    """A unit vector across a direction, in SCS along an axis where it can be."""
    axis = np.eye(3)[int(np.argmin(np.abs(direction)))]
    return _unit(axis - (axis @ direction) * direction)


def _outer_arrow(solution: Solution, rod: str, place: Floats, arrow: Floats) -> Any:
    """Arrow from the place where it points away from the rod's middle, to the place where it does not."""
    middle = solution.nodes(rod).mean(axis=0)
    return _arrow(place if arrow @ (place - middle) >= 0.0 else place - arrow, arrow)


def _arrow(start: Floats, arrow: Floats, thickness: float = 1.0, head: float = 0.32) -> Any:
    import pyvista

    length = float(np.linalg.norm(arrow))
    if length == 0.0:
        return pyvista.PolyData(np.asarray(start, float).reshape(1, 3))
    return pyvista.Arrow(
        start=start, direction=arrow, scale=length, shaft_radius=0.035 * thickness,
        tip_radius=0.10 * thickness, tip_length=head, shaft_resolution=20, tip_resolution=24,
    )  # fmt: skip


def _turning_arrow(centre: Floats, axis: Floats, radius: float) -> Any:
    """Part of a circle about the axis, right-handed, with a head at its end."""
    import pyvista

    if not np.any(axis):
        return pyvista.PolyData(np.asarray(centre, float).reshape(1, 3))
    first = _across(axis)
    second = np.cross(axis, first)
    angle = np.linspace(0.0, TURN, 60)[:, None]
    line = centre + radius * (np.cos(angle) * first + np.sin(angle) * second)
    forwards = np.cos(TURN) * second - np.sin(TURN) * first
    length = 0.55 * radius
    head = pyvista.Cone(
        center=line[-1] + 0.3 * length * forwards, direction=forwards, height=length, radius=0.22 * radius,
        resolution=24,
    )  # fmt: skip
    return _tube(line, 0.07 * radius).merge(head)


def _tube(points: Floats, radius: float) -> Any:
    import pyvista

    return pyvista.lines_from_points(points).tube(radius=radius, n_sides=12, capping=True)


def _disc(centre: Floats, direction: Floats, radius: float) -> Any:
    import pyvista

    return pyvista.Cylinder(
        center=centre, direction=direction, radius=radius, height=0.3 * radius, resolution=48
    )


def _ball(centre: Floats, radius: float) -> Any:
    import pyvista

    return pyvista.Sphere(radius=radius, center=centre, theta_resolution=24, phi_resolution=24)
