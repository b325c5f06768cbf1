"""Measure the families: every element in `ancf.elements`, its formulations, meshes, solver settings."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from ancf.elements import ELEMENTS, Element
from validation.cost.families import Family, Reference, families
from validation.cost.limits import ladder_limit
from validation.cost.others import absent_references, reference_points
from validation.cost.peers import absent_peers, peer_points
from validation.cost.points import CostPoint, beam_point

MESHES = (2, 4, 8, 16, 32)
MESHES_FULL = (*MESHES, 64)
# Where other solver settings are compared, in a quick run of one element only.
COMPARED_ELEMENT = "3333"
COMPARED, COMPARED_FULL = (8,), (4, 16)
COMPARED_FORMULATION = (8, 32)  # its floor is wanted too
PEER_MESHES, PEER_MESHES_FULL = (8, 32), (4, 8, 16, 32)
REPEATS, REPEATS_FULL = 3, 5
FREE_CLAMP = [{"at": 0.0, "kind": "free_section_clamp"}]


@dataclass(frozen=True)
class Floor:
    """Error, by the length, that no mesh of a model removes, and how well the ladder of meshes knows it."""

    model: str
    formulation: str
    error: float
    bar: float
    order: float | None


@dataclass(frozen=True)
class FamilyCost:
    """All that was measured of one family.

    Parameters
    ----------
    reference_position : tip (3,) by the length; None for a component that the reference does not give
    thickness : distance of the infinitely thin rod from the reference; None where that says nothing
    omissions : models that were left out, or failed, and why
    """

    name: str
    problem: str
    reference: str
    reference_kind: str
    reference_source: str
    reference_error: float
    reference_position: list[float | None]
    thickness: float | None
    points: list[CostPoint] = field(default_factory=list)
    floors: list[Floor] = field(default_factory=list)
    omissions: list[str] = field(default_factory=list)
    seconds: float = 0.0

    def finest(self, model: str) -> CostPoint | None:
        """The finest mesh of a model with its default settings, whatever came of it; None: no such model."""
        first = next((p for p in self.points if p.model == model), None)
        if first is None:
            return None
        return max((p for p in self.points if p.setting == first.setting), key=lambda p: p.elements)


def measure_all(
    full: bool = False, progress: Callable[[str, int, int], None] | None = None
) -> list[FamilyCost]:
    """All families; `progress` is called with the family's name, how many are done and of how many."""
    found, every = [], families()
    for done, family in enumerate(every):
        if progress is not None:
            progress(family.name, done, len(every))
        found.append(measure(family, full))
    return found


def measure(family: Family, full: bool = False) -> FamilyCost:
    """Every model of one family on its meshes."""
    started = time.process_time()
    reference = family.find_reference(family.scene)
    omissions = absent_references(family, reference) + absent_peers(family, full)
    points = list(reference_points(family, reference, full))
    for element in ELEMENTS.values():
        points += _beams(family, reference, element, full, omissions)
    peers = PEER_MESHES_FULL if full else PEER_MESHES
    points += peer_points(family, reference, peers, REPEATS_FULL if full else REPEATS, full)
    points, floors = _with_limits(family, reference, points)
    omissions += [f"{point.label}, {point.mesh}: {point.status}" for point in points if not point.converged]
    return FamilyCost(
        name=family.name,
        problem=family.problem,
        reference=reference.name,
        reference_kind=reference.kind,
        reference_source=reference.source,
        reference_error=reference.error,
        reference_position=[None if math.isnan(v) else v for v in reference.position],
        thickness=reference.thickness,
        points=points,
        floors=floors,
        omissions=omissions,
        seconds=time.process_time() - started,
    )


@dataclass(frozen=True)
class Setting:
    """How a beam is solved: settings of the rod, of the solver, meshes, and the name of the model."""

    formulation: str
    rod: dict[str, Any]
    solver: dict[str, Any]
    meshes: tuple[int, ...]


def settings(element: Element, family: Family, full: bool) -> Iterator[Setting]:
    """The settings of an element in a family, its default one first."""
    meshes = MESHES_FULL if full else MESHES
    rod: dict[str, Any] = {"element": element.name}
    if element.quadratic_section:
        rod["supports"] = FREE_CLAMP  # as the references: their sections contract at the clamp
    first = element.formulations[0]
    default = rod | {"formulation": first}
    yield Setting(first, default, {}, meshes)
    for name, more in family.variants.items():
        yield Setting(name, default | dict(more), {}, meshes)
    for other in element.formulations[1:]:
        yield Setting(other, rod | {"formulation": other}, {}, meshes if full else COMPARED_FORMULATION)
    if full or element.name == COMPARED_ELEMENT:
        meshes = COMPARED_FULL if full else COMPARED
        yield Setting(first, default, {"predictor": "none"}, meshes)
        yield Setting(first, default, {"tangent": "finite-difference"}, meshes)


def _beams(
    family: Family, reference: Reference, element: Element, full: bool, omissions: list[str]
) -> Iterator[CostPoint]:
    """Points of one element; a setting that the element refuses becomes an omission."""
    for setting in settings(element, family, full):
        for elements in setting.meshes:
            data = family.with_rod(solver=setting.solver, elements=elements, **setting.rod)
            point, solution = beam_point(data, REPEATS_FULL if full else REPEATS)
            point = replace(point, formulation=setting.formulation)
            if solution is None:
                omissions.append(f"{point.label}: {point.status}")
                break
            if point.converged:
                point = replace(point, error=family.error(solution.tip().position, reference))
            yield point


def _with_limits(
    family: Family, reference: Reference, points: list[CostPoint]
) -> tuple[list[CostPoint], list[Floor]]:
    """Split each error: what the mesh leaves, and the floor that no mesh of the model removes."""
    limits: dict[tuple[str, str], np.ndarray] = {}
    floors = []
    for key in dict.fromkeys((p.model, p.formulation) for p in points if p.kind in ("beam", "peer", "solid")):
        ladder = [p for p in points if (p.model, p.formulation) == key and p.converged]
        # The finest mesh may have been solved with the default settings only.
        ladder = [p for p in ladder if (p.tangent, p.predictor) == (ladder[0].tangent, ladder[0].predictor)]
        limit = ladder_limit([p.elements for p in ladder], [np.array(p.position) for p in ladder])
        if limit is None:
            continue
        limits[key] = limit.value
        error = family.error(limit.value * family.length, reference)
        floors.append(Floor(*key, error, limit.bar, limit.order))
    split = [
        replace(
            p, discretisation=float(np.linalg.norm(np.array(p.position) - limits[p.model, p.formulation]))
        )
        if p.converged and (p.model, p.formulation) in limits
        else p
        for p in points
    ]
    return split, floors
