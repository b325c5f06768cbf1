"""The closed form of the thin arm (helix.py) as ONNX nodes: same symbols, both quaternions side by side.

Newton takes a fixed number of steps to the first root of each quaternion, so the graph holds where that is
the right one: |v| below some 4 rad. Values are (n, 1), or (n, 2) for the two quaternions.
"""

from __future__ import annotations

import math

import numpy as np

from surrogate.arm import Arm
from surrogate.helix import LENGTH_COST
from surrogate.onnx_nodes import Graph, Value, arctan2, joined

STEPS = 8
STRAIGHT2 = 1e-18  # square of the sine below which an angle and its sine are equal
SLOWEST = 1e-3  # least slope of Newton: a quaternion that is not meant may have none


def body_columns(graph: Graph, pose: Value, arm: Arm) -> list[Value]:
    """The twelve numbers (n, 1) of `Arm.body_poses`, row by row."""
    base = np.zeros((3, 4))
    base[:, 0] = arm.rod.base.position
    scale = np.array([1.0 / arm.length, 1.0, 1.0, 1.0])
    flat = (scale * (arm.rod.base.rotation.T @ (pose - base))).shaped(-1, 12)
    return [flat.taken([k]) for k in range(12)]


def helix_inverse(columns: list[Value], nu: float) -> tuple[list[Value], list[Value]]:
    """v and the unwrapped logarithm, three (n, 1) each, of the numbers of `body_columns`."""
    r, d_y, d_z = (columns[k::4] for k in (0, 2, 3))
    signs = columns[0].graph.constant(np.array([[1.0, -1.0]]))
    w, x, y, z = (signs * part for part in _quaternion(*_section_axes(d_y, d_z)))
    rho, alpha, p2 = (w * w + x * x).apply("Sqrt"), arctan2(x, w), y * y + z * z
    a = alpha / (1.0 + nu)
    for _ in range(STEPS):
        c, s = rho * a.apply("Cos"), rho * a.apply("Sin")
        sine2 = (s * s + p2).at_least(STRAIGHT2)
        sine = sine2.apply("Sqrt")
        theta = arctan2(sine, c)
        rate = (s * s + theta * c * p2 / sine) / sine2 * nu + 1.0
        gap = a + nu * (theta * s / sine) - alpha
        a = (a - gap / rate.at_least(SLOWEST)).at_least(-math.pi).at_most(math.pi)
    turn = alpha - a
    cosine, sine = turn.apply("Cos"), turn.apply("Sin")
    along = rho * a.apply("Sin")
    factor = _angle_by_sine(along * along + p2, rho * a.apply("Cos"))
    v = [factor * along, factor * (y * cosine - z * sine), factor * (z * cosine + y * sine)]
    factor = _angle_by_sine(x * x + p2, w)
    log = [factor * part for part in (x, y, z)]
    cost = _distance2(v, r).apply("Sqrt") + LENGTH_COST * _dot(v, v).apply("Sqrt")
    second = cost.taken([1]).less_than(cost.taken([0]))
    v, log = ([second.where(part.taken([1]), part.taken([0])) for part in parts] for parts in (v, log))
    return v, log


def to_moments(v: list[Value], arm: Arm) -> Value:
    """Moments (n, 3) [N m] of v, as `Arm.moments`."""
    x, y, z = v
    if arm.moment.direction != "fixed":
        angle = x * -arm.twist_ratio
        c, s = angle.apply("Cos"), angle.apply("Sin")
        y, z = y * c - z * s, z * c + y * s
    return joined([x, y, z]) @ (arm.to_body * arm.unit)


def _section_axes(d_y: list[Value], d_z: list[Value]) -> tuple[list[Value], list[Value], list[Value]]:
    yy, yz, zz = _dot(d_y, d_y), _dot(d_y, d_z), _dot(d_z, d_z)
    n = [d_y[(k + 1) % 3] * d_z[(k + 2) % 3] - d_y[(k + 2) % 3] * d_z[(k + 1) % 3] for k in range(3)]
    d = _dot(n, n).apply("Sqrt")
    scale = 1.0 / ((yy + zz + 2.0 * d).apply("Sqrt") * d)
    a, b, c = (zz + d) * scale, yz * scale, (yy + d) * scale
    return (
        [part / d for part in n],
        [a * i - b * j for i, j in zip(d_y, d_z, strict=True)],
        [c * j - b * i for i, j in zip(d_y, d_z, strict=True)],
    )


def _quaternion(a: list[Value], b: list[Value], c: list[Value]) -> list[Value]:
    """The quaternion by its largest component: of the four equivalent formulas, the one with that divisor."""
    axial = [b[2] - c[1], c[0] - a[2], a[1] - b[0]]
    sums = [b[0] + a[1], c[0] + a[2], c[1] + b[2]]  # xy, xz, yz
    signs = ((1.0, 1.0, 1.0), (1.0, -1.0, -1.0), (-1.0, 1.0, -1.0), (-1.0, -1.0, 1.0))
    squares = [1.0 + i * a[0] + j * b[1] + k * c[2] for i, j, k in signs]
    rows = [
        [squares[0], *axial],
        [axial[0], squares[1], sums[0], sums[1]],
        [axial[1], sums[0], squares[2], sums[2]],
        [axial[2], sums[1], sums[2], squares[3]],
    ]
    best, largest = rows[0], squares[0]
    for row, square in zip(rows[1:], squares[1:], strict=True):
        larger = largest.less_than(square)
        best = [larger.where(new, old) for new, old in zip(row, best, strict=True)]
        largest = larger.where(square, largest)
    size = _dot(best, best).apply("Sqrt")
    return [part / size for part in best]


def _angle_by_sine(sine2: Value, cosine: Value) -> Value:
    sine = sine2.at_least(STRAIGHT2).apply("Sqrt")
    return 2.0 * arctan2(sine, cosine) / sine


def _distance2(v: list[Value], r: list[Value]) -> Value:
    """|r(v) - r|^2, over the length."""
    x, y, z = v
    phi2 = (x * x + y * y + z * z).at_least(STRAIGHT2)
    phi = phi2.apply("Sqrt")
    a, b = phi.apply("Sin") / phi, (1.0 - phi.apply("Cos")) / phi2
    c = (1.0 - a) / phi2
    gap = [a + c * x * x - r[0], b * z + c * x * y - r[1], c * x * z - b * y - r[2]]
    return _dot(gap, gap)


def _dot(a: list[Value], b: list[Value]) -> Value:
    first, *rest = [i * j for i, j in zip(a, b, strict=True)]
    for term in rest:
        first = first + term
    return first
