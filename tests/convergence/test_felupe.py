"""A second, independent finite element code agrees on the same mesh: felupe (A. Dutzler), extra `peers`.

Shared are the nodes alone. Shape functions, quadrature, laws and assembly are felupe's own.
"""

import numpy as np
import pytest

from reference.bodies import Body, distorted
from reference.oracles import felupe_assembly
from reference.solid_materials import MooneyRivlin, NeoHookean, SaintVenantKirchhoff
from reference.solid_mesh import circular_section, rectangular_section, rod_mesh

for peer in ("felupe", "tensortrax"):
    pytest.importorskip(peer, reason=f"{peer} is not installed: pip install 'ancf[peers]'")

LAWS = [SaintVenantKirchhoff(1.0, 0.3), NeoHookean(1.0, 0.45), MooneyRivlin(0.12, 0.08, 5.0)]
MESHES = {
    "O-grid": lambda: distorted(rod_mesh(circular_section(0.5, 2, 1), 0.8, 1), 0.01),
    "brick": lambda: distorted(rod_mesh(rectangular_section(1.0, 0.8, 2, 1), 0.8, 2), 0.03),
}


@pytest.mark.parametrize("mesh", MESHES)
@pytest.mark.parametrize("law", LAWS, ids=lambda law: type(law).__name__)
def test_forces_and_tangent_agree_to_rounding(law, mesh):
    body_mesh = MESHES[mesh]()
    u = np.random.default_rng(7).uniform(-0.01, 0.01, body_mesh.nodes.shape)
    x = body_mesh.nodes + u
    u = u + np.column_stack([0.1 * x[:, 1], -0.05 * x[:, 2], 0.08 * x[:, 0] ** 2])
    body = Body(body_mesh, law, "displacement", np.zeros(u.shape, bool))
    force, tangent = felupe_assembly(body_mesh, law, u)
    # 1e-12: rounding of some 1e2 terms by entry and of ln J near 1
    np.testing.assert_allclose(body.force(u), force, rtol=0, atol=1e-12 * np.abs(force).max())
    np.testing.assert_allclose(body.tangent(u).toarray(), tangent, rtol=0, atol=1e-12 * np.abs(tangent).max())
    assert np.abs(force).max() > 1e-3
