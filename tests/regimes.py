"""Regimes of a domain of validity, as the tests of certificate and domain use them."""

REGIME = {
    "element": "3333", "formulation": "enhanced", "law": "saint-venant-kirchhoff", "loads": ["bending"],
    "section": "circle", "reference": "straight", "axial_rule": "default", "shear_factors": "1 1",
    "supports": "clamp at 0", "elements": 24, "slenderness": 40.0,
    "flatness": 1.0, "poisson_ratio": 0.3, "kappa_R": 0.03, "turn": 1.2, "turn_per_element": 0.05,
    "turn_by_aspect": 0.09, "reference_turn": 0.0, "tolerance": 1e-10, "thrust": 2.0, "strain": 0.03,
    # Loads that are never what a test is about; their sizes have tests of their own.
    "numbers": {
        "bending: M L/EI": 10.0, "torsion: M L/EI": 10.0, "force: F L2/EI along the axis": 2.0,
        "force: F L2/EI against the axis": 2.0, "force: F L2/EI across the axis": 2.0,
    },
    "known": True,
}  # fmt: skip
HARD = {"kappa_R": 0.15, "turn": 6.0, "turn_per_element": 0.246, "turn_by_aspect": 0.42, "strain": 0.16}
