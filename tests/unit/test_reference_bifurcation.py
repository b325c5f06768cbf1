"""Critical loads: sideways buckling against a second rod solver, published values and thin limits; closed
forms against the perturbation equations.
"""

from math import inf, pi, sqrt

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import block_diag, expm

from reference import rotation as rot
from reference.bifurcation import hinged_frame, lateral_buckling, right_angle_frame
from reference.buckling import euler_load, lateral_buckling_load
from reference.critical_loads import beck_flutter, column_load, hinged_frame_moment, ring_twist, shaft_torque
from reference.perturbation import Leg, LegState, cantilever, perturbation_matrix, transfer
from reference.published import published
from reference.rod import RodLoads, RodProperties, solve_rod

E1, E2, E3 = np.eye(3)
RIGID = np.zeros(3)


def strip(length=240.0, width=30.0, thickness=0.6, E=71240.0, nu=0.31):
    """Argyris' strip, strong in the plane x-y, torsion constant of a thin section."""
    A, G = width * thickness, E / (2 * (1 + nu))
    GJ = G * width * thickness**3 / 3
    return RodProperties(
        length, E * A, G * A, G * A, GJ, E * width * thickness**3 / 12, E * thickness * width**3 / 12
    )


def slender(ratio, GJ=1.2):
    """No extension, no shear; EI_y/EI_z = ratio, EI_y = 1, length 1."""
    return RodProperties(1.0, 1e9, 1e9, 1e9, GJ, 1.0, 1 / ratio)


# ---- perturbation equations --------------------------------------------------------------------------------


def test_transfer_is_the_derivative_of_the_end_by_the_start():
    """Two joined legs in space: central differences, whose error falls by four with half the step."""
    rng = np.random.default_rng(1)
    leg = Leg(1.0, np.array([1e-3, 3e-3, 2e-3]), np.array([0.8, 1.0, 0.3]), rot.exp([0.3, 0.2, 1.0]))
    start = LegState(np.zeros(3), rot.exp(rng.normal(size=3)), 2 * rng.normal(size=3), rng.normal(size=3))
    T, d = transfer([leg, leg], start)[1], rng.normal(size=12)

    def end(h):
        return transfer(
            [leg, leg],
            LegState(
                h * d[:3],
                rot.exp(h * d[3:6]) @ start.frame,
                start.force + h * d[6:9],
                start.moment + h * d[9:],
            ),
        )[0]

    def error(h):
        a, b = end(h), end(-h)
        turn = rot.log(a.frame @ b.frame.T)
        change = [a.position - b.position, turn, a.force - b.force, a.moment - b.moment]
        return np.abs(np.concatenate(change) / (2 * h) - T @ d).max()

    assert error(1e-2) < 2e-3
    assert error(1e-2) / error(5e-3) == pytest.approx(4, rel=0.01)


def test_cantilever_agrees_with_the_collocation_solver(monkeypatch):
    force = np.array([0.1, 2.0, -1.0])
    leg = Leg(1.0, np.array([1e-3, 3e-3, 2e-3]), np.array([0.8, 1.0, 0.3]), np.eye(3))
    rod = RodProperties(1.0, 1e3, 1 / 3e-3, 1 / 2e-3, 1 / 0.8, 1.0, 1 / 0.3)
    _, end, _ = cantilever([leg], force)
    assert end.position == pytest.approx(solve_rod(rod, RodLoads(tip_force=force)).position[0], abs=1e-11)
    monkeypatch.setattr("reference.perturbation.MOST_ITERATIONS", 2)
    with pytest.raises(ArithmeticError, match="no equilibrium"):
        cantilever([leg], 5 * force)


