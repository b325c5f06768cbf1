"""Joints of rods that are apart in the reference: the load factor brings them together."""

import math
from dataclasses import replace

import numpy as np
import pytest

import ancf
from ancf.model import Model
from ancf.rotation import exp
from reference.arcs import Piece, chain_tip, concentric_curvature

E, NU = 1e9, 0.3
STIFF, SOFT = 2e-3, 1.5e-3  # radii [m]


UPRIGHT = np.eye(3)


def rod(name, radius, curvature, **more):
    return {
        "name": name, "length": 0.3, "section": {"shape": "circle", "radius": radius},
        "material": {"young_modulus": E, "poisson_ratio": NU}, "curvature": curvature, "elements": 6, **more,
    }  # fmt: skip


def joint(at, kind="rigid", **more):
    ends = {"a": {"rod": "inner", "at": at}, "b": {"rod": "outer", "at": at}}
    return {"kind": kind, "reference": "apart", **ends, **more}


def tubes(curvatures, turn=UPRIGHT, stations=(1 / 3, 2 / 3, 1.0)):
    base = {"position": [0.1, -0.2, 0.3], "x_axis": turn[:, 0].tolist(), "y_axis": turn[:, 1].tolist()}
    held = {"base": base, "supports": [{"at": 0.0}]}
    pairs = zip(("inner", "outer"), (SOFT, STIFF), curvatures, strict=True)
    return ancf.scene_from_dict(
        {"rod": [rod(n, r, list(k), **held) for n, r, k in pairs], "joint": [joint(at) for at in stations]}
    )


TURN = exp(np.array([0.3, -0.8, 0.5]))


@pytest.mark.parametrize("turn", [UPRIGHT, TURN], ids=["as SCS", "turned"])
@pytest.mark.parametrize("curvatures", [(6.0, 0.0), (8.0, -4.0)])
def test_plane_tubes_meet_at_the_weighted_curvature(curvatures, turn):
    """sum(EI k)/sum(EI): Webster, Romano, Cowan 2009; (kappa R)^2 = 3e-4 is of second order."""
    solution = ancf.solve(tubes([(0, 0, k) for k in curvatures], turn))
    assert solution.status == "converged", solution.message
    curvature = concentric_curvature([SOFT**4, STIFF**4], curvatures)
    tip, frame = chain_tip([Piece(0.3, (0, 0, curvature))], turn)
    for name in ("inner", "outer"):
        pose = solution.tip(name)
        np.testing.assert_allclose(pose.position - [0.1, -0.2, 0.3], tip, atol=3e-4 * 0.3)
    both = [
        solution.tip(name).rotation @ turn @ exp(np.array([0, 0, 0.3 * k]))
        for name, k in zip(("inner", "outer"), curvatures, strict=True)
    ]
    np.testing.assert_allclose(both[0], both[1], atol=1e-10)  # one section, whatever each was
    np.testing.assert_allclose(both[0], frame, atol=1e-3)
    # Between the tubes only couples: the last joint carries EI_1 (kappa - k_1) about z.
    couple = solution.joints[-1].moment
    EI = E * math.pi * SOFT**4 / 4
    expected = turn @ [0, 0, EI * (curvature - curvatures[0])]
    np.testing.assert_allclose(couple, expected, rtol=0.02, atol=0.02 * EI)


def test_sections_meet_in_space():
    """Curvature and twist about all axes: positions and frames of both rods are one, and forces balance."""
    k = ((2.0, 4.0, 3.0), (0.0, -1.0, 2.0))
    solution = ancf.solve(tubes(k, TURN))
    assert solution.status == "converged", solution.message
    inner, outer = (solution.tip(name) for name in ("inner", "outer"))
    np.testing.assert_allclose(inner.position, outer.position, atol=1e-11)
    frames = [p.rotation @ TURN @ exp(0.3 * np.array(c)) for p, c in zip((inner, outer), k, strict=True)]
    np.testing.assert_allclose(frames[0], frames[1], atol=1e-10)
    (f_1, m_1), (f_2, m_2) = (solution.reaction(name) for name in ("inner", "outer"))
    EI = E * math.pi * STIFF**4 / 4
    np.testing.assert_allclose(f_1 + f_2, 0.0, atol=1e-9 * EI / 0.3**2)
    np.testing.assert_allclose(m_1 + m_2, 0.0, atol=1e-9 * EI / 0.3)


