"""Scene files on disk: encoding, syntax, missing files, the examples."""

from pathlib import Path

import pytest

from ancf.errors import SceneError
from ancf.scene_file import load_scene


def refused_file(path: Path) -> SceneError:
    with pytest.raises(SceneError) as caught:
        load_scene(path)
    return caught.value


@pytest.mark.parametrize(
    ("content", "place"),
    [
        (b"title = \n", ": line 1, column 9"),
        (b"a = 1\na = 2\n", ": line 2"),
        (b"[[rod]]\nlength = 0.4 m\n", ": line 2, column 14"),
    ],
)
def test_syntax_errors_name_line_and_column(tmp_path: Path, content: bytes, place: str):
    file = tmp_path / "scene.toml"
    file.write_bytes(content)
    message = refused_file(file).message
    assert message.what == "The scene file is not valid TOML."
    assert message.where.startswith(str(file) + place)


@pytest.mark.parametrize(
    ("content", "what", "value"),
    [
        (b"\xff\xfe\x00t", "cannot be read", "byte 0 is not UTF-8"),
        (b"a = " + b"[" * 100_000, "TOML", ""),
        (b"a = " + b"9" * 5000, "cannot be parsed", "4300 digits"),
        (b"#" * 10_000_001, "cannot be read", "larger than 10 MB"),
    ],
    ids=["encoding", "nesting", "digits", "size"],
)
def test_strange_files_are_refused(tmp_path: Path, content: bytes, what: str, value: str):
    file = tmp_path / "scene.toml"
    file.write_bytes(content)
    message = refused_file(file).message
    assert what in message.what or "cannot be parsed" in message.what
    assert value in message.value


def test_missing_file_and_directory_are_refused(tmp_path: Path):
    assert refused_file(tmp_path / "none.toml").message.value == "no such file"
    assert refused_file(tmp_path).message.value == "it is a directory"
    assert refused_file(Path("nul\0byte")).message.what == "The scene file cannot be read."


def test_file_with_byte_order_mark_is_read(tmp_path: Path):
    file = tmp_path / "scene.toml"
    text = (
        '[[rod]]\nlength = "40 cm"\nelements = 2\nsection = { shape = "circle", radius = 0.01 }\n'
        "material = { young_modulus = 1e6, poisson_ratio = 0.3 }\n"
    )
    file.write_bytes(b"\xef\xbb\xbf" + text.encode())
    assert load_scene(file).rods[0].length == 0.4


EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.toml"))


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_are_valid(path: Path):
    scene = load_scene(path)
    assert scene.title and scene.rods


def test_there_are_examples():
    assert {"fig2-force-x", "fig2-force-z", "fig2-moment-y", "fig2-moment-z"} < {
        path.stem for path in EXAMPLES
    }
