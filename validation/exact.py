"""What the section problem, the 3-D solid and the integrated rod say about the rod of a scene.

Only numbers pass from a scene to a reference. Expensive answers come from the store of solved references
(`reference.cache`). Positions are by the rod's length; the rod is clamped at the origin, along x.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

import ancf
from reference.cache import session
from reference.rod import RodNotSolved, solve_rod
from reference.rod_inputs import constants_of
from reference.section_answer import NoAnswer, section_answer
from reference.solid import SolidTooLarge
from reference.solid_answer import solid_answer
from validation.scenes import reference_rod

Floats = NDArray[np.float64]

SOURCES = ("section", "solid", "rod")
DIGITS = 12  # of the inputs of a stored answer


@dataclass(frozen=True)
class Answer:
    """Tip of a rod by one reference.

    Parameters
    ----------
    position : material point of the axis (3,) [length]
    rotation : section rotation (3, 3)
    position_error, angle_error : own estimated errors [length], [rad]; infinite where there is no answer
    reason : why there is none
    values : all that is stored: axis, stress, unknowns, ...
    """

    position: Floats
    rotation: Floats
    position_error: float
    angle_error: float
    reason: str = ""
    values: Mapping[str, Any] = field(default_factory=dict)


def answer(source: str, scene: Mapping[str, Any], support: str = "soft") -> Answer:
    """Answer of a reference for the one rod of a scene with loads in SI units.

    A reference that does not converge gives an answer with infinite error, which makes its cases
    inconclusive.
    """
    try:
        return {"section": _section, "solid": _solid, "rod": _rod}[source](scene, support)
    except (NoAnswer, RodNotSolved, SolidTooLarge) as error:
        return Answer(np.full(3, np.nan), np.full((3, 3), np.nan), math.inf, math.inf, str(error))


def _section(scene: Mapping[str, Any], support: str) -> Answer:
    inputs = {**_rod_numbers(scene), "moment": _loads(scene)["moment"]}
    return _stored("section_answer", section_answer, inputs)


def _solid(scene: Mapping[str, Any], support: str) -> Answer:
    inputs = {**_rod_numbers(scene), "loads": _loads(scene), "support": support}
    return _stored("solid_answer", solid_answer, inputs)


def _stored(kind: str, compute: Callable[..., dict[str, Any]], inputs: Mapping[str, Any]) -> Answer:
    inputs = _rounded(inputs)
    found = session().get(kind, inputs, lambda: compute(**inputs))
    return Answer(
        np.array(found["position"]),
        np.array(found["rotation"]),
        found["position_error"],
        found["angle_error"],
        values=found,
    )


def _rod(scene: Mapping[str, Any], support: str) -> Answer:
    properties, loads = reference_rod(ancf.scene_from_dict(scene))
    exact = solve_rod(properties, loads)
    error = exact.estimated_error
    return Answer(exact.position[0] / properties.length, exact.rotation[0], error, error)


def _rod_numbers(scene: Mapping[str, Any]) -> dict[str, Any]:
    rod = scene["rod"][0]
    return {
        "material": constants_of(rod["material"], "law"),
        "section": constants_of(rod["section"], "shape"),
        "length": float(rod["length"]),
    }


def _rounded(values: Any) -> Any:
    """Numbers to `DIGITS`: the last bits of a load belong to the machine, and must not change its key."""
    if isinstance(values, Mapping):
        return {name: _rounded(value) for name, value in values.items()}
    if isinstance(values, list):
        return [_rounded(value) for value in values]
    return float(f"{values:.{DIGITS}g}") if isinstance(values, float) else values


def _loads(scene: Mapping[str, Any]) -> dict[str, list[float]]:
    """Dead loads of a scene: tip moment [N m], tip force [N], weight [N/m3]."""
    loads = {}
    for table in ("moment", "force"):
        if scene.get(table):
            loads[table] = [float(sum(entry["value"][i] for entry in scene[table])) for i in range(3)]
    if "gravity" in scene:
        density = float(scene["rod"][0]["material"]["density"])
        loads["body_force"] = [density * float(a) for a in scene["gravity"]["acceleration"]]
    return loads
