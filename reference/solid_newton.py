"""Newton's method for the static equilibrium of a solid rod.

Symbols: `u` nodal displacement (n, 3) [m], `F` deformation gradient, `P_pk1` and `A_pk1` stress and tangent,
`S_pk2` second Piola-Kirchhoff stress, `Q_int`, `Q_ext` nodal forces [N], `K` tangent [N/m].
"""

from __future__ import annotations

from collections.abc import Callable
from time import perf_counter

import numpy as np
from numpy.typing import NDArray

from reference.solid_assembly import SolidAssembly
from reference.solid_cost import check_cost
from reference.solid_couple import (
    couple_force,
    resultant_force,
    section_moments,
    section_rotation,
    section_spin,
)
from reference.solid_forms import solid_form
from reference.solid_linear import linear_solver
from reference.solid_problem import SolidProblem, SolidResult, SolidStatus

Array = NDArray[np.float64]

FORCE_FLOOR = 1e-5  # of E A: TOLERANCE times this is the round-off of a stress-free rod
STALLED_STEP = 1e-9  # of the length: so small a step with a residual below STALLED_RESIDUAL is round-off
STALLED_RESIDUAL = 1e-6
MAX_HALVINGS = 8


def solve_solid(
    problem: SolidProblem,
    *,
    begin: float | None = None,
    memory_limit: float | None = None,
    seconds_limit: float | None = None,
    report: Callable[[str], None] | None = None,
) -> SolidResult:
    """Newton's method from `problem.guess` at the full load; a failure is a status, never an exception.

    Parameters
    ----------
    problem : SolidProblem
        What to solve.
    begin : float, optional
        [s, perf_counter]. Starts the clock earlier, so that `seconds` includes the making of the mesh.
    memory_limit : float, optional
        [byte]; None: the memory of the machine.
    seconds_limit : float, optional
        [s].
    report : callable, optional
        Takes the estimated cost as one line before the work starts; None: standard error, where it is long.

    Raises
    ------
    SolidTooLarge
        When the estimate exceeds a limit; nothing has been allocated then.
    """
    begin = perf_counter() if begin is None else begin
    check_cost(
        problem.mesh,
        problem.formulation,
        memory_limit=memory_limit,
        seconds_limit=seconds_limit,
        report=report,
    )
    return Newton(problem, begin).run()


