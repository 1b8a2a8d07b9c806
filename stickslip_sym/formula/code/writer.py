"""Criteria as text of another language: the branches of a call, and no need of this package."""

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from string import Template

import sympy as sp
from sympy.printing.c import C99CodePrinter
from sympy.printing.codeprinter import CodePrinter, PrintMethodNotImplementedError
from sympy.printing.jscode import JavascriptCodePrinter
from sympy.printing.numpy import NumPyPrinter
from sympy.printing.octave import OctaveCodePrinter

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.balls import number_at
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import FUNCTIONS
from stickslip_sym.core.names import lookup
from stickslip_sym.core.remedies import Call, ParameterValues
from stickslip_sym.core.special import NumberPower
from stickslip_sym.core.status import Status
from stickslip_sym.formula.code.languages import LANGUAGES, Language
from stickslip_sym.formula.evaluation.branch_builder import compared
from stickslip_sym.formula.evaluation.branches import Branch, PanelTable
from stickslip_sym.formula.evaluation.term_function import TermFunction
from stickslip_sym.formula.evaluation.term_sum import TermSum
from stickslip_sym.formula.proof.proving import Verdict
from stickslip_sym.model.expression.canonical_form import canonical_form
from stickslip_sym.model.expression.pieces import drop_unreachable_kinks
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.model.terms import terms_of
from stickslip_sym.numerics.known import Unknown


def code(criteria: Mapping[str, tuple[TermSum, str]], language: str) -> str:
    """Return criteria by their names, each with words about it, as text of a language of the table.

    A language that is not there or lacks a function is refused, and so is a profile's shape without a value.
    """
    writer = _Writer(lookup("language", language, LANGUAGES))
    for name, (average, about) in criteria.items():
        writer.add(name, average, about)
    return writer.text()


def require_shapes(law: FrictionLaw) -> None:
    """Refuse a law whose profiles have shapes without values, for their branches cannot be written as code."""
    missing = sorted(str(symbol) for symbol in shapes_in_code(law) if str(symbol) not in law.values)
    if missing:
        raise InputError(
            f"{', '.join(missing)} of the law {law.name or law.text} has no value, and code is written for "
            "one value of an exponent; give it first: ",
            ParameterValues.of(missing[0]),
        )


def shapes_in_code(law: FrictionLaw) -> set[Expr]:
    """Return the parameters whose values code holds, as the branches are made for them."""
    return {symbol for term in law.terms for meaning in term.shapes.values() for symbol in meaning.free_symbols}


def _settled_terms(average: TermSum) -> tuple[list[TermFunction], set[Expr]]:
    """Return the terms of a criterion, and the parameters that are numbers in them.

    Where the values of parameters meet, as of Max(mu_k, mu_s - a v) at mu_s = mu_k, a scale is 0 or has no value:
    then the law is split again at these values.
    """
    law = average.law
    values = {symbol: law.values[name] for name, symbol in average.arguments.items() if name in law.values}
    meeting: set[Expr] = set()
    for function in average.functions:
        scales = [base for base, power in zip(function.bases, function.ratio, strict=True) if power]
        for part in (*scales, *function.term.shapes.values()):
            if part.free_symbols <= values.keys():
                value = number_at(part, values)
                if not value.is_finite or (value == 0 and part in scales):
                    meeting |= part.free_symbols
    if not meeting:
        return average.functions, set()
    expr = drop_unreachable_kinks(law.expr, values).xreplace({symbol: values[symbol] for symbol in meeting})
    return replace(average, terms=terms_of(canonical_form(expr))).functions, meeting


# -- expressions and numbers -------------------------------------------------------------------------


_ELEMENTARY = {"csch", "acosh", "atanh", "erfc", "Erfcx", "Langevin", "expm1", "log1p", "Abs", "sign"}
_SPECIAL = frozenset(row.name for row in FUNCTIONS.values() if not row.in_laws and row.name not in _ELEMENTARY)
"""Functions that a language has, if at all, in a library that a reader of code may not have."""


def expression_text(expr: Expr, names: Mapping[Expr, str], language: Language) -> str:
    """Return an expression in a language, by SymPy's printer; a function that the language has not is refused."""
    numbers = {node: sp.Float(float(node)) for node in expr.atoms(NumberPower)}
    functions = {type(node).__name__ for node in expr.atoms(sp.Function) - numbers.keys()}
    refusal = f"{str(expr)[:60]} cannot be written as code: {language.name} lacks "
    if special := functions & _SPECIAL:
        raise InputError(f"{refusal}{', '.join(sorted(special))}")
    try:
        return _PRINTERS[language.name](language, names).doprint(expr.xreplace(numbers))
    except PrintMethodNotImplementedError:
        raise InputError(f"{refusal}one of {', '.join(sorted(functions))}") from None


