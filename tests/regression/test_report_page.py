"""The report opened from file:// in headless Chromium: self-contained, no broken anchor, "
"readable on a phone and on A4."""

from __future__ import annotations

import importlib.util
import json
import re
from pathlib import Path

import pytest

pytest.importorskip("matplotlib", reason="the report needs the extra [report]")
pytest.importorskip("jinja2", reason="the report needs the extra [report]")

from validation import runner
from validation.report.page import write_page

_spec = importlib.util.spec_from_file_location("chromium", Path(__file__).with_name("chromium.py"))
assert _spec and _spec.loader
chromium = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(chromium)

EXECUTABLE = chromium.find_chromium()
needs_browser = pytest.mark.skipif(EXECUTABLE is None, reason="no chromium on this machine")
CASES = (
    "HX-3333-12",
    "TO-square-3333",
    "RM",
    "CB-600-literature",
    "FIG2-b",
    "FIG2-c",
    "IT-90-3243",
    "PIN-3243-full-4",
)


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> Path:
    """A report of a few cases and the quick studies; every kind of section has content."""
    record = runner.run(wanted=CASES)
    rest = runner.run(parts=("locking", "remedies", "hard cases"))
    record.locking, record.hard_cases = rest.locking, rest.hard_cases
    record.remedies = rest.remedies
    quick = [
        s for s in runner.convergence.studies() if s.element == "3333" and s.name in ("bending", "stretch")
    ]
    record.convergence = [runner.convergence.run_study(s) for s in quick]
    bending = next(f for f in runner.cost.families() if f.name == "pure bending")
    record.work = [runner.cost.measure(bending)]
    record.scaling = runner.scaling.scale((100,))
    record.tangents = runner.scaling.tangent_ratios(2)
    return write_page(record, tmp_path_factory.mktemp("report"))


@pytest.fixture(scope="module")
def browser():
    assert EXECUTABLE
    try:
        found = chromium.Browser(EXECUTABLE)
    except (RuntimeError, OSError):  # seen once on a loaded machine: it started and never spoke
        found = chromium.Browser(EXECUTABLE)
    yield found
    found.close()


def test_nothing_is_loaded_from_elsewhere(page):
    text = page.read_text()
    assert "<script" not in text
    loaded = re.findall(r'(?:src|(?<!xlink:)href)="([^"#][^"]*)"', text) + re.findall(
        r"url\(([^)#]+)\)", text
    )
    assert all(address.startswith("data:") for address in loaded), loaded
    assert not re.findall(r"\b(?:nan|inf)\b", text.lower())


@needs_browser
def test_no_console_error_and_no_request(page, browser):
    seen = len(browser.events)
    browser.open(page, 1280)
    events = browser.events[seen:]
    said = [
        e
        for e in events
        if e["method"] in ("Runtime.consoleAPICalled", "Runtime.exceptionThrown", "Log.entryAdded")
    ]
    assert not said, json.dumps(said)[:500]
    asked = {e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"}
    assert page.as_uri() in asked
    assert all(url.startswith(("file:", "data:")) for url in asked), asked


@needs_browser
def test_every_anchor_resolves_and_ids_are_unique(page, browser):
    browser.open(page, 1280)
    broken = browser.evaluate(
        "[...document.querySelectorAll('a[href^=\"#\"], use')].map(a => a.getAttribute('href') || "
        "a.getAttribute('xlink:href')).filter(h => h && !document.getElementById(h.slice(1)))"
    )
    assert broken == []
    assert browser.evaluate("document.querySelectorAll('nav a').length") == 16
    twice = browser.evaluate(
        "(() => {const ids = [...document.querySelectorAll('[id]')].map(e => e.id);"
        "return ids.filter((id, i) => ids.indexOf(id) !== i)})()"
    )
    assert twice == []


@needs_browser
@pytest.mark.parametrize("width", [390, 768, 1280])
def test_the_page_fits_its_width(page, browser, width):
    browser.open(page, width)
    assert browser.evaluate("document.documentElement.scrollWidth") <= width
    # Even with everything unfolded: tables scroll inside their own box.
    browser.evaluate("document.querySelectorAll('details').forEach(d => d.open = true)")
    assert browser.evaluate("document.documentElement.scrollWidth") <= width


@needs_browser
def test_the_verdict_is_readable_on_a_phone(page, browser):
    browser.open(page, 390)
    box = browser.evaluate(
        "(() => {const e = document.querySelector('.verdict .word'), r = e.getBoundingClientRect();"
        "return {text: e.textContent, left: r.left, right: r.right, bottom: r.bottom,"
        " size: parseFloat(getComputedStyle(e).fontSize), body: "
        "parseFloat(getComputedStyle(document.body).fontSize)}})()"
    )
    assert box["text"] in ("PASS", "FAIL", "PARTIAL")
    assert box["left"] >= 0
    assert box["right"] <= 390
    assert box["bottom"] <= 844  # without scrolling
    assert box["size"] >= 24
    assert box["body"] >= 15


@needs_browser
def test_it_prints_on_a4(page, browser):
    # The printable width of A4 with the page's margins is 180 mm = 680 CSS pixels: no table may be cut off.
    browser.open(page, 680)
    browser.call("Emulation.setEmulatedMedia", media="print")
    overflow = browser.evaluate("document.documentElement.scrollWidth")
    browser.call("Emulation.setEmulatedMedia", media="")
    assert overflow <= 680
    pdf = browser.pdf()
    assert pdf.startswith(b"%PDF")
    sizes = {
        (round(float(w)), round(float(h)))
        for w, h in re.findall(rb"/MediaBox \[0 0 ([\d.]+) ([\d.]+)\]", pdf)
    }
    assert sizes == {(595, 842)} or sizes == {(595, 841)} or sizes == {(596, 842)}, sizes
    assert len(re.findall(rb"/Type /Page\b", pdf)) >= 5
