"""Problem and result of the solid reference: what is asked, and what came out.

The loads follow the end section by its polar rotation R (`solid_couple`); supports are held components.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from enum import StrEnum

import numpy as np
from numpy.typing import NDArray

from reference.solid_forms import Formulation
from reference.solid_linear import SolverName
from reference.solid_materials import SolidMaterial
from reference.solid_mesh import RodMesh

Array = NDArray[np.float64]

TOLERANCE = 1e-10  # of |Q_int|
MAX_ITERATIONS = 30
LOADS = ("moment", "follower_moment", "force", "follower_force", "start_force", "body_force")


def _no_load() -> Array:
    return np.zeros(3)


@dataclass(frozen=True, eq=False)
class SolidProblem:
    """A rod, its law, its supports, its loads and a start value.

    Parameters
    ----------
    mesh : RodMesh
        The rod.
    material : SolidMaterial
        The law.
    fixed : (n, 3) bool
        Displacement components that keep the value they have in `guess`.
    guess : (n, 3) [m]
        Displacement to start from.
    moment, follower_moment : (3,) [N m]
        End couple, fixed in space; end couple that turns with R, components in the reference.
    force, follower_force : (3,) [N]
        Even traction of the end face, by its resultant: dead; turning with R.
    start_force : (3,) [N]
        Even dead traction of the start face, by its resultant. Opposite to the loads across the rod it takes
        the shear force off the point supports of `soft_clamp`, under which the solution has no limit.
    body_force : (3,) [N/m^3]
        Density times acceleration of gravity, per reference volume.
    formulation : "displacement" or "mixed"
        `solid_forms.formulation_for` chooses: displacements lock near nu = 1/2.
    linear_solver : "auto", "block" or "pardiso"
        Block-tridiagonal LU, or PARDISO where pypardiso is installed (`solid_linear`).
    tolerance : float
        Of the residual, by |Q_int|.
    max_iterations : int
        Of Newton's method.

    Raises
    ------
    ValueError
        For wrong shapes and values that are not finite.
    """

    mesh: RodMesh
    material: SolidMaterial
    fixed: NDArray[np.bool_]
    guess: Array
    moment: Array = field(default_factory=_no_load)
    follower_moment: Array = field(default_factory=_no_load)
    force: Array = field(default_factory=_no_load)
    follower_force: Array = field(default_factory=_no_load)
    start_force: Array = field(default_factory=_no_load)
    body_force: Array = field(default_factory=_no_load)
    formulation: Formulation = "displacement"
    linear_solver: SolverName = "auto"
    tolerance: float = TOLERANCE
    max_iterations: int = MAX_ITERATIONS

    def __post_init__(self) -> None:
        nodal = self.mesh.nodes.shape
        needed = {"fixed": nodal, "guess": nodal, **dict.fromkeys(LOADS, (3,))}
        for name, shape in needed.items():
            value = getattr(self, name)
            if np.shape(value) != shape:
                raise ValueError(f"{name} has the shape {np.shape(value)}; {shape} is needed.")
            if not np.all(np.isfinite(value)):
                raise ValueError(f"{name} is not finite.")

    def with_load_factor(self, factor: float) -> SolidProblem:
        """The same problem with every load times `factor` [-]."""
        return replace(self, **{name: factor * getattr(self, name) for name in LOADS})


class SolidStatus(StrEnum):
    """How a solution ended."""

    CONVERGED = "converged"
    NOT_CONVERGED = "not_converged"
    INVERTED_ELEMENT = "inverted_element"
    NOT_FINITE = "not_finite"


@dataclass(frozen=True, eq=False)
class SolidResult:
    """Equilibrium of a solid rod, or the last admissible state and the reason why there is none.

    `tip_position` (3,) [m] is the area mean of the end section, `tip_centre` (3,) [m] its material point on
    the axis (None where the section is hollow), `tip_rotation` (3, 3) its polar rotation, `strain_energy`
    [J], `residual` [-] is |Q_ext - Q_int|/|Q_int| over the free components, `iterations` counts
    factorisations, `seconds` is wall time with mesh and set-up, `seconds_by_part` splits it, `positions`
    (n, 3) [m] and `reactions` (n, 3) [N], the forces of the supports, belong to the nodes of `problem.mesh`.
    Energy and residual are infinite and the reactions zero when the start value was not admissible.
    """

    status: SolidStatus
    reason: str
    tip_position: Array
    tip_centre: Array | None
    tip_rotation: Array
    strain_energy: float
    residual: float
    iterations: int
    unknowns: int
    seconds: float
    seconds_by_part: dict[str, float]
    positions: Array
    reactions: Array
    problem: SolidProblem

    @property
    def converged(self) -> bool:
        """Whether the state is an equilibrium."""
        return self.status is SolidStatus.CONVERGED

    @property
    def reaction_force(self) -> Array:
        """Resultant of the supports (3,) [N]."""
        return self.reactions.sum(axis=0)

    @property
    def reaction_moment(self) -> Array:
        """Moment of the supports about the origin, sum x_a x f_a (3,) [N m]."""
        return np.cross(self.positions, self.reactions).sum(axis=0)

    def tip_angle(self, near: float) -> float:
        """Rotation of the tip about z [rad] on the branch closest to `near`, for bending in the x-y plane."""
        angle = np.arctan2(self.tip_rotation[1, 0], self.tip_rotation[0, 0])
        return float(angle + 2 * np.pi * np.round((near - angle) / (2 * np.pi)))
