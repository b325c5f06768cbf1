"""What a solve costs: calls and seconds of each effect, seconds of each phase."""

from __future__ import annotations

import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager


class Counters:
    """Evaluations and seconds by effect name, and the seconds of the linear solves."""

    def __init__(self) -> None:
        self.calls: dict[str, int] = defaultdict(int)
        self.seconds: dict[str, float] = defaultdict(float)
        self.linear_solve = 0.0

    @contextmanager
    def effect(self, name: str) -> Iterator[None]:
        """Count one evaluation of an effect, whatever the number of its loads, and its time."""
        self.calls[name] += 1
        started = time.perf_counter()
        yield
        self.seconds[name] += time.perf_counter() - started

    @contextmanager
    def solving(self) -> Iterator[None]:
        """Time a factorisation or a back-substitution."""
        started = time.perf_counter()
        yield
        self.linear_solve += time.perf_counter() - started
