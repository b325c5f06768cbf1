"""Rod with extension, shear, bending and torsion (Simo-Reissner), clamped at one end: boundary-value solver.

Symbols
-------
s, L      reference arc length and length, [m]
R, q      section frame, columns d1 (normal to the section), d2 = y, d3 = z; its quaternion
n, m      internal force [N] and moment [N m] in space
gamma     stretch of the axis in section axes, e1 + (n1/EA, n2/GA_y, n3/GA_z), with n_i = d_i.n, [-]
kappa     curvature in section axes, kappa_0 + (m1/GJ, m2/EI_y, m3/EI_z), [1/m]
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from reference import rotation as rot
from reference.rod_collocation import STEP_TOLERANCE, Collocation, RodEquations, State

Array = NDArray[np.float64]

FIRST_ELEMENTS = 12  # coarse mesh of the load continuation; order 8, some 1e-6 for a smooth load
MOST_ELEMENTS = 400
LARGEST_TURN = 0.7  # rad a load step: keeps to the branch that starts at zero load
SMALLEST_STEP = 1e-4
ON_THE_WAY = 1e-4  # Newton tolerance before load factor 1: only a start for the next step


def _zeros() -> Array:
    return np.zeros(3)


class RodNotSolved(RuntimeError):
    """The boundary-value problem was not solved; the message says at which load factor and why."""


@dataclass(frozen=True, eq=False)
class RodProperties:
    """A rod of constant stiffness: length [m], EA, GA_y, GA_z [N], GJ, EI_y, EI_z [N m2].

    EI_y = E int z^2 dA resists bending about d2. `curvature` (3,) [1/m] is the twist and the curvatures about
    d2 and d3 of the unstressed rod (positive about d3 bends d1 towards d2), constant along it. Base: position
    (3,) [m], rotation (3, 3) with columns d1, d2, d3 at the clamp.
    """

    length: float
    EA: float
    GA_y: float
    GA_z: float
    GJ: float
    EI_y: float
    EI_z: float
    curvature: ArrayLike = field(default_factory=_zeros)
    base_position: ArrayLike = field(default_factory=_zeros)
    base_rotation: ArrayLike = field(default_factory=lambda: np.eye(3))

    @classmethod
    def from_section(
        cls,
        length: float,
        young_modulus: float,
        poisson_ratio: float,
        area: float,
        I_y: float,
        I_z: float,
        J_t: float | None = None,
        shear_factors: tuple[float, float] = (1.0, 1.0),
        curvature: ArrayLike = (0.0, 0.0, 0.0),
        base_position: ArrayLike = (0.0, 0.0, 0.0),
        base_rotation: ArrayLike = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    ) -> RodProperties:
        """Rod of an isotropic material: I_y = int z^2 dA [m4]; J_t = k_y I_y + k_z I_z [m4] unless given.

        That J_t is what a section which stays plane has (3243, 3333), and exact for a circle.
        """
        G = young_modulus / (2 * (1 + poisson_ratio))
        return cls(
            length=length,
            EA=young_modulus * area,
            GA_y=shear_factors[0] * G * area,
            GA_z=shear_factors[1] * G * area,
            GJ=G * (shear_factors[0] * I_y + shear_factors[1] * I_z if J_t is None else J_t),
            EI_y=young_modulus * I_y,
            EI_z=young_modulus * I_z,
            curvature=curvature,
            base_position=base_position,
            base_rotation=base_rotation,
        )

    @classmethod
    def circle(
        cls,
        length: float,
        radius: float,
        young_modulus: float,
        poisson_ratio: float,
        curvature: ArrayLike = (0.0, 0.0, 0.0),
        base_position: ArrayLike = (0.0, 0.0, 0.0),
        base_rotation: ArrayLike = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)),
    ) -> RodProperties:
        """Round rod, shear factors 1: A = pi R^2, I = pi R^4/4, J_t = 2 I."""
        area, moment = np.pi * radius**2, np.pi * radius**4 / 4
        return cls.from_section(
            length,
            young_modulus,
            poisson_ratio,
            area,
            moment,
            moment,
            curvature=curvature,
            base_position=base_position,
            base_rotation=base_rotation,
        )

    def reference(self, s: ArrayLike) -> tuple[Array, Array]:
        """Unstressed rod at s: positions (n, 3) [m] and frames (n, 3, 3), a helix or arc."""
        s = np.atleast_1d(np.asarray(s, dtype=float))
        v = s[:, None] * np.asarray(self.curvature, dtype=float)
        R0 = np.asarray(self.base_rotation, dtype=float)
        local = s[:, None] * rot.exp_integral(v)[..., 0]
        return np.asarray(self.base_position, dtype=float) + local @ R0.T, R0 @ rot.exp(v)


@dataclass(frozen=True, eq=False)
class RodLoads:
    """Loads on a rod, all (3,), components in space [N, N m, N/m].

    Dead loads keep their direction; a follower value is given on the unstressed rod and turns with the tip
    section, F = R_tip R_ref^T F_ref. `line_load` is a dead force per reference length (weight: rho A g).
    """

    tip_force: ArrayLike = field(default_factory=_zeros)
    tip_moment: ArrayLike = field(default_factory=_zeros)
    follower_tip_force: ArrayLike = field(default_factory=_zeros)
    follower_tip_moment: ArrayLike = field(default_factory=_zeros)
    line_load: ArrayLike = field(default_factory=_zeros)


@dataclass(frozen=True, eq=False)
class RodSolution:
    """Equilibrium of a rod at the stations s (n,) [m].

    position (n, 3) [m]; frame (n, 3, 3), columns d1 d2 d3; rotation (n, 3, 3) relative to the reference
    section; force (n, 3) [N] and moment (n, 3) [N m], internal, in space, on the part towards the clamp;
    reference_position (n, 3) [m]; estimated_error [-]: position error over the length and rotation error in
    rad, the larger, against a mesh of half the elements; elements, load_steps, iterations: the work done.
    """

    s: Array
    position: Array
    frame: Array
    rotation: Array
    force: Array
    moment: Array
    reference_position: Array
    estimated_error: float
    elements: int
    load_steps: int
    iterations: int

    @property
    def displacement(self) -> Array:
        """Position minus reference position (n, 3) [m]."""
        return self.position - self.reference_position


def _equations(rod: RodProperties, loads: RodLoads) -> Callable[[float], RodEquations]:
    """Return the dimensionless equations at a load factor: units L, EI/L^2, EI/L of length, force, moment."""
    L = rod.length
    EI = max(rod.EI_y, rod.EI_z)
    _, tip_frame = rod.reference(L)

    def scaled(value: ArrayLike, unit: float, into: Array | None = None) -> Array:
        v = np.asarray(value, dtype=float) / unit
        return v if into is None else into.T @ v

    def at(load_factor: float) -> RodEquations:
        return RodEquations(
            compliance_n=EI / L**2 / np.array([rod.EA, rod.GA_y, rod.GA_z]),
            compliance_m=EI / np.array([rod.GJ, rod.EI_y, rod.EI_z]),
            kappa0=np.asarray(rod.curvature, dtype=float) * L,
            tip_force=load_factor * scaled(loads.tip_force, EI / L**2),
            tip_moment=load_factor * scaled(loads.tip_moment, EI / L),
            body_force=load_factor * scaled(loads.follower_tip_force, EI / L**2, tip_frame[0]),
            body_moment=load_factor * scaled(loads.follower_tip_moment, EI / L, tip_frame[0]),
            line_load=load_factor * scaled(loads.line_load, EI / L**3),
        )

    return at


def solve_rod(
    rod: RodProperties,
    loads: RodLoads,
    s: ArrayLike | None = None,
    tolerance: float = 1e-11,
    first_step: float = 1.0,
) -> RodSolution:
    """Equilibrium of a clamped-free rod.

    r' = R gamma,  R' = R hat(kappa),  n' = -line_load,  m' = -r' x n;  clamp at s = 0, loads at s = L.

    Parameters
    ----------
    rod : RodProperties
    loads : RodLoads
    s : (n,) [m] stations wanted, default the tip
    tolerance : wanted estimated error (of the length, and in rad)
    first_step : first load factor tried, 1 unless the branch has to be followed in finer steps

    Returns
    -------
    RodSolution

    Raises
    ------
    RodNotSolved when Newton fails at the smallest load step (limit point), or the finest mesh misses
    `tolerance`.

    Notes
    -----
    Gauss collocation of order 8, Newton with the exact Jacobian, load continuation on a coarse mesh in which
    no section turns more than 0.7 rad a step; then the elements are doubled until two meshes agree. Typically
    0.03 to 0.3 s with one BLAS thread. Forces up to some 1e3 EI/L^2. A perfectly straight rod under axial
    load stays straight: bifurcations are not followed.
    Simo 1985; Antman, Nonlinear Problems of Elasticity, ch. 8; collocation: Ascher, Mattheij, Russell 1988.
    """
    base = np.asarray(rod.base_rotation, dtype=float)
    if base.shape != (3, 3) or np.abs(base.T @ base - np.eye(3)).max() > 1e-9 or np.linalg.det(base) < 0:
        raise ValueError("base_rotation must be a 3 x 3 rotation matrix")
    L = rod.length
    s = np.array([L]) if s is None else np.atleast_1d(np.asarray(s, dtype=float))
    if s.min() < 0 or s.max() > L * (1 + 1e-12):
        raise ValueError(f"stations must lie between 0 and the length {L}")
    at = _equations(rod, loads)
    # A boundary layer of length sqrt(EI/F) has to be seen by the first mesh already.
    heaviest = at(1.0)
    forces = (heaviest.tip_force, heaviest.body_force, heaviest.line_load)
    force = sum(float(np.linalg.norm(f)) for f in forces)
    first = max(FIRST_ELEMENTS, int(0.4 * np.sqrt(force)))
    if first > MOST_ELEMENTS:
        raise RodNotSolved(f"a force of {force:.1e} EI/L^2 needs {first} elements, more than {MOST_ELEMENTS}")
    mesh = Collocation(first, base)
    state, steps, iterations = _continue(mesh, at, first_step)

    x = np.minimum(s / L, 1.0)
    equations = at(1.0)
    before = mesh.evaluate(state, equations, x)
    while True:
        finer = mesh.refined()
        if finer.elements > MOST_ELEMENTS:
            raise RodNotSolved(f"estimated error above {tolerance:.1e} with {mesh.elements} elements")
        result = finer.newton(finer.transfer(mesh, state, equations), equations)
        iterations += result.iterations
        if result.state is None:
            raise RodNotSolved(f"Newton failed on {finer.elements} elements: {result.reason}")
        mesh, state = finer, result.state
        now = mesh.evaluate(state, equations, x)
        error = max(
            float(np.abs(now.position - before.position).max()),
            float(np.abs(now.frame - before.frame).max()),
        )
        if error <= tolerance:
            break
        before = now

    EI = max(rod.EI_y, rod.EI_z)
    reference_position, reference_frame = rod.reference(s)
    return RodSolution(
        s=s,
        position=np.asarray(rod.base_position, dtype=float) + L * now.position,
        frame=now.frame,
        rotation=now.frame @ np.swapaxes(reference_frame, -1, -2),
        force=now.force * EI / L**2,
        moment=now.moment * EI / L,
        reference_position=reference_position,
        estimated_error=error,
        elements=mesh.elements,
        load_steps=steps,
        iterations=iterations,
    )


def _continue(
    mesh: Collocation, at: Callable[[float], RodEquations], first_step: float
) -> tuple[State, int, int]:
    """Follow the solution from zero load to load factor 1; returns state, steps, iterations."""
    state = mesh.unstressed(at(0.0))
    previous: tuple[float, State] | None = None
    factor, step, steps, iterations = 0.0, min(first_step, 1.0), 0, 0
    reason = ""
    while factor < 1.0:
        if step < SMALLEST_STEP:
            raise RodNotSolved(f"no equilibrium beyond load factor {factor:.6g} (step {steps}): {reason}")
        target = min(1.0, factor + step)
        guess = state
        if previous is not None:
            guess = mesh.extrapolate(previous[1], state, (target - factor) / (factor - previous[0]))
        result = mesh.newton(guess, at(target), ON_THE_WAY if target < 1.0 else STEP_TOLERANCE)
        iterations += result.iterations
        reason = result.reason
        if result.state is not None:
            turn = mesh.largest_turn(state, result.state)
            if turn <= LARGEST_TURN:
                previous = (factor, state)
                factor, state, steps = target, result.state, steps + 1
                step *= float(np.clip(0.75 * LARGEST_TURN / max(turn, 1e-9), 0.5, 3.0))
                continue
            reason = f"a section turns by {turn:.2f} rad in one step"
        step *= 0.4
    return state, steps, iterations
