"""Check that the packages of evenspin depend on one another one way only.

    check_python_layers.py <root of the repository>

Every violation is printed as `file:line: rule`. Exit status: 0 none, 1 some, 2 there was nothing to check.

Order     A package of tools/src/evenspin imports only packages that stand above it in ORDER. A package that ORDER does
          not list is a violation, too: whoever adds one says where it belongs.
Circles   No module imports itself through others, within a package or across packages. Imports inside of functions and
          imports for type checkers count: they are dependencies of the reader all the same.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

SOURCES = "tools/src"
PACKAGE = "evenspin"

# From what knows nothing to what knows everything. Packages of one line do not know each other.
ORDER = (
    ("errors",),
    ("native", "tableview", "build", "plausible"),
    ("model", "blocks", "effects", "output", "recording"),
    ("sim",),
    ("log", "analysis", "doctor", "importer"),
    ("report", "cycles", "drive", "export"),
    ("compare", "memory", "design", "motor"),
    ("identify", "empirical"),
    ("weakform",),
    ("bench", "reproduce", "run", "gap", "balance"),
    ("tune", "driven", "grid", "replay", "correct"),
    ("commission", "scope", "blind", "api"),
    ("cli",),
)


@dataclass(frozen=True, slots=True)
class Import:
    """One module of ours that a module imports, and where."""

    module: str
    line: int


def module_name(path: Path, sources: Path) -> str:
    parts = path.relative_to(sources).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


def imports_of(source: str, modules: Iterable[str]) -> Iterator[Import]:
    """What a source imports of @p modules; `from package import name` is the module package.name where there is one."""
    known = frozenset(modules)
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            inner = [f"{node.module}.{alias.name}" for alias in node.names]
            names = [name if name in known else node.module for name in inner]
        else:
            continue
        for name in dict.fromkeys(names):
            if name in known:
                yield Import(name, node.lineno)


def package_of(module: str) -> str | None:
    """The package below evenspin that a module is in; None for evenspin itself, which everyone may import: it loads the
    others only when they are asked for."""
    parts = module.split(".")
    return parts[1] if len(parts) > 1 else None


def levels(order: Iterable[Iterable[str]]) -> dict[str, int]:
    return {name: level for level, names in enumerate(order) for name in names}


def order_faults(
    importer: str, found: Iterable[Import], order: Iterable[Iterable[str]] = ORDER
) -> Iterator[tuple[int, str]]:
    """Line and rule of every import of a module that points the wrong way."""
    level = levels(order)
    here = package_of(importer)
    if here is None:
        return
    if here not in level:
        yield 1, f"{here} has no place in ORDER"
        return
    for item in found:
        there = package_of(item.module)
        if there is not None and there != here and level.get(there, len(level)) >= level[here]:
            yield item.line, f"{here} does not import {there}"


def circle(graph: Mapping[str, Iterable[str]]) -> list[str] | None:
    """One circle of modules, each importing the next, or None."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(reversed(error.args[1]))
    return None


def main(arguments: list[str]) -> int:
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    root = Path(arguments[0])
    sources = root / SOURCES
    files = {module_name(path, sources): path for path in sorted((sources / PACKAGE).rglob("*.py"))}
    if not files:
        print(f"check_python_layers: no modules below {sources}", file=sys.stderr)
        return 2
    count = 0
    graph: dict[str, list[str]] = {}
    for module, path in files.items():
        found = list(imports_of(path.read_text(encoding="utf-8"), files))
        graph[module] = [item.module for item in found if item.module != module]
        for line, rule in sorted(order_faults(module, found)):
            print(f"{path.relative_to(root).as_posix()}:{line}: {rule}")
            count += 1
    while (around := circle(graph)) is not None:
        print(f"{files[around[0]].relative_to(root).as_posix()}:1: a circle: {' -> '.join(around)}")
        graph[around[0]].remove(around[1])  # look for the next one without it
        count += 1
    print(f"check_python_layers: {len(files)} modules, {count} violations")
    return 1 if count else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
