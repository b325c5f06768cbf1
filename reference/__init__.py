"""Answers obtained without the solver: closed forms, a rod boundary-value solver, published numbers."""
