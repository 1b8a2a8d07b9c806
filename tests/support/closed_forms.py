"""The closed forms of the catalogue, and their formulas in a document read back."""

from functools import cache

import mpmath
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.core.special import Lerch
from stickslip_sym.output.notation import latex_name
from support import latex_reader

LAWS = list(ss.laws.catalogue)
NO_LEAST_SQUARES = {"andersson"}
NO_HARMONIC = {"stribeck", "stribeck_viscous", "tanh", "sech", "andersson", "brown_mcphee", "simscape"}
WITHOUT = {"least_squares": NO_LEAST_SQUARES, "harmonic": NO_HARMONIC}


@cache
def form_of(name, criterion):
    """Derive a form once for all tests; SymPy's integrator is left out, the rules must do."""
    return ss.derive(ss.laws.catalogue[name], criterion, search=False)


def with_forms(criterion):
    return [name for name in LAWS if name not in WITHOUT[criterion]]


FORMS = [(name, criterion) for criterion in WITHOUT for name in with_forms(criterion)]
"""Each law and criterion with a closed form."""


def point_of(form, number):
    """An operating point near the typical one, and the same by the LaTeX of its symbols."""
    values = {"V": "0.31", "N": "2.5"} | {p.name: p.typical for p in form.law.parameters.values()}
    exact = {name: sp.Rational(value) * sp.Rational(37 + number, 36) for name, value in values.items()}
    return exact, {latex_name(name): mpmath.mpf(int(x.p)) / int(x.q) for name, x in exact.items()}


def agrees(form, tex):
    """Whether the formula of a document, and the exact text beside it, have the values of the form."""
    names = {symbol.name: symbol for symbol in form.arguments.values()} | {"Lerch": Lerch}
    label = f"eq:{form.law.name}-{form.criterion.name}"
    (found,) = [block for block in latex_reader.equations(tex) if block[0] == label]
    _, exact, shown, definitions = found
    if sp.sympify(exact, locals=names) != form.expr:
        with mpmath.workdps(30):
            point, _ = point_of(form, 0)
            values = {form.arguments[name]: value for name, value in point.items()}
            if abs(sp.N((sp.sympify(exact, locals=names) - form.expr).subs(values), 20)) > 1e-15:
                return False
    for number in range(2):
        with mpmath.workdps(50):
            point, by_latex = point_of(form, number)
            waiting = [latex_reader.sides(text) for text in definitions]
            while waiting:  # what stands in another definition comes first
                for left, right in list(waiting):
                    if not any(other in right for other, _ in waiting if other != left):
                        by_latex[left] = latex_reader.read(right, by_latex)
                        waiting.remove((left, right))
            left, right = latex_reader.sides(shown)
            assert left == "c"
            got = latex_reader.read(right, by_latex)
            expected = form.evaluate(20, **point)
            if not abs(got - expected) <= mpmath.mpf("1e-18") * max(abs(expected), mpmath.mpf("1e-300")):
                return False
    return True
