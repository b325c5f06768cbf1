"""Soromox (piecewise constant strain, jax) on a straight round rod, where it is installed.

Its statics are elastic_force(q) + gravitational_force(q) = J(q)^T W with the wrench W at the tip; Newton with
jax's own derivatives, as its users would write it. Compiling takes half a minute for every mesh and is not
counted: the time is that of a warm solve.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib import import_module
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from validation.cost.families import Family, Reference
from validation.cost.points import CostPoint

Floats = NDArray[np.float64]

FAMILIES = ("helix", "tip force")
SEGMENTS = (4, 8)  # compiling and dense Newton grow fast
LOAD_STEPS = (1, 4, 16)
ITERATIONS = 40
STEP = 1e-8  # of the strains, at which Newton ends
DIVERGED = 1e4


def soromox_points(family: Family, reference: Reference, repeats: int) -> Iterator[CostPoint]:
    """Both meshes of one family."""
    for segments in SEGMENTS:
        about: dict[str, Any] = {
            "model": "soromox PCS", "kind": "peer", "formulation": "", "elements": segments,
            "mesh": f"{segments} segments", "tangent": "analytic", "predictor": "none",
        }  # fmt: skip
        try:
            solve, tip = _compiled(family, segments)
            steps = next((s for s in LOAD_STEPS if solve(s)[0] is not None), None)
            if steps is None:
                yield CostPoint(**about, status=f"not converged in {LOAD_STEPS[-1]} load steps")
                continue
            seconds = []
            for _ in range(repeats):
                started = process_time()
                q, iterations = solve(steps)
                seconds.append(process_time() - started)
        except Exception as error:  # another program's failure is a finding, whatever its kind
            yield CostPoint(**about, status=f"failed: {type(error).__name__}: {str(error).strip()[:200]}")
            continue
        position = tip(q)
        yield CostPoint(
            **about, status="converged", position=(position / family.length).tolist(),
            unknowns=6 * segments, iterations=iterations, steps=steps,
            error=family.error(position, reference), fastest=min(seconds),
            median=float(np.median(seconds)), repeats=repeats, parts={"rest": min(seconds)},
        )  # fmt: skip


def _compiled(
    family: Family, segments: int
) -> tuple[Callable[[int], tuple[Floats | None, int]], Callable[[Any], Floats]]:
    """Solver by load steps, giving strains or None and its iterations, and the tip (3,) [m] of strains."""
    jax, jnp, systems = (import_module(name) for name in ("jax", "jax.numpy", "soromox.systems"))
    jax.config.update("jax_enable_x64", True)
    rod = family.scene["rod"][0]
    link = systems.LinkSpec.circular(
        length=family.length / segments, radius=rod["section"]["radius"], density=1000.0,
        reference_strain=[0.0, 0.0, 0.0, 1.0, 0.0, 0.0],
        young_modulus=rod["material"]["young_modulus"], poisson_ratio=rod["material"]["poisson_ratio"],
    )  # fmt: skip
    along_x = jnp.array([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0])  # its default base stands upright
    robot = systems.PCS.from_links([link] * segments, gravity=jnp.zeros(3), base_pose=along_x)
    wrench = jnp.array(
        [
            sum((load["value"][i] for load in family.scene.get(name, [])), 0.0)
            for name in ("moment", "force")
            for i in range(3)
        ]
    )
    end = jnp.array(family.length)

    def residual(q: Any, factor: float) -> Any:
        return robot.elastic_force(q) - robot.jacobian_inertialframe(q, end).T @ (factor * wrench)

    both = jax.jit(lambda q, factor: (residual(q, factor), jax.jacfwd(residual)(q, factor)))

    def solve(steps: int) -> tuple[Floats | None, int]:
        q, total = np.zeros(6 * segments), 0
        for step in range(1, steps + 1):
            for _ in range(ITERATIONS):
                g, K = both(q, step / steps)
                dq = np.linalg.solve(np.asarray(K), -np.asarray(g))
                q, total = q + dq, total + 1
                size = float(np.max(np.abs(dq)))
                if not size < DIVERGED:
                    return None, total
                if size < STEP:
                    break
            else:
                return None, total
        return q, total

    return solve, lambda q: np.asarray(robot.forward_kinematics(jnp.asarray(q), end), float)[:3, 3]
