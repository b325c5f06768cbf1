"""Bending, elastica, torsion, buckling, uniaxial: closed forms against integration and minimisation."""

from math import cos, cosh, pi, sin, sqrt

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

from reference.analytic import (
    BendingSection,
    elastica_tip_force,
    euler_load,
    full_hooke_locking_factor,
    lateral_buckling_load,
    pure_bending_curvature,
    pure_bending_moment,
    self_weight_load,
    torsion_constant_bilinear_section,
    torsion_constant_circle,
    torsion_constant_ellipse,
    torsion_constant_linear_section,
    torsion_constant_rectangle,
    twist_angle,
    uniaxial_neo_hookean,
    uniaxial_saint_venant_kirchhoff,
)

# ---- finite-strain pure bending ----------------------------------------------------------------------------


@pytest.mark.parametrize("model", ["rigid", "stretching"])
@pytest.mark.parametrize("shape", ["circle", "rectangle"])
def test_bending_minimises_the_energy(model, shape):
    """Energy by quadrature over the section and minimised over lambda (and a); moment by its derivative."""
    R = h = 1.0
    x, w = np.polynomial.legendre.leggauss(60)
    if shape == "circle":
        section = BendingSection.circle(R)
        angle = (x + 1) * pi / 2  # chords at y = R cos(angle): a smooth integrand
        y, weight = R * np.cos(angle), w * pi / 2 * 2 * (R * np.sin(angle)) ** 2
    else:
        section = BendingSection.rectangle(h, 0.7)
        y, weight = h / 2 * x, w * h / 2 * 0.7

    def energy(unknowns, kappa):
        stretch, a = unknowns[0], (unknowns[1] if model == "stretching" else 1.0)
        along = ((stretch - kappa * a * y) ** 2 - 1) / 2
        return float(weight @ (along**2 + ((a**2 - 1) / 2) ** 2)) / 2

    def least(kappa):
        start = np.ones(2 if model == "stretching" else 1)
        return minimize(lambda u: 1e3 * energy(u, kappa), start, method="BFGS", options={"gtol": 1e-9})

    kappa, d = 0.2, 1e-3
    state = pure_bending_moment(kappa, 1.0, section, model)
    found = least(kappa).x
    assert state.axial_stretch == pytest.approx(found[0], abs=1e-7)
    if model == "stretching":
        assert state.section_stretch == pytest.approx(found[1], abs=1e-7)
    slopes = [(least(kappa + k * d).fun - least(kappa - k * d).fun) / (2 * k * d) / 1e3 for k in (1, 2)]
    assert state.moment == pytest.approx((4 * slopes[0] - slopes[1]) / 3, rel=1e-7)


@pytest.mark.parametrize("theta, growth", [(pi / 4, 1.002131), (pi / 2, 1.008652), (pi, 1.036886)])
def test_bending_values_of_an_independent_derivation(theta, growth):
    """kappa L/theta at L/R = 20, nu = 0, worked out by others before this code existed (six digits)."""
    L, section = 20.0, BendingSection.circle(1.0)
    state = pure_bending_curvature(theta * section.second_moment / L, 1.0, section)
    assert state.curvature * L / theta == pytest.approx(growth, abs=6e-7)


def test_bending_limits_signs_and_inverse():
    section = BendingSection.circle(1.0)
    EI = section.second_moment
    for model, coefficient in (("stretching", 1.375), ("rigid", 0.875)):
        state = pure_bending_curvature(1e-3 * EI, 1.0, section, model)
        assert (state.curvature / 1e-3 - 1) / 1e-6 == pytest.approx(coefficient, rel=2e-5)
        assert pure_bending_curvature(-1e-3 * EI, 1.0, section, model).curvature == -state.curvature
        assert pure_bending_curvature(0.0, 1.0, section, model).curvature == 0.0
        strong = pure_bending_curvature(0.2 * EI, 1.0, section, model)
        assert pure_bending_moment(strong.curvature, 1.0, section, model).moment == pytest.approx(0.2 * EI)
        with pytest.raises(ValueError, match="exceeds the largest"):
            pure_bending_curvature(0.9 * EI, 1.0, section, model)
    box = pure_bending_moment(0.1, 1.0, BendingSection.rectangle(1.0, 1.0), "rigid")
    assert box.moment == pytest.approx(0.1 / 12 * (1 - 0.30 * 0.01), rel=1e-14)
    along, across, angle = box.tip(7.0)
    radius = box.axial_stretch / box.curvature
    assert (along, across) == pytest.approx((radius * sin(angle), radius * (1 - cos(angle))), rel=1e-14)


