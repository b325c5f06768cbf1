"""Regimes of a domain of validity, as the tests of certificate and domain use them."""

REGIME = {
    "element": "3333", "formulation": "enhanced", "law": "saint-venant-kirchhoff", "loads": ["bending"],
    "section": "circle", "reference": "straight", "axial_rule": "default", "shear_factors": "1 1",
    "supports": "clamp at 0", "moment": "section", "places": "the end", "elements": 24, "slenderness": 40.0,
    "flatness": 1.0, "poisson_ratio": 0.3, "kappa_R": 0.03, "turn": 1.2, "turn_per_element": 0.05,
    "strain": 0.03, "known": True,
}  # fmt: skip
HARD = {"kappa_R": 0.15, "turn": 6.0, "turn_per_element": 0.246, "strain": 0.16}
