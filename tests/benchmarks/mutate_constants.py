"""Which numeric constants of the package no test notices.

Run ``python tests/benchmarks/mutate_constants.py RESULTS.jsonl [FOLDER ...] [--seconds 6]``, with folders or
modules of the package as ``formula/evaluation``. A run that is cut goes on where it ended: what is known stands in
RESULTS.jsonl.

1. Each test is run once, and it is noted which functions that name a constant it enters, and how long it takes.
2. Each constant is changed: by factors of 3 and 1/3, and a tolerance, which is less than a hundredth, by 10 and
   1/10. Tests that enter such a function are run, for some seconds of processor time in all, until one fails: of
   each test one case before another case of any, those in the file that bears the module's name first, then the
   quickest. Then the benchmark of work is run, the answers that call the module's functions most. Each change has
   a process of its own, a copy of one that has the package imported and the tests collected; a constant that is
   needed on import, as a default or in a class, is changed in the source as it is imported.
3. Printed are the constants, and for each change what noticed it: a test, work, time (three times as long), or
   nothing. A change that nothing noticed is looked at again by a run with more ``--seconds``.

Tests whose results depend on others having run before, by caches, may enter fewer functions than they would alone.
A test that starts the package in a process of its own does not see a change. What numba compiles runs as plain
Python where one of its constants is changed.
"""

import argparse
import ast
import importlib.abc
import importlib.machinery
import json
import os
import resource
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

ROOT = Path(__file__).parents[2]
WORK = "tests/benchmarks/bench_work.py"
PACKAGE = "stickslip_sym"
TOLERANCE = 0.01
"""What is smaller is changed by a larger factor: a tolerance is a power of ten."""
SLOWER = 3.0
"""Times as long as before, which a benchmark notices; under load a test may take twice as long."""
STARTING = 5.0
"""Seconds that importing the package, collecting tests and filling caches may take."""
SECONDS_OF_WORK = 8.0
"""That the answers whose work is counted take for each change."""
SECONDS_TO_BEGIN = 0.4
SECONDS_A_CALL = 6e-6
"""Of an answer in plain Python, while its calls are counted."""
PLAIN_SECONDS = 120.0
"""Seconds of tests that are run once in plain Python, to know which are quick without compilation."""
COMPILED_AS = ("@compilable", "@inlined")
"""Decorators of what numba compiles, which can note nothing: the tests that enter what calls it are run."""


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


# -- which constant is used where --------------------------------------------------------------------


class _Module(NamedTuple):
    """The names that a module's functions and assigned values use, those that it needs on import, and imports."""

    functions: list[tuple[str, set[str]]]
    assigned: list[tuple[str, ast.expr, set[str]]]
    needed_on_import: set[str]
    imported: list[tuple[tuple[str, str], str]]
    compiles: bool


class Uses(NamedTuple):
    """Where a constant is used: functions, and the names of modules that hold it or what is computed from it."""

    functions: set[str]
    aliases: list[tuple[str, str]]
    needed_on_import: bool
    compiled: bool


def _key(module: str, node: ast.FunctionDef) -> str:
    return f"{module}:{node.lineno}:{node.name}"


def _used(*nodes: ast.AST | None) -> set[str]:
    return {one.id for node in nodes if node is not None for one in ast.walk(node) if isinstance(one, ast.Name)}


def _outside_functions(node: ast.AST) -> set[str]:
    """Return the names that are looked up as a module is imported, in what is not an assignment of its own."""
    if isinstance(node, ast.FunctionDef | ast.Lambda):
        decorators = node.decorator_list if isinstance(node, ast.FunctionDef) else []
        return _used(*decorators, *node.args.defaults, *node.args.kw_defaults)
    own = {node.id} if isinstance(node, ast.Name) else set[str]()
    return own.union(*(_outside_functions(child) for child in ast.iter_child_nodes(node)))


