"""Static equilibrium of a solid rod: problem, result, and Newton's method between them.

Symbols: `u` nodal displacement (n, 3) [m], `F` deformation gradient, `P_pk1` and `A_pk1` stress and tangent,
`S_pk2` second Piola-Kirchhoff stress, `Q_int`, `Q_ext` nodal forces [N], `K` tangent [N/m].
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import StrEnum
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from reference.solid_assembly import SolidAssembly
from reference.solid_couple import couple_force, section_moments, section_rotation
from reference.solid_materials import SolidMaterial
from reference.solid_mesh import RodMesh

Array = NDArray[np.float64]

TOLERANCE = 1e-10  # of |Q_int|
FORCE_FLOOR = 1e-5  # of E A: TOLERANCE times this is the round-off of a stress-free rod
STALLED_STEP = 1e-9  # of the length: so small a step with a residual below STALLED_RESIDUAL is round-off
STALLED_RESIDUAL = 1e-6
MAX_ITERATIONS = 30
MAX_HALVINGS = 8


class SolidStatus(StrEnum):
    """How a solution ended."""

    CONVERGED = "converged"
    NOT_CONVERGED = "not_converged"
    INVERTED_ELEMENT = "inverted_element"
    NOT_FINITE = "not_finite"


@dataclass(frozen=True, eq=False)
class SolidProblem:
    """A rod, its law, its supports, the couple on its end face and a start value.

    `fixed` (n, 3) bool marks the displacement components that keep the value they have in `guess` (n, 3)
    [m]; `moment` (3,) [N m] is fixed in space. Raises `ValueError` for wrong shapes and values that are not
    finite.
    """

    mesh: RodMesh
    material: SolidMaterial
    fixed: NDArray[np.bool_]
    guess: Array
    moment: Array = field(default_factory=lambda: np.zeros(3))
    tolerance: float = TOLERANCE
    max_iterations: int = MAX_ITERATIONS

    def __post_init__(self) -> None:
        nodal = self.mesh.nodes.shape
        for name, value, shape in [
            ("fixed", self.fixed, nodal),
            ("guess", self.guess, nodal),
            ("moment", self.moment, (3,)),
        ]:
            if value.shape != shape:
                raise ValueError(f"{name} has the shape {value.shape}; {shape} is needed.")
            if not np.all(np.isfinite(value)):
                raise ValueError(f"{name} is not finite.")


@dataclass(frozen=True, eq=False)
class SolidResult:
    """Equilibrium of a solid rod, or the last admissible state and the reason why there is none.

    `tip_position` (3,) [m] is the area mean of the end section, `tip_centre` (3,) [m] its material point on
    the axis, `tip_rotation` (3, 3) its polar rotation, `strain_energy` [J], `residual` [-] is
    |Q_ext - Q_int|/|Q_int| over the free components, `iterations` counts factorisations, `seconds` is wall
    time with mesh and set-up, `seconds_by_part` splits it, `positions` (n, 3) [m] belongs to the nodes of
    `problem.mesh`.
    Energy and residual are infinite when the start value was not admissible.
    """

    status: SolidStatus
    reason: str
    tip_position: Array
    tip_centre: Array
    tip_rotation: Array
    strain_energy: float
    residual: float
    iterations: int
    unknowns: int
    seconds: float
    seconds_by_part: dict[str, float]
    positions: Array
    problem: SolidProblem

    @property
    def converged(self) -> bool:
        """Whether the state is an equilibrium."""
        return self.status is SolidStatus.CONVERGED

    def tip_angle(self, near: float) -> float:
        """Rotation of the tip about z [rad] on the branch closest to `near`, for bending in the x-y plane."""
        angle = np.arctan2(self.tip_rotation[1, 0], self.tip_rotation[0, 0])
        return float(angle + 2 * np.pi * np.round((near - angle) / (2 * np.pi)))


def solve_solid(problem: SolidProblem, *, begin: float | None = None) -> SolidResult:
    """Newton's method from `problem.guess` at the full load; a failure is a status, never an exception.

    `begin` [s, perf_counter] starts the clock earlier, so that `seconds` includes the making of the mesh.
    """
    newton = _Newton(problem, perf_counter() if begin is None else begin)
    lowest, where = _lowest_determinant(newton.F)
    if lowest <= 0:
        return newton.result(SolidStatus.INVERTED_ELEMENT, f"The start value is not admissible: {where}.")
    while True:
        newton.evaluate()
        at = f"residual {newton.residual:.1e} after {newton.iterations} iterations"
        if newton.residual <= problem.tolerance:
            return newton.result(SolidStatus.CONVERGED, at)
        if newton.step <= STALLED_STEP * problem.mesh.length and newton.residual <= STALLED_RESIDUAL:
            return newton.result(SolidStatus.CONVERGED, f"{at}, at the round-off of the stress")
        if newton.iterations >= problem.max_iterations:
            advice = "Start closer to the solution or apply the load in steps."
            return newton.result(SolidStatus.NOT_CONVERGED, f"{at} > {problem.tolerance:.1e}. {advice}")
        try:
            du = newton.direction()
        except np.linalg.LinAlgError as error:
            return newton.result(SolidStatus.NOT_FINITE, f"The tangent is singular: {error}; {at}.")
        if not np.all(np.isfinite(du)):
            return newton.result(SolidStatus.NOT_FINITE, f"The Newton step is not finite; {at}.")
        inverted = newton.advance(du)
        if inverted:
            reason = f"{MAX_HALVINGS} halvings of the step do not cure it: {inverted}; {at}."
            return newton.result(SolidStatus.INVERTED_ELEMENT, reason)


class _Newton:
    """State of the iteration.

    The tangent is that of the mixed-integration-point method: its geometric part takes the stress predicted
    by the last linear step, S(u_k) + dS(du), instead of S(u_k+1), which saves up to half of the
    iterations; the residual is the true one (Magisano, Leonetti, Garcea 2017).
    """

    def __init__(self, problem: SolidProblem, begin: float) -> None:
        mesh = problem.mesh
        self.problem = problem
        self.begin = self._clock = begin
        self.seconds = {"setup": 0.0, "assembly": 0.0, "linear_solve": 0.0}
        self.assembly = SolidAssembly(mesh, problem.fixed)
        self.end = mesh.plane(-1)
        self.W = section_moments(mesh.section.nodes, mesh.section.mass)
        self.u = problem.guess.astype(float)
        self.F = self.assembly.deformation_gradient(self.u)
        self.S_predicted: Array | None = None
        self.step = np.inf
        self.iterations = 0
        self.residual = np.inf
        self._charge("setup")

    def evaluate(self) -> None:
        """Stress, out-of-balance force, couple tangent and residual of the present state."""
        mesh, material = self.problem.mesh, self.problem.material
        self.P_pk1 = material.stress(self.F)
        Q_int = self.assembly.internal_force(self.P_pk1)
        x_end = mesh.nodes[self.end] + self.u[self.end]
        Q_couple, self.K_load = couple_force(x_end, self.W, self.problem.moment)
        self.right = -Q_int
        self.right[self.end] += Q_couple
        self.right[self.problem.fixed] = 0.0
        floor = FORCE_FLOOR * material.young_modulus * mesh.section.area
        self.residual = float(np.linalg.norm(self.right) / max(float(np.linalg.norm(Q_int)), floor))
        self._charge("assembly")

    def direction(self) -> Array:
        """Newton step (n, 3) [m] with the mixed-integration-point tangent."""
        self.A_pk1 = self.problem.material.tangent(self.F)
        self.S_pk2 = np.linalg.solve(self.F, self.P_pk1)
        A_mixed = self.A_pk1
        if self.S_predicted is not None:
            A_mixed = self.A_pk1.copy()
            for i in range(3):  # d_ik (S_predicted - S)_JL
                A_mixed[..., i, :, i, :] += self.S_predicted - self.S_pk2
        K = self.assembly.tangent(A_mixed, self.K_load)
        self._charge("assembly")
        du = self.assembly.solve(K, self.right)
        self.iterations += 1
        self._charge("linear_solve")
        return du

    def advance(self, du: Array) -> str:
        """Take the step, halved until no point is inverted; returns the inverted place if that fails."""
        dF = self.assembly.gradient(du)
        for _ in range(MAX_HALVINGS + 1):
            lowest, where = _lowest_determinant(self.F + dF)
            if lowest > 0:
                break
            du, dF = du / 2, dF / 2
        else:
            return where
        dP = np.einsum("eqiJkL,eqkL->eqiJ", self.A_pk1, dF, optimize=True)
        self.S_predicted = self.S_pk2 + np.linalg.solve(self.F, dP - dF @ self.S_pk2)
        self.u = self.u + du
        self.F = self.assembly.deformation_gradient(self.u)
        self.step = float(np.max(np.abs(du)))
        return ""

    def result(self, status: SolidStatus, reason: str) -> SolidResult:
        """Record of the present state."""
        problem, mesh = self.problem, self.problem.mesh
        x = mesh.nodes + self.u
        x_end = x[self.end]
        energy = (
            self.assembly.integrate(problem.material.energy(self.F)) if self.residual < np.inf else np.inf
        )
        return SolidResult(
            status=status,
            reason=reason,
            tip_position=mesh.section.mass.sum(axis=0) @ x_end / mesh.section.area,
            tip_centre=x_end[mesh.section.centre],
            tip_rotation=section_rotation(x_end, self.W),
            strain_energy=energy,
            residual=self.residual,
            iterations=self.iterations,
            unknowns=int(np.sum(~problem.fixed)),
            seconds=perf_counter() - self.begin,
            seconds_by_part=self.seconds,
            positions=x,
            problem=problem,
        )

    def _charge(self, part: str) -> None:
        """Charge the time since the last call to a part of the solution."""
        now = perf_counter()
        self.seconds[part] += now - self._clock
        self._clock = now


def _lowest_determinant(F: Array) -> tuple[float, str]:
    """Smallest det F of all integration points, and where it is."""
    J = np.linalg.det(F)
    element, point = np.unravel_index(np.argmin(J), J.shape)
    return float(J[element, point]), f"det F = {J[element, point]:.2e} in element {element}, point {point}"