class Newton:
    """State of the iteration.

    The tangent is that of the mixed-integration-point method: its geometric part takes the stress predicted
    by the last linear step, S(u_k) + dS(du), instead of S(u_k+1), which saves up to half of the
    iterations; the residual is the true one (Magisano, Leonetti, Garcea 2017). The pressure of the mixed
    form is predicted alike, p(u_k) + dp(du), which is Newton on displacement and pressure; it starts from
    zero, because the small error of volume of a start value makes an enormous pressure at nu near 1/2.
    """

    def __init__(self, problem: SolidProblem, begin: float) -> None:
        mesh = problem.mesh
        self.begin = self._clock = begin
        self.seconds = {"setup": 0.0, "assembly": 0.0, "linear_solve": 0.0}
        self.assembly = SolidAssembly(mesh, problem.fixed)
        self.form = solid_form(problem.formulation, problem.material, self.assembly)
        self.linear = linear_solver(problem.linear_solver, self.assembly.block_starts)
        self.start, self.end = mesh.plane(0), mesh.plane(-1)
        self.W = section_moments(mesh.section.nodes, mesh.section.mass)
        self.share = mesh.section.mass.sum(axis=0) / mesh.section.area
        self.restart(problem, np.zeros(self.assembly.volume.shape))
        self._charge("setup")

    def restart(self, problem: SolidProblem, p: Array) -> None:
        """Another start value, pressure p (n_el, n_qp) and loads on the same mesh, law and supports."""
        self.problem = problem
        self.p = p
        self.u = problem.guess.astype(float)
        self.F = self.assembly.deformation_gradient(self.u)
        self.S_predicted: Array | None = None
        self.step = np.inf
        self.iterations = 0
        self.residual = np.inf
        self.out_of_balance = np.zeros_like(self.u)

    @np.errstate(all="ignore")  # numbers that are not finite are caught and reported
    def run(self) -> SolidResult:
        """Iterate to an equilibrium or to a reason why there is none."""
        problem = self.problem
        where = self.form.inadmissible(self.F)
        if where:
            return self.result(SolidStatus.INVERTED_ELEMENT, f"The start value is not admissible: {where}.")
        while True:
            try:
                self.evaluate()
            except np.linalg.LinAlgError:
                reason = "The end section is flat or a line: its rotation is not defined."
                return self.result(SolidStatus.NOT_FINITE, reason)
            at = f"residual {self.residual:.1e} after {self.iterations} iterations"
            if not np.isfinite(self.residual):
                return self.result(SolidStatus.NOT_FINITE, f"The nodal forces are not finite; {at}.")
            if self.residual <= problem.tolerance:
                return self.result(SolidStatus.CONVERGED, at)
            if self.step <= STALLED_STEP * problem.mesh.length and self.residual <= STALLED_RESIDUAL:
                return self.result(SolidStatus.CONVERGED, f"{at}, at the round-off of the stress")
            if self.iterations >= problem.max_iterations:
                advice = "Start closer to the solution or apply the load in steps."
                return self.result(SolidStatus.NOT_CONVERGED, f"{at} > {problem.tolerance:.1e}. {advice}")
            try:
                du = self.direction()
            except np.linalg.LinAlgError as error:
                return self.result(SolidStatus.NOT_FINITE, f"The tangent is singular: {error}; {at}.")
            if not np.all(np.isfinite(du)):
                return self.result(SolidStatus.NOT_FINITE, f"The Newton step is not finite; {at}.")
            inverted = self.advance(du)
            if inverted:
                reason = f"{MAX_HALVINGS} halvings of the step do not cure it: {inverted}; {at}."
                return self.result(SolidStatus.INVERTED_ELEMENT, reason)

    def evaluate(self) -> None:
        """Stress, out-of-balance force, load tangent and residual of the present state."""
        problem, mesh = self.problem, self.problem.mesh
        self.P_pk1 = self.form.stress(self.F)
        Q_int = self.assembly.internal_force(self.P_pk1)
        spin = section_spin(mesh.nodes[self.end] + self.u[self.end], self.W)
        Q_couple, K_couple = couple_force(spin, problem.moment, problem.follower_moment)
        Q_force, K_force = resultant_force(spin, self.share, problem.force, problem.follower_force)
        self.K_load = K_couple + K_force
        self.out_of_balance = self.assembly.nodal_volume[:, None] * problem.body_force - Q_int
        self.out_of_balance[self.end] += Q_couple + Q_force
        self.out_of_balance[self.start] += self.share[:, None] * problem.start_force
        self.right = np.where(problem.fixed, 0.0, self.out_of_balance)
        floor = FORCE_FLOOR * problem.material.young_modulus * mesh.section.area
        self.residual = float(np.linalg.norm(self.right) / max(float(np.linalg.norm(Q_int)), floor))
        self._charge("assembly")

    def direction(self) -> Array:
        """Newton step (n, 3) [m] with the mixed-integration-point tangent."""
        self.linearisation = self.form.linearise(self.F, self.p)
        self.S_pk2 = np.linalg.solve(self.F, self.linearisation.P_pk1)
        A_mixed = self.linearisation.A_pk1
        if self.S_predicted is not None:
            A_mixed = A_mixed.copy()
            for i in range(3):  # d_ik (S_predicted - S)_JL
                A_mixed[..., i, :, i, :] += self.S_predicted - self.S_pk2
        K = self.assembly.tangent(A_mixed, self.K_load, self.linearisation.K_element)
        self._charge("assembly")
        du = self.linear.solve(K, self.right.ravel()).reshape(-1, 3)
        self.iterations += 1
        self._charge("linear_solve")
        return du

    def advance(self, du: Array) -> str:
        """Take the step, halved until no point is inverted; returns the inverted place if that fails."""
        dF = self.assembly.gradient(du)
        for _ in range(MAX_HALVINGS + 1):
            where = self.form.inadmissible(self.F + dF)
            if not where:
                break
            du, dF = du / 2, dF / 2
        else:
            return where
        dP = self.linearisation.stress_rate(dF)
        S_predicted = np.linalg.solve(self.F, self.P_pk1 + dP - dF @ self.S_pk2)
        self.S_predicted = np.asarray(S_predicted, float)
        self.p = self.form.point_pressure(self.F) + self.linearisation.pressure_rate(dF)
        self.u = self.u + du
        self.F = self.assembly.deformation_gradient(self.u)
        self.step = float(np.max(np.abs(du)))
        return ""

    def result(self, status: SolidStatus, reason: str) -> SolidResult:
        """Record of the present state."""
        problem, mesh = self.problem, self.problem.mesh
        x = mesh.nodes + self.u
        x_end, centre = x[self.end], mesh.section.centre
        return SolidResult(
            status=status,
            reason=reason,
            tip_position=self.share @ x_end,
            tip_centre=None if centre is None else x_end[centre],
            tip_rotation=section_rotation(x_end, self.W),
            strain_energy=self.form.energy(self.F) if np.isfinite(self.residual) else np.inf,
            residual=self.residual if np.isfinite(self.residual) else np.inf,
            iterations=self.iterations,
            unknowns=int(np.sum(~problem.fixed)),
            seconds=perf_counter() - self.begin,
            seconds_by_part=self.seconds,
            positions=x,
            reactions=np.where(problem.fixed, -self.out_of_balance, 0.0),
            problem=problem,
        )

    def _charge(self, part: str) -> None:
        """Charge the time since the last call to a part of the solution."""
        now = perf_counter()
        self.seconds[part] += now - self._clock
        self._clock = now
