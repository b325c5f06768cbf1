"""A rod as a 3-D solid on families of meshes: tip, own error, axis and stress, as numbers to be stored.

The rod lies along x from the origin; positions are by its length. The start value is the Simo-Reissner rod
of `reference.rod`, lifted, or the unloaded shape where that fails; the residual decides. The ends disturb
the answer, the linear traction of an end couple by some (kappa R)^2 R/L. In pure bending and pure torsion the
turn of the middle third is free of them; where a rod bends and twists, a tilt of the end layer stays in it,
some 6e-5 rad at kappa R = 0.03.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from reference.rod import RodLoads, RodNotSolved, RodProperties, RodSolution, solve_rod
from reference.rod_inputs import law_of, section_of
from reference.rotation import exp, log
from reference.section_answer import NoAnswer
from reference.solid import (
    SolidProblem,
    SolidResult,
    clamped,
    full_clamp,
    lifted_rod,
    section_states,
    section_stress,
    soft_clamp,
    solve_in_steps,
    solve_solid,
)
from reference.solid_convergence import MeshError, corrected, richardson
from reference.solid_cost import SolidTooLarge
from reference.solid_forms import formulation_for
from reference.solid_materials import SolidMaterial
from reference.solid_mesh import RodMesh, SectionMesh, rod_mesh

Array = NDArray[np.float64]

FORMAL_ORDER = 4.0  # of tip position and rotation on hex27, twice the order of the energy norm
MEMORY_LIMIT = 4e9  # byte, of the finest mesh
CELLS = (2, 3, 4)  # across the core: the section's family, on few slices
REFINED = (2, 3, 4)  # slices of the axis' family on the coarsest section, by half of the coarsest
# Slices at a turn of 90 degrees and length/radius 40: the axial error of hex27, some 0.014 (h^2 kappa/R)^2 of
# the angle, is then 1e-5 with twice as many. Multiples of 6 put planes of all meshes on the thirds.
SLICES = 24
THIRDS = 6
STATIONS = 81  # of the rod that is lifted
RINGS, SPOKES = 6, 16  # points of the stress, inside the section
CLAMPS = {"soft": soft_clamp, "full": full_clamp}


def solid_answer(
    material: Mapping[str, Any],
    section: Mapping[str, Any],
    length: float,
    loads: Mapping[str, Sequence[float]],
    support: str = "soft",
) -> dict[str, Any]:
    """Tip of a solid rod, corrected for the mesh of the section and that of the axis, each by three meshes.

    Parameters
    ----------
    material, section : mappings
        Tables of a scene file (`rod_inputs`).
    length : float
        [m].
    loads : mapping
        Any of ``moment`` [N m], ``force`` [N], ``body_force`` [N/m3], (3,) each, dead.
    support : "soft" or "full"
        `soft_clamp` or `full_clamp`.

    Returns
    -------
    dict
        ``position`` (3,) of the material centre, ``rotation`` (3, 3), ``position_error``, ``angle_error``
        [rad], the lower observed ``order`` (or None), ``third`` (3, 3) and ``third_error`` [rad]: rotation of
        the section at 2/3 against that at 1/3, ``axis``: ``s`` and ``position`` (m, 3) by the length, all in
        the limit of fine meshes; of the finest mesh ``slices``, ``unknowns``, ``iterations``, ``stress``:
        ``points`` (y, z) [m] and Cauchy ``axial`` [Pa] at mid-length.

    Raises
    ------
    NoAnswer
        When a mesh does not converge or is too large for `MEMORY_LIMIT`, or the rod to start from has no
        solution.
    ValueError
        For another support, and for a torque on the soft clamp, which does not hold it.
    """
    if support not in CLAMPS:
        raise ValueError(f"support is {support!r}; there are {' and '.join(CLAMPS)}.")
    if support == "soft" and _load(loads, "moment")[0] != 0.0:
        raise ValueError('the soft clamp holds no torque; take support = "full".')
    law = law_of(material)
    half = _slices(law, section_of(section, CELLS[0]), length, loads) // 2

    def solve(cells: int, slices: int) -> SolidResult:
        return _solve(law, section_of(section, cells), length, loads, support, slices)

    families = (
        ([solve(cells, half) for cells in CELLS], [1.0 / cells for cells in CELLS]),
        ([solve(CELLS[0], half * n) for n in REFINED], [1.0 / n for n in REFINED]),
    )
    finest = solve(CELLS[-1], half * REFINED[-1])

    def limit(quantity: Callable[[SolidResult], Array]) -> MeshError:
        errors = [
            richardson([quantity(result) for result in results], sizes, FORMAL_ORDER)
            for results, sizes in families
        ]
        return corrected(quantity(finest), errors)

    def turned(rotation: Callable[[SolidResult], Array]) -> tuple[Array, float]:
        turn = limit(lambda result: log(rotation(result) @ rotation(finest).T))
        return exp(turn.extrapolated) @ rotation(finest), turn.extrapolated_error

    centre = limit(lambda result: _tip(result) / length)
    tip, tip_error = turned(lambda result: result.tip_rotation)
    third, third_error = turned(_middle_third)
    axis = limit(lambda result: _axis(result, half) / length)
    points = _points(finest.problem.mesh.section)
    states = section_states(finest)
    normal = states.rotation[len(states.rotation) // 2][:, 0]
    stress = section_stress(finest, length / 2, points)
    return {
        "position": centre.extrapolated,
        "rotation": tip,
        "position_error": centre.extrapolated_error,
        "angle_error": tip_error,
        "order": centre.order,
        "third": third,
        "third_error": third_error,
        "slices": finest.problem.mesh.slices,
        "unknowns": finest.unknowns,
        "iterations": finest.iterations,
        "axis": {"s": np.linspace(0.0, 1.0, half + 1), "position": axis.extrapolated},
        "stress": {"points": points, "axial": np.einsum("i,nij,j->n", normal, stress.cauchy, normal)},
    }


def _solve(
    law: SolidMaterial,
    section: SectionMesh,
    length: float,
    loads: Mapping[str, Sequence[float]],
    support: str,
    slices: int,
) -> SolidResult:
    rod = rod_mesh(section, length, slices)
    fixed = CLAMPS[support](rod)
    start = _rod_shape(law, rod, loads)
    problem = SolidProblem(
        rod, law, fixed, clamped(start, fixed),
        formulation=formulation_for(law),
        moment=_load(loads, "moment"), force=_load(loads, "force"),
        body_force=_load(loads, "body_force"),
        start_force=_across(rod, loads) if support == "soft" else np.zeros(3),
    )  # fmt: skip
    try:
        result = solve_solid(problem, memory_limit=MEMORY_LIMIT)
        if not result.converged:
            unloaded = replace(problem, guess=np.zeros_like(start))
            result = solve_in_steps(unloaded, memory_limit=MEMORY_LIMIT)
    except SolidTooLarge as error:
        raise NoAnswer(str(error)) from None
    if not result.converged:
        raise NoAnswer(
            f"solid of {slices} slices, {len(section.nodes)} nodes each: {result.status}, {result.reason}"
        )
    return result


def _rod_shape(law: SolidMaterial, mesh: RodMesh, loads: Mapping[str, Sequence[float]]) -> Array:
    """The integrated rod under the same loads, as displacement (n, 3) of the solid's nodes."""
    rod, curvature = _rod(law, mesh.section, mesh.length, loads)
    return lifted_rod(mesh, rod.s, rod.position, rod.rotation, curvature, law.poisson_ratio)


