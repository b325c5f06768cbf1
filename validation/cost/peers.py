"""Other people's programs on the same tasks, where they are installed: Exudyn (extra `peers`), Soromox.

Each gets the plain rod (E A, G A, G J, E I), the same loads, one thread, its own best settings for statics;
its model is built anew for every solve, as `ancf.solve` does, and the time of building is told apart.
"""

from __future__ import annotations

import importlib.util
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from validation.cost import peer_soromox
from validation.cost.families import Family, Reference
from validation.cost.points import ENOUGH, CostPoint, elements_text
from validation.scenes import changed, stiffness_of

Floats = NDArray[np.float64]

EXUDYN = ("ANCFCable2D", "ANCFCable", "GeometricallyExactBeam", "ANCFBeam")
LOAD_STEPS = (1, 4, 16, 64)  # the first that converges is taken, and its time counted
NEWTON_TOLERANCE = 1e-8  # relative, Exudyn's own default


@dataclass(frozen=True)
class PeerAnswer:
    """Tip (3,) [m] (None: no equilibrium), unknowns, load steps, CPU seconds of building and of solving."""

    position: Floats | None
    unknowns: int
    steps: int
    build: float
    solve: float


def absent_peers(family: Family, full: bool) -> list[str]:
    """Why a peer is not on the axes of a family, in words."""
    reasons = []
    if not installed("exudyn"):
        reasons.append("exudyn: not installed (pip install 'ancf[peers]')")
    elif not _same_everywhere(family):
        reasons.append(f"exudyn: {_why_not(family)}")
    else:
        reasons += [f"exudyn {kind}: {why}" for kind in EXUDYN if (why := _cannot(kind, family))]
    if not installed("soromox"):
        reasons.append("soromox: not installed (it needs jax)")
    else:
        reasons += soromox_reasons(family, full)
    return reasons


def soromox_reasons(family: Family, full: bool) -> list[str]:
    """Why Soromox, although installed, is not on the axes of a family; [] where it is."""
    if family.name not in peer_soromox.FAMILIES:
        return [f"soromox: taken for {' and '.join(peer_soromox.FAMILIES)} only"]
    return [] if full else ["soromox: compiles half a minute for every mesh; in the full run"]


def installed(package: str) -> bool:
    """Whether a package can be imported; it is not."""
    return importlib.util.find_spec(package) is not None


def peer_points(
    family: Family, reference: Reference, meshes: tuple[int, ...], repeats: int, full: bool
) -> Iterator[CostPoint]:
    """All peers that can take a family, over the meshes."""
    if installed("soromox") and not soromox_reasons(family, full):
        yield from peer_soromox.soromox_points(family, reference, repeats)
    if not installed("exudyn") or not _same_everywhere(family):
        return
    for kind in EXUDYN:
        if _cannot(kind, family):
            continue
        for elements in meshes:
            yield _exudyn_point(kind, family, reference, elements, repeats)


def _same_everywhere(family: Family) -> bool:
    return not _why_not(family)


def _why_not(family: Family) -> str:
    rod = family.scene["rod"][0]
    if rod["material"].get("law", "saint-venant-kirchhoff") != "saint-venant-kirchhoff":
        return "its beams have linear material"
    if any(rod.get("curvature", ())):
        return "curved references were not set up for it"
    if rod["section"]["shape"] != "circle":
        return "strips were not set up for it"
    return ""


def _cannot(kind: str, family: Family) -> str:
    """Why one of Exudyn's elements cannot take the loads of a family; "" where it can."""
    if family.scene.get("moment") and kind != "GeometricallyExactBeam":
        return "takes no couple on a node"
    return ""


def _exudyn_point(kind: str, family: Family, reference: Reference, elements: int, repeats: int) -> CostPoint:
    about: dict[str, Any] = {
        "model": f"exudyn {kind}", "kind": "peer", "formulation": "", "elements": elements,
        "mesh": elements_text(elements), "tangent": "analytic", "predictor": "none",
    }  # fmt: skip
    try:
        found = _settle(lambda steps: solve_exudyn(kind, family, elements, steps))
        runs = [found]
        while (
            found.position is not None
            and len(runs) < repeats
            and sum(r.build + r.solve for r in runs) < ENOUGH
        ):
            runs.append(solve_exudyn(kind, family, elements, found.steps))
    except Exception as error:  # another program's failure is a finding, whatever its kind
        return CostPoint(**about, status=f"failed: {type(error).__name__}: {str(error).strip()[:200]}")
    if found.position is None:
        return CostPoint(
            **about, status=f"not converged in {found.steps} load steps", unknowns=found.unknowns
        )
    seconds = [run.build + run.solve for run in runs]
    best = min(runs, key=lambda run: run.build + run.solve)
    return CostPoint(
        **about,
        status="converged",
        position=(found.position / family.length).tolist(),
        unknowns=found.unknowns,
        steps=found.steps,
        error=family.error(found.position, reference),
        fastest=min(seconds),
        median=float(np.median(seconds)),
        repeats=len(seconds),
        parts={"setup": best.build, "rest": best.solve},
    )


def _settle(solve: Callable[[int], PeerAnswer]) -> PeerAnswer:
    """The answer in the fewest load steps that converge."""
    found = solve(LOAD_STEPS[0])
    for steps in LOAD_STEPS[1:]:
        if found.position is not None:
            break
        found = solve(steps)
    return found