@pytest.mark.parametrize("kind", ["rigid", "ball"])
def test_tangent_and_rate_are_the_derivatives(kind):
    """Central differences err by h^2 f'''/6 + eps f/h = 1e-9 at h = 1e-5; the residual is of size 1."""
    scene = ancf.scene_from_dict(
        {
            "rod": [
                rod("inner", SOFT, [1.0, 2.0, 3.0], supports=[{}]),
                rod("outer", STIFF, [0, -3.0, 1.0], supports=[{}], base={"position": [0.02, 0.01, 0]}),
            ],
            "joint": [joint(0.5, kind)],
        }
    )
    model, at, h = Model(scene), 0.7, 1e-5
    assert model.constraints is not None
    q = model.q0 + 0.05 * model.unit * np.random.default_rng(1).uniform(-1, 1, model.n)
    (part,) = model.constraints.joints
    x, terms = q[part.dofs], part.terms(q[part.dofs], at)
    tangent = terms.tangent.reshape(len(x), len(x))
    unit, force_unit = model.unit[part.dofs], part.energy / model.unit[part.dofs]
    for j, step in enumerate(h * unit):
        change = np.eye(len(x))[j] * step
        slope = (part.terms(x + change, at).g - part.terms(x - change, at).g) / (2 * step)
        np.testing.assert_allclose(
            tangent[:, j] * unit[j] / force_unit, slope * unit[j] / force_unit, atol=1e-7
        )
    rate = (part.terms(x, at + h).g - part.terms(x, at - h).g) / (2 * h)
    assert np.abs(rate / force_unit).max() > 0.01
    np.testing.assert_allclose(terms.rate / force_unit, rate / force_unit, atol=1e-8)


def refused(**change):
    with pytest.raises(ancf.SceneError) as error:
        ancf.scene_from_dict(
            {
                "rod": [rod(n, SOFT, [0, 0, k], supports=[{}]) for n, k in (("inner", 3.0), ("outer", 0.0))],
                "joint": [{**joint(1.0), **change}],
            }
        )
    return str(error.value)


def test_what_does_not_fit_is_refused():
    assert 'write reference = "apart"' in refused(reference="together")
    assert "apart in the reference" in refused(reference="together")
    assert '"reference" does not belong to a hinge' in refused(kind="hinge", axis=[0, 0, 1])
    assert '"reference" does not belong to a joint to the ground' in refused(b="ground")
    assert "moved against the ground" in refused(displacement=[0.1, 0, 0])
    assert "did you mean" in refused(reference="apar")


@pytest.mark.parametrize("turns", [0.0, 0.4, 0.5, 1.0, 2.0, 2.7, -3.2])
def test_turns_are_counted_along_the_rods(turns):
    """Two rods from one base: the inner curved by `turns` about z more than the straight outer one."""
    curved = rod("inner", SOFT, [0, 0, 2 * math.pi * turns / 0.3], supports=[{}], elements=13)
    scene = ancf.scene_from_dict(
        {"rod": [curved, rod("outer", STIFF, [0, 0, 0], supports=[{}])], "joint": [joint(1.0)]}
    )
    constraints = Model(scene).constraints
    assert constraints is not None
    np.testing.assert_allclose(constraints.joints[0].rotation, [0, 0, -2 * math.pi * turns], atol=1e-9)


@pytest.mark.parametrize("parameter", ["curvature", "length", "radius"])
def test_sensitivities_know_that_the_gap_changes(parameter):
    """Central differences of two solutions: their error is of second order in the step."""
    scene = tubes([(0.5, 1.0, 3.0), (0.0, -1.0, 2.0)])
    solution = ancf.solve(scene)
    size = {"curvature": 1e-3, "length": 1e-6, "radius": 1e-7}[parameter]

    def tip(step):
        change = {
            "curvature": lambda r: {"curvature": r.curvature + np.array([0, 0, step])},
            "length": lambda r: {"length": r.length + step},
            "radius": lambda r: {"section": replace(r.section, radius=r.section.radius + step)},
        }[parameter]
        rods = tuple(replace(r, **change(r)) if r.name == "outer" else r for r in scene.rods)
        pose = ancf.solve(replace(scene, rods=rods)).tip("outer")
        return np.concatenate([pose.position, pose.r_x, pose.r_y, pose.r_z])

    difference = (tip(size) - tip(-size)) / (2 * size)
    exact = solution.sensitivity(parameter, "outer")
    exact = exact[:, 2] if parameter == "curvature" else exact
    assert np.abs(exact).max() > 1e-3
    np.testing.assert_allclose(exact, difference, atol=2e-5 * np.abs(exact).max())
