"""What the tests of the solid reference share: difference checks, a small rod, exact bending of a section.

"Reference study" marks numbers derived in this project with independent code before this module was written.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from scipy.optimize import root

from reference.solid_assembly import SolidAssembly
from reference.solid_materials import MooneyRivlin, NeoHookean, SaintVenantKirchhoff
from reference.solid_mesh import circular_section, rod_mesh

LENGTH, RADIUS, YOUNG, NU = 0.4, 0.01, 1e6, 0.3  # the rod of the reference study
RUBBER = SaintVenantKirchhoff(YOUNG, NU)
LAWS = [RUBBER, NeoHookean(YOUNG, 0.45), MooneyRivlin(0.1 * YOUNG, 0.06 * YOUNG, 2 * YOUNG)]
SECOND_MOMENT = np.pi * RADIUS**4 / 4


def assert_second_order(function, derivative, direction, step, point):
    """Central differences approach the derivative with an error that falls by four when the step halves."""
    errors = []
    for h in (step, step / 2):
        difference = (function(point + h * direction) - function(point - h * direction)) / (2 * h)
        errors.append(np.linalg.norm(difference - derivative) / np.linalg.norm(derivative))
    assert errors[0] < 1e-2
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2, abs=0.1)


def rotation(seed):
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.linalg.det(q)


@cache
def small_rod():
    mesh = rod_mesh(circular_section(0.1, core=1), 0.3, slices=2)
    return mesh, SolidAssembly(mesh, np.zeros(mesh.nodes.shape, bool))


def random_displacement(mesh, seed=5, size=4e-3):
    return size * np.random.default_rng(seed).normal(size=mesh.nodes.shape)


def bending_moment(theta):
    """Couple that bends the thin rod of the reference study by theta, E I theta/L [N m]."""
    return theta * YOUNG * SECOND_MOMENT / LENGTH


@dataclass
class ExactSection:
    """Uniform bending of a disc of radius 1, E = 1: `curvature`, mean position `offset` of the section."""

    curvature: float
    offset: float


@cache
def exact_section(thin_curvature: float, law, degree: int = 5) -> ExactSection:
    """Exact finite-strain bending under the couple I kappa_0: theory of a uniformly bent rod, no mesh.

    x(s, Y) = Rot(kappa s) w(Y) gives F_xx = -kappa w_y beside the section gradient of w. w is polynomial, the
    section energy is stationary in it, the couple is -int w_y P_xx dA. Degree 7 changes 1e-8. E = 1.
    """
    r, w_r = np.polynomial.legendre.leggauss(8)
    angle = 2 * np.pi * np.arange(16) / 16
    radius, weight = (r + 1) / 2, (r + 1) / 4 * w_r * 2 * np.pi / 16
    y, z = np.outer(radius, np.cos(angle)).ravel(), np.outer(radius, np.sin(angle)).ravel()
    weight = np.repeat(weight, 16)
    powers = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    terms = {
        parity: np.array(
            [
                [y**i * z**j, i * y ** max(i - 1, 0) * z**j, j * y**i * z ** max(j - 1, 0)]
                for i, j in powers
                if j % 2 == parity
            ]
        )
        for parity in (0, 1)
    }
    even, odd = terms[0], terms[1]

    def residual(unknown):
        kappa, v, w = unknown[0], *np.split(unknown[1:], [len(even)])
        v, v_y, v_z = np.tensordot(v, even, 1)
        _, w_y, w_z = np.tensordot(w, odd, 1)
        F = np.zeros((len(y), 3, 3))
        F[:, 0, 0] = 1 - kappa * (y + v)
        F[:, 1, 1], F[:, 1, 2], F[:, 2, 1], F[:, 2, 2] = 1 + v_y, v_z, w_y, 1 + w_z
        P = weight[:, None, None] * law.stress(F)
        couple = -P[:, 0, 0] @ (y + v) - np.pi / 4 * thin_curvature
        in_v = -kappa * even[:, 0] @ P[:, 0, 0] + even[:, 1] @ P[:, 1, 1] + even[:, 2] @ P[:, 1, 2]
        return np.concatenate([[couple], in_v, odd[:, 1] @ P[:, 2, 1] + odd[:, 2] @ P[:, 2, 2]])

    start = np.concatenate([[thin_curvature], np.zeros(len(even) + len(odd))])
    solution = root(residual, start, tol=1e-13).x
    offset = weight @ np.tensordot(solution[1 : 1 + len(even)], even[:, 0], 1) / np.pi
    return ExactSection(float(solution[0]), float(offset))
