"""Applied and reaction forces balance in random scenes of every effect, on each rod and as a whole."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from hypothesis import event, given, settings, strategies as st

import ancf
from tests.strategies import fewer, vectors

BALANCE = 1e-10  # issue "effects", numbers: of the larger of the load and E I/L^2, plus the float64 floor

L, R, E = 0.5, 0.01, 1e6
EI = E * math.pi * R**4 / 4


def effects(draw: st.DrawFn, rod: str) -> dict[str, list[dict[str, Any]]]:
    """Loads of any kind on one rod, of the size that bends it by a radian or less."""

    def size(unit: float) -> list[float]:
        return (unit * draw(vectors())).tolist()

    directions, places = st.sampled_from(["fixed", "follower"]), st.sampled_from([0.3, 0.5, 1.0])
    share = st.floats(0.0, 1.0, allow_subnormal=False)
    offset = [0.4 * R, -0.3 * R]
    makers = {
        "force": lambda: {
            "value": size(EI / L**2),
            "at": draw(places),
            "offset": draw(st.sampled_from([[0.0, 0.0], offset])),
        },
        "moment": lambda: {
            "value": size(0.7 * EI / L),
            "at": draw(places),
            "definition": draw(st.sampled_from(["section", "vorticity"])),
        },
        "line_load": lambda: {"value": size(EI / L**3)},
        "line_moment": lambda: {"value": size(EI / L**2)},
        "magnet": lambda: {"remanence": size(0.1), "field": size(0.02)},
        "tendon": lambda: {
            "tension": draw(share) * EI / (L * R),
            "path": [[0.0, 0.6 * R, 0.0], [0.55, 0.0, -0.5 * R], [1.0, -0.2 * R, 0.6 * R]],
        },
        "spring": lambda: {
            "at": draw(places),
            "offset": offset,
            "stiffness": [0.0, draw(share) * EI / L**3, 0.0],
            "rotational_stiffness": [draw(share) * EI / L for _ in range(3)],
        },
        "foundation": lambda: {
            "rotational_stiffness": [draw(share) * EI / L**2 for _ in range(3)],
            "frame": "section",
            "from": 0.2,
        },
        "pressure": lambda: {
            "value": (2.0 * draw(share) - 1.0) * 0.02 * E,
            "from": 0.1,
            "to": 0.9,
            "chamber": {"centre": [0.4 * R, 0.0], "radius": 0.4 * R},
        },
    }
    found: dict[str, list[dict[str, Any]]] = {}
    for name in draw(st.lists(st.sampled_from(sorted(makers)), min_size=1, max_size=3, unique=True)):
        load = {"rod": rod, **makers[name]()}
        if name in ("force", "moment", "line_load", "line_moment"):
            load["direction"] = draw(directions)
        found[name] = [load]
    return found


@st.composite
def scenes(draw: st.DrawFn) -> dict[str, Any]:
    """One rod, or two that a joint holds together, the second perhaps held by the ground and moved."""
    element = draw(st.sampled_from(["3333", "3333", "3343", "3363"]))
    material = {"young_modulus": E, "poisson_ratio": 0.3, "density": 1000.0}
    plain = {
        "length": L,
        "elements": 4,
        "element": element,
        "section": {"shape": "circle", "radius": R},
        "material": material,
        "supports": [{"kind": draw(st.sampled_from(["clamp", "free_section_clamp"]))}],
    }
    base = {"position": draw(vectors(5.0)).tolist(), "x_axis": [0.0, 0.6, 0.8], "y_axis": [1.0, 0.0, 0.0]}
    rods = [{"name": "a", "base": base, **plain, "curvature": draw(vectors(1.0 / L)).tolist()}]
    scene: dict[str, Any] = {"rod": rods, **effects(draw, "a")}
    if draw(st.booleans()):
        scene["gravity"] = {"acceleration": draw(vectors(2.0)).tolist()}
    if draw(st.booleans()):
        end = ancf.solve(ancf.scene_from_dict({"rod": rods})).tip("a").position
        rods.append(
            {
                "name": "b",
                "base": {"position": end.tolist(), "x_axis": [0.0, 1.0, 0.0], "y_axis": [0.0, 0.0, 1.0]},
                **{k: v for k, v in plain.items() if k != "supports"},
            }
        )
        kind = draw(st.sampled_from(["rigid", "hinge"]))
        joint = {"kind": kind, "a": {"rod": "a", "at": 1.0}, "b": {"rod": "b", "at": 0.0}}
        scene["joint"] = [{**joint, **({"axis": [0.0, 0.0, 1.0]} if kind == "hinge" else {})}]
        if kind == "hinge" or draw(st.booleans()):
            held = {"kind": "rigid", "a": {"rod": "b", "at": 1.0}, "b": "ground"}
            scene["joint"].append({**held, "displacement": (0.1 * L * draw(vectors())).tolist()})
        for name, loads in effects(draw, "b").items():
            scene.setdefault(name, []).extend(loads)
    return scene


@settings(max_examples=fewer(2), deadline=None)
@given(scenes())
def test_forces_and_moments_balance(data: dict[str, Any]):
    solution = ancf.solve(ancf.scene_from_dict(data))
    event(str(solution.status))  # the last equilibrium on the way balances as well
    limit = BALANCE + solution.residual_floor
    whole = solution.balance()
    assert set(whole.applied) == {effect.name for effect in solution.model.effects}
    assert whole.relative <= limit
    assert set(whole.reactions) <= {"supports", "ground"}  # joints between rods are inside
    parts = [solution.balance(rod.name) for rod in solution.scene.rods]
    for part in parts:
        assert part.relative <= limit
    # What acts on the rods acts on the structure: each force is found on one rod, once.
    for name, resultant in whole.applied.items():
        for kind in ("force", "moment"):
            total = sum(getattr(part.applied[name], kind) for part in parts)
            np.testing.assert_allclose(total, getattr(resultant, kind), rtol=0, atol=1e-9 * EI / L**2)
