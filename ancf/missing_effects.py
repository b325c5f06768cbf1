r"""Effects that a scene leaves out, at a magnitude that is typical of them, and what they would do.

    weight             of every rod, in the worst direction; 1000 kg/m3 where a material has no density
    tendon friction    capstan friction with mu = 0.1 in tendons of given tension that have none
    tendon stretch     of tendons of given length, by T/(E A) with E A = 10 kN
    swelling           of chambers under pressure in walls that no fibres hold (chamber_swelling.py)
    field gradient     a magnetic field that varies by a tenth over the rod, in the worst direction

Influences of friction, stretch and gradient are in proportion to what is assumed while they are small, so
they can be read for other magnitudes. Contact is in missing_contacts.py.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ancf.advice_state import State
from ancf.chamber_swelling import largest_swelling
from ancf.hyperelastic import Law
from ancf.influence import MATTERS, Influence
from ancf.model import Model
from ancf.scene import Gravity, LineLoad, Rod, Scene, Tendon
from ancf.scene_numbers import STANDARD_GRAVITY, weight_number
from ancf.tendon_state import tendon_states

Floats = NDArray[np.float64]

DENSITY = 1000.0  # kg/m3, water; silicones have 1000 to 1200, nitinol 6500, steel 7900
# Steel on nylon or in a PTFE tube; in bare silicone more.
FRICTION = 0.1
TENDON_STIFFNESS = 1e4  # N, E A of a steel rope of 0.5 mm; of nylon or polyethylene line of 0.5 mm about 1e3
LARGEST_SWELLING = 0.3  # of the radius: beyond, small strain says nothing
FIELD_CHANGE = 0.1  # of the field over the rod: a magnet at 30 rod lengths, as its field falls by 3/distance


def missing_effects(state: State) -> Iterator[Influence]:
    """Those that the scene does not list but has the bodies for."""
    if state.known:  # these follow the shape
        if any(tendon.tension and not tendon.friction for tendon in state.scene.pulled_tendons):
            yield _tendon_friction(state)
        if state.scene.controlled_tendons:
            yield _tendon_stretch(state)
        if state.scene.pressures:
            yield from _swelling(state)
        if any(np.any(magnet.field) and np.any(magnet.remanence) for magnet in state.scene.magnets):
            yield _field_gradient(state)
    if state.scene.gravity is None:  # six equilibria where rods touch, so it comes last
        yield _weight(state)


def _weight(state: State) -> Influence:
    bare = any(part.material.density is None for rod in state.scene.rods for part in rod.parts)
    rods = tuple(_with_density(rod) for rod in state.scene.rods)
    near = replace(state.near, rods=rods)
    number = max(weight_number(rod, heavy) or 0.0 for rod, heavy in zip(state.model.rods, rods, strict=True))
    return state.of_worst_direction(
        "gravity",
        lambda direction: replace(near, gravity=Gravity(STANDARD_GRAVITY * direction)),
        "rightly left out",
        "would matter: list [gravity]" + (" and give the density" if bare else ""),
        number=number,
        measure="weight L^2/EI",
        note="in the worst direction" + (f", {DENSITY:g} kg/m3 where no density is given" if bare else ""),
    )


def _with_density(rod: Rod) -> Rod:
    """The rod with a density wherever it has none."""

    def heavy(law: Law) -> Law:
        return law if law.density is not None else replace(law, density=DENSITY)

    segments = tuple(replace(segment, material=heavy(segment.material)) for segment in rod.segments)
    return replace(rod, material=heavy(rod.material), segments=segments)


def _tendon_friction(state: State) -> Influence:
    tendons = tuple(
        replace(tendon, friction=FRICTION) if tendon.tension and not tendon.friction else tendon
        for tendon in state.scene.tendons
    )
    other = replace(state.near, tendons=tendons)
    ends = tendon_states(Model(other), state.q, 1.0)
    loss = max(1.0 - one.end_tension / one.tension for one in ends if one.tension > 0.0)
    return state.influence(
        "tendon friction",
        other,
        "rightly left out",
        "would matter: set `friction` of the [[tendon]]",
        number=float(loss),
        measure="tension lost",
        note=f"friction = {FRICTION:g} taken",
    )


def _tendon_stretch(state: State) -> Influence:
    """A drum holds the length that the cable has without tension; under tension it is T/(E A) longer."""
    strains = [
        0.0 if one.tendon.length is None else one.tension / TENDON_STIFFNESS
        for one in tendon_states(state.model, state.q, 1.0)
    ]
    tendons = tuple(map(stretched, state.scene.tendons, strains))
    found = state.influence(
        "tendon stretch",
        replace(state.near, tendons=tendons),
        "rightly left out",
        "would matter: lengthen the tendons by T/(E A)",
        number=float(max(strains)),
        measure="T/(E A) of the tendon",
        note=f"E A = {TENDON_STIFFNESS:g} N taken",
    )
    if found.largest and found.verdict != MATTERS:
        softest = TENDON_STIFFNESS * found.largest / state.limit
        found = replace(found, note=f"{found.note}; matters below {softest:.2g} N")
    return found


def stretched(tendon: Tendon, strain: float) -> Tendon:
    """A tendon that is longer by a strain; of given tension the same."""
    return tendon if tendon.length is None else replace(tendon, length=tendon.length * (1.0 + strain))


def _swelling(state: State) -> Iterator[Influence]:
    rods = {rod.name: rod for rod in state.scene.rods}
    growth = [largest_swelling(rods[one.rod], one) for one in state.scene.pressures]
    known = [share for share in growth if share is not None]
    if len(known) < len(growth):
        return  # only round sections are known
    worst = max(known, key=abs)
    note = "walls without fibres taken, at small strain"
    if abs(worst) > LARGEST_SWELLING:
        note = f"walls without fibres would balloon: the radius by {worst:.0%} and more"
    wider = tuple(
        replace(one, value=one.value * (1.0 + min(share, LARGEST_SWELLING)) ** 2)
        for one, share in zip(state.scene.pressures, known, strict=True)
    )
    yield state.influence(
        "swelling of chambers",
        replace(state.near, pressures=wider),
        "rightly left out",
        "would matter: hold the walls by fibres, or enlarge the chamber",
        rough=True,
        number=worst if math.isfinite(worst) else None,
        measure="growth of the radius",
        note=note,
    )


def _field_gradient(state: State) -> Influence:
    """Force per length |p| dB/L, p the magnetic moment per length."""
    from ancf.effects.magnet import MU_0

    rods = {rod.name: rod for rod in state.scene.rods}

    def under(direction: Floats) -> Scene:
        loads = []
        for magnet in state.scene.magnets:
            rod = rods[magnet.rod]
            moment = _mean_area(rod) / MU_0 * float(np.linalg.norm(magnet.remanence))
            change = FIELD_CHANGE * float(np.linalg.norm(magnet.field)) / rod.length
            loads.append(LineLoad(rod.name, moment * change * direction))
        return replace(state.near, line_loads=(*state.scene.line_loads, *loads))

    return state.of_worst_direction(
        "field gradient",
        under,
        "rightly left out",
        "would matter: list its force as [[line_load]]",
        number=FIELD_CHANGE,
        measure="change of field/field",
        note=f"a field that varies by {FIELD_CHANGE:.0%} over the rod taken",
    )


def _mean_area(rod: Rod) -> float:
    return sum(part.length * part.section_at(0.5).area for part in rod.parts) / rod.length
