"""The gate: data are made only by code, and of scenes, that a valid certificate speaks for.

It is asked three times: whether a certificate holds for this code, before a row is solved whether its loads
lie in the domain of validity, and after it whether its bending and strain do. One way leads around it, and
what comes of that is stamped UNVALIDATED wherever it goes.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancf.errors import Message
from validation.certificate import Certificate, NotValidated, Roots, digests, verify

if TYPE_CHECKING:
    from ancf.batch import BatchSolution
    from ancf.scene import Scene

UNVALIDATED = "UNVALIDATED"
SHOWN = 3  # reasons that a message repeats


@dataclass(frozen=True)
class Gate:
    """The certificate that was found valid, or why none was."""

    certificate: Certificate | None
    reasons: tuple[str, ...] = ()  # against the certificate

    @property
    def id(self) -> str:
        """Id of the certificate, or UNVALIDATED."""
        return UNVALIDATED if self.certificate is None else self.certificate.id

    def outside(self, batch: BatchSolution) -> dict[int, list[str]]:
        """Which rows of a batch lie outside the domain of validity, and why; none without a certificate.

        Rows under moments alone are judged by their loads, and those of the largest moment, bending and
        torsion by their solutions too: what bends and twists less strains less. All others are judged solved,
        as curvature is not known before. A row without an equilibrium says nothing that could be vouched for,
        and stays, with its status.
        """
        if self.certificate is None:
            return {}
        converged = np.flatnonzero(batch.status == "converged")
        found: dict[int, list[str]] = {}
        if _moments_only(batch.loads.scene):
            hardest = _hardest(batch, converged)
            found = {row: self.certificate.outside(batch.loads.row(row)) for row in range(len(batch))}
        else:
            hardest = converged
        for row in hardest:
            solution = batch.solution(int(row))
            found[int(row)] = self.certificate.outside(solution.scene, solution)
        return {row: reasons for row, reasons in found.items() if reasons}


def ask(allow_unvalidated: bool = False) -> Gate:
    """Ask for a certificate of this code; raises `NotValidated` when there is none that holds."""
    found = verify()
    if found.certificate is not None and found.valid:
        slim = {"id": found.certificate.id, "predicate": {"domain": found.certificate.domain}}
        return Gate(Certificate(slim))  # without its evidence, as it travels to every worker
    if not allow_unvalidated:
        raise NotValidated(
            Message(
                "There is no valid certificate for this code, so no data are made with it.",
                str(found.path),
                listed(found.reasons),
                "the code, a case or a limit changed since the last full validation, or there was none",
                f"run `ancf validate --full`, or stamp the data {UNVALIDATED} with --allow-unvalidated",
            )
        )
    return Gate(None, tuple(found.reasons))


def refuse_outside(where: str, reasons: Iterable[str]) -> None:
    """Raise `NotValidated` for rows outside the domain of validity, if there are any."""
    reasons = list(reasons)
    if reasons:
        raise NotValidated(
            Message(
                "Samples lie outside what the certificate vouches for.",
                where,
                listed(reasons),
                "no validated case has such a rod, load, mesh or curvature",
                f"change ranges or elements, or stamp the data {UNVALIDATED} with --allow-unvalidated",
            )
        )


def admit(stamp: str, where: str, allow_unvalidated: bool = False) -> str:
    """The stamp under which data or a model may be used now: the same, or UNVALIDATED where that is allowed.

    Raises `NotValidated` for what is UNVALIDATED, or was made under another certificate than the present one.
    """
    present = ask(allow_unvalidated).id
    if stamp == present:
        return stamp
    if not allow_unvalidated:
        raise NotValidated(
            Message(
                "The present certificate does not vouch for these data.",
                where,
                f"stamped {stamp}, the certificate of this code is {present}",
                "they were made without a certificate, or by another version of the solver",
                "make them again with `ancf dataset`, or go on UNVALIDATED with --allow-unvalidated",
            )
        )
    return UNVALIDATED


@cache
def solver_digest() -> str:
    """SHA-256 of every file of ancf/, as this process imports it."""
    return digests.of_json(digests.of_solver(Roots()))


def listed(reasons: Iterable[str]) -> str:
    """The first reasons, and how many more there are."""
    reasons = list(reasons)
    more = len(reasons) - SHOWN
    return "; ".join(reasons[:SHOWN]) + (f"; and {more} more" if more > 0 else "")


def _hardest(batch: BatchSolution, rows: NDArray[np.intp]) -> NDArray[np.intp]:
    """Of some rows those with the largest moments, in size, about the rods' axes and across them."""
    if not len(rows):
        return rows
    scene = batch.loads.scene
    axes = np.array([scene.rod(load.rod).base.rotation[:, 0] for load in scene.moments])
    moments = batch.loads.moments[rows]  # (b, m, 3), SCS as the axes
    along = np.abs(np.einsum("mi,bmi->bm", axes, moments))
    size = np.linalg.norm(moments, axis=-1)
    across = np.sqrt(np.maximum(size**2 - along**2, 0.0))
    return rows[np.unique([np.argmax(kind.sum(axis=1)) for kind in (size, along, across)])]


def _moments_only(scene: Scene) -> bool:
    """Whether point moments are all that acts."""
    no_loads = {"rods", "moments", "solver", "stability", "title"}
    return not any(getattr(scene, field.name) for field in fields(scene) if field.name not in no_loads)
