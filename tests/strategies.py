"""Hypothesis strategies for rods: the random rods of `validation`, drawn by Hypothesis so that it can shrink
them.
"""

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

from validation.random_rods import random_rotation, random_section

T = TypeVar("T")


class HypothesisDraws:
    """`validation.random_rods.Draws` from Hypothesis; its numbers favour ends, zeros and equal values."""

    def __init__(self, draw) -> None:
        self.draw = draw

    def number(self, low: float, high: float) -> float:
        """See `Draws.number`."""
        return self.draw(st.floats(low, high, allow_nan=False, allow_subnormal=False))

    def choice(self, options: Sequence[T]) -> T:
        """See `Draws.choice`."""
        return self.draw(st.sampled_from(options))


@st.composite
def draws(draw):
    """A source of numbers."""
    return HypothesisDraws(draw)


@st.composite
def rotations(draw):
    """Rotation matrices (3, 3)."""
    return random_rotation(HypothesisDraws(draw))


@st.composite
def sections(draw, shape=None):
    """Sections of radius about 1."""
    return random_section(HypothesisDraws(draw), 1.0, shape)


def vectors(size=1.0):
    """Vectors (3,) with components in [-size, size]."""
    number = st.floats(-size, size, allow_nan=False, allow_subnormal=False)
    return st.tuples(number, number, number).map(np.array)


def fewer(share: int) -> int:
    """A share of the profile's examples, for tests whose examples are dear."""
    return max(settings().max_examples // share, 5)
