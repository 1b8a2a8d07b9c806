"""What every printer prints of random formulas, read back by readers of their own, has the formula's value.

STICKSLIP_PRINTED sets how many formulas are drawn; the seeds are the numbers of the batches.
"""

import functools
import html
import os
import random
import re
import runpy
import shutil
import subprocess

import latex_reader
import mpmath
import numpy as np
import pytest
import sympy as sp
from random_formulas import NOTATION, Draws
from text_reader import read_text

from stickslip_sym import abbreviation, c_text, html_text, layout, octave_text, printing, python_text
from stickslip_sym.dialects import c99, octave, python
from stickslip_sym.errors import NoClosedForm
from stickslip_sym.notation import notation_of

COUNT = int(os.environ.get("STICKSLIP_PRINTED", "300"))
BATCH = 100  # formulas; one run of the compiler and of Octave for each
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


def inline(expr, names):
    return printing.latex(expr, names, inline=True)


def in_html(expr, names):
    shown = str(html_text.formula(printing.latex(expr, names)))
    return html.unescape(re.fullmatch(r"<span>\$(.*)\$</span>", shown, re.S)[1])


LATEX = {"display": printing.latex, "inline": inline, "HTML": in_html}


@batches
@pytest.mark.parametrize("kind", LATEX)
def test_latex_says_what_it_is_printed_of(kind, batch):
    with mpmath.workdps(DIGITS):
        for number, (expr, point, expected) in enumerate(draws(batch)):
            names = notation(expr, number)
            known = {names[symbol.name]: point[symbol] for symbol in expr.atoms(sp.Symbol)}
            shown = LATEX[kind](expr, names)
            assert agrees(latex_reader.read(shown, known), expected), f"{expr!r}\n{shown}"


def broken(expr, names):
    """The value of an equation in narrow lines, with the abbreviations after it."""
    shown = abbreviation.equation("c", expr, names)
    return re.findall(r"\\begin\{equation\*\}\n.*?\\end\{equation\*\}", shown, re.S)


@batches
def test_broken_and_abbreviated_equations_say_the_same(batch, monkeypatch):
    monkeypatch.setattr(layout, "LINE", NARROW)
    monkeypatch.setattr(abbreviation, "LINE", NARROW)
    with mpmath.workdps(DIGITS):
        for number, (expr, point, expected) in enumerate(draws(batch)):
            names = notation(expr, number)
            known = {names[symbol.name]: point[symbol] for symbol in expr.atoms(sp.Symbol)}
            shown, *definitions = broken(expr, names)
            for equation in [shown, *definitions]:
                latex_reader.rows(equation)
            for definition in definitions:
                left, right = latex_reader.sides(definition)
                assert left not in known, f"{left} has a meaning already in\n{shown}"
                known[left] = latex_reader.read(right, known)
            got = latex_reader.read(latex_reader.sides(shown)[1], known)
            assert agrees(got, expected), f"{expr!r}\n{shown}\n{definitions}"


@batches
def test_text_says_what_it_is_printed_of(batch):
    with mpmath.workdps(DIGITS):
        for expr, point, expected in draws(batch):
            shown = printing.text(expr)
            known = {symbol.name: value for symbol, value in point.items()}
            assert agrees(read_text(shown, known), expected), f"{expr!r}\n{shown}"


# -- code -------------------------------------------------------------------------------------------


def written(dialect, batch):
    """The formulas of a batch in one language: text, names and values of the arguments."""
    for expr, point, expected in draws(batch, plain=True):
        names = {symbol: dialect.name(symbol) for symbol in point}
        values = [float(value) for value in point.values()]
        yield expr, dialect.text(expr, names), list(names.values()), values, expected


def by_python(batch, folder):
    parts, given = [python_text.head("formulas", products=False)], list(written(python, batch))
    for number, (_, text, names, _, _) in enumerate(given):
        parts.append(f"\n\ndef f_{number}({', '.join(names)}):\n    return {text}\n")
    (folder / "formulas.py").write_text("".join(parts))
    module = runpy.run_path(str(folder / "formulas.py"))
    with np.errstate(all="ignore"):
        # Each formula at the point and, in the same array, at a place beside it: nothing may hang on a scalar.
        return [
            float(np.broadcast_to(module[f"f_{number}"](*(np.array([x, 1.01 * x]) for x in values)), 2)[0])
            for number, (_, _, _, values, _) in enumerate(given)
        ]


def by_c(batch, folder):
    parts, calls = [c_text.head("formulas", products=False), "#include <stdio.h>\n"], []
    for number, (_, text, names, values, _) in enumerate(written(c99, batch)):
        listed = ", ".join(f"double {name}" for name in names)
        parts.append(f"static double f_{number}({listed})\n{{\n    return {text};\n}}\n")
        calls.append(f'    printf("%.17g\\n", f_{number}({", ".join(map(repr, values))}));\n')
    (folder / "formulas.c").write_text("".join([*parts, "int main(void)\n{\n", *calls, "    return 0;\n}\n"]))
    program = str(folder / "formulas")
    flags = ["-std=c99", "-Wall", "-Wno-unused-parameter", "-Wno-parentheses", "-Werror", "-O0"]
    subprocess.run(["cc", *flags, "-o", program, str(folder / "formulas.c"), "-lm"], check=True, timeout=60)
    return numbers(subprocess.run([program], capture_output=True, text=True, check=True, timeout=60).stdout)


def by_octave(batch, folder):
    parts = [octave_text.head("formulas", products=False)]
    calls = []
    for number, (_, text, names, values, _) in enumerate(written(octave, batch)):
        parts.append(f"function value = f_{number}({', '.join(names)})\n    value = {text};\nend\n")
        calls.append(f'printf("%.17g\\n", f_{number}({", ".join(map(repr, values))}));\n')
    (folder / "formulas.m").write_text("".join([*parts, *calls]))
    command = ["octave-cli", "--norc", "--quiet", str(folder / "formulas.m")]
    return numbers(subprocess.run(command, capture_output=True, text=True, check=True, timeout=120).stdout)


def numbers(text):
    return [float(line) for line in text.split()]


LANGUAGES = {
    "Python": pytest.param(by_python, python),
    "C": pytest.param(
        by_c, c99, marks=pytest.mark.skipif(not shutil.which("cc"), reason="there is no C compiler")
    ),
    "Octave": pytest.param(
        by_octave, octave,
        marks=pytest.mark.skipif(not shutil.which("octave-cli"), reason="there is no octave; Debian has it"),
    ),
}  # fmt: skip


@batches
@pytest.mark.parametrize(("run", "dialect"), LANGUAGES.values(), ids=LANGUAGES)
def test_code_computes_what_it_is_written_of(run, dialect, batch, tmp_path):
    given = list(written(dialect, batch))
    for (expr, text, _, _, expected), got in zip(given, run(batch, tmp_path), strict=True):
        assert agrees(got, expected), f"{expr!r}\n{text}\n{got} is not {expected}"
