r"""Contacts that a scene does not list: where the shape passes through itself, another rod, or an obstacle.

The gap of every pair is taken at the equilibrium. Where it is open nothing touches, and the influence is
zero. Where it is closed the scene is solved with the contact, from the reference, as a body has two sides;
if that ends without an equilibrium the depth d is a bound,

    largest shift >= d (obstacle),   >= d/2 (two rods),

because a point must leave by the depth on whatever side.

Left out are pairs that a joint holds together, and bodies that stand in one another from the beginning. An
obstacle that is listed for one rod is looked at for all.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from ancf.advice_state import State
from ancf.contact_points import contact_points
from ancf.effects import blocks_of
from ancf.effects.contact import TOUCHING, ObstacleContact
from ancf.effects.rod_contact import SAMPLES, RodContact
from ancf.errors import SceneError
from ancf.influence import CLOSE, MATTERS, Influence
from ancf.obstacles import Obstacle
from ancf.rod_model import RodModel
from ancf.scene import Contact, Rod, Scene
from ancf.sections import Annulus, Circle

Floats = NDArray[np.float64]

ITSELF, RODS, OBSTACLES = "contact with itself", "contact between rods", "contact with obstacles"
# Distances looked at for a pair of rods: 80 MB. Rods that ask for more are not looked at.
MOST_DISTANCES = 10_000_000


@dataclass(frozen=True)
class _Pair:
    """A contact that could be listed, and its gap at the equilibrium [m]."""

    contact: Contact
    gap: float
    radius: float  # m, of the rod where it is thinnest

    @property
    def closed(self) -> bool:
        """Whether one is in the other by more than rounding."""
        return self.gap < -TOUCHING * self.radius

    @property
    def text(self) -> str:
        """Who with whom, as a scene file writes it."""
        obstacle, other = self.contact.obstacle, self.contact.other
        body = f'{{ shape = "rod", name = "{other}" }}' if obstacle is None else f"the {obstacle.shape}"
        return f'[[contact]] rod = "{self.contact.rod}", with = {body}'


def missing_contacts(state: State) -> Iterator[Influence]:
    """One influence for each kind of contact that has pairs: that of all closed pairs together."""
    if not state.known:
        return
    for effect, candidates in candidate_contacts(state.scene).items():
        pairs = [pair for contact in candidates if (pair := _gap(state, contact)) is not None]
        if pairs:
            yield _influence(state, effect, pairs)


def candidate_contacts(scene: Scene) -> dict[str, list[Contact]]:
    """Contacts of round rods that are not listed, by kind."""
    names = [rod.name for rod in scene.rods if _is_round(rod)]
    together = {frozenset((one.rod, one.other)) for one in scene.contacts if one.other is not None}
    together |= {frozenset(place.rod for place in joint.places) for joint in scene.joints if joint.b}
    obstacles = {_key(one.obstacle): one.obstacle for one in scene.contacts if one.obstacle is not None}
    known = {(one.rod, _key(one.obstacle)) for one in scene.contacts if one.obstacle is not None}
    return {
        ITSELF: [Contact(name, other=name) for name in names if frozenset((name,)) not in together],
        RODS: [Contact(a, other=b) for a, b in combinations(names, 2) if frozenset((a, b)) not in together],
        OBSTACLES: [
            Contact(name, obstacle)
            for key, obstacle in obstacles.items()
            for name in names
            if (name, key) not in known
        ],
    }


def _key(obstacle: Obstacle) -> tuple[str, ...]:
    """The same for two obstacles that are one body."""
    return (obstacle.shape, *(str(np.round(value, 12)) for value in vars(obstacle).values()))


def _is_round(rod: Rod) -> bool:
    """Whether contact knows the surface of a rod."""
    return all(isinstance(section, Circle | Annulus) for part in rod.parts for section in (part.section,))


def _gap(state: State, contact: Contact) -> _Pair | None:
    """The gap of a contact; None where it is too large a question, or closed from the beginning."""
    models = {model.rod.name: model for model in state.model.rods}
    a, b = models[contact.rod], models.get(contact.other or "")
    radius = _thinnest(a)
    try:
        if contact.obstacle is not None:
            effect = ObstacleContact(a, contact.obstacle)
            gap = np.min(effect.gaps(blocks_of(state.q, effect.dofs)))
        else:
            assert b is not None
            points = contact_points(a, _thinnest(b)).N
            if points.shape[0] * points.shape[1] * len(b.dofs) * (SAMPLES + 1) > MOST_DISTANCES:
                return None
            gap = np.min(RodContact(a, b).gaps(state.q))
            if a is b and gap > 0.0:
                gap = _bight(a, state.q) - 2.0 * radius
    except SceneError:
        return None
    return _Pair(contact, float(gap), radius)


def _bight(rod: RodModel, q: Floats) -> float:
    """Least distance [m] at which the axis of a rod comes near itself again; inf where it does not.

    From each of its points the distance grows along the rod; a minimum beyond counts.
    """
    points = contact_points(rod, _thinnest(rod))
    first = np.unique(np.round(points.at.ravel(), 12), return_index=True)[1]
    r = np.einsum("mpn,mnc->mpc", points.N, rod.element_vectors(q)).reshape(-1, 3)[first]
    distance = np.pad(cdist(r, r), ((0, 0), (1, 1)), constant_values=np.inf)
    here = distance[:, 1:-1]
    least = (here < distance[:, :-2]) & (here < distance[:, 2:]) & ~np.eye(len(r), dtype=bool)
    return float(np.min(here[least], initial=np.inf))


def _thinnest(rod: RodModel) -> float:
    parts = rod.rod.parts
    return float(min(min(part.section.outer_radius, part.last_section.outer_radius) for part in parts))


def _influence(state: State, effect: str, pairs: list[_Pair]) -> Influence:
    nearest = min(pairs, key=lambda pair: pair.gap)
    length = state.scene.rod(nearest.contact.rod).length
    about = {"number": nearest.gap / length if np.isfinite(nearest.gap) else None, "measure": "gap/L"}
    closed = [pair for pair in pairs if pair.closed]
    if not closed:
        return state.judged(effect, 0.0, 0.0, False, "nothing touches", "", **about)
    more = f", and {len(closed) - 1} more" if len(closed) > 1 else ""
    cure = f"list {nearest.text}{more}"
    contacts = (*state.scene.contacts, *(pair.contact for pair in closed))
    dq = state.neighbour(replace(state.near, contacts=contacts), afresh=not state.scene.follows_path)
    if dq is None:
        share = 1.0 if nearest.contact.obstacle is not None else 0.5
        longest = max(rod.length for rod in state.scene.rods)
        depth = -share * nearest.gap / longest
        verdict = MATTERS if depth > state.limit else CLOSE
        note = f"no equilibrium with it was found; the shape moves by {depth:.1g} L at least"
        return Influence(effect, None, depth, verdict, note=note, advice=f"would matter: {cure}", **about)
    size = np.linalg.norm(state.shifts(dq), axis=1)
    return state.judged(
        effect,
        float(size[state.tips].max()),
        float(size.max()),
        False,
        "touches, and could be left out",
        f"would matter: {cure}",
        **about,
    )