def _elementwise(text: str, language: Language) -> str:
    """Return an expression with the operators of a language for arrays."""
    if language.elementwise:
        return re.sub(r"(?<!\.)([*/^])", r".\1", text)
    return text


class _Written(CodePrinter):
    """What SymPy's printers have in common here: names for symbols, and numbers that are read back exactly."""

    def __init__(self, language: Language, names: Mapping[Expr, str]) -> None:
        super().__init__({"user_functions": dict(language.functions), "strict": True})
        self._names = names
        self._written_in = language

    def _print_Symbol(self, expr: Expr) -> str:
        return self._names[expr]

    def _print_Number(self, expr: Expr) -> str:
        return _number(float(expr), self._written_in)

    def _print_reciprocal(self, expr: Expr) -> str:
        """Print what SymPy would write by exponentials, which overflow."""
        return f"({self._print(1 / _RECIPROCALS[type(expr)](*expr.args))})"


for _kind in ("Integer", "Rational", "Half", "Float", "NumberSymbol", "Pi", "Exp1"):
    setattr(_Written, f"_print_{_kind}", _Written._print_Number)
_RECIPROCALS: dict[type[Expr], type[Expr]] = {sp.sech: sp.cosh, sp.coth: sp.tanh, sp.csch: sp.sinh}
for _function in _RECIPROCALS:
    setattr(_Written, f"_print_{_function.__name__}", _Written._print_reciprocal)

_PRINTERS: dict[str, type[_Written]] = {
    name: type("Printer", (_Written, printer), {})
    for name, printer in (
        ("python", NumPyPrinter),
        ("c", C99CodePrinter),
        ("octave", OctaveCodePrinter),
        ("javascript", JavascriptCodePrinter),
    )
}


def _number(value: float, language: Language) -> str:
    """Return a number, exact when it is read back."""
    if math.isnan(value):
        return language.nan
    if value == math.inf:
        return language.infinity
    return repr(float(value))


def _polynomial(coefficients: tuple[float, ...], language: Language) -> str:
    """Return a polynomial in z by Horner's rule."""
    *rest, last = (_number(c, language) for c in coefficients)
    text = f"{last}*z" if rest else f"{last} + 0.0*z"
    for i, coefficient in enumerate(reversed(rest)):
        if i == len(rest) - 1:
            text = f"{coefficient} + {text}"
        else:
            text = f"({coefficient} + {text})*z"
    return text


# -- criteria ----------------------------------------------------------------------------------------


