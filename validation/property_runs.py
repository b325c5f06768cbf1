"""Seeded runs of the property checks for the report: examples run, and the worst value against its bound."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from validation.criteria import Finding, Limit, Verdict, judge, largest

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


def run(examples: int, solved: int) -> Iterator[PropertyResult]:
    """Run every property on `examples` random rods, one result at a time.

    `solved` is their number where each solves scenes; fewer where they are dear (`Property.cost`).
    The examples are the same on every machine, and so is the verdict.
    """
    from validation.properties import PROPERTIES

    for index, check in enumerate(PROPERTIES):
        started = time.perf_counter()
        worst, seed = 0.0, (SEED, index, 0)
        count = max(1, (solved if check.solves else examples) // check.cost)
        for example in range(count):
            key = (SEED, index, example)
            try:
                observed = largest(abs(float(check.run(np.random.default_rng(key)))))
            except Exception:
                observed = float("inf")  # an example that cannot be run has not met its bound
            if observed > worst:
                worst, seed = observed, key
        limit = Limit(check.name, check.bound, check.unit, check.title)
        yield PropertyResult(
            check.name, check.title, check.bound, check.unit, count, judge(limit, check.name, worst), seed,
            time.perf_counter() - started,
        )  # fmt: skip
