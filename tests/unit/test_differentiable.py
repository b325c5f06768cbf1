"""torch differentiates through the solver: gradients against differences, and a pose found by gradients."""

import numpy as np
import pytest

import ancf

torch = pytest.importorskip("torch", reason="torch is not installed (extra `surrogate`)")

L, RADIUS, YOUNG = 0.4, 0.01, 1e6
EI = YOUNG * np.pi * RADIUS**4 / 4


def scene(**tables):
    rod = {
        "length": L, "elements": 2, "section": {"shape": "circle", "radius": RADIUS},
        "material": {"young_modulus": YOUNG, "poisson_ratio": 0.3}, "base": {"position": [1.0, 2.0, 3.0]},
    }  # fmt: skip
    return ancf.scene_from_dict({"rod": [rod], **tables})


@pytest.mark.parametrize(
    ("tables", "kind", "unit"),
    [
        ({"moment": [{"value": [0, 0, 1.0]}]}, "moment", EI / L),
        ({"force": [{"value": [0, 0, 1.0], "frame": "body"}]}, "force", EI / L**2),
    ],
)
def test_gradients_are_those_of_differences(tables, kind, unit):
    from surrogate.differentiable import tip_poses

    loads = torch.tensor([[0.2, 0.5, 1.0], [-0.3, 0.1, 0.4]], dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(
        lambda x: tip_poses(scene(**tables), x * unit, kind), (loads,), eps=1e-4, atol=1e-6, rtol=1e-6
    )


def test_a_pose_is_found_by_gradients():
    from surrogate.differentiable import tip_poses

    template = scene(moment=[{"value": [0, 0, 1.0]}])
    wanted = tip_poses(template, torch.tensor([[0.0, 0.4, 0.8]], dtype=torch.float64) * EI / L)
    x = torch.zeros(1, 3, dtype=torch.float64, requires_grad=True)
    search = torch.optim.LBFGS([x], max_iter=40, tolerance_grad=1e-12, tolerance_change=1e-14)

    def miss():
        search.zero_grad()
        loss = ((tip_poses(template, x * EI / L) - wanted) ** 2).sum()
        loss.backward()
        return loss

    search.step(miss)
    np.testing.assert_allclose(x.detach().numpy(), [[0.0, 0.4, 0.8]], atol=1e-5)


def test_single_precision_stays_so_outside():
    from surrogate.differentiable import tip_poses

    loads = torch.zeros(1, 3, requires_grad=True)
    poses = tip_poses(scene(moment=[{"value": [0, 0, 1.0]}]), loads)
    poses[0, 1, 0].backward()
    assert poses.dtype == torch.float32 and loads.grad.dtype == torch.float32
    assert loads.grad[0, 2] == pytest.approx(L**2 / (2 * EI), rel=2e-3)  # linear beam theory


def test_a_row_without_equilibrium_is_named():
    from surrogate.differentiable import UnsolvedRowsError, tip_poses

    loads = torch.tensor([[0, 0, EI / L**2], [1e300, 0, 1e299]], dtype=torch.float64)
    with pytest.raises(UnsolvedRowsError, match="the first is 1") as failed:
        tip_poses(scene(force=[{"value": [0, 0, 1.0]}], solver={"max_steps": 10}), loads, "force")
    assert failed.value.rows == [1]
