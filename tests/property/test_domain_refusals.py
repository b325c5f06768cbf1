"""What lies beyond the cases that passed is refused, and the reason names what is beyond."""

from __future__ import annotations

import copy

import pytest
from hypothesis import example, given, settings, strategies as st

import ancf
from tests.regimes import REGIME
from validation.domain import FLOOR, MEASURED, ROUNDING, SETTINGS, WORDS, domain_of, outside
from validation.regime import HARDNESS, regimes

L, R = 0.4, 0.01
SCENE = {
    "rod": [
        {
            "length": L, "elements": 8, "section": {"shape": "circle", "radius": R},
            "material": {"young_modulus": 1.0e6, "poisson_ratio": 0.3, "density": 100.0},
        }
    ],
    "force": [{"value": [0.005, 0.01, 0.01]}],
    "gravity": {"acceleration": [0, 0, -9.81]},
    "tendon": [{"tension": 0.4, "path": [[0, 0.006, 0.002], [1, 0.006, 0.0]]}],
}  # fmt: skip


def solved(changes=()):
    """The scene with changes, each a path of keys and a value, and its solution."""
    tables = copy.deepcopy(SCENE)
    for *path, last, value in changes:
        at = tables
        for key in path:
            at = at[key]
        at[last] = value
    scene = ancf.scene_from_dict(tables)
    return scene, ancf.solve(scene)


@pytest.fixture(scope="module")
def tried():
    """Domain of the scene alone, tried at a curvature and strain that no change here reaches."""
    (regime,) = regimes(solved()[1])
    measured = {name: 10.0 * regime[name] for name in MEASURED - {"slenderness", "flatness"}}
    return domain_of([{**regime, **measured}])


def reasons(tried, *changes):
    return outside(tried, *solved(changes))


def test_the_scene_that_was_tried_is_inside(tried):
    assert reasons(tried) == []
    # Less of every load is inside, too.
    assert reasons(tried, ("tendon", 0, "tension", 0.2), ("force", 0, "value", [0.001, 0.005, 0.0])) == []


ROD, FORCE, TENDON = ("rod", 0), ("force", 0), ("tendon", 0)
# A number of the scene, its value times a factor, and the words that have to name it.
SIZES = [
    (lambda f: [(*ROD, "length", L * f), (*ROD, "elements", 60)], "L/R"),
    (lambda f: [(*ROD, "section", {"shape": "circle", "radius": R * f}), (*ROD, "elements", 60)], "L/R"),
    (lambda f: [(*ROD, "material", "poisson_ratio", 0.3 * min(f, 1.6))], "poisson_ratio"),
    (lambda f: [(*ROD, "elements", int(8 / f))], "elements are fewer than 8"),
    (lambda f: [(*ROD, "material", "density", 100.0 * f)], "gravity: rho A g L3/EI across the axis"),
    (lambda f: [("gravity", "acceleration", [0, 0, -9.81 * f])], "gravity: rho A g L3/EI across the axis"),
    (lambda f: [("gravity", "acceleration", [f - 1, 0, -9.0])], "gravity: rho A g L3/EI along the axis"),
    (lambda f: [("gravity", "acceleration", [1 - f, 0, -9.0])], "gravity: rho A g L3/EI against the axis"),
    (lambda f: [(*FORCE, "value", [0.005, 0.01 * f, 0.01 * f])], "force: F L2/EI across the axis"),
    (lambda f: [(*FORCE, "value", [0.005 * f, 0.01, 0.01])], "force: F L2/EI along the axis"),
    (lambda f: [(*FORCE, "value", [-0.001 * f, 0.01, 0.01])], "force: F L2/EI against the axis"),
    (lambda f: [("force", SCENE["force"] + [{"value": [0, 0.001 * f, 0]}])], "force: F L2/EI across"),
    (lambda f: [(*TENDON, "tension", 0.4 * f)], "tendon: T L2/EI"),
    (lambda f: [(*TENDON, "path", [[0, 0.0, 0.0064 * f], [1, 0.0, 0.0064 * f]])], "tendon: offset/R"),
    (lambda f: [(*TENDON, "path", [[0, 0.0, 0.0], [1, 0.002 * f, 0.0]])], "tendon: slope"),
    (lambda f: [("tendon", SCENE["tendon"] * 2), (*TENDON, "tension", 0.1)], "tendon: number of tendons"),
    (lambda f: [("solver", {"tolerance": 1e-10 * f})], "tolerance of the solver"),
]  # fmt: skip