def solve_exudyn(kind: str, family: Family, elements: int, steps: int) -> PeerAnswer:
    """One static solution with Exudyn; a planar element gets the load turned into its plane."""
    import exudyn as exu
    import exudyn.itemInterface as items

    started = process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        exu.config.printToConsole = False
        container = exu.SystemContainer()
        system: Any = container.AddSystem()  # its stubs name the wrong types
        nodes, back = _rod_in_exudyn(exu, items, system, kind, family, elements)
        system.Assemble()
        settings = exu.SimulationSettings()
        settings.solution.file.write = False
        settings.parallel.numberOfThreads = 1
        static = settings.staticSolver
        # Its own bisection of steps may take minutes where an element is too coarse.
        static.verboseMode, static.numberOfLoadSteps, static.adaptiveStep = 0, steps, False
        static.newton.relativeTolerance, static.newton.maxIterations = NEWTON_TOLERANCE, 50
        # Dense below some hundred unknowns is Exudyn's own advice.
        kinds = exu.LinearSolverType
        settings.linearSolver.solverType = kinds.EXUdense if elements <= 8 else kinds.EigenSparse
        built = process_time()
        try:
            converged = system.SolveStatic(settings)
        except (ValueError, RuntimeError):
            converged = False
        solved = process_time()
        tip = np.array(system.GetNodeOutput(nodes[-1], exu.OutputVariableType.Position), float)
        unknowns = len(system.systemData.GetODE2Coordinates())
    position = back @ tip if converged and np.all(np.isfinite(tip)) else None
    return PeerAnswer(position, unknowns, steps, built - started, solved - built)


def _rod_in_exudyn(
    exu: Any, items: Any, system: Any, kind: str, family: Family, elements: int
) -> tuple[list[int], Floats]:
    """Build a clamped rod with its loads; its nodes, and the rotation (3, 3) to the family's axes."""
    rod = stiffness_of(changed(family.scene, {"elements": 1}))
    EI, GJ, EA, GA = rod.EI, rod.GJ, rod.EA, 2.0 * rod.GJ / rod.radius**2
    h, area = rod.length / elements, np.pi * rod.radius**2
    density = float(family.scene["rod"][0]["material"].get("density", 1000.0))
    section = exu.BeamSection()
    section.stiffnessMatrix = np.diag([EA, GA, GA, GJ, EI, EI])
    section.massPerLength = density * area
    section.inertia = density * rod.EI / EA * area * np.diag([2.0, 1.0, 1.0])
    make_node, fixed = {
        "ANCFCable2D": (lambda x: items.NodePoint2DSlope1(referenceCoordinates=[x, 0, 1, 0]), (0, 1, 3)),
        "ANCFCable": (
            lambda x: items.NodePointSlope1(referenceCoordinates=[x, 0, 0, 1, 0, 0]),
            (0, 1, 2, 4, 5),
        ),
        "GeometricallyExactBeam": (
            # Tait-Bryan angles: of its rotations the one that solves the helix, in 64 load steps.
            lambda x: items.NodeRigidBodyRxyz(referenceCoordinates=[x, 0, 0, 0, 0, 0]),
            range(6),
        ),
        "ANCFBeam": (
            lambda x: items.NodePointSlope23(referenceCoordinates=[x, 0, 0, 0, 1, 0, 0, 0, 1]),
            range(9),
        ),
    }[kind]
    cable = {"bendingStiffness": EI, "axialStiffness": EA, "massPerLength": density * area}
    # Reduced integration: full integration locks (Gerstmayr, Irschik 2008).
    cable |= {"length": h, "useReducedOrderIntegration": 1}
    make_element, given = {
        "ANCFCable2D": (items.ObjectANCFCable2D, cable),
        "ANCFCable": (items.ObjectANCFCable, cable),
        "GeometricallyExactBeam": (items.ObjectBeamGeometricallyExact, {"length": h, "sectionData": section}),
        "ANCFBeam": (items.ObjectANCFBeam, {"length": h, "sectionData": section}),
    }[kind]
    nodes = [system.AddNode(make_node(h * i)) for i in range(elements + 1)]
    bodies = [system.AddObject(make_element(nodeNumbers=list(pair), **given)) for pair in pairwise(nodes)]
    ground = system.AddMarker(
        items.MarkerNodeCoordinate(nodeNumber=system.AddNode(items.NodePointGround()), coordinate=0)
    )
    for coordinate in fixed:
        marker = system.AddMarker(items.MarkerNodeCoordinate(nodeNumber=nodes[0], coordinate=coordinate))
        system.AddObject(items.ObjectConnectorCoordinate(markerNumbers=[ground, marker]))
    back = _into_plane(family)
    for force in family.scene.get("force", []):
        marker = system.AddMarker(items.MarkerNodePosition(nodeNumber=nodes[-1]))
        system.AddLoad(items.LoadForceVector(markerNumber=marker, loadVector=list(back.T @ force["value"])))
    for moment in family.scene.get("moment", []):
        marker = system.AddMarker(items.MarkerNodeRigid(nodeNumber=nodes[-1]))
        system.AddLoad(items.LoadTorqueVector(markerNumber=marker, loadVector=list(back.T @ moment["value"])))
    if "gravity" in family.scene:
        weight = list(back.T @ family.scene["gravity"]["acceleration"])
        for body in bodies:
            marker = system.AddMarker(items.MarkerBodyMass(bodyNumber=body))
            system.AddLoad(items.LoadMassProportional(markerNumber=marker, loadVector=weight))
    return nodes, back


def _into_plane(family: Family) -> Floats:
    """Rotation (3, 3) about the rod that brings a planar model's y axis to the family's force."""
    forces = [f["value"] for f in family.scene.get("force", [])]
    if "gravity" in family.scene:
        forces.append(family.scene["gravity"]["acceleration"])
    if not forces:
        return np.eye(3)
    across = np.array([0.0, *forces[0][1:]])
    y = across / np.linalg.norm(across)
    return np.column_stack([[1.0, 0.0, 0.0], y, np.cross([1.0, 0.0, 0.0], y)])
