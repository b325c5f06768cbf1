"""The domain of validity: what the cases that passed have really tried, and whether a scene lies inside it.

A scene is inside when, for every family of its loads, all that it is made of was tried, and one single case
was at least as hard in every respect: Poisson ratio, curvature, turn, turn of an element, strain. A box would
claim the largest curvature at the hardest material and on the coarsest mesh.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from validation.regime import HARDNESS, SETTINGS, regime_of, regimes

if TYPE_CHECKING:
    from ancf.scene import Scene
    from ancf.solution import Solution

# A moment found at an integration point may be this much below the load that caused it.
ROUNDING = 1.01
KEY = ("element", "formulation", "law", "load")
RANGES = {"slenderness": "L/R", "flatness": "flatness", "poisson_ratio": "poisson_ratio"}
WORDS = {
    "poisson_ratio": "poisson_ratio", "kappa_R": "kappa R", "turn": "turn [rad]",
    "turn_per_element": "turn of an element [rad]", "strain": "largest strain",
}  # fmt: skip


def domain_of(certified: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """What was tried, for each element, formulation, law and load family, over the regimes of passed cases.

    Returns
    -------
    Records with the four names; ``tried``: by setting, the words tried; [smallest, largest] elements,
    slenderness, flatness and poisson_ratio; ``front``: the hardest cases, as numbers in the order of
    `HARDNESS`, none of which is exceeded by another in all.
    """
    groups: dict[tuple[str, ...], list[Mapping[str, Any]]] = {}
    for regime in certified:
        for load in regime["loads"]:
            names = {**regime, "load": load}
            groups.setdefault(tuple(names[key] for key in KEY), []).append(regime)
    found = []
    for names, group in sorted(groups.items()):
        entry: dict[str, Any] = dict(zip(KEY, names, strict=True))
        entry["tried"] = {name: sorted({regime[name] for regime in group}) for name in SETTINGS}
        for key in ("elements", *RANGES):
            values = [short(regime[key]) for regime in group]
            entry[key] = [min(values), max(values)]
        entry["front"] = _front([[short(regime[name]) for name in HARDNESS] for regime in group])
        found.append(entry)
    return found


def outside(domain: Iterable[Mapping[str, Any]], scene: Scene, solution: Solution | None = None) -> list[str]:
    """Why a scene is not inside the domain, one sentence each; empty when it is.

    Without a solution, curvature and turn are judged for rods under moments alone, strain is not, and for
    any other load a sentence says that the solution is needed, as for a scene that asks for an accuracy.
    """
    if solution is None and scene.solver.accuracy is not None:
        return ["the mesh is chosen when the scene is solved, so its solution is needed"]
    entries = {tuple(entry[key] for key in KEY): entry for entry in domain}
    known = regimes(solution) if solution is not None else [regime_of(rod, scene) for rod in scene.rods]
    reasons = [] if solution is None else _unfit(solution)
    if scene.joints:
        reasons.append("the rods are joined or moved, and the domain is that of rods on supports")
    for rod, here in zip(scene.rods, known, strict=True):
        if not here["known"]:
            reasons.append(f"rod {rod.name!r}: how hard these loads bend it is known only once it is solved")
        for load in here["loads"]:
            names = tuple({**here, "load": load}[key] for key in KEY)
            entry = entries.get(names)
            if entry is None:
                reasons.append(f"rod {rod.name!r}: no case that passed has {', '.join(names)}")
            else:
                reasons += [f"rod {rod.name!r}, {load}: {text}" for text in _beyond(entry, here)]
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


def _beyond(entry: Mapping[str, Any], here: Mapping[str, Any]) -> list[str]:
    """What of a regime lies outside one entry of the domain."""
    found = [
        f"{name} {here[name]} is not among {'; '.join(entry['tried'][name])}"
        for name in SETTINGS
        if here[name] not in entry["tried"][name]
    ]
    for name, word in RANGES.items():
        low, high = entry[name]
        slack = 1.0 if name == "poisson_ratio" else ROUNDING
        if not low / slack <= short(here[name]) <= high * slack:
            found.append(f"{word} {here[name]:.4g} is outside {low:.4g} to {high:.4g}")
    if here["elements"] < entry["elements"][0]:
        found.append(f"{here['elements']} elements are fewer than {entry['elements'][0]}")
    return found or _too_hard(entry["front"], here)


def _too_hard(front: Iterable[Iterable[float]], here: Mapping[str, Any]) -> list[str]:
    """Whether no single case was as hard, and the first number that no case so far had."""
    cases = [dict(zip(HARDNESS, case, strict=True)) for case in front]
    asked = {name: short(here[name]) for name in HARDNESS if name in here}
    passed: list[str] = []
    for name, value in asked.items():
        slack = 1.0 if name == "poisson_ratio" else ROUNDING
        enough = [case for case in cases if value <= case[name] * slack]
        if not enough:
            most = max(case[name] for case in cases)
            given = f" with {', '.join(passed)}" if passed else ""
            return [f"{WORDS[name]} {value:.3g} is above {most:.3g}, the most tried{given}"]
        cases = enough
        passed.append(f"{WORDS[name]} >= {value:.3g}")
    return []


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