def _read(path: Path) -> _Module:
    text = path.read_text()
    tree, module = ast.parse(text), str(path.relative_to(ROOT))
    assigned = [
        (name, node.value, _used(node.value)) for name, node in assignments(tree) if node.value is not None
    ]
    plain = {id(node) for _, node in assignments(tree)}
    imported = [
        ((node.module.replace(".", "/") + ".py", alias.name), alias.asname or alias.name)
        for node in tree.body
        if isinstance(node, ast.ImportFrom) and node.module is not None
        for alias in node.names
    ]
    return _Module(
        functions=[
            (_key(module, node), _used(node)) for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)
        ],
        assigned=assigned,
        needed_on_import=set[str]().union(
            *(_outside_functions(node) for node in tree.body if id(node) not in plain)
        ),
        imported=imported,
        compiles=any(name in text for name in COMPILED_AS),
    )


def uses_of_constants() -> dict[tuple[str, str], Uses]:
    """Return where each constant is used, itself or through another name of a module."""
    read = {str(path.relative_to(ROOT)): _read(path) for path in modules()}
    takers = defaultdict[tuple[str, str], list[tuple[str, str]]](list)
    for module, one in read.items():
        for origin, local in one.imported:
            takers[origin].append((module, local))
    return {
        (constant.module, constant.name): _uses(constant, read, takers)
        for path in modules()
        for constant in constants_of(path)
    }


def _uses(constant: Constant, read: dict[str, _Module], takers: Any) -> Uses:
    aliases = [(constant.module, name) for name in constant.name.split(", ")]
    functions = set[str]()
    on_import = compiled = False
    for module, name in aliases:  # which grows
        one = read[module]
        functions |= {key for key, used in one.functions if name in used}
        on_import |= name in one.needed_on_import
        compiled |= one.compiles
        more = [(module, other) for other, _, used in one.assigned if name in used]
        aliases += [alias for alias in [*more, *takers[module, name]] if alias not in aliases]
    if compiled:
        compiled_modules = {name for name, one in read.items() if one.compiles}
        callers = [
            one for one in read.values() if any(origin in compiled_modules for (origin, _), _ in one.imported)
        ]
        functions |= {key for one in callers for key, _ in one.functions}
        functions = {key for key in functions if key.partition(":")[0] not in compiled_modules}
    return Uses(functions, aliases, on_import, compiled)


def modules() -> list[Path]:
    return sorted((ROOT / PACKAGE).rglob("*.py"))


# -- importing the package with changes --------------------------------------------------------------

REACHED: set[str] = set()
"""Functions entered so far, by module, line and name: each that names a constant adds itself here."""


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


def change_in_place(constant: Constant, value: float, uses: Uses) -> None:
    """Put another value where a constant stands in modules that are imported, and compute anew what follows."""
    tree = ast.parse((ROOT / constant.module).read_text())
    _replace(tree, constant, value)
    importlib.import_module(_name_of(constant.module))
    for module, name in uses.aliases:
        within = sys.modules.get(_name_of(module))
        if within is None:
            continue  # it will be imported with the change
        source = tree if module == constant.module else ast.parse((ROOT / module).read_text())
        own: list[ast.stmt] = [node for target, node in assignments(source) if name in target.split(", ")]
        if own:
            exec(compile(ast.fix_missing_locations(ast.Module(own, [])), module, "exec"), vars(within))
        else:
            _take_anew(within, module, name)


def _name_of(module: str) -> str:
    return module.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def _take_anew(within: Any, module: str, name: str) -> None:
    """Take from another module what a name was imported as."""
    for (origin, original), local in _read(ROOT / module).imported:
        if local == name and (source := sys.modules.get(_name_of(origin))) is not None:
            setattr(within, name, getattr(source, original))


# -- running tests -----------------------------------------------------------------------------------


def run(items: list[Any], *, stops: bool = True) -> list[dict[str, Any]]:
    """Run collected tests, until one fails where so wished; return for each what it enters, and its time."""
    from _pytest.runner import runtestprotocol

    rows = list[dict[str, Any]]()
    for item, after in zip(items, [*items[1:], None], strict=True):
        REACHED.clear()
        start = time.process_time()
        failed = any(report.failed for report in runtestprotocol(item, log=False, nextitem=after))
        seconds = time.process_time() - start
        rows.append({"test": item.nodeid, "seconds": seconds, "failed": failed, "enters": sorted(REACHED)})
        if failed and stops:
            break
    return rows