# ---- elastica ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("load", [1e-4, 0.2999, 0.3001, 1.0, 5.0, 10.0, 40.0])
def test_elastica_solves_its_equation(load):
    """theta'' = -P cos theta from the tip (theta' = 0) must reach theta = 0 at the clamp."""
    tip = elastica_tip_force(load)

    def slope(_, y):
        return [y[1], -load * np.cos(y[0]), np.cos(y[0]), np.sin(y[0])]

    end = solve_ivp(slope, (0, 1), [tip.angle, 0, 0, 0], "DOP853", rtol=1e-13, atol=1e-16).y[:, -1]
    assert abs(end[0]) < 1e-12 * cosh(sqrt(load))  # growth of an error in the tip angle
    assert 1 - end[2] == pytest.approx(tip.u, abs=1e-12)
    assert end[3] == pytest.approx(tip.w, abs=1e-12)


def test_elastica_values_of_an_independent_code():
    """Ten printed digits by others; their w is 2e-10, 5e-10, 1.0e-9 too large at loads 2, 5, 10."""
    rows = {
        1: (0.0564332363, 0.3017207739, 0.4613519497),
        2: (0.1606417208, 0.4934574806, 0.7817498316),
        5: (0.3876283607, 0.7137915241, 1.2153681176),
        10: (0.5549955978, 0.8106090259, 1.4302855388),
    }
    for load, row in rows.items():
        tip = elastica_tip_force(load)
        assert (tip.u, tip.angle) == pytest.approx((row[0], row[2]), abs=1e-10)
        assert tip.w == pytest.approx(row[1], abs=2e-9)


def test_elastica_limits():
    """Linear theory (P/3, P^2/15, P/2) below; w -> 1 - (2 - sqrt 2)/alpha, u -> 1 - sqrt 2/alpha above."""
    small = elastica_tip_force(1e-5)
    assert (small.w, small.angle, small.u) == pytest.approx((1e-5 / 3, 5e-6, 1e-10 / 15), rel=1e-9)
    large = elastica_tip_force(1e4)
    assert (large.w, large.u) == pytest.approx((1 - (2 - sqrt(2)) / 100, 1 - sqrt(2) / 100), abs=1e-12)
    assert elastica_tip_force(-3.0).w == -elastica_tip_force(3.0).w
    assert elastica_tip_force(-3.0).u == elastica_tip_force(3.0).u
    assert elastica_tip_force(0.0).w == 0.0


# ---- torsion -----------------------------------------------------------------------------------------------


def ritz_torsion_constant(a, b, degree=14):
    """Largest of (int phi)^2/int |grad phi|^2 over (1 - x^2)(1 - y^2) times polynomials: J = 4 x that."""
    x, w = np.polynomial.legendre.leggauss(40)
    bubble, slope = 1 - x**2, -2 * x
    P = [np.polynomial.legendre.Legendre.basis(k) for k in range(0, degree, 2)]
    f = np.array([bubble * p(x) for p in P])
    df = np.array([slope * p(x) + bubble * p.deriv()(x) for p in P])
    mass, stiff, mean = (f * w) @ f.T, (df * w) @ df.T, f @ w
    K = np.kron(stiff, mass) * (b / a) + np.kron(mass, stiff) * (a / b)
    F = np.kron(mean, mean) * a * b / 4
    return 4 * float(F @ np.linalg.solve(K, F))


