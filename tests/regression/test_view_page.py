"""`ancf solve --view`: a page that headless Chromium shows from file://; PNG pictures without a display."""

from __future__ import annotations

import importlib.util
import json
import time
from pathlib import Path

import numpy as np
import pytest

import ancf
from ancf import view_page
from ancf.cli import main
from ancf.errors import InputError
from ancf.view_3d import picture, view_of
from ancf.view_skin import FIELDS, closed_skin, telling_field

pyvista = pytest.importorskip("pyvista", reason="three-dimensional pictures need the extra [pictures]")
pytest.importorskip("trame_vtk", reason="the page needs the extra [pictures]")
Image = pytest.importorskip("PIL.Image", reason="pictures need the extra [pictures]")

_spec = importlib.util.spec_from_file_location("chromium", Path(__file__).with_name("chromium.py"))
assert _spec and _spec.loader
chromium = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(chromium)

EXECUTABLE = chromium.find_chromium()
needs_browser = pytest.mark.skipif(EXECUTABLE is None, reason="no chromium on this machine")

EI = 1e6 * np.pi * 0.01**4 / 4
SCENE = f"""
title = "Bent <arm> & tested"
[[rod]]
name = "arm"
length = 0.4
elements = 4
section = {{ shape = "circle", radius = 0.01 }}
material = {{ young_modulus = 1e6, poisson_ratio = 0.3 }}
[[moment]]
value = [0, 0, {1.5 * EI / 0.4}]
"""


def can_draw() -> bool:
    """Whether VTK finds something to draw with: its wheels bring neither EGL nor OSMesa."""
    try:
        with pyvista.vtk_verbosity("off"):
            plotter = pyvista.Plotter(off_screen=True, window_size=[16, 16])
        plotter.add_mesh(pyvista.Sphere(), color="black")
        pixels = plotter.screenshot(return_img=True)
        plotter.close()
    except RuntimeError:
        return False
    return bool(pixels.min() < 128)


@pytest.fixture(scope="module")
def drawing():
    if not can_draw():
        pytest.skip("VTK cannot draw here: no EGL, no OSMesa, no display")