def in_child(task: Callable[[], Any], limit: float) -> Any:
    """Do something in a copy of this process, and return what it returns; None where its processor time was up."""
    read, write = os.pipe()
    child = os.fork()
    if child == 0:
        os.close(read)
        silent = os.open(os.devnull, os.O_WRONLY)
        os.dup2(silent, 1)
        os.dup2(silent, 2)
        spent = int(time.process_time() + limit) + 1
        resource.setrlimit(resource.RLIMIT_CPU, (spent, spent))
        text = b""
        try:
            text = json.dumps(task()).encode()
        finally:
            with os.fdopen(write, "wb") as pipe:
                pipe.write(text)
            os._exit(0)
    os.close(write)
    parts, end = list[bytes](), time.monotonic() + 20 * (limit + STARTING)
    os.set_blocking(read, False)
    while time.monotonic() < end:
        try:
            part = os.read(read, 1 << 16)
        except BlockingIOError:
            time.sleep(0.01)
            continue
        if not part:
            break
        parts.append(part)
    else:
        os.kill(child, 9)
    os.close(read)
    _, status = os.waitpid(child, 0)
    if os.WIFSIGNALED(status):
        return None
    return json.loads(b"".join(parts)) if parts else []


class Session:
    """A plugin of pytest that does something with the collected tests in place of running them."""

    def __init__(self, task: Callable[[list[Any]], Any]) -> None:
        self._task = task
        self.result: Any = None

    def pytest_runtestloop(self, session: Any) -> bool:
        self.result = self._task(session.items)
        return True


def with_collected(task: Callable[[list[Any]], Any], tests: list[str], watched: set[str] | None = None,
                   change: tuple[Constant, float] | None = None) -> Any:  # fmt: skip
    """Import the package, changed or watched, collect tests and do something with them."""
    sys.modules["mutate_constants"] = sys.modules["__main__"]
    if watched or change:
        sys.meta_path.insert(0, _Finder(change, watched or set()))
    import pytest

    session = Session(task)
    options = ["-n", "0", "-q", "-p", "no:cacheprovider", "-o", f"python_files=test_*.py {Path(WORK).name}"]
    pytest.main([*options, *tests], plugins=[session])
    return session.result


# -- a campaign --------------------------------------------------------------------------------------


