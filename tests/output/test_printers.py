"""What every printer prints of random formulas, read back by readers of their own, has the formula's value.

STICKSLIP_PRINTED sets how many formulas are drawn; the seeds are the numbers of the batches.
"""

import functools
import html
import itertools
import os
import random
import re

import mpmath
import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.formula.code import writer
from stickslip_sym.formula.code.languages import LANGUAGES as WRITTEN
from stickslip_sym.output import abbreviation, latex_printer, layout, printing, text_printer
from stickslip_sym.output.notation import notation_of
from stickslip_sym.views import markup
from support import latex_reader
from support.exported_code import PROGRAMS, runs, values_of
from support.random_formulas import NOTATION, SEVERAL, Draws
from support.text_reader import read_text

COUNT = int(os.environ.get("STICKSLIP_PRINTED", "50"))
BATCH = min(COUNT, 100)  # formulas; one run of the compiler and of Octave for each
NARROW = 100.0  # points, so that small formulas are broken into lines and abbreviated
DIGITS = 30
CLOSE = mpmath.mpf("1e-9")  # a draw that changes by 1e-6 when its parts change by 1e-9 is not drawn
V, a, b = (sp.Symbol(name, positive=True) for name in ("V", "a", "b"))


@functools.cache
def draws(batch, plain=False):
    """Formulas with a point and a value each, and whether a user wants other letters."""
    rng = random.Random(f"{batch} {plain}")
    with mpmath.workdps(DIGITS):
        found = []
        while len(found) < BATCH:
            drawn = Draws(rng, plain=plain)
            found += [drawn.draw() for _ in range(5)]
    return found


