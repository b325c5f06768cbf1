"""The certificate: an in-toto statement that this code passed the whole validation, and its verification.

A statement (https://in-toto.io/Statement/v1) about every file of ancf/ with the predicate test-result/v0.1:
what was judged by which code and cases, the verdict lists, the numbers behind them, the domain of validity.
Measured values, times, date and machine stay out of its id, so that two machines that agree give one id.

`verify` takes nothing on trust that it can work out again: digests, limits, verdicts, lists, domain. Without
a secret key it cannot tell a number that was measured from one invented together with all that follows
from it; only a run can, and `ancf validate --full --fresh` is that run.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ancf.errors import Message
from validation import digests
from validation.cases import Case, CaseError, load_cases
from validation.criteria import Verdict
from validation.digests import Roots, differences
from validation.domain import KEY, domain_of, outside
from validation.evidence import evidence_of, limit_faults, lists_of, unmeasured, verdict_of
from validation.regime import ACCURATE

if TYPE_CHECKING:
    from ancf.scene import Scene
    from ancf.solution import Solution
    from validation.expected import Expectation
    from validation.runner import Run

STATEMENT = "https://in-toto.io/Statement/v1"
PREDICATE = "https://in-toto.io/attestation/test-result/v0.1"
SHIPPED = Path(__file__).parent / "certificate.json"
CERTIFIED = {str(Verdict.PASS), str(Verdict.WARN)}  # of the cases that make the domain


class NotValidated(Exception):
    """There is no valid certificate for the present code (exit code 4)."""

    def __init__(self, message: Message) -> None:
        super().__init__(str(message))
        self.message = message


@dataclass(frozen=True)
class Certificate:
    """A statement as it is stored."""

    statement: Mapping[str, Any]

    @property
    def id(self) -> str:
        """Digest of everything that is not measured."""
        return self.statement["id"]

    @property
    def domain(self) -> list[dict[str, Any]]:
        """Domain of validity, see `validation.domain.domain_of`."""
        return self.statement["predicate"]["domain"]

    def outside(self, scene: Scene, solution: Solution | None = None) -> list[str]:
        """Why a scene is not inside the domain of validity; empty when it is."""
        return outside(self.domain, scene, solution)


@dataclass(frozen=True)
class Verification:
    """Whether a certificate holds for the present code, and if not, every reason by name."""

    path: Path
    certificate: Certificate | None
    reasons: list[str] = field(default_factory=list)

    @property
    def valid(self) -> bool:
        """No reason against it was found."""
        return self.certificate is not None and not self.reasons


def domain_of_run(run: Run) -> list[dict[str, Any]]:
    """Domain of validity that a run earned, whole or not."""
    return _domain(evidence_of(run))


def build(run: Run) -> dict[str, Any]:
    """The statement about a run, all of it or not; `verify` decides whether it is worth anything."""
    evidence = evidence_of(run)
    verdicts = {name: Verdict(entry["verdict"]) for name, entry in evidence.items()}
    predicate = {
        **lists_of(verdicts),
        "configuration": _descriptors(run.configuration),
        "scope": run.scope,
        "complete": run.complete,
        "domain": _domain(evidence),
        "evidence": evidence,
        "environment": {**run.environment, **run.versions},
        "date": run.started,
    }
    statement = {
        "_type": STATEMENT,
        "subject": _descriptors(run.subject),
        "predicateType": PREDICATE,
        "predicate": predicate,
    }
    # Through JSON once, so that what is sealed is what a reader finds.
    return seal(json.loads(json.dumps(statement, allow_nan=False, default=lambda value: value.tolist())))


def seal(statement: Mapping[str, Any]) -> dict[str, Any]:
    """The statement with its id and the checksum of its whole content."""
    content = {key: value for key, value in statement.items() if key not in ("id", "checksum")}
    content["id"] = identity(content)
    return {**content, "checksum": digests.of_json(content)}


def identity(statement: Mapping[str, Any]) -> str:
    """SHA-256 of subject, configuration, verdict lists, limits, kinds of the domain; nothing measured."""
    predicate = statement["predicate"]
    kept = ("result", "configuration", "passedTests", "warnedTests", "failedTests", "scope", "complete")
    return digests.of_json(
        {
            "type": [statement["_type"], statement["predicateType"]],
            "subject": statement["subject"],
            **{key: predicate[key] for key in kept},
            "evidence": unmeasured(predicate["evidence"]),
            "domain": [[entry[key] for key in KEY] for entry in predicate["domain"]],
        }
    )


def write(statement: Mapping[str, Any], path: Path) -> Path:
    """Write a statement whole or not at all."""
    from validation.record import write_text

    return write_text(path, json.dumps(statement, indent=1, allow_nan=False) + "\n")


def load(path: Path) -> Certificate:
    """Read a certificate; raises ValueError (with the reason) when the file is not one, or not whole."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ValueError(f"it cannot be read: {error.strerror or error}") from None
    except ValueError as error:
        raise ValueError(f"it is not JSON: {error}") from None
    if not isinstance(data, dict) or (data.get("_type"), data.get("predicateType")) != (STATEMENT, PREDICATE):
        raise ValueError("it is not an in-toto test result")
    content = {key: value for key, value in data.items() if key != "checksum"}
    if data.get("checksum") != digests.of_json(content):
        raise ValueError("its content does not match its checksum: it was damaged or edited")
    try:
        if data["id"] != identity(data):
            raise ValueError("its id does not match its content: it was edited")
    except (KeyError, TypeError, AttributeError) as error:
        raise ValueError(f"it is not complete: {type(error).__name__} {error}") from None
    return Certificate(data)


