r"""Starts for rods with joints: each rod rebuilt from its local measures, placed by a support or a joint.

As without joints (path.py) the local measures are extrapolated, and a rod is rebuilt from its one orienting
support. The others follow along the rigid joints: the section of the next rod has the position and rotation
of the one it is joined to. What hangs by hinges and balls, or on the ground, is placed by the extrapolated
position and rotation of one of its joined sections. Loops do not quite close: Newton closes them.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ancf.elements import R
from ancf.model import Model
from ancf.rod_model import RodModel
from ancf.rod_shape import LocalShape, from_local, node_rotations
from ancf.scene import Place

Floats = NDArray[np.float64]


def placed(model: Model, shapes: Sequence[LocalShape], linear: Floats, turned: Sequence[Floats]) -> Floats:
    """Unknowns (n,) of rods with the given local measures.

    Parameters
    ----------
    linear : (n,) unknowns extrapolated as they are: multipliers, positions of sections, and rods that have
        more than one support
    turned : section rotations (n_nodes, 3, 3) of each rod, extrapolated as rotations
    """
    q = linear.copy()
    index_of = {rod.rod.name: index for index, rod in enumerate(model.rods)}
    done: set[str] = set()

    def build(rod: RodModel, node: int, position: Floats, rotation: Floats) -> None:
        shape = from_local(rod, shapes[index_of[rod.rod.name]], node, position, rotation)
        q[rod.first_dof : rod.first_dof + rod.size] = shape.ravel()
        done.add(rod.rod.name)

    def section(place: Place) -> tuple[RodModel, int, int]:
        rod = model.rods[index_of[place.rod]]
        return rod, rod.node_at(place.at), rod.element.vectors.index(R)

    for rod in model.rods:
        if rod.rod.clamp is not None:
            node = rod.node_at(rod.rod.clamp.at)
            build(rod, node, rod.q0[node, rod.element.vectors.index(R)], np.eye(3))
        elif rod.rod.supports:
            done.add(rod.rod.name)
    while len(done) < len(model.rods):
        before = len(done)
        for joint in model.scene.joints:
            if joint.kind != "rigid" or joint.b is None or joint.apart:
                continue
            for a, b in ((joint.a, joint.b), (joint.b, joint.a)):
                if a.rod in done and b.rod not in done:
                    (rod_a, node_a, r_a), (rod_b, node_b, r_b) = section(a), section(b)
                    vectors = rod_a.nodal(q)
                    moved = vectors[node_a, r_a] - rod_a.q0[node_a, r_a]
                    rotation = node_rotations(rod_a, vectors)[node_a]
                    build(rod_b, node_b, rod_b.q0[node_b, r_b] + moved, rotation)
        if len(done) == before:
            place = next(p for j in model.scene.joints for p in j.places if p.rod not in done)
            rod, node, r = section(place)
            build(rod, node, rod.nodal(linear)[node, r], turned[index_of[place.rod]][node])
    return q
