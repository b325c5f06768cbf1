"""Supports: linear conditions on the vectors of one node, as the paper's B_2 and as a projector.

A support is a set of rows C with C dq = 0 on the 3 n_v unknowns of its node. The solver keeps all unknowns
and projects with P = I - C^T (C C^T)^-1 C, which leaves the band untouched; `basis` is the paper's B_2 (eq.
10), an orthonormal basis of the allowed motions, for inspection.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ancf.elements import R_X, R_Y, R_Z, Element, R

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class NodeSupport:
    """A support resolved on a node: its unknowns and the condition rows on them."""

    dofs: NDArray[np.intp]  # (nd,)
    rows: Floats  # (conditions, nd)

    @cached_property
    def held(self) -> NDArray[np.bool_] | None:
        """Which unknowns (nd,) are held, where the conditions hold whole unknowns; else None."""
        fixed = (self.rows != 0.0).any(axis=0)
        return fixed if len(self.rows) == np.count_nonzero(fixed) else None

    @cached_property
    def projector(self) -> Floats:
        """Projector (nd, nd) on the allowed motions."""
        basis = self.basis
        return basis @ basis.T

    @cached_property
    def basis(self) -> Floats:
        """Orthonormal allowed motions (nd, free), the node's block of B_2."""
        if self.held is not None:  # the unit vectors exactly
            return np.eye(len(self.held))[:, ~self.held]
        _, singular, right = np.linalg.svd(self.rows)
        return right[np.count_nonzero(singular > 1e-12) :].T


def support_rows(kind: str, element: Element, frame: Floats) -> Floats:
    """Condition rows (conditions, 3 n_v) of a support.

    Parameters
    ----------
    kind : ``clamp`` fixes every nodal vector; ``pin`` fixes r; ``free_section_clamp`` fixes r, the plane of
        the section (r_y . x = r_z . x = 0, likewise the higher section vectors) and its orientation
        (r_y . z = r_z . y), and leaves it free to contract; of a cable r and the direction of r_x, so that it
        stretches at the clamp as it does beside it
    frame : section frame (3, 3) of the reference at the support, columns x, y, z in SCS
    """
    count = len(element.vectors)

    def row(*terms: tuple[tuple[int, int, int], Floats]) -> Floats:
        full = np.zeros((count, 3))
        for vector, direction in terms:
            full[element.vectors.index(vector)] += direction
        return full.ravel()

    if kind == "clamp":
        return np.eye(3 * count)
    position = [row((R, direction)) for direction in np.eye(3)]
    if kind == "pin":
        return np.array(position)
    if kind == "free_section_clamp":
        x, y, z = frame.T
        if not element.has_section:
            return np.array([*position, row((R_X, y)), row((R_X, z))])
        higher = [row((order, x)) for order in element.vectors if order[0] == 0 and sum(order) > 1]
        return np.array([*position, row((R_Y, x)), row((R_Z, x)), row((R_Y, z), (R_Z, -y)), *higher])
    raise ValueError(f"unknown support kind {kind!r}")
