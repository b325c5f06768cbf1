"""After a run: write its certificate, or say why there is none; a quick run looks at the shipped one."""

from __future__ import annotations

from pathlib import Path

from validation import certificate
from validation.criteria import Verdict
from validation.digests import Roots
from validation.runner import Run, all_cases

NAME = "certificate.json"


def certify(run: Run, folder: Path, ship: bool = False) -> list[Path]:
    """Certify a run where it earned it, and record in the run what came of it.

    A full run in which everything required passed gets a certificate in `folder`, if that certificate
    verifies against the code as it is now. Any other run only states whether the shipped one holds.

    Parameters
    ----------
    run : a finished run; `certificate` and `certificate_reasons` are set
    folder : where the certificate goes; one that a full run no longer earns is removed there
    ship : write it as the shipped certificate too

    Returns
    -------
    Files written.
    """
    if run.scope != "full" or not run.complete:
        found = certificate.verify()
        run.certificate = found.certificate.id if found.certificate and found.valid else None
        run.certificate_reasons = found.reasons
        return []
    verdict, reasons = run.verdict
    if verdict is Verdict.PASS:
        statement = certificate.build(run)
        reasons = certificate.faults(statement, all_cases(), Roots())
        if not reasons:
            run.certificate, run.certificate_reasons = statement["id"], []
            targets = [folder / NAME, *([certificate.SHIPPED] if ship else [])]
            return [certificate.write(statement, path) for path in targets]
    run.certificate, run.certificate_reasons = None, reasons
    (folder / NAME).unlink(missing_ok=True)
    return []
