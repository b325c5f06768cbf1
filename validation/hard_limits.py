"""What is asked of every hard case: quantities, their common limits, and why a correct program meets them."""

from __future__ import annotations

from dataclasses import dataclass

from validation.criteria import Limit
from validation.hard_case import HardCase

EPS = 2.220446049250313e-16  # of float64
DRIFT = 1e-9  # of the length: so that digits beyond those of a drawing agree

# Finite strain of Saint Venant-Kirchhoff turns a rod further than a thin one by 1.375 (kappa R)^2 (theory.md
# 2); the tip of a full circle then misses its base by about as many rod lengths.
FINITE_STRAIN = 1.375
# What 12 elements 3333 leave of a full circle, and of a quarter: theory.md 3 and README.md, with room for 2.
MESH_CIRCLE, MESH_QUARTER = 1e-3, 1e-4

# Why no case needs more than 1e-9 L, however slender: rounding of the stored positions changes every strain
# by about eps, as an initial strain of that size would; the rod then moves by eps L times its amplification.
# The residual is that strain times E A, so its floor grows with A L^2/I; the position of the answer does not.
_DRIFT = (
    "rounding of stored positions acts like an initial strain of eps: the rod moves by about eps L, however "
    "slender; 1e-9 leaves six digits for amplification near a bifurcation"
)


@dataclass(frozen=True)
class Measure:
    """A column of the table.

    Parameters
    ----------
    name : of the quantity, as in findings
    heading : of the column
    limit : common to all cases; None where the number is shown and not judged
    meaning : for the reader
    quick : whether the quick run measures it
    shows : number that the cell shows in its place: an order where its shortfall is judged
    """

    name: str
    heading: str
    meaning: str
    limit: Limit | None = None
    quick: bool = True
    shows: str = ""


def _drift(name: str, heading: str, meaning: str, quick: bool = True) -> Measure:
    return Measure(f"drift, {name}", heading, meaning, Limit(f"drift, {name}", DRIFT, "L", _DRIFT), quick)


_FLOOR = Limit(
    "residual over floor", 1.0, "-", "converged means residual <= max(tolerance, floor) (theory.md 6)",
    kind="non-regression",
)  # fmt: skip
_ORDER = Limit(
    "Newton order below 2", 0.2, "-", "an exact tangent gives 2; required is 1.8", kind="non-regression"
)
_STEP_ORDER = Limit(
    "Newton order by steps below 2",
    0.5,
    "-",
    "three steps tell 2 + ln(C_2/C_1)/ln(e_2/e_1): the constant C of e_2 = C e_1^2 changes by some 10 on the "
    "way in, over two or three decades; linear convergence gives 1",
    kind="non-regression",
)
_CONDITION = Limit(
    "condition number",
    1.0 / EPS,
    "-",
    "beyond 1/eps no digit of a linear solve is left",
    kind="non-regression",
)
_ENERGY = Limit(
    "energy balance", 1e-5, "U",
    "Simpson's rule on a path that turns by t per step errs by about t^4/30: 5e-7 for a circle in 100 steps",
    kind="non-regression",
)  # fmt: skip
_ENERGY_ORDER = Limit(
    "energy order off 2", 0.2, "-", "the trapezoidal rule on a smooth path has order 2", kind="non-regression"
)

MEASURES = (
    Measure("deviation", "tip to exact", "distance of the tip from the exact answer named in the case"),
    Measure("residual over floor", "residual / floor", "the floor, or the tolerance if larger", _FLOOR),
    Measure(
        "Newton order below 2",
        "order by residuals",
        "of the last three between 0.1 and 100 floors; fast: fewer, quicker than an order can show",
        _ORDER,
        shows="Newton order",
    ),
    Measure(
        "Newton order by steps below 2",
        "order by steps",
        "of the last three below 0.1 whose residuals are above 10 floors; shows more on slender rods",
        _STEP_ORDER,
        shows="Newton order by steps",
    ),
    Measure("condition number", "condition number", "1-norm, of the dimensionless tangent", _CONDITION),
    Measure("min det F", "min det F", "smallest volume ratio at the axial points; must be positive"),
    _drift("units", "mm-g-s", "the scene written in mm, g, s"),
    _drift("turned", "turned", "the whole scene turned about no special axis"),
    _drift("moved", "1e6 m away", "base 1e6 m away in all three directions"),
    _drift("reversed", "reversed", "described from its other end: clamp at 1, axis and curvature reversed"),
    _drift("renumbered", "renumbered", "rods, loads, supports in opposite order, behind a stranger"),
    _drift("one ulp", "one ulp", "length, section, stiffness or loads as the next float64, the worst", False),
    Measure("ulp ratio", "ulp drift / eps κ", "κ: amplification of the load, at least 1", quick=False),
    _drift("threads", "1 / 2 threads", "BLAS with one thread and with two, in processes of their own"),
    _drift("hundred steps", "100 steps", "the load in a hundred equal steps without predictor", quick=False),
    Measure("energy balance", "|W − U| / U", "work of the loads, Simpson, 100 steps", _ENERGY, quick=False),
    Measure(
        "energy order off 2", "order off 2", "observed order of the trapezoidal rule, 50 to 100 steps",
        _ENERGY_ORDER, quick=False,
    ),
)  # fmt: skip
WALKED: tuple[str, ...] = ("drift, hundred steps", "energy balance", "energy order off 2")


def hard_limits(case: HardCase, full: bool = True) -> tuple[Limit, ...]:
    """Limits of a case in a quick or full run, its own first; none where it need not converge.

    A case's own limit of a quantity (`HardCase.limits`) replaces the common one.
    """
    if not case.solvable:
        return ()
    costly = case.drifts == "full"
    asked = [
        m
        for m in MEASURES
        if full
        or (m.quick and not (costly and m.name.startswith("drift")))
        or (m.name in WALKED and case.walk == "quick")
    ]
    left_out = {m.name for m in MEASURES} - {m.name for m in asked}
    own = {limit.quantity: limit for limit in case.limits if limit.quantity not in left_out}
    common = [m.limit for m in asked if m.limit is not None and m.name not in case.not_asked]
    return (*own.values(), *(limit for limit in common if limit.quantity not in own))


def deviation(value: float, reason: str) -> tuple[Limit, ...]:
    """Limit of the tip's distance from the exact answer; a bound on the model, met or not."""
    return (Limit("deviation", value, "L", reason, kind="non-regression"),)


def energy(turn: float) -> Limit:
    """Limit of the energy balance of a rod that turns by `turn` rad in a hundred steps."""
    value = float(f"{3.0 * (turn / 100.0) ** 4 / 30.0:.1e}")
    why = f"Simpson's rule on a path that turns by {turn / 100:.2g} rad a step: three times t^4/30"
    return Limit("energy balance", value, "U", why, kind="non-regression")


def thin(angle: float, slenderness: float, mesh: float) -> tuple[Limit, ...]:
    """Limit of the distance from the thin arc or helix: finite strain, then the mesh."""
    strain = 1.5 * FINITE_STRAIN * (angle / slenderness) ** 2
    value = float(f"{strain + mesh:.1e}")
    return deviation(
        value, f"finite strain 1.375 (kappa R)^2 = {strain / 1.5:.1e}, mesh {mesh:.0e}; half as much again"
    )
