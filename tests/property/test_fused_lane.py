"""One lane at a time, as the threads of a GPU work, against the lanes of a register; compiled for the CPU."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, event, given, settings

from ancf import fused
from ancf.materials import SaintVenantKirchhoff
from ancf.model import Model
from ancf.scene import Force, Rod, Scene, Support
from ancf.sections import Circle
from tests.property.test_fused_scenes import AGREE, every_element, loads_of, random_scene
from tests.strategies import draws, fewer

numba = pytest.importorskip("numba")

# More than a tile has lanes, so that some take a second sample.
ROWS = 40
# Iterations within which Newton goes straight for an equilibrium. One that wanders magnifies rounding, which
# differs (a register fuses products with sums): 2 of 1520 rows of 38 random scenes, which took 19 and more.
STRAIGHT = 10
ROD = Rod("rod", 1.0, 8, Circle(0.025), SaintVenantKirchhoff(1e6, 0.3))


@pytest.fixture(scope="module")
def run():
    """All lanes of all tiles, one after the other."""
    from ancf.fused_lane import TILE, solve_lane

    @numba.njit(error_model="numpy")
    def every_lane(
        tiles, problem, found, unit, mesh, elastic, projectors, loads, start, at, states, memories
    ):
        for tile in range(tiles):
            for lane in range(TILE):
                solve_lane(
                    tile,
                    lane,
                    tiles,
                    problem,
                    found,
                    unit,
                    mesh,
                    elastic,
                    projectors,
                    loads,
                    start,
                    at,
                    states,
                    memories,
                )

    return every_lane


def refuse_to_be_read(shape, kind):
    """Memory whose content would spoil every result."""
    return np.full(shape, np.nan if kind == np.float64 else -1, dtype=kind)


def solve_alone(run, model, moments, forces, start=None, tiles=1):
    """Results of all lanes, in memory that holds nothing of use before; each keeps to its own column."""
    from ancf.fused_lane import TILE, tile_arrays

    rows, tables = len(moments), fused.tables_of(model, fused.FEW)
    found = fused.Found(
        refuse_to_be_read((rows, model.n), np.float64),
        np.zeros(rows, bool),
        refuse_to_be_read(rows, np.float64),
        np.zeros(rows, np.int64),
    )
    problem = fused.problem_of(model, moments, forces, start, None, tables.floor, 25)
    states, memories = tile_arrays(tables, tiles, refuse_to_be_read)
    run(tiles, problem, found, model.unit, *tables[:6], states, memories)
    for sample in range(max(0, rows - tiles * TILE), rows):  # the last of each lane
        tile, lane = divmod(sample % (tiles * TILE), TILE)
        x = memories[tile, tables.at.x : tables.at.x + model.n, lane]
        np.testing.assert_array_equal(x * model.unit, found.x[sample])
    return found


@every_element
@settings(max_examples=fewer(4))
@given(source=draws())
def test_a_lane_alone_finds_what_lanes_together_find(run, element, source):
    """issue 5: to 1e-11 on random scenes, in as many iterations; no row spoils those that follow it."""
    scene = random_scene(source, element)
    model = Model(scene)
    assume(not fused.unsupported(model))
    moments, forces = loads_of(scene, ROWS)
    share = np.linspace(-1.0, 1.5, ROWS).reshape(-1, 1, 1)
    moments, forces = share * moments, share * forces
    moments[5:7] *= 1e5
    forces[7:9] *= 1e5
    expected = fused.solve_rows(model, moments, forces)
    found = solve_alone(run, model, moments, forces, tiles=source.choice((1, 2)))
    straight = expected.converged & (expected.iterations <= STRAIGHT)
    event(f"most go straight: {straight.mean() > 0.5}")
    assert found.converged[straight].all()
    np.testing.assert_array_equal(found.iterations[straight], expected.iterations[straight])
    for q, other in zip(found.x[straight], expected.q[straight], strict=True):
        assert model.largest_motion(q - other) <= AGREE
    limit = max(scene.solver.tolerance, expected.floor[0])
    assert np.isfinite(found.x).all() and np.all(found.residual[found.converged] <= limit)


def test_a_compressed_column_is_not_left_straight(run):
    """Beyond Euler's load pi^2/4 E I/L^2 the straight shape is an equilibrium, but no minimum."""
    push = Model(Scene((ROD,), forces=(Force("rod", 1.0, np.array([-1.0, 0.0, 0.0])),)))
    critical = np.pi**2 / 4.0 * push.rods[0].bending_stiffness
    forces = np.array([[[-0.9 * critical, 0.0, 0.0]], [[-1.1 * critical, 0.0, 0.0]]])
    found = solve_alone(run, push, np.empty((2, 0, 3)), forces)
    np.testing.assert_array_equal(found.converged, [True, False])


def test_a_section_turned_inside_out_is_no_solution(run):
    """An arc in the x-y plane, pinned at three points and mirrored in z, has no strain and det F = -1."""
    pins = tuple(Support(at, "pin") for at in (0.0, 0.5, 1.0))
    arc = Model(Scene((replace(ROD, curvature=np.array([0.0, 0.0, 1.0]), supports=pins),)))
    mirrored = arc.q0.reshape(-1, 3, 3) * np.array([[1.0], [1.0], [-1.0]])
    none = np.empty((2, 0, 3))
    found = solve_alone(run, arc, none, none, np.array([arc.q0, mirrored.ravel()]))
    np.testing.assert_array_equal(found.converged, [True, False])
