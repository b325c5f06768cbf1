"""Root of a scalar function in a bracket, to rounding."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

from scipy.optimize import brentq

RELATIVE = 1e-14


def bracketed_root(
    function: Callable[[float], float], low: float, high: float, absolute: float = 1e-300
) -> float:
    """Root of a continuous function whose signs differ at `low` and `high`, to 1e-14 relative (Brent 1973).

    A root that may be zero itself needs a larger `absolute` tolerance to stop at.
    """
    rtol = cast(Any, RELATIVE)  # scipy's stubs ask for a NumPy scalar
    return float(cast(Any, brentq(function, low, high, xtol=absolute, rtol=rtol)))
