"""Reading of a rod's material: the law by its name, and the constants that belong to it.

A law is a record of `materials.py` or `hyperelastic.py`; `LAWS` is the one place that names it for a scene.
"""

from __future__ import annotations

from ancf.hyperelastic import Law, MooneyRivlin, NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.scene_table import MODULUS, Limit, Table
from ancf.units import DENSITY, NUMBER, STRESS, Dimension

LAWS: dict[str, type[Law]] = {
    "saint-venant-kirchhoff": SaintVenantKirchhoff,
    "neo-hookean": NeoHookean,
    "mooney-rivlin": MooneyRivlin,
}
CONSTANTS_OF: dict[str, tuple[str, ...]] = {
    "saint-venant-kirchhoff": ("young_modulus", "poisson_ratio"),
    "neo-hookean": ("young_modulus", "poisson_ratio"),
    "mooney-rivlin": ("c10", "c01", "bulk_modulus"),
}
POISSON = Limit(lambda v: -1.0 < v < 0.5, "inside (-1, 0.5), both ends excluded")
RUBBER_CONSTANT = Limit(lambda v: v == 0.0 or MODULUS.holds(v), ">= 0, and 0 or between 1e-30 and 1e30")
CONSTANTS: dict[str, tuple[Dimension, Limit]] = {
    "young_modulus": (STRESS, MODULUS),
    "poisson_ratio": (NUMBER, POISSON),
    "c10": (STRESS, RUBBER_CONSTANT),
    "c01": (STRESS, RUBBER_CONSTANT),
    "bulk_modulus": (STRESS, MODULUS),
    "density": (DENSITY, MODULUS),
}
FARTHEST = 1e12  # bulk over shear modulus or the reverse: beyond it the two lose each other's digits


def law_name(material: Law) -> str:
    """Name of a material's law in a scene file."""
    return next(name for name, law in LAWS.items() if type(material) is law)


def read_material(table: Table) -> Law:
    """Read the material of a rod; absent, the law is Saint Venant-Kirchhoff and the density unknown."""
    law = table.word("law", tuple(LAWS), "saint-venant-kirchhoff")
    keys = CONSTANTS_OF[law]
    _refuse_constants_of_other_laws(table, law)
    table.expect_keys(("law", *keys, "density"))
    given = [*keys, *(["density"] if "density" in table.data else [])]
    values = {key: _constant(table, key, law) for key in given}
    if law == "mooney-rivlin":
        _check_rubber(table, values["c10"] + values["c01"], values["bulk_modulus"])
    return LAWS[law](**values)


def _refuse_constants_of_other_laws(table: Table, law: str) -> None:
    """Refuse a key of another law and name that law: "law" was forgotten, or is the wrong one."""
    for key in CONSTANTS:
        if key not in table.data or key == "density" or key in CONSTANTS_OF[law]:
            continue
        laws = [name for name, keys in CONSTANTS_OF.items() if key in keys]
        table.refuse(
            key,
            f'"{key}" is no constant of {law}.',
            f"{law} has {', '.join(CONSTANTS_OF[law])} and density",
            f"{key} belongs to {' and '.join(laws)}"
            + ("" if "law" in table.data else '; "law" is not given and defaults to saint-venant-kirchhoff'),
            f'write law = "{laws[-1]}", or give {", ".join(CONSTANTS_OF[law])} in place of {key}',
        )


def _constant(table: Table, key: str, law: str) -> float:
    """Read one constant; negative Mooney-Rivlin constants are refused with their reason."""
    dimension, limit = CONSTANTS[key]
    if limit is not RUBBER_CONSTANT:
        return table.number(key, dimension, limit=limit)
    value = table.number(key, dimension)
    if value < 0.0:
        mode = "uniaxial tension" if key == "c10" else "equibiaxial tension"
        table.refuse(
            key,
            f"{key} of {law} is negative.",
            f"{value:g} Pa, must be {limit.words}",
            f"a fit to one test may return it, but its energy then falls without bound in {mode}",
            f"fit again with {key} >= 0, or set {key} = 0 and give the other constant the sum",
        )
    return table.number(key, dimension, limit=limit)


def _check_rubber(table: Table, half_shear: float, bulk: float) -> None:
    """Refuse a Mooney-Rivlin rubber without shear stiffness, or one with moduli too far apart."""
    if half_shear <= 0.0:
        table.refuse(
            "c10",
            "The Mooney-Rivlin rubber has no shear stiffness.",
            "c10 + c01 = 0 Pa, must be > 0",
            "its shear modulus is 2 (c10 + c01)",
            "give c10 > 0 or c01 > 0",
        )
    ratio = bulk / (2.0 * half_shear)
    if not 1.0 / FARTHEST <= ratio <= FARTHEST:
        table.refuse(
            "bulk_modulus",
            "Bulk and shear modulus of the rubber lie too far apart for double precision.",
            f"bulk_modulus / (2 (c10 + c01)) = {ratio:.3g}, outside {1 / FARTHEST:g} to {FARTHEST:g}",
            "a very large number was meant as incompressible, or a unit differs",
            "take bulk_modulus about 5000 times 2 (c10 + c01), that is Poisson ratio 0.4999",
        )
