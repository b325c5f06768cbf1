"""Arch: against a boundary-value solver, the shallow limit in closed form, and published critical loads."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from scipy.integrate import solve_bvp
from scipy.optimize import brentq, minimize_scalar

from reference.arch import Arch, ArchEquations, chebyshev
from reference.arch_path import ArchPath, PathLost, critical_points, default_stop

SHALLOW = Arch.circle(1.0, 0.004, 0.6, 1e9, 0.3)
SNAP_BACK = replace(Arch.circle(1.0, 0.004, 2.0, 1e9, 0.3), ends=("clamped", "pinned"))
OFF_MIDDLE = replace(Arch.circle(1.0, 0.005, 1.0, 1e9, 0.3), load_at=0.4, direction="radial")


@cache
def path(arch):
    return ArchPath(arch, 36, default_stop(arch))


def test_chebyshev_differentiates_and_integrates():
    D, x, weights = chebyshev(20)
    assert D @ np.exp(x) == pytest.approx(np.exp(x), abs=1e-11)
    assert weights @ np.exp(x) == pytest.approx(np.e - 1, abs=1e-14)


@pytest.mark.parametrize("arch", [SHALLOW, SNAP_BACK, OFF_MIDDLE])
def test_jacobian_is_the_derivative(arch):
    """Second-order differences: the error falls by four with half the step."""
    equations = ArchEquations(arch, 8)
    rng = np.random.default_rng(0)
    z = equations.unstressed()
    z, dz = z + 0.3 * rng.normal(size=z.size), rng.normal(size=z.size)

    def errors(h):
        slope = (equations(z + h * dz)[0] - equations(z - h * dz)[0]) / (2 * h)
        move = (equations.displacement(z + h * dz) - equations.displacement(z - h * dz)) / (2 * h)
        return np.array(
            [
                np.abs(equations(z)[1] @ dz - slope).max(),
                abs(equations.displacement_gradient(z) @ dz - move),
            ]
        )

    assert errors(1e-2) / errors(5e-3) == pytest.approx([4, 4], rel=0.05)


def test_radial_is_towards_the_centre():
    """Loaded point R (sin, cos) of its angle from the crown, left of it at 40 % of the arc."""
    angle = OFF_MIDDLE.opening * (OFF_MIDDLE.load_at - 0.5)
    assert ArchEquations(OFF_MIDDLE, 8).d == pytest.approx([-np.sin(angle), -np.cos(angle)], abs=1e-15)
    assert pytest.approx([0, -1], abs=1e-15) == ArchEquations(SNAP_BACK, 8).d


def boundary_value_problem(arch, point):
    """Displacement of the loaded point by SciPy's solver for the first-order equations of both parts at once.

    theta' = kappa_0 + M/EI, M' = -(r' x n).z, r' = R gamma, n constant; parts mapped to [0, 1].
    """
    equations = ArchEquations(arch, 36)
    EI, L = arch.EI, arch.length
    left, right = arch.load_at * L, (1 - arch.load_at) * L
    radius = L / arch.opening
    chord = 2 * radius * np.sin(arch.opening / 2)
    drop = -point.load * equations.d

    def part(theta, M, n):
        c, s = np.cos(theta), np.sin(theta)
        g1, g2 = 1 + (c * n[0] + s * n[1]) / arch.EA, (c * n[1] - s * n[0]) / arch.GA
        x, y = c * g1 - s * g2, s * g1 + c * g2
        return np.array([-arch.opening / L + M / EI, -(x * n[1] - y * n[0]), x, y])

    def slope(_, v, n):
        return np.concatenate([left * part(v[0], v[1], n), right * part(v[4], v[5], n + drop)])

    def ends(a, b, n):
        first = a[0] - arch.opening / 2
        last = b[4] + arch.opening / 2 if arch.ends[1] == "clamped" else b[5]
        return np.array([first, a[2], a[3], *(b[:4] - a[4:]), last, b[6] - chord, b[7]])

    m = equations.N + 1
    x = equations.x
    D = equations.D
    theta = point.z[: 2 * m].reshape(2, m)
    n = point.z[2 * m : 2 * m + 2] * EI / L**2
    guess, start = np.zeros((8, m)), np.zeros(2)
    for k, (length, force) in enumerate(((left, n), (right, n + drop))):
        M = EI * (D[k] @ theta[k] / L + arch.opening / L)
        r = part(theta[k], M, force)[2:] * length
        _, _, weights = chebyshev(m - 1)
        antiderivative = np.linalg.lstsq(D[k] * equations.lengths[k], r.T, rcond=None)[0].T
        antiderivative -= antiderivative[:, :1]
        assert np.allclose(antiderivative[:, -1], r @ weights)
        guess[4 * k : 4 * k + 4] = [theta[k], M, *(start[:, None] + antiderivative)]
        start = guess[4 * k + 2 : 4 * k + 4, -1]
    guess *= 1 + 1e-3 * np.sin(7 * x)  # off the answer that it is to confirm
    result = solve_bvp(slope, ends, x, guess, p=n * (1 + 1e-3), tol=1e-10, max_nodes=20000)
    assert result.success
    half = arch.opening / 2
    at = np.array(
        [
            radius * (np.sin(half) - np.sin(half - arch.opening * arch.load_at)),
            radius * (np.cos(half - arch.opening * arch.load_at) - np.cos(half)),
        ]
    )
    return float((result.y[2:4, -1] - at) @ equations.d)


@pytest.mark.parametrize("arch", [SHALLOW, SNAP_BACK, OFF_MIDDLE])
@pytest.mark.parametrize("part", [0.2, 0.45, 0.7, 0.9])
def test_states_solve_the_first_order_equations(arch, part):
    """On the rising, the falling and the last branch, away from limit points, where a load has one state."""
    points = path(arch).points
    point = points[int(part * len(points))]
    assert boundary_value_problem(arch, point) == pytest.approx(point.displacement, rel=1e-8)


def shallow_limit_loads(slenderness):
    """Largest load, both crossings and smallest load of a clamped shallow arch, P L^2/EI over the opening.

    slenderness = EA L^2/EI times opening^2.

    EI w'''' + H (w'' + kappa_0) = P delta, H/EA = int (kappa_0 w - w'^2/2)/L; in the half right of the load
    w = A cos mx + B sin mx + C x + D - x^2/2 (unit kappa_0), H = m^2: linear in P for given m, and the second
    equation is quadratic in P. Timoshenko and Gere, ch. 7; Schreyer and Masur 1966.
    """
    x, weight = np.polynomial.legendre.leggauss(40)
    x, weight = (x + 1) / 4, weight / 2  # both halves

    def parts(m, P, own):
        B, C = -P / (2 * m**3), P / (2 * m**2)
        slope = C + B * m * np.cos(m / 2) - own / 2
        A = slope / (m * np.sin(m / 2))
        D = -(A * np.cos(m / 2) + B * np.sin(m / 2) + C / 2 - own / 8)
        w = A * np.cos(m * x) + B * np.sin(m * x) + C * x + D - own * x**2 / 2
        return w, -A * m * np.sin(m * x) + B * m * np.cos(m * x) + C - own * x

    def load(m, sign):
        (w0, s0), (w1, s1) = parts(m, 0.0, 1.0), parts(m, 1.0, 0.0)
        a, b = -weight @ s1**2 / 2, weight @ (w1 - s0 * s1)
        c = weight @ (w0 - s0**2 / 2) - m**2 / slenderness
        square = b * b - 4 * a * c
        return (-b + sign * np.sqrt(square)) / (2 * a) if square >= 0 else np.nan

    found = []
    for sign in (1, -1):
        grid = np.linspace(0.05, 4 * np.pi - 0.05, 4000)
        values = np.array([load(m, sign) for m in grid])
        for direction in (1, -1):
            inner = direction * values
            for i in range(1, len(grid) - 1):
                if inner[i] > inner[i - 1] and inner[i] > inner[i + 1]:
                    best = minimize_scalar(
                        lambda m, s=sign, d=direction: -d * load(m, s),
                        bounds=(grid[i - 1], grid[i + 1]),
                        method="bounded",
                    )
                    found.append(load(best.x, sign))
    half = brentq(lambda v: np.tan(v) - v, 4.4, 4.6)
    return max(found), load(2 * half, 1), load(2 * half, -1), min(found)


def test_shallow_limit():
    """Errors fall with the square of the opening at one slenderness (that of 0.6 rad, L/R = 250).

    The unsymmetric mode of the shallow arch is that of the clamped column: tan(m/2) = m/2.
    """
    slenderness = 4 * 250**2 * 0.6**2
    exact = np.array(shallow_limit_loads(slenderness))
    errors = []
    for opening in (0.2, 0.1):
        EA = slenderness / opening**2
        points = critical_points(Arch(1.0, opening, 1.0, EA, 1e9))
        assert [p.kind for p in points[1:3]] == ["bifurcation"] * 2
        errors.append(np.array([p.load / opening for p in points]) / np.sort(exact)[::-1] - 1)
    assert np.abs(errors[1]).max() < 1e-3
    assert errors[0] / errors[1] == pytest.approx([4] * 4, rel=0.05)


def test_published_deep_arches():
    """Inextensible: clamped-pinned, 215 degrees, P R^2/EI = 8.97 (DaDeppo and Schmidt 1975, J. Appl. Mech.
    42:896); pinned semicircle, sidesway at 5.86 (Langhaar, Boresi, Carver 1954; DaDeppo and Schmidt 1969).
    """
    deep = Arch(1.0, np.radians(215), 1.0, 1e8, 1e8, ends=("clamped", "pinned"))
    first = critical_points(deep)[0]
    assert first.kind == "load maximum"
    assert first.load / deep.opening**2 == pytest.approx(8.97, abs=5e-3)
    semicircle = Arch(1.0, np.pi, 1.0, 1e8, 1e8, ends=("pinned", "pinned"))
    first = critical_points(semicircle, stop=lambda P, w: w > 0.1)[0]
    assert first.kind == "bifurcation"
    assert first.load / semicircle.opening**2 == pytest.approx(5.86, abs=1e-2)


@pytest.mark.parametrize(
    "opening, radius", [(0.3, 0.004), (0.6, 0.004), (1.0, 0.004), (0.6, 0.01), (1, 0.01)]
)
def test_shallow_clamped_arches_snap_through(opening, radius):
    """One maximum and one minimum, to 1e-9; between them a displacement has one load."""
    arch = Arch.circle(1.0, radius, opening, 1e9, 0.3)
    points = critical_points(arch)
    limits = [p for p in points if p.kind != "bifurcation"]
    assert [p.kind for p in limits] == ["load maximum", "load minimum"]
    assert max(p.error for p in points) < 1e-9
    high, low = limits
    assert low.load < high.load and low.displacement > high.displacement
    (load,) = path(arch).loads((low.displacement + high.displacement) / 2)
    assert low.load < load < high.load


def test_snap_back():
    """Clamped-pinned, 2 rad, L/R = 250: loaded point turns back twice; three states at some displacements."""
    points = critical_points(SNAP_BACK)
    kinds = ["load maximum", "displacement maximum", "load minimum"]
    assert [p.kind for p in points] == [*kinds, "load maximum", "displacement minimum", "load minimum"]
    assert max(p.error for p in points) < 1e-8
    top, bottom = points[1], points[4]
    assert len(path(SNAP_BACK).loads((top.displacement + bottom.displacement) / 2)) == 3
    assert len(path(SNAP_BACK).loads(bottom.displacement - 1e-3)) == 1


def test_symmetric_and_general_solution_agree():
    """A force a little off the middle follows the general equations; the limit load is even in its offset
    only to second order where no path crosses before it.
    """
    arch = Arch.circle(1.0, 0.01, 0.6, 1e9, 0.3)
    even = critical_points(arch)[0].load
    change = [critical_points(replace(arch, load_at=0.5 + d))[0].load / even - 1 for d in (2e-3, -2e-3, 1e-3)]
    assert change[0] == pytest.approx(change[1], rel=1e-5)
    assert change[0] / change[2] == pytest.approx(4, rel=0.02)


def test_a_lost_path_says_where(monkeypatch):
    monkeypatch.setattr("reference.arch_path.MOST_POINTS", 60)
    never = Arch(1.0, np.pi, 1.0, 1e4, 1e4, ends=("pinned", "pinned"))
    with pytest.raises(PathLost, match="after 61 points"):
        ArchPath(never, 8, lambda P, w: False)
