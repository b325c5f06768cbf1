"""What is measured on the section problem: convergence to truths that it did not come from, and to its own.

Moduli near 1 Pa, a radius of 1 m: the answers do not depend on the units.
"""

from __future__ import annotations

from functools import cache

from reference.rivlin_compressible import torsion_compressible
from reference.root import bracketed_root
from reference.section import bend, twist
from reference.solid_mesh import circular_section
from validation.reference_measures import Measure, Rubber

TWISTED, BENT = 0.3, 0.1  # twist and curvature times the radius
FINE = 6  # quads across the core


def section_errors(rubber: Rubber) -> Measure:
    """Relative errors of a circular section with 1/size quads across its core.

    Twist without axial force, its couple and its change of length (Poynting) against radial equilibrium of
    the cylinder, collocated; couple of bending against a mesh of `FINE` quads.
    """

    @cache
    def truth() -> tuple[float, float, float]:
        """Stretch and couple of torsion, couple of bending."""

        def axial_force(stretch: float) -> float:
            return torsion_compressible(rubber.invariant, TWISTED, 1.0, stretch).axial_force

        stretch = bracketed_root(axial_force, 0.9, 1.1)
        torsion = torsion_compressible(rubber.invariant, TWISTED, 1.0, stretch)
        bending = bend(circular_section(1.0, FINE), rubber.material, curvature=BENT)
        return stretch, torsion.moment, float(bending.couple[2])

    def measure(size: float) -> dict[str, float]:
        stretch, torsion, bending = truth()
        section = circular_section(1.0, round(1 / size))
        twisted = twist(section, rubber.material, twist=TWISTED)
        bent = bend(section, rubber.material, curvature=BENT)
        return {
            "couple of torsion": abs(float(twisted.couple[0]) / torsion - 1),
            "stretch of torsion": abs(twisted.axial_stretch / stretch - 1),
            "couple of bending": abs(float(bent.couple[2]) / bending - 1),
        }

    return measure
