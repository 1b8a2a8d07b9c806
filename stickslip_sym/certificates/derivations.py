"""Derivations as scripts in plain SymPy: each step with its words, its two sides, and the theorem that it takes.

What is printed is what was proved: the sides of each step, and the data of its theorem.
"""

import json
import re
from collections.abc import Iterator, Sequence
from pathlib import Path
from textwrap import fill

import sympy as sp
from sympy.core.function import AppliedUndef

from stickslip_sym.certificates.python_printer import WIDTH, assignment, imports, python_code, script_line
from stickslip_sym.certificates.script import SafeNames
from stickslip_sym.core.aliases import Expr, UndefinedFunction
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.remedies import Call
from stickslip_sym.core.status import Status
from stickslip_sym.formula.derivation import Derivation, Step
from stickslip_sym.formula.proof.theorems import ChangeOfVariable, LinearSolution

_PAGE = Path(__file__).with_suffix(".txt")


def certificate_of_derivation(derivation: Derivation) -> str:
    """Return a script that proves the steps of a derivation one after another, and needs SymPy only.

    Raises `InputError` for a derivation that is not proved, or takes a theorem that a script has no rule for.
    """
    if derivation.status is not Status.PROVED:
        raise InputError(
            f"{derivation.title} is {derivation.status.value}, and a certificate is for what is PROVED; its steps "
            "say what is open: ",
            Call("print(derivation.text())", "derive LAW --steps"),
        )
    for number, step in enumerate(derivation.steps, 1):
        if step.by is not None and not isinstance(step.by, ChangeOfVariable | LinearSolution):
            raise InputError(f"a certificate has no rule for {type(step.by).__name__}, which step {number} takes")
    sides = [side for step in derivation.steps for side in (_left(step), step.statement.rhs)]
    functions = sorted({type(node) for side in sides for node in side.atoms(AppliedUndef)}, key=str)
    page = _PAGE.read_text(encoding="utf-8").strip()
    safe = SafeNames(
        " ".join(["sp left split vanishes solution check NotProved", *map(str, functions)]), r"right_\d+"
    )
    images = [step.by.image for step in derivation.steps if isinstance(step.by, ChangeOfVariable)]
    symbols = sorted(set().union(*(side.atoms(sp.Symbol) for side in [*sides, *images])), key=str)
    names: dict[Expr, str] = {x: safe.new(x.name) for x in symbols}
    body = f"{page}\n\n\n" + "\n".join(_script_lines(derivation, functions, names))
    title = fill(f"A proof, step by step: {derivation.title}.", WIDTH - 10)
    words = "Nothing but SymPy 1.13 or later is needed. NotProved names the step that fails, under python -O too."
    return f'"""{title}\n\n{words}\n"""\n\n{imports(body).lstrip()}\n\n{body}\n'


def _left(step: Step) -> Expr:
    return step.statement.lhs if step.lhs is None else step.lhs


def _script_lines(
    derivation: Derivation, functions: Sequence[UndefinedFunction], names: dict[Expr, str]
) -> Iterator[str]:
    kinds: dict[str, list[str]] = {}
    for x, name in names.items():
        kind = next((kind for kind in ("positive", "nonnegative", "real") if getattr(x, f"is_{kind}")), "complex")
        kinds.setdefault(kind, []).append(name)
    for kind, group in kinds.items():
        maker = "sp.symbols" if len(group) > 1 else "Symbol"
        yield f'{", ".join(group)} = {maker}("{" ".join(group)}", {kind}=True)'
    for function in functions:
        yield f'{function} = sp.Function("{function}", real=True)  # any function'
    solved = None
    rights = dict[str, str]()  # right sides, and their names

    def text(expr: Expr) -> str:
        """Return an expression in code, earlier right sides in it by their names."""
        written = python_code(expr, names)
        for right, name in rights.items():
            written = re.sub(rf"(?<![^(\[ ])(?<![-+*/] ){re.escape(right)}(?=[,)\]]|$)", name, written)
        return written

    for number, step in enumerate(derivation.steps, 1):
        yield ""
        yield from (
            f"# {text}" for text in fill(f"{number}. {step.operation}: {step.reason}", WIDTH - 2).split("\n")
        )
        message = json.dumps(" ".join([f"step {number}", *([step.label] if step.label else [])]))
        yield assignment("left", text(_left(step)))
        if isinstance(step.statement, sp.Gt):
            yield f"check(sp.factor(left).is_positive, {message})"
            continue
        by = step.by
        if isinstance(by, ChangeOfVariable):
            old, new, image = (python_code(part, names) for part in (by.old, by.new, by.image))
            yield f"left = left.transform({old}, ({image}, {new}))  # {old} = {image}"
        elif isinstance(by, LinearSolution):
            unknowns = ", ".join(names[x] for x in by.unknowns)
            if by is not solved:
                equations = ", ".join(map(text, by.equations))
                yield script_line(f"(solution,) = sp.linsolve([{equations}], [{unknowns}])")
            solved = by
            yield f"left = left.subs(dict(zip([{unknowns}], solution, strict=True)), simultaneous=True)"
        yield assignment(right := f"right_{number}", text(step.statement.rhs))
        yield f"check(vanishes(left - {right}), {message})"
        rights[python_code(step.statement.rhs, names)] = right
    yield ""
    yield script_line(f"print({json.dumps(f'proved: {derivation.title}')})")
