"""The chapter of hard cases: every column, every colour by margin, the history behind each case."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ElementTree
from pathlib import Path

import pytest

from ancf.newton import Iteration
from validation.criteria import Limit, Verdict, judge
from validation.hard_case import HardCase
from validation.hard_cases import HardResult
from validation.hard_limits import MEASURES, hard_limits
from validation.hard_scenes import arm
from validation.report import hard_table
from validation.report.history_plot import history_plot
from validation.report.page import render
from validation.runner import Run

CASE = HardCase("slenderness", "a <case>", arm(), "what is hard", not_asked={"drift, moved": "no reason"})
HISTORY = [Iteration(f, i, 10.0**-i, 10.0 ** (-2 * i)) for f in (0.5, 1.0) for i in (1, 2, 3)]


def result(case=CASE, verdict=Verdict.PASS, status="converged", measured=None, history=HISTORY, fault=""):
    found = {limit.quantity: limit.value / 100.0 for limit in hard_limits(case)} | (measured or {})
    findings = [
        judge(k, k.quantity, math.nan if found[k.quantity] is None else found[k.quantity])
        for k in hard_limits(case)
    ]
    found |= {"min det F": 0.9, "Newton order": 1.97, "energy order": 2.01}
    return HardResult(
        case, verdict, status, "", fault, 2, 1, 6, 1e-12, 1e-10, found, {}, findings, history, 0.01
    )


def page(*results):
    run = Run("quick", "now", hard_cases=list(results), parts=("hard cases",), seconds={"total": 1.0})
    return render(run, Path("no-such-folder"))


def row_of(html, name="hard-a-case"):
    return re.search(rf'<tr id="{name}".*?</tr>', html, re.DOTALL)[0]


def test_all_columns_are_there():
    html = page(result())
    header = html[html.index('<table class="heat">') :]
    header = header[: header.index("</thead>")]
    for measure in MEASURES:
        assert f">{measure.heading}</th>" in header
    assert row_of(html).count("<td") == 2 + len(MEASURES)
    spans = [int(n) for n in re.findall(r'colspan="(\d+)"', header)]
    assert sum(spans) == len(MEASURES)
    wanted = "mm-g-s, turned, 1e6 m away, reversed, renumbered, one ulp, 1 / 2 threads, 100 steps"
    for heading in (
        *wanted.split(", "),
        "condition number",
        "min det F",
        "order by residuals",
        "|W − U| / U",
    ):
        assert f">{heading}</th>" in header


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (2.0, "h0"),
        (None, "h0"),
        (0.8, "h1"),
        (0.5, "h2"),
        (0.01, "h3"),
        (1e-4, "h4"),
        (1e-9, "h5"),
        (0.0, "h5"),
    ],
)
def test_the_colour_is_the_margin(found, expected):
    limit = Limit("drift, turned", 1.0, "L", "reason")
    finding = judge(limit, limit.quantity, math.nan if found is None else found)
    assert hard_table.heat(finding) == expected


def test_the_number_is_in_the_cell():
    measure = next(m for m in MEASURES if m.name == "drift, turned")
    cell = hard_table.cell(measure, result(measured={"drift, turned": 2e-13}))
    assert "2.0" in cell.text
    assert "−13" in cell.text
    assert "1e-09 L" in cell.title
    order = hard_table.cell(next(m for m in MEASURES if m.shows == "Newton order"), result())
    assert order.text == "1.97"  # the order, coloured by its shortfall
    missing = hard_table.cell(measure, result(measured={"drift, turned": None}))
    assert (missing.text, missing.heat) == ("no number", "h0")
    left_out = hard_table.cell(next(m for m in MEASURES if m.name == "drift, moved"), result())
    assert left_out.heat == "hn"
    assert "no reason" in left_out.title


def test_a_failure_is_seen_and_explained():
    html = page(result(verdict=Verdict.FAIL, status="limit_point", fault="ended limit_point, must not"))
    assert 'class="bad"' in row_of(html)
    assert "ended limit_point, must not" in html
    assert "0 of 1 end as they must" in html
    assert '<a href="#hard-a-case">' in html  # from the verdict at the top


def test_nothing_is_loaded_and_names_are_escaped():
    html = page(result())
    assert "a &lt;case&gt;" in html
    assert "a <case>" not in html
    chapter = html[html.index('id="hard-cases"') : html.index('id="paper"')]
    assert not re.search(r"(?:src|href)=\"(?!#)", chapter)
    assert "<script" not in chapter


def test_the_scene_and_the_iterations_are_behind_the_row():
    html = page(result())
    assert "[[rod]]" in html
    assert html.count("<tr><td>6<td>1<td>3<td>1.0e-03<td>1.0e-06") == 1
    assert "not finite" in page(result(history=[Iteration(1.0, 1, 1e300, math.nan)]))
    long = [Iteration(1.0, i + 1, 1.0, 1.0) for i in range(100)]
    html = page(result(history=long))
    assert "60 more, in report.json" in html
    assert "<tr><td>100<td>1<td>100<td>" in html
    assert "<tr><td>50<td>" not in html


def test_the_drawing():
    svg = ElementTree.fromstring(history_plot(HISTORY, 1e-10, "how <it> went"))
    assert svg.get("aria-label") == "how <it> went"
    assert len(svg.findall("circle")) == len(svg.findall("rect")) == len(HISTORY)
    y = [float(mark.get("cy")) for mark in svg.findall("circle")]
    assert y[0] < y[1] < y[2]  # smaller residuals stand lower
    assert y[3] == y[0]
    texts = [text.text for text in svg.findall("text")]
    assert {"0.5", "1"} <= set(texts)  # a line for every load step
    upright = [path.get("d") for path in svg.findall("path") if "V" in path.get("d")]
    x = [float(mark.get("cx")) for mark in svg.findall("circle")]
    at = [float(d[1:].split()[0]) for d in upright]
    assert at[0] < x[0]
    assert x[2] < at[1] < x[3]  # between the third iteration and the first of the next step
    dashed = [path for path in svg.findall("path") if path.get("stroke-dasharray")]
    assert len(dashed) == 1


@pytest.mark.parametrize("value", [0.0, math.inf, math.nan, 1e300, 1e-300])
def test_the_drawing_stands_any_number(value):
    history = [Iteration(1.0, 1, value, value), Iteration(1.0, 2, 1e-3, 1e-3)]
    text = history_plot(history, 0.0, "any")
    ElementTree.fromstring(text)
    assert not re.search(r"nan|inf", text)


def test_an_empty_chapter():
    assert "Not in this run" in page()