def _rod(
    law: SolidMaterial, section: SectionMesh, length: float, loads: Mapping[str, Sequence[float]]
) -> tuple[RodSolution, Array]:
    """The integrated rod, and its twist and curvatures (n, 3) [1/m] in the section's frame."""
    (I_z, _), (_, I_y) = section.second_moments
    properties = RodProperties.from_section(
        length, law.young_modulus, law.poisson_ratio, section.area, I_y=I_y, I_z=I_z
    )
    rod_loads = RodLoads(
        tip_force=_load(loads, "force"),
        tip_moment=_load(loads, "moment"),
        line_load=section.area * _load(loads, "body_force"),
    )
    try:
        rod = solve_rod(properties, rod_loads, np.linspace(0.0, length, STATIONS))
    except RodNotSolved as error:
        raise NoAnswer(f"no rod to start the solid from: {error}") from None
    moment = np.einsum("nji,nj->ni", rod.rotation, rod.moment)
    return rod, moment / np.array([properties.GJ, properties.EI_y, properties.EI_z])


def _slices(
    law: SolidMaterial, section: SectionMesh, length: float, loads: Mapping[str, Sequence[float]]
) -> int:
    """Slices of the coarsest mesh of the axis: h grows as (R/kappa)^(1/2), which keeps the axial error.

    kappa is the root mean square along the rod.
    """
    _, curvature = _rod(law, section, length, loads)
    bending = float(np.sqrt(np.mean(curvature[:, 1:] ** 2) * 2))
    radius = float(np.sqrt(section.area / np.pi))
    needed = SLICES * np.sqrt(bending * length / (np.pi / 2) * length / radius / 40)
    return THIRDS * int(np.ceil(max(needed, SLICES) / THIRDS - 1e-3))


def _middle_third(result: SolidResult) -> Array:
    """Rotation (3, 3) of the section at 2/3 of the length against that at 1/3."""
    rotation, third = section_states(result).rotation, 2 * result.problem.mesh.slices // 3
    return rotation[2 * third] @ rotation[third].T


def _axis(result: SolidResult, stations: int) -> Array:
    """Centre line (stations + 1, 3) [m] at equal distances, where every mesh has a plane."""
    axis = section_states(result).axis
    return axis[:: (len(axis) - 1) // stations]


def _across(rod: RodMesh, loads: Mapping[str, Sequence[float]]) -> Array:
    """Force (3,) [N] that balances the loads across the rod; its axial part is left to the face's support."""
    volume = rod.section.area * rod.length
    force = -_load(loads, "force") - volume * _load(loads, "body_force")
    return force * [0.0, 1.0, 1.0]


def _load(loads: Mapping[str, Sequence[float]], name: str) -> Array:
    return np.array(loads.get(name, np.zeros(3)), float)


def _tip(result: SolidResult) -> Array:
    return result.tip_position if result.tip_centre is None else result.tip_centre


def _points(section: SectionMesh) -> Array:
    """Points (n, 2) [m] of rings and spokes that lie inside the discrete section of any shape."""
    share = np.linspace(0.0, 0.98, RINGS)[1:, None]
    angle = np.arange(SPOKES) * (2 * np.pi / SPOKES)
    unit = np.column_stack([np.cos(angle), np.sin(angle)])
    rim = section.nodes[list(section.rim)]
    reach = np.array([rim[0, 0], rim[1, 1]])
    inner = 0.0 if section.centre is not None else np.min(np.linalg.norm(section.nodes, axis=1)) / reach[0]
    shares = inner + (1 - inner) * share
    rings = (shares[..., None] * unit).reshape(-1, 2) * reach
    return rings if section.centre is None else np.vstack([[0.0, 0.0], rings])
