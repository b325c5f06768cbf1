"""Does the solver agree with independent answers, and at what cost: cases, verdicts, studies "
"and the report."""
