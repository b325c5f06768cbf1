"""Cross-check problems: loads in SI, deviations from made-up references, no answer where there is none."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from reference.cache import Cache
from reference.rod import RodNotSolved
from reference.rotation import exp
from reference.section_answer import NoAnswer, section_answer
from reference.solid import SolidTooLarge
from validation import exact, problems_cross, problems_stress
from validation.cases import Case, Reference
from validation.criteria import Limit, Verdict
from validation.exact import Answer, answer
from validation.problems import run_case
from validation.report.matrix import matrices
from validation.scenes import solve

LENGTH, RADIUS, MODULUS = 0.4, 0.01, 1.0e6
EI = MODULUS * np.pi * RADIUS**4 / 4
ROD = {
    "length": LENGTH, "elements": 4, "element": "3333", "section": {"shape": "circle", "radius": RADIUS},
    "material": {"young_modulus": MODULUS, "poisson_ratio": 0.3, "density": 1000.0},
    "supports": [{"at": 0.0, "kind": "free_section_clamp"}],
}  # fmt: skip
SCENE = {"rod": [ROD]}
ANY = tuple(Limit(name, 1e-2, "-", "test") for name in ("tip position, *", "tip rotation, *"))


@pytest.fixture(autouse=True)
def own_store(tmp_path, monkeypatch):
    """Tests neither read nor write the shipped answers."""
    monkeypatch.setattr(exact, "session", lambda: Cache(tmp_path))


def case(problem: str = "cross-check", limits=ANY, **parameters) -> Case:
    return Case(
        "X-3333", "X", "family", "title", problem, "tip moment", "shows", "quick", True, SCENE,
        {"load": "bending", "sizes": [90], "against": ["section"], **parameters},
        Reference("r", "section problem", "s"), limits, place={"element": "3333"},
    )  # fmt: skip


def test_a_bit_of_the_load_does_not_change_the_key():
    """0.02372501057954172 and ...725 once were two solids, of half a minute each."""
    store = exact.session()
    for bit in (1.0, 1.0 + 2e-16):
        answer("section", problems_cross.loaded({"rod": [{**ROD, "length": LENGTH * bit}]}, "torsion", 90))
    assert len(list(store.folder.glob("*.json"))) == 1


@pytest.mark.parametrize("error", [NoAnswer("a"), RodNotSolved("b"), SolidTooLarge("c")])
def test_whatever_a_reference_fails_of_its_cases_are_inconclusive(monkeypatch, error):
    def fails(**inputs):
        raise error

    monkeypatch.setattr(exact, "section_answer", fails)
    result = run_case(case())
    assert result.verdict is Verdict.INCONCLUSIVE
    assert str(error) in result.outcome.notes[0]


def test_loads_of_every_family_are_in_si_units():
    bent = problems_cross.loaded(SCENE, "bending", 90)
    assert bent["moment"][0]["value"] == pytest.approx([0, 0, EI * np.pi / 2 / LENGTH])
    twisted = problems_cross.loaded(SCENE, "torsion", 90)
    assert twisted["moment"][0]["value"] == pytest.approx(
        [EI / 1.3 * np.pi / 2 / LENGTH, 0, 0]
    )  # GJ = EI/(1+nu)
    both = problems_cross.loaded(SCENE, "bending and torsion", 2)
    assert both["moment"][0]["value"] == pytest.approx([v * EI / LENGTH for v in (1.2, 1.0, -1.6)])
    pushed = problems_cross.loaded(SCENE, "tip force", 3)
    assert pushed["force"][0]["value"] == pytest.approx([0, 3 * EI / LENGTH**2, 0])
    assert problems_cross.loaded(SCENE, "gravity", 2)["gravity"]["acceleration"] == pytest.approx(
        [0, -19.62, 0]
    )
    with pytest.raises(ValueError, match="load family"):
        problems_cross.loaded(SCENE, "wind", 1)


def test_the_deviation_is_that_from_the_reference(monkeypatch):
    """A reference 3e-3 L beside the beam's own answer and turned by 4e-3 rad from it."""
    scene = problems_cross.loaded(SCENE, "bending", 90)
    tip = solve(scene).tip()

    def beside(source, scene, support):
        turned = exp(np.array([0.0, 4e-3, 0.0])) @ tip.rotation
        return Answer(tip.position / LENGTH + [0.0, 0.0, 3e-3], turned, 1e-5, 2e-5)

    monkeypatch.setattr(problems_cross, "answer", beside)
    result = run_case(case())
    observed = {f.quantity: (f.observed, f.reference_error) for f in result.findings}
    assert observed["tip position, 90, section"] == pytest.approx((3e-3, 1e-5), rel=1e-9)
    assert observed["tip rotation, 90, section"] == pytest.approx((4e-3, 2e-5), rel=1e-6)
    assert result.verdict == "PASS"
    strict = tuple(replace(limit, value=2e-3) for limit in ANY)
    assert run_case(case(limits=strict)).verdict == "FAIL"
    unsure = tuple(replace(limit, value=2e-5) for limit in ANY)
    assert run_case(case(limits=unsure)).verdict == "INCONCLUSIVE"  # own errors 1e-5 and 2e-5 > 2e-5/3


