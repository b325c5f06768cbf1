"""Hard cases: scenes at the edge of what a user may ask, with the status that each must end in.

Not solving is allowed where no equilibrium exists; ending without a typed reason, or with a number that is
not
finite, is not.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

import ancf
from ancf.errors import InputError
from ancf.solution import Solution
from validation.criteria import Verdict

LENGTH, YOUNG = 0.4, 1.0e6  # m, Pa
TYPED_FAILURES = ("not_converged", "limit_point", "inverted_element", "not_finite", "material_unstable")


@dataclass(frozen=True)
class HardCase:
    """A scene, the statuses it may end in, and what its answer is compared with (None: the status alone)."""

    name: str
    scene: dict[str, Any]
    expected: tuple[str, ...]
    deviation: Callable[[Solution], float] | None = None
    limit: float = math.inf
    meaning: str = ""


@dataclass(frozen=True)
class HardResult:
    """How a hard case ended; `deviation` in the unit of its limit."""

    case: HardCase
    verdict: Verdict
    status: str
    reason: str
    steps: int
    cutbacks: int
    iterations: int
    residual: float | None
    floor: float | None
    deviation: float | None
    seconds: float


def _scene(
    slenderness: float = 40.0,
    young: float = YOUNG,
    nu: float = 0.3,
    angle: float | None = None,
    **changes: Any,
) -> dict[str, Any]:
    """The arm under a tip moment E I angle/L about z; `changes` go to the rod, or replace a load table."""
    radius = LENGTH / slenderness
    tables = {key: changes.pop(key) for key in ("moment", "force", "gravity", "solver") if key in changes}
    rod = {
        "length": LENGTH, "elements": 12, "element": "3333", "section": {"shape": "circle", "radius": radius},
        "material": {"young_modulus": young, "poisson_ratio": nu, "density": 1070.0}, **changes,
    }  # fmt: skip
    if angle is not None:
        moment = young * math.pi * radius**4 / 4.0 * angle / LENGTH
        tables["moment"] = [{"value": [0.0, 0.0, moment]}]
    return {"rod": [rod], **tables}


def _stiffness(slenderness: float = 40.0, young: float = YOUNG) -> float:
    return young * math.pi * (LENGTH / slenderness) ** 4 / 4.0


def _from_circle(angle: float) -> Callable[[Solution], float]:
    """Distance of the tip, over L, from the thin arc that turns by `angle`."""

    def deviation(solution: Solution) -> float:
        rod = solution.scene.rods[0]
        exact = LENGTH * np.array(
            [np.sinc(angle / np.pi), np.sin(angle / 2) * np.sinc(angle / (2 * np.pi)), 0.0]
        )
        return float(np.linalg.norm(solution.tip().position - rod.base.position - exact)) / LENGTH

    return deviation


def _from_straight(solution: Solution) -> float:
    return float(np.linalg.norm(solution.tip().position - [LENGTH, 0.0, 0.0])) / LENGTH


def hard_cases() -> list[HardCase]:
    """All of them."""
    circle, quarter, done = 2 * math.pi, math.pi / 2, ("converged",)
    EI = _stiffness()
    push = math.pi**2 / 4 * EI / LENGTH**2  # Euler load of the column
    both: dict[str, Any] = {"supports": [{"at": 0.0, "kind": "clamp"}, {"at": 1.0, "kind": "clamp"}]}
    return [
        HardCase(
            "full circle, L/R = 5",
            _scene(5, angle=circle),
            (*done, *TYPED_FAILURES),
            None,
            math.inf,
            "kappa R = 1.26: the moment exceeds the largest that the section carries; a typed "
            "failure is right",
        ),
        HardCase(
            "full circle, L/R = 40",
            _scene(40, angle=circle),
            done,
            _from_circle(circle),
            6e-2,
            "the tip comes back to the base; finite strain turns it further by 1.4 (kappa R)^2",
        ),
        HardCase(
            "full circle, L/R = 400",
            _scene(400, angle=circle),
            done,
            _from_circle(circle),
            3e-3,
            "the same, a hundred times less finite strain",
        ),
        HardCase(
            "full circle, L/R = 4000",
            _scene(4000, angle=circle),
            done,
            _from_circle(circle),
            3e-3,
            "float64 positions leave a residual of 6e-7 here; the floor is reported",
        ),
        HardCase(
            "nu = 0.4999, 90 degrees",
            _scene(nu=0.4999, angle=quarter),
            done,
            _from_circle(quarter),
            2e-3,
            "nearly incompressible: no Poisson locking with the enhanced law",
        ),
        HardCase(
            "one element, 90 degrees",
            _scene(400, angle=quarter, elements=1),
            done,
            _from_circle(quarter),
            5e-2,
            "one quadratic element for a quarter circle",
        ),
        HardCase(
            "200 elements, 90 degrees",
            _scene(400, angle=quarter, elements=200),
            done,
            _from_circle(quarter),
            1e-4,
            "cost grows linearly, the floor with the number of elements",
        ),
        HardCase(
            "E = 100 Pa, 90 degrees",
            _scene(young=1e2, angle=quarter),
            done,
            _from_circle(quarter),
            2e-3,
            "the tolerance is dimensionless: same digits",
        ),
        HardCase(
            "E = 1e12 Pa, 90 degrees",
            _scene(young=1e12, angle=quarter),
            done,
            _from_circle(quarter),
            2e-3,
            "the tolerance is dimensionless: same digits",
        ),
        HardCase("no load at all", _scene(), done, _from_straight, 1e-15, "nothing is divided by the load"),
        HardCase(
            "two opposite tip forces",
            _scene(force=[{"value": [0, 1e3, 0]}, {"value": [0, -1e3, 0]}]),
            done,
            _from_straight,
            1e-9,
            "contradictory loads cancel exactly",
        ),
        HardCase(
            "tip force 1e300 N",
            _scene(force=[{"value": [0, 1e300, 0]}]),
            TYPED_FAILURES,
            None,
            math.inf,
            "overflows: a typed reason, nothing that is not finite",
        ),
        HardCase(
            "base 1e6 m away, full circle",
            _scene(40, angle=circle, base={"position": [1e6, 1e6, -1e6]}),
            done,
            _from_circle(circle),
            6e-2,
            "same digits as at the origin",
        ),
        HardCase(
            "follower tip force, P L2/EI = 10",
            _scene(force=[{"value": [0, 10 * EI / LENGTH**2, 0], "direction": "follower"}]),
            done,
            None,
            math.inf,
            "unsymmetric load tangent, no closed-form start",
        ),
        HardCase(
            "clamped at both ends, moment at the middle",
            _scene(moment=[{"at": 0.5, "value": [0, 0, 10 * EI / LENGTH]}], **both),
            done,
            None,
            math.inf,
            "statically indeterminate, no predictor",
        ),
        HardCase(
            "perfect column at 3 Euler loads",
            _scene(force=[{"value": [-3 * push, 0, 0]}]),
            (*done, *TYPED_FAILURES),
            None,
            math.inf,
            "perfect: the straight shape is an equilibrium, and the result warns that it is unstable",
        ),
        HardCase(
            "column with 0.1 % lateral load at 3 Euler loads",
            _scene(force=[{"value": [-3 * push, 3e-3 * push, 0]}]),
            done,
            None,
            math.inf,
            "one long step would land on the unstable, nearly straight shape; the path takes the buckled one",
        ),
        HardCase(
            "pinned at one end only",
            _scene(supports=[{"at": 0.0, "kind": "pin"}], force=[{"value": [0, 0.01, 0]}]),
            ("refused", *TYPED_FAILURES),
            None,
            math.inf,
            "a mechanism: refused before anything is computed (exit code 2)",
        ),
    ]


def run_hard_case(case: HardCase) -> HardResult:
    """Solve one and judge how it ended."""
    started = time.perf_counter()
    try:
        solution = ancf.solve(ancf.scene_from_dict(case.scene))
        deviation = None if case.deviation is None else case.deviation(solution)
    except InputError as error:
        seconds = time.perf_counter() - started
        verdict = Verdict.PASS if "refused" in case.expected else Verdict.FAIL
        return HardResult(case, verdict, "refused", error.message.what, 0, 0, 0, None, None, None, seconds)
    except Exception as error:  # a traceback is the one thing that must not happen
        seconds = time.perf_counter() - started
        reason = f"{type(error).__name__}: {error}"
        return HardResult(case, Verdict.FAIL, "exception", reason, 0, 0, 0, None, None, None, seconds)
    seconds = time.perf_counter() - started
    status = str(solution.status)
    good = status in case.expected and (deviation is None or deviation <= case.limit)
    explained = status == "converged" or bool(solution.reason)
    finite = bool(np.isfinite(solution.q).all())
    verdict = Verdict.PASS if good and explained and finite else Verdict.FAIL
    return HardResult(
        case, verdict, status, solution.reason, solution.steps, solution.cutbacks, solution.iterations,
        _finite(solution.residual), _finite(solution.residual_floor), None if deviation is None else
        _finite(deviation),
        seconds,
    )  # fmt: skip


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


def run() -> Iterator[HardResult]:
    """Run all, one result at a time."""
    for case in hard_cases():
        yield run_hard_case(case)
