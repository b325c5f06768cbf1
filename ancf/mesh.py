"""Mesh of one rod and its reference configuration: nodes on the (possibly curved and twisted) axis.

Positions are relative to the base of the rod. A rod that stands 1e6 m from the origin then has the same
digits as one at the origin; the base is added on output.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ancf.elements import Element
from ancf.errors import InputError, Message
from ancf.rotation import exp, hat
from ancf.scene import SAME_PLACE, Rod, Scene
from ancf.segments import starts

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Mesh:
    """Nodes and elements of one rod."""

    breaks: Floats  # (n_el + 1,) m, element boundaries along the reference length
    node_x: Floats  # (n_nodes,) m
    nodes_of: NDArray[np.intp]  # (n_el, nodes per element)

    @cached_property
    def h(self) -> Floats:
        """Element lengths (n_el,) [m]."""
        return np.diff(self.breaks)


def distinct_places(places: list[float]) -> Floats:
    """Fractions of the length in order, from 0 to 1, without repetition."""
    marks = np.sort([0.0, *places, 1.0])
    marks = marks[np.concatenate([[True], np.diff(marks) > SAME_PLACE])]
    marks[-1] = 1.0
    return marks


def element_breaks(length: float, elements: int, anchors: list[float]) -> Floats:
    """Element boundaries (n_el + 1,) [m]: equal elements between anchors, a boundary on every anchor.

    `anchors` are fractions of the length where a support or a point load stands: there the solution has a
    kink, and an element boundary represents it exactly. The elements are shared out in proportion to the
    distances, so anchors on the uniform grid leave the grid uniform. There must be as many as pieces.
    """
    if not anchors:
        return length * np.append(np.linspace(0.0, 1.0, elements, endpoint=False), 1.0)
    marks = distinct_places(anchors)
    pieces = np.diff(marks)
    ideal = pieces * elements
    count = np.maximum(np.floor(ideal + 1e-9).astype(int), 1)
    while count.sum() < elements:
        count[np.argmax(ideal / count)] += 1
    while count.sum() > elements:
        able = np.where(count > 1, ideal / count, np.inf)
        count[np.argmin(able)] -= 1
    parts = [
        np.linspace(a, b, n, endpoint=False) for a, b, n in zip(marks[:-1], marks[1:], count, strict=True)
    ]
    return length * np.concatenate([*parts, [1.0]])


def places_in_part(rod: Rod, part: int, places: list[float]) -> list[float]:
    """Those of the places inside one part of a rod, not on its ends, as fractions of the part's length."""
    first, last = rod.ends[part], rod.ends[part + 1]
    inside = [at for at in places if first + SAME_PLACE < at < last - SAME_PLACE]
    return [float((at - first) / (last - first)) for at in inside]


def held_places(scene: Scene, rod: Rod) -> list[float]:
    """Fractions of the length at which supports and joints hold a rod."""
    joined = [place.at for joint in scene.joints for place in joint.places if place.rod == rod.name]
    return [support.at for support in rod.supports] + joined


def loaded_places(scene: Scene, rod: Rod) -> list[float]:
    """Fractions of the length at which moments, forces and springs act on a rod."""
    # A load of zero magnitude must not even move the mesh.
    acting = [load for load in (*scene.moments, *scene.forces) if load.rod == rod.name and np.any(load.value)]
    springs = [spring for spring in scene.springs if spring.rod == rod.name and spring.holds]
    return [load.at for load in (*acting, *springs)]


