r"""Exact derivatives of the tip pose by loads, material and geometry, from the tangent at the equilibrium.

With g(q, p) = 0 along a parameter p and the pose P(q, p), linear in q,

    dP/dp = P_q (dq_h - K^-1 g_p) + P_p,     g_p = dg/dp at q + dq_h,

K = dg/dq the exact tangent and dq_h the motion that the supports impose (a clamp at the far end of a rod
that grows). Generalised forces are linear in the values of loads, so g_p is the force of a unit load.
By material and geometry the explicit derivatives g_p, dq_h and P_p are fourth-order differences of closed
expressions at fixed q (STEP below); nothing is solved again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancf.band import Factors, SingularMatrixError
from ancf.effect_assembly import load_effects
from ancf.errors import refuse
from ancf.model import Model
from ancf.passive_reports import passive_reports
from ancf.rod_model import RodModel
from ancf.scene import Rod, Scene

Floats = NDArray[np.float64]

LOADS = {
    "moment": "moments",
    "force": "forces",
    "line_load": "line_loads",
    "line_moment": "line_moments",
    "tension": "tendons",
}
# Of the parameter (or of 1/L, for curvature). Its fourth power times A L^2/I, the stiffness of the axis in
# units of that of bending, is what truncation leaves; rounding leaves eps A L^2/I over it.
STEP = 2e-4
MISSING = ("a misspelt or missing name", "name one of these")
STENCIL = ((-2.0, 1.0 / 12.0), (-1.0, -8.0 / 12.0), (1.0, 8.0 / 12.0), (2.0, -1.0 / 12.0))


def pose_map(rod: RodModel, at: float = 1.0) -> tuple[NDArray[np.intp], Floats]:
    """Unknowns (nd,) of the element at a section, and the map (12, nd) from them to [r, r_x, r_y, r_z]."""
    point = rod.section_point(at)
    rows = [point.N[0], point.N_x[0], point.N[rod.element.y_director], point.N[rod.element.z_director]]
    return point.dofs, np.asarray(np.kron(np.array(rows), np.eye(3)), dtype=float)


def sensitivity(
    model: Model, q: Floats, load_factor: float, parameter: str, rod: str | None = None, index: int = 0
) -> Floats:
    """Derivative of the tip pose [r, r_x, r_y, r_z] by a parameter, along the branch of an equilibrium.

    Parameters
    ----------
    q, load_factor : the equilibrium (n,)
    parameter : "moment", "force", "line_load" (by the value of the table `index` of the scene, in its own
        frame), "tension" or "tendon_length" (of the tendon `index`) or "gravity"; or a number of the rod:
        "young_modulus", "poisson_ratio", "density", "length", "curvature", or a size of its section
    rod : whose tip, and whose number; by default the rod of the load, else the first

    Returns
    -------
    (12, 3) for loads and curvature, (12,) for numbers, in SI units; loads act times the load factor.

    Raises
    ------
    InputError : no such parameter, or a critical point, where the pose has no derivative.
    """
    name = rod or _owner(model.scene, parameter, index)
    if name not in [r.rod.name for r in model.rods]:
        known = f"rods: {[r.rod.name for r in model.rods]}"
        refuse("The scene has no such rod.", f"rod = {name!r}", known, *MISSING)
    observed = next(r for r in model.rods if r.rod.name == name)
    _refuse_contact(model, q)
    lu = _factors(model, q, load_factor)
    if parameter == "tendon_length":
        rate = length_rate(model, index)
        dofs, P = pose_map(observed)
        return P @ model.system.solve(lu, load_factor * rate)[dofs]
    if parameter in LOADS or parameter == "gravity":
        dq = model.system.solve(lu, load_factor * load_forces(model, q, parameter, index))
        dofs, P = pose_map(observed)
        return P @ (dq[dofs, 0] if parameter == "tension" else dq[dofs])
    columns = []
    for change, step in _changes(observed.rod, parameter):
        g, pose = _explicit(model, q, load_factor, name, change, step)
        dofs, P = pose_map(observed)
        columns.append(pose + P @ model.system.solve(lu, -g)[dofs])
    return np.column_stack(columns) if parameter == "curvature" else columns[0]


def length_rate(model: Model, index: int) -> Floats:
    """Generalised force (n,) of a unit length of the tendon `index`, whose length is controlled."""
    tendon = _entry(model.scene.tendons, "tendon_length", "tendon", index)
    if tendon.length is None:
        refuse(
            "The tendon has no controlled length.", f'sensitivity("tendon_length"), index = {index}',
            "it has a tension", MISSING[0], 'take sensitivity("tension")',
        )  # fmt: skip
    assert model.constraints is not None
    rate = np.zeros(model.n)
    controlled = model.constraints.tendons[model.scene.controlled_tendons.index(tendon)]
    rate[controlled.multipliers] = 1.0
    return rate


def load_forces(model: Model, q: Floats, parameter: str, index: int = 0) -> Floats:
    """Generalised forces (n, 3) at q (n,) of the unit values of a load, in its frame; (n, 1) of a tension."""
    forces = np.zeros((model.n, 1 if parameter == "tension" else 3))
    for axis, scene in enumerate(_unit_loads(model.scene, parameter, index)):
        for effect in load_effects(scene, model.rods):
            e = q[effect.dofs].reshape(len(effect.dofs), -1, 3)
            np.add.at(forces[:, axis], effect.dofs.ravel(), effect.force(e).ravel())
    return forces


def _unit_loads(scene: Scene, parameter: str, index: int) -> Iterator[Scene]:
    """Scenes with nothing but one load of unit value."""
    if parameter == "gravity":
        if scene.gravity is None:
            refuse("The scene has no gravity.", 'sensitivity("gravity")', "no [gravity] table", *MISSING)
        for unit in np.eye(3):
            yield Scene(scene.rods, gravity=replace(scene.gravity, acceleration=unit))
        return
    table = "tendon" if parameter == "tension" else parameter
    load = _entry(getattr(scene, LOADS[parameter]), parameter, table, index)
    if parameter == "tension":
        if load.tension is None:
            refuse(
                "The tension of the tendon is not given.", f'sensitivity("tension"), index = {index}',
                "its length is", MISSING[0], 'take sensitivity("tendon_length")',
            )  # fmt: skip
        yield replace(Scene(scene.rods), tendons=(replace(load, tension=1.0),))
        return
    for unit in scene.load_axes(load).T:
        yield replace(Scene(scene.rods), **{LOADS[parameter]: (replace(load, value=unit),)})


def _entry(loads: Sequence[Any], parameter: str, table: str, index: int) -> Any:
    """The load of an index of the scene's tables, which is checked."""
    if not -len(loads) <= index < len(loads):
        refuse(
            f"The scene has no such {table}.", f'sensitivity("{parameter}"), index = {index}',
            f"it has {len(loads)} [[{table}]] tables", *MISSING,
        )  # fmt: skip
    return loads[index]


