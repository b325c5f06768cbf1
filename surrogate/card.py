"""The data card: what the numbers of a data set are, where they come from and what vouches for them.

It holds no date, time or machine, so that the same data have the same card.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surrogate import npz
from surrogate.gate import UNVALIDATED
from surrogate.plan import SCHEMA, Plan
from surrogate.sampling import SPLIT_NAMES, seeds

MOST_REASONS = 20


def card(plan: Plan, arrays: Mapping[str, NDArray], outside: Sequence[str]) -> dict[str, Any]:
    """The card of a finished data set.

    Parameters
    ----------
    outside : why rows lie outside the domain of validity; any makes the data UNVALIDATED
    """
    design = plan.design
    stamp = UNVALIDATED if outside else plan.gate.id
    reasons = [*plan.gate.reasons, *outside]
    statuses, counts = np.unique(arrays["status"], return_counts=True)
    return {
        "schema": SCHEMA,
        "preset": design.name,
        "certificate": stamp,
        "reasons": reasons[:MOST_REASONS],
        "rows": design.count,
        "rows_by_split": {name: int(np.sum(arrays["split"] == name)) for name in SPLIT_NAMES},
        "rows_by_status": {str(s): int(c) for s, c in zip(statuses, counts, strict=True)},
        "units": {
            "moments": "N m", "pose": "m (r), dimensionless (r_x, r_y, r_z)", "stretch": "dimensionless",
            "residual": "dimensionless", "loads": [variable.unit for variable in design.variables],
        },
        "frames": frames(plan),
        "loads": [
            {"name": v.name, "unit": v.unit, "range": [v.low, v.high], "steps": v.steps or None}
            for v in design.variables
        ],
        "moment_range": moment_range(plan),
        "arm": arm(plan),
        "sampling": {"kind": design.sampling, "count": design.count, "split": design.split},
        "seed": design.seed,
        "seeds": seeds(design),
        "versions": plan.record["versions"],
        "arrays": {name: npz.described(array) for name, array in sorted(arrays.items())},
        "plan": plan.record,
        "plan_id": plan.digest,
    }  # fmt: skip


def frames(plan: Plan) -> dict[str, Any]:
    """Which axes the components are counted in; `base` turns body axes into SCS: v_SCS = rotation v_body."""
    scene = plan.design.scene
    base = arm_rod(plan).base
    return {
        "pose": "structure",
        "moments": scene.moments[0].frame if scene.moments else "structure",
        "base": {"position": base.position.tolist(), "rotation": base.rotation.tolist()},
    }


def moment_range(plan: Plan) -> list[list[float]]:
    """Bounds [N m] of the three components of the first moment, in its frame."""
    bounds = np.repeat(plan.design.first_moments(plan.sample.points[:1]).T, 2, axis=1)
    for variable in plan.design.variables:
        if (variable.load, variable.index) == ("moment", 0):
            bounds["xyz".index(variable.component)] = variable.low, variable.high
    return bounds.tolist()


def arm_rod(plan: Plan) -> Any:
    """The rod whose tip the poses are."""
    scene = plan.design.scene
    return scene.rod((*scene.moments, *scene.forces, *scene.tendons)[0].rod)


def arm(plan: Plan) -> dict[str, Any]:
    """The rod whose tip the poses are; `radius` is the outer one, material that at the base."""
    rod = arm_rod(plan)
    return {
        "name": rod.name,
        "length": rod.length,
        "radius": getattr(rod.section, "radius", rod.section.outer_radius),
        "section": type(rod.section).__name__.lower(),
        "young_modulus": rod.material.young_modulus,
        "poisson_ratio": rod.material.poisson_ratio,
        "law": type(rod.material).__name__,
        "element": rod.element,
        "elements": rod.elements,
        "formulation": rod.formulation,
        "bending_stiffness": rod.material.young_modulus * rod.section.weaker_second_moment,
    }
