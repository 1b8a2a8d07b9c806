"""Names in the package: each stands for one thing, and what a docstring names is there."""

import ast
import re
from collections import defaultdict
from functools import cache
from itertools import pairwise
from pathlib import Path

import pytest

import stickslip_sym

PACKAGE = Path(stickslip_sym.__file__).parent
PREPOSITIONS = frozenset(
    [
        "about",
        "above",
        "after",
        "against",
        "along",
        "around",
        "at",
        "before",
        "behind",
        "below",
        "beneath",
        "beside",
        "between",
        "beyond",
        "by",
        "down",
        "during",
        "for",
        "from",
        "in",
        "inside",
        "into",
        "like",
        "near",
        "of",
        "off",
        "on",
        "onto",
        "out",
        "outside",
        "over",
        "per",
        "since",
        "than",
        "through",
        "toward",
        "under",
        "until",
        "up",
        "upon",
        "via",
        "with",
        "within",
        "without",
    ]
)
"""The conversions as_ and to_ are not among them: they are verbs in NumPy and SymPy, asarray and to_dict."""
FOR_READERS = "certificates/checker.py"
"""Its text stands in the scripts that leave the package: it shares nothing with it, and its names are its own."""

SAME_FILES = {
    **dict.fromkeys(
        ["critical.py", "damping.py", "export.py", "fit.py", "laws.py", "simulate.py", "study.py", "tradeoff.py"],
        "a command, and what it calls",
    ),
    "comparison.py": "the views of the folder's results",
    "margins.py": "the views of the folder's results",
    "thresholds.py": "the scripts, and the views, of the folder's results",
}
SAME_FUNCTIONS = {
    "_damped_wave": "a rule for one family of terms, by polynomial weights or by the harmonic one",
    "_power": "a rule for one family of terms, by polynomial weights or by the harmonic one",
    "_rational": "a rule for one family of terms, by polynomial weights or by the harmonic one",
    "main": "the entry point, and what it runs once all is imported",
    "run": "a command of the file's name",
}
SAME_NUMBERS: dict[str, str] = {}


@cache
def trees():
    """The modules of the package by their paths in it, read."""
    files = sorted(path for path in PACKAGE.rglob("*.py") if "docs" not in path.parts)
    return {path.relative_to(PACKAGE).as_posix(): ast.parse(path.read_text()) for path in files}


def owners(kinds):
    """Return the modules that define each function, or class, of a module."""
    found = defaultdict(set)
    for path, tree in trees().items():
        for node in tree.body:
            if isinstance(node, kinds) and path != FOR_READERS:
                found[node.name].add(path)
    return found


def twins(found):
    """Return the names that stand in more than one place."""
    return {name: sorted(places) for name, places in found.items() if len(places) > 1}


def test_no_file_name_stands_twice():
    found = defaultdict(set)
    for path in trees():
        if not path.endswith("__init__.py"):
            found[Path(path).name].add(path)
    assert {name: places for name, places in twins(found).items() if name not in SAME_FILES} == {}


def test_no_class_name_stands_twice():
    assert twins(owners(ast.ClassDef)) == {}


def test_no_function_name_stands_twice_but_of_one_interface():
    twice = twins(owners(ast.FunctionDef))
    assert {name: places for name, places in twice.items() if name not in SAME_FUNCTIONS} == {}
    assert sorted(set(SAME_FUNCTIONS) - set(twice)) == []  # reasons for what is gone


def numbers():
    """Return the modules that define each constant whose value is a number, or some."""
    found = defaultdict(set)
    for path, tree in trees().items():
        for node in (node for node in tree.body if isinstance(node, ast.Assign)):
            try:
                value = ast.literal_eval(node.value)
            except ValueError:
                continue
            if all(type(one) in (int, float) for one in (value if isinstance(value, tuple) else (value,))):
                for name in (part.id for part in ast.walk(node.targets[0]) if isinstance(part, ast.Name)):
                    found[name].add(path)
    return found


def test_no_name_of_a_number_means_two_things():
    twice = twins(numbers())
    assert {name: places for name, places in twice.items() if name not in SAME_NUMBERS} == {}
    assert sorted(set(SAME_NUMBERS) - set(twice)) == []


