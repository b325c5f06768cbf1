"""Hypothesis profiles by HYPOTHESIS_PROFILE: dev (25 examples), ci (100), gate (500), long (10 000);
ci and gate are derandomised.
"""

import os

from hypothesis import HealthCheck, settings

# A draw builds a rod, and an example solves scenes: slow by Hypothesis' standards, not by ours.
_COMMON = {"deadline": None, "suppress_health_check": [HealthCheck.too_slow, HealthCheck.data_too_large]}

settings.register_profile("dev", max_examples=25, **_COMMON)
settings.register_profile("ci", max_examples=100, derandomize=True, **_COMMON)
settings.register_profile("gate", max_examples=500, derandomize=True, print_blob=True, **_COMMON)
settings.register_profile("long", max_examples=10_000, print_blob=True, **_COMMON)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "dev"))