# ---- sideways buckling -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "rod", [slender(0.05), slender(0.2), RodProperties(1.0, 300.0, 90.0, 70.0, 1.2, 1.0, 20.0)]
)
def test_lateral_buckling_is_where_the_disturbed_rod_runs_away(rod):
    """A tip force of 1e-7 sideways: 1/deflection, from the collocation solver, is analytic in the load and
    vanishes at the critical one (cubic extrapolation from 5 % to 1 % below).
    """
    critical = lateral_buckling(rod)
    parts = np.array([0.95, 0.97, 0.98, 0.99])
    tips = [solve_rod(rod, RodLoads(tip_force=(0, p * critical.value, 1e-7)), tolerance=1e-10) for p in parts]
    inverse = np.array([1e-7 / tip.displacement[0, 2] for tip in tips])
    # load as a cubic in 1/deflection, at zero
    found = np.polynomial.polynomial.polyfit(inverse / inverse[0], parts, 3)[0]
    assert found == pytest.approx(1, abs=2e-6)
    assert critical.error < 1e-8 * critical.value


def test_lateral_buckling_of_a_thin_strip():
    """Limit 4.0126 sqrt(EI GJ)/L^2, first order in the stiffness ratio; the published correction
    1/sqrt((1 - EI_y/EI_z)(1 - GJ/EI_z)) (Reissner 1979; exact for pure bending) has that order and sign.
    """
    ratios = np.array([1e-3, 5e-4])
    classical = lateral_buckling_load(1.0, 1.2, 1.0)
    rise = np.array([lateral_buckling(slender(r)).value / classical - 1 for r in ratios])
    assert rise[0] / rise[1] == pytest.approx(2, rel=2e-3)
    published_rise = 1 / np.sqrt((1 - ratios) * (1 - 1.2 * ratios)) - 1
    assert 1.0 < rise[0] / published_rise[0] < 1.25
    scaled = RodProperties(3.0, 1e9, 1e9, 1e9, 2.4, 2.0, 40.0)
    assert lateral_buckling(scaled).value == pytest.approx(
        lateral_buckling(slender(0.05)).value * 2 / 9, rel=1e-7
    )


def test_stiff_sections_do_not_buckle_sideways():
    with pytest.raises(ValueError, match="must be below EI_z"):
        lateral_buckling(slender(1.0))
    with pytest.raises(ValueError, match="straight"):
        lateral_buckling(RodProperties(1.0, 1e9, 1e9, 1e9, 1.0, 1.0, 9.0, curvature=(0, 0, 0.1)))


def test_right_angle_frame():
    """Argyris et al. 1979, Simo and Vu-Quoc 1986: 1.088 pulling the first leg. Pushing compresses that leg
    and must be weaker; no published value is known here.
    """
    pull, push = (right_angle_frame(strip(), sign) for sign in (1, -1))
    row = published("right-angle frame")
    assert pull.value == pytest.approx(row.values[0], abs=1.1 * row.rounding)
    assert push.value < pull.value
    assert max(pull.error / pull.value, push.error / push.value) < 1e-8


@pytest.mark.parametrize("sign", [1, -1])
def test_right_angle_frame_without_bending_in_the_plane(sign):
    """The thin limit from scalar equations on the unbent legs: moment m about z, -P L on the first leg and
    -P (L - s) on the second; w' = K (mu + m x w), mu_y' = -P u_z', u_z' = -w_y and w_x on the two legs. The
    load is critical where (mu_x, mu_y) vanish at the tip.
    """
    EI, GJ, L = 1.0, 1.5, 1.0

    def tip_moments(P):
        out = []
        for start in ((1.0, 0.0), (0.0, 1.0)):
            # y = (w_x, w_y, mu_x, mu_y)
            def first(s, y):
                m = -P * L
                wx, wy = (y[2] - m * y[1]) / GJ, (y[3] + m * y[0]) / EI
                return [wx, wy, 0.0, P * y[1]]

            def second(s, y):
                m = -P * (L - s)
                wx, wy = (y[2] - m * y[1]) / EI, (y[3] + m * y[0]) / GJ
                return [wx, wy, 0.0, -P * y[0]]

            y = np.array([0.0, 0.0, *start])
            for slope in (first, second):
                y = solve_ivp(slope, (0, L), y, "DOP853", rtol=1e-11, atol=1e-13).y[:, -1]
            out.append(y[2:])
        return np.linalg.det(np.array(out))

    found = right_angle_frame(slender(1e-6, GJ), sign).value
    assert abs(tip_moments(sign * found)) < 1e-4 * max(abs(tip_moments(sign * p * found)) for p in (0.5, 0.9))
    assert tip_moments(sign * found * (1 - 1e-4)) * tip_moments(sign * found * (1 + 1e-4)) < 0
    assert min(tip_moments(sign * p * found) for p in np.linspace(0.02, 0.98, 25)) > 0