@pytest.fixture(scope="module")
def page(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("page")
    (folder / "arm.toml").write_text(SCENE)
    assert main(["solve", str(folder / "arm.toml"), "--json", "--view", str(folder / "arm.html")]) == 0
    assert sorted(p.name for p in folder.iterdir()) == ["arm.html", "arm.toml"]  # no stage left
    return folder / "arm.html"


def bent(*turns: float):
    """The arm of SCENE under a moment of these turns in E I/L."""
    rod = {
        "name": "arm", "length": 0.4, "elements": 4, "section": {"shape": "circle", "radius": 0.01},
        "material": {"young_modulus": 1e6, "poisson_ratio": 0.3},
    }  # fmt: skip
    return ancf.solve(
        ancf.scene_from_dict({"rod": [rod], "moment": [{"value": [t * EI / 0.4 for t in turns]}]})
    )


@pytest.fixture(scope="module")
def solution():
    return bent(0, 0, 1.5)


@pytest.fixture(scope="module")
def browser():
    assert EXECUTABLE
    try:
        found = chromium.Browser(EXECUTABLE, chromium.WEBGL)
    except (RuntimeError, OSError):  # seen once on a loaded machine: it started and never spoke
        found = chromium.Browser(EXECUTABLE, chromium.WEBGL)
    yield found
    found.close()


def coloured(pixels: np.ndarray) -> np.ndarray:
    """Pixels with colour in them: of the skin, red and blue outside and inside; all else is grey."""
    return np.ptp(pixels[..., :3].astype(int), axis=-1) > 60


def shown(browser, target: Path, patience: float = 30.0) -> np.ndarray:
    """Pixels (height, width, 3) of the page without its legend, once the scene is there."""
    browser.evaluate("document.querySelector('#legend').style.visibility = 'hidden'")
    until = time.monotonic() + patience
    while True:
        browser.screenshot(target)
        pixels = np.asarray(Image.open(target).convert("RGB"))
        if coloured(pixels).sum() > 500 or time.monotonic() > until:
            return pixels
        time.sleep(0.3)


@needs_browser
def test_the_page_shows_the_rod_and_asks_nobody(page, browser, tmp_path):
    seen = len(browser.events)
    browser.open(page, 900, 640)
    pixels = shown(browser, tmp_path / "page.png")
    # A rod of 1:40 that fills half the page, half of its skin coloured: some 900 pixels at least.
    assert coloured(pixels).sum() > 900
    red, blue = pixels[..., 0].astype(int), pixels[..., 2].astype(int)
    assert (red - blue > 60).sum() > 200  # stretched outside of the bend
    assert (blue - red > 60).sum() > 200  # squeezed inside
    events = browser.events[seen:]
    asked = {e["params"]["request"]["url"] for e in events if e["method"] == "Network.requestWillBeSent"}
    assert page.as_uri() in asked
    assert all(url.startswith((page.as_uri(), "data:", "blob:")) for url in asked), asked
    logged = [e["params"]["entry"] for e in events if e["method"] == "Log.entryAdded"]
    wrong = [e for e in events if e["method"] == "Runtime.exceptionThrown"]
    wrong += [e for e in logged if e["level"] == "error"]  # a slow graphics driver is a warning
    assert not wrong, json.dumps(wrong)[:500]


@needs_browser
def test_the_mouse_turns_it(page, browser, tmp_path):
    browser.open(page, 900, 640)
    before = shown(browser, tmp_path / "before.png")
    browser.call("Input.dispatchMouseEvent", type="mousePressed", x=450, y=320, button="left", clickCount=1)
    for step in range(1, 11):
        place = {"x": 450 + 12 * step, "y": 320 + 10 * step}
        browser.call("Input.dispatchMouseEvent", type="mouseMoved", button="left", buttons=1, **place)
    browser.call("Input.dispatchMouseEvent", type="mouseReleased", button="left", clickCount=1, **place)
    time.sleep(0.5)
    after = shown(browser, tmp_path / "after.png")
    assert coloured(after).sum() > 500
    assert (coloured(before) != coloured(after)).sum() > 0.5 * coloured(before).sum()


def test_title_and_legend_are_in_the_page(page):
    text = page.read_text(encoding="utf-8")
    assert text.count("<title>Bent &lt;arm&gt; &amp; tested</title>") == 1
    assert "vtk-js/icon" not in text
    assert "default-src 'none'" in text
    # A fibre at R of an arc of angle 1.5 is strained by kappa R = 1.5 R/L = 3.75 %, E_xx = e + e^2/2 = 3.82 %
    # outside; what the section takes of it changes the third digit.
    assert "<span>axial strain [%]</span>" in text
    high = float(text.split("<span>0</span><span>")[1].split("</span>")[0])
    assert high == pytest.approx(3.8, rel=0.02)
    assert len(text) < 2e6  # the viewer has 1.05 MB


def test_an_old_page_survives_a_failure(page, tmp_path, solution, monkeypatch):
    target = tmp_path / "page.html"
    target.write_text("old")

    def broken(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("os.replace", broken)
    with pytest.raises(OSError, match="No space"):
        view_page.write_page(solution, target)
    assert target.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["page.html"]


def test_without_the_extra_it_says_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setattr(view_page, "find_spec", lambda name: None)
    with pytest.raises(InputError) as refused:
        view_page.check_page_path(tmp_path / "page.html")
    message = refused.value.message
    assert message.what == "The page cannot be written."
    assert message.where == f"--view {tmp_path / 'page.html'}"
    assert message.value == "pyvista and trame-vtk are not installed"
    assert message.cause == "three-dimensional pictures are an extra"
    assert message.advice == "try after pip install 'ancf[pictures]'"


def test_an_unfinished_solve_is_said_in_the_page(tmp_path, solution):
    from dataclasses import replace

    stopped = replace(solution, status=ancf.Status.LIMIT_POINT, load_factor=0.625)
    view_page.write_page(stopped, tmp_path / "page.html")
    assert "limit_point at load factor 0.625" in (tmp_path / "page.html").read_text(encoding="utf-8")


def test_picture_is_whole_small_and_shows_the_rod(tmp_path, solution, drawing):
    picture(solution, tmp_path / "arm.png")
    pixels = np.asarray(Image.open(tmp_path / "arm.png").convert("RGB"))
    assert coloured(pixels).sum() > 2000
    assert (pixels[0] == 255).all()  # white, and nothing cut off
    assert (pixels[:, [0, -1]] == 255).all()
    assert (tmp_path / "arm.png").stat().st_size < 60_000
    assert [p.name for p in tmp_path.iterdir()] == ["arm.png"]


def test_field_on_the_skin(solution):
    """Von Mises stress of little bending, sigma_xx = E kappa R alone, and of twist, sqrt(3) M R/(2 I)."""
    for turns, expected in (((0, 0, 0.1), 1e6 * 0.1), ((0.1, 0, 0), 3**0.5 * 1e6 * 0.1 / 2)):
        view = view_of(bent(*turns), "stress")
        view.plotter.close()
        assert view.scale.low == 0.0
        assert view.scale.title == "von Mises stress [kPa]"
        # Of second order in the strain of 0.25 %.
        assert view.scale.high == pytest.approx(1e-3 * expected * 0.01 / 0.4, rel=0.01)


def test_the_field_is_the_one_that_tells_something(solution):
    assert telling_field(solution) is FIELDS["axial strain"]
    assert telling_field(bent(0.2, 0, 0)) is FIELDS["stress"]


def test_skin_is_closed_and_faces_outwards():
    angle = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    y, z = 0.1 * np.cos(angle), 0.1 * np.sin(angle)
    rings = np.array([np.column_stack([np.full(24, x), y, z]) for x in (0.0, 0.5, 1.0)])
    skin = closed_skin(rings)
    # Volume of a prism over a regular polygon of 24 corners; the sign is that of the normals.
    assert skin.triangulate().volume == pytest.approx(0.5 * 24 * 0.1**2 * np.sin(2 * np.pi / 24), rel=1e-5)
    side = np.abs(skin.points[:, 0] - 0.5) < 1e-6
    outwards = skin.points[side] * [0, 1, 1]
    assert (np.einsum("pa,pa->p", skin.point_data["Normals"][side], outwards) > 0.099).all()
