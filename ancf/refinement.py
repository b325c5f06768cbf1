"""Meshes that the program chooses: the first one, cuts of its elements, and shapes carried between them.

Every mesh keeps the boundaries of the one before it, so that spaces are nested and boundaries stay on
segments, supports, joints and point loads.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ancf.elements import ELEMENTS
from ancf.errors import InputError, Message
from ancf.mesh import distinct_places, held_places, loaded_places, places_in_part, rod_breaks
from ancf.model import Model
from ancf.scene import Rod, Scene

Floats = NDArray[np.float64]
Counts = NDArray[np.intp]

# Elements of a rod on the first mesh: as many as it needs, by order 4, if its error is 1 on one of them. They
# are cheap: below some 50 elements a solve takes the same time.
FEWEST, MOST = 4, 64
FIRST_TURN = math.pi / 4  # rad, by which an element of the first mesh may be curved in the reference
# A clamped section of second degree cannot bulge; what it does instead dies out within a few radii. Elements
# of a rod's length jump over it, and error estimates with them: lengths grow from this share of the radius.
LAYER = 0.5
MOST_PIECES = 4  # into which one round cuts an element: estimates of coarse meshes do not reach further
# Of an estimate the prediction counts on this share: order 4 begins late where curvature is uneven.
SAFETY = 0.5


def with_elements(rod: Rod, counts: Sequence[int]) -> Rod:
    """The rod with so many elements in each of its parts, equal between supports, joints and loads."""
    if rod.segments:
        segments = tuple(replace(s, elements=n) for s, n in zip(rod.segments, counts, strict=True))
        return replace(rod, segments=segments, elements=sum(counts), breaks=())
    return replace(rod, elements=counts[0], breaks=())


def with_breaks(rod: Rod, breaks: Floats) -> Rod:
    """The rod with its elements between `breaks` (n_el + 1,), fractions that hold the ends of its parts."""
    middle = 0.5 * (breaks[1:] + breaks[:-1])
    part = np.searchsorted(rod.ends[1:-1], middle, side="right")
    counts = np.bincount(part, minlength=len(rod.parts))
    return replace(with_elements(rod, [int(n) for n in counts]), breaks=tuple(breaks.tolist()))


def prepared(scene: Scene) -> Scene:
    """The scene with the mesh that is tried first, asking for no accuracy any more.

    Raises `InputError` for a rod that has a mesh already.
    """
    for index, rod in enumerate(scene.rods):
        if rod.elements or rod.breaks:
            raise InputError(
                Message(
                    "Elements and accuracy are both given.",
                    f"rod[{index}].elements",
                    f"elements = {rod.elements} of rod {rod.name!r}, accuracy = {scene.solver.accuracy:g}",
                    "accuracy stands in the place of elements: the program chooses the mesh",
                    "leave elements away (0 in Python), or accuracy",
                )
            )
    wanted = scene.solver.accuracy
    assert wanted is not None
    return first_mesh(replace(scene, solver=replace(scene.solver, accuracy=None)), wanted)


def first_mesh(scene: Scene, accuracy: float) -> Scene:
    """The scene with the mesh from which the search for an accuracy begins."""
    count = min(max(math.ceil(accuracy**-0.25), FEWEST), MOST)
    return replace(scene, rods=tuple(_first(scene, rod, count) for rod in scene.rods))


def _first(scene: Scene, rod: Rod, count: int) -> Rod:
    places = held_places(scene, rod) + loaded_places(scene, rod)
    turn = float(np.linalg.norm(rod.curvature))
    counts = []
    for index, part in enumerate(rod.parts):
        pieces = len(distinct_places(places_in_part(rod, index, places))) - 1
        share = math.ceil(count * part.length / rod.length - 1e-9)
        counts.append(max(pieces, share, math.ceil(turn * part.length / FIRST_TURN)))
    meshed = with_elements(rod, counts)
    return layered(with_breaks(meshed, rod_breaks(scene, meshed) / rod.length))


def layered(rod: Rod) -> Rod:
    """The rod with short elements beside its clamps, where its sections are of second degree."""
    if not ELEMENTS[rod.element].quadratic_section:
        return rod
    breaks = np.array(rod.breaks)
    added = []
    for support in rod.supports:
        if support.kind != "clamp":
            continue
        first = LAYER * rod.section_at(support.at).outer_radius / rod.length
        for side in (-1.0, 1.0):
            distance = side * (breaks - support.at)
            beyond = distance[distance > first]
            nearest = float(beyond.min()) if len(beyond) else 0.0
            doublings = max(math.ceil(math.log2(nearest / first)) if nearest else 0, 0)
            added += [
                support.at + side * first * 2.0**k
                for k in range(doublings)
                if 2.0**k * first < 0.75 * nearest
            ]
    return with_breaks(rod, np.unique(np.concatenate([breaks, added])))


def cut(rod: Rod, pieces: Counts | int) -> Rod:
    """The rod with each element in so many equal pieces (n_el,)."""
    breaks = np.array(rod.breaks)
    pieces = np.broadcast_to(pieces, len(breaks) - 1)
    first = np.repeat(breaks[:-1], pieces)
    length = np.repeat(np.diff(breaks) / pieces, pieces)
    step = np.concatenate([np.arange(count) for count in pieces])
    return with_breaks(rod, np.append(first + step * length, breaks[-1]))


def pieces_for(contributions: Floats, reduction: float, order: int) -> Counts:
    r"""Into how many pieces (n_el,) elements should be cut, at the least cost.

    Pieces of a m-th of the length leave m^-order of a contribution. The least sum m_e with
    sum_e eta_e m_e^-order <= reduction sum_e eta_e has m_e in proportion to eta_e^(1/(order + 1)).

    Parameters
    ----------
    contributions : eta (n_el,) of each element to the error, not negative
    reduction : what may remain of their sum, 0 to 1
    """
    eta = contributions / max(float(contributions.sum()), np.finfo(float).tiny)
    density = eta ** (1.0 / (order + 1))
    density = density / max(float(density.max()), np.finfo(float).tiny)
    for scale in np.geomspace(1.0, MOST_PIECES, 64):
        pieces = np.clip(np.ceil(scale * density - 0.5), 1, MOST_PIECES).astype(np.intp)
        if float(eta @ pieces ** -float(order)) <= reduction:
            alike = math.ceil(reduction ** (-1.0 / order))  # whole numbers may round to more than that
            return pieces if pieces.sum() <= alike * len(eta) else np.full(len(eta), alike, dtype=np.intp)
    return np.clip(np.ceil(MOST_PIECES * density**0.5), 2, MOST_PIECES).astype(np.intp)


def carried(source: Model, q: Floats, target: Model) -> Floats:
    """Coordinates (n,) on the mesh of `target` of the shape that `source` has at q; the same if nested.

    Both have the same rods with the same elements and joints.
    """
    found = np.empty(target.n)
    for rod, other in zip(source.rods, target.rods, strict=True):
        element, breaks, e = rod.element, rod.mesh.breaks, rod.element_vectors(q)
        x = other.mesh.node_x
        place = np.clip(np.searchsorted(breaks, x, side="right") - 1, 0, len(breaks) - 2)
        vectors = np.empty(other.q0.shape)
        for index in np.unique(place):
            here = place == index
            h = float(breaks[index + 1] - breaks[index])
            xi = np.clip(2.0 * (x[here] - breaks[index]) / h - 1.0, -1.0, 1.0)
            for column, (order, j, k) in enumerate(element.vectors):
                N = element.shape(xi, h, derivative=order)[:, element.directors.index((j, k))]
                vectors[here, column] = N @ e[index]
        found[other.first_dof : other.first_dof + other.size] = vectors.ravel()
    found[target.motions :] = q[source.motions :]  # what the joints carry
    return found