@pytest.mark.parametrize(("change", "words"), SIZES, ids=[words for _, words in SIZES])
@settings(max_examples=4)
@example(factor=1.02)
@given(factor=st.floats(1.02, 1.5))
def test_more_than_was_tried_is_refused_by_name(tried, change, words, factor):
    (reason,) = reasons(tried, *change(factor))
    assert words in reason


PATH = [[0, 0.006, 0], [1, 0.006, 0]]
KINDS = [
    ([(*ROD, "element", "3243")], "has 3243"),
    ([(*ROD, "formulation", "continuum")], "has 3333, continuum"),
    ([(*ROD, "material", "law", "neo-hookean")], "neo-hookean"),
    ([(*ROD, "section", {"shape": "annulus", "radius": R, "inner_radius": 0.002})], "section annulus"),
    ([(*ROD, "section", {"shape": "rectangle", "height_y": 0.02, "width_z": 0.01})], "section rectangle"),
    ([(*ROD, "axial_rule", "full")], "axial_rule full"),
    ([(*ROD, "shear_factors", [0.9, 0.9])], "shear_factors 0.9 0.9"),
    ([(*ROD, "curvature", [0, 0, 0.5])], "reference curved"),
    ([(*ROD, "supports", [{"at": 0.0, "kind": "free_section_clamp"}])], "supports free_section_clamp at 0"),
    ([(*FORCE, "direction", "follower")], "follower force"),
    ([(*FORCE, "at", 0.7)], "force, between the ends"),
    ([(*FORCE, "offset", [0.001, 0.0])], "force, off the axis"),
    ([(*TENDON, "friction", 0.1)], "tendon, with friction"),
    ([(*TENDON, "path", [[0, 0.006, 0], [0.9, 0.006, 0]])], "tendon, along a part"),
    ([("tendon", [{"length": 0.3999, "path": PATH}])], "tendon, of given length"),
    ([("moment", [{"value": [0, 0, 1e-3]}])], "bending"),
    ([("moment", [{"value": [1e-3, 0, 0]}])], "torsion"),
    ([("moment", [{"value": [0, 0, 1e-3], "direction": "follower"}])], "follower bending"),
    ([("moment", [{"value": [0, 0, 1e-3], "definition": "vorticity"}])], "bending, vorticity"),
    ([("line_load", [{"value": [0, 1e-3, 0]}])], "line load"),
    ([("line_load", [{"value": [0, 1e-3, 0], "direction": "follower"}])], "follower line load"),
    ([("line_moment", [{"value": [0, 0, 1e-3]}])], "line moment"),
    ([("magnet", [{"remanence": [0.01, 0, 0], "field": [0, 1e-4, 0]}])], "magnet"),
    ([("pressure", [{"value": 10.0, "chamber": {"centre": [0.004, 0], "radius": 0.002}}])], "pressure"),
    ([("pressure", [{"value": -10.0, "chamber": {"centre": [0.004, 0], "radius": 0.002}}])], "suction"),
    ([("spring", [{"stiffness": 0.01}])], "spring"),
    ([("spring", [{"stiffness": 0.01, "anchor": [0.4, 0.1, 0]}])], "spring to an anchor"),
    ([("foundation", [{"stiffness": 0.01}])], "foundation"),
    (
        [("contact", [{"with": {"shape": "plane", "point": [0, 0, -1], "normal": [0, 0, 1]}}])],
        "contact",
    ),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "words"), KINDS, ids=[words for _, words in KINDS])
def test_what_was_never_tried_is_refused_by_name(tried, changes, words):
    assert any(words in reason for reason in reasons(tried, *changes))


