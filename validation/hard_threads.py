"""The hard cases solved in a process of its own with a given number of BLAS threads.

OpenBLAS reads its number of threads when it is loaded, so one and two threads need two processes; each
solves all cases, in a few seconds. Run as ``python -m validation.hard_threads`` it writes the shapes as JSON.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np

from validation.hard_drift import Shape, shape_of

# Every BLAS that NumPy or SciPy may be built with.
VARIABLES = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS")
PATIENCE = 600.0  # s


@cache
def shapes_with(threads: int, names: tuple[str, ...] = ()) -> dict[str, Shape]:
    """Shapes of the named cases (all but the costly) that converge, by name, with a number of threads."""
    environment = {**os.environ, **dict.fromkeys(VARIABLES, str(threads))}
    # The packages of this process, wherever the other one is started.
    home = str(Path(__file__).parent.parent)
    environment["PYTHONPATH"] = os.pathsep.join([home, *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(
        [sys.executable, "-m", "validation.hard_threads", *names],
        env=environment, capture_output=True, text=True, timeout=PATIENCE, check=True,
    )  # fmt: skip
    return {name: [np.array(r) for r in shape] for name, shape in json.loads(done.stdout).items()}


def main() -> None:
    """Solve the cases named on the command line, or all quick ones that must converge; print their shapes."""
    from validation.hard_cases import hard_cases
    from validation.hard_ending import solve_case

    found = {}
    for case in hard_cases():
        wanted = case.name in sys.argv[1:] if sys.argv[1:] else case.drifts == "quick"
        if case.solvable and wanted:
            solution = solve_case(case, case.scene)
            if solution.status == "converged":
                found[case.name] = [r.tolist() for r in shape_of(solution)]
    sys.stdout.write(json.dumps(found))


if __name__ == "__main__":
    main()
