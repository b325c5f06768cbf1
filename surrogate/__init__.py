"""Learning the inverse problem, behind the gate of a valid certificate. Empty in this version.

The certificate comes first: a surrogate may only be trained on what the full validation has passed.
"""