def test_no_function_begins_with_a_preposition():
    names = [name for name in owners(ast.FunctionDef) if name.lstrip("_").split("_")[0] in PREPOSITIONS]
    assert names == []


# -- what docstrings name --------------------------------------------------------------------------

QUOTED = re.compile(r"(?<!`)`([A-Za-z_][\w.]*)(?:\([^`]*\))?`(?!`)")
"""A name in single backticks, perhaps as a call."""
ELSEWHERE = {
    "field": "the tactic of Coq",
    "one_threshold": "a chapter of the derivations",
    "uncertainties": "the library",
}


def modules():
    """The names of all modules and folders, from the package on, behind a dot."""
    names = {path.removesuffix(".py").replace("/", ".").removesuffix(".__init__") for path in trees()}
    return {f".stickslip_sym.{name}" for name in names}


@cache
def identifiers():
    """Whatever the code of the package names."""
    found = set()
    for node in (node for tree in trees().values() for node in ast.walk(tree)):
        for attribute in ("name", "id", "attr", "arg", "asname"):
            found.add(getattr(node, attribute, None))
    return found


@cache
def definitions():
    """Functions, classes and constants of modules."""
    found = set()
    for node in (node for tree in trees().values() for node in tree.body):
        targets = getattr(node, "targets", [getattr(node, "target", None)])
        found |= {getattr(node, "name", None), *(getattr(target, "id", None) for target in targets)}
    return found


def is_there(name, path):
    """Whether a name in a docstring is that of a module, of a file beside it, or of the code.

    The docstring of a folder names what its modules define, and no variable of some function.
    """
    if any(module.endswith(f".{name}") for module in modules()) or (PACKAGE / path).with_name(name).exists():
        return True
    *_, last = name.split(".")
    known = definitions() if path.endswith("__init__.py") and "." not in name else identifiers()
    return last in known or name in ELSEWHERE or last in dir(__builtins__) or last in __builtins__


def unknown_names(path, text):
    """Return what a docstring names that is not there."""
    return [name for name in QUOTED.findall(text) if not is_there(name, path)]


def docstrings():
    """Yield each docstring with the path of its module."""
    for path, tree in trees().items():
        for node in ast.walk(tree):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and (text := ast.get_docstring(node)):
                yield path, text


def test_what_docstrings_name_is_there():
    wrong = {path: names for path, text in docstrings() if (names := unknown_names(path, text))}
    assert wrong == {}
    assert unknown_names("formula/finding/__init__.py", "or in `harmonics`") == ["harmonics"]
    assert unknown_names("model/__init__.py", "`catalogue`, of `model.no_such_module`") == ["model.no_such_module"]


@pytest.mark.parametrize("folder", sorted(path.parent.name for path in PACKAGE.glob("*/__init__.py")))
def test_folders_import_what_their_docstrings_say(folder):
    """A docstring that says "Imports `core` and `output`" names all folders that modules of the folder import."""
    text = ast.get_docstring(trees()[f"{folder}/__init__.py"]).replace("\n", " ") + " "
    said = re.search(r"Imports (?!all|everything)(.*?)\. ", text)
    if said is None:
        return
    imported = set()
    for path, tree in trees().items():
        if path.startswith(f"{folder}/"):
            for node in ast.walk(tree):
                if isinstance(node, ast.ImportFrom) and node.module.startswith("stickslip_sym."):
                    imported.add(node.module.split(".")[1])
    assert imported - {folder, "certificates"} <= set(QUOTED.findall(said[1]))  # the writers are called by methods


def test_each_text_in_the_code_belongs_to_what_stands_before_it():
    """A string that is no value is a docstring, or stands behind the constant that it describes."""
    orphans = []
    for path, tree in trees().items():
        for block in (node.body for node in ast.walk(tree) if isinstance(getattr(node, "body", None), list)):
            for before, node in pairwise(block):
                is_text = isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant)
                if (
                    is_text
                    and isinstance(node.value.value, str)
                    and not isinstance(before, ast.Assign | ast.AnnAssign)
                ):
                    orphans.append(f"{path}:{node.lineno}")
    assert orphans == []
