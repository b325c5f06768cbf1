"""The chapter on effects: every effect is measured, and a scene's row says "-" where one was never called."""

from ancf.scene_effects import EFFECT_MODULES
from validation import runner
from validation.effect_costs import ALONE, EffectCost, SceneCalls, call_table, measure, one_rod, scene_files
from validation.report import page

# Modules of EFFECT_MODULES that are not measured alone, with the reason.
EXCUSED: dict[str, str] = {"contact": "costs by what touches; issue and report leave it out"}


def test_every_effect_is_measured():
    measured = {table for tables in ALONE.values() for table in tables}
    assert measured | set(EXCUSED) == set(EFFECT_MODULES.values())


def test_a_measurement_is_of_the_effects_alone():
    cost = measure("force", one_rod(4, ALONE["force"]), 2)
    assert cost.elements == 4 and cost.milliseconds > 0.0 and cost.elastic > 0.0
    assert cost.ratio == cost.milliseconds / cost.elastic


def test_scenes_of_the_interface_are_there():
    names = {path.stem for path in scene_files()}
    assert {"gravity-arm", "paper-arm", "pure-bending", "tip-force"} <= names


def test_table_and_chapter():
    rows = [
        SceneCalls("a", "converged", 4, {"elastic": 5, "force": 5}, {"elastic": 0.5, "force": 0.01}),
        SceneCalls("b", "converged", 4, {"elastic": 6}, {"elastic": 0.25}),
    ]
    names, table = call_table(rows)
    assert names == ["elastic", "force"]
    assert [cells for _, cells in table] == [["5 × 0.5 ms", "5 × 0.01 ms"], ["6 × 0.25 ms", "-"]]
    run = runner.Run("quick", "now", effect_calls=rows, effect_costs=[EffectCost("force", 12, 0.1, 0.2)])
    run.seconds["total"] = 0.0
    html = page.render(run)
    chapter = html[html.index('<section id="effects">') :]
    chapter = chapter[: chapter.index("</section>")]
    assert "6 × 0.25 ms" in chapter and "<svg" in chapter and "1 of 1 measurements" in chapter
