"""Small designs, a stub of the certificate and a gate that knows it, for the tests of data sets."""

from __future__ import annotations

import copy
import json
from pathlib import Path

from surrogate.design import design_from_dict
from tests.regimes import REGIME
from validation.certificate import Certificate, Verification
from validation.domain import domain_of

ID = "c" * 64
# A rod of six elements under a tip moment, three blocks of rows.
SMALL = {
    "title": "small",
    "rod": [
        {
            "name": "arm", "length": 0.4, "elements": 6, "section": {"shape": "circle", "radius": 0.01},
            "material": {"young_modulus": 1.0e6, "poisson_ratio": 0.3, "density": 1000.0},
            "base": {"position": [0.1, 0.2, 0.3], "x_axis": [0, 0, 1], "y_axis": [0, 1, 0]},
        }
    ],
    "moment": [{"value": [0, 0, 0], "frame": "body"}],
    "design": {
        "sampling": "sobol", "count": 300, "seed": 7,
        "vary": [{"load": "moment", "component": axis, "range": [-0.01, 0.01]} for axis in "xyz"],
    },
}  # fmt: skip
# A case at least as hard as any row of it: |M| L/(E I) < 0.9, kappa R < 0.023.
VOUCHED = {
    "loads": ["bending", "torsion"], "elements": 6, "kappa_R": 0.03, "turn": 1.0,
    "turn_per_element": 0.2, "turn_by_aspect": 1.4, "strain": 0.05,
}  # fmt: skip


def tables(**design):
    """The small design as a dictionary, with other entries in [design]."""
    found = copy.deepcopy(SMALL)
    found["design"].update(design)
    return found


def small(**design):
    return design_from_dict(tables(**design))


def certificate(*changes):
    """A certificate whose domain comes from cases of the given regimes."""
    regimes = [{**REGIME, **change} for change in (changes or (VOUCHED,))]
    domain = json.loads(json.dumps(domain_of(regimes)))
    return Certificate({"id": ID, "predicate": {"domain": domain}})


def valid(*changes):
    """What `verify` says of a certificate that holds."""
    found = certificate(*changes)
    return lambda: Verification(Path("certificate.json"), found)


def stale():
    """What `verify` says after an edit of the solver."""
    return Verification(Path("certificate.json"), certificate(), ["ancf/energy.py changed"])
