"""Stiffnesses between vectors of an element, against the sum over all nodal vectors."""

import numpy as np
from hypothesis import given, strategies as st

from ancf.vector_pairs import VectorPairs

M, K, NODAL = 3, 4, 5


@given(st.integers(0, 2**20), st.sets(st.integers(0, NODAL - 1)), st.sets(st.integers(0, NODAL - 1)))
def test_entries_are_those_of_the_sum(seed, of_forces, of_changes):
    """dQ/de = sum_k L_k^T R_k (x) C_k; nodal vectors that nothing depends on have no entry."""
    rng = np.random.default_rng(seed)
    L, R = rng.uniform(0.5, 1.0, (2, M, K, NODAL))
    L[:, :, sorted(of_forces)] = 0.0
    R[:, :, sorted(of_changes)] = 0.0
    C = rng.uniform(-1.0, 1.0, (M, K, 3, 3))
    pairs = VectorPairs(L, R)
    dense = np.zeros(M * (3 * NODAL) ** 2)
    dense[pairs.entries] = pairs.entries_of(C)
    expected = np.einsum("mkn,mko,mkab->mnaob", L, R, C)
    np.testing.assert_allclose(dense.reshape(expected.shape), expected, rtol=0, atol=1e-14)
    assert len(np.unique(pairs.entries)) == len(pairs.entries)
    assert len(pairs.entries) == 9 * M * (NODAL - len(of_forces)) * (NODAL - len(of_changes))
