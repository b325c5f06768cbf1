"""Tip of a rod under a couple by the exact section problem, as numbers that can be stored.

The rod is clamped at the origin along x with a section free to contract; positions are by its length.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from reference.rod_inputs import law_of, section_of
from reference.rotation import log
from reference.section import SectionState, bend, bend_and_twist, twist

CELLS = (2, 3)  # quads across the core; the answers differ by some 1e-8, on rectangles in torsion by 1e-4
MAY_TURN = ("circle", "annulus")  # sections that bend and twist at once


class NoAnswer(RuntimeError):
    """A reference did not converge; the message says why."""


def section_answer(
    material: Mapping[str, Any], section: Mapping[str, Any], length: float, moment: Sequence[float]
) -> dict[str, Any]:
    """Answer of the section problem for a tip couple that is constant in space.

    Parameters
    ----------
    material, section : mappings
        Tables of a scene file (`rod_inputs`).
    length : float
        [m].
    moment : (3,)
        [N m]; other than a circle or annulus takes a pure torque or a couple about z.

    Returns
    -------
    dict
        ``position`` (3,) of the material centre and ``stretch`` of its fibre [-], ``rotation`` (3, 3),
        ``screw`` (3,) and ``twist`` [rad] over the length, ``energy`` [J], ``position_error`` and
        ``angle_error`` [rad], the difference of two meshes.

    Raises
    ------
    NoAnswer
        When the section problem does not reach the load.
    """
    coarse, fine = (_state(material, section, moment, cells) for cells in CELLS)
    poses = [state.pose(length) for state in (coarse, fine)]
    turned = log(poses[0].rotation @ poses[1].rotation.T)
    return {
        "position": poses[1].centre / length,
        "rotation": poses[1].rotation,
        "stretch": fine.axial_stretch,
        "screw": fine.screw * length,
        "twist": fine.twist * length,
        "energy": fine.energy * length,
        "position_error": float(np.linalg.norm(poses[0].centre - poses[1].centre)) / length,
        "angle_error": float(np.linalg.norm(turned)),
    }


def _state(
    material: Mapping[str, Any], section: Mapping[str, Any], moment: Sequence[float], cells: int
) -> SectionState:
    mesh, law = section_of(section, cells), law_of(material)
    M_x, M_y, M_z = moment
    if M_y == 0.0 == M_z:
        state = twist(mesh, law, moment=M_x)
    elif M_x == 0.0 == M_y:
        state = bend(mesh, law, moment=M_z)
    elif section["shape"] in MAY_TURN:
        state = bend_and_twist(mesh, law, np.array(moment, float))
    else:
        raise ValueError(
            f"A {section['shape']} under the couple {list(moment)} N m is no screw motion; only a circle or "
            "an annulus may bend and twist at once. Take a pure torque, or a couple about z."
        )
    if state.status.value != "converged":
        raise NoAnswer(f"section problem, {cells} quads: {state.message}")
    return state
