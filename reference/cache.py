"""Results of expensive references as small files, each tied to its inputs and to the code that gave it.

A result is used again only if its file is whole (checksum), was made for exactly these inputs, by exactly
this code, with this major version of scikit-fem. Everything else is named in `Cache.events` and recomputed.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import math
import os
import platform
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from reference.code_digest import code_digest

SOLVED = Path(__file__).parent / "solved"
SCHEMA = 1
KEYS = {"schema", "kind", "inputs", "code", "scikit-fem", "versions", "result", "checksum"}


@dataclass(frozen=True)
class Event:
    """What happened to one result: ``hit``, ``computed``, or why a file was not used.

    ``corrupted``, ``foreign`` and ``stale`` files are not used; ``not stored`` names a file that could not be
    written.
    """

    what: str
    file: str
    detail: str = ""

    @property
    def warning(self) -> str:
        """A sentence for people; empty for a hit and for a result computed because there was none."""
        if self.what in ("hit", "computed"):
            return ""
        then = "the result is not kept" if self.what == "not stored" else "it was not used"
        return f"stored reference {self.file}: {self.what} ({self.detail}); {then}"


def user_folder() -> Path:
    """Folder for results where the package itself cannot be written (``XDG_CACHE_HOME`` is respected)."""
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "ancf" / "solved"


def scikit_fem_version() -> str:
    """Major version of scikit-fem, the only library version that a stored result is tied to.

    scikit-fem chooses elements and quadrature; numpy and scipy change a converged result only by rounding,
    and tying results to them would empty the shipped folder on most machines. They are recorded instead.
    """
    try:
        return importlib.metadata.version("scikit-fem").split(".")[0]
    except importlib.metadata.PackageNotFoundError:
        return "none"


class Cache:
    """Stored results in a folder, and a second folder where the first cannot be written.

    Parameters
    ----------
    folder : where results are looked for first, and written if possible
    fresh : recompute everything once, and store it anew
    fallback : second folder; the user's own if None
    code : folder of the modules that produce results
    """

    def __init__(
        self,
        folder: Path = SOLVED,
        fresh: bool = False,
        fallback: Path | None = None,
        code: Path = SOLVED.parent,
    ) -> None:
        self.folder, self.fresh, self.code = folder, fresh, code
        self.fallback = user_folder() if fallback is None else fallback
        self.events: list[Event] = []
        self._known: dict[str, dict[str, Any]] = {}
        self._digests: dict[str, dict[str, str]] = {}

    @property
    def warnings(self) -> list[str]:
        """Sentences about the files that were not used."""
        return [event.warning for event in self.events if event.warning]

    def get(
        self, kind: str, inputs: Mapping[str, Any], compute: Callable[[], Mapping[str, Any]]
    ) -> dict[str, Any]:
        """The stored result, or a new one from `compute`, which is then stored.

        Parameters
        ----------
        kind : module of reference/ that computes the result, without the package: ``"section"``, ``"solid"``
        inputs : everything the result depends on besides the code: numbers, strings, lists, mappings
        compute : gives the result as a mapping of such values; it raises where there is none, for what is
            returned is kept

        Returns
        -------
        The result after a passage through JSON: lists for arrays, floats exact to the last bit.

        Raises
        ------
        ValueError for a number that is not finite, or a value that is no number, string, list or mapping.
        """
        wanted = plain(inputs, "inputs")
        name = f"{kind}-{checksum({'kind': kind, 'inputs': wanted})[:16]}.json"
        if name not in self._known:
            if kind not in self._digests:
                self._digests[kind] = code_digest(kind, self.code)
            self._known[name] = self._find(name, kind, wanted) or self._make(name, kind, wanted, compute)
        return json.loads(json.dumps(self._known[name]))  # a caller's change stays with the caller

    def _find(self, name: str, kind: str, wanted: Any) -> dict[str, Any] | None:
        if self.fresh:
            return None
        for folder in (self.folder, self.fallback):
            path = folder / name
            if path.exists():
                stored, fault = self._read(path, kind, wanted)
                if stored is not None:
                    self.events.append(Event("hit", name))
                    return stored
                self.events.append(Event(*fault))
        return None

    def _read(self, path: Path, kind: str, wanted: Any) -> tuple[dict[str, Any] | None, tuple[str, str, str]]:
        """The result in a file, or None and the reason (event, file, detail)."""

        def no(what: str, detail: str) -> tuple[None, tuple[str, str, str]]:
            return None, (what, path.name, detail)

        try:
            data = json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError, RecursionError) as error:
            return no("corrupted", f"not readable as JSON: {error}")
        if not isinstance(data, dict) or set(data) != KEYS:
            return no("corrupted", "keys are missing or unknown")
        if not isinstance(data["code"], dict) or not isinstance(data["result"], dict):
            return no("corrupted", "code or result is no table")
        content = {key: value for key, value in data.items() if key != "checksum"}
        try:
            whole = data["checksum"] == checksum(content)
        except ValueError:
            return no("corrupted", "it holds a number that is not finite")
        if not whole:
            return no("corrupted", "its content does not match its checksum")
        if data["schema"] != SCHEMA:
            return no("stale", f"schema {data['schema']}, now {SCHEMA}")
        if data["kind"] != kind or data["inputs"] != wanted:
            return no("foreign", "it was made for other inputs")
        now = self._digests[kind]
        changed = sorted(n for n in {*now, *data["code"]} if now.get(n) != data["code"].get(n))
        if changed:
            return no("stale", f"changed since: {', '.join(f'reference/{n}.py' for n in changed)}")
        if data["scikit-fem"] != scikit_fem_version():
            return no("stale", f"made with scikit-fem {data['scikit-fem']}, now {scikit_fem_version()}")
        return data["result"], ("", "", "")

    def _make(
        self, name: str, kind: str, wanted: Any, compute: Callable[[], Mapping[str, Any]]
    ) -> dict[str, Any]:
        result = plain(compute(), "result")
        content = {
            "schema": SCHEMA,
            "kind": kind,
            "inputs": wanted,
            "code": self._digests[kind],
            "scikit-fem": scikit_fem_version(),
            "versions": _versions(),
            "result": result,
        }
        text = json.dumps({**content, "checksum": checksum(content)}, indent=1, allow_nan=False) + "\n"
        self.events.append(Event("computed", name))
        failures = []
        for folder in (self.folder, self.fallback):
            try:
                write_whole(folder / name, text)
                return result
            except OSError as error:
                failures.append(str(error))
        self.events.append(Event("not stored", name, "; ".join(failures)))
        return result


def plain(value: Any, where: str) -> Any:
    """Numbers, strings, lists and mappings only, arrays as lists; refuses what JSON cannot hold exactly."""
    if hasattr(value, "tolist"):  # arrays and numpy scalars
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): plain(item, f"{where}.{key}") for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item, f"{where}[{index}]") for index, item in enumerate(value)]
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float) and math.isfinite(value):
        return value
    raise ValueError(
        f"A stored reference holds finite numbers, text, lists and mappings only. where: {where}; "
        f"value: {value!r}; cause: a result that did not converge, or an object; try: its numbers."
    )


def checksum(content: Any) -> str:
    """SHA-256 of the content as canonical JSON (sorted keys, shortest exact floats)."""
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def write_whole(path: Path, text: str) -> None:
    """Write a file whole or not at all; makes its folder. Raises OSError."""
    path.parent.mkdir(parents=True, exist_ok=True)
    handle, temporary = tempfile.mkstemp(dir=path.parent, prefix=f".{path.name}.")
    try:
        with os.fdopen(handle, "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(temporary, 0o644)
        os.replace(temporary, path)
    except BaseException:
        os.unlink(temporary)
        raise


def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for package in ("numpy", "scipy", "scikit-fem"):
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            found[package] = "not installed"
    return found


_sessions: list[Cache] = [Cache()]


def session() -> Cache:
    """The cache of the running program; `open_session` starts another."""
    return _sessions[-1]


def open_session(fresh: bool = False, folder: Path = SOLVED, fallback: Path | None = None) -> Cache:
    """Start the cache that `session` gives from now on."""
    _sessions[:] = [Cache(folder, fresh, fallback)]
    return session()
