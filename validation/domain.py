"""The domain of validity: what the cases that passed have really tried, and whether a scene lies inside it.

A scene is inside when cases that passed had all of its loads at once, perhaps with others, on a rod made of
the same, and when a single one of them was at least as hard in every number: Poisson ratio, curvature, turn,
turn of an element, section force, strain, and the size of every load (load_numbers.py). A box would claim the
largest curvature at the hardest material and on the coarsest mesh, and two loads at once because each was
tried alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from validation.regime import HARDNESS, SETTINGS, regime_of, regimes

if TYPE_CHECKING:
    from ancf.scene import Scene
    from ancf.solution import Solution

# What is measured on a solution may be this much below what caused it: a moment at an integration point.
ROUNDING = 1.01
FLOOR = 1e-6  # below which a measured number is rounding: the force in a rod under moments
EXACT = 1.0 + 2e-6  # what a scene says is known to six digits
MEASURED = frozenset(
    {"kappa_R", "turn", "turn_per_element", "turn_by_aspect", "thrust", "strain", "slenderness", "flatness"}
)
ROD = ("element", "formulation", "law")
KEY = (*ROD, "loads", *SETTINGS)
JOINT = " + "  # between the families of an entry
SHOWN = 3  # numbers that left few cases, in a reason
RANGES = {"slenderness": "L/R", "flatness": "flatness", "poisson_ratio": "poisson_ratio"}
WORDS = {
    "poisson_ratio": "poisson_ratio", "kappa_R": "kappa R", "turn": "turn [rad]",
    "turn_per_element": "turn of an element [rad]",
    "turn_by_aspect": "turn of an element times its length over R",
    "reference_turn": "turn of the unstressed rod [rad]", "tolerance": "tolerance of the solver",
    "thrust": "section force N L2/EI", "strain": "largest strain",
}  # fmt: skip


def domain_of(certified: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """What was tried, for each element, formulation, law, set of loads and make, by the cases that passed.

    Returns
    -------
    Records with the names of `KEY`, loads joined by " + "; [smallest, largest] elements, slenderness,
    flatness and poisson_ratio; ``numbers``: names of the numbers, `HARDNESS` and those of the loads;
    ``front``: the hardest cases, in that order, none of which is exceeded by another in all.
    """
    groups: dict[tuple[str, ...], list[Mapping[str, Any]]] = {}
    for regime in certified:
        if regime["loads"]:
            names = {**regime, "loads": JOINT.join(regime["loads"])}
            groups.setdefault(tuple(names[key] for key in KEY), []).append(regime)
    found = []
    for names, group in sorted(groups.items()):
        entry: dict[str, Any] = dict(zip(KEY, names, strict=True))
        for key in ("elements", *RANGES):
            values = [short(regime[key]) for regime in group]
            entry[key] = [min(values), max(values)]
        cases = [_numbers(regime) for regime in group]
        entry["numbers"] = [*HARDNESS, *sorted({name for case in cases for name in case} - {*HARDNESS})]
        entry["front"] = _front([[case.get(name, 0.0) for name in entry["numbers"]] for case in cases])
        found.append(entry)
    return found


def outside(domain: Iterable[Mapping[str, Any]], scene: Scene, solution: Solution | None = None) -> list[str]:
    """Why a scene is not inside the domain, one sentence each; empty when it is.

    Without a solution, curvature and turn are judged for rods under moments alone, strain is not, and for
    any other load a sentence says that the solution is needed, as for a scene that asks for an accuracy.
    """
    if solution is None and scene.solver.accuracy is not None:
        return ["the mesh is chosen when the scene is solved, so its solution is needed"]
    domain = list(domain)
    known = regimes(solution) if solution is not None else [regime_of(rod, scene) for rod in scene.rods]
    reasons = [] if solution is None else _unfit(solution)
    if scene.joints:
        reasons.append("the rods are joined or moved, and the domain is that of rods on supports")
    if scene.stability is not None and scene.stability.branch != "primary":
        reasons.append(f"no case that passed follows the {scene.stability.branch} branch")
    for rod, here in zip(scene.rods, known, strict=True):
        if not here["loads"]:
            continue
        if not here["known"]:
            reasons.append(f"rod {rod.name!r}: how hard these loads bend it is known only once it is solved")
        reasons += [f"rod {rod.name!r}{text}" for text in _beyond(domain, here)]
    return reasons


def short(value: float) -> float:
    """Six digits: what two machines agree in."""
    return value if isinstance(value, int) else float(f"{value:.6g}")


def _unfit(solution: Solution) -> list[str]:
    """Why nothing vouches for a solution, wherever it lies."""
    found = []
    if solution.status.value != "converged":
        found.append(f"there is no equilibrium to vouch for: {solution.status.value}")
    if solution.stable is False:
        found.append("the equilibrium is unstable")
    return found


def _beyond(domain: Iterable[Mapping[str, Any]], here: Mapping[str, Any]) -> list[str]:
    """What of a regime lies outside the domain, each behind the name of its rod."""
    rod = ", ".join(here[key] for key in ROD)
    loads = {*here["loads"]}
    of_rod = [entry for entry in domain if all(entry[key] == here[key] for key in ROD)]
    tried = {load for entry in of_rod for load in entry["loads"].split(JOINT)}
    if not loads <= tried:
        return [f": no case that passed has {rod}, {load}" for load in sorted(loads - tried)]
    entries = [entry for entry in of_rod if loads <= {*entry["loads"].split(JOINT)}]
    together = JOINT.join(sorted(loads))
    if not entries:
        return [f": no case that passed has {rod} and {together} at once"]
    for name in SETTINGS:
        words = sorted({entry[name] for entry in entries})
        if here[name] not in words:
            return [f", {together}: {name} {here[name]} is not among {'; '.join(words)}"]
        entries = [entry for entry in entries if entry[name] == here[name]]
    found = []
    for name, word in RANGES.items():
        low = min(entry[name][0] for entry in entries)
        high = max(entry[name][1] for entry in entries)
        slack = _slack(name)
        if not low / slack <= short(here[name]) <= high * slack:
            found.append(f"{word} {here[name]:.4g} is outside {low:.4g} to {high:.4g}")
    fewest = min(entry["elements"][0] for entry in entries)
    if here["elements"] < fewest:
        found.append(f"{here['elements']} elements are fewer than {fewest}")
    cases = [dict(zip(entry["numbers"], case, strict=True)) for entry in entries for case in entry["front"]]
    return [f", {together}: {text}" for text in found or _too_hard(cases, _numbers(here))]


def _too_hard(cases: list[dict[str, float]], here: Mapping[str, float]) -> list[str]:
    """Whether no single case was as hard, and the first number that no case so far had."""
    passed: list[str] = []
    for name, value in here.items():
        floor = FLOOR if name in MEASURED else 0.0
        enough = [case for case in cases if value <= case.get(name, 0.0) * _slack(name) + floor]
        word = WORDS.get(name, name)
        if not enough:
            most = max(case.get(name, 0.0) for case in cases)
            given = f" with {', '.join(passed[-SHOWN:])}" if passed else ""
            return [f"{word} {value:.3g} is above {most:.3g}, the most tried{given}"]
        if len(enough) < len(cases):
            passed.append(f"{word} >= {value:.3g}")
        cases = enough
    return []


def _numbers(regime: Mapping[str, Any]) -> dict[str, float]:
    """`HARDNESS` as far as it is known, then the numbers of the loads."""
    known = {name: short(regime[name]) for name in HARDNESS if name in regime}
    return known | {name: short(value) for name, value in sorted(regime["numbers"].items())}


def _slack(name: str) -> float:
    return ROUNDING if name in MEASURED else 1.0 if name == "poisson_ratio" else EXACT


def _front(cases: list[list[float]]) -> list[list[float]]:
    """Cases that no other exceeds or equals in every number, in rising order."""
    distinct = sorted({tuple(case) for case in cases})
    return [
        list(case)
        for case in distinct
        if not any(
            other != case and all(o >= c for o, c in zip(other, case, strict=True)) for other in distinct
        )
    ]
