"""Who checks the references? Solid and section against truths they did not come from, with promised orders.

Manufactured solutions, patches, rigid motion, homogeneous stretch, Rivlin's flexure and torsion, scikit-fem's
form language, felupe. `run` yields one `CheckResult` at a time; the quick list takes some 20 s.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from reference.oracles import felupe_version
from reference.rivlin import flexure_of_block, poynting_stretch, torsion_of_cylinder
from reference.rivlin_compressible import flexure_compressible, torsion_compressible
from reference.solid_forms import Formulation
from validation.criteria import Finding, Limit, Verdict, judge, worst
from validation.reference_exact import bent_block, twisted_cylinder
from validation.reference_measures import (
    Measure,
    Rubber,
    manufactured,
    oracle,
    patch,
    rigid_motion,
    rubbers,
    stretches,
)
from validation.section_measures import section_errors

SHORTFALL = 0.3  # of an order: what two meshes far from the limit may miss
ROUNDING = 1e-12  # relative; measured 1e-16 to 2e-14
SOLVED = 1e-10  # relative, where Newton's method stops at 1e-11 of the forces
CURVATURE, THICKNESS = 0.5, 1.0  # 1/m, m: hoop stretches 0.79 and 1.27
TWIST, STRETCH = 0.6, 1.05  # 1/m at a radius of 1 m: shear 0.6; -
NEARLY = 0.4999
FORMS: tuple[Formulation, ...] = ("displacement", "mixed")


@dataclass(frozen=True)
class CheckResult:
    """Errors of one check over its levels, the order between the last two, and the verdicts.

    `errors[name]` (levels,) relative errors; `sizes` what shrinks (mesh size, 1 - 2 nu); `orders[name]` the
    fitted order, `promised[name]` the expected one; `truth` where the exact answer comes from; `note` the
    reason when nothing could be measured.
    """

    name: str
    truth: str
    sizes: tuple[float, ...]
    errors: dict[str, tuple[float, ...]]
    promised: dict[str, float]
    findings: list[Finding] = field(default_factory=list)
    seconds: float = 0.0
    note: str = ""

    @property
    def verdict(self) -> Verdict:
        """Worst of the findings."""
        return worst(finding.verdict for finding in self.findings)

    @property
    def orders(self) -> dict[str, float]:
        """Observed orders, fitted over all levels."""
        return {name: _order(self.sizes, self.errors[name]) for name in self.promised}


@dataclass(frozen=True)
class Check:
    """A measurement to be made: `measure(size)` returns errors by name at one level.

    `bound` limits the errors at the last level, one number or one by name, because `reason`; `promised`
    orders hold within SHORTFALL; `optional` where a package is needed that the project does not ask for.
    """

    name: str
    truth: str
    measure: Measure
    bound: Mapping[str, float] | float
    reason: str
    sizes: tuple[float, ...] = (1.0,)
    promised: dict[str, float] = field(default_factory=dict)
    optional: bool = False

    def run(self) -> CheckResult:
        """Measure all levels and judge; a body without an equilibrium is a failure with its reason."""
        begin = time.perf_counter()
        levels: list[dict[str, float]] = []
        note = ""
        try:
            levels = [self.measure(size) for size in self.sizes]
        except (RuntimeError, ValueError, np.linalg.LinAlgError) as error:
            note = f"not measured: {error}"
            levels = [{"equilibrium": float("nan")}]
        found = {name: tuple(level[name] for level in levels) for name in levels[0]}
        findings = []
        for name, values in found.items():
            bound = self.bound.get(name, 0.0) if isinstance(self.bound, Mapping) else self.bound
            limit = Limit(f"{self.name}: {name}", bound, "-", self.reason)
            findings.append(judge(limit, limit.quantity, values[-1]))
            if name in self.promised:
                promise = self.promised[name]
                why = f"promised {promise:g}: {self.reason}"
                limit = Limit(f"{self.name}: order of {name} below its promise", SHORTFALL, "-", why)
                shortfall = max(promise - _order(self.sizes, values), 0.0)
                findings.append(judge(limit, limit.quantity, shortfall))
        promised = {name: order for name, order in self.promised.items() if name in found}
        seconds = time.perf_counter() - begin
        return CheckResult(self.name, self.truth, self.sizes, found, promised, findings, seconds, note)


def _order(sizes: tuple[float, ...], values: tuple[float, ...]) -> float:
    """Slope of the errors over the sizes, fitted on logarithmic scales."""
    return float(np.polyfit(np.log(sizes), np.log(values), 1)[0])


def _nu(nearly: bool) -> str:
    """Poisson ratio as the names carry it."""
    return f"nu = {NEARLY if nearly else 0.3}"


def _once(function: Callable[[], dict[str, float]]) -> Measure:
    """A measurement that has no levels."""
    return lambda size: function()


def checks(full: bool = False) -> Iterator[Check]:
    """All checks; `full` adds finer meshes and the remaining pairs of law and form."""
    for rubber in rubbers(0.3):
        last = rubber.name == "Mooney-Rivlin"
        for form in FORMS:
            yield from _identities(rubber, form)
            yield _oracle(rubber, form, "scikit-fem")
            if full or last or form == "displacement":
                yield _manufactured(rubber, form, "surface", full)
            if full or last == (form == "mixed"):
                yield _flexure(rubber, form, full)
                yield _torsion(rubber, form, full)
        if full or last:
            yield _section(rubber, 0.3)
        if felupe_version() is not None:
            yield _oracle(rubber, "displacement", "felupe")
    for rubber in rubbers(NEARLY):
        if full or rubber.name == "neo-Hookean":
            yield _section(rubber, NEARLY)
        # Saint Venant-Kirchhoff is left out: near nu = 1/2 it resists tr E, which no simple motion keeps.
        if rubber.name == "Mooney-Rivlin" or (full and rubber.name == "neo-Hookean"):
            yield _manufactured(rubber, "mixed", "face", full, nearly=True)
    yield _manufactured(rubbers(0.3)[1], "displacement", "face", full)
    yield _flexure(rubbers(NEARLY)[2], "mixed", full, nearly=True)
    yield _torsion(rubbers(NEARLY)[2], "mixed", full, nearly=True)
    for index in (1, 2):
        yield _rivlin_flexure(index, full)
        yield _rivlin_torsion(index, full)


def run(full: bool = False) -> Iterator[CheckResult]:
    """Run all checks, one result at a time."""
    for check in checks(full):
        yield check.run()


def _identities(rubber: Rubber, form: Formulation) -> Iterator[Check]:
    """Checks that are exact on every mesh."""
    name = f"{rubber.name}, {form}"
    why = "isoparametric 27-node elements hold every affine motion, whatever their shape"
    for curved, body in [(False, "brick"), (True, "O-grid")]:
        measure = _once(partial(patch, rubber, form, curved=curved))
        yield Check(f"patch, {body}: {name}", "affine motion", measure, SOLVED, why)
    why = "an energy of F^T F and a mesh that resolves every rigid motion"
    yield Check(
        f"rigid motion: {name}", "objectivity", _once(partial(rigid_motion, rubber, form)), ROUNDING, why
    )
    truth = "one equation in the principal stretches (homogeneous)"
    why = "a homogeneous state is held exactly; only Newton's tolerance remains"
    yield Check(f"stretch: {name}", truth, _once(partial(stretches, rubber, form)), SOLVED, why)


def _manufactured(rubber: Rubber, form: Formulation, held: str, full: bool, *, nearly: bool = False) -> Check:
    """Method of manufactured solutions; a motion without change of volume where nu is near 1/2."""
    return Check(
        f"manufactured, {held} held, {_nu(nearly)}: {rubber.name}, {form}",
        "a chosen motion, its body force and tractions by complex steps from the law in invariants",
        manufactured(rubber, form, swells=not nearly, held=held),
        {"displacement": 3e-4, "gradient": 6e-3} if full else {"displacement": 2.5e-3, "gradient": 2.5e-2},
        "quadratic elements: third order in L2, second in the gradient; bounds near twice the measured",
        (1 / 2, 1 / 3, 1 / 4) if full else (1, 1 / 2),
        {"displacement": 3.0, "gradient": 2.0},
    )


def _oracle(rubber: Rubber, form: Formulation, code: str) -> Check:
    """The same mesh and state by other code."""
    if form == "mixed":
        truth = "derivatives of the energy, written again with a least-squares projection"
    else:
        truth = f"felupe {felupe_version()}" if code == "felupe" else "scikit-fem's form language"
    return Check(
        f"oracle, {code if form == 'displacement' else 'energy'}: {rubber.name}, {form}",
        truth,
        _once(partial(oracle, rubber, form, code)),
        ROUNDING,
        "the same integrals at the same points",
        optional=code == "felupe",
    )


def _section(rubber: Rubber, nu: float) -> Check:
    """Section problem under refinement."""
    return Check(
        f"section problem, nu = {nu:g}: {rubber.name}",
        "radial equilibrium of the twisted cylinder, collocated; bending: a mesh of 6 quads",
        section_errors(rubber),
        1e-7,
        "required with refinement; fields of fourth order give couples of about seventh",
        (1, 1 / 2, 1 / 3),
        {"couple of torsion": 6.0, "stretch of torsion": 6.0, "couple of bending": 6.0},
    )


def _flexure(rubber: Rubber, form: Formulation, full: bool, *, nearly: bool = False) -> Check:
    """Flexure of a compressible block under mesh refinement."""

    def measure(size: float) -> dict[str, float]:
        exact = flexure_compressible(rubber.invariant, CURVATURE, THICKNESS)
        return bent_block(rubber.material, form, CURVATURE, THICKNESS, round(1 / size), exact)

    return Check(
        f"flexure, {_nu(nearly)}: {rubber.name}, {form}",
        "radial equilibrium of the bent block, collocated",
        measure,
        1e-3,
        "quadratic elements: resultants of fourth order, positions of third",
        (1 / 2, 1 / 4, 1 / 8) if full else (1 / 2, 1 / 4),
        {"couple": 4.0, "radii": 3.0},
    )


def _torsion(rubber: Rubber, form: Formulation, full: bool, *, nearly: bool = False) -> Check:
    """Torsion of a stretched compressible cylinder under mesh refinement."""

    def measure(size: float) -> dict[str, float]:
        exact = torsion_compressible(rubber.invariant, TWIST, 1.0, STRETCH)
        return twisted_cylinder(rubber.material, form, TWIST, STRETCH, round(1 / size), exact)

    return Check(
        f"torsion, {_nu(nearly)}: {rubber.name}, {form}",
        "radial equilibrium of the twisted cylinder, collocated",
        measure,
        1e-3,
        "quadratic elements: fourth order in the limit, 3.5 on so coarse O-grids, 3 at nu near 1/2",
        (1 / 2, 1 / 3) if full else (1, 1 / 2),
        {"axial force": 3.0} if nearly else {"couple": 3.5, "axial force": 3.5},
    )


def _rivlin_flexure(index: int, full: bool) -> Check:
    """Rivlin's flexure as nu goes to 1/2, on one fine mesh; `index` of the law."""

    def measure(gap: float) -> dict[str, float]:
        rubber = rubbers((1 - gap) / 2)[index]
        exact = flexure_of_block(CURVATURE, THICKNESS, rubber.c10, rubber.c01)
        return bent_block(rubber.material, "mixed", CURVATURE, THICKNESS, 8 if full else 4, exact)

    return Check(
        f"Rivlin's flexure, nu to 1/2: {rubbers(0.3)[index].name}, mixed",
        "closed form of the incompressible block (Rivlin 1949, Ogden 1984)",
        measure,
        4e-4 if full else 4e-3,
        "a compressible block differs in the first order of 1 - 2 nu; twice the measured distance",
        (0.02, 0.002, 0.0002) if full else (0.02, 0.002),
        {"couple": 1.0},
    )


def _rivlin_torsion(index: int, full: bool) -> Check:
    """Rivlin's torsion without axial force (Poynting's stretch) as nu goes to 1/2; `index` of the law."""

    def measure(gap: float) -> dict[str, float]:
        rubber = rubbers((1 - gap) / 2)[index]
        stretch = poynting_stretch(TWIST, 1.0, rubber.c10, rubber.c01)
        exact = torsion_of_cylinder(TWIST, 1.0, rubber.c10, rubber.c01, stretch)
        return twisted_cylinder(rubber.material, "mixed", TWIST, stretch, 3 if full else 2, exact)

    return Check(
        f"Rivlin's torsion at Poynting's stretch, nu to 1/2: {rubbers(0.3)[index].name}, mixed",
        "closed form of the incompressible cylinder (Rivlin 1949)",
        measure,
        5e-4 if full else 5e-3,
        "a compressible cylinder differs in the first order of 1 - 2 nu; twice the measured distance",
        (0.02, 0.002, 0.0002) if full else (0.02, 0.002),
        {"axial force": 1.0},
    )
