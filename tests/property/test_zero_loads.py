"""A load without a potential whose value is zero is as if it were not listed: shape, path and stability."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings, strategies as st

import ancf
from ancf.model import Model
from ancf.solution import Solution, Status
from tests.property.test_advice import TWO_SHAPES
from tests.strategies import fewer, vectors

NOTHING = [0.0, 0.0, 0.0]
# Every load that has no potential where its value is not zero: its table, and it without its value.
KINDS: dict[str, tuple[str, dict[str, Any]]] = {
    "moment": ("moment", {"at": 0.3}),
    "follower moment": ("moment", {"at": 0.3, "direction": "follower"}),
    "vorticity": ("moment", {"at": 0.3, "definition": "vorticity"}),
    "follower vorticity": ("moment", {"at": 0.3, "definition": "vorticity", "direction": "follower"}),
    "follower force": ("force", {"at": 0.3, "direction": "follower", "offset": [0.001, 0.0]}),
    "follower line load": ("line_load", {"direction": "follower"}),
    "line moment": ("line_moment", {}),
    "follower line moment": ("line_moment", {"direction": "follower"}),
}
every_kind = pytest.mark.parametrize("kind", KINDS)

L, R, E = 0.5, 0.01, 1e6
EI = E * math.pi * R**4 / 4
EULER = EI * (math.pi / (2 * L)) ** 2  # of a column clamped below
ROD: dict[str, Any] = {
    "name": "a",
    "length": L,
    "elements": 4,
    "section": {"shape": "circle", "radius": R},
    "material": {"young_modulus": E, "poisson_ratio": 0.3, "density": 1000.0},
}
AXIAL = {"rod": "a", "value": [-1.2 * EULER, 0.0, 0.0]}
COLUMN = {"rod": [ROD], "force": [AXIAL, {"rod": "a", "value": [0.0, 1e-3 * EULER, 0.0]}]}
SCENES: dict[str, dict[str, Any]] = {
    "two shapes": TWO_SHAPES | {"moment": []},
    "round column": {"rod": [ROD], "force": [AXIAL]},
    "column with modes": COLUMN | {"stability": {"modes": 2}},
    "path": COLUMN | {"solver": {"method": "arclength"}},
    "buckled branch": {"rod": [ROD], "force": [AXIAL], "stability": {"branch": "buckled"}},
    # Bent into a helix by a moment, which has no potential: with the zero one none has.
    "moment": {"rod": [ROD], "moment": [{"rod": "a", "value": [0.5 * EI / L, 0.0, 2.0 * EI / L]}]},
}


def with_zero(data: dict[str, Any], kind: str) -> dict[str, Any]:
    """The scene with a load of value zero more."""
    table, load = KINDS[kind]
    return {**data, table: [*data.get(table, []), {"rod": "a", "value": NOTHING, **load}]}


def solved(data: dict[str, Any], reduction: str) -> Solution:
    options = {**data.get("solver", {}), "reduction": reduction}
    return ancf.solve(ancf.scene_from_dict({**data, "solver": options}))


def check_absent(data: dict[str, Any], kind: str) -> Solution:
    """Bit for bit with reduction = "full", 1e-12 of the length under "auto" (issue "effects", proof)."""
    without, added = solved(data, "full"), solved(with_zero(data, kind), "full")
    assert added.status == without.status
    np.testing.assert_array_equal(added.q, without.q)
    assert added.stable is without.stable
    assert [(i.load_factor, i.step, i.residual) for i in added.history] == [
        (i.load_factor, i.step, i.residual) for i in without.history
    ]
    assert (added.stability is None) == (without.stability is None)
    if added.stability is not None and without.stability is not None:
        assert added.stability.as_dict() == without.stability.as_dict()
    lean, more = solved(data, "auto"), solved(with_zero(data, kind), "auto")
    assert more.status == lean.status and more.stable is lean.stable
    if lean.status is Status.CONVERGED:
        np.testing.assert_allclose(more.tip().position, lean.tip().position, rtol=0, atol=1e-12 * L)
    return without


@every_kind
@pytest.mark.parametrize("scene", SCENES)
def test_zero_is_absence(scene, kind):
    check_absent(SCENES[scene], kind)


@every_kind
def test_a_zero_load_has_a_potential(kind):
    """And none as soon as its value is not zero, at whatever load factor."""
    data = with_zero({"rod": [ROD]}, kind)
    table, _ = KINDS[kind]
    zero = Model(ancf.scene_from_dict(data))
    assert zero.conservative and zero.potential(zero.q0) == 0.0
    data[table][0]["value"] = [1e-3, 0.0, 0.0]
    acting = Model(ancf.scene_from_dict(data))
    assert not acting.conservative
    assert acting.potential(acting.q0) is None and acting.potential(acting.q0, 0.0) is None
    # A model under other values is judged by those.
    assert acting.under(zero.scene).conservative and not zero.under(acting.scene).conservative


@st.composite
def conservative(draw: st.DrawFn) -> dict[str, Any]:
    """A curved rod under loads with a potential, of the size that bends it by radians."""
    rod = {**ROD, "curvature": (2.0 / L * draw(vectors())).tolist()}
    path = [[0.0, 0.6 * R, 0.0], [1.0, 0.0, 0.5 * R]]
    makers = {
        "force": lambda: {"value": (8.0 * EI / L**2 * draw(vectors())).tolist(), "at": 1.0},
        "magnet": lambda: {"remanence": (0.1 * draw(vectors())).tolist(), "field": [0.0, 0.02, 0.0]},
        "tendon": lambda: {"tension": draw(st.floats(0.0, 0.5)), "path": path},
        "pressure": lambda: {"value": 0.02 * E, "chamber": {"centre": [0.4 * R, 0.0], "radius": 0.4 * R}},
    }
    names = draw(st.lists(st.sampled_from(sorted(makers)), min_size=1, max_size=2, unique=True))
    return {"rod": [rod], **{name: [{"rod": "a", **makers[name]()}] for name in names}}


@settings(max_examples=fewer(4), deadline=None)
@example({**TWO_SHAPES, "moment": []}, "moment")
@given(conservative(), st.sampled_from(sorted(KINDS)))
def test_zero_is_absence_on_random_rods(data, kind):
    check_absent(data, kind)


@pytest.mark.parametrize("engine", ["numpy", "fused"])
@pytest.mark.parametrize("direction", ["fixed", "follower"])
@pytest.mark.parametrize("table", ["moment", "force"])
def test_a_zero_row_is_judged_as_without_the_load(table, direction, engine):
    """Rows of zero beside others: beyond Euler's load a round column has two negative eigenvalues, an even
    number, so that only a scene with a potential shows that the straight shape is no minimum."""
    if (table, direction) == ("force", "fixed"):
        pytest.skip("has a potential")
    pytest.importorskip("numba" if engine == "fused" else "numpy")
    push = {"rod": "a", "value": [-1.2 * EULER, 0.0, 0.0]}
    load = {"rod": "a", "value": NOTHING, "at": 1.0, "direction": direction}
    tables = {"force": [push], "moment": [load]} if table == "moment" else {"force": [load, push]}
    rows = np.array([[0.0, 0.0, 0.0], [0.0, 0.2 * EI / L, 0.0], [0.0, 0.0, 0.0]])
    start = Model(ancf.scene_from_dict({"rod": [ROD], **tables})).q0
    without = solved({"rod": [ROD], "force": [push]}, "full")
    assert without.stable is False  # nothing pushes it aside
    for values in (rows, rows[:1]):  # whether or not the load acts in other rows
        scene = ancf.scene_from_dict({"rod": [ROD], **tables})
        found = ancf.solve_batch(scene, **{table + "s": values}, start=start, engine=engine)
        for row in np.flatnonzero(~values.any(axis=1)):
            assert found.status[row] == without.status
            np.testing.assert_array_equal(found.q[row], without.q)
            assert found.iterations[row] > len(without.history)  # it was looked for alone


@pytest.mark.parametrize(
    "tables",
    [
        {"gravity": {"acceleration": NOTHING}},
        {"pressure": [{"rod": "a", "value": 0.0, "chamber": {"radius": 0.002}}]},
        {"tendon": [{"rod": "a", "tension": 0.0, "path": [[0.1, 0.002, 0.0], [0.9, 0.0, 0.002]]}]},
        {"line_load": [{"rod": "a", "value": NOTHING, "direction": "follower"}]},
        {"line_moment": [{"rod": "a", "value": NOTHING}]},
    ],
    ids=lambda tables: next(iter(tables)),
)
def test_rows_start_where_they_would_without_it(tables):
    """Bit for bit: moments alone have starts in closed form, other loads that act take them in waves."""
    rows = np.linspace(0.2, 3.0, 5)[:, None] * np.array([0.1, -0.4, 1.0]) * EI / L
    bare: dict[str, Any] = {"rod": [ROD], "moment": [{"rod": "a", "value": NOTHING}]}
    expected, found = (
        ancf.solve_batch(ancf.scene_from_dict({**bare, **more}), rows, engine="numpy")
        for more in ({}, tables)
    )
    assert (expected.status == Status.CONVERGED).all()
    np.testing.assert_array_equal(found.iterations, expected.iterations)
    np.testing.assert_array_equal(found.q, expected.q)