def test_a_reference_that_does_not_converge_makes_the_case_inconclusive_and_says_why(monkeypatch):
    def fails(kind, compute, inputs):
        raise NoAnswer("solid of 24 slices: not_converged, residual 1e-3")

    monkeypatch.setattr(exact, "_stored", fails)
    result = run_case(case(against=["solid"]))
    assert {f.verdict for f in result.findings} == {"INCONCLUSIVE"}
    assert result.outcome is not None
    assert "residual 1e-3" in result.outcome.notes[0]
    rated = run_case(case("gap rate", (Limit("*", 1.0, "-", "t"),), radii=[0.02, 0.01]))
    assert rated.verdict == "INCONCLUSIVE"


def test_a_model_error_of_first_order_fails_the_rate(monkeypatch):
    limits = (
        Limit(problems_cross.QUANTITY_ORDER, 0.1, "-", "t"),
        Limit(problems_cross.QUANTITY_SIZE, 1e3, "-", "t"),
    )

    def beside(order):
        def made_up(source, scene, support="soft"):
            radius = scene["rod"][0]["section"]["radius"]
            tip = solve(scene).tip()
            return Answer(
                tip.position / LENGTH + [0, 0, 0.5 * (radius / RADIUS) ** order], tip.rotation, 0.0, 0.0
            )

        return made_up

    monkeypatch.setattr(problems_cross, "answer", beside(2))
    second = run_case(case("gap rate", limits, radii=[0.02, 0.01, 0.005]))
    assert second.verdict == "PASS"
    kappa_R = np.pi / 2 * 0.005 / LENGTH
    assert second.findings[1].observed == pytest.approx(0.5 * 0.25 / kappa_R**2)
    monkeypatch.setattr(problems_cross, "answer", beside(1))
    first = run_case(case("gap rate", limits, radii=[0.02, 0.01, 0.005]))
    assert first.verdict == "FAIL"
    assert first.findings[0].observed == pytest.approx(1.0)


def test_the_thin_limit_of_the_section_answer_is_the_helix():
    """R/L = 1e-3: the closed-form helix (reference.helix) within (kappa R)^2 = 6e-6."""
    from reference.analytic import helix_tip_moment

    thin = 4e-4
    stiffness = MODULUS * np.pi * thin**4 / 4
    moment = np.array([0.6, 0.5, -0.8]) * stiffness / LENGTH
    found = section_answer(
        {"law": "neo-hookean", "young_modulus": MODULUS, "poisson_ratio": 0.3},
        {"shape": "circle", "radius": thin}, LENGTH, list(moment),
    )  # fmt: skip
    wanted = helix_tip_moment(moment, LENGTH, stiffness, stiffness / 1.3, LENGTH)
    np.testing.assert_allclose(np.array(found["position"]) * LENGTH, wanted.position[0], atol=1e-5 * LENGTH)
    np.testing.assert_allclose(found["rotation"], wanted.rotation[0], atol=1e-5)


def test_the_rod_and_the_section_problem_agree_on_a_thin_rod():
    thin = {"rod": [{**ROD, "section": {"shape": "circle", "radius": 4e-4}}]}
    scene = problems_cross.loaded(thin, "bending", 60)
    rod, section = answer("rod", scene), answer("section", scene)
    np.testing.assert_allclose(rod.position, section.position, atol=1e-5)  # (kappa R)^2 = 1e-6, shear-free


