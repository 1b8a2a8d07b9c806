"""Which numeric constants of the package no test notices.

Run ``python tests/benchmarks/mutate_constants.py RESULTS.jsonl [FOLDER ...] [--seconds 15]``, with folders or
modules of the package as ``formula/evaluation``. A run that is cut goes on where it ended: what is known stands in
RESULTS.jsonl.

1. Each test is run once, and it is noted which functions that name a constant it enters, and how long it takes.
2. Each constant is changed, in the source as it is imported: by factors of 3 and 1/3, and a tolerance, which is
   less than a hundredth, by 10 and 1/10. The quickest of the tests that enter such a function are run, the
   file of tests that bears the module's name first, for some seconds of processor time in all, until one fails.
3. Printed are the constants, and for each change what noticed it: a test, time (three times as long), or nothing.

Tests whose results depend on others having run before, by caches, may enter fewer functions than they would alone.
"""

import argparse
import ast
import importlib.abc
import importlib.machinery
import importlib.util
import json
import os
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).parents[2]
PACKAGE = "stickslip_sym"
TOLERANCE = 0.01
"""What is smaller is changed by a larger factor: a tolerance is a power of ten."""
SLOWER = 3.0
"""Times as long as before, which a benchmark notices; under load a test may take twice as long."""
STARTING = 5.0
"""Seconds that importing the package and collecting tests may take."""


class Constant(NamedTuple):
    """A number in a module: the name that it is assigned to, and its place where that is a tuple."""

    module: str
    name: str
    place: int
    value: float

    @property
    def changed(self) -> list[float]:
        """Two other values; one that counts something remains whole, and not zero."""
        factor = 10 if abs(self.value) < TOLERANCE else 3
        larger, smaller = self.value * factor, self.value / factor
        if isinstance(self.value, int):
            smaller = self.value // factor or 1
        candidates = [larger, smaller] if self.value else [1, -1]
        return [other for other in candidates if other != self.value]


def literal(node: ast.expr | None) -> tuple[float, ...]:
    """Return the numbers of an assigned value that is a number or a tuple of numbers, computed or not."""
    if node is None:
        return ()
    try:
        value = eval(compile(ast.Expression(node), "", "eval"), {"__builtins__": {}}, {})
    except Exception:  # no constant: it needs names
        return ()
    return value if isinstance(value, tuple) else (value,)


def is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def assignments(tree: ast.Module) -> Iterator[tuple[str, ast.Assign | ast.AnnAssign]]:
    """Yield the assignments of a module, with the name."""
    for node in tree.body:
        if isinstance(node, ast.Assign):
            target = node.targets[0]
            yield ", ".join(one.id for one in ast.walk(target) if isinstance(one, ast.Name)), node
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            yield node.target.id, node


def constants_of(path: Path) -> list[Constant]:
    """Return the numeric constants of a module."""
    module = str(path.relative_to(ROOT))
    return [
        Constant(module, name, place, value)
        for name, node in assignments(ast.parse(path.read_text()))
        for place, value in enumerate(literal(node.value))
        if name and is_number(value)
    ]


# -- importing the package with changes --------------------------------------------------------------

REACHED: set[str] = set()
"""Functions entered so far, by module, name and line: each that names a constant adds itself here."""


class _Loader(importlib.machinery.SourceFileLoader):
    """Loads a module with a constant changed, or with functions that note when they are entered."""

    def __init__(self, name: str, path: str, change: tuple[Constant, float] | None, watched: set[str]) -> None:
        super().__init__(name, path)
        self._change, self._watched = change, watched

    def get_code(self, _name: str) -> Any:
        path = Path(self.path)
        tree, module = ast.parse(path.read_text()), str(path.relative_to(ROOT))
        if self._change is not None and self._change[0].module == module:
            _replace(tree, *self._change)
        for node in ast.walk(tree):
            if isinstance(node, ast.FunctionDef) and (key := _key(module, node)) in self._watched:
                start = 1 if ast.get_docstring(node, clean=False) is not None else 0
                note = ast.parse(f"__import__('mutate_constants').REACHED.add({key!r})").body[0]
                node.body.insert(start, note)
        ast.fix_missing_locations(tree)
        return compile(tree, self.path, "exec", dont_inherit=True)


class _Finder(importlib.abc.MetaPathFinder):
    def __init__(self, change: tuple[Constant, float] | None, watched: set[str]) -> None:
        self._change, self._watched = change, watched

    def find_spec(self, name: str, path: Any, target: Any = None) -> Any:
        if not name.startswith(PACKAGE):
            return None
        spec = importlib.machinery.PathFinder.find_spec(name, path)
        if spec is not None and spec.origin is not None and spec.origin.endswith(".py"):
            spec.loader = _Loader(name, spec.origin, self._change, self._watched)
        return spec