def rod_breaks(scene: Scene, rod: Rod) -> Floats:
    """Element boundaries (n_el + 1,) [m] of a rod: on the ends of its segments, on its supports and joints
    and, elements of the segment permitting, its loads; or those that the rod has been given.
    """
    if rod.breaks:
        return rod.length * np.array(rod.breaks)
    if not rod.elements:
        raise InputError(
            Message(
                "The rod has no mesh yet.",
                f"rod {rod.name!r}",
                "elements = 0",
                "its scene asks for an accuracy, and solving it chooses the mesh",
                "solve it with ancf.solve, and go on with the scene of the solution",
            )
        )
    held, loaded = held_places(scene, rod), loaded_places(scene, rod)
    breaks = []
    for part, (segment, start) in enumerate(zip(rod.parts, starts(rod.parts)[:-1], strict=True)):
        anchors = places_in_part(rod, part, held + loaded)
        if anchors and len(distinct_places(anchors)) - 1 > segment.elements:
            anchors = places_in_part(rod, part, held)
        breaks.append((start + element_breaks(segment.length, segment.elements, anchors))[:-1])
    return np.concatenate([*breaks, [rod.length]])


def make_mesh(element: Element, breaks: Floats) -> Mesh:
    """Nodes of the elements between `breaks`; neighbours share the node on their boundary."""
    inner = len(element.node_xi) - 1
    h = np.diff(breaks)
    offsets = 0.5 * (1.0 + np.array(element.node_xi[:-1]))
    node_x = np.concatenate([(breaks[:-1, None] + h[:, None] * offsets).ravel(), breaks[-1:]])
    nodes_of = inner * np.arange(len(h))[:, None] + np.arange(inner + 1)
    return Mesh(breaks, node_x, nodes_of)


def reference_axis(x: Floats, curvature: Floats) -> tuple[Floats, Floats]:
    """Reference axis in BCS: positions (n, 3) [m] and section frames (n, 3, 3) at arc lengths x (n,) [m].

    Constant curvature k = (twist, about y, about z) makes the axis a helix with R(x) = exp(x k) and
    r(x) = int_0^x R e_x = (x I + c_1 hat(k) + c_2 hat(k)^2) e_x,
    c_1 = (1 - cos(a x))/a^2, c_2 = (a x - sin(a x))/a^3, a = |k|.
    """
    x = np.asarray(x, dtype=float)
    if not np.any(curvature):
        return x[:, None] * np.array([1.0, 0.0, 0.0]), np.broadcast_to(np.eye(3), (len(x), 3, 3))
    angle = np.linalg.norm(curvature) * x
    small = angle < 1e-3
    safe = np.where(small, 1.0, angle)
    c_1 = x**2 * np.where(small, 0.5 - angle**2 / 24.0, 2.0 * (np.sin(0.5 * safe) / safe) ** 2)
    # The series avoids the cancellation of a x - sin(a x); two terms leave a^4/5040 < 1e-15 below 1e-3.
    c_2 = x**3 * np.where(small, 1.0 / 6.0 - angle**2 / 120.0, (safe - np.sin(safe)) / safe**3)
    k_hat = hat(np.asarray(curvature, dtype=float))
    e_x = np.array([1.0, 0.0, 0.0])
    position = x[:, None] * e_x + c_1[:, None] * (k_hat @ e_x) + c_2[:, None] * (k_hat @ k_hat @ e_x)
    return position, exp(x[:, None] * curvature)


def reference_nodes(rod: Rod, element: Element, node_x: Floats) -> Floats:
    """Nodal vectors of the reference q0 (n_nodes, vectors, 3) in SCS, positions relative to the base.

    First-order vectors are the columns of A_o R(x) (paper eq. 1-6 with T_o block diagonal).
    """
    position, frame = reference_axis(node_x, rod.curvature)
    A_o = rod.base.rotation
    vectors = []
    for order in element.vectors:
        if order == (0, 0, 0):
            vectors.append(position @ A_o.T)
        elif sum(order) == 1:
            vectors.append((A_o @ frame)[..., order.index(1)])
        elif order[0] == 0:
            vectors.append(np.zeros_like(position))  # sections are plane and undistorted in the reference
        else:
            raise ValueError(f"element {element.name}: no reference rule for nodal vector {order}")
    return np.stack(vectors, axis=1)
