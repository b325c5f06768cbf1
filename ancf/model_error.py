r"""What no mesh removes: the known error of an element's sections against the solid, as a tip error.

Where a section of the element carries the moment m and the solid's carries m + dm at the same curvature, the
equilibrium shifts, to first order, so that a tip moves by

    d r_tip = -int dm . w'(z) dx,     K^T z = d r_tip/dq,

z the adjoint of the tip and w(z) the spin of the sections by it. dm is known for

* finite strain: exact bending is M = E I k (1 - c (k R)^2), and each element has a c of its own;
* torsion of sections that warp: the element's J against Saint-Venant's;
* ``continuum`` with linear sections (Poisson locking) and tapers (inclined skin);
* tubes that flatten and strips that curve across (section_validity.py).

Not covered: ends (what a clamp or a force on a point does within a radius or two), shear at finite strain,
and whether the law is that of the material.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ancf.elements import ELEMENTS
from ancf.error_estimate import ErrorEstimate
from ancf.hyperelastic import Law, MooneyRivlin, NeoHookean
from ancf.materials import SaintVenantKirchhoff
from ancf.rod_model import RodModel
from ancf.rotation import section_rotation
from ancf.section_stress import part_sections
from ancf.section_validity import ANTICLASTIC
from ancf.sections import Annulus, Circle, Ellipse, Rectangle, Section
from ancf.solution import Solution
from ancf.validity import poisson_locking

Floats = NDArray[np.float64]

# c of M = E I k (1 - c (k R)^2) for a circle, at these Poisson ratios. Exact: reference/section.py at k R =
# .03 (.08 gives the same to 1 %); elements: 60 of them in uniform bending. Mooney-Rivlin: c01/c10 = 1/4.
POISSON_RATIOS = (0.0, 0.3, 0.45, 0.49)
EXACT: dict[type[Law], tuple[float, ...]] = {
    SaintVenantKirchhoff: (1.499, 1.505, 1.473, 1.450),
    NeoHookean: (0.500, 0.451, 0.396, 0.369),
    MooneyRivlin: (0.598, 0.598, 0.455, 0.422),  # not measured below 0.3
}
OF_ELEMENT: dict[str, dict[type[Law], tuple[float, ...]]] = {
    "3333": {
        SaintVenantKirchhoff: (1.374, 0.924, 0.700, 0.640),
        NeoHookean: (0.375, 0.524, 0.599, 0.619),
        MooneyRivlin: (1.241, 1.241, 1.390, 1.430),
    },
    "3243": {
        SaintVenantKirchhoff: (1.057, 0.652, 0.433, 0.371),
        NeoHookean: (0.058, 0.253, 0.333, 0.352),
        MooneyRivlin: (0.969, 0.969, 1.123, 1.162),
    },
    "3363": {
        SaintVenantKirchhoff: (1.374, 1.444, 1.512, 1.534),
        NeoHookean: (0.375, 0.443, 0.466, 0.460),
        MooneyRivlin: (0.588, 0.588, 0.437, 0.389),
    },
}
# Tip motion in rod lengths by a force of one E I/L^2; 1/3 is that of a straight rod.
FREE = 1e5
# dm/m of bending by a twist t: this times (t R)^2, on top of what bending does. Under oblique couples it is
# .04 to .16 (Saint Venant-Kirchhoff, neo-Hookean, nu = 0 to .49, L/R = 40; reference/section.py).
TWIST = 0.1
# J = A^4/(40 I_p) on solid sections without re-entrant corners, within 13 % (triangle; Saint-Venant 1856).
SAINT_VENANT = 40.0


def model_errors(estimate: ErrorEstimate, elements: tuple[str, ...]) -> list[dict[str, float]]:
    """Tip error over length that the sections of each of the `elements` leave (n_rods dictionaries).

    Empty at a critical point and where the shape may turn freely: there nothing holds the tip. All rods are
    taken with the same element. Shape, moments and adjoint are those of the finer mesh; the element that
    found them makes no difference of first order.
    """
    found = []
    for rod, shift in zip(estimate.finer.model.rods, model_shifts(estimate, elements), strict=False):
        errors = np.linalg.norm(shift, axis=1) / rod.rod.length
        found.append({name: float(error) for name, error in zip(elements, errors, strict=True)})
    return found


def model_shifts(
    estimate: ErrorEstimate, elements: tuple[str, ...], law_of: Callable[[Law], Law] = lambda law: law
) -> list[Floats]:
    """Motion of each tip (elements, 3) [m] from where the elements have it to where the solid would.

    law_of : another law in the place of that of a segment, at the curvatures of this equilibrium
    """
    solution = estimate.finer
    rods = solution.model.rods
    defects = [_moment_defects(solution, rod, elements, law_of) for rod in rods]
    found = []
    for index in range(len(rods)):
        z = _adjoint(estimate, index)
        if z is None:
            return []
        shift = np.zeros((len(elements), 3))
        for other, dm in zip(rods, defects, strict=True):
            shift -= np.einsum("kea,cea->kc", dm, np.diff(_spins(other, solution.q, z), axis=1))
        found.append(shift)
    return found


def _adjoint(estimate: ErrorEstimate, index: int) -> Floats | None:
    """z (3, n) of the position of a rod's tip, or of the place that stands for it; None where it is free."""
    model = estimate.finer.model
    point = model.rods[index].section_point(estimate.places[index])
    goal = np.zeros((model.n, 3))
    goal[point.dofs.reshape(-1, 3), np.arange(3)] = point.N[0][:, None]
    z = model.system.solve_transposed(estimate.factors, goal)
    softness = np.max(np.abs(z * model.force_unit[:, None])[: model.motions]) / model.rods[index].rod.length
    return z.T if softness < FREE else None


