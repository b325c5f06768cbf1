r"""Moments and follower forces on one section, for several samples at once (effects/moment.py, rotation.py).

The weights of the section rotation are W_k = sum_b I_kb E_b with the reference directors E_y, E_z, so that
A = sum_k d_k W_k^T = B E^T with B = [b_y b_z] = sum_k d_k I_k. Its polar parts have closed forms:

    d = |b_y x b_z|,  t^2 = tr(B^T B) + 2 d,  S = (B^T B + d I)/t,  n = b_y x b_z / d,  [q_y q_z] = B S^-1,
    R = q_y E_y^T + q_z E_z^T + n E_x^T,   V = b_y q_y^T + b_z q_z^T,   G^-1 = V/d + n n^T/t

(S^-1 = adj(S)/d, because det S = d and tr S = t; G = tr(V) I - V has the eigenvalues of adj(S) in the
section and t across). Then as in rotation.py, with the columns dd_b = e_c of the tangent one after the
other,

    Q_k = mu x R W_k,   mu = G^-1 M,   dw = G^-1 (R W_b x e_c),   dmu = G^-1 (dM - dG mu),
    dG mu = mu (R W_b)_c - e_c (R W_b . mu) - V (mu x dw),   dQ_k = dmu x R W_k + mu x (dw x R W_k),

dM = dw x M for the part of M that follows the section; a follower force F = R F_0 has dF = dw x F.
"""

from __future__ import annotations

import math

from ancf.fused_blocks import (
    compiled,
    cross,
    dot,
    inlined,
    minus,
    plus,
    plus_scaled,
    put_vector,
    scaled,
    vector,
)


@inlined
def _section(x, dof, director, second):
    """b_y, b_z of a section."""
    first = vector(x, dof + 3 * director[0])
    b_y, b_z = scaled(second[0, 0], first), scaled(second[0, 1], first)
    for k in range(1, len(director)):
        d = vector(x, dof + 3 * director[k])
        b_y, b_z = plus_scaled(b_y, second[k, 0], d), plus_scaled(b_z, second[k, 1], d)
    return b_y, b_z


@inlined
def _times_V(s, a):
    """V a."""
    b_y, b_z, q_y, q_z, _, _, _ = s
    return plus_scaled(scaled(dot(q_y, a), b_y), dot(q_z, a), b_z)


@inlined
def _times_G_inverse(s, a):
    """G^-1 a."""
    n, per_d, per_t = s[4], s[5], s[6]
    return plus_scaled(scaled(per_d, _times_V(s, a)), per_t * dot(n, a), n)


@inlined
def _rotated(s, a):
    """R a for a in the section's reference axes x, y, z."""
    return plus_scaled(plus_scaled(scaled(a[0], s[4]), a[1], s[2]), a[2], s[3])


@compiled
def section_load(G, K, x, dof, nv, load, tables, w, tangent):
    """Add the loads on one section to G and, if `tangent`, subtract dQ/dd from its node's K (nv x nv)."""
    director, second = tables.director, tables.moments[load]
    b_y, b_z = _section(x, dof, director, second)
    c_yy, c_yz, c_zz = dot(b_y, b_y), dot(b_y, b_z), dot(b_z, b_z)
    n = cross(b_y, b_z)
    d = math.sqrt(dot(n, n))
    per_d = 1.0 / d
    t = math.sqrt(c_yy + c_zz + 2.0 * d)
    per_t = 1.0 / t
    # S^-1 = adj(S)/d
    s_yy, s_yz, s_zz = (c_zz + d) * per_t * per_d, c_yz * per_t * per_d, (c_yy + d) * per_t * per_d
    q_y = minus(scaled(s_yy, b_y), scaled(s_yz, b_z))
    q_z = minus(scaled(s_zz, b_z), scaled(s_yz, b_y))
    s = (b_y, b_z, q_y, q_z, scaled(per_d, n), per_d, per_t)

    M_turning = _rotated(s, vector(w.M_turning, 3 * load))
    M = plus(vector(w.M_fixed, 3 * load), M_turning)
    mu = _times_G_inverse(s, M)
    for k in range(len(director)):
        RW = plus_scaled(scaled(second[k, 0], q_y), second[k, 1], q_z)
        at = dof + 3 * director[k]
        put_vector(G, at, plus(vector(G, at), cross(mu, RW)))
    first, last = tables.turning_start[load], tables.turning_start[load + 1]
    for f in range(first, last):
        F = _rotated(s, vector(w.F_turning, 3 * f))
        for v in range(nv):
            put_vector(G, dof + 3 * v, plus_scaled(vector(G, dof + 3 * v), tables.turning_shape[f, v], F))
    if not tangent:
        return
    for b in range(len(director)):
        RW_b = plus_scaled(scaled(second[b, 0], q_y), second[b, 1], q_z)
        along = dot(RW_b, mu)
        for c in range(3):
            e_c = (1.0 if c == 0 else 0.0, 1.0 if c == 1 else 0.0, 1.0 if c == 2 else 0.0)
            dw = _times_G_inverse(s, cross(RW_b, e_c))
            dG_mu = minus(scaled(dot(RW_b, e_c), mu), _times_V(s, cross(mu, dw)))
            dG_mu = minus(dG_mu, (along * e_c[0], along * e_c[1], along * e_c[2]))
            dmu = _times_G_inverse(s, minus(cross(dw, M_turning), dG_mu))
            for k in range(len(director)):
                RW = plus_scaled(scaled(second[k, 0], q_y), second[k, 1], q_z)
                dQ = plus(cross(dmu, RW), cross(mu, cross(dw, RW)))
                _subtract_column(K, nv, director[k], director[b], c, dQ)
            for f in range(first, last):
                dF = cross(dw, _rotated(s, vector(w.F_turning, 3 * f)))
                for v in range(nv):
                    _subtract_column(K, nv, v, director[b], c, scaled(tables.turning_shape[f, v], dF))


@inlined
def _subtract_column(K, nv, row, column, c, a):
    """Subtract a from column c of one block."""
    at = 9 * (row * nv + column) + c
    K[at] = K[at] - a[0]
    K[at + 3] = K[at + 3] - a[1]
    K[at + 6] = K[at + 6] - a[2]
