"""What linters do not know of this house: private modules, circles of imports, kernels' arguments.

    python tools/check_structure.py [SOURCE]

Prints one line per fault and ends with 1 if there is one. Imports count wherever they stand, also
those for the type checker alone.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

MOST_ARGUMENTS = 8
"""Of a compiled kernel; what is more belongs into records."""

TASK_KINDS = {"formation", "individual", "commands"}
KNOWS_KINDS = ("scenario", "checking")
"""The kind of task is asked for where files are read, and by the checker, which shares nothing."""

Module = tuple[str, ...]


def main(source: Path) -> int:
    """Check all modules below a package's folder."""
    trees = {name: (path, ast.parse(path.read_text("utf-8"))) for name, path in modules(source)}
    arrows = {name: set(imports(tree, name, trees)) for name, (_, tree) in trees.items()}
    faults = [
        *(f"{trees[name][0]}: imports {'.'.join(to)}" for name, to in private(arrows)),
        *(
            f"a circle of imports: {' -> '.join('.'.join(name) for name in c)}"
            for c in circles(arrows)
        ),
    ]
    for name, (path, tree) in trees.items():
        faults += [f"{path}:{line}: {what}" for line, what in kernels(tree)]
        if len(name) > 1 and name[1] not in KNOWS_KINDS:
            faults += [f"{path}:{line}: asks for the kind of task" for line in kinds(tree)]
    print("\n".join(faults) if faults else f"{len(trees)} modules in order")
    return 1 if faults else 0


def modules(source: Path) -> Iterator[tuple[Module, Path]]:
    """Names and files of all modules; a package goes by its own name."""
    for path in sorted(source.rglob("*.py")):
        name = (source.name, *path.relative_to(source).with_suffix("").parts)
        yield (name[:-1] if name[-1] == "__init__" else name), path


def imports(tree: ast.AST, name: Module, known: dict) -> Iterator[Module]:
    """The modules that a module imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and node.module and not node.level:
            base = tuple(node.module.split("."))
            for alias in node.names:
                to = (*base, alias.name) if (*base, alias.name) in known else base
                if to in known and to != name:
                    yield to
        elif isinstance(node, ast.Import):
            yield from (to for alias in node.names if (to := tuple(alias.name.split("."))) in known)


def private(arrows: dict[Module, set[Module]]) -> Iterator[tuple[Module, Module]]:
    """Imports of another package's private module."""
    for name, targets in arrows.items():
        for to in sorted(targets):
            if any(part.startswith("_") for part in to[1:]) and name[:2] != to[:2]:
                yield name, to


def circles(arrows: dict[Module, set[Module]]) -> Iterator[list[Module]]:
    """One circle for each way back that a walk along the imports finds."""
    done: set[Module] = set()

    def walk(name: Module, trail: list[Module]) -> Iterator[list[Module]]:
        if name in trail:
            yield [*trail[trail.index(name) :], name]
        elif name not in done:
            for to in sorted(arrows[name]):
                # A package's front page hands names on; whoever is below it does not need it.
                if to != name[: len(to)]:
                    yield from walk(to, [*trail, name])
            done.add(name)

    for name in sorted(arrows):
        yield from walk(name, [])


def kernels(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Compiled kernels with too many arguments."""
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef):
            compiled = any("njit" in ast.unparse(one) for one in node.decorator_list)
            count = len(node.args.posonlyargs + node.args.args)
            if compiled and count > MOST_ARGUMENTS:
                yield node.lineno, f"kernel {node.name} has {count} arguments"


def kinds(tree: ast.AST) -> Iterator[int]:
    """Lines that compare something's `kind` with a kind of task."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            values = {n.value for n in ast.walk(node) if isinstance(n, ast.Constant)}
            asked = any(isinstance(n, ast.Attribute) and n.attr == "kind" for n in ast.walk(node))
            if asked and values & TASK_KINDS:
                yield node.lineno


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1] if len(sys.argv) > 1 else "src/cavalcade")))
