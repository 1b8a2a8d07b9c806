"""Which tests may notice a mutant, those that cost least first."""

import ast
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from mutants import Mutant


@dataclass(frozen=True)
class Covering:
    """What the test files run, as `covering` found it."""

    found: list[dict[str, dict[str, object]]]
    sources: list[Path]

    @cached_property
    def seconds(self) -> dict[str, float]:
        """CPU seconds of each test that passes, measured while it was traced."""
        return {
            test: facts["seconds"] for of in self.found for test, facts in of["tests"].items() if facts["passed"]
        }

    @cached_property
    def lines(self) -> dict[str, dict[int, set[str]]]:
        """Of each file and each line, the tests that run it."""
        lines: dict[str, dict[int, set[str]]] = {}
        for of in self.found:
            for path, of_file in of["lines"].items():
                for line, tests in of_file.items():
                    known = self.seconds.keys() & set(tests)
                    lines.setdefault(path, {}).setdefault(int(line), set()).update(known)
        return lines

    @cached_property
    def _trees(self) -> dict[Path, ast.Module]:
        return {path: ast.parse(path.read_text()) for path in self.sources}

    def running(self, path: Path, first: int, last: int) -> set[str]:
        """Return the tests that run any of the lines."""
        of_file = self.lines.get(str(path), {})
        return set().union(*(of_file.get(line, set()) for line in range(first, last + 1)))

    def _inside(self, function: ast.FunctionDef | ast.AsyncFunctionDef, path: Path) -> set[str]:
        return self.running(path, function.body[0].lineno, function.end_lineno or 0)

    def _naming(self, names: set[str]) -> set[str]:
        """Return the tests that run a function in which one of the names occurs."""
        tests: set[str] = set()
        for path, tree in self._trees.items():
            for function in ast.walk(tree):
                if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef) and any(
                    (isinstance(node, ast.Name) and node.id in names)
                    or (isinstance(node, ast.Attribute) and node.attr in names)
                    for node in ast.walk(function)
                ):
                    tests |= self._inside(function, path)
        return tests

    def tiers(self, mutant: Mutant) -> Iterator[set[str]]:
        """Yield sets of tests, those first that are likeliest to notice.

        First come those that run the statement, or that run what uses the names it defines, if it runs at import.
        What an earlier test has cached is not run again in a later one, so there follow those that run anything
        of the same function, and of the same file; last come the tests that name the file's module, which
        may use it in a process that could not be traced.
        """
        tree, path, line = self._trees[mutant.path], mutant.path, mutant.line
        around = [
            node
            for node in ast.walk(tree)
            if isinstance(node, ast.stmt | ast.ExceptHandler) and _first(node) <= line <= (node.end_lineno or 0)
        ]
        functions = [node for node in around if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
        innermost = max(around, key=lambda node: (_first(node), -(node.end_lineno or 0)))
        within = [function for function in functions if line >= function.body[0].lineno]
        if within:
            yield self.running(path, *_lines(innermost))
        elif functions:
            yield self._inside(functions[-1], path)
        else:
            yield self._naming(_defined(innermost))
        for function in reversed(functions):
            yield self._inside(function, path)
        yield set().union(
            *(self._inside(node, path) for node in ast.walk(tree) if isinstance(node, ast.FunctionDef))
        )
        yield {test for test in self.seconds if path.stem in Path(test.partition("::")[0]).read_text()}

    def chosen(self, mutant: Mutant, budget: float) -> list[str]:
        """Return the tests to run, in their order; together they take no more CPU seconds than the budget."""
        tests: list[str] = []
        left = budget
        for tier in self.tiers(mutant):
            for test in sorted(tier - set(tests), key=lambda test: (self.seconds[test], test)):
                left -= self.seconds[test]
                if left < 0 and tests:
                    return tests
                tests.append(test)
        return tests


def _first(node: ast.AST) -> int:
    decorators = getattr(node, "decorator_list", [])
    return min([node.lineno, *(decorator.lineno for decorator in decorators)])


def _lines(node: ast.AST) -> tuple[int, int]:
    """Return first and last line of a statement, of one with a body those of its head."""
    body = getattr(node, "body", None)
    last = max(node.lineno, body[0].lineno - 1) if isinstance(body, list) and body else node.end_lineno
    return _first(node), last or node.lineno


def _defined(node: ast.AST) -> set[str]:
    """Return the names that a statement at the level of a module or class defines."""
    if isinstance(node, ast.ClassDef):
        return {node.name}
    targets = getattr(node, "targets", [getattr(node, "target", None)])
    return {
        name.id if isinstance(name, ast.Name) else name.attr
        for target in targets
        if target is not None
        for name in ast.walk(target)
        if isinstance(name, ast.Name | ast.Attribute)
    }
