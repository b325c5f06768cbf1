"""What a solve costs: calls and seconds of each effect, seconds of each phase."""

from __future__ import annotations

import time
from collections import defaultdict


class Counters:
    """Evaluations and seconds by effect name, and the seconds of the linear solves."""

    def __init__(self) -> None:
        self.calls: dict[str, int] = defaultdict(int)
        self.seconds: dict[str, float] = defaultdict(float)
        self.linear_solve = 0.0

    def effect(self, name: str) -> _Evaluation:
        """Count one evaluation of an effect, whatever the number of its loads, and its time."""
        self.calls[name] += 1
        return _Evaluation(self, name)

    def solving(self) -> _Solving:
        """Time a factorisation or a back-substitution."""
        return _Solving(self)


# Classes, as generators of contextlib cost more than some of the effects that they time.
class _Evaluation:
    def __init__(self, counters: Counters, name: str) -> None:
        self.counters = counters
        self.name = name

    def __enter__(self) -> None:
        self.started = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        self.counters.seconds[self.name] += time.perf_counter() - self.started


class _Solving:
    def __init__(self, counters: Counters) -> None:
        self.counters = counters

    def __enter__(self) -> None:
        self.started = time.perf_counter()

    def __exit__(self, *_: object) -> None:
        self.counters.linear_solve += time.perf_counter() - self.started
