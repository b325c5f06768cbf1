"""Property checks of the solver: statements that hold for every rod, each measured on random examples.

`PROPERTIES` is used by the report (examples drawn with NumPy) and by the property tests (examples drawn with
Hypothesis); both call the same measuring functions. Observed 0 is perfect, a property holds while observed <=
bound.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ancf.elements import ELEMENTS, SECTION_ELEMENTS
from validation import (
    energy_measures as energy,
    kernel_measures as kernel,
    property_examples as example,
    solution_measures as solution,
)
from validation.random_rods import Draws, RngDraws


@dataclass(frozen=True)
class Property:
    """A statement with its bound; `observe` measures one example on a rod of the given element.

    name: identifier; title: the statement; bound and unit of the observed value; source: where the statement
    and the bound come from; solves: whether an example solves scenes (tens of milliseconds instead of a few);
    elements: names of the elements it is promised for, empty for all; cost: by how much an example is dearer
    than others of its kind, and its number smaller; of_sections: whether it speaks of sections, moments,
    followers or twist, which a cable has not.
    """

    name: str
    title: str
    bound: float
    unit: str
    source: str
    observe: Callable[[Draws, str], float]
    solves: bool = False
    elements: tuple[str, ...] = ()
    cost: int = 1
    of_sections: bool = False

    @property
    def element_names(self) -> tuple[str, ...]:
        """Elements it is promised for."""
        return self.elements or tuple(SECTION_ELEMENTS if self.of_sections else ELEMENTS)

    def run(self, rng: np.random.Generator) -> float:
        """Observed value of one random example; infinite where a scene that has a solution was not solved."""
        draws = RngDraws(rng)
        try:
            return self.observe(draws, draws.choice(self.element_names))
        except solution.NotConverged:
            return float(np.inf)


PROPERTIES: tuple[Property, ...] = (
    Property(
        "rigid-strain",
        "A rigid motion of any rod causes no strain in the kernel",
        1e-12,
        "-",
        "benchmarks.md RM",
        example.rigid(kernel.largest_kernel_strain),
    ),
    Property(
        "rigid-gradient",
        "A rigid motion of any rod leaves (F^T F - I)/2 = 0, F formed from the shape functions",
        1e-12,
        "-",
        "benchmarks.md RM; paper eq. 11-13",
        example.rigid(kernel.largest_gradient_strain),
        of_sections=True,
    ),
    Property(
        "rigid-force",
        "A rigid motion of any rod causes no elastic force",
        1e-12,
        "E A (1 - nu)/((1 + nu)(1 - 2 nu))",
        "benchmarks.md RM",
        example.rigid(kernel.rigid_force),
    ),
    Property(
        "rigid-floor",
        "The elastic force after a rigid motion stays at the float64 floor",
        2.0,
        "10 eps (L/h) c A L^2/I",
        "theory.md 5, where equal elements make L/h = n_el; twice the estimate, which is one of size",
        example.rigid(kernel.force_over_floor),
    ),
    Property(
        "rigid-far",
        "Absolute coordinates 1e6 m away: the strain of a rigid motion stays at their resolution",
        10.0,
        "eps |r|/h",
        "benchmarks.md RM",
        example.far_rigid_strain,
    ),
    Property(
        "objectivity",
        "A superposed rotation leaves the energy and turns the force of a strained state",
        1e-11,
        "relative",
        "invariance of Green-Lagrange strain; rounding times the ratio of stiffnesses",
        example.objectivity,
    ),
    Property(
        "energy-integral",
        "The energy is the volume integral of the law, written in F, with the rules of each formulation",
        1.0,
        "1e-10, for rubber 1e-6",
        "theory.md 3, 5; degree 8 leaves 2e-8 of rubber (no polynomial) at strains of 0.3",
        example.energy,
        of_sections=True,
    ),
    Property(
        "elastic-order",
        "energy -> force -> tangent: central differences err with order 2",
        0.2,
        "|order - 2|",
        "Taylor's theorem",
        example.elastic_orders(0),
    ),
    Property(
        "elastic-derivative",
        "energy -> force -> tangent: extrapolated differences agree",
        1e-8,
        "relative",
        "benchmarks.md MO",
        example.elastic_orders(1),
    ),
    Property(
        "elastic-symmetry",
        "The elastic tangent is symmetric, mixed-integration-point stress or not",
        1e-12,
        "relative",
        "it is the Hessian of a potential",
        example.asymmetry,
    ),
    Property(
        "mixed-tangent",
        "The mixed-integration-point stress is the linear prediction, and the plain one at rest",
        1e-12,
        "relative",
        "Magisano, Leonetti, Garcea 2017; theory.md 6",
        example.mixed_tangent,
    ),
    Property(
        "patch",
        "Constant strain gives the exact nodal forces on unequal elements",
        1e-11,
        "relative",
        "benchmarks.md PT; integration by parts of constant P = dPsi/dF",
        example.patch(energy.patch_force),
        of_sections=True,
    ),
    Property(
        "patch-stress",
        "Constant strain gives the law's Cauchy stress at every point of every section",
        1e-10,
        "relative",
        "the same law in F, P F^T / det F (reference/solid_materials.py)",
        example.patch(energy.patch_stress),
        of_sections=True,
    ),
    Property(
        "zero-modes",
        "The tangent of the unstressed rod has exactly six zero modes",
        0.0,
        "modes",
        "issue 2, NUMBERS",
        example.zero_modes(bent=False),
        of_sections=True,
    ),
    Property(
        "zero-modes-bent",
        "B^T D B in bent and twisted states has exactly six zero modes",
        0.0,
        "modes",
        "issue 2, NUMBERS; D of the unstressed law, because that of strained rubber is indefinite",
        example.zero_modes(bent=True),
        of_sections=True,
    ),
    Property(
        "moment",
        "A point moment has the resultant M, no force, and the power M . w",
        1e-8,
        "relative",
        "theory.md 4; the resultant is exact to rounding, the spin is differenced",
        example.moment_identities,
        of_sections=True,
    ),
    Property(
        "load-order",
        "force -> tangent of every load: central differences err with order 2",
        0.2,
        "|order - 2|",
        "Taylor's theorem",
        example.load_orders(0),
        of_sections=True,
    ),
    Property(
        "load-derivative",
        "force -> tangent of every load: extrapolated differences agree",
        1e-6,
        "relative",
        "benchmarks.md MO; remainder t^6 of loads that are not polynomial",
        example.load_orders(1),
        of_sections=True,
    ),
    Property(
        "turned",
        "A turned base and turned loads give the turned solution",
        1e-9,
        "L and -",
        "frame indifference; the trap of theory.md 3",
        example.turned,
        True,
    ),
    Property(
        "shifted",
        "A base 2.5e6 L away (1e6 m for 0.4 m) gives the same solution relative to the base",
        1e-9,
        "L and -",
        "issue 2, NUMBERS",
        example.shifted,
        True,
    ),
    Property(
        "mirrored",
        "The mirror image of a scene has the mirrored solution",
        1e-9,
        "L and -",
        "reflection; Newton's tolerance 1e-10",
        example.mirrored,
        True,
    ),
    Property(
        "reversed",
        "A rod described from its other end has the same solution",
        1e-9,
        "L and -",
        "architecture.md, Tests; Newton's tolerance 1e-10",
        example.reversed,
        True,
    ),
    Property(
        "scaled",
        "Metres, kilograms or millimetres, grams: the same dimensionless solution",
        1e-9,
        "L and -",
        "dimensional analysis",
        example.scaled,
        True,
    ),
    Property(
        "balance",
        "Reactions and loads are in equilibrium on the deformed rod",
        1.0,
        "1e-10 max(load, E I/L^2 or E I/L) + 10 floors",
        "reaction balance to 1e-10 (architecture.md, Tests) beyond what Newton's residual may be",
        example.on_scene(solution.imbalance),
        True,
    ),
    Property(
        "reciprocity",
        "Betti: two small loads do the same work on each other's displacements",
        1e-6,
        "relative",
        "Betti 1872; Newton's tolerance 1e-10 over the load 1e-4",
        example.reciprocity,
        True,
    ),
    Property(
        "path",
        "With and without the predictor: the same equilibrium",
        1e-8,
        "L and -",
        "theory.md 4: equilibria do not depend on the path; Newton's tolerance and condition",
        example.on_scene(solution.path_dependence),
        True,
    ),
    Property(
        "difference-tangent",
        "The paper's finite-difference tangent finds the same equilibrium",
        1e-8,
        "L and -",
        "paper eq. 38-41; Newton's tolerance and condition",
        example.on_scene(solution.difference_tangent_dependence),
        True,
        cost=10,
    ),
    Property(
        "zero-effects",
        "Loads of zero magnitude change no bit of the solution",
        0.0,
        "coordinates",
        "architecture.md, Tests",
        example.on_scene(solution.zero_effects),
        True,
    ),
    Property(
        "supports",
        "Every support condition holds at the solution",
        1e-12,
        "L and -",
        "interface.md, supports; they are linear and hold exactly",
        example.supports,
        True,
    ),
    Property(
        "resumed",
        "A saved state resumes to the same solution in two iterations",
        1e-9,
        "L and -",
        "interface.md; Newton's tolerance",
        example.resumed,
        True,
    ),
    Property(
        "stretch",
        "Uniaxial stretch with free sections follows the law",
        1e-10,
        "-",
        "P = dPsi/dF with no lateral stress (reference/solid_materials.py); Newton's tolerance",
        example.stretched,
        True,
        # A force on the axis is a point load on a quadratic section, which it indents: no uniform state.
        ("3333", "3243"),
    ),
    Property(
        "helix",
        "Slender rod, oblique tip moment up to 2.5 E I/L: the closed-form helix",
        1e-3,
        "L",
        "theory.md 3, table: 12 elements; L/R = 200 to 400, so that finite strain is below half of it",
        example.helix(solution.helix_error),
        True,
        ("3333",),
    ),
    Property(
        "section-moment",
        "Under a tip moment the section moment is M everywhere",
        5e-3,
        "E I/L",
        "theory.md 1; 12 elements with two axial points",
        example.helix(solution.section_moment_error),
        True,
        ("3333",),
    ),
)
