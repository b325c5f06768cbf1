r"""Section laws: energy of the strain products gamma at every axial point, as the elastic kernel needs it.

Quadratic, for Saint Venant-Kirchhoff (section_energy.py): U = 1/2 gamma^T H gamma with constant H.

By quadrature, for rubber: a sum of terms (section_terms.py) over the section.

`predicted` is the stress of the mixed-integration-point tangent (energy.py): T(gamma_o) + H(gamma_o) (gamma -
gamma_o) with the products gamma that the last linear step from gamma_o predicted.

Arrays: gamma and T (n_el, points, pairs), v (n_el, points, vectors, 3), H (n_el or 1, points, pairs, pairs);
the axial weight is included everywhere.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ancf.section_terms import ProjectedTerm, QuadraticTerm, Term

Floats = NDArray[np.float64]


class SectionLaw(Protocol):
    """Energy of the sections of one rod as a function of the strain products."""

    def energy(self, gamma: Floats) -> float:
        """Strain energy [J]."""
        ...

    def resultants(self, gamma: Floats) -> Floats:
        """T = dU/dgamma."""
        ...

    def response(self, gamma: Floats) -> tuple[Floats, Floats]:
        """T and H = dT/dgamma, symmetric."""
        ...

    def predicted(self, gamma_previous: Floats, gamma: Floats) -> Floats:
        """T that the linear law at gamma_previous predicts for gamma."""
        ...

    def smallest_volume(self, v: Floats) -> Floats | None:
        """Smallest det F of each section (n_el, points); None, or inf at a section, where the law is finite
        whatever it is.
        """
        ...


@dataclass(frozen=True)
class QuadraticSection:
    """U = 1/2 gamma^T H gamma with H (n_el or 1, points, pairs, pairs)."""

    H: Floats

    def energy(self, gamma: Floats) -> float:
        """See `SectionLaw.energy`."""
        return 0.5 * float(np.sum(gamma * self.resultants(gamma)))

    def resultants(self, gamma: Floats) -> Floats:
        """See `SectionLaw.resultants`."""
        return (self.H @ gamma[..., None])[..., 0]

    def response(self, gamma: Floats) -> tuple[Floats, Floats]:
        """See `SectionLaw.response`."""
        return self.resultants(gamma), self.H

    def predicted(self, gamma_previous: Floats, gamma: Floats) -> Floats:
        """See `SectionLaw.predicted`: a linear law predicts exactly."""
        return self.resultants(gamma)

    def smallest_volume(self, v: Floats) -> None:
        """See `SectionLaw.smallest_volume`: strain alone counts, and it is finite."""
        return


@dataclass(frozen=True)
class AlikeSections:
    """Axial points with one reference in section axes: which they are, their axial weights, their terms."""

    points: NDArray[np.intp]  # (m,) places in the flattened (n_el, points)
    axial_weight: Floats  # (m,) [m]
    terms: tuple[Term | ProjectedTerm | QuadraticTerm, ...]

    def of(self, gamma: Floats) -> Floats:
        """The products (batch times m, pairs) of these points, from all (..., n_el, points, pairs)."""
        flat = gamma.reshape(*gamma.shape[:-3], -1, gamma.shape[-1])
        return flat[..., self.points, :].reshape(-1, gamma.shape[-1])

    def shaped(self, values: Floats, gamma: Floats) -> Floats:
        """Values (batch times m, ...) of these points as (..., m, ...) with the batch axes of gamma."""
        return values.reshape(*gamma.shape[:-3], len(self.points), *values.shape[1:])


@dataclass(frozen=True)
class QuadratureSection:
    """Potentials summed over section points, one group of alike sections after the other."""

    groups: tuple[AlikeSections, ...]

    def energy(self, gamma: Floats) -> float:
        """See `SectionLaw.energy`."""
        return float(
            sum(
                np.sum(group.axial_weight * group.shaped(term.energy(group.of(gamma)), gamma))
                for group in self.groups
                for term in group.terms
            )
        )

    def resultants(self, gamma: Floats) -> Floats:
        """See `SectionLaw.resultants`."""
        return self._summed(gamma, lambda group, term: (term.resultants(group.of(gamma)),))[0]

    def response(self, gamma: Floats) -> tuple[Floats, Floats]:
        """See `SectionLaw.response`."""
        T, H = self._summed(gamma, lambda group, term: term.response(group.of(gamma)))
        return T, H

    def predicted(self, gamma_previous: Floats, gamma: Floats) -> Floats:
        """See `SectionLaw.predicted`."""
        return self._summed(
            gamma, lambda group, term: (term.predicted(group.of(gamma_previous), group.of(gamma)),)
        )[0]

    def _summed(
        self, gamma: Floats, values: Callable[[AlikeSections, Term | ProjectedTerm | QuadraticTerm], tuple]
    ) -> list[Floats]:
        """Values of the terms, each an array (m, ...) a group, summed and put in place (..., points, ...)."""
        places = gamma.shape[:-1]
        found: list[Floats] = []
        for group in self.groups:
            parts = [values(group, term) for term in group.terms]
            for which, part in enumerate(zip(*parts, strict=True)):
                total = group.shaped(np.sum(part, axis=0), gamma)
                if which == len(found):
                    found.append(
                        np.empty((*places[:-2], places[-2] * places[-1], *total.shape[len(places) - 1 :]))
                    )
                weight = group.axial_weight.reshape(-1, *(1,) * (total.ndim - len(places) + 1))
                found[which][(*(slice(None),) * (len(places) - 2), group.points)] = weight * total
        return [value.reshape(*places, *value.shape[len(places) - 1 :]) for value in found]

    def smallest_volume(self, v: Floats) -> Floats:
        """See `SectionLaw.smallest_volume`: over the points of every rule; inf where strain alone counts."""
        flat = v.reshape(*v.shape[:-4], -1, *v.shape[-2:])
        smallest = np.full(flat.shape[:-2], np.inf)
        for group in self.groups:
            for term in group.terms:
                if isinstance(term, QuadraticTerm):
                    continue
                # Columns of F (..., m, n, 3): the triple product is the determinant.
                c_x, c_y, c_z = np.einsum(
                    "...miv,nia->a...mnv", flat[..., group.points, :, :], term.weights_local
                )
                determinant = np.sum(np.cross(c_x, c_y) * c_z, axis=-1).min(axis=-1)
                smallest[..., group.points] = np.minimum(smallest[..., group.points], determinant)
        return smallest.reshape(v.shape[:-2])