class Campaign:
    """A file that keeps what is known, a row a line, and the seconds of tests for each change."""

    def __init__(self, path: Path, seconds: float) -> None:
        self._path = path
        self._seconds = seconds
        self._uses = uses_of_constants()

    def rows(self) -> list[dict[str, Any]]:
        """Return what is known."""
        return [json.loads(line) for line in self._path.read_text().splitlines()] if self._path.exists() else []

    def _keep(self, rows: list[dict[str, Any]]) -> None:
        with self._path.open("a") as file:
            file.writelines(json.dumps(row) + "\n" for row in rows)

    def look(self, *, plain: bool) -> None:
        """Run each new file of tests once, watched; in plain Python the quickest tests of what is compiled."""
        watched = {key for uses in self._uses.values() for key in uses.functions}
        within = self._look_at_plain if plain else self._look
        in_child(lambda: with_collected(within, [], watched=watched), FOREVER)

    def _look(self, items: list[Any]) -> None:
        of_files = defaultdict[Path, list[Any]](list)
        known = {row["test"].partition("::")[0] for row in self.rows() if "test" in row} | {WORK}
        for item in items:
            if item.nodeid.partition("::")[0] not in known:
                of_files[item.path].append(item)
        for of_file in of_files.values():
            rows = in_child(lambda of_file=of_file: run(of_file, stops=False), FOREVER)
            self._keep(rows)

    def _look_at_plain(self, items: list[Any]) -> None:
        functions = set[str]().union(*(uses.functions for uses in self._uses.values() if uses.compiled))
        entering = _one_of_each_first(_entering(self.rows(), functions), "test_slip.py")
        named = {item.nodeid: item for item in items}
        run_in_plain_python()
        left = PLAIN_SECONDS
        for row in entering:
            found = in_child(lambda row=row: run([named[row["test"]]]), 4.0) if row["test"] in named else None
            if found:
                self._keep([one | {"plain": True} for one in found])
                left -= found[0]["seconds"]
            if left < 0:
                break

    def change(self, folders: list[str]) -> None:
        """Change each constant of some folders, and run tests, then the benchmark of work."""
        wanted = [
            constant
            for path in modules()
            for constant in constants_of(path)
            if any(constant.module.removeprefix(PACKAGE + "/").startswith(folder) for folder in folders)
        ]
        on_import = [one for one in wanted if self._uses[one.module, one.name].needed_on_import]
        at_once = [one for one in wanted if one not in on_import]
        # What tests keep as they are collected would be missing in the work: it is counted in other processes.
        for choose, collected in ((self._tests, []), (self._work, [WORK])):
            task = partial(self._change_in_place, at_once, choose)
            in_child(partial(with_collected, task, collected), FOREVER)
            for constant in on_import:
                self._change_on_import(constant, choose)

    def _change_in_place(self, constants: list[Constant], choose: "_Choose", items: list[Any]) -> None:
        named = {item.nodeid: item for item in items}
        for constant in constants:
            uses = self._uses[constant.module, constant.name]

            def changed(tests: list[str], other: float, constant: Constant = constant, uses: Uses = uses) -> Any:
                if uses.compiled:
                    run_in_plain_python()
                change_in_place(constant, other, uses)
                return run([named[test] for test in tests if test in named])  # the others are gone since

            self._outcomes(constant, changed, choose)

    def _change_on_import(self, constant: Constant, choose: "_Choose") -> None:
        def changed(tests: list[str], other: float) -> Any:
            if self._uses[constant.module, constant.name].compiled:
                run_in_plain_python()
            return with_collected(run, tests, change=(constant, other))

        self._outcomes(constant, changed, choose)

    def _outcomes(self, constant: Constant, changed: Callable[[list[str], float], Any], choose: "_Choose") -> None:
        """Run tests with a constant changed each way, and keep what noticed it."""
        known = self.rows()
        tests, seconds, looked_at = choose(known, constant)
        for other in constant.changed:
            row = {"constant": list(constant), "other": other, "tests": len(tests), **looked_at}
            if tests and not any(_settles(old, row, *looked_at) for old in known):
                found = in_child(partial(changed, tests, other), SLOWER * (seconds + STARTING))
                self._keep([row | {"by": _noticed_by(found)}])

    def _tests(self, known: list[dict[str, Any]], constant: Constant) -> "_Chosen":
        """Return tests that enter a function which names a constant."""
        uses = self._uses[constant.module, constant.name]
        rows = [row for row in known if row.get("plain", False) == uses.compiled]
        chosen, total = list[str](), 0.0
        for row in _one_of_each_first(_entering(rows, uses.functions), f"test_{Path(constant.module).stem}.py"):
            if total + row["seconds"] <= self._seconds:
                chosen.append(row["test"])
                total += row["seconds"]
        return chosen, total, {"seconds": self._seconds}

    def _work(self, _: list[dict[str, Any]], constant: Constant) -> "_Chosen":
        """Return the answers whose work lies most in the modules that hold a constant, for the time they take."""
        recorded = json.loads((ROOT / WORK).with_name("work.json").read_text())
        holding = {module for module, _ in self._uses[constant.module, constant.name].aliases}
        of_modules = {module.removeprefix(PACKAGE + "/").removesuffix(".py") for module in holding}
        worth = dict[str, float]()
        seconds = dict[str, float]()
        for name, work in recorded.items():
            within = sum(count for module, count in work["calls"].items() if module in of_modules)
            if within:
                calls = sum(work["calls"].values())
                seconds[name] = SECONDS_TO_BEGIN + SECONDS_A_CALL * calls
                worth[name] = within / calls / seconds[name]
        chosen, left = list[str](), SECONDS_OF_WORK
        for name in sorted(worth, key=worth.__getitem__, reverse=True):
            if seconds[name] <= left:
                chosen.append(f"{WORK}::test_work[{name}]")
                left -= seconds[name]
        return chosen, SECONDS_OF_WORK, {"work": len(chosen)}