def verify(path: Path | None = None, roots: Roots | None = None) -> Verification:
    """Hold a certificate against the present code, reference code, cases and limits.

    Parameters
    ----------
    path : file; the shipped certificate if None
    roots : folders of the packages; the installed ones if None
    """
    path, roots = path or SHIPPED, roots or Roots()
    try:
        certificate = load(path)
        reasons = faults(certificate.statement, load_cases(roots.cases), roots)
    except (ValueError, CaseError) as error:
        return Verification(path, None, [str(error)])
    except (KeyError, TypeError, AttributeError) as error:
        return Verification(path, None, [f"it is not complete: {type(error).__name__} {error}"])
    return Verification(path, certificate, reasons)


def require(path: Path | None = None, roots: Roots | None = None) -> Certificate:
    """The certificate if it holds for the present code; raises `NotValidated` with the reasons if not."""
    found = verify(path, roots)
    if found.certificate is not None and found.valid:
        return found.certificate
    shown = "; ".join(found.reasons[:5])
    more = f"; and {len(found.reasons) - 5} more" if len(found.reasons) > 5 else ""
    raise NotValidated(
        Message(
            "There is no valid certificate for this code.",
            str(found.path),
            shown + more,
            "the code, a case or a limit changed since the last full validation, or there was none",
            "run `ancf validate --full`; it writes a certificate when everything required passes",
        )
    )


def faults(statement: Mapping[str, Any], cases: Iterable[Case], roots: Roots) -> list[str]:
    """Every reason why a statement does not hold for the present code; empty when it does."""
    cases = list(cases)
    predicate, evidence = statement["predicate"], statement["predicate"]["evidence"]
    now = {f"case {case.id}": digests.of_case(case) for case in cases if case.required}
    reasons = differences(_by_name(statement["subject"]), digests.of_solver(roots))
    reasons += differences(_by_name(predicate["configuration"]), {**digests.of_judges(roots), **now})
    if predicate["scope"] != "full":
        reasons.append(f"it is of a {predicate['scope']} run, not of a full one")
    if predicate["complete"] is not True:
        reasons.append("it is of a part of the validation, not of the whole")
    if not evidence:
        reasons.append("nothing was run")
    try:
        from validation.expected import expected_checks

        expected = expected_checks(cases)
    except ModuleNotFoundError as error:
        need = f"{error.name} is needed to judge it again: pip install 'ancf[reference]'"
        return [*reasons, need]
    except Exception as error:  # an edit may leave code that does not load; its digest is named already
        return [*reasons, f"the present code does not load: {type(error).__name__}: {error}"]
    reasons += _judged_again(predicate, expected)
    reasons += _regime_faults(evidence, cases)
    if predicate["domain"] != json.loads(json.dumps(_domain(evidence))):
        reasons.append("the domain of validity is not the one of the cases that passed")
    return reasons


def _judged_again(predicate: Mapping[str, Any], expected: Mapping[str, Expectation]) -> list[str]:
    """Verdicts from the numbers and limits, lists from the verdicts, names from the present code."""
    evidence = predicate["evidence"]
    reasons = [f"{name} is missing from the run" for name in sorted(expected.keys() - evidence.keys())]
    verdicts = {}
    for name, entry in evidence.items():
        verdicts[name], wrong = verdict_of(name, entry)
        reasons += wrong
        if name in expected:
            reasons += limit_faults(name, entry, expected[name])
    for key, value in lists_of(verdicts).items():
        if predicate[key] != value:
            reasons.append(f"{key} does not follow from the verdicts")
    failed = [name for name, verdict in verdicts.items() if verdict in (Verdict.FAIL, Verdict.INCONCLUSIVE)]
    return reasons + [f"{name} is {verdicts[name]}" for name in sorted(failed)]


def _regime_faults(evidence: Mapping[str, Mapping[str, Any]], cases: Iterable[Case]) -> list[str]:
    """Checks that speak for the domain and may not, or for other rods than their case has."""
    speaking = {f"case {case.id}": case for case in cases if case.problem in ACCURATE}
    faults = []
    for name, entry in evidence.items():
        regimes = entry.get("regimes", [])
        if regimes and name not in speaking:
            faults.append(f"{name} does not measure accuracy, but speaks for the domain of validity")
        elif any(
            (regime["element"], regime["formulation"], regime["law"]) not in speaking[name].combinations
            for regime in regimes
        ):
            faults.append(f"{name} speaks for rods that are not in that case")
    return faults


def _domain(evidence: Mapping[str, Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Domain of the cases that passed in every finding; a documented miss makes none."""
    return domain_of(
        regime
        for entry in evidence.values()
        if {entry["verdict"], *(finding["verdict"] for finding in entry["findings"])} <= CERTIFIED
        for regime in entry.get("regimes", [])
    )


def _descriptors(found: Mapping[str, str]) -> list[dict[str, Any]]:
    """Resource descriptors of in-toto."""
    return [{"name": name, "digest": {"sha256": found[name]}} for name in sorted(found)]


def _by_name(descriptors: Iterable[Mapping[str, Any]]) -> dict[str, str]:
    return {entry["name"]: entry["digest"]["sha256"] for entry in descriptors}