def _spins(rod: RodModel, q: Floats, z: Floats) -> Floats:
    """Spin (k, n_el + 1, 3) of the sections between elements by the variations z (k, n)."""
    element = rod.element
    inner = len(element.node_xi) - 1
    columns = [element.vectors.index((0, j, k)) for j, k in element.directors]
    directors = rod.nodal(q)[::inner, columns]
    spin = section_rotation(directors, rod.node_weights[::inner]).spin()
    nodal = z[:, rod.first_dof : rod.first_dof + rod.size].reshape(len(z), *rod.q0.shape)
    return np.einsum("nikc,znkc->zni", spin, nodal[:, ::inner, columns])


def _moment_defects(
    solution: Solution, rod: RodModel, elements: tuple[str, ...], law_of: Callable[[Law], Law]
) -> Floats:
    """dm (elements asked for, n_el, 3) [N m] in SCS, the mean over each element of the mesh."""
    name, points = rod.rod.name, rod.axial_points
    axes, moment = solution.section_axes(name), solution.section_forces(name).moment
    local = np.einsum("nia,ni->na", axes, moment)  # about the section's normal, y and z
    found = np.empty((len(elements), len(local), 3))
    for part, segment in enumerate(rod.rod.parts):
        sections = part_sections(rod, part)
        where = rod.elements_of(part)
        first = where.start * points
        count = (where.stop - where.start) * points
        for n in range(count):
            section = sections[n if len(sections) > 1 else 0]
            m = local[first + n]
            for row, element in enumerate(elements):
                own = rod.rod.formulation if element == rod.rod.element else ELEMENTS[element].formulations[0]
                share = relative_defect(element, own, section, law_of(segment.material), m)
                share[1:] -= segment.slope**2
                found[row, first + n] = axes[first + n] @ (share * m)
    return found.reshape(len(elements), -1, points, 3).mean(axis=2)


def relative_defect(element: str, formulation: str, section: Section, law: Law, moment: Floats) -> Floats:
    """dm/m (3,) of a section under a local moment (3,) [N m]: torsion, bending about y, about z.

    Parameters
    ----------
    element : of any name; linear and quadratic sections that are not in the tables count as 3333 and 3363
    formulation : of linear sections
    """
    quadratic = ELEMENTS[element].quadratic_section
    young, nu = law.young_modulus, law.poisson_ratio
    second = np.diag(section.second_moments)[::-1]  # about y, about z
    curvature = moment[1:] / (young * second)
    defect = np.array([_torsion(section, quadratic), 0.0, 0.0])
    if formulation == "continuum" and not quadratic:
        defect += 1.0 / poisson_locking(nu) - 1.0
        return defect
    table = OF_ELEMENT.get(element, OF_ELEMENT["3363" if quadratic else "3333"])[type(law)]
    difference = np.interp(nu, POISSON_RATIOS, table) - np.interp(nu, POISSON_RATIOS, EXACT[type(law)])
    # 4 I/A is R^2 of a circle.
    bending = float(np.sum(curvature**2 * second)) * 4.0 / section.area
    twist = moment[0] * 2.0 * (1.0 + nu) / (young * float(np.sum(second)))
    twisting = twist**2 * 2.0 * float(np.sum(second)) / section.area
    defect[1:] += difference * bending + np.copysign(TWIST * twisting, difference)
    defect[1:] += _changes_of_shape(section, nu, curvature, quadratic)
    return defect


def _torsion(section: Section, quadratic: bool) -> float:
    """J of Saint-Venant over that of the element, less 1."""
    I_z, I_y = np.diag(section.second_moments)
    polar = float(I_y + I_z)
    harmonic = 4.0 * float(I_y * I_z) / polar  # exact for ellipses
    held = harmonic if quadratic and isinstance(section, Rectangle | Ellipse) else polar
    if isinstance(section, Circle | Annulus):
        exact = polar
    elif isinstance(section, Ellipse):
        exact = harmonic
    elif isinstance(section, Rectangle):
        b, a = sorted((section.height_y, section.width_z))
        # Roark's Formulas for Stress and Strain, table 10.7, within 0.5 %.
        exact = a * b**3 * (1.0 / 3.0 - 0.21 * b / a * (1.0 - b**4 / (12.0 * a**4)))
    else:
        exact = section.area**4 / (SAINT_VENANT * polar)
    return exact / held - 1.0


def _changes_of_shape(section: Section, nu: float, curvature: Floats, quadratic: bool) -> Floats:
    """dm/m (2,) about y and z of tubes that flatten and strips that curve across (section_validity.py)."""
    if isinstance(section, Annulus):
        wall = section.radius - section.inner_radius
        middle = section.radius - 0.5 * wall
        loss = 1.5 * (1.0 - nu**2) * (float(np.linalg.norm(curvature)) * middle**2 / wall) ** 2
        return np.full(2, -min(loss, 1.0))
    if quadratic or not isinstance(section, Rectangle | Ellipse):
        return np.zeros(2)
    side_y, side_z = 2.0 * np.abs(section.outline(4)).max(axis=0)
    x = (np.array([side_y**2 / side_z, side_z**2 / side_y]) * curvature) ** 2 / ANTICLASTIC
    return nu**2 * x / (1.0 + (1.0 - nu**2) * x)