def test_two_loads_that_were_tried_one_by_one_are_not_tried_together():
    """Weight and a force each passed alone, hard: nothing is known of both."""
    scene, solution = solved([("tendon", [])])
    (both,) = regimes(solution)
    alone = [{**both, "loads": [load]} for load in both["loads"]]
    (reason,) = outside(domain_of(alone), scene, solution)
    assert reason.endswith(
        "no case that passed has 3333, enhanced, saint-venant-kirchhoff and force + gravity at once"
    )
    assert outside(domain_of([*alone, both]), scene, solution) == []
    # A case with both vouches for the weight alone, but not where the weight alone bends the rod more.
    scene, solution = solved([("tendon", []), ("force", [])])
    (reason,) = outside(domain_of([both]), scene, solution)
    assert "kappa R" in reason
    bent = {**both, **{name: 2.0 * both[name] for name in MEASURED - {"slenderness", "flatness"}}}
    assert outside(domain_of([bent]), scene, solution) == []


def test_a_branch_that_was_turned_into_is_refused(tried):
    scene = ancf.scene_from_dict({**SCENE, "stability": {"branch": "buckled"}})
    assert any("buckled branch" in reason for reason in outside(tried, scene))


NUMBERS = (*HARDNESS, "force: F L2/EI across the axis", "gravity: weight")
sizes = st.fixed_dictionaries({name: st.sampled_from([0.01, 0.02, 0.05, 0.1]) for name in NUMBERS})
cases = st.lists(
    st.tuples(
        sizes,
        st.sampled_from([["force"], ["gravity"], ["force", "gravity"]]),
        st.sampled_from(["circle", "annulus"]),
        st.integers(4, 8),
    ),
    min_size=1,
    max_size=6,
)


def regime(case):
    numbers, loads, section, elements = case
    return {
        **REGIME, **{name: numbers[name] for name in HARDNESS}, "loads": loads, "section": section,
        "elements": elements,
        "numbers": {name: numbers[name] for name in NUMBERS if name.split(":")[0] in loads},
    }  # fmt: skip


@given(cases, cases)
def test_a_single_case_was_as_hard_in_everything(passed, asked):
    """Whatever is found inside, one case had all its loads, its make, and no smaller number."""
    from validation.domain import _beyond

    domain = domain_of(regime(case) for case in passed)
    for sample in (regime(case) for case in asked):

        def vouches(case, sample=sample):
            mine, here = {**case, **case["numbers"]}, {**sample, **sample["numbers"]}
            return (
                {*sample["loads"]} <= {*case["loads"]}
                and all(case[name] == sample[name] for name in SETTINGS)
                and all(
                    here[name] <= mine[name] * ROUNDING + FLOOR for name in (*HARDNESS, *sample["numbers"])
                )
            )

        enough = [case for case in map(regime, passed) if vouches(case)]
        fewest = min(
            (case["elements"] for case in map(regime, passed)
             if {*sample["loads"]} <= {*case["loads"]} and case["section"] == sample["section"]),
            default=99,
        )  # fmt: skip
        nus = [
            case["poisson_ratio"] for case in map(regime, passed)
            if {*sample["loads"]} <= {*case["loads"]} and case["section"] == sample["section"]
        ]  # fmt: skip
        inside = bool(enough) and sample["elements"] >= fewest and min(nus) <= sample["poisson_ratio"]
        assert (_beyond(domain, sample) == []) is inside


@given(
    st.sampled_from([*HARDNESS, *REGIME["numbers"]]), st.floats(1.02, 100.0),
    st.lists(sizes, max_size=3),
)  # fmt: skip
def test_the_number_that_is_beyond_is_named(name, factor, gentler):
    """One hard case, gentler ones beside it: any number of it, made larger, is named."""
    from validation.domain import _beyond

    hard = {**REGIME, "loads": ["bending", "force", "torsion"], "reference_turn": 0.5}
    soft = [
        {**hard, **{key: min(hard[key], size[key]) for key in HARDNESS if key != "poisson_ratio"}}
        for size in gentler
    ]
    domain = domain_of([hard, *soft])
    assert _beyond(domain, hard) == []
    beyond = copy.deepcopy(hard)
    where = beyond if name in HARDNESS else beyond["numbers"]
    where[name] *= factor
    (reason,) = _beyond(domain, beyond)
    assert str(WORDS.get(name, name)) in reason
