"""One self-contained offline `report.html` from a run: jinja2 template, inline figures, inline style."""

from __future__ import annotations

import tomllib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from markupsafe import Markup

from validation.cases import INDEPENDENCE, Case, formulation_of
from validation.convergence import SHORTFALL
from validation.cost import advice
from validation.criteria import Verdict
from validation.effect_costs import ASKED as ASKED_SHARE, call_table
from validation.environment import peak_memory_mb
from validation.locking import VARIANTS
from validation.locking_remedies import FORCE_CASES, MOMENT_CASES
from validation.outcome import Row
from validation.problems import CaseResult
from validation.property_runs import SEED
from validation.record import write_text
from validation.report import (
    figures_cost,
    figures_cross,
    figures_effects,
    figures_paper,
    figures_studies,
    numbers,
)
from validation.report.captions import captions
from validation.report.coverage import coverage, domain_rows
from validation.report.hard_table import chapter
from validation.report.matrix import matrices, slug
from validation.report.sketch import sketch
from validation.report.style import styled
from validation.report.surrogate_study import study_chapter
from validation.runner import Run
from validation.scenes import as_toml

HERE = Path(__file__).parent
ASKED = ("estimated error", "model error")  # problems of the chapter on `accuracy`
CONTENTS = (
    ("not-shown", "What this report does not show"),
    ("coverage", "What was compared with what"),
    ("ladder", "The ladder of truth: section problem, solid, beam"),
    ("cases", "Cases against references"),
    ("convergence", "Order of convergence"),
    ("properties", "Properties on random rods"),
    ("own-numbers", "Our own earlier numbers"),
    ("locking", "Locking: the paper's element and its cure"),
    ("work", "What accuracy costs"),
    ("asked", "Accuracy asked for"),
    ("effects", "Effects: only what a scene lists"),
    ("hard-cases", "Hard cases"),
    ("paper", "The paper's figures 1 to 3"),
    ("surrogate", "The surrogate: moments for a wanted pose"),
    ("decisions", "Where the paper is wrong or silent"),
    ("environment", "Environment and time"),
)


@dataclass(frozen=True)
class Card:
    """A case result as the template shows it."""

    case: Case
    verdict: Verdict
    findings: list
    reason: str
    warnings: list[str]
    rows: list[Row]
    sketch: Markup | None
    data: str
    short: str
    toml: str
    slug: str


def write_page(run: Run, folder: Path) -> Path:
    """Write `report.html` into a folder that exists; atomic."""
    return write_text(folder / "report.html", render(run, folder))


def render(run: Run, folder: Path) -> str:
    """The page as text; a study of the surrogate is taken from the folder."""
    import jinja2

    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(HERE), autoescape=True, undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    environment.filters.update(
        pretty=numbers.pretty,
        number=numbers.number,
        compact=numbers.compact,
        margin=numbers.margin,
        seconds=numbers.seconds,
    )
    return environment.get_template("report.html.j2").render(context(run, folder))