@pytest.mark.parametrize("a, b, printed", [(1.0, 1.0, 0.140577), (2.0, 1.0, 0.22868), (10.0, 1.0, 0.3123)])
def test_rectangle_torsion_by_ritz(a, b, printed):
    """Prandtl's stress function by a polynomial Ritz method; printed: Timoshenko and Goodier, table 7."""
    J = torsion_constant_rectangle(a, b)
    assert pytest.approx(ritz_torsion_constant(a, b), rel=1e-6 if a < 5 else 2e-4) == J
    assert J / (a * b**3) == pytest.approx(printed, abs=6e-5)
    assert torsion_constant_rectangle(b, a) == J


def test_other_torsion_constants():
    assert torsion_constant_rectangle(1, 1) == pytest.approx(0.1405770149551536, abs=1e-13)
    R = 0.3
    assert torsion_constant_circle(R) == pytest.approx(torsion_constant_ellipse(R, R), rel=1e-15)
    assert torsion_constant_circle(R, 0.299) == pytest.approx(
        2 * pi * 0.2995**3 * 0.001, rel=1e-5
    )  # thin tube
    assert torsion_constant_circle(R) == pytest.approx(
        torsion_constant_linear_section(pi * R**4 / 4, pi * R**4 / 4)
    )
    # 2:1 rectangle, a = 2, b = 1: I_y = 1/6, I_z = 2/3; warping c y z minimises the energy
    c = np.linspace(-1, 1, 200001)
    least = ((c - 1) ** 2 / 6 + (c + 1) ** 2 * 2 / 3).min()
    assert torsion_constant_bilinear_section(1 / 6, 2 / 3) == pytest.approx(least, rel=1e-9)
    assert torsion_constant_bilinear_section(1 / 6, 2 / 3) / 2 == pytest.approx(0.266667, abs=1e-6)
    assert torsion_constant_linear_section(1 / 12, 1 / 12) == pytest.approx(0.166667, abs=1e-6)
    assert twist_angle(3.0, 2.0, 4.0) == 1.5


# ---- buckling ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "ends", ["clamped-free", "pinned-pinned", "clamped-pinned", "clamped-clamped", "clamped-guided"]
)
def test_euler_load_is_the_first_singular_load(ends):
    """w'''' + k^2 w'' = 0 with w = 1, x, cos kx, sin kx: the boundary rows are singular at P, not below."""

    def rows(k):
        c, s = np.cos(k), np.sin(k)
        at = {
            "w0": [1, 0, 1, 0],
            "d0": [0, 1, 0, k],
            "m0": [0, 0, -(k**2), 0],
            "w1": [1, 1, c, s],
            "d1": [0, 1, -k * s, k * c],
            "m1": [0, 0, -(k**2) * c, -(k**2) * s],
            "q1": [0, k**2, 0, 0],  # w''' + k^2 w'
        }
        names = {
            "clamped-free": "w0 d0 m1 q1",
            "pinned-pinned": "w0 m0 w1 m1",
            "clamped-pinned": "w0 d0 w1 m1",
            "clamped-clamped": "w0 d0 w1 d1",
            "clamped-guided": "w0 d0 d1 q1",
        }[ends]
        return np.linalg.det(np.array([at[n] for n in names.split()], float))

    k = sqrt(euler_load(1.0, 1.0, ends))
    below = [rows(x) for x in np.linspace(0.2, 0.98, 60) * k]
    assert abs(rows(k)) < 1e-9 * max(map(abs, below))
    assert min(map(abs, below)) > 1e-6 * max(map(abs, below))
    assert euler_load(3.0, 2.0, ends) == pytest.approx(k**2 * 0.75)


def test_euler_load_names_the_choices():
    with pytest.raises(ValueError, match="clamped-free"):
        euler_load(1.0, 1.0, "free-free")


