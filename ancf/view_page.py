"""An interactive page of a solution: one HTML file that needs neither network nor server.

The page is the offline viewer of vtk.js, which trame-vtk ships and pyvista's own export writes as well, with
the scene inside. It is filled here through the serialiser of trame-vtk, because pyvista's export starts a web
server first and needs four packages more. Nothing is drawn here, so no graphics is needed, only the extra
"pictures".
"""

from __future__ import annotations

import html
import io
import json
import os
import tempfile
import zipfile
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ancf.errors import InputError, Message
from ancf.solution import Status

if TYPE_CHECKING:
    from ancf.solution import Solution
    from ancf.view_3d import View

PAGE_KINDS = (".html", ".htm")
PACKAGES = {"pyvista": "pyvista", "trame_vtk": "trame-vtk"}  # module: name for pip

# The viewer asks Kitware's server for an icon; the policy holds whatever else a later viewer may ask for.
FAVICON = "https://kitware.github.io/vtk-js/icon/favicon-${t}x${t}.png"
POLICY = (
    '<meta http-equiv="Content-Security-Policy" content="default-src \'none\'; img-src data: blob:; '
    "script-src 'unsafe-inline' 'unsafe-eval' blob:; style-src 'unsafe-inline'; worker-src blob:; "
    'connect-src data: blob:">'
)
STYLE = """
      #heading, #legend { position: fixed; z-index: 9; pointer-events: none; color: #1b2631;
        font: 14px/1.4 Helvetica, Arial, sans-serif; }
      #heading { left: 20px; top: 16px; right: 20px; }
      #heading h1 { font-size: 18px; margin: 0; }
      #heading p { margin: 2px 0 0; color: #5d6d7e; }
      #legend { left: 50%; bottom: 16px; width: min(320px, 80vw); transform: translateX(-50%);
        text-align: center; }
      #legend div { height: 12px; margin: 4px 0 2px; }
      #legend p { display: flex; justify-content: space-between; margin: 0; }
    """


def check_page_path(path: str | os.PathLike[str]) -> Path:
    """Refuse, before anything is computed, a page that could not be written (`InputError`)."""
    target = Path(path)
    missing = [name for module, name in PACKAGES.items() if find_spec(module) is None]
    problem: tuple[str, str, str] | None = None
    if target.suffix.lower() not in PAGE_KINDS:
        problem = (
            f"the ending {target.suffix or '(none)'} is not .html",
            "--view writes a page",
            "FILE.html",
        )
    elif target.is_dir():
        problem = ("it is a directory", "the name is taken by a folder", "another name")
    elif not target.parent.is_dir():
        problem = (f"{target.parent} is no folder", "a misspelt path", "an existing folder")
    elif not os.access(target.parent, os.W_OK):
        problem = (f"{target.parent} may not be written", "missing permission", "another folder")
    elif missing:
        problem = (
            f"{' and '.join(missing)} {'are' if len(missing) > 1 else 'is'} not installed",
            "three-dimensional pictures are an extra",
            "after pip install 'ancf[pictures]'",
        )
    if problem is not None:
        value, cause, advice = problem
        raise InputError(
            Message("The page cannot be written.", f"--view {target}", value, cause, f"try {advice}")
        )
    return target


def write_page(solution: Solution, path: str | os.PathLike[str]) -> None:
    """Write the page of a solution: turned with the mouse, 1.3 MB for one rod, whole or not at all."""
    target = check_page_path(path)
    text = _page(solution)
    with tempfile.TemporaryDirectory(dir=target.parent, prefix=".unfinished-") as stage:
        written = Path(stage) / target.name
        written.write_text(text, encoding="utf-8")
        os.replace(written, target)


def _page(solution: Solution) -> str:
    """The viewer with the scene inside, with our title, legend and policy instead of its own."""
    from trame_vtk.tools.vtksz2html import write_html

    from ancf.view_3d import aim, view_of

    view = view_of(solution)
    aim(view)
    page = io.StringIO()
    write_html(_packed_scene(view.plotter.render_window), page)
    view.plotter.close()
    before, _, rest = page.getvalue().partition("<title>")
    _, _, rest = rest.partition("</title>")
    head, _, body = rest.partition("<body>")
    title = html.escape(solution.scene.title or "ancf")
    new_head = f"{before}{POLICY}\n    <title>{title}</title>\n    <style>{STYLE}</style>{head}"
    return f"{new_head}<body>\n{_overlay(view, title)}{body.replace(FAVICON, 'data:,')}"


def _packed_scene(window: Any) -> bytes:
    """Zip archive of the render window as vtk.js reads it: the scene, and its arrays by hash."""
    from trame_vtk.modules.vtk import serializers

    serializers.initialize_serializers()
    context = serializers.SynchronizationContext()
    context.set_ignore_last_dependencies(True)
    name = serializers.reference_id(window)
    scene: Any = serializers.serialize(None, window, name, context, 1)
    camera = window.GetRenderers().GetFirstRenderer().GetActiveCamera()
    scene["extra"] = {
        "vtkRefId": name,
        "centerOfRotation": camera.GetFocalPoint(),
        "camera": serializers.reference_id(camera),
    }
    arrays = {
        entry["hash"]: {**entry, "content": context.get_cached_data_array(entry["hash"], False)}
        for entry in serializers.extract_array_hash(scene)
    }
    packed = io.BytesIO()
    with zipfile.ZipFile(packed, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("index.json", json.dumps({"hashes": arrays, "scene": scene}))
    return packed.getvalue()


def _overlay(view: View, title: str) -> str:
    """Title, how to turn the scene, and the legend of the field, in front of the scene."""
    import matplotlib
    from matplotlib.colors import to_hex

    colours = matplotlib.colormaps[view.scale.colours]
    stops = ", ".join(to_hex(colours(i / 16)) for i in range(17))
    low, high = view.scale.low, view.scale.high
    solution = view.solution
    state = ""
    if solution.status is not Status.CONVERGED:
        state = f"<p>{html.escape(str(solution.status))} at load factor {solution.load_factor:.3g}</p>"
    # The viewer fills .content, and would empty the body without one.
    return f"""    <div class="content"></div>
    <div id="heading"><h1>{title}</h1>{state}
      <p>Drag to turn, wheel to zoom, shift and drag to move.</p></div>
    <div id="legend"><span>{html.escape(view.scale.title)}</span>
      <div style="background: linear-gradient(to right, {stops})"></div>
      <p><span>{low:.3g}</span><span>{0.5 * (low + high):.3g}</span><span>{high:.3g}</span></p></div>
"""
