"""Page of the packages: each folder of `ods` with the line that its `__init__.py` says of it."""

import ast
from pathlib import Path

import ods

HEAD = """# Packages

Generated from the folders' own docstrings by `make docs`; do not edit. How they are arranged:
[architecture](architecture.md).

A folder's name is a word of the configuration or of the field: `use = "filter.wiener"` is in
`ods/pipeline/filter/wiener.py`.

| folder | what belongs there |
|---|---|
"""


def package_page() -> dict[str, str]:
    """Return the page: name and text."""
    root = Path(ods.__file__).parent
    folders = sorted(path.parent for path in root.rglob("__init__.py") if path.parent != root)
    rows = (f"| `{folder.relative_to(root.parent).as_posix()}/` | {_says(folder)} |\n" for folder in folders)
    return {"packages.md": HEAD + "".join(rows)}


def _says(folder: Path) -> str:
    """Return the first paragraph of a package's docstring as one line."""
    text = ast.get_docstring(ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))) or ""
    return " ".join(text.split("\n\n")[0].split())