class _Writer:
    """Fills the page of a language."""

    def __init__(self, language: Language) -> None:
        self.language = language
        self.names: list[str] = []
        self.about: list[str] = []
        self.functions: list[str] = []
        self.parts: list[str] = []  # tables, and terms

    def text(self) -> str:
        """Return the whole text."""
        page = self.language.page
        functions = self.functions
        tables = ""
        if any("in_table(" in part for part in self.parts):
            tables = page.get("tables", "")
        main = self.names[0]
        if len(self.names) > 1 and "several" in page:
            handles = "\n".join(f"  criteria.{name} = @{name};" for name in self.names)
            main = "damping_criteria"
            functions = [self._filled("several", handles=handles), *functions]
        body = [page["shared"], tables, *self.parts, *functions]
        if self.language.main_first:
            body = [*functions, *self.parts, page["shared"]]
        lines = "\n".join(self.about).splitlines()
        about = "\n".join(self.language.comment + line.strip() for line in lines)
        for text in self.language.never:
            about = about.replace(text, "")
        return "".join([self._filled("head", about=about, first=main), *body])

    def _filled(self, section: str, **fields: object) -> str:
        return Template(self.language.page[section]).substitute(fields)

    def _numbers(self, values: Iterable[float]) -> str:
        """Return numbers with commas, a few on each line."""
        texts = [_number(value, self.language) for value in values]
        return self.language.next_line.join(", ".join(texts[i : i + 4]) for i in range(0, len(texts), 4))

    def add(self, name: str, average: TermSum, about: str) -> None:
        """Write a criterion: its terms, and the function that adds them up."""
        law = average.law
        language = self.language
        require_shapes(law)
        values = law.values
        fixed = shapes_in_code(law)
        functions, settled = _settled_terms(average)
        fixed |= settled
        free = {key: symbol for key, symbol in average.arguments.items() if symbol not in fixed}
        texts = {symbol: language.argument.format(i) for i, symbol in enumerate(free.values(), language.first)}
        texts |= {symbol: _number(float(values[str(symbol)]), language) for symbol in fixed}
        point = [float(values[key]) if symbol in fixed else 1.0 for key, symbol in average.arguments.items()]
        reach = math.inf
        if law.v_max is not None:
            reach = float(law.v_max) / (1 if average.criterion.weight is None else 2)
        terms = {f"{name}_term_{i}": term for i, term in enumerate(functions)}
        verdicts = [self._add_term(key, term, point, texts, average) for key, term in terms.items()]
        arguments = [self._argument(key) for key in free]
        self.names.append(name)
        order = list(Status)
        constant = Verdict(Status.PROVED, "a constant law has no slope")
        worst = max(verdicts, key=lambda verdict: order.index(verdict.status), default=constant)
        self.about.append(f"{name}: {about}\nAs written {worst}")
        self.functions.append(
            self._filled(
                "function",
                name=name,
                arguments=", ".join(arguments),
                declared=", ".join(language.declared.format(argument) for argument in arguments),
                arrays=", ".join(f"const double *{argument}" for argument in arguments),
                elements=", ".join(f"{argument}[element]" for argument in arguments),
                total=" + ".join(f"{key}(a)" for key in terms)
                or f"0.0*{language.argument.format(language.first)}",
                flags="".join("1" if symbol.is_nonnegative else "0" for symbol in free.values()),
                fastest=_number(reach, language),
            )
        )

    def _argument(self, name: str) -> str:
        """Return an argument's name, with one more underscore after a word of the language."""
        if name.startswith(self.language.prefixes) or name.rstrip("_") in self.language.words:
            return f"{name}_"
        return re.sub("^_+", "x_", name)

    def _add_term(
        self, name: str, term: TermFunction, point: list[float], texts: Mapping[Expr, str], average: TermSum
    ) -> Verdict:
        """Write number * prod bases^amplitude * F(prod bases^ratio) and the tables of F, and compare them."""
        shapes = term.shape_values(point)
        branches = term.branches(shapes)
        law = average.law
        criterion = average.criterion
        if isinstance(branches, Unknown):
            raise InputError(
                f"the term {str(term.term.expr)[:60]} of the law {(law.name or law.text)[:60]} has no branches "
                "that could be written: ",
                *branches.reason,
                "; take its values by ",
                Call("stickslip_sym.slope_average", f"damping LAW --method {criterion.name}"),
            )
        language = self.language
        bases = [texts[symbols.V], texts[symbols.N], _number(term.size, language)]
        bases += [expression_text(sp.sympify(base), texts, language) for base in term.bases]
        ends = [*branches.starts[1:], math.inf]
        cases = [
            self._case(f"{name}_table_{i}", start, end, branch)
            for i, (start, end, branch) in enumerate(zip(branches.starts, ends, branches.branches, strict=True))
        ]
        self.parts.append(
            self._filled(
                "term",
                name=name,
                number=_number(term.number, language),
                count=len(bases),
                bases=", ".join(bases),
                amplitude=self._numbers((0.0, 1.0, 0.0, *term.amplitude)),
                ratio=self._numbers((1.0, 0.0, -1.0, *term.ratio)),
                cases="".join(cases).rstrip("\n"),
            )
        )
        return compared(branches, term.average.profile, term.average.criterion, term.exact_shapes(shapes))

    def _case(self, name: str, start: float, end: float, branch: Branch) -> str:
        """Return the statements that compute g and the power between two ratios; write the table, if it is one."""
        language = self.language
        if isinstance(branch, PanelTable):
            rows = language.next_row.join(self._numbers(row) for row in branch.rows)
            self.parts.append(self._filled("table", name=name, rows=rows))
            panels, width = branch.rows.shape
            z = "r"
            g = self._filled("lookup", name=name, panels=panels, width=width).strip()
            if branch.function is not None:
                g += f"*{expression_text(branch.function, {symbols.V: 'r'}, language)}"
        else:
            plain = {1.0: "r", 2.0: "r*r", -1.0: "1.0/r", -2.0: "1.0/(r*r)"}
            several = any(len(coefficients) > 1 for _, coefficients in branch.parts)
            power = language.power.format("r", _number(branch.variable, language))
            z = "r"
            if several:
                z = plain.get(branch.variable, power)
            g = " + ".join(
                f"({_polynomial(coefficients, language)})"
                + ("" if function is None else f"*({expression_text(function, {symbols.V: 'r'}, language)})")
                for function, coefficients in branch.parts
            )
        bounds = {"start": _number(start, language), "end": _number(end, language)}
        z = _elementwise(z, language)
        g = _elementwise(g, language)
        return self._filled("case", z=z, g=g, power=_number(branch.power, language), **bounds)
