"""Learning the inverse problem, behind the gate of a valid certificate.

The certificate comes first: data are made only of scenes that the full validation vouches for (gate.py), and
what is made without it is stamped UNVALIDATED wherever it goes.
"""