FOREVER = 1e6
_Chosen = tuple[list[str], float, dict[str, float]]
"""Names of tests, the seconds that they take, and how much was looked at."""
_Choose = Callable[[list[dict[str, Any]], Constant], _Chosen]


def run_in_plain_python() -> None:
    """Let nothing be compiled: machine code kept on disk has the constants of before."""
    from stickslip_sym.motion.compiled import compiled, is_compiling

    sys.modules["numba"] = None  # type: ignore[assignment]
    is_compiling.cache_clear()
    compiled.cache_clear()


def _entering(rows: list[dict[str, Any]], keys: set[str]) -> list[dict[str, Any]]:
    """Return the tests that pass and enter one of some functions, whose lines may have moved since."""
    functions = {_without_line(key) for key in keys}
    tests = (row for row in rows if "test" in row and not row["failed"])
    return [row for row in tests if any(_without_line(key) in functions for key in row["enters"])]


def _one_of_each_first(rows: list[dict[str, Any]], own: str) -> list[dict[str, Any]]:
    """Sort tests: of each its quickest case before another case of any, those of a module's own file first."""
    cases = Counter[str]()
    ranks = dict[str, int]()
    for row in sorted(rows, key=lambda row: row["seconds"]):
        function = row["test"].partition("[")[0]
        ranks[row["test"]] = cases[function]
        cases[function] += 1
    return sorted(rows, key=lambda row: (ranks[row["test"]], own not in row["test"], row["seconds"]))


def _without_line(key: str) -> str:
    module, _, name = key.split(":")
    return f"{module}:{name}"


def _settles(old: dict[str, Any], new: dict[str, Any], looked_at: str) -> bool:
    """Whether a change was looked at: noticed, or not noticed in as many seconds, or in as much work."""
    return _is_of(old, new) and (bool(old["by"]) or old.get(looked_at, 0) >= new[looked_at])


def _is_of(old: dict[str, Any], new: dict[str, Any]) -> bool:
    """Whether two rows are of one change."""
    return "constant" in old and (old["constant"], old["other"]) == (new["constant"], new["other"])


def _noticed_by(rows: list[dict[str, Any]] | None) -> str | None:
    if rows is None:
        return "time"
    if not rows:
        return "the import, or the collection of tests"
    return next((row["test"] for row in rows if row["failed"]), None)


def print_table(known: list[dict[str, Any]]) -> None:
    """Print what noticed each change; the last word on it counts."""
    rows = {(*row["constant"][:3], row["other"]): row for row in known if "constant" in row}
    for row in rows.values():
        module, name, place, value = row["constant"]
        by = row["by"] or f"NOTHING ({row['tests']} tests)"
        print(f"{module.removeprefix(PACKAGE + '/')}  {name}[{place}]  {value:g} -> {row['other']:g}:  {by}")
    unnoticed = sum(row["by"] is None for row in rows.values())
    print(f"{len(rows)} changes, {unnoticed} noticed by nothing")


def main() -> None:
    """Go on with a campaign, and print what is known."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path)
    parser.add_argument("folders", nargs="*", default=[""])
    parser.add_argument("--seconds", type=float, default=6.0, help="of tests for each change")
    parser.add_argument("--only", choices=["map", "table"], help="look which tests enter what, or print")
    options = parser.parse_intermixed_args()
    for name in ("numpy", "scipy.optimize", "sympy", "flint", "mpmath", "numba"):
        importlib.import_module(name)
    os.chdir(ROOT)
    campaign = Campaign(options.results.resolve(), options.seconds)
    if options.only != "table":
        campaign.look(plain=False)
        if not any(row.get("plain") for row in campaign.rows()):
            campaign.look(plain=True)
        if options.only != "map":
            campaign.change(options.folders)
    print_table(campaign.rows())


if __name__ == "__main__":
    main()
