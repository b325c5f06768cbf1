"""Fixtures of the certificate: packages nobody touches, a run, its statement, a tree to tamper with."""

from __future__ import annotations

import shutil

import pytest

from tests.certificates import LEFT_OUT, passing_run, reasons, roots_in
from validation.certificate import build, write
from validation.digests import PACKAGE


@pytest.fixture(scope="module")
def sources(tmp_path_factory):
    """One copy of the three packages: the tree itself is never touched, nor read twice while it changes."""
    folder = tmp_path_factory.mktemp("sources")
    for name in ("ancf", "reference", "validation"):
        shutil.copytree(PACKAGE.parent / name, folder / name, ignore=LEFT_OUT)
    return folder


@pytest.fixture(scope="module")
def run(sources):
    return passing_run(roots_in(sources))


@pytest.fixture(scope="module")
def statement(run):
    return build(run)


@pytest.fixture
def tree(sources, tmp_path, statement):
    """Packages and the certificate that they earned."""
    shutil.copytree(sources, tmp_path, dirs_exist_ok=True)
    write(statement, tmp_path / "certificate.json")
    return tmp_path


@pytest.fixture
def refused(sources, tmp_path):
    """Reasons against a certificate (a statement or bytes) for code that nobody touched."""

    def judged(content):
        path = tmp_path / "certificate.json"
        if isinstance(content, bytes):
            path.write_bytes(content)
        else:
            write(content, path)
        return reasons(sources, path)

    return judged
