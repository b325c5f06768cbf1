r"""Elastic energy, force and tangent of one rod in the Gram form.

At each axial point v = N e (section_energy.generalised_shape) and gamma_ij = v_i . v_j - v0_i . v0_j:

    T = dU/dgamma,  H = dT/dgamma       (section_law.py; T = H gamma for Saint Venant-Kirchhoff)
    Q = N^T (S v),                      S_ij = T_ij (i != j), 2 T_ii,
    K = N^T (B_v^T H B_v + S (x) I) N,  B_v = d gamma / d v.

With assumed strains (assumed_strain.py) T and H belong to gamma_bar(x_g) = sum_s A_gs gamma(x_s): the same
expressions with S of A^T T at the places x_s, and B^T H B with B = A B_v N.

What the points miss of the sections is a second energy of the same form, `control` (hourglass.py).

T and H carry the axial weight. S is the stress resultant of each product; the *mixed-integration-point*
tangent (Magisano, Leonetti, Garcea, Int. J. Numer. Meth. Eng. 109 (2017) 1183) replaces it, in the tangent
only, by the stress that the last linear step predicted: T(gamma_o) + H(gamma_o) (gamma - gamma_o) at
gamma ~ v_o . v + v . v_o - v_o . v_o - v0 . v0 with the iterate v_o before that step. It lets Newton take
long steps where axis and sections are much stiffer than bending, and vanishes at convergence.

Positions enter relative to the first node of the element: what is common to all nodes cannot cancel later.

Arrays e, v, T, H may carry leading batch axes before n_el: many states of one rod at once (batch_newton.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ancf.section_energy import pairs
from ancf.section_law import SectionLaw

Floats = NDArray[np.float64]

ALL = slice(None)


@dataclass(frozen=True)
class ElasticRod:
    """Constant data of the elastic kernel of one rod.

    Parameters
    ----------
    N : (n_el or 1, places, generalised vectors, nodal vectors of the element) [m^(...)]; the places are the
        axial points, followed by those where assumed strains are sampled besides
    section : energy of the strain products at the axial points, axial weight included
    e0 : (n_el, nodal vectors of the element, 3) reference nodal vectors
    position_columns : which nodal vectors of an element are positions
    assumed : (points, places, pairs) strain products at the axial points from those at the places; None: the
        places are the axial points
    control : energy besides, of what the axial points do not see (hourglass.py)
    """

    N: Floats
    section: SectionLaw
    e0: Floats
    position_columns: NDArray[np.intp]
    assumed: Floats | None = None
    control: ElasticRod | None = None

    @cached_property
    def _pairs(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        return pairs(self.N.shape[-2])

    @cached_property
    def v0(self) -> Floats:
        """Reference generalised vectors (n_el, places, generalised vectors, 3)."""
        return self.generalised(self.e0)

    @cached_property
    def _products0(self) -> Floats:
        return self._packed(_gram(self.v0, self.v0))

    def generalised(self, e: Floats) -> Floats:
        """Generalised vectors v (n_el, places, generalised vectors, 3) of e (n_el, nodal, 3)."""
        relative = e.copy()
        relative[..., self.position_columns, :] -= e[..., self.position_columns[:1], :]
        return self.N @ relative[..., None, :, :]

    def _packed(self, gram: Floats) -> Floats:
        i, j = self._pairs
        return gram[..., i, j]

    def gamma(self, v: Floats) -> Floats:
        """Strain products (n_el, points, pairs), exactly zero at the reference."""
        return self._at_points(self._packed(_gram(v, v)) - self._products0)

    def _at_points(self, gamma: Floats) -> Floats:
        """Strain products (n_el, points, pairs) that the sections see, from those at the places."""
        return gamma if self.assumed is None else np.einsum("gsp,...sp->...gp", self.assumed, gamma)

    def _at_places(self, T: Floats) -> Floats:
        """Resultants (n_el, places, pairs) from those at the axial points: the transpose of `_at_points`."""
        return T if self.assumed is None else np.einsum("gsp,...gp->...sp", self.assumed, T)

    def predicted_gamma(self, v: Floats, v_previous: Floats) -> Floats:
        """Strain products that the linear step from v_previous to v predicted (mixed integration point)."""
        mixed = _gram(v_previous, v)
        gram = mixed + np.swapaxes(mixed, -1, -2) - _gram(v_previous, v_previous)
        return self._at_points(self._packed(gram) - self._products0)

    def energy(self, e: Floats) -> float:
        """Strain energy [J]."""
        U = self.section.energy(self.gamma(self.generalised(e)))
        return U if self.control is None else U + self.control.energy(e)

    def _symmetric(self, T: Floats) -> Floats:
        """S (..., vectors, vectors) with Q_v = S v from the packed resultants T."""
        count = self.N.shape[-2]
        i, j = self._pairs
        S = np.zeros((*T.shape[:-1], count, count))
        S[..., i, j] = T
        return S + np.swapaxes(S, -1, -2)  # doubles the diagonal, as d(v_i . v_i) = 2 v_i . dv_i demands

    def vector_force(self, v: Floats) -> Floats:
        """Forces conjugate to v (n_el, places, generalised vectors, 3), axial weight included."""
        return self._symmetric(self._at_places(self.section.resultants(self.gamma(v)))) @ v

    def section_force(self, v: Floats) -> Floats:
        """Stress of the sections on v (n_el, points, generalised vectors, 3), axial weight included.

        The same as `vector_force` where no strain is assumed.
        """
        T = self.section.resultants(self.gamma(v))
        return self._symmetric(T) @ v[..., : T.shape[-2], :, :]

    def force(self, e: Floats) -> Floats:
        """Elastic force Q (n_el, nodal vectors, 3), the gradient of the energy (paper eq. 18)."""
        Q = self._force_to_nodes(self.vector_force(self.generalised(e)))
        return Q if self.control is None else Q + self.control.force(e)

    def force_and_tangent(self, e: Floats, e_previous: Floats | None = None) -> tuple[Floats, Floats]:
        """Elastic force (n_el, nodal, 3) and tangent (n_el, 3 nodal, 3 nodal), symmetric.

        With `e_previous` the geometric part uses the mixed-integration-point stress.
        """
        Q, K = self._force_and_tangent(e, e_previous)
        if self.control is not None:
            Q_c, K_c = self.control.force_and_tangent(e, e_previous)
            return Q + Q_c, K + K_c
        return Q, K

    def _force_and_tangent(self, e: Floats, e_previous: Floats | None) -> tuple[Floats, Floats]:
        v = self.generalised(e)
        T, H = self.section.response(self.gamma(v))
        S = self._symmetric(self._at_places(T))
        Q = self._force_to_nodes(S @ v)
        if e_previous is not None:
            v_previous = self.generalised(e_previous)
            predicted = self.predicted_gamma(v, v_previous)
            S = self._symmetric(self._at_places(self.section.predicted(self.gamma(v_previous), predicted)))
        if self.assumed is not None:
            return Q, self._assumed_material(v, H) + self.geometric_tangent(S)
        return Q, self._tangent_to_nodes(self._material(v, H) + _times_identity(S))

    def material_tangent(self, v: Floats) -> Floats:
        """Part B^T H B of the tangent (n_el, 3 nodal, 3 nodal) at v, without `control`."""
        H = self.section.response(self.gamma(v))[1]
        return (
            self._tangent_to_nodes(self._material(v, H))
            if self.assumed is None
            else self._assumed_material(v, H)
        )

    def geometric_tangent(self, S: Floats) -> Floats:
        """Part N^T S N (x) I of the tangent (n_el, 3 nodal, 3 nodal), S at the places."""
        half = S @ self.N
        return _times_identity(self._N_stacked @ half.reshape(*half.shape[:-3], -1, half.shape[-1]))

    def _material(self, v: Floats, H: Floats) -> Floats:
        """B_v^T H B_v (n_el, points, 3 vectors, 3 vectors) on the generalised vectors."""
        B_v = self._strain_changes(v)
        return np.swapaxes(B_v, -1, -2) @ (H @ B_v)

    @cached_property
    def _samplings(self) -> list[tuple[NDArray[np.intp], NDArray[np.intp], Floats]]:
        """Pairs that are sampled alike: their indices, the places, and A (points, places) for them."""
        assert self.assumed is not None
        points = len(self.assumed)
        _, first, alike = np.unique(
            self.assumed.reshape(-1, self.assumed.shape[-1]), axis=1, return_index=True, return_inverse=True
        )
        found = []
        for group, pair in enumerate(first):
            A = self.assumed[:, :, pair]
            places = np.flatnonzero(np.any(A != 0.0, axis=0))
            found.append((np.flatnonzero(alike.ravel() == group), places, A[:, places].reshape(points, -1)))
        return found

    def _assumed_material(self, v: Floats, H: Floats) -> Floats:
        """B^T H B (n_el, 3 nodal, 3 nodal), B = A B_v N the change of the assumed strains."""
        assert self.assumed is not None
        N = self._N_components
        points, size = len(self.assumed), N.shape[-1]
        B = np.empty((*v.shape[:-3], points, len(self._pairs[0]), size))
        for chosen, places, A in self._samplings:
            change = self._strain_changes(v[..., places, :, :], chosen) @ N[:, places]
            mixed = A @ change.reshape(*change.shape[:-3], len(places), -1)
            B[..., chosen, :] = mixed.reshape(*mixed.shape[:-1], len(chosen), size)
        stacked = B.reshape(*B.shape[:-3], -1, size)
        return np.swapaxes(stacked, -1, -2) @ (H @ B).reshape(stacked.shape)

    def _strain_changes(self, v: Floats, chosen: NDArray[np.intp] | slice = ALL) -> Floats:
        """B_v = d gamma / d v (n_el, places, pairs, 3 vectors), of the chosen pairs."""
        *places, count, _ = v.shape
        i, j = (side[chosen] for side in self._pairs)
        index = np.arange(len(i))
        B_v = np.zeros((*places, len(i), count, 3))
        B_v[..., index, i, :] = v[..., j, :]
        B_v[..., index, j, :] += v[..., i, :]
        return B_v.reshape(*places, len(i), 3 * count)

    @cached_property
    def _N_stacked(self) -> Floats:
        """N of all places side by side, transposed: (n_el or 1, nodal, places * vectors)."""
        kinds, points, count, nodal = self.N.shape
        return np.swapaxes(self.N.reshape(kinds, points * count, nodal), -1, -2)

    @cached_property
    def _N_components(self) -> Floats:
        """N (x) I, (n_el or 1, places, 3 vectors, 3 nodal)."""
        return np.asarray(np.kron(self.N, np.eye(3)), dtype=float)

    def _force_to_nodes(self, Q_v: Floats) -> Floats:
        return np.matmul(self._N_stacked, Q_v.reshape(*Q_v.shape[:-3], -1, 3))

    def _tangent_to_nodes(self, K_v: Floats) -> Floats:
        N = self._N_components
        kinds, points, rows, size = N.shape
        half = (K_v @ N).reshape(*K_v.shape[:-3], points * rows, size)
        return np.swapaxes(N.reshape(kinds, points * rows, size), -1, -2) @ half


def _times_identity(S: Floats) -> Floats:
    """S (x) I: (..., 3 n, 3 n) from (..., n, n)."""
    n = S.shape[-1]
    K = np.zeros((*S.shape[:-2], n, 3, n, 3))
    for a in range(3):
        K[..., a, :, a] = S
    return K.reshape(*S.shape[:-2], 3 * n, 3 * n)


def _gram(v: Floats, w: Floats) -> Floats:
    """Products v_i . w_j (n_el, points, vectors, vectors)."""
    return v @ np.swapaxes(w, -1, -2)
