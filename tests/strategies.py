"""Hypothesis strategies for rods: the random rods of `validation`, drawn by Hypothesis so that it can shrink
them.
"""

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np
from hypothesis import settings, strategies as st

from validation.random_rods import random_rotation, random_section

T = TypeVar("T")


class HypothesisDraws:
    """`validation.random_rods.Draws` from Hypothesis; its numbers favour ends, zeros and equal values."""

    def __init__(self, draw) -> None:
        self.draw = draw
        self.drawn: list[Any] = []  # what a counterexample is kept as, see `ListedDraws`

    def number(self, low: float, high: float) -> float:
        """See `Draws.number`."""
        return self._kept(self.draw(st.floats(low, high, allow_nan=False, allow_subnormal=False)))

    def choice(self, options: Sequence[T]) -> T:
        """See `Draws.choice`."""
        return self._kept(self.draw(st.sampled_from(options)))

    def _kept(self, value: T) -> T:
        self.drawn.append(value)
        return value


class ListedDraws:
    """Draws from a list, in order: the `drawn` of a counterexample that Hypothesis printed.

    A list that no longer fits what is drawn fails here, so that it cannot turn into another example.
    """

    def __init__(self, drawn: Sequence[Any]) -> None:
        self.left = list(drawn)

    def number(self, low: float, high: float) -> float:
        """See `Draws.number`."""
        value = self.left.pop(0)
        assert isinstance(value, float) and low <= value <= high, (low, value, high)
        return value

    def choice(self, options: Sequence[T]) -> T:
        """See `Draws.choice`."""
        value = self.left.pop(0)
        option = options[options.index(value)]
        assert type(option) is type(value), (value, options)  # False == 0 == 0.0
        return option


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
