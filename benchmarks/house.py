"""`python -m benchmarks.house`: how easily the code is read, in figures: files, functions, docstrings, names, papers.

Measured of the package `ods` alone; tests are only counted. A function's docstring is no part of its length, `self` and
`cls` are no parameters, and a name that a module imports from another one is defined in that other one only.
"""

import argparse
import ast
import re
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from statistics import median

Function = ast.FunctionDef | ast.AsyncFunctionDef
KERNEL_DECORATORS = ("kernel", "compiled", "njit", "jit", "vectorize", "cfunc")
MOST_PARAMETERS = 6
FRONT_DOOR = {
    "how to contribute": "CONTRIBUTING.md",
    "architecture page": "docs/architecture.md",
    "pre-commit": ".pre-commit-config.yaml",
    "CI workflow": ".github/workflows/*.yml",
    "editor settings": ".editorconfig",
    "py.typed": "ods/py.typed",
    "changelog": "CHANGELOG.md",
    "decisions": "docs/decisions/*.md",
}


@dataclass(frozen=True)
class Source:
    """One parsed file of the package."""

    path: Path
    text: str
    tree: ast.Module

    @property
    def lines(self) -> int:
        """Number of lines."""
        return len(self.text.splitlines())


@dataclass(frozen=True)
class Measured:
    """One function or method, at any depth."""

    where: str
    """Path and line."""
    name: str
    lines: int
    """From `def` to the last line, without the docstring."""
    parameters: int
    typed: bool
    """Every parameter and the result have a type."""
    kernel: bool
    """Compiled by numba."""


def sources(folder: Path) -> list[Source]:
    """Parse every Python file below `folder`."""
    texts = ((path, path.read_text(encoding="utf-8")) for path in sorted(folder.rglob("*.py")))
    return [Source(path, text, ast.parse(text)) for path, text in texts]


def functions(source: Source) -> Iterator[Measured]:
    """Measure every function of a file."""
    for node in ast.walk(source.tree):
        if isinstance(node, Function):
            arguments = _parameters(node)
            yield Measured(
                where=f"{source.path}:{node.lineno}",
                name=node.name,
                lines=node.end_lineno - node.lineno + 1 - _docstring_lines(node) if node.end_lineno else 0,
                parameters=len(arguments),
                typed=node.returns is not None and all(argument.annotation for argument in arguments),
                kernel=any(_last_name(decorator) in KERNEL_DECORATORS for decorator in node.decorator_list),
            )


def _parameters(function: Function) -> list[ast.arg]:
    given = function.args
    every = [*given.posonlyargs, *given.args, *given.kwonlyargs, *filter(None, (given.vararg, given.kwarg))]
    return [argument for argument in every if argument.arg not in ("self", "cls")]


def _docstring_lines(function: Function) -> int:
    first = function.body[0]
    return (first.end_lineno or first.lineno) - first.lineno + 1 if ast.get_docstring(function) else 0


def _last_name(decorator: ast.expr) -> str:
    """Return `c` of the decorator @c, @a.c or @a.c(...)."""
    inner = decorator.func if isinstance(decorator, ast.Call) else decorator
    return inner.attr if isinstance(inner, ast.Attribute) else inner.id if isinstance(inner, ast.Name) else ""


def documented(module: ast.Module) -> Iterator[bool]:
    """Yield, for the module and each public class, function and method of it, whether it has a docstring."""
    yield ast.get_docstring(module) is not None
    containers: list[ast.Module | ast.ClassDef] = [module]
    while containers:
        for node in containers.pop().body:
            if isinstance(node, Function | ast.ClassDef) and not node.name.startswith("_"):
                yield ast.get_docstring(node) is not None
                if isinstance(node, ast.ClassDef):
                    containers.append(node)


def public_definitions(module: ast.Module) -> set[str]:
    """Return the public classes and functions that a module itself defines."""
    found = (node.name for node in module.body if isinstance(node, Function | ast.ClassDef))
    return {name for name in found if not name.startswith("_")}


