"""Stationary point of the section energy under prescribed strains or forces, by Newton's method with LU.

    dU/du + C^T lambda = 0,   C u = 0,   and for each i   e_i = value_i (held)   or   dU/de_i = value_i.

The multipliers vanish with the force and with k x couple: then the bar is in equilibrium as a whole. The
energy is stationary there, not least: the tangent is indefinite, hence LU and no minimiser.
Without unit, as `section_form`.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bmat, coo_array, csc_array
from scipy.sparse.linalg import splu

from reference.section_form import STRAINS, SectionForces, SectionForm

Array = NDArray[np.float64]

TOLERANCE = 1e-9  # last step by the largest displacement or strain of the state; the next is its square
MAX_ITERATIONS = 25
MAX_HALVINGS = 12
SMALLEST_FRACTION = 2.0**-7  # of the load: a shorter load step gives up
LARGEST_STEP = 1e3  # a longer Newton step is divergence


class SectionStatus(StrEnum):
    """How a section problem ended."""

    CONVERGED = "converged"
    NOT_CONVERGED = "not_converged"
    NOT_HELICAL = "not_helical"


@dataclass(frozen=True, eq=False)
class SectionLoad:
    """What is prescribed: `value` (7,) is the strain where `held` (7,) bool, else its conjugate force.

    With `aligned` the equation of the spin says instead that k is parallel to the couple in the x-z plane.
    """

    held: NDArray[np.bool_]
    value: Array
    aligned: bool = False

    def part(self, fraction: float) -> SectionLoad:
        """Return the load at a fraction between the undeformed state (0) and the full load (1)."""
        start = np.where(self.held, np.eye(STRAINS)[0], 0.0)
        return SectionLoad(self.held, start + fraction * (self.value - start), self.aligned)


@dataclass(frozen=True, eq=False)
class SectionPoint:
    """State (u (ns, 3), e (7,), multipliers (6,)) with its forces at the last point that converged.

    `fraction` of the load reached; `residual` largest unbalanced force by E size^2.
    """

    u: Array
    e: Array
    multiplier: Array
    forces: SectionForces
    status: SectionStatus
    fraction: float
    iterations: int
    residual: float


@np.errstate(all="ignore")  # a step out of the law's range gives numbers that are not finite, and is halved
def solve_section(form: SectionForm, load: SectionLoad) -> SectionPoint:
    """Solve for the full load at once, and by shorter load steps where Newton fails.

    The frame turns with the section, so that the displacement is small however far the bar is bent and the
    straight state is start enough. Each later step starts from the line through the last two points.
    """
    u, e = form.straight
    last = SectionPoint(u, e, np.zeros(6), form.forces(u, e), SectionStatus.CONVERGED, 0.0, 0, 0.0)
    before, step, iterations = last, 1.0, 0
    while last.fraction < 1.0 and step >= SMALLEST_FRACTION:
        fraction = min(1.0, last.fraction + step)
        point, spent = _newton(form, load.part(fraction), fraction, *_extrapolated(before, last, fraction))
        iterations += spent
        if point is None:
            step /= 2
        else:
            before, last = last, point
    status = SectionStatus.CONVERGED if last.fraction == 1.0 else SectionStatus.NOT_CONVERGED
    return replace(last, status=status, iterations=iterations)


def bordered_tangent(form: SectionForm, tangent: csc_array, load: SectionLoad) -> csc_array:
    """Derivative of all equations by (u, e, multiplier): the energy's, the frame's and the load's rows."""
    border = form.unknowns - STRAINS
    gates = np.ones(form.unknowns)
    gates[border:][load.held] = 0.0
    where = border + np.flatnonzero(load.held)
    rows, columns, values = list(where), list(where), [1.0] * len(where)
    if load.aligned:
        gates[-1] = 0.0
        m_x, m_z = load.value[3], load.value[5]
        rows += [form.unknowns - 1] * 2
        columns += [border + 3, border + 5]
        values += [1.0, -m_x / m_z]
    size = (form.unknowns, form.unknowns)
    own = coo_array((values, (rows, columns)), shape=size)
    scale = coo_array((gates, (np.arange(size[0]), np.arange(size[0]))), shape=size)
    frame = csc_array(np.hstack([form.frame, np.zeros((6, STRAINS))]))
    return csc_array(bmat([[scale @ tangent + own, frame.T], [frame, None]]))


def _imbalance(form: SectionForm, load: SectionLoad, forces: SectionForces, e: Array, lam: Array) -> Array:
    """Left sides of all equations (3 ns + 7 + 6,)."""
    border = form.unknowns - STRAINS
    gradient = forces.gradient.copy()
    gradient[:border] += form.frame.T @ lam
    gradient[border:] = np.where(load.held, e, gradient[border:]) - load.value
    if load.aligned:
        gradient[-1] = e[3] - e[5] * load.value[3] / load.value[5]
    return gradient


def _extrapolated(before: SectionPoint, last: SectionPoint, fraction: float) -> tuple[Array, Array, Array]:
    """Start value (u, e, multiplier) on the line through two points, at the last where there is one only."""
    past = last.fraction - before.fraction
    grown = (fraction - last.fraction) / past if past > 0 else 0.0
    pairs = [(before.u, last.u), (before.e, last.e), (before.multiplier, last.multiplier)]
    u, e, multiplier = (new + grown * (new - old) for old, new in pairs)
    return u, e, multiplier


def _newton(
    form: SectionForm, load: SectionLoad, fraction: float, u: Array, e: Array, lam: Array
) -> tuple[SectionPoint | None, int]:
    """Newton's method at one load step, None where it fails; returns the iterations spent too."""
    u_0, e_0 = form.straight
    if form.least_volume(u, e) <= 0:
        return None, 0
    pressure = None
    for iteration in range(1, MAX_ITERATIONS + 1):
        forces = form.forces(u, e, pressure)
        right = _imbalance(form, load, forces, e, lam)
        right = np.concatenate([right, form.frame @ u.ravel()])
        try:
            step = -splu(bordered_tangent(form, forces.tangent, load)).solve(right)
        except RuntimeError:  # exactly singular
            return None, iteration
        if not np.all(np.isfinite(step)):
            return None, iteration
        du = step[: u.size].reshape(u.shape)
        de, dlam = step[u.size : -6], step[-6:]
        # Twist is k_x + spin; how it is shared is ill-determined by slight bending, and matters as little.
        strains = np.append(de[:6], de[3] + de[6])[[0, 1, 2, 4, 5, 6]] if load.aligned else de
        length = max(np.abs(du).max(), np.abs(strains).max())
        if length > LARGEST_STEP:
            return None, iteration
        part = 1.0
        while form.least_volume(u + part * du, e + part * de) <= 0:
            part /= 2
            if part < 2.0**-MAX_HALVINGS:
                return None, iteration
        pressure = form.predict_pressure(forces, part * step[:-6])
        u, e, lam = u + part * du, e + part * de, lam + part * dlam
        amplitude = max(np.abs(u - u_0).max(), np.abs(e - e_0).max())
        if part == 1.0 and length <= TOLERANCE * amplitude + form.round_off:
            forces = form.forces(u, e)
            residual = float(np.abs(_imbalance(form, load, forces, e, lam)).max())
            point = SectionPoint(u, e, lam, forces, SectionStatus.CONVERGED, fraction, iteration, residual)
            return point, iteration
    return None, MAX_ITERATIONS