@pytest.mark.parametrize("sign", [1, -1])
def test_hinged_frame(sign):
    """Argyris et al. 1979: +-622.2; the closed form is the limit of no bending in the plane."""
    rod = strip()
    closed = hinged_frame_moment(rod.EI_y, rod.GJ, rod.length)
    assert closed == pytest.approx(622.2, abs=0.05)
    found = hinged_frame(rod, sign)
    assert found.value == pytest.approx(closed, rel=1e-4)
    assert found.error < 1e-8 * found.value
    off = [hinged_frame(slender(r), sign).value / hinged_frame_moment(1, 1.2, 1) - 1 for r in (1e-3, 5e-4)]
    assert off[0] / off[1] == pytest.approx(2, rel=0.05)


# ---- closed forms ------------------------------------------------------------------------------------------


def straight_transfer(n, m, compliance_n, compliance_m, length=1.0):
    """Transfer matrix of a straight rod along x, by the exponential of the perturbation equations."""
    state = LegState(np.zeros(3), np.eye(3), n * E1, m * E1)
    return expm(length * perturbation_matrix(state, compliance_n, compliance_m))


U_Y, U_Z, W_Y, W_Z, NU_Y, NU_Z, MU_Y, MU_Z = 1, 2, 4, 5, 7, 8, 10, 11
END_ROWS = {  # (known zero at the start, known zero at the end), bending in the plane x-y
    "clamped-free": ([U_Y, W_Z], [NU_Y, MU_Z]),
    "pinned-pinned": ([U_Y, MU_Z], [U_Y, MU_Z]),
    "clamped-clamped": ([U_Y, W_Z], [U_Y, W_Z]),
    "clamped-guided": ([U_Y, W_Z], [NU_Y, W_Z]),
}


@pytest.mark.parametrize("ends", END_ROWS)
@pytest.mark.parametrize("EA, GA", [(900.0, 350.0), (400.0, inf), (inf, 60.0)])
def test_column_with_compression_and_shear(ends, EA, GA):
    """The boundary rows of the perturbed rod are singular at the load and at none below it."""
    start, end = END_ROWS[ends]
    free = [i for i in (U_Y, W_Z, NU_Y, MU_Z) if i not in start]
    P = column_load(2.0, EA, GA, 1.0, ends)

    def determinant(p):
        T = straight_transfer(-p, 0.0, np.array([1 / EA, 1 / GA, 1 / GA]), np.array([1.0, 0.5, 0.5]))
        return float(np.linalg.det(T[np.ix_(end, free)]))

    below = [determinant(p * P) for p in np.linspace(0.02, 0.98, 49)]
    assert abs(determinant(P)) < 1e-9 * max(map(abs, below))
    assert min(map(abs, below)) > 1e-6 * max(map(abs, below))
    assert euler_load(2.0, 1.0, ends) == column_load(2.0, inf, inf, 1.0, ends)


def test_column_limits():
    """Engesser and Haringx agree to first order: P_E (1 - P_E/GA); compression raises the load."""
    P_E = euler_load(1.0, 1.0)
    for GA in (1e4, 2e4):
        assert (column_load(1.0, inf, GA, 1.0) / P_E - 1) * GA == pytest.approx(-P_E, rel=1e-3)
    assert column_load(1.0, 100.0, inf, 1.0) > P_E
    with pytest.raises(ValueError, match="exceeds 1"):
        column_load(1.0, 3 * P_E, inf, 1.0)
    with pytest.raises(ValueError, match="clamped-free"):
        column_load(1.0, 1e3, 1e3, 1.0, "clamped-pinned")


