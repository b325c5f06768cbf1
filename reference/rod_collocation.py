"""Gauss collocation of the rod equations: residual, exact Jacobian, Newton, evaluation.

Everything is dimensionless (length 1, bending stiffness 1). The unknowns of a node are y = (q, m), quaternion
and moment in space; the force n(s) = n_tip + line_load (1 - s) is known up to n_tip, three more unknowns.
Gauss methods keep |q| = 1 to rounding because it is a quadratic invariant (Hairer, Lubich, Wanner, Geometric
Numerical Integration, IV.2).

Symbols
-------
y, Y     node and stage values of (q, m), 7 numbers
f        right-hand side, y' = f(y, n)
A, b, c  Gauss-Legendre coefficients, K = 4 stages, order 8
h        element length
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference import rotation as rot

Array = NDArray[np.float64]

STAGES = 4
MOST_ITERATIONS = 12
STEP_TOLERANCE = 1e-7  # Newton converges quadratically: after a step this small the error is near rounding
DIVERGED = 3.0  # a quaternion step beyond this is no correction; give up early and take a smaller load step


def _gauss_coefficients(K: int) -> tuple[Array, Array, Array]:
    """Butcher coefficients A, b, c of the K-stage Gauss method, by integrating Lagrange polynomials."""
    c, b = np.polynomial.legendre.leggauss(K)
    c, b = np.array((c + 1) / 2, dtype=np.float64), np.array(b / 2, dtype=np.float64)
    powers = np.arange(K)
    # sum_j A_ij c_j^p = c_i^(p+1)/(p+1) for p < K
    A = np.linalg.solve((c[:, None] ** powers).T, (c[:, None] ** (powers + 1) / (powers + 1)).T).T
    return np.array(A, dtype=np.float64), b, c


A, b, c = _gauss_coefficients(STAGES)


@dataclass(frozen=True, eq=False)
class RodEquations:
    """Dimensionless data, all (3,): compliances, reference curvature, loads in space or tip section axes."""

    compliance_n: Array
    compliance_m: Array
    kappa0: Array
    tip_force: Array
    tip_moment: Array
    body_force: Array
    body_moment: Array
    line_load: Array

    def slope(self, y: Array, n: Array) -> tuple[Array, Array, Array, Array]:
        """Right-hand side and derivatives: f (..., 7), df/dy (..., 7, 7), df/dn (..., 7, 3), r' (..., 3).

        q' = q o (0, kappa)/2, m' = -r' x n, r' = R gamma.
        """
        q, m = y[..., :4], y[..., 4:]
        R = rot.matrix(q)
        Rt = np.swapaxes(R, -1, -2)
        kappa = self.kappa0 + self.compliance_m * (Rt @ m[..., None])[..., 0]
        gamma = np.array([1.0, 0.0, 0.0]) + self.compliance_n * (Rt @ n[..., None])[..., 0]
        dr = (R @ gamma[..., None])[..., 0]

        dkappa_dq = self.compliance_m[:, None] * rotated_by_q(q, m, transpose=True)
        dkappa_dm = self.compliance_m[:, None] * Rt
        dr_dq = rotated_by_q(q, gamma) + R @ (self.compliance_n[:, None] * rotated_by_q(q, n, transpose=True))
        dr_dn = R @ (self.compliance_n[:, None] * Rt)

        Q = _left(q)
        f = np.concatenate([0.5 * (Q @ kappa[..., None])[..., 0], -rot.cross(dr, n)], axis=-1)
        df_dy = np.zeros((*y.shape[:-1], 7, 7))
        df_dy[..., :4, :4] = 0.5 * (_right(kappa) + Q @ dkappa_dq)
        df_dy[..., :4, 4:] = 0.5 * Q @ dkappa_dm
        n_hat = rot.hat(n)
        df_dy[..., 4:, :4] = n_hat @ dr_dq
        df_dn = np.zeros((*y.shape[:-1], 7, 3))
        df_dn[..., 4:, :] = n_hat @ dr_dn - rot.hat(dr)
        return f, df_dy, df_dn, dr


def rotated_by_q(q: Array, v: Array, transpose: bool = False) -> Array:
    """Derivative of R(q) v, or R(q)^T v, by q = (w, u): (..., 3, 4).

    R v = (w^2 - u.u) v + 2 u (u.v) + 2 w u x v; the transpose has -w in the last term.
    """
    w, u = q[..., :1], q[..., 1:]
    sign = -1.0 if transpose else 1.0
    by_w = 2 * w * v + 2 * sign * rot.cross(u, v)
    uv = np.sum(u * v, axis=-1)[..., None, None]
    by_u = 2 * (
        -v[..., :, None] * u[..., None, :]
        + uv * np.eye(3)
        + u[..., :, None] * v[..., None, :]
        - sign * w[..., None] * rot.hat(v)
    )
    return np.concatenate([by_w[..., None], by_u], axis=-1)


def _left(q: Array) -> Array:
    """Matrix Q (..., 4, 3) with q o (0, k) = Q k."""
    w, u = q[..., 0], q[..., 1:]
    return np.concatenate([-u[..., None, :], w[..., None, None] * np.eye(3) + rot.hat(u)], axis=-2)


def _right(k: Array) -> Array:
    """Matrix W (..., 4, 4) with q o (0, k) = W q."""
    W = np.zeros((*k.shape[:-1], 4, 4))
    W[..., 0, 1:], W[..., 1:, 0] = -k, k
    W[..., 1:, 1:] = -rot.hat(k)
    return W


@dataclass(frozen=True, eq=False)
class State:
    """Node values y (N+1, 7), stage values Y (N, K, 7), tip force n_tip (3,)."""

    y: Array
    Y: Array
    n_tip: Array


@dataclass(frozen=True, eq=False)
class NewtonResult:
    """State or None, iterations, and the reason of a failure."""

    state: State | None
    iterations: int
    reason: str = ""


@dataclass(frozen=True, eq=False)
class Values:
    """Position (n, 3), frame (n, 3, 3), force (n, 3), moment (n, 3), dimensionless, base at the origin."""

    position: Array
    frame: Array
    force: Array
    moment: Array


def _normalised(y: Array) -> Array:
    out = y.copy()
    out[..., :4] /= np.linalg.norm(y[..., :4], axis=-1, keepdims=True)
    return out


class Collocation:
    """Uniform mesh of Gauss collocation elements on [0, 1], clamped with the frame `base` (3, 3) at 0."""

    def __init__(self, elements: int, base: Array) -> None:
        self.elements = elements
        self.base = base
        self.h = 1.0 / elements
        self.nodes = np.arange(elements + 1) / elements
        self.stations = self.nodes[:-1, None] + self.h * c  # (N, K)
        self.q_base = rot.quaternion(base)

    def refined(self) -> Collocation:
        """Return the mesh with every element halved."""
        return Collocation(2 * self.elements, self.base)

    def unstressed(self, equations: RodEquations) -> State:
        """State without load."""

        def at(x: Array) -> Array:
            half = x[..., None] * equations.kappa0 / 2
            angle = np.linalg.norm(half, axis=-1)[..., None]
            turn = np.concatenate([np.cos(angle), np.sinc(angle / np.pi) * half], axis=-1)
            # base quaternion times the turn, continuous in x (no change of sign)
            q = turn[..., :1] * self.q_base + (_left(self.q_base) @ turn[..., 1:, None])[..., 0]
            return np.concatenate([q, np.zeros((*x.shape, 3))], axis=-1)

        return State(at(self.nodes), at(self.stations), np.zeros(3))

    def extrapolate(self, before: State, now: State, ratio: float) -> State:
        """Return now + ratio (now - before), quaternions renormalised."""
        return State(
            _normalised(now.y + ratio * (now.y - before.y)),
            _normalised(now.Y + ratio * (now.Y - before.Y)),
            now.n_tip + ratio * (now.n_tip - before.n_tip),
        )

    def largest_turn(self, before: State, now: State) -> float:
        """Largest angle [rad] between the frames of two states at a node."""
        cosine = np.abs(np.sum(before.y[:, :4] * now.y[:, :4], axis=1))
        return float(2 * np.arccos(np.minimum(cosine, 1.0)).max())

    def _force(self, n_tip: Array, equations: RodEquations, x: Array) -> Array:
        return n_tip + (1 - x)[..., None] * equations.line_load

    def newton(
        self, state: State, equations: RodEquations, tolerance: float = STEP_TOLERANCE
    ) -> NewtonResult:
        """Newton from `state`, full steps, until a step is below `tolerance`."""
        for iteration in range(1, MOST_ITERATIONS + 1):
            new, size = self._newton_step(state, equations)
            if not np.isfinite(size) or size > DIVERGED:
                return NewtonResult(None, iteration, f"Newton diverged (step {size:.1e})")
            state = new
            if size < tolerance:
                return NewtonResult(state, iteration)
        return NewtonResult(None, MOST_ITERATIONS, f"Newton did not converge in {MOST_ITERATIONS} iterations")

    def _newton_step(self, state: State, equations: RodEquations) -> tuple[State, float]:
        N, K, h = self.elements, STAGES, self.h
        y, Y, n_tip = state.y, state.Y, state.n_tip
        f, df_dy, df_dn, _ = equations.slope(Y, self._force(n_tip, equations, self.stations))

        # Stages of each element: (I - h A df/dy) dY = -G + dy_left + h A df/dn dn_tip.
        G = Y - y[:-1, None] - h * np.einsum("jk,nka->nja", A, f)
        matrix = -h * np.einsum("jk,nkab->njakb", A, df_dy).reshape(N, 7 * K, 7 * K)
        matrix[:, np.arange(7 * K), np.arange(7 * K)] += 1.0
        right = np.zeros((N, K, 7, 11))
        right[..., 0] = -G
        right[..., 1:8] = np.eye(7)
        right[..., 8:] = h * np.einsum("jk,nkab->njab", A, df_dn)
        dY = np.linalg.solve(matrix, right.reshape(N, 7 * K, 11)).reshape(N, K, 7, 11)
        # Element map: dy_right = Phi dy_left + Psi dn_tip + rest.
        step = h * np.einsum("k,nkab,nkbc->nac", b, df_dy, dY)
        step[..., 8:] += h * np.einsum("k,nkab->nab", b, df_dn)
        step[..., 1:8] += np.eye(7)
        rest = step[..., 0] - (y[1:] - y[:-1] - h * np.einsum("k,nka->na", b, f))

        size = 7 * (N + 1) + 3
        J = np.zeros((size, size))
        r = np.zeros(size)
        J[:4, :4] = np.eye(4)
        # y[0] keeps its sign, so the clamp is met with the base quaternion of either sign.
        sign = 1.0 if y[0, :4] @ self.q_base >= 0 else -1.0
        r[:4] = sign * self.q_base - y[0, :4]
        for i in range(N):
            row = slice(4 + 7 * i, 11 + 7 * i)
            J[row, 7 * i + 7 : 7 * i + 14] = np.eye(7)
            J[row, 7 * i : 7 * i + 7] = -step[i, :, 1:8]
            J[row, -3:] = -step[i, :, 8:]
            r[row] = rest[i]
        # Tip: m = tip_moment + R body_moment, n_tip = tip_force + R body_force.
        q = y[-1, :4]
        R = rot.matrix(q)
        J[-6:-3, -6:-3] = np.eye(3)
        J[-6:-3, -10:-6] = -rotated_by_q(q, equations.body_moment)
        r[-6:-3] = equations.tip_moment + R @ equations.body_moment - y[-1, 4:]
        J[-3:, -3:] = np.eye(3)
        J[-3:, -10:-6] = -rotated_by_q(q, equations.body_force)
        r[-3:] = equations.tip_force + R @ equations.body_force - n_tip
        try:
            delta = np.linalg.solve(J, r)
        except np.linalg.LinAlgError:
            return state, np.inf
        dy, dn = delta[:-3].reshape(N + 1, 7), delta[-3:]
        stage = dY[..., 0] + np.einsum("nkab,nb->nka", dY[..., 1:8], dy[:-1]) + dY[..., 8:] @ dn
        # Moments and forces relative to their own size, so that heavy loads converge to the same digits.
        scale_m = 1 + np.abs(y[:, 4:]).max()
        scale_n = 1 + np.abs(n_tip).max()
        largest = max(np.abs(dy[:, :4]).max(), np.abs(dy[:, 4:]).max() / scale_m, np.abs(dn).max() / scale_n)
        return State(_normalised(y + dy), _normalised(Y + stage), n_tip + dn), float(largest)

    def evaluate(self, state: State, equations: RodEquations, x: Array) -> Values:
        """Values at x (n,) in [0, 1]: one Gauss step from the node on the left, so of full order."""
        *_, dr = equations.slope(state.Y, self._force(state.n_tip, equations, self.stations))
        increments = self.h * np.einsum("k,nka->na", b, dr)
        node_position = np.concatenate([np.zeros((1, 3)), np.cumsum(increments, axis=0)])
        i = np.minimum((x * self.elements).astype(int), self.elements - 1)
        h = x - self.nodes[i]
        left = state.y[i]
        Y = self._stages(left, h, x - h, state.n_tip, equations)
        n = self._force(state.n_tip, equations, (x - h)[:, None] + h[:, None] * c)
        f, _, _, dr = equations.slope(Y, n)
        y = _normalised(left + h[:, None] * np.einsum("k,nka->na", b, f))
        position = node_position[i] + h[:, None] * np.einsum("k,nka->na", b, dr)
        return Values(position, rot.matrix(y[:, :4]), self._force(state.n_tip, equations, x), y[:, 4:])

    def _stages(self, left: Array, h: Array, x: Array, n_tip: Array, equations: RodEquations) -> Array:
        """Stage values (n, K, 7) of steps of length h (n,) from x (n,), by Newton on each step alone."""
        K, count = STAGES, len(h)
        n = self._force(n_tip, equations, x[:, None] + h[:, None] * c)
        Y = np.repeat(left[:, None, :], K, axis=1)
        for _ in range(MOST_ITERATIONS):
            f, df_dy, _, _ = equations.slope(Y, n)
            G = Y - left[:, None] - h[:, None, None] * np.einsum("jk,nka->nja", A, f)
            matrix = -h[:, None, None] * np.einsum("jk,nkab->njakb", A, df_dy).reshape(count, 7 * K, 7 * K)
            matrix[:, np.arange(7 * K), np.arange(7 * K)] += 1.0
            step = np.linalg.solve(matrix, -G.reshape(count, 7 * K, 1)).reshape(count, K, 7)
            Y = Y + step
            if np.abs(step).max() < 1e-12 * (1 + np.abs(Y).max()):
                break
        return Y

    def transfer(self, coarse: Collocation, state: State, equations: RodEquations) -> State:
        """State of the coarser mesh at the nodes and stages of this one."""

        def at(x: Array) -> Array:
            i = np.minimum((x * coarse.elements).astype(int), coarse.elements - 1)
            h = x - coarse.nodes[i]
            Y = coarse._stages(state.y[i], h, x - h, state.n_tip, equations)
            n = coarse._force(state.n_tip, equations, (x - h)[:, None] + h[:, None] * c)
            f = equations.slope(Y, n)[0]
            return _normalised(state.y[i] + h[:, None] * np.einsum("k,nka->na", b, f))

        return State(at(self.nodes), at(self.stations.ravel()).reshape(*self.stations.shape, 7), state.n_tip)
