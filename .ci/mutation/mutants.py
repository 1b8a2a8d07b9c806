"""Mutants: every one that cosmic-ray makes of the sources, and a sample of them.

A mutant is named by what it is, not by where it stands: by its definition, its line's text and the place in it.
So a sample stays the same when code is moved to another file, and what is not touched keeps its results.
"""

import ast
import hashlib
import warnings
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from cosmic_ray.ast import ast_nodes, get_ast
from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator, operator_names


@dataclass(frozen=True)
class Mutant:
    """One change of one file.

    Attributes
    ----------
    path
        The file, relative to the root.
    line, column
        Where the change begins.
    definition
        The function or class that it is in, such as ``Class.method``; empty at the level of the module.
    operator, occurrence
        What cosmic-ray makes the change with.
    site
        What is changed, as a text that does not depend on the file.
    """

    path: Path
    line: int
    column: int
    definition: str
    operator: str
    occurrence: int
    site: str

    @property
    def name(self) -> str:
        """A text that tells this mutant from all others."""
        return fingerprint(self.site, self.operator, str(self.occurrence_at_site))

    @property
    def occurrence_at_site(self) -> int:
        """Which of the changes that the operator makes at the site."""
        return int(self.site.rpartition("#")[2])

    @cached_property
    def text(self) -> str:
        """The mutated file's text."""
        return mutate_code(self.path.read_text(), get_operator(self.operator)(), self.occurrence) or ""

    @cached_property
    def change(self) -> tuple[str, str]:
        """The lines before and after, without those they have in common, each stripped."""
        before, after = self.path.read_text().splitlines(), self.text.splitlines()
        while before and after and before[0] == after[0]:
            del before[0], after[0]
        while before and after and before[-1] == after[-1]:
            del before[-1], after[-1]
        return " ".join(map(str.strip, before)), " ".join(map(str.strip, after))

    def is_one(self) -> bool:
        """Tell whether the mutant compiles, without a warning as of ``x is 1``, and is another program."""
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", SyntaxWarning)
                mutated = ast.parse(self.text)
                compile(mutated, str(self.path), "exec")
        except (SyntaxError, SyntaxWarning):
            return False
        return ast.dump(mutated) != ast.dump(ast.parse(self.path.read_text()))


def fingerprint(*parts: str) -> str:
    """Return a number of 16 digits, in hexadecimal, that stands for texts."""
    return hashlib.sha256("\0".join(parts).encode()).hexdigest()[:16]


def definitions(tree: ast.Module) -> list[tuple[int, int, str]]:
    """Return first and last line and full name of every function and class, outer ones first."""
    found: list[tuple[int, int, str]] = []

    def visit(node: ast.AST, outer: str) -> None:
        for child in ast.iter_child_nodes(node):
            if isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
                name = f"{outer}.{child.name}" if outer else child.name
                first = min([child.lineno, *(decorator.lineno for decorator in child.decorator_list)])
                found.append((first, child.end_lineno or first, name))
                visit(child, name)
            else:
                visit(child, outer)

    visit(tree, "")
    return found


def annotations(tree: ast.Module) -> list[tuple[tuple[int, int], tuple[int, int]]]:
    """Return beginning and end of every annotation: no program depends on them."""
    nodes = []
    for node in ast.walk(tree):
        if isinstance(node, ast.arg | ast.AnnAssign):
            nodes.append(node.annotation)
        elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            nodes.append(node.returns)
    return [
        ((node.lineno, node.col_offset), (node.end_lineno or 0, node.end_col_offset or 0))
        for node in nodes
        if node
    ]


def mutants_of(path: Path) -> Iterator[Mutant]:
    """Yield every mutant of a file, but those of annotations."""
    text = path.read_text()
    lines, tree = text.splitlines(), ast.parse(text)
    inside, skipped = definitions(tree), annotations(tree)
    nodes = list(ast_nodes(get_ast(text)))
    seen: Counter[tuple[str, str]] = Counter()
    made: Counter[tuple[str, int, int]] = Counter()
    orders: dict[tuple[str, int, int], int] = {}
    for name in sorted(operator_names()):
        kind = get_operator(name)
        if kind.arguments():
            continue
        operator, places = kind(), (place for node in nodes for place in kind().mutation_positions(node))
        for occurrence, ((line, column), _) in enumerate(places):
            # Columns of ast count bytes.
            at = (line, len(lines[line - 1][:column].encode()))
            if any(start <= at < end for start, end in skipped):
                continue
            definition = next((name for first, last, name in reversed(inside) if first <= line <= last), "")
            stripped = lines[line - 1].strip()
            indent = len(lines[line - 1]) - len(lines[line - 1].lstrip())
            what = "\0".join([definition, stripped, str(column - indent), type(operator).__module__])
            if (name, line, column) not in orders:
                # Lines of one text in one definition are told apart by their order.
                orders[name, line, column] = seen[what, name]
                seen[what, name] += 1
            index = made[name, line, column]
            made[name, line, column] += 1
            order = orders[name, line, column]
            yield Mutant(path, line, column, definition, name, occurrence, f"{what}\0{order}#{index}")


def sampled(mutants: list[Mutant], seed: str, count: int) -> list[Mutant]:
    """Return a sample: one mutant at each of so many sites, all drawn by the seed.

    A site with many mutants, such as an operator that eleven others can replace, is as likely as one with few.
    """
    sites: dict[str, list[Mutant]] = {}
    for mutant in mutants:
        sites.setdefault(mutant.site.rpartition("#")[0], []).append(mutant)
    drawn = []
    for site in sorted(sites, key=lambda site: fingerprint(seed, site)):
        for mutant in sorted(sites[site], key=lambda mutant: fingerprint(seed, mutant.name)):
            if mutant.is_one():
                drawn.append(mutant)
                break
        if len(drawn) == count:
            break
    return drawn
