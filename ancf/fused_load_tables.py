"""Tables of the fused kernel, second part: loads, and the rod as it is bent by them for a start.

As in fused_tables.py everything is dimensionless: lengths by L, moments by E I/L, a generalised force by
E I/L over the unit of its nodal vector.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancf.effects import DeadLoad
from ancf.elements import R_Y, R_Z, R
from ancf.fused_tables import vector_units
from ancf.mesh import reference_axis
from ancf.model import Model
from ancf.predictor import compliance_between_nodes
from ancf.section_energy import force_weights

Floats = NDArray[np.float64]
Indices = NDArray[np.int64]


class LoadTables(NamedTuple):
    """Sections under point loads whose force depends on the shape, and what every load does."""

    at: Indices  # (n_el + 1,) the loaded section on each element boundary, or -1
    node: Indices  # (loads,)
    director: Indices  # (K,) which nodal vectors are directors of the section, the axis left out
    moments: Floats  # (loads, K, 2) section moments int phi_k (y, z) dA, relative
    axes: Floats  # (loads, 3, 3) rows E_x, E_y, E_z of the reference
    moment_load: Indices  # (moments,) the section of each moment
    moment_turns: Indices  # (moments,) 1 where it follows the section
    dead_shape: Floats  # (forces, n / 3) generalised force of each dead force; zero for followers
    force_turning: Indices  # (forces,) place among the follower forces, or -1
    turning_load: Indices  # (follower forces,) the section of each
    turning_start: Indices  # (loads + 1,) follower forces by section
    turning_shape: Floats  # (follower forces, nv)
    dead: Floats  # (n,) gravity and line loads
    energy: float  # E I/L [N m]


class StartTables(NamedTuple):
    """The rod between its nodes, lengths by L and moments by E I/L."""

    bends: int  # 1 where the start can be found from the moments: clamped at x = 0
    x0: Floats  # (n,) reference, dimensionless
    position: int  # which nodal vector is the position
    h: Floats  # (n_nodes - 1,)
    C: Floats  # (n_nodes - 1, 3, 3) curvature per moment in section axes
    k_0: Floats  # (3,)
    R_0: Floats  # (n_nodes, 3, 3)
    local: Floats  # (n_nodes, nv, 3) reference nodal vectors in section axes
    load_node: Indices  # (loads,)


def load_tables(model: Model) -> LoadTables:
    """Loads of a scene that `fused.unsupported` has let pass."""
    (rod,) = model.rods
    scene, element = model.scene, rod.element
    nv, units = len(element.vectors), vector_units(rod)
    energy = rod.bending_stiffness / rod.rod.length
    inner = len(element.node_xi) - 1
    directors = [k for k, order in enumerate(element.directors) if order != (0, 0)]
    followers = [load for load in scene.forces if load.direction == "follower"]
    nodes = sorted({rod.node_at(load.at) for load in (*scene.moments, *followers)})
    at = np.full(len(rod.mesh.breaks), -1, dtype=np.int64)
    at[[node // inner for node in nodes]] = np.arange(len(nodes))
    columns = [element.vectors.index((0, *element.directors[k])) for k in directors]
    moments = np.empty((len(nodes), len(directors), 2))
    axes = np.empty((len(nodes), 3, 3))
    for row, node in enumerate(nodes):
        d0 = rod.q0[node, [element.vectors.index(R_Y), element.vectors.index(R_Z)]]
        axes[row] = [np.cross(*d0), *d0]
        W = rod.node_weights[node][directors] * units[columns][:, None]
        moments[row] = W @ d0.T / np.abs(rod.node_weights[node]).max()
    turning_load = np.array([nodes.index(rod.node_at(load.at)) for load in followers], dtype=np.int64)
    by_section = np.argsort(turning_load, kind="stable")
    place = {id(followers[k]): row for row, k in enumerate(by_section)}
    dead_shape = np.zeros((len(scene.forces), model.n // 3))
    turning_shape = np.zeros((len(followers), nv))
    for row, load in enumerate(scene.forces):
        point = rod.section_point(load.at)
        y, z = (float(value) for value in load.offset)
        shape = force_weights(element, rod.rod.section_at(load.at), y, z) @ point.N
        full = np.zeros(model.n // 3)
        full[point.dofs[::3] // 3] = shape * np.tile(units, len(element.node_xi)) / energy
        if load.direction == "follower":
            node = rod.node_at(load.at)
            turning_shape[place[id(load)]] = full[node * nv : (node + 1) * nv]
        else:
            dead_shape[row] = full
    return LoadTables(
        at=at,
        node=np.array(nodes, dtype=np.int64),
        director=np.array(columns, dtype=np.int64),
        moments=moments,
        axes=axes,
        moment_load=np.array([nodes.index(rod.node_at(m.at)) for m in scene.moments], dtype=np.int64),
        moment_turns=np.array([m.direction == "follower" for m in scene.moments], dtype=np.int64),
        dead_shape=dead_shape,
        force_turning=np.array([place.get(id(load), -1) for load in scene.forces], dtype=np.int64),
        turning_load=turning_load[by_section],
        turning_start=np.searchsorted(turning_load[by_section], np.arange(len(nodes) + 1)).astype(np.int64),
        turning_shape=turning_shape,
        dead=_dead_force(model),
        energy=energy,
    )


def start_tables(model: Model, load_node: Indices) -> StartTables:
    """What `fused_start.bend` needs."""
    (rod,) = model.rods
    length, x = rod.rod.length, rod.mesh.node_x
    _, frame = reference_axis(x, rod.rod.curvature)
    R_0 = rod.rod.base.rotation @ frame
    q0 = rod.q0 / vector_units(rod)[:, None]
    return StartTables(
        bends=int(rod.rod.clamp is not None and rod.rod.supports[0].at == 0.0),
        x0=q0.ravel(),
        position=rod.element.vectors.index(R),
        h=np.diff(x) / length,
        C=compliance_between_nodes(rod) * rod.bending_stiffness,
        k_0=np.asarray(rod.rod.curvature, dtype=float) * length,
        R_0=np.ascontiguousarray(R_0),
        local=np.einsum("nba,nvb->nva", R_0, q0),
        load_node=load_node,
    )


def _dead_force(model: Model) -> Floats:
    """Generalised force (n,) of gravity and dead line loads, dimensionless."""
    Q = np.zeros(model.n)
    for effect in model.effects:
        if isinstance(effect, DeadLoad) and effect.name in ("gravity", "line_load"):
            np.add.at(Q, effect.dofs.ravel(), effect.Q.ravel())
    return Q / model.force_unit
