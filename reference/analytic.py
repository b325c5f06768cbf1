"""Closed forms by one name: re-exports of the modules that derive them."""

from reference.bending import BendingSection, BendingState, pure_bending_curvature, pure_bending_moment
from reference.buckling import euler_load, lateral_buckling_load, self_weight_load
from reference.constant_curvature import constant_curvature_moment, constant_curvature_pose, printed_eq47
from reference.critical_loads import (
    Flutter,
    RingTwist,
    beck_flutter,
    column_load,
    hinged_frame_moment,
    ring_twist,
    shaft_torque,
)
from reference.elastica import (
    BuckledTip,
    ElasticaTip,
    buckled_tip,
    elastica_closing_ratio,
    elastica_shortening,
    elastica_tip_force,
)
from reference.hanging import HangingBar, hanging_bar, hanging_saint_venant_kirchhoff
from reference.helix import RodShape, helix_tip_moment, space_moment
from reference.helix_inverse import HelixMoment, helix_inverse
from reference.torsion import (
    torsion_constant_bilinear_section,
    torsion_constant_circle,
    torsion_constant_ellipse,
    torsion_constant_linear_section,
    torsion_constant_rectangle,
    twist_angle,
)
from reference.uniaxial import (
    Stretch,
    full_hooke_locking_factor,
    uniaxial_neo_hookean,
    uniaxial_saint_venant_kirchhoff,
)

__all__ = [
    "BendingSection",
    "BendingState",
    "BuckledTip",
    "ElasticaTip",
    "Flutter",
    "HangingBar",
    "HelixMoment",
    "RingTwist",
    "RodShape",
    "Stretch",
    "beck_flutter",
    "buckled_tip",
    "column_load",
    "constant_curvature_moment",
    "constant_curvature_pose",
    "elastica_closing_ratio",
    "elastica_shortening",
    "elastica_tip_force",
    "euler_load",
    "full_hooke_locking_factor",
    "hanging_bar",
    "hanging_saint_venant_kirchhoff",
    "helix_inverse",
    "helix_tip_moment",
    "hinged_frame_moment",
    "lateral_buckling_load",
    "printed_eq47",
    "pure_bending_curvature",
    "pure_bending_moment",
    "ring_twist",
    "self_weight_load",
    "shaft_torque",
    "space_moment",
    "torsion_constant_bilinear_section",
    "torsion_constant_circle",
    "torsion_constant_ellipse",
    "torsion_constant_linear_section",
    "torsion_constant_rectangle",
    "twist_angle",
    "uniaxial_neo_hookean",
    "uniaxial_saint_venant_kirchhoff",
]
