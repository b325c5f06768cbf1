"""Captions of the figures: each states its conclusion, with the numbers of the run it belongs to."""

from __future__ import annotations

from validation.cost.advice import TARGETS, cheapest
from validation.criteria import Verdict
from validation.report.numbers import compact, number
from validation.runner import Run

STRESS = (
    "<b>Axial stress in the middle of a neo-Hookean arm rolled to a half circle, ν = 0.49.</b> Left: the 3-D "
    "solid. The quadratic section of 3363 shows its stress; the linear section of 3333 cannot follow the "
    "in-plane field of bending. Differences are against the solid, in units of E."
)
RATES = (
    "<b>What remains between beam and exact answer vanishes with the square of the thickness.</b> Same angle "
    "and length, three radii; the grey line has the slope of order 2. The order is gated, not only the size."
)
OVERLAY = (
    "<b>Beam over solid.</b> A neo-Hookean arm, L/R = 40, ν = 0.49, under a tip moment: the solid's centre "
    "line and 16 elements 3363 (marks). Right: distance of the centre lines, 3363 solid, 3333 dashed."
)


def captions(run: Run) -> dict[str, str]:
    """Caption (HTML) by figure."""
    return {
        "margins": _margins(run),
        "convergence": _convergence(run) + "3333 converges with the fourth order in all five "
        "problems, curved reference included; 3243 with more than its second order, because "
        "locking, which it leaves "
        "first, fades with the fourth. Numbers: fitted order.",
        "locking": _locking(run),
        "work": _work(run),
        "work_unknowns": "<b>Error against unknowns.</b> Beams and solid, marks as above.",
        "work_iterations": "<b>Error against linear solves.</b> Load steps without the predictor cost "
        "several times as many; the kind of tangent changes nothing.",
        "overlay": OVERLAY,
        "stress": STRESS,
        "rates": RATES,
        "effects": "<b>What an effect costs.</b> One assembly, force and tangent, by that of the rods.",
        "fig1": "<b>Figure 1.</b> A solved element 3243: at each node the position r and the gradients "
        "r<sub>x</sub>, r<sub>y</sub>, r<sub>z</sub>, in structure coordinates (SCS). 24 nodal coordinates.",
        "fig2": _scenes(run),
        "fig3": "<b>Figure 3.</b> Circular section in cylindrical coordinates (x, r, θ), with the points of "
        "the quadrature that integrates the Saint Venant-Kirchhoff energy over the disc exactly (degree 4).",
    }


def _convergence(run: Run) -> str:
    missed = [r for r in run.convergence if r.verdict is Verdict.FAIL]
    if missed:
        names = ", ".join(f"{r.study.name} with {r.study.element}" for r in missed)
        return f"<b>Not every promise is kept: {names}.</b> "
    return "<b>Every element keeps its promised order.</b> "


def _locking(run: Run) -> str:
    finding = run.study_findings.get("locking curve")
    lead = (
        "With the paper's full Hooke law the rod is too stiff, at every mesh, by the closed form "
        "(1 − ν)/((1 + ν)(1 − 2ν)). The enhanced law gives E I itself up to ν = 0.499."
    )
    if finding is None or finding.verdict is Verdict.FAIL:
        lead = "The solver does not follow the closed forms."
    return f"<b>{lead}</b> Lines: closed forms; marks: solver, two elements, turn of 10<sup>−4</sup> rad."


def _scenes(run: Run) -> str:
    found = [r.verdict for r in run.cases if r.case.row == "fig. 2"]
    agree = "agrees" if found and Verdict.FAIL not in found else "was to agree"
    return (
        "<b>Figure 2, with our numbers.</b> 12 elements 3243, L = 0.4 m, radius 10 mm, E = 1 "
        "MPa, ν = 0.3, base "
        "of eq. 3 (the arm stands along Z). Grey: undeformed; blue: equilibrium, with the tip "
        "frames r<sub>x</sub> "
        "(orange), r<sub>y</sub> (green), r<sub>z</sub> (blue) before and after. Each scene is a "
        f"case above and {agree} "
        "with the integrated rod."
    )


def _margins(run: Run) -> str:
    found = [
        f for r in run.cases for f in r.findings if f.limit.kind == "reference" and f.limit.documented is None
    ]
    met = [f for f in found if f.margin is None or f.margin >= 1.0]
    if not found:
        return "No reference checks in this run."
    tightest = min((f.margin for f in met if f.margin is not None), default=None)
    lead = (
        "<b>Every reference check meets its limit.</b>"
        if len(met) == len(found)
        else (f"<b>{len(found) - len(met)} of {len(found)} reference checks miss their limit.</b>")
    )
    return (
        f"{lead} One dot a check, by row of the benchmark table; the tightest margin is "
        f"{number(tightest, 3)}. Triangles: below 1.5. "
        "Diamonds: known limits, which miss on purpose and by a documented amount. Exact hits "
        "stand at the right edge."
    )


def _work(run: Run) -> str:
    if not run.work:
        return "Tip error against time."
    found = [c for family in run.work for c in cheapest(family)]
    reached = {t: sum(c.beam is not None for c in found if c.target == t) for t in TARGETS}
    lead = ", ".join(f"{compact(t)} L in {n} of {len(run.work)} families" for t, n in reached.items())
    return (
        f"<b>Some beam reaches {lead}.</b> Filled marks: default settings; hollow and dotted: the other "
        "formulation, no predictor, finite-difference tangent. Small numbers: elements of the coarsest and "
        "finest mesh. Crosses at the upper edge: no equilibrium found; they are among the omissions below."
    )