batches = pytest.mark.parametrize("batch", range(max(COUNT // BATCH, 1)))


def agrees(got, expected):
    return isinstance(got, mpmath.mpf | float) and abs(got - expected) <= CLOSE * abs(expected)


def notation(expr, number):
    names = sorted(symbol.name for symbol in expr.atoms(sp.Symbol))
    return notation_of(names, {name: NOTATION[name] for name in names if name in NOTATION} if number % 2 else {})


def by_latex(shown, expr, point, names):
    """The value that a person reads."""
    return latex_reader.read(shown, {names[symbol.name]: point[symbol] for symbol in expr.atoms(sp.Symbol)})


def by_lines(shown, point, names):
    """The value of an equation that is broken into lines, with the definitions that follow it."""
    first, *definitions = re.findall(r"\\begin\{equation\*\}\n.*?\\end\{equation\*\}", shown, re.S)
    known = {names[symbol.name]: value for symbol, value in point.items() if symbol.name in names}
    for equation in [first, *definitions]:
        latex_reader.rows(equation)
    for definition in definitions:
        left, right = latex_reader.sides(definition)
        assert left not in known, f"{left} has a meaning already"
        known[left] = latex_reader.read(right, known)
    return latex_reader.read(latex_reader.sides(first)[1], known)


def by_text(shown, point):
    return read_text(shown, {symbol.name: value for symbol, value in point.items()})


@batches
def test_latex_and_text_have_the_formulas_value(batch, monkeypatch):
    monkeypatch.setattr(layout, "LINE", NARROW)
    monkeypatch.setattr(abbreviation, "LINE", NARROW)
    with mpmath.workdps(DIGITS):
        for number, (expr, point, expected) in enumerate(draws(batch)):
            names = notation(expr, number)
            for inline in (False, True):
                shown = printing.latex(expr, names, inline=inline)
                assert agrees(by_latex(shown, expr, point, names), expected), f"{expr!r}\n{shown}"
                too_long = f"<i>a formula of {len(shown)} characters of LaTeX</i>"
                assert html.unescape(markup.inline_formula(shown)) in (f"<span>${shown}$</span>", too_long)
            shown = abbreviation.displayed_equation("c", expr, names)
            assert agrees(by_lines(shown, point, names), expected), f"{expr!r}\n{shown}"
            shown = printing.text(expr)
            assert agrees(by_text(shown, point), expected), f"{expr!r}\n{shown}"


@pytest.mark.parametrize("module", [latex_printer, text_printer])
def test_a_printer_that_drops_brackets_is_caught(module, monkeypatch):
    """The negative control: without the brackets of sums and quotients many formulas have another value."""
    if module is latex_printer:
        monkeypatch.setattr(latex_printer, "held", lambda latex, least: latex)
    else:
        monkeypatch.setattr(text_printer._Text, "parenthesize", lambda self, item, *_, **__: self._print(item))
    others = refused = 0
    formulas = itertools.chain.from_iterable(map(draws, range(200 // BATCH)))
    with mpmath.workdps(DIGITS):
        for number, (expr, point, expected) in enumerate(formulas):
            names = notation(expr, number)
            if expr.has(*SEVERAL, sp.hyper) or any(not power.exp.is_number for power in expr.atoms(sp.Pow)):
                continue  # misread, they would be towers of powers, or sums without an end
            try:
                if module is latex_printer:
                    got = by_latex(printing.latex(expr, names, inline=True), expr, point, names)
                else:
                    got = by_text(printing.text(expr), point)
            except (AssertionError, TypeError):  # a complex number has no order
                refused += 1
            else:
                others += not agrees(got, expected)
    assert others >= 5
    assert refused >= (5 if module is latex_printer else 0)


@pytest.mark.parametrize(
    ("latex", "value"),
    [
        (r"{}_{1}F_{0}(-a; ; b)", 4), (r"{}_{0}F_{0}(; ; 0)", 1), (r"{}_{0}F_{1}(; a; 0)", 1),
        (r"\begin{cases} a & \text{for}\: a < b \\b & \text{for}\: (-a)^{a/b} < a \\3 & \text{otherwise} "
         r"\end{cases}", 2),
        (r"\begin{cases} a & \text{for}\: b < a \\b^{\begin{cases} V & \text{for}\: b < a \\2 & \text{otherwise} "
         r"\end{cases}} & \text{otherwise} \end{cases}", 9),
    ],
)  # fmt: skip
def test_reader_reads_empty_groups_and_nested_cases(latex, value):
    known = {"a": mpmath.mpf(2), "b": mpmath.mpf(3), "V": mpmath.mpf(5)}
    assert mpmath.almosteq(latex_reader.read(latex, known), value)


@pytest.mark.parametrize(
    "latex",
    [
        r"{}_{1}F_{0}(; a; b)", r"\ln(a; b)",
        r"\begin{cases} a & \text{for}\: (-a)^{1/b} < a \\V & \text{otherwise} \end{cases}", "a/b V", "a/b/V",
        r"2 3^{V}", r"2 \frac{1}{3}", r"\ln(V)^{2}", r"V^{a}^{b}", r"\tanh^{-1}(V)", "a + - b",
        r"\begin{cases} a & \text{for}\: V < b \\b & \text{otherwise} \end{cases} + 1", r"a \times + b",
        r"\int_{0}^{a} V \,\mathrm{d}V/2", r"\int_{0}^{a} V \,\mathrm{d}V b", r"\sqrt{V}^{2}", r"{a + b} V",
    ],
)  # fmt: skip
def test_reader_refuses_what_has_two_readings(latex):
    with pytest.raises(AssertionError):
        latex_reader.read(latex, {"a": mpmath.mpf(2), "b": mpmath.mpf(3), "V": mpmath.mpf(5)})


# -- code -------------------------------------------------------------------------------------------

PAGE, JAVASCRIPT = WRITTEN["python"].page, WRITTEN["javascript"].page
FUNCTIONS = {
    "python": (PAGE["head"] + PAGE["shared"] + "\n\n", "def {name}({names}):\n    return {text}\n"),
    "c": ("#include <math.h>\n", "double {name}({typed})\n{{\n    return {text};\n}}\n"),
    "javascript": (
        JAVASCRIPT["head"] + JAVASCRIPT["shared"],
        "function {name}({names}) {{\n  return {text};\n}}\n",
    ),
    "octave": ("1;\n", "function value = {name}({names})\n    value = {text};\nend\n"),
}
"""What stands before the functions of a file, and what one looks like."""
ALLOWED = ("-Wno-unused-parameter", "-Wno-parentheses")


def written(name, batch):
    """The formulas of a batch in one language: formula, text, arguments, their values, and its value."""
    for expr, point, expected in draws(batch, plain=True):
        if not expr.has(sp.Piecewise, sp.sign):  # pieces are branches of an average, or shapes that have values
            names = {symbol: f"x{i}" for i, symbol in enumerate(point)}
            values = [float(value) for value in point.values()]
            yield expr, writer.expression_text(expr, names, WRITTEN[name]), names.values(), values, expected


def computed(name, batch, folder):
    """Each formula of a batch with its text, the value that a program gives, and its own.

    Python gets it at the point and, in the same array, at a place beside it: nothing may hang on a scalar.
    """
    head, function = FUNCTIONS[name]
    given, functions, calls = list(written(name, batch)), [], []
    for i, (_, text, names, values, _) in enumerate(given):
        typed = ", ".join(f"double {name}" for name in names)
        functions.append(function.format(name=f"f_{i}", names=", ".join(names), typed=typed, text=text))
        calls.append((f"f_{i}", [np.array([x, 1.01 * x]) for x in values] if name == "python" else values))
    with np.errstate(all="ignore"):
        values = values_of(name, head + "".join(functions), calls, folder, ALLOWED)
    return [
        (expr, text, float(np.ravel(got)[0]), expected)
        for (expr, text, *_, expected), got in zip(given, values, strict=True)
    ]


@batches
@pytest.mark.parametrize("name", PROGRAMS)
def test_code_computes_what_it_is_written_of(name, batch, tmp_path):
    if not runs(name):
        pytest.skip(f"there is no {PROGRAMS[name]} on this machine; Debian has it")
    for expr, text, got, expected in computed(name, batch, tmp_path):
        assert agrees(got, expected), f"{expr!r}\n{text}\n{got} is not {expected}"


def test_code_that_drops_brackets_is_caught(monkeypatch, tmp_path):
    bare = lambda self, expr, *level, **how: str(self._print(expr))  # noqa: E731
    monkeypatch.setattr(writer._PRINTERS["python"], "parenthesize", bare)
    assert sum(not agrees(got, expected) for *_, got, expected in computed("python", 0, tmp_path)) >= 10


@pytest.mark.parametrize("name", ["python", "c", "octave", "javascript"])
@pytest.mark.parametrize(
    "function", [sp.besseli(1, V), sp.polylog(2, -V), sp.erfi(V), sp.gamma(V), sp.elliptic_e(V)]
)
def test_functions_that_no_language_has_are_refused(function, name):
    with pytest.raises(ss.InputError, match=f"cannot be written as code: {name} lacks"):
        writer.expression_text(a + 2 * function / b, {V: "V", a: "a", b: "b"}, WRITTEN[name])


@pytest.mark.parametrize(("number", "written"), [("1/50", "1/50"), ("1/125", "0.008"), ("21/200", "0.105")])
def test_a_fraction_that_is_read_at_a_glance_is_no_decimal(number, written):
    """Of a denominator of two digits."""
    assert printing.text(sp.Rational(number)) == written
