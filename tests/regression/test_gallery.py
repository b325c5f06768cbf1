"""The gallery (examples/README.md): every scene converges and meets its number; every scene has its picture.

The numbers come from reference/ or statics, the limits with their reasons from validation/report/gallery.py.
"""

import re
from pathlib import Path

import pytest

import ancf
from ancf.solution import Status
from validation.report.exhibits import EXAMPLES, EXHIBITS
from validation.report.gallery import compare, page

ROOT = Path(__file__).resolve().parents[2]
LARGEST_PICTURE = 60_000  # bytes


@pytest.mark.parametrize("exhibit", EXHIBITS, ids=lambda e: e.name)
def test_scene_meets_its_number(exhibit):
    solution = ancf.solve(ancf.load_scene(exhibit.path))
    assert solution.status is Status.CONVERGED, solution.message
    comparison = compare(exhibit, solution)
    assert comparison.error <= exhibit.limit, comparison


def test_page_and_pictures_are_there():
    text = (EXAMPLES / "README.md").read_text(encoding="utf-8")
    assert len(EXHIBITS) >= 10
    shown = set(re.findall(r"\(gallery/([\w-]+)\.png\)", text))
    assert shown == {exhibit.name for exhibit in EXHIBITS}
    for exhibit in EXHIBITS:
        picture = EXAMPLES / "gallery" / f"{exhibit.name}.png"
        data = picture.read_bytes()
        assert data.startswith(b"\x89PNG")
        assert len(data) <= LARGEST_PICTURE
        assert f"{exhibit.limit:g}: {exhibit.reason}" in text
        assert exhibit.source in text
    assert {p.stem for p in (EXAMPLES / "gallery").iterdir()} == shown


def test_page_shows_what_was_compared():
    exhibit = next(e for e in EXHIBITS if e.name == "parallel-robot")
    text = page([compare(exhibit, ancf.solve(ancf.load_scene(exhibit.path)))])
    assert "| (0.00000, 0.00000, 0.30000) N | (0.00000, 0.00000, 0.30000) N |" in text
    assert "![" in text
    assert "## Parallel robot" in text