def public_constants(module: ast.Module) -> set[str]:
    """Return the public names that a module itself gives a value: constants, type aliases."""
    names: set[str] = set()
    for node in module.body:
        if isinstance(node, ast.Assign | ast.AnnAssign):
            targets = node.targets if isinstance(node, ast.Assign) else [node.target]
            names.update(name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name))
    return {name for name in names if not name.startswith("_")}


def in_several_modules(package: Sequence[Source], names_of: Callable[[ast.Module], set[str]]) -> dict[str, list[Path]]:
    """Return the names that `names_of` finds in more than one module, with those modules."""
    homes: defaultdict[str, list[Path]] = defaultdict(list)
    for source in package:
        for name in names_of(source.tree):
            homes[name].append(source.path)
    return {name: paths for name, paths in sorted(homes.items()) if len(paths) > 1}


def front_door(root: Path) -> dict[str, bool]:
    """Return which of the things that a newcomer looks for first are there."""
    return {what: any(root.glob(pattern)) for what, pattern in FRONT_DOOR.items()}


def table(root: Path, package: Sequence[Source], all_functions: Sequence[Measured]) -> dict[str, str]:
    """Return what is measured, and the figures."""
    lengths = [source.lines for source in package]
    folders = Counter(source.path.parent for source in package)
    (largest, files), *_ = folders.most_common(1)
    many = [found for found in all_functions if found.parameters > MOST_PARAMETERS]
    kernels = sum(found.kernel for found in many)
    documents = [has for source in package for has in documented(source.tree)]
    test_lines = sum(source.lines for source in sources(root / "tests"))
    doors = front_door(root)
    missing = [what for what, there in doors.items() if not there]
    return {
        "files; lines, median / max": f"{len(lengths)}; {median(lengths):.0f} / {max(lengths)}",
        "functions; lines, median": f"{len(all_functions)}; {median(found.lines for found in all_functions):.0f}",
        "functions over 50 / 30 lines": " / ".join(
            _share([f.lines > most for f in all_functions]) for most in (50, 30)
        ),
        f"more than {MOST_PARAMETERS} parameters": f"{_share([f in many for f in all_functions])}"
        f" ({len(many)}, of them {kernels} numba kernels)",
        "public docstrings; typed": f"{_share(documents)}; {_share([found.typed for found in all_functions])}",
        "test / source lines": f"{test_lines / sum(lengths):.2f}",
        "largest flat folder, files": f"{files} ({largest.relative_to(root)})",
        "names of several modules: classes and functions; constants": "; ".join(
            f"{len(in_several_modules(package, names_of))}" for names_of in (public_definitions, public_constants)
        ),
        "`type: ignore`": f"{sum(len(re.findall(r'# type: ignore', source.text)) for source in package)}",
        f"front door, of {len(doors)}": f"{sum(doors.values())}" + (f" (no {', '.join(missing)})" if missing else ""),
    }


def _share(flags: Sequence[bool]) -> str:
    return f"{100 * sum(flags) / len(flags):.2f} %"


def details(package: Sequence[Source], all_functions: Sequence[Measured]) -> Iterator[str]:
    """Yield the functions of many parameters and the names of several modules, one a line."""
    for found in all_functions:
        if found.parameters > MOST_PARAMETERS:
            yield f"{found.where}: {found.name}, {found.parameters} parameters{', kernel' * found.kernel}"
    for names_of in (public_definitions, public_constants):
        for name, paths in in_several_modules(package, names_of).items():
            yield f"{name}: {', '.join(map(str, paths))}"


def main() -> None:
    """Print the table; with --list, the functions and names behind its figures too."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("root", type=Path, nargs="?", default=Path(), help="folder of the project (default: here)")
    parser.add_argument("--list", action="store_true", help="name the functions and names behind the figures")
    args = parser.parse_args()
    package = sources(args.root / "ods")
    all_functions = [found for source in package for found in functions(source)]
    print("| | here |\n|---|---|")
    for what, figures in table(args.root, package, all_functions).items():
        print(f"| {what} | {figures} |")
    if args.list:
        print("", *details(package, all_functions), sep="\n")


if __name__ == "__main__":
    main()