@pytest.mark.parametrize(
    "ends, rows, free",
    [
        ("pinned-pinned", (U_Y, U_Z, MU_Y, MU_Z), (W_Y, W_Z, NU_Y, NU_Z)),
        ("clamped-clamped", (U_Y, U_Z, W_Y, W_Z), (NU_Y, NU_Z, MU_Y, MU_Z)),
    ],
)
def test_twisted_shaft(ends, rows, free):
    """Rank drops by two (equal stiffnesses) at Greenhill's torque, and at none below it."""
    M = shaft_torque(2.0, 1.0, ends)

    def smallest(m):
        T = straight_transfer(0.0, m, RIGID, np.array([1.0, 0.5, 0.5]))
        return np.linalg.svd(T[np.ix_(rows, free)])[1][-2:]

    assert smallest(M).max() < 1e-12
    assert min(smallest(p * M)[-1] for p in np.linspace(0.05, 0.95, 19)) > 1e-4
    with pytest.raises(ValueError, match="pinned-pinned"):
        shaft_torque(1.0, 1.0, "free-free")


def ring_determinant(moment, mode, EI=1.3, GJ=0.7, radius=2.0):
    """Smallest singular value of the perturbation equations for e^{i mode s/R} in the moving trihedron."""
    state = LegState(np.zeros(3), np.eye(3), moment / radius * E3, moment * E1 + EI / radius * E3)
    # tangent d1, d2 to the centre, d3 = b: their rate of turn is b/R
    turning = block_diag(*[rot.hat(E3 / radius)] * 4)
    A = perturbation_matrix(state, RIGID, np.array([1 / GJ, 1 / EI, 1 / EI])) - turning
    return np.linalg.svd(A - 1j * mode / radius * np.eye(12))[1][-1]


def test_michells_ring():
    """Mode k at sqrt(k^2 - 1) EI/R, mode 2 first; no other mode from 2 on below it."""
    ring = ring_twist(1.3, 0.7, 2.0)
    assert ring_determinant(ring.moment, 2) < 1e-13
    assert ring_determinant(sqrt(8) * 1.3 / 2, 3) < 1e-13
    for mode in (2, 3, 4):
        assert min(ring_determinant(p * ring.moment, mode) for p in np.linspace(0, 0.95, 20)) > 1e-3
    assert ring.angle == pytest.approx(2 * pi * sqrt(3) * 1.3 / 0.7, rel=1e-14)


def test_beck():
    """Beck 1952: 20.05, later digits 20.0509; two exact frequencies of the beam meet there, by expm."""
    flutter = beck_flutter()
    assert flutter.load == pytest.approx(20.05, abs=5e-3)

    def tip(p, w):
        # y'''' + p y'' - w^2 y = 0, y(0) = y'(0) = 0: moment and shear at the tip
        A = np.array([[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [w * w, 0, -p, 0.0]])
        return float(np.linalg.det(expm(A)[2:, 2:]))

    p, w = flutter.load, flutter.frequency
    assert tip(p * (1 - 1e-4), w) < 0 < tip(p * (1 + 1e-4), w)
    around = [tip(p, x) for x in np.linspace(3, 18, 151)]
    assert min(around) > -1e-6 * max(around)


def test_beck_has_no_static_critical_load():
    """Follower force at the tip, nu = w x n there: the rows never become singular, shear and all."""
    signs = set()
    for P in np.linspace(0.0, 60.0, 121):
        T = straight_transfer(-P, 0.0, np.array([1e-3, 2e-3, 2e-3]), np.ones(3))
        follower = T[NU_Y] + P * T[W_Z]  # (w x n)_y = -P w_z for n = -P e_1
        rows = np.array([follower, T[MU_Z]])[:, [NU_Y, MU_Z]]
        signs.add(np.sign(np.linalg.det(rows)))
    assert signs == {1.0}
