"""Records of a scene as people read them: what is set, numbers without noise."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import MISSING, fields, is_dataclass
from typing import Any

import numpy as np

from ancf.scene import Place, Rod
from ancf.scene_materials import law_name


def rod_lines(rod: Rod) -> Iterator[str]:
    """What a rod is: a line for it, and two for each of its pieces."""
    held = ", ".join(f"{support.kind} at {support.at:g}" for support in rod.supports) or "no support"
    count = f"{rod.elements} x {rod.element}" if rod.elements else f"elements to be chosen, {_first(rod)}"
    yield f"rod {rod.name}: {rod.length:g} m, {count} {rod.formulation}, {held}"
    shape = [f"base {value_text(rod.base.position)} m"] if np.any(rod.base.position) else []
    if not np.array_equal(rod.base.rotation, np.eye(3)):
        shape.append(f"along {value_text(rod.base.rotation[:, 0])}, y {value_text(rod.base.rotation[:, 1])}")
    if np.any(rod.curvature):
        shape.append(f"curvature [twist, about y, about z] {value_text(rod.curvature)} 1/m")
    if rod.shear_factors != (1.0, 1.0):
        shape.append(f"shear factors {value_text(rod.shear_factors)}")
    if rod.axial_rule != "default":
        shape.append(f"axial rule {rod.axial_rule}")
    if shape:
        yield f"  {', '.join(shape)}"
    for part in rod.parts:
        taper = f" to {value_text(part.section_end)}" if part.tapered else ""
        number = f", {part.elements} elements" if part.elements else ""
        piece = f"{part.length:g} m{number}: " if rod.segments else ""
        yield f"  {piece}{value_text(part.section)}{taper}"
        yield f"  {law_name(part.material)}: {record_text(part.material)}"


def _first(rod: Rod) -> str:
    """Which element a rod without a mesh begins with, and whether it keeps it."""
    return f"first {rod.element}" if rod.any_element else rod.element


def record_text(record: Any) -> str:
    """Fields of a record in a line, less those that only say zero; of another package's what it prints."""
    if not is_dataclass(record):
        return str(record)
    shown = []
    for field in fields(record):
        value = getattr(record, field.name)
        if value is not None and not _is_plain_default(field, value):
            shown.append(f"{field.name} = {value_text(value)}")
    return ", ".join(shown)


def _is_plain_default(field: Any, value: Any) -> bool:
    """Whether a number or vector stands at its default; words are always shown."""
    default = field.default if field.default_factory is MISSING else field.default_factory()
    if default is MISSING or isinstance(value, str) or is_dataclass(value):
        return False
    return bool(np.shape(default) == np.shape(value) and np.all(np.equal(default, value)))


def value_text(value: Any) -> str:
    """A value in a scene: numbers with six digits, bodies and places by name."""
    if isinstance(value, bool | str) or value is None:
        return str(value)
    if isinstance(value, Place):
        return f"{value.rod} at {value.at:g}"
    if is_dataclass(value):
        name = getattr(value, "shape", type(value).__name__.lower())
        return f"{name}({record_text(value)})"
    if isinstance(value, np.ndarray | list | tuple):
        return "[" + ", ".join(value_text(one) for one in value) + "]"
    return f"{value:.6g}" if isinstance(value, int | float) else str(value)
