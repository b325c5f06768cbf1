"""What each effect costs: calls and time in the example scenes, and its assembly against the elastic one.

Times in scenes are of the wall clock, by the counters of one solve; those of assemblies are CPU times, the
fastest of several.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import ancf
from ancf.effect_assembly import blocks_of
from ancf.model import Model
from ancf.scene import Scene

HERE = Path(__file__).parent
# The scenes of the interface; the examples are there in a checkout only.
FOLDERS = (HERE / "contract_scenes", HERE.parent / "examples")
ELEMENTS = (8, 16, 200)
ASKED = 0.2  # of the elastic assembly, which an effect may cost (issue "effects", numbers)
LARGE = 2**21
REPEATS = {8: 30, 16: 30, 200: 15}


@dataclass(frozen=True)
class SceneCalls:
    """Which effects a solve called, how often, and milliseconds by iteration."""

    scene: str
    status: str
    iterations: int
    calls: dict[str, int]
    milliseconds: dict[str, float]


@dataclass(frozen=True)
class EffectCost:
    """CPU time of one assembly of an effect, tangent included, by that of the elastic assembly."""

    effect: str
    elements: int
    milliseconds: float
    elastic: float  # milliseconds

    @property
    def ratio(self) -> float:
        """Cost by that of the rods themselves."""
        return self.milliseconds / self.elastic


def scene_files() -> list[Path]:
    """The scenes of the table, those of the interface first."""
    return [path for folder in FOLDERS for path in sorted(folder.glob("*.toml"))]


def scene_calls() -> Iterator[SceneCalls]:
    """Solve every scene and read its counters."""
    for path in scene_files():
        solution = ancf.solve(ancf.load_scene(path))
        count = max(solution.iterations, 1)
        yield SceneCalls(
            scene=path.stem,
            status=str(solution.status),
            iterations=solution.iterations,
            calls={name: int(found["calls"]) for name, found in solution.effects.items()},
            milliseconds={name: 1e3 * found["seconds"] / count for name, found in solution.effects.items()},
        )


_EI = 1e6 * np.pi * 0.01**4 / 4
# One effect each, on a rod of 0.4 m and radius 1 cm.
ALONE: dict[str, dict[str, Any]] = {
    "force": {"force": [{"value": [0, 2 * _EI, 0]}]},
    "force, follower": {"force": [{"value": [0, 2 * _EI, 0], "direction": "follower"}]},
    "moment": {"moment": [{"value": [0, 0, _EI]}]},
    "gravity": {"gravity": {"acceleration": [0, 0, -0.1]}},
    "line_load": {"line_load": [{"value": [0, 2 * _EI, 0]}]},
    "line_load, follower": {"line_load": [{"value": [0, 2 * _EI, 0], "direction": "follower"}]},
    "line_moment": {"line_moment": [{"value": [0, 0, 2 * _EI]}]},
    "magnet": {"magnet": [{"remanence": [0.1, 0, 0], "field": [0, 0.005, 0]}]},
    "tendon": {"tendon": [{"tension": 0.3, "path": [[0, 0.005, 0], [1, 0.005, 0]]}]},
    "spring": {"spring": [{"stiffness": 10.0}]},
    "spring, rotational": {"spring": [{"rotational_stiffness": _EI}]},
    "foundation": {"foundation": [{"stiffness": 10.0}]},
    "foundation, rotational": {"foundation": [{"rotational_stiffness": _EI}]},
    "pressure": {"pressure": [{"value": 1e3, "chamber": {"centre": [0.003, 0], "radius": 0.004}}]},
}


def effect_costs() -> Iterator[EffectCost]:
    """Every effect alone, on a coarse and a fine mesh."""
    np.zeros(LARGE)  # freed at once: from then on arrays of this size are kept, and not fetched page by page
    for count in ELEMENTS:
        for name, tables in ALONE.items():
            yield measure(name, one_rod(count, tables), REPEATS[count])


def one_rod(elements: int, tables: dict[str, Any]) -> Scene:
    """The rod of `ALONE` under some tables."""
    rod = {
        "length": 0.4,
        "elements": elements,
        "section": {"shape": "circle", "radius": 0.01},
        "material": {"young_modulus": 1e6, "poisson_ratio": 0.3, "density": 1000.0},
    }
    return ancf.scene_from_dict({"rod": [rod], **tables})


def measure(name: str, scene: Scene, repeats: int) -> EffectCost:
    """Assembly of forces and tangent of the effects of a scene, and of its rods, at a bent shape."""
    model, bare = Model(scene), Model(one_rod(scene.rods[0].elements, {}))
    way = np.random.default_rng(0).uniform(-1e-3, 1e-3, model.n)
    q = model.q0 + way * model.unit
    sums, flat = model._effect_sums, np.zeros(model.pattern.entries)
    Q_int, Q_ext = np.zeros((2, model.n))
    for effect in model.effects:  # what is made at the first call
        effect.force(blocks_of(q, effect.dofs))
    own = _fastest(lambda: sums.terms(Q_int, Q_ext, flat, q, 1.0), repeats)
    elastic = _fastest(lambda: bare.residual_and_tangent(q, 1.0), repeats)
    return EffectCost(name, scene.rods[0].elements, own, elastic)


def _fastest(work: Callable[[], object], repeats: int) -> float:
    """CPU milliseconds of the fastest of some calls."""
    work()
    seconds = []
    for _ in range(repeats):
        started = time.process_time()
        work()
        seconds.append(time.process_time() - started)
    return 1e3 * min(seconds)


def call_table(rows: list[SceneCalls]) -> tuple[list[str], list[tuple[SceneCalls, list[str]]]]:
    """Effects (columns), and for each scene a text for each of them: calls and milliseconds, "-" if never."""
    names = list(dict.fromkeys(name for row in rows for name in row.calls))
    return names, [
        (
            row,
            [
                f"{row.calls[name]} × {row.milliseconds[name]:.2g} ms" if name in row.calls else "-"
                for name in names
            ],
        )
        for row in rows
    ]