def context(run: Run, folder: Path) -> dict[str, Any]:
    """Everything the template needs."""
    verdict, reasons = run.verdict
    cards = [_card(result) for result in run.cases if not result.case.place]
    references = [c for c in cards if c.case.reference.independence != "own earlier number"]
    findings = [f for result in run.cases for f in result.findings]
    counts = Counter(f.verdict for f in findings)
    return {
        "run": run,
        "css": Markup((HERE / "report.css").read_text(encoding="utf-8")),
        "verdict": str(verdict) if run.complete or verdict is not Verdict.PASS else "PARTIAL",
        "sentence": sentence(run),
        "reasons": reasons,
        "blocking": [(name, _anchor(name)) for name in run.blocking],
        "tally": [(str(v), counts[v]) for v in Verdict if counts[v]],
        "checks": len(findings),
        "contents": CONTENTS,
        "independence": INDEPENDENCE,
        "known": [c for c in cards if c.verdict is Verdict.KNOWN_LIMIT],
        "coverage": coverage(run.cases),
        "domain": domain_rows(run),
        "matrices": matrices(run.cases),
        "groups": _groups(references),
        "own": _groups([c for c in cards if c.case.reference.independence == "own earlier number"]),
        "hard": chapter(run.hard_cases),
        "cost": [{"cost": cost, "sentence": advice.sentence(cost)} for cost in run.work],
        "effects": _effects(run),
        "asked": [r for r in run.cases if r.case.problem in ASKED and r.outcome is not None],
        "figures": _figures(run),
        "captions": captions(run),
        "shortfall": SHORTFALL,
        "seed": SEED,
        "variants": VARIANTS,
        "remedy_cases": (FORCE_CASES, MOMENT_CASES),
        "decisions": tomllib.loads((HERE / "decisions.toml").read_text(encoding="utf-8"))["decision"],
        "surrogate": study_chapter(folder, run.certificate),
        "memory": peak_memory_mb(),
    }


def sentence(run: Run) -> str:
    """The verdict in words."""
    checks = run.checks
    held = sum(v not in (Verdict.FAIL, Verdict.INCONCLUSIVE) for v in checks.values())
    near = sum(v is Verdict.WARN for v in checks.values())
    known = sum(v is Verdict.KNOWN_LIMIT for v in checks.values())
    parts = [f"{held} of {len(checks)} required results hold"]
    if near:
        parts.append(f"{near} of them close to the limit")
    if known:
        parts.append(f"{known} known limits are confirmed at their documented size")
    text = "; ".join(parts) + "."
    if held == len(checks) and run.complete and not run.skipped:
        text += (
            " The solver agrees with every independent answer it was held against, within the stated limits."
        )
    return text


def _card(result: CaseResult) -> Card:
    outcome = result.outcome
    solution = outcome.solution if outcome else None
    name = slug(result.case.id)
    return Card(
        case=result.case,
        verdict=result.verdict,
        findings=result.findings,
        reason=result.reason,
        warnings=result.warnings,
        rows=outcome.rows if outcome else [],
        sketch=sketch(solution, f"Rod of case {result.case.id}") if solution is not None else None,
        data=_data(result),
        short=_short(result.case),
        toml=as_toml(outcome.scene) if outcome and outcome.scene else "",
        slug=name,
    )


def _data(result: CaseResult) -> str:
    """The rod in one line."""
    case = result.case
    scene = (result.outcome.scene if result.outcome else None) or case.scene
    if case.parameters.get("variants") or not scene:
        notes = list(result.outcome.notes) if result.outcome else []
        count = len(case.parameters.get("variants", []))
        return "; ".join([f"{count} kinds of rod", *notes])
    rod = scene["rod"][0]
    pieces = rod.get("segments", [rod])
    section = ", ".join(
        f"{k.replace('_', ' ')} {v:g} m" if isinstance(v, int | float) else str(v)
        for k, v in pieces[0]["section"].items()
    )
    material = pieces[0]["material"]
    parts = [
        _mesh(rod),
        f"L = {sum(piece['length'] for piece in pieces):g} m",
        section,
        _law(case, material),
    ]
    if any(rod.get("curvature", ())):
        parts.append(f"stress-free curvature {list(rod['curvature'])} 1/m")
    return "; ".join(parts)


def _mesh(rod: dict[str, Any]) -> str:
    """Elements, element and formulation as far as the scene gives them; an accuracy chooses the others."""
    if "elements" in rod:
        return f"{rod['elements']} elements {rod.get('element', '3333')}, {formulation_of(rod)}"
    return f"elements {rod['element']} to be chosen" if "element" in rod else "elements to be chosen"


