"""Seeded runs of the property checks for the report: examples run, and the worst value against its bound."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from validation.criteria import Finding, Limit, Verdict, judge

SEED = 8611  # any other serves; printed, so that a failing example can be found again


@dataclass(frozen=True)
class PropertyResult:
    """One property: examples run, the worst of them, and its verdict."""

    name: str
    title: str
    bound: float
    unit: str
    examples: int
    finding: Finding
    worst_seed: tuple[int, int, int]
    seconds: float

    @property
    def verdict(self) -> Verdict:
        """Verdict of the worst example."""
        return self.finding.verdict


def run(examples: int, seconds_each: float) -> Iterator[PropertyResult]:
    """Run every property on up to `examples` random rods, one result at a time.

    A property stops early when its share of time is used up, but never before three examples.
    """
    from validation.properties import PROPERTIES

    for index, check in enumerate(PROPERTIES):
        started = time.perf_counter()
        worst, seed, count = 0.0, (SEED, index, 0), 0
        for example in range(examples):
            if count >= 3 and time.perf_counter() - started > seconds_each:
                break
            key = (SEED, index, example)
            try:
                observed = abs(float(check.run(np.random.default_rng(key))))
            except Exception:
                observed = float("inf")  # an example that cannot be run has not met its bound
            count += 1
            if not observed <= worst:
                worst, seed = observed, key
        limit = Limit(check.name, check.bound, check.unit, check.title)
        yield PropertyResult(
            check.name, check.title, check.bound, check.unit, count, judge(limit, check.name, worst), seed,
            time.perf_counter() - started,
        )  # fmt: skip
