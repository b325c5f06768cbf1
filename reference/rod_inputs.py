"""A rod given by plain numbers, as stored with every solved reference: its law, its section, its mesh.

The tables are those of a scene file: `{"law": "neo-hookean", "young_modulus": .., ..}` and
`{"shape": "circle", "radius": ..}`, in SI units.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from reference.solid_materials import MooneyRivlin, NeoHookean, SaintVenantKirchhoff, SolidMaterial
from reference.solid_mesh import (
    SectionMesh,
    annular_section,
    circular_section,
    elliptic_section,
    rectangular_section,
)

MOST_CELLS = 24  # along the longer side of a rectangle


def _rectangle(height_y: float, width_z: float, cells: int) -> SectionMesh:
    """Rectangle of quads that are about square, `cells` across its shorter side."""
    short = min(height_y, width_z)
    n_y, n_z = (min(MOST_CELLS, round(cells * side / short)) for side in (height_y, width_z))
    return rectangular_section(height_y, width_z, n_y, n_z)


LAWS: dict[str, tuple[Callable[..., SolidMaterial], tuple[str, ...]]] = {
    "saint-venant-kirchhoff": (SaintVenantKirchhoff, ("young_modulus", "poisson_ratio")),
    "neo-hookean": (NeoHookean, ("young_modulus", "poisson_ratio")),
    "mooney-rivlin": (MooneyRivlin, ("c10", "c01", "bulk_modulus")),
}
SECTIONS: dict[str, tuple[Callable[..., SectionMesh], tuple[str, ...]]] = {
    "circle": (circular_section, ("radius",)),
    "annulus": (annular_section, ("radius", "inner_radius")),
    "rectangle": (_rectangle, ("height_y", "width_z")),
    "ellipse": (elliptic_section, ("semi_axis_y", "semi_axis_z")),
}


def law_of(table: Mapping[str, Any]) -> SolidMaterial:
    """The law of a material table; density and unknown keys are left out.

    Raises ValueError for a law that has no solid counterpart.
    """
    make, keys = _known(LAWS, table.get("law", "saint-venant-kirchhoff"), "law")
    return make(**{key: float(table[key]) for key in keys})


def section_of(table: Mapping[str, Any], cells: int) -> SectionMesh:
    """Mesh of a section table with `cells` quads across its core; raises ValueError for an unknown shape."""
    make, keys = _known(SECTIONS, table["shape"], "shape")
    return make(*(float(table[key]) for key in keys), cells)


def constants_of(table: Mapping[str, Any], kind: str) -> dict[str, Any]:
    """The entries of a table that decide the answer, its ``law`` or ``shape`` first."""
    known = LAWS if kind == "law" else SECTIONS
    name = table.get(kind, "saint-venant-kirchhoff")
    _, keys = _known(known, name, kind)
    return {kind: name, **{key: float(table[key]) for key in keys}}


def _known(known: Mapping[str, Any], name: str, what: str) -> Any:
    if name not in known:
        raise ValueError(f"There is no {what} {name!r} among the references; there are {', '.join(known)}.")
    return known[name]
