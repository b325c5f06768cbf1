"""Moment per reference length on the sections of a rod, fixed in space or turning with them."""

from __future__ import annotations

from ancf.effects import Effect
from ancf.rod_model import RodModel
from ancf.scene import Scene
from ancf.section_couples import SectionMoments, all_sections


def build(scene: Scene, rods: list[RodModel]) -> list[Effect]:
    """Line moments of the scene."""
    models = {model.rod.name: model for model in rods}
    return [
        LineMoment(*all_sections(models[load.rod]), load.value, load.direction == "follower")
        for load in scene.line_moments
    ]


class LineMoment(SectionMoments):
    """A moment per length [N m/m]."""

    name = "line_moment"
