"""Static equilibrium of soft continuum robots with Absolute Nodal Coordinate Formulation beams.

>>> import ancf
>>> solution = ancf.solve(ancf.load_scene("arm.toml"))
>>> solution.status, solution.tip().position
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ancf.batch import BatchSolution, solve_batch
    from ancf.errors import InputError, Message, SceneError
    from ancf.scene import Scene
    from ancf.scene_file import load_scene, scene_from_dict
    from ancf.solution import Pose, SectionForces, Solution, Status
    from ancf.solver import solve
    from ancf.state import resume

__version__ = "0.1.0"

_HOME = {
    "BatchSolution": "batch",
    "solve_batch": "batch",
    "InputError": "errors",
    "Message": "errors",
    "SceneError": "errors",
    "Scene": "scene",
    "load_scene": "scene_file",
    "scene_from_dict": "scene_file",
    "Pose": "solution",
    "SectionForces": "solution",
    "Solution": "solution",
    "Status": "solution",
    "solve": "solver",
    "resume": "state",
}

__all__ = [
    "BatchSolution",
    "InputError",
    "Message",
    "Pose",
    "Scene",
    "SceneError",
    "SectionForces",
    "Solution",
    "Status",
    "__version__",
    "load_scene",
    "resume",
    "scene_from_dict",
    "solve",
    "solve_batch",
]


def __getattr__(name: str) -> Any:
    """Load a public name on first use, so that ``ancf --help`` stays quick."""
    if name not in _HOME:
        raise AttributeError(f"module 'ancf' has no attribute {name!r}")
    value = getattr(import_module(f"ancf.{_HOME[name]}"), name)
    globals()[name] = value
    return value
