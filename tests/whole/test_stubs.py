"""What type checkers are told of SymPy and mpmath, in `.ci/stubs`, is there, and takes those arguments."""

import ast
import importlib
import inspect
from pathlib import Path

import mpmath
import pytest
import sympy

STUBS = Path(__file__).parents[2] / ".ci" / "stubs"
BY_OTHER_WAYS = {"__iter__", "__getattr__"}  # by `__getitem__`, and each name by itself


def declared(body):
    """Return what a module or a class is said to have, without names of the stub's own."""
    named = [node for node in body if isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AnnAssign)]
    found = [(node.target.id if isinstance(node, ast.AnnAssign) else node.name, node) for node in named]
    public = [(name, node) for name, node in found if not name.startswith("_") or name.endswith("_")]
    return [(name, node) for name, node in public if name not in BY_OTHER_WAYS]


def kinds_of(kind):
    """Return a class and those below it, which have what a flag such as `is_Pow` tells."""
    return [kind, *(lower for each in kind.__subclasses__() for lower in kinds_of(each))]


def arguments_are_taken(function, node):
    """Whether a function takes what has a default in the stub, by these names; True where it does not say."""
    try:
        taken = inspect.signature(function).parameters.values()
    except ValueError:
        return True
    named = node.args.args[len(node.args.args) - len(node.args.defaults) :] + node.args.kwonlyargs
    any_name = any(one.kind is one.VAR_KEYWORD for one in taken)
    return any_name or {argument.arg for argument in named} <= {one.name for one in taken}


@pytest.mark.parametrize("file", sorted(STUBS.rglob("*.pyi")), ids=lambda file: str(file.relative_to(STUBS)))
def test_what_a_stub_declares_is_there(file):
    parts = file.relative_to(STUBS).with_suffix("").parts
    module = importlib.import_module(".".join(part for part in parts if part != "__init__"))
    names = declared(ast.parse(file.read_text(encoding="utf-8")).body)
    for name, node in names:
        if isinstance(node, ast.FunctionDef):
            assert arguments_are_taken(getattr(module, name), node), name
        if not isinstance(node, ast.ClassDef):
            assert hasattr(module, name), name
            continue
        kind = getattr(module, name)
        holders = [mpmath.mp] if kind is mpmath.MPContext else kinds_of(kind)
        for member, method in declared(node.body):
            having = [holder for holder in holders if hasattr(holder, member)]
            assert having, f"{name}.{member}"
            if isinstance(method, ast.FunctionDef) and inspect.isfunction(getattr(having[0], member)):
                assert arguments_are_taken(getattr(having[0], member), method), f"{name}.{member}"


def test_a_stub_of_what_is_not_there_is_noticed():
    """The checks of this file can fail."""
    assert arguments_are_taken(sympy.diff, ast.parse("def diff(f, *symbols): ...").body[0])
    assert not arguments_are_taken(sympy.denom, ast.parse("def denom(expr, nonsense=1): ...").body[0])
    assert not any(hasattr(kind, "nonsense") for kind in kinds_of(sympy.Expr))
    assert any(hasattr(kind, "lts") for kind in kinds_of(sympy.logic.boolalg.Boolean))
