r"""Stability of a solution: negative eigenvalues, the first critical load, the softest modes.

The buckling factor is found on the nonlinear path of equilibria, not by one linear eigenproblem of the
unloaded rod: the deflection before buckling counts.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ancf.band import SingularMatrixError
from ancf.continuation import Followed, follow
from ancf.critical import CriticalPoint
from ancf.scene import StabilityOptions
from ancf.spectrum import Spectrum

if TYPE_CHECKING:
    from ancf.model import Model

Floats = NDArray[np.float64]

FARTHEST = 1e6  # load factor up to which a critical load is looked for; a step may double it
NO_POTENTIAL = (
    "a load has no potential: only the sign of the tangent's determinant is known, and flutter cannot be seen"
    " in statics"
)


@dataclass(frozen=True)
class Mode:
    """A mode of the tangent: its eigenvalue by E I/L^3 of the first rod (spectrum.py), and its shape.

    shape: displacement (n_nodes, 3) of the nodes by rod, the largest component 1.
    """

    eigenvalue: float
    shape: dict[str, Floats]


@dataclass(frozen=True)
class Stability:
    """What is known of the stability of a solution and of the path to it.

    negative_pivots: negative eigenvalues of the tangent at the solution; for loads without a potential 1 if
    its determinant is negative, else 0. buckling_factor: load factor of the first critical point on the path
    from the unloaded state, None where none was found. modes: softest modes at that point, else at the
    solution. critical_points: all that were met on the way. note: what is not known, and why.
    """

    negative_pivots: int
    buckling_factor: float | None
    modes: list[Mode] = field(default_factory=list)
    critical_points: list[CriticalPoint] = field(default_factory=list)
    note: str = ""

    def as_dict(self) -> dict[str, Any]:
        """Plain Python, every number finite."""
        return {
            "negative_pivots": self.negative_pivots,
            "buckling_factor": self.buckling_factor,
            "modes": [
                {"eigenvalue": m.eigenvalue, "shape": {name: s.tolist() for name, s in m.shape.items()}}
                for m in self.modes
            ],
            "critical_points": [
                {"kind": c.kind, "load_factor": c.load_factor, "multiplicity": len(c.modes)}
                for c in self.critical_points
            ],
            "note": self.note,
        }


def examine(
    model: Model, q: Floats, load_factor: float, followed: Followed | None, deadline: float
) -> Stability:
    """Examine the solution q (n,); for `[stability]` look for a critical load where the path met none.

    Parameters
    ----------
    followed : the path to the solution; None: load steps led there
    deadline : value of time.perf_counter(), at which the look ahead ends
    """
    options, notes = model.scene.stability, []
    pivots = _negative(model, q, load_factor, followed, notes)
    critical = [] if followed is None else followed.critical
    if followed is not None:
        notes += _about_branch(model, followed)
    if not np.any(model.residual(model.q0).Q_ext):
        notes.append("there is no load")
    elif not critical and options is not None:
        ahead = follow(model, FARTHEST, model.scene.solver.max_steps, deadline, first_critical=True)
        critical = ahead.critical[:1]
        if not critical:
            notes.append(_why_none(ahead))
    if critical:
        q, load_factor = critical[0].point.q, critical[0].load_factor
    modes = []
    try:
        modes = _modes(model, q, load_factor, (options or StabilityOptions()).modes)
    except SingularMatrixError as error:
        notes.append(f"no modes: {error}")
    factor = critical[0].load_factor if critical else None
    return Stability(pivots, factor, modes, critical, "; ".join(notes))


def _negative(
    model: Model, q: Floats, load_factor: float, followed: Followed | None, notes: list[str]
) -> int:
    """Negative eigenvalues at the solution; what is not known is noted."""
    # On a branch that leads any way (a round column) one eigenvalue is zero: the path did not count it.
    if model.conservative and followed is not None and followed.points[-1].q is q:
        return followed.points[-1].negative
    try:
        _, flat = model.residual_and_tangent(q, load_factor)
        if model.conservative:
            return model.system.negative_eigenvalues(flat)
        notes.append(NO_POTENTIAL)
        return int(model.system.factorise(flat).determinant_sign < 0)
    except (SingularMatrixError, np.linalg.LinAlgError):
        notes.append("the tangent is singular at the solution")
        return 0


def _about_branch(model: Model, followed: Followed) -> list[str]:
    """What became of the wish for the buckled branch, and of critical points that the mesh would make."""
    found = []
    if model.scene.stability is not None and model.scene.stability.branch == "buckled":
        if not followed.tried_branch:
            found.append("no bifurcation was met before the loads: this is the primary branch")
        elif not followed.turned_off:
            found.append("the buckled branch could not be entered: this is the primary branch")
    if followed.too_coarse:
        found.append("from where elements turn or are pressed too much no critical points were looked for")
    return found


def _why_none(ahead: Followed) -> str:
    last = ahead.points[-1].load_factor
    if ahead.too_coarse:
        return (
            f"no critical load was found up to {last:.3g} times the loads; beyond, the elements are too long"
        )
    if ahead.reached:
        return f"no critical load was found up to {last:.3g} times the loads"
    reason = "max_steps is used up" if ahead.out_of_steps else "no equilibrium was found beyond"
    return f"no critical load was found up to {last:.3g} times the loads, where the path ends ({reason})"


def _modes(model: Model, q: Floats, load_factor: float, count: int) -> list[Mode]:
    spectrum = Spectrum(model)
    if model.conservative:
        f, phi = spectrum.lowest(q, load_factor, count)
        return [Mode(float(value), _shape(model, mode)) for value, mode in zip(f, phi.T, strict=True)]
    value, mode = spectrum.nearest_zero(q, load_factor)
    return [Mode(value, _shape(model, mode))] if np.isfinite(value) else []


def _shape(model: Model, mode: Floats) -> dict[str, Floats]:
    """Displacement of the nodes of every rod, the largest component 1."""
    shapes = {rod.rod.name: rod.nodal(mode)[:, 0].copy() for rod in model.rods}
    everything = np.concatenate(list(shapes.values()))
    largest = everything.flat[np.argmax(np.abs(everything))]
    return {name: shape / largest for name, shape in shapes.items()} if largest else shapes
