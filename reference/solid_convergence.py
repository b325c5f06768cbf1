"""Error of a mesh from the same quantity on two or three meshes: Richardson extrapolation and Roache's index.

Symbols: `f` the quantity, `h` mesh size, f = f_0 + c h^p, `p` order.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

Array = NDArray[np.float64]

SAFETY_THREE = 1.25  # Roache's factor when three meshes show the order
SAFETY_TWO = 3.0  # when the order is assumed, or the meshes do not show one
LOWEST_ORDER = 0.5
ROUND_OFF = 1e-12  # of the value: differences below it show no order


@dataclass(frozen=True, eq=False)
class MeshError:
    """What the meshes say about a quantity, scalar or vector.

    `value` on the finest mesh, `extrapolated` to h = 0, `order` as observed (None when two meshes were given
    or no order shows), `error` estimated error bar of `value` in its own unit (2-norm), `extrapolated_error`
    that of `extrapolated`, `asymptotic` whether three meshes approach the limit from one side with an order
    between 1/2 and twice the formal one.
    """

    value: Array
    extrapolated: Array
    order: float | None
    error: float
    extrapolated_error: float
    asymptotic: bool

    @property
    def relative(self) -> float:
        """Error by the size of the value [-]; infinite for a value of zero."""
        size = float(np.linalg.norm(self.value))
        return self.error / size if size > 0 else np.inf


def richardson(values: Sequence[ArrayLike], sizes: Sequence[float], formal_order: float) -> MeshError:
    """Limit and error bar of a quantity from two or three meshes, the finest last.

    f_0 = f + (f - f_coarse)/((h_coarse/h)^p - 1); error bar of f = safety |f_0 - f|. The error bar of f_0 is
    three times what the third mesh changed in it: the difference of the limits that the coarse pair and the
    fine pair give with the formal order, or of the formal and the observed order if that is larger.

    Parameters
    ----------
    values : sequence of 2 or 3 floats or arrays of one shape
        The quantity, coarse to fine.
    sizes : sequence of as many floats
        Mesh sizes h, falling; only their ratios matter.
    formal_order : float
        Order of the method; an observed order above it is not trusted and replaced by it.

    Returns
    -------
    MeshError
        With three meshes in the asymptotic range the safety factor is 1.25 and p the observed order, else 3
        and the formal order, applied to the largest difference seen.

    Raises
    ------
    ValueError
        For another number of meshes, sizes that do not fall, values that are not finite.

    Notes
    -----
    Grid convergence index: Roache, Perspective: a method for uniform reporting of grid refinement studies,
    J. Fluids Eng. 116 (1994) 405-413. Ratios that differ: Celik et al., J. Fluids Eng. 130 (2008) 078001.
    """
    f, h = [np.asarray(v, float) for v in values], np.asarray(sizes, float)
    if len(f) not in (2, 3) or len(h) != len(f):
        raise ValueError(
            f"{len(f)} values with {len(h)} mesh sizes were given; two or three of each are needed."
        )
    if np.any(h <= 0) or np.any(np.diff(h) >= 0):
        raise ValueError(
            f"The mesh sizes are {h.tolist()}; they must be positive and fall from coarse to fine."
        )
    if not all(np.all(np.isfinite(v)) for v in f):
        raise ValueError("A value is not finite; leave out meshes whose solution failed.")
    fine = f[-1] - f[-2]
    ratio = h[-2] / h[-1]
    if len(f) == 2:
        change = fine / (ratio**formal_order - 1)
        error = SAFETY_TWO * _size(change)
        return MeshError(f[-1], f[-1] + change, None, error, error, False)
    coarse = f[1] - f[0]
    if _size(coarse) <= ROUND_OFF * _size(f[-1]):
        error = SAFETY_TWO * max(_size(coarse), _size(fine))
        return MeshError(f[-1], f[-1], None, error, error, True)
    order = _observed_order(_size(coarse), _size(fine), h)
    one_sided = float(np.sum(coarse * fine)) > 0
    if not one_sided or order is None or not LOWEST_ORDER <= order <= 2 * formal_order:
        largest = max(_size(coarse) / ((h[0] / h[1]) ** formal_order), _size(fine))
        return MeshError(f[-1], f[-1], order, SAFETY_TWO * largest, SAFETY_TWO * largest, False)
    limit = f[-1] + fine / (ratio ** min(order, formal_order) - 1)
    after = f[-1] + fine / (ratio**formal_order - 1)
    before = f[1] + coarse / ((h[0] / h[1]) ** formal_order - 1)
    moved = max(_size(after - before), _size(limit - after))
    return MeshError(
        f[-1], limit, order, SAFETY_THREE * _size(limit - f[-1]), SAFETY_TWO * moved, asymptotic=True
    )


def corrected(value: ArrayLike, errors: Sequence[MeshError]) -> MeshError:
    """A value corrected for independent mesh errors, f + sum_i (extrapolated_i - value_i).

    Refine the section on few slices and the axis on a coarse section, then correct one solution by both: far
    cheaper than refining both at once, where the error bars of the two directions do not separate either.

    Parameters
    ----------
    value : float or array
        The quantity on the mesh whose section and axis are the finest of the two families.
    errors : sequence of MeshError
        One per direction.

    Returns
    -------
    MeshError
        Both errors are sums over the directions; `order` is the lowest.
    """
    finest = np.asarray(value, float)
    total = finest + sum((e.extrapolated - e.value for e in errors), np.zeros_like(finest))
    orders = [e.order for e in errors if e.order is not None]
    return MeshError(
        value=finest,
        extrapolated=total,
        order=min(orders, default=None),
        error=sum(e.error for e in errors),
        extrapolated_error=sum(e.extrapolated_error for e in errors),
        asymptotic=all(e.asymptotic for e in errors),
    )


def _observed_order(coarse: float, fine: float, h: Array) -> float | None:
    """p from |f_2 - f_1|/|f_3 - f_2| = (h_1^p - h_2^p)/(h_2^p - h_3^p); None outside 0.01 to 20."""
    if fine == 0:
        return None

    def excess(p: float) -> float:
        predicted = (h[0] ** p - h[1] ** p) / (h[1] ** p - h[2] ** p)
        return float(np.log(predicted * fine / coarse))

    low, high = 0.01, 20.0
    if excess(low) * excess(high) > 0:
        return None
    return float(np.asarray(brentq(excess, low, high)))


def _size(v: Array) -> float:
    return float(np.linalg.norm(v))
