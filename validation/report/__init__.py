"""The report: one self-contained offline page from a run."""