def test_self_weight_and_lateral_buckling_by_integration():
    """The linear equations from the free end: the clamp condition is met at the load, and not before it."""

    def first_sign(power, load):
        def slope(x, y):
            return [y[1], -load * x**power * y[0]]

        run = solve_ivp(slope, (0, 1), [1.0, 0.0], "DOP853", rtol=1e-12, atol=1e-14, dense_output=True)
        return run.y[0, -1], run.sol(np.linspace(0, 0.99, 100))[0].min()

    end, before = first_sign(1, self_weight_load(1.0, 1.0))
    assert abs(end) < 1e-10 and before > 0
    end, before = first_sign(2, lateral_buckling_load(1.0, 1.0, 1.0) ** 2)
    assert abs(end) < 1e-10 and before > 0
    assert self_weight_load(1.0, 1.0) == pytest.approx(7.8373, abs=5e-5)  # Greenhill 1881
    assert lateral_buckling_load(1.0, 1.0, 1.0) == pytest.approx(4.012599344, abs=1e-9)  # Prandtl 1899: 4.013
    assert self_weight_load(2.0, 3.0) == pytest.approx(7.8373474 * 2 / 27, rel=1e-7)
    assert lateral_buckling_load(2.0, 8.0, 2.0) == pytest.approx(4.012599344)


# ---- uniaxial ----------------------------------------------------------------------------------------------


@settings(deadline=None)
@given(st.floats(-0.19, 3.0), st.floats(0.0, 0.2))
def test_saint_venant_kirchhoff_stretch_minimises_the_energy(f, nu):
    """Full three-dimensional energy: both derivatives by the stretches vanish."""
    stretch = uniaxial_saint_venant_kirchhoff(f, 1.0, nu, 1.0)
    lam, mu = nu / ((1 + nu) * (1 - 2 * nu)), 1 / (2 * (1 + nu))
    along, across = (stretch.axial**2 - 1) / 2, (stretch.lateral**2 - 1) / 2
    trace = along + 2 * across
    assert stretch.axial * (lam * trace + 2 * mu * along) == pytest.approx(f, abs=1e-13)
    assert lam * trace + 2 * mu * across == pytest.approx(0, abs=1e-13)
    assert stretch.axial >= 1 / sqrt(3)


def test_uniaxial_limits():
    assert uniaxial_saint_venant_kirchhoff(0.0, 1.0, 0.3, 1.0).axial == pytest.approx(1.0, abs=1e-15)
    with pytest.raises(ValueError, match="no equilibrium"):
        uniaxial_saint_venant_kirchhoff(-0.2, 1.0, 0.3, 1.0)
    with pytest.raises(ValueError, match="shrinks"):
        uniaxial_saint_venant_kirchhoff(3.0, 1.0, 0.4, 1.0)
    # mu = 9e5 Pa, A = .01 m2, 9500 N: lambda - lambda^-2 = 1.0556 at lambda = 1.5
    assert uniaxial_neo_hookean(9500.0, 9e5, 0.01).axial == pytest.approx(1.5, abs=1e-14)
    for f in (-5.0, -0.1, 0.0, 4.0):
        x = uniaxial_neo_hookean(f, 1.0, 1.0)
        assert x.axial - x.axial**-2 == pytest.approx(f, abs=1e-12)
        assert x.axial * x.lateral**2 == pytest.approx(1.0)


def test_locking_factor_is_the_oedometric_modulus():
    """Hooke's matrix with zero lateral strain; the numbers were measured by others on elements."""
    for nu, printed in ((0.3, 1.3462), (0.45, 3.7931), (0.49, 17.114)):
        compliance = np.full((3, 3), -nu) + (1 + nu) * np.eye(3)
        assert full_hooke_locking_factor(nu) == pytest.approx(np.linalg.inv(compliance)[0, 0], rel=1e-12)
        assert full_hooke_locking_factor(nu) == pytest.approx(printed, rel=5e-5)
    assert full_hooke_locking_factor(0.0) == 1.0
