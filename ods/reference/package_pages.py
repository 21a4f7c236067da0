"""Pages of the packages: each folder of `ods` with the line that its `__init__.py` says of it."""

import ast
from pathlib import Path

import ods

ON_BOARD = {
    "base", "bridge", "client", "compiled", "listen", "messages", "nav_bridge", "pipeline", "pose", "recording", "ros2",
    "runtime", "sonar_link", "tracker",
}  # fmt: skip
FOLDER, ON, OFF = "architecture", "packages.md", "packages-off-board.md"
HEAD = """# Packages {where}

Generated from the folders' own docstrings by `make docs`; do not edit. How they are arranged:
[architecture](README.md). Others: [{others}]({page}).

A folder's name is a word of the configuration or of the field: `use = "filter.wiener"` is in
`ods/pipeline/filter/wiener.py`.

| folder | what belongs there |
|---|---|
"""


def package_pages() -> dict[str, str]:
    """Return the pages: name and text."""
    root = Path(ods.__file__).parent
    on_board, others = "", ""
    for folder in sorted(path.parent for path in root.rglob("__init__.py") if path.parent != root):
        row = f"| `{folder.relative_to(root.parent).as_posix()}/` | {_says(folder)} |\n"
        if folder.relative_to(root).parts[0] in ON_BOARD:
            on_board += row
        else:
            others += row
    return {
        f"{FOLDER}/{ON}": HEAD.format(where="on board", others="off board", page=OFF) + on_board,
        f"{FOLDER}/{OFF}": HEAD.format(where="off board", others="on board", page=ON) + others,
    }


def _says(folder: Path) -> str:
    """Return the first paragraph of a package's docstring as one line."""
    text = ast.get_docstring(ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))) or ""
    return " ".join(text.split("\n\n")[0].split())
