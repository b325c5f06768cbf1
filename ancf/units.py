"""Quantities written with a unit ("40 cm") become SI numbers here, and nowhere else.

pint is loaded when the first such string is read; a scene of plain numbers never loads it.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, NoReturn

from ancf.errors import Message, SceneError


@dataclass(frozen=True)
class Dimension:
    """What a number of the scene file measures: its name, its SI unit and an example with a unit."""

    name: str
    unit: str
    example: str


NUMBER = Dimension("pure number", "dimensionless", "0.3")
LENGTH = Dimension("length", "m", '"40 cm"')
STRESS = Dimension("stress", "Pa", '"0.5 MPa"')
DENSITY = Dimension("density", "kg/m^3", '"1.07 g/cm^3"')
FORCE = Dimension("force", "N", '"200 mN"')
MOMENT = Dimension("moment", "N m", '"3 N mm"')
FORCE_PER_LENGTH = Dimension("force per length", "N/m", '"1 N/cm"')
ACCELERATION = Dimension("acceleration", "m/s^2", '"9.81 m/s^2"')
STIFFNESS = Dimension("stiffness", "N/m", '"20 N/cm"')
ROTATIONAL_STIFFNESS = Dimension("rotational stiffness", "N m/rad", '"3 N mm/rad"')
ROTATIONAL_BED = Dimension("rotational stiffness per length", "N/rad", '"3 N mm/rad/m"')
MOMENT_PER_LENGTH = Dimension("moment per length", "N", '"3 N mm/m"')
FLUX_DENSITY = Dimension("magnetic flux density", "T", '"50 mT"')
CURVATURE = Dimension("curvature", "1/m", '"0.1 1/cm"')
TIME = Dimension("time", "s", '"10 min"')

_QUANTITY = re.compile(r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d{1,4})?)\s*(\S.*?)?\s*", re.ASCII)
# pint evaluates expressions, so "9^9^9^9 m" would keep it busy for ever: only names, products, quotients
# and whole powers of at most two digits are handed over, and no power of a power.
_UNIT = r"(?:[^\W\d]+|%)(?:\s*(?:\^|\*\*)\s*-?\d{1,2}(?!\d))?"
_UNIT_EXPRESSION = re.compile(rf"(?:1?\s*/\s*)?{_UNIT}(?:(?:\s*[*/·]\s*|\s+){_UNIT})*")
_PURE = ("dimensionless", "percent", "ppm")  # how pint writes the units of pure numbers
_LONGEST_TEXT = 80  # characters; a quantity with its unit is far shorter


def to_si(text: str, dimension: Dimension, where: str) -> float:
    """Convert a quantity with a unit to the SI number of the dimension.

    Parameters
    ----------
    text : str
        A number, then a unit: ``"40 cm"``, ``"3 N mm"``, ``"9.81 m/s^2"``.
    dimension : Dimension
        What is expected; the result is in ``dimension.unit``.
    where : str
        File and key, for the message.

    Returns
    -------
    float
        Value [dimension.unit]; may overflow to infinity, which the caller refuses.

    Raises
    ------
    SceneError
        If the text is no quantity, has no unit, has an unknown unit or measures something else.
    """
    match = _QUANTITY.fullmatch(text) if len(text) <= _LONGEST_TEXT else None
    if match is None:
        _refuse(text, dimension, where, "it does not start with a number", "not a number followed by a unit")
    number, unit = float(match[1]), match[2]
    if unit is None:
        _refuse(
            text,
            dimension,
            where,
            "the text holds no unit",
            "a number in quotes",
        )
    if not _UNIT_EXPRESSION.fullmatch(unit):
        _refuse(text, dimension, where, f"{unit!r} is not a unit", "the unit cannot be read")
    return number * _factor(text, unit, dimension, where)


def _factor(text: str, unit: str, dimension: Dimension, where: str) -> float:
    """Return how many SI units one `unit` is, as pint's registry has it."""
    import pint

    if unit.startswith("/"):
        unit = "1" + unit
    try:
        parsed = _registry().parse_units(unit)
        factor = float(_registry().Quantity(1.0, parsed).to(dimension.unit).magnitude)
    except pint.DimensionalityError as error:
        # "Nm" is legal in pint: the number (unit "N" in another sense) per metre.
        hint = "; write 'N m' with a space" if unit in ("Nm", "Nmm") else ""
        found = str(error.dim1 or error.units1)
        reason = f"{unit!r} measures {found}, not a {dimension.name}{hint}"
        _refuse(text, dimension, where, reason, "the unit has the wrong dimension")
    except pint.UndefinedUnitError:
        reason = f"{unit!r} holds an unknown unit name; capitals matter (MPa, not MPA)"
        _refuse(text, dimension, where, reason, "the unit is unknown")
    except (pint.PintError, ValueError, TypeError, ArithmeticError, AttributeError, SyntaxError) as error:
        _refuse(text, dimension, where, f"{unit!r} is not a unit: {error}", "the unit cannot be read")
    if dimension is NUMBER and str(parsed) not in _PURE:  # pint takes degrees and turns for pure numbers
        _refuse(text, dimension, where, f"{unit!r} is an angle, not a pure number", "the unit is wrong")
    return factor


@lru_cache(maxsize=1)
def _registry() -> Any:
    """Build pint's registry once: it takes some 0.3 s."""
    import pint

    try:
        return pint.UnitRegistry(cache_folder=":auto:")  # pint's parsed definitions, in the user's cache
    except OSError:  # no home to write to
        return pint.UnitRegistry()


def _refuse(text: str, dimension: Dimension, where: str, reason: str, cause: str) -> NoReturn:
    shown = text if len(text) <= _LONGEST_TEXT else text[:_LONGEST_TEXT] + "..."
    raise SceneError(
        Message(
            what=f"The text {shown!r} is no {dimension.name}.",
            where=where,
            value=f"{reason}; a {dimension.name} [{dimension.unit}] is expected",
            cause=cause,
            advice=f"write {dimension.example}, or a plain number in SI units ({dimension.unit})",
        )
    )
