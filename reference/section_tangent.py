"""Stiffness of a bar at a converged state, by exact linearisation of the section problem.

The equations of the state are differentiated once more with its own bordered matrix: no differences.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array
from scipy.sparse.linalg import splu

from reference.section_form import STRAINS, SectionForm
from reference.section_newton import SectionLoad, bordered_tangent
from reference.section_state import SectionState

Array = NDArray[np.float64]


@dataclass(frozen=True)
class BarStiffness:
    """Stiffness of the undeformed bar: EA [N], EI_y and EI_z [N m^2] about y and z, GJ [N m^2]."""

    EA: float
    EI_y: float
    EI_z: float
    GJ: float


def tangent(state: SectionState) -> Array:
    """Tangent of the couple by the rotation of the sections, dM_i/dk_j at zero axial force.

    Returns (3, 3) [N m^2] in the section's frame, symmetric: the constitutive law of a rod around this state,
    with the spin held. At a bent state dM_z/dk_z is the bending stiffness, dM_x/dk_x the torsional one.

    Notes
    -----
    Schur complement of the converged bordered system: U is stationary in u and a while k moves.
    """
    held = np.zeros(STRAINS, bool)
    held[3:] = True
    K = _response(state.form, state.point.forces.tangent, held)[3:6, 3:6]
    K = state.turn @ K @ state.turn.T
    return K * state.form.stress_unit * state.form.size**4


def coupled_tangent(state: SectionState) -> Array:
    """Tangent of a circular bar along its helical equilibria, d(M_t, M_b)/d(twist, curvature).

    Returns (2, 2) [N m^2]: twisting and bending part of the couple of `bend_and_twist` by the twist
    k_x + spin and the curvature, with k parallel to the couple and no axial force throughout. The thin
    limit is diag(GJ, EI). Not symmetric at finite strain: the force conjugate to the spin is not M_t.

    Raises
    ------
    ValueError
        For a state that is not bent by `bend_and_twist`.
    """
    form, load = state.form, state.load
    if not load.aligned:
        raise ValueError("the state has no spin: coupled_tangent needs one of bend_and_twist with bending.")
    m_x, m_z, k_z = load.value[3], load.value[5], state.point.e[5]
    right = np.zeros((form.unknowns + 6, 2))
    border = form.unknowns - STRAINS
    right[border + 3, 0] = right[border + 5, 1] = 1.0
    right[form.unknowns - 1] = k_z / m_z, -k_z * m_x / m_z**2  # d(k_x - k_z m_x/m_z) = 0
    matrix = bordered_tangent(form, state.point.forces.tangent, load)
    e = splu(matrix).solve(right)[border : border + STRAINS]
    compliance = np.array([e[3] + e[6], e[5]])
    return np.linalg.inv(compliance) * form.stress_unit * form.size**4


def stiffness_of(form: SectionForm) -> BarStiffness:
    """Stiffness of the undeformed bar of a discrete section."""
    held = np.ones(STRAINS, bool)
    K = _response(form, form.forces(*form.straight).tangent, held)[:6, :6]
    EA, _, _, GJ, EI_y, EI_z = 1 / np.diag(np.linalg.inv(K)) * form.stress_unit * form.size**2
    square = form.size**2
    return BarStiffness(float(EA), float(EI_y * square), float(EI_z * square), float(GJ * square))


def _response(form: SectionForm, energy_tangent: csc_array, held: NDArray[np.bool_]) -> Array:
    """Derivative of the forces by the held strains (7, 7), zero columns for the others."""
    matrix = bordered_tangent(form, energy_tangent, SectionLoad(held, np.zeros(STRAINS)))
    border = form.unknowns - STRAINS
    right = np.zeros((form.unknowns + 6, STRAINS))
    right[border : form.unknowns][held, held] = 1.0
    moved = splu(matrix).solve(right)[: form.unknowns]
    return (energy_tangent @ moved)[border:]
