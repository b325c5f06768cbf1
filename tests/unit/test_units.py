"""Quantities with units."""

from __future__ import annotations

import subprocess
import sys

import pytest

from ancf import units
from ancf.errors import SceneError
from ancf.units import to_si


@pytest.mark.parametrize(
    ("text", "dimension", "expected"),
    # Definitions of the SI prefixes, min and degree: BIPM SI brochure, 9th edition, tables 7 and 8.
    [
        ("40 cm", units.LENGTH, 0.4),
        ("40cm", units.LENGTH, 0.4),
        ("-.5e3 mm", units.LENGTH, -0.5),
        ("5 µm", units.LENGTH, 5e-6),
        ("0.5 MPa", units.STRESS, 5e5),
        ("1 N/mm^2", units.STRESS, 1e6),
        ("1.07 g/cm^3", units.DENSITY, 1070.0),
        ("1.07 g cm**-3", units.DENSITY, 1070.0),
        ("200 mN", units.FORCE, 0.2),
        ("3 N mm", units.MOMENT, 3e-3),
        ("3 N*mm", units.MOMENT, 3e-3),
        ("3 N·mm", units.MOMENT, 3e-3),
        ("1 N/cm", units.FORCE_PER_LENGTH, 100.0),
        ("-9.81 m/s^2", units.ACCELERATION, -9.81),
        ("0.1 1/cm", units.CURVATURE, 10.0),
        ("0.1/cm", units.CURVATURE, 10.0),
        ("180 deg/m", units.CURVATURE, 3.141592653589793),
        ("10 min", units.TIME, 600.0),
        ("50 %", units.NUMBER, 0.5),
    ],
)
def test_quantity_becomes_si(text: str, dimension: units.Dimension, expected: float):
    assert to_si(text, dimension, "here") == pytest.approx(expected, rel=1e-14)


@pytest.mark.parametrize(
    ("text", "dimension", "value", "cause"),
    [
        ("5 kg", units.FORCE, "'kg' measures [mass], not a force", "wrong dimension"),
        ("40 cm", units.STRESS, "'cm' measures [length], not a stress", "wrong dimension"),
        ("3 Nm", units.MOMENT, "write 'N m' with a space", "wrong dimension"),
        ("4 MPA", units.STRESS, "capitals matter", "unknown"),
        ("4 furlings", units.LENGTH, "'furlings' holds an unknown unit name", "unknown"),
        ("0.3", units.NUMBER, "no unit", "a number in quotes"),
        ("", units.LENGTH, "does not start with a number", "not a number"),
        ("cm 40", units.LENGTH, "does not start with a number", "not a number"),
        ("nan m", units.LENGTH, "does not start with a number", "not a number"),
        ("3 m and more", units.LENGTH, "unknown unit name", "unknown"),
        ("3 m)", units.LENGTH, "is not a unit", "cannot be read"),
        ("9 m^9^9^9", units.LENGTH, "is not a unit", "cannot be read"),
        ("9 m^9999999", units.LENGTH, "is not a unit", "cannot be read"),
        ("1 " + "m" * 500, units.LENGTH, "does not start with a number", "not a number"),
        ("5 degC", units.LENGTH, "'degC' measures [temperature]", "wrong dimension"),
    ],
)
def test_bad_quantities_are_refused(text: str, dimension: units.Dimension, value: str, cause: str):
    with pytest.raises(SceneError) as caught:
        to_si(text, dimension, "arm.toml: rod[0].length")
    message = caught.value.message
    assert message.where == "arm.toml: rod[0].length"
    assert f"is no {dimension.name}." in message.what
    assert value in message.value
    assert cause in message.cause
    assert dimension.example in message.advice


def test_numbers_never_load_pint():
    code = (
        "import sys, ancf.scene_file as f\n"
        "rod = dict(length=1.0, elements=2, section=dict(shape='circle', radius=0.1),\n"
        "           material=dict(young_modulus=1.0, poisson_ratio=0.0))\n"
        "f.scene_from_dict(dict(rod=[rod]))\n"
        "assert 'pint' not in sys.modules\n"
        "f.scene_from_dict(dict(rod=[{**rod, 'length': '1 m'}]))\n"
        "assert 'pint' in sys.modules\n"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)
