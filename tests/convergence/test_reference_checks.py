"""Who checks the reference? Every quick check holds; wrong laws, assemblies and projections are caught."""

import numpy as np
import pytest

from reference import solid_forms, solid_materials
from reference.bodies import NoEquilibrium, distorted
from reference.solid_assembly import SolidAssembly
from reference.solid_mesh import circular_section, rod_mesh
from validation.criteria import BLOCKING, Verdict
from validation.reference_checks import Check, checks
from validation.reference_measures import rubbers

QUICK = list(checks())


@pytest.mark.parametrize("check", QUICK, ids=lambda check: check.name)
def test_the_solid_meets_an_answer_it_did_not_come_from(check):
    result = check.run()
    bad = [f for f in result.findings if f.verdict in BLOCKING]
    assert not bad, (result.note, result.errors, result.orders)
    assert result.findings


@pytest.mark.slow
@pytest.mark.parametrize("check", list(checks(full=True)), ids=lambda check: check.name)
def test_finer_meshes_keep_the_promised_orders(check):
    result = check.run()
    assert result.verdict not in BLOCKING, (result.note, result.errors, result.orders)


def test_every_law_and_form_is_checked():
    names = [check.name for check in QUICK]
    for rubber in rubbers(0.3):
        for form in ("displacement", "mixed"):
            own = [
                name.split(":")[0].split(",")[0] for name in names if name.endswith(f"{rubber.name}, {form}")
            ]
            assert {"patch", "rigid motion", "stretch", "oracle"} <= set(own)
    assert len(names) == len(set(names))


def test_a_check_without_an_answer_fails_with_its_reason():
    def measure(size):
        raise NoEquilibrium("residual 1e-2 after 30 iterations")

    result = Check("lost", "none", measure, 1e-3, "for the test").run()
    assert result.verdict is Verdict.FAIL
    assert result.note == "not measured: residual 1e-2 after 30 iterations"


@pytest.mark.parametrize(
    ("errors", "fails"), [((1e-2, 1.2e-3), False), ((1e-2, 3e-3), True), ((1e-2, 9e-3), True)]
)
def test_a_missed_order_fails(errors, fails):
    values = dict(zip((1.0, 0.5), errors, strict=True))
    check = Check("order", "", lambda h: {"e": values[h]}, 1.0, "", (1.0, 0.5), {"e": 3.0})
    assert (check.run().verdict is Verdict.FAIL) == fails


def test_distortion_refuses_to_turn_elements_inside_out():
    with pytest.raises(ValueError, match="inside out"):
        distorted(rod_mesh(circular_section(0.5, 2, 1), 1.0, 2), 0.1)


# --- mutants: each is an error someone could make, and some quick check has to find it ----------------------


def scaled(name, part, factor):
    """One method of a law, times a factor."""
    original = getattr(getattr(solid_materials, name), part)

    def wrong(self, F):
        return factor * original(self, F)

    return getattr(solid_materials, name), part, wrong


def transposed_stress(name):
    original = getattr(solid_materials, name).stress
    return getattr(solid_materials, name), "stress", lambda self, F: original(self, F).swapaxes(-1, -2)


def unprojected():
    return solid_forms.MixedForm, "project", lambda self, f: f


def constant_projection():
    def project(self, f):
        mean = np.sum(self.assembly.volume * f, axis=1) / self.assembly.volume.sum(axis=1)
        return np.broadcast_to(mean[:, None], f.shape)

    return solid_forms.MixedForm, "project", project


def unweighted_force():
    original = SolidAssembly.internal_force
    return SolidAssembly, "internal_force", lambda self, P: original(self, P / self.volume[..., None, None])


def negated_gradient_component():
    original = SolidAssembly.gradient

    def gradient(self, u):
        H = original(self, u)
        H[..., 0, 1] *= -1
        return H

    return SolidAssembly, "gradient", gradient


def swapped_tangent():
    original = SolidAssembly.tangent

    def tangent(self, A_pk1, K_load=None, K_element=None):
        return original(self, A_pk1.swapaxes(-1, -2), K_load, K_element)

    return SolidAssembly, "tangent", tangent


def forgotten_pressure_curvature(name):
    law = getattr(solid_materials, name)
    original = law.volume_measure

    def measure(self, F):
        g, g_F, g_FF = original(self, F)
        return g, g_F, 0 * g_FF

    return law, "volume_measure", measure


def halved_bulk_slope(name):
    law = getattr(solid_materials, name)
    original = law.volume_energy

    def volume(self, theta):
        U, U1, U2 = original(self, theta)
        return U, U1, U2 / 2

    return law, "volume_energy", volume


LAW_NAMES = ("SaintVenantKirchhoff", "NeoHookean", "MooneyRivlin")
TITLES = {
    "SaintVenantKirchhoff": "Saint Venant-Kirchhoff",
    "NeoHookean": "neo-Hookean",
    "MooneyRivlin": "Mooney-Rivlin",
}
MUTANTS = [
    *[
        (f"{n}.{p} x 1.001", n, scaled(n, p, 1.001))
        for n in LAW_NAMES
        for p in ("energy", "stress", "tangent")
    ],
    *[(f"{n} stress transposed", n, transposed_stress(n)) for n in LAW_NAMES],
    *[(f"{n} without d2g", n, forgotten_pressure_curvature(n)) for n in LAW_NAMES],
    *[(f"{n} U'' halved", n, halved_bulk_slope(n)) for n in LAW_NAMES],
    ("no projection", "MooneyRivlin", unprojected()),
    ("P0 projection", "MooneyRivlin", constant_projection()),
    ("force without weights", "NeoHookean", unweighted_force()),
    ("sign in the gradient", "NeoHookean", negated_gradient_component()),
    ("tangent indices swapped", "NeoHookean", swapped_tangent()),
]


@pytest.mark.parametrize(("law", "mutant"), [m[1:] for m in MUTANTS], ids=[m[0] for m in MUTANTS])
def test_a_wrong_reference_is_caught(law, mutant, monkeypatch):
    monkeypatch.setattr(*mutant)
    # The oracles come first: they solve nothing, while Newton's method runs long with a wrong tangent.
    quick = ("oracle, energy", "oracle, scikit-fem", "patch, brick", "rigid motion", "stretch")
    own = [c for kind in quick for c in QUICK if TITLES[law] in c.name and c.name.startswith(kind)]
    assert len(own) == 8
    with np.errstate(all="ignore"):
        assert any(check.run().verdict is Verdict.FAIL for check in own)