def _owner(scene: Scene, parameter: str, index: int) -> str:
    """Name of the rod whose tip is meant."""
    if parameter in LOADS or parameter == "tendon_length":
        loads = scene.tendons if parameter == "tendon_length" else getattr(scene, LOADS[parameter])
        if -len(loads) <= index < len(loads):
            return loads[index].rod
    return scene.rods[0].name


def _refuse_contact(model: Model, q: Floats) -> None:
    """Refuse where a rod touches: at fixed multipliers the gap would give way, which it does not."""
    for entry in passive_reports(model, q).get("contacts", []):
        if entry["points"]:
            refuse(
                "A rod in contact has no derivative in this version.", "sensitivity",
                f'rod {entry["rod"]!r} touches at {entry["points"]} points',
                "the tangent holds the forces of contact by a penalty, not by the gap itself",
                "take differences of two solutions",
            )  # fmt: skip


def _factors(model: Model, q: Floats, load_factor: float) -> Factors:
    _, flat = model.residual_and_tangent(q, load_factor)
    try:
        return model.system.factorise(flat)
    except SingularMatrixError:
        refuse(
            "The tip pose has no derivative here.", "sensitivity",
            f"singular tangent at load factor {load_factor:g}",
            "a critical point: the equilibrium is not unique next to it", "change the load slightly",
        )  # fmt: skip


def _explicit(
    model: Model, q: Floats, load_factor: float, name: str, change: Callable[[float], Rod], step: float
) -> tuple[Floats, Floats]:
    """g_p (n,) and dP/dp (12,) at fixed free unknowns, by a number of a rod.

    change : the rod with the number so much above its value
    """
    g, pose = np.zeros(model.n), np.zeros(12)
    for steps, weight in STENCIL:
        rods = tuple(change(steps * step) if rod.name == name else rod for rod in model.scene.rods)
        moved = Model(replace(model.scene, rods=rods))
        held = moved.admissible(q)
        g += weight / step * moved.residual(held, load_factor).at(load_factor)
        dofs, P = pose_map(next(r for r in moved.rods if r.rod.name == name))
        pose += weight / step * (P @ held[dofs])
    return g, pose


def _changes(rod: Rod, parameter: str) -> list[tuple[Callable[[float], Rod], float]]:
    """Rods with a number changed, and the step of the differences; three for the curvature."""
    numbers = {"length", "curvature"}
    for record in (rod.material, rod.section):
        numbers |= {name for name, value in vars(record).items() if isinstance(value, float)}
    if parameter not in numbers or rod.segments:
        refuse(
            "There is no derivative by this parameter.", f"sensitivity({parameter!r}), rod {rod.name!r}",
            "a rod of segments has loads only" if rod.segments else f"not one of {sorted(numbers)}",
            MISSING[0], f"loads are {', '.join(LOADS)}, tendon_length and gravity",
        )  # fmt: skip
    if parameter == "curvature":
        return [
            (lambda d, e=unit: replace(rod, curvature=rod.curvature + d * e), STEP / rod.length)
            for unit in np.eye(3)
        ]
    if parameter == "length":
        return [(lambda d: replace(rod, length=rod.length + d), STEP * rod.length)]
    where = "material" if hasattr(rod.material, parameter) else "section"
    record = getattr(rod, where)
    value = float(getattr(record, parameter))
    # Near 0.5 the stiffness goes as 1/(1 - 2 nu).
    scale = 0.5 - value if parameter == "poisson_ratio" else abs(value) or 1.0
    return [(lambda d: replace(rod, **{where: replace(record, **{parameter: value + d})}), STEP * scale)]
