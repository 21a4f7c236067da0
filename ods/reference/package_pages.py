"""Page of the packages: each package of `ods` with the line that its `__init__.py` says of it, and its folders."""

import ast
from pathlib import Path

import ods

ON_BOARD = {
    "base", "bridge", "client", "compiled", "listen", "messages", "nav_bridge", "pipeline", "pose", "recording", "ros2",
    "runtime", "sonar_link", "tracker",
}  # fmt: skip
HEAD = """# Packages

Generated from `ods/*/__init__.py` by `make docs`. [How they depend on each other](README.md#packages).

Folders have names of the configuration or of the field: the stage `filter.wiener` is `ods/pipeline/filter/wiener.py`.
"""


def package_pages() -> dict[str, str]:
    """Return the page: name and text."""
    root = Path(ods.__file__).parent
    packages = sorted(path.parent for path in root.glob("*/__init__.py"))
    on_board = "".join(_section(folder) for folder in packages if folder.name in ON_BOARD)
    others = "".join(_section(folder) for folder in packages if folder.name not in ON_BOARD)
    return {"architecture/packages.md": f"{HEAD}\n## On board\n\n{on_board}\n## Off board\n\n{others}"}


def _section(package: Path) -> str:
    """Return a package's row, which ends with its folders."""
    inside = sorted(path.parent.name for path in package.glob("*/__init__.py"))
    listed = f" ({', '.join(f'`{folder}`' for folder in inside)})" if inside else ""
    return f"- `{package.name}`: {_says(package)}{listed}\n"


def _says(folder: Path) -> str:
    """Return the first paragraph of a package's docstring as one line."""
    text = ast.get_docstring(ast.parse((folder / "__init__.py").read_text(encoding="utf-8"))) or ""
    return " ".join(text.split("\n\n")[0].split())