def _short(case: Case) -> str:
    """Mesh and element, which tell the cards of one family apart."""
    if not case.scene or "variants" in case.parameters:
        return ""
    rod = case.rod
    rule = f", {rod['axial_rule']} axial rule" if "axial_rule" in rod else ""
    law = f", {rod['formulation']}" if "formulation" in rod else ""
    section = rod.get("segments", [rod])[0]["section"]
    if "accuracies" in case.parameters or "accuracy" in case.parameters:
        return rod.get("element", "")
    ratio = f", L/R = {rod['length'] / section['radius']:g}" if section["shape"] == "circle" else ""
    if "elements" in case.parameters or "slenderness" in case.parameters:
        return f"{rod.get('element', '3333')}{law}{rule}"
    return f"{rod['elements']} × {rod.get('element', '3333')}{law}{rule}{ratio}"


def _law(case: Case, material: dict[str, Any]) -> str:
    """The law and its constants; nothing is said of Saint Venant-Kirchhoff, the default."""
    law = material.get("law", "saint-venant-kirchhoff")
    name = "" if law == "saint-venant-kirchhoff" else f"{law}, "
    given = [material["poisson_ratio"]] if "poisson_ratio" in material else []
    ratios = ", ".join(f"{nu:g}" for nu in case.parameters.get("poisson_ratios", given))
    if "c10" in material:
        mu = numbers.pascal(2.0 * (material["c10"] + material["c01"]))
        return f"{name}μ = {mu}, " + (
            f"ν = {ratios}" if ratios else f"K = {numbers.pascal(material['bulk_modulus'])}"
        )
    return f"{name}E = {numbers.pascal(material['young_modulus'])}, ν = {ratios}"


def _groups(cards: Sequence[Card]) -> list[dict[str, Any]]:
    """Cards by row of the benchmark table, in their order."""
    order: dict[str, list[Card]] = {}
    for card in cards:
        order.setdefault(card.case.row, []).append(card)
    return [
        {
            "row": row,
            "title": found[0].case.family,
            "shows": found[0].case.shows,
            "reference": found[0].case.reference,
            "slug": slug(row),
            "results": found,
        }
        for row, found in order.items()
    ]


def _figures(run: Run) -> dict[str, Markup | None]:
    crossed = any(r.case.place for r in run.cases)
    with styled():
        return {
            "overlay": figures_cross.overlay() if crossed else None,
            "stress": figures_cross.stress() if crossed else None,
            "rates": figures_cross.rates(run.cases),
            "margins": figures_studies.margins(run.cases) if run.cases else None,
            "convergence": figures_studies.convergence(run.convergence) if run.convergence else None,
            "locking": figures_studies.locking(run.locking) if run.locking else None,
            "work": figures_cost.grid(run.work, "seconds") if run.work else None,
            "work_unknowns": figures_cost.grid(run.work, "unknowns") if run.work else None,
            "work_iterations": figures_cost.grid(run.work, "iterations") if run.work else None,
            "effects": figures_effects.cost_bars(run.effect_costs) if run.effect_costs else None,
            "fig1": figures_paper.element(),
            "fig2": figures_paper.scenes(run.cases),
            "fig3": figures_paper.section(),
        }


def _effects(run: Run) -> dict[str, Any]:
    """Effects by scene, and how many cost more than was asked for."""
    names, rows = call_table(run.effect_calls)
    dear = sum(cost.ratio > ASKED_SHARE for cost in run.effect_costs)
    return {"names": names, "rows": rows, "asked": ASKED_SHARE, "dear": dear}


def _anchor(check: str) -> str:
    """Where on the page a named check stands."""
    kind, _, name = check.partition(" ")
    if check.startswith("hard case "):
        return f"hard-{slug(check.removeprefix('hard case '))}"
    places = {
        "order": "convergence", "property": "properties", "locking": "locking", "slenderness": "locking",
        "remedies": "locking", "work-precision": "work", "part": "environment",
        "reference": "reference-checks",
    }  # fmt: skip
    return f"case-{slug(name)}" if kind == "case" else places.get(kind, "")