def test_a_matrix_puts_every_quantity_of_every_case_in_its_cell(monkeypatch):
    def perfect(source, scene, support):
        tip = solve(scene).tip()
        return Answer(tip.position / LENGTH, tip.rotation, 0.0, 0.0)

    monkeypatch.setattr(problems_cross, "answer", perfect)
    first = replace(case(sizes=[45, 90]), id="X-A", place={"element": "A"})
    second = replace(case(sizes=[90]), id="X-B", place={"element": "B"})
    (matrix,) = matrices([run_case(first), run_case(second)])
    assert matrix.groups == [("tip position", 2), ("tip rotation", 2)]
    assert matrix.columns == ["45, section", "90, section"] * 2
    assert [row.names for row in matrix.rows] == [["A"], ["B"]]
    assert [cell is None for cell in matrix.rows[1].cells] == [True, False, True, False]
    cell = matrix.rows[0].cells[3]
    assert cell is not None
    assert cell.quantity == "tip rotation, 90, section"
    assert math.isfinite(cell.observed or 0.0)


def test_the_middle_third_of_the_ladder_is_that_of_the_section_problem(monkeypatch):
    """Bending with torsion: the turn between the thirds by the section problem itself is met exactly."""
    from reference.section import bend_and_twist
    from reference.solid_materials import SaintVenantKirchhoff
    from reference.solid_mesh import circular_section

    scene = problems_cross.loaded(SCENE, "bending and torsion", 1)
    moment = scene["moment"][0]["value"]
    state = bend_and_twist(circular_section(RADIUS, 3), SaintVenantKirchhoff(MODULUS, 0.3), moment)
    third = state.rotation(2 * LENGTH / 3) @ state.rotation(LENGTH / 3).T
    exact_answer = answer("section", scene)

    def made_up(source, scene, support="soft"):
        if source == "section":
            return exact_answer
        values = {"third": third, "third_error": 1e-6, "unknowns": 5}
        return Answer(exact_answer.position, exact_answer.rotation, 1e-6, 1e-6, values=values)

    monkeypatch.setattr(problems_cross, "answer", made_up)
    limits = (Limit("turn of *", 1e-6, "angle", "t"),)
    result = run_case(case("ladder", limits, load="bending and torsion", sizes=[1]))
    observed = {f.quantity: f.observed for f in result.findings}
    assert observed["turn of middle third by the angle, 1"] == pytest.approx(0.0, abs=1e-9)
    assert observed["turn of tip by the angle, 1"] == pytest.approx(0.0, abs=1e-9)
    turned = exp(np.array([0.0, 0.0, 1e-3])) @ third
    third = turned
    again = run_case(case("ladder", limits, load="bending and torsion", sizes=[1]))
    # |M| L/EI = 1.118: the turn of 1e-3 by the whole angle
    wanted = 1e-3 / np.linalg.norm(problems_cross.BOTH)
    assert again.findings[1].observed == pytest.approx(wanted, rel=1e-5)


@pytest.mark.parametrize(("sign", "verdict"), [(1.0, Verdict.PASS), (-1.0, Verdict.INCONCLUSIVE)])
def test_stress_of_the_middle_section(monkeypatch, sign, verdict):
    """Compression towards +y; a made-up solid that contradicts the section problem proves nothing."""
    points = 0.9 * RADIUS * np.array([[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0]])
    axial = sign * MODULUS * np.array([0.0, -0.0353, 0.0353, 0.0])  # kappa y E, kappa R = 0.0393
    solid = Answer(
        np.zeros(3),
        np.eye(3),
        0.0,
        0.0,
        values={"stress": {"points": points.tolist(), "axial": axial.tolist()}},
    )
    monkeypatch.setattr(problems_stress, "answer", lambda source, scene: solid)
    limits = (
        Limit("axial stress, 90, section", 0.05, "-", "test"),
        Limit("axial stress, 90, solid", 0.2, "-", "t"),
    )
    result = run_case(case("section stress", limits))
    assert result.verdict is verdict
    assert result.outcome.observed["axial stress, 90, section"] < 0.04
    assert result.outcome.reference_error["axial stress, 90, section"] < 1e-3


def test_without_a_solid_the_stress_is_inconclusive(monkeypatch):
    lost = Answer(np.full(3, np.nan), np.full((3, 3), np.nan), math.inf, math.inf, "no mesh converged")
    monkeypatch.setattr(problems_stress, "answer", lambda source, scene: lost)
    result = run_case(case("section stress", (Limit("axial stress, *", 0.2, "-", "test"),)))
    assert result.verdict is Verdict.INCONCLUSIVE
    assert "no mesh converged" in result.outcome.notes[0]