def _replace(tree: ast.Module, constant: Constant, value: float) -> None:
    """Put another value where a constant is assigned."""
    for name, node in assignments(tree):
        numbers = literal(node.value)
        if name == constant.name and len(numbers) > constant.place and numbers[constant.place] == constant.value:
            changed = [*numbers[: constant.place], value, *numbers[constant.place + 1 :]]
            single = len(numbers) == 1 and not isinstance(node.value, ast.Tuple)
            node.value = ast.Constant(changed[0]) if single else ast.Constant(tuple(changed))
            return
    raise LookupError(f"{constant} is not there")


def _key(module: str, node: ast.FunctionDef) -> str:
    return f"{module}:{node.lineno}:{node.name}"


class _Names(NamedTuple):
    """The names that a module's functions and assigned values use, and what it imports from other modules."""

    functions: list[tuple[str, set[str]]]
    assigned: list[tuple[str, set[str]]]
    imported: list[tuple[tuple[str, str], str]]


def _names_in(path: Path) -> _Names:
    tree, module = ast.parse(path.read_text()), str(path.relative_to(ROOT))
    functions = [(_key(module, node), _used(node)) for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
    assigned = [(name, _used(node.value)) for name, node in assignments(tree) if node.value is not None]
    imported = [
        ((node.module.replace(".", "/") + ".py", alias.name), alias.asname or alias.name)
        for node in tree.body
        if isinstance(node, ast.ImportFrom) and node.module is not None
        for alias in node.names
    ]
    return _Names(functions, assigned, imported)


def _used(node: ast.AST) -> set[str]:
    return {one.id for one in ast.walk(node) if isinstance(one, ast.Name)}


def users() -> dict[tuple[str, str], set[str]]:
    """Return the functions that name each constant, itself or through another name of a module."""
    names = {str(path.relative_to(ROOT)): _names_in(path) for path in modules()}
    found: dict[tuple[str, str], set[str]] = {}
    for constant in {(c.module, c.name) for path in modules() for c in constants_of(path)}:
        waiting = [(constant[0], name) for name in constant[1].split(", ")]
        aliases, keys = set(waiting), set[str]()
        while waiting:
            module, name = waiting.pop()
            keys |= {key for key, used in names[module].functions if name in used}
            more = {(module, other) for other, used in names[module].assigned if name in used}
            more |= {(other, local) for other, one in names.items() for origin, local in one.imported
                     if origin == (module, name)}  # fmt: skip
            waiting += more - aliases
            aliases |= more
        found[constant] = keys
    return found


def modules() -> list[Path]:
    return sorted((ROOT / PACKAGE).rglob("*.py"))


# -- running tests -----------------------------------------------------------------------------------


class Recorder:
    """A plugin of pytest that notes what each test enters, and its processor time."""

    def __init__(self) -> None:
        self.rows: list[dict[str, Any]] = []
        self.failed: str | None = None
        self._start = 0.0

    def pytest_runtest_logstart(self) -> None:
        REACHED.clear()
        self._start = time.process_time()

    def pytest_runtest_logreport(self, report: Any) -> None:
        if report.failed and self.failed is None:
            self.failed = report.nodeid

    def pytest_runtest_logfinish(self, nodeid: str) -> None:
        self.rows.append({"test": nodeid, "seconds": time.process_time() - self._start, "enters": sorted(REACHED)})


def in_child(tests: list[str], change: tuple[Constant, float] | None, watched: set[str], limit: float) -> Any:
    """Run tests in a process of their own, and return what was recorded; None where time was up."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(read)
        silent = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silent, 1)
        os.dup2(silent, 2)
        sys.modules["mutate_constants"] = sys.modules["__main__"]
        sys.meta_path.insert(0, _Finder(change, watched))
        import pytest

        recorder, status = Recorder(), 3
        try:
            options = ["-n", "0", "-q", "-p", "no:cacheprovider", *([] if watched else ["-x"])]
            status = int(pytest.main([*options, *tests], plugins=[recorder]))
        finally:
            result = {"status": status, "failed": recorder.failed, "rows": recorder.rows}
            _written(write, json.dumps(result).encode())
            os._exit(0)
    os.close(write)
    return _awaited(child, read, limit)


def _written(pipe: int, text: bytes) -> None:
    while text:
        text = text[os.write(pipe, text) :]


def _awaited(child: int, pipe: int, limit: float) -> Any:
    """Read what a process writes until it ends; it is stopped when its time is up."""
    os.set_blocking(pipe, False)
    parts, end = list[bytes](), time.monotonic() + limit
    while True:
        try:
            part = os.read(pipe, 1 << 16)
            if not part:
                break
            parts.append(part)
        except BlockingIOError:
            if time.monotonic() > end:
                os.kill(child, 9)
                os.waitpid(child, 0)
                os.close(pipe)
                return None
            time.sleep(0.02)
    os.waitpid(child, 0)
    os.close(pipe)
    return json.loads(b"".join(parts)) if parts else {"status": 3, "failed": "the run itself", "rows": []}


def main() -> None:
    """Go on with a campaign, and print what is known."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path)
    parser.add_argument("folders", nargs="*", default=[""])
    parser.add_argument("--seconds", type=float, default=15.0, help="of tests for each change")
    parser.add_argument(
        "--tests", nargs="*", help="whose names begin so, below tests; by default those of the folders"
    )
    parser.add_argument("--only", choices=["map", "table"], help="look which tests enter what, or print")
    options = parser.parse_args()
    lines = options.results.read_text().splitlines() if options.results.exists() else []
    known = [json.loads(line) for line in lines]
    if options.only != "table":
        with options.results.open("a") as file:
            _go_on(known, options, file)
    _print(known)


def _go_on(known: list[dict[str, Any]], options: Any, file: Any) -> None:
    def keep(row: dict[str, Any]) -> None:
        known.append(row)
        file.write(json.dumps(row) + "\n")
        file.flush()

    for name in ("numpy", "scipy.optimize", "sympy", "flint", "mpmath", "numba"):
        importlib.import_module(name)
    os.chdir(ROOT)
    named = users()
    watched = {key for keys in named.values() for key in keys}
    watched = {key for key in watched if "/kernel/" not in key}
    mapped = {row["file"] for row in known if "file" in row}
    for path in sorted((ROOT / "tests").rglob("test_*.py")):
        test_file = str(path.relative_to(ROOT))
        wanted = options.tests or [one.split("/")[0] for one in options.folders]
        if test_file in mapped or not any(test_file.startswith(f"tests/{one}") for one in wanted):
            continue
        found = in_child([test_file], None, watched, 900.0)
        keep({"file": test_file, "rows": found["rows"] if found else []})
    if options.only == "map":
        return
    tests = [row for one in known if "file" in one for row in one["rows"]]
    done = {(*row["constant"][:3], row["other"]) for row in known if "constant" in row}
    for path in modules():
        if not any(str(path.relative_to(ROOT / PACKAGE)).startswith(one) for one in options.folders):
            continue
        for constant in constants_of(path):
            chosen, seconds = _chosen(tests, constant, named[constant.module, constant.name], options.seconds)
            for other in constant.changed:
                if (*constant[:3], other) not in done:
                    keep(_outcome(constant, other, chosen, seconds))


def _function(key: str) -> str:
    """Return a function without its line, which other changes move."""
    module, _, name = key.split(":")
    return f"{module}:{name}"


def _chosen(
    tests: list[dict[str, Any]], constant: Constant, keys: set[str], seconds: float
) -> tuple[list[str], float]:
    """Return tests that enter a function which names a constant, and how long they take."""
    functions = {_function(key) for key in keys}
    entering = [row for row in tests if any(_function(key) in functions for key in row["enters"])]
    own = f"test_{Path(constant.module).stem}.py"
    entering.sort(key=lambda row: (own not in row["test"], row["seconds"]))
    chosen, total = list[str](), 0.0
    for row in entering:
        if total + row["seconds"] <= seconds:
            chosen.append(row["test"])
            total += row["seconds"]
    return chosen, total


def _outcome(constant: Constant, other: float, chosen: list[str], seconds: float) -> dict[str, Any]:
    """Run tests with a constant changed, and return what noticed it."""
    row: dict[str, Any] = {"constant": list(constant), "other": other, "tests": len(chosen), "by": None}
    if not chosen:
        row["by"] = "no test enters it in time"
        return row
    found = in_child(chosen, (constant, other), set(), STARTING + SLOWER * 3 * (seconds + STARTING))
    took = sum(one["seconds"] for one in found["rows"]) if found else float("inf")
    if found and found["status"] != 0:
        row["by"] = found["failed"] or "no test could be collected"
    elif took > SLOWER * (seconds + 1):
        row["by"] = "time"
    return row


def _print(known: list[dict[str, Any]]) -> None:
    rows = [row for row in known if "constant" in row]
    for row in rows:
        module, name, place, value = row["constant"]
        by = row["by"] or f"NOTHING ({row['tests']} tests)"
        print(f"{module.removeprefix(PACKAGE + '/')}  {name}[{place}]  {value:g} -> {row['other']:g}:  {by}")
    unnoticed = sum(row["by"] is None for row in rows)
    print(f"{len(rows)} changes, {unnoticed} noticed by nothing")


if __name__ == "__main__":
    main()
