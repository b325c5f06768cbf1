"""What a result depends on: the code of a module of reference/ and of all it imports, without the wording."""

from __future__ import annotations

import ast
import hashlib
import io
import tokenize
from pathlib import Path

HERE = Path(__file__).parent
Documented = ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef


def code_digest(module: str, folder: Path = HERE) -> dict[str, str]:
    """Digest of the code of `module` and of every module of the folder that it imports, directly or not.

    Parameters
    ----------
    module : name of a module in `folder`, without the package
    folder : folder of the package ``reference``

    Returns
    -------
    Module name -> first 16 hexadecimal digits of the SHA-256 of its code without docstrings, comments and
    blank lines, so that better wording keeps a result and any other edit gives it up.

    Raises
    ------
    ValueError if there is no such module.
    """
    found: dict[str, str] = {}
    waiting = [module]
    while waiting:
        name = waiting.pop()
        path = folder / f"{name}.py"
        if name in found:
            continue
        if not path.is_file():
            raise ValueError(
                f"There is no module reference/{name}.py to take a digest of. value: {name!r}; "
                "cause: a misspelt kind of result; try: the name of the module that computes it."
            )
        source = path.read_text(encoding="utf-8")
        found[name] = hashlib.sha256(bare_code(source).encode()).hexdigest()[:16]
        waiting += [other for other in _imported(source) if (folder / f"{other}.py").is_file()]
    return dict(sorted(found.items()))


def bare_code(source: str) -> str:
    """Python source without docstrings, comments, blank lines and trailing blanks.

    The text is cut by position and not printed from the syntax tree: `ast.dump` and `ast.unparse` differ from
    one Python to the next, and shipped results have to hold for all.
    """
    lines = source.splitlines()
    drop: list[tuple[int, int, int, int]] = []  # first line, column, last line, column; lines from 0
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, Documented) and ast.get_docstring(node, clean=False) is not None:
            text = node.body[0]
            assert text.end_lineno is not None and text.end_col_offset is not None
            # ast counts columns in bytes, tokenize in characters.
            first = len(lines[text.lineno - 1].encode()[: text.col_offset].decode())
            last = len(lines[text.end_lineno - 1].encode()[: text.end_col_offset].decode())
            drop.append((text.lineno - 1, first, text.end_lineno - 1, last))
    for token in tokenize.generate_tokens(io.StringIO(source).readline):
        if token.type == tokenize.COMMENT:
            drop.append((token.start[0] - 1, token.start[1], token.end[0] - 1, token.end[1]))
    for top, first, bottom, last in sorted(drop, reverse=True):
        rest = lines[bottom][last:]
        lines[top] = lines[top][:first] + rest
        for index in range(top + 1, bottom + 1):
            lines[index] = ""
    return "\n".join(line.rstrip() for line in lines if line.strip())


def _imported(source: str) -> set[str]:
    """Modules of the package that the source imports, inside functions too."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        for name in names:
            parts = name.split(".")
            if parts[0] == "reference" and len(parts) > 1:
                found.add(parts[1])
    return found
