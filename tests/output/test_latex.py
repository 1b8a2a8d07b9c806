"""LaTeX as a person writes it, and read back by a parser that shares nothing with the printer."""

import re
from pathlib import Path
from string import ascii_letters

import matplotlib
import mpmath
import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym import symbols
from stickslip_sym.output import latex_printer, layout, printing, text_printer
from stickslip_sym.output.notation import latex_name, notation_of
from support import latex_reader
from support.closed_forms import agrees, form_of
from support.sweeps import sample

V, N, v = symbols.V, symbols.N, symbols.v
a, b, mu_s, mu_m, alpha = (sp.Symbol(name, positive=True) for name in ("a", "b", "mu_s", "mu_m", "alpha"))


@pytest.mark.parametrize(
    ("name", "latex"),
    [
        ("mu_s", r"\mu_{\mathrm{s}}"), ("v_0", "v_{0}"), ("a1", "a_{1}"), ("alpha", r"\alpha"),
        ("lamda", r"\lambda"),
        ("beta_x_1", r"\beta_{\mathrm{x},1}"), ("drop", r"\mathit{drop}"), ("D", "D"),
        ("Alpha", r"\mathit{Alpha}"),
        ("mu_static", r"\mu_{\mathrm{static}}"),
    ],
)  # fmt: skip
def test_names(name, latex):
    assert latex_name(name) == latex


@pytest.mark.parametrize(
    ("expr", "latex"),
    [
        (sp.exp(-alpha * V), r"\mathrm{e}^{-\alpha V}"),
        (sp.exp(-(V / a) ** b), r"\exp\bigl[-(V/a)^{b}\bigr]"),
        (V * alpha * N / 2, r"\frac{N \alpha V}{2}"),
        ((a - b) / (1 + v / a), r"\frac{a - b}{1 + v/a}"),
        (sp.besseli(1, alpha * V) / V, r"\frac{I_{1}(\alpha V)}{V}"),
        (sp.log(1 + V / a), r"\ln(1 + V/a)"),
        (N * (a - b) * (1 + V + V**2) / V, r"\frac{N (a - b)}{V} (V^{2} + V + 1)"),
        (sp.tanh(V) ** 2, r"\tanh^{2}(V)"),
        (-sp.Rational(5, 2), r"-\frac{5}{2}"),
        (v / sp.Rational("0.0788") - sp.Rational("0.01230"), r"\frac{v}{0.0788} - 0.0123"),
        (sp.Rational(*(0.1234).as_integer_ratio()) * v, "0.1234 v"),
        (sp.Integral(sp.sin(v), (v, 0, 2 * V)), r"\int_{0}^{2 V} \sin(v) \,\mathrm{d}v"),
        (sp.Eq(a, b, evaluate=False), "a = b"),
        # each of these was once printed as something else
        (sp.exp((V + a) / b), r"\exp\bigl[(V + a)/b\bigr]"),
        (sp.erf((2 * V - a) / b), r"\operatorname{erf}\bigl[(2 V - a)/b\bigr]"),
        (V ** ((a + 1) / b), r"V^{(1 + a)/b}"),
        (2 * 3**V, r"2 \cdot 3^{V}"),
        (sp.Mul(-1, a - b, evaluate=False), "-(a - b)"),
        (sp.Catalan * sp.Symbol("G"), r"\operatorname{Catalan} G"),
        (sp.exp(V) * sp.Symbol("e"), r"e \exp(V)"),
        (sp.Symbol("a1") - sp.Symbol("a_1"), r"a_{1} - \mathit{a\_1}"),
        (sp.Symbol("u") - 2 * sp.Dummy("u"), r"u - 2 \mathit{u\_}"),
        (sp.Derivative(2 * a * V, V), r"\frac{\partial}{\partial V} (2 a V)"),
        (2 * sp.Derivative(V, V), r"2 \cdot \frac{\mathrm{d}}{\mathrm{d} V} V"),
    ],
)  # fmt: skip
def test_conventions(expr, latex):
    assert printing.latex(expr) == latex


@pytest.mark.parametrize(
    ("expr", "text"),
    [
        (2 * sp.Derivative(V, V), "2*Derivative(V, V)"),
        (sp.Derivative(symbols.mu(V), (V, 2)), "mu''(V)"),
        (sp.Symbol("u") - 2 * sp.Dummy("u"), "u - 2*u_"),
        (sp.Symbol("E") * sp.E, "exp(1)*E"),
    ],
)
def test_conventions_of_text(expr, text):
    assert printing.text(expr) == text


@pytest.mark.parametrize(
    ("number", "text"),
    [
        ((7, 40), "7/40"), ((3, 200), "0.015"),  # read at a glance, or a decimal
        ((123456789, 10**18), "0.000000000123456789"), ((7, 10**28), f"7/1{28 * '0'}"),  # and no long one
    ],
)  # fmt: skip
def test_fractions_that_are_short_decimals_are_decimals(number, text):
    assert printing.text(sp.Rational(*number)) == text


def test_a_computed_number_is_its_shortest_decimal():
    """A power of 2 below as many as half a million may have been written."""
    for power, is_decimal in ((19, False), (21, True)):
        assert bool(text_printer.decimal(sp.Rational(3, 2**power), shortest=True)) == is_decimal


@pytest.mark.parametrize(("letters", "is_on_fraction"), [(8, True), (20, False)])
def test_a_short_sum_stands_on_a_fraction(letters, is_on_fraction):
    one, other = sp.symbols([f"mu_{letter * letters}" for letter in "ab"], positive=True)
    shown = printing.latex(V * (one + other) / N)
    assert (shown == rf"\frac{{V}}{{N}} ({printing.latex(one + other)})") != is_on_fraction


@pytest.mark.parametrize(("letters", "is_one_pair"), [(24, True), (90, False)])
def test_long_brackets_may_be_parted(letters, is_one_pair):
    assert (r"\left" in latex_printer.bracketed(rf"\frac{{{'a' * letters}}}{{b}}")) == is_one_pair


def test_notation_may_be_replaced():
    form = form_of("exponential", "equilibrium")
    assert form.latex() == r"c = N \alpha (\mu_{\mathrm{s}} - \mu_{\mathrm{m}}) \,\mathrm{e}^{-\alpha V}"
    renamed = form.latex({"V": "v_b", "alpha": r"\beta", "c": r"c_{\mathrm{crit}}"})
    assert (
        renamed == r"c_{\mathrm{crit}} = N \beta (\mu_{\mathrm{s}} - \mu_{\mathrm{m}}) \,\mathrm{e}^{-\beta v_b}"
    )
    assert printing.latex(V**2, {"V": "V'"}) == "{V'}^{2}"


@pytest.mark.parametrize(
    "latex",
    ["{v", "}v{", "$v$", "v%", "", "v\n", "v" * 61, "v#1", "2", "AB", "-v", r"\alpha\beta", "v^{2}", "v^2",
     r"\mathrm{a+b}", r"\delta v", "v_", "v_a_b", "v\\", r"a\mathrm b", r"v_\hat{b}", r"\write18{ls}",
     r"\def\a{}", "{a+b}", "{}", r"\frac{a}{b}", "{2}", 3],
)  # fmt: skip
def test_notation_that_prints_no_symbol_is_refused(latex):
    with pytest.raises(ss.InputError, match="is not one symbol"):
        form_of("exponential", "equilibrium").latex({"alpha": latex})


def test_symbols_that_look_alike_or_are_unknown():
    for given, message in (
        ({"alpha": r"\mu_s"}, "would both be printed"),
        ({"alpa": "x"}, r"no symbol 'alpa' to print otherwise.*did you mean 'alpha'"),
    ):
        with pytest.raises(ss.InputError, match=message):
            form_of("exponential", "equilibrium").latex(given)


@pytest.mark.parametrize(
    "latex",
    ["v_b", r"\hat{v}_{1}", r"\Delta v", r"\Delta v_{\mathrm{s}}", r"\mathit{Sk}", r"\text{stick-slip}",
     r"\boldsymbol{\hat{v}}", "v^{+}", r"\bar{v_{0}}", "{V'}", r"v_{a,b}", r"\operatorname{Re}", r"v^{\prime}",
     r"\mathbb{V}", r"\mymacro{v}_{b}", r"\dot{\gamma}'_{0}"],
)  # fmt: skip
def test_notation_that_prints_one_symbol_is_taken(latex):
    assert notation_of(["alpha", "V"], {"alpha": latex})["alpha"] == latex


@sample(2)
@pytest.mark.parametrize(
    ("formula", "letters"),
    [
        ("mu_0 - 0.0185*v + 0.3*exp(-3.712345*v) + 0.1*v^3/5.1^3", ["0.0185", "3.712345", "0.3", "1326.51"]),
        ("0.31234 + 0.123/(1 + v/0.0777)", ["0.43534", "0.31234", "0.0777"]),
        ("0.4 + 0.31*v^1.5 - 0.1234*v", []),
        ("0.4 - 0.1234*v", []),
    ],
)
@mpmath.workdps(15)
def test_long_numbers_of_a_document_get_letters(formula, letters):
    form = ss.derive(formula)
    tex = ss.export_latex(form)
    _, shown, _ = re.split(r"\\label\{eq:law-least_squares\}|Verification:", tex)
    given = re.findall(r"\$(\\?\w+_\{(?:\d|\\mathrm\{\w\})\}) = ([^$]+)\$", shown)
    assert [value for _, value in given] == letters
    assert max(map(int, re.findall(r"\d+", re.sub(r"\d+\.\d+|%.*", "", shown)))) < 10**5
    right = latex_reader.sides(re.split(r"\\end\{equation\}", shown)[0] + r"\end{equation}")[1]
    point = {"V": mpmath.mpf("0.3"), "N": mpmath.mpf(2), r"\mu_{0}": mpmath.mpf("0.7")}
    point |= {name: mpmath.mpf(value) for name, value in given}
    names = dict.fromkeys(form.law.parameters, "0.7")
    assert mpmath.almosteq(latex_reader.read(right, point), form.evaluate(V="0.3", N=2, **names), rel_eps=1e-12)


@pytest.mark.parametrize("item", [ss.laws.linear, "linear", ss.criteria.harmonic])
def test_what_is_no_form_is_refused(item, tmp_path):
    for export in (ss.export_latex, lambda item: ss.export_code(item, "c")):
        with pytest.raises(ss.InputError, match="cannot be exported; give closed forms"):
            export(item)
    if not isinstance(item, ss.FrictionLaw):
        with pytest.raises(
            ss.InputError, match=f"laws are saved, got {'Criterion' if item != 'linear' else 'str'}"
        ):
            ss.save([item], tmp_path / "a.json")


def test_two_symbols_are_never_one():
    """A symbol of random parts is taken, and its product, sum or difference with another is not."""
    rng = np.random.default_rng(7)

    def symbol():
        base = str(rng.choice(["v", "Q", r"\beta ", r"\hat{v}", r"\mathit{Sk}", r"\mathcal{F}", r"\own{a}"]))
        below = str(rng.choice(["", "_0", "_{s}", r"_{\mathrm{belt}}"]))
        above = str(rng.choice(["", "'", "^*", "^{+}"]))
        return base + "".join(rng.permutation([below, above]))

    for _ in range(100):
        one, other = symbol(), symbol()
        assert notation_of(["x"], {"x": one})["x"] == one
        for sign in ("", " ", "+", "-", ","):
            with pytest.raises(ss.InputError, match="is not one symbol"):
                notation_of(["x"], {"x": f"{one}{sign}{other}"})


def test_lines_break_at_the_outermost_sum():
    terms = sp.Add(*[sp.Symbol(f"a_{i}") * (b - sp.Symbol(f"d_{i}")) for i in range(14)])
    right = printing.latex(terms)
    shown = layout.displayed("c", right, label="eq:x")
    rows = shown.split("\\\\\n")
    assert len(rows) > 2
    assert all(layout.width(row.replace("&", "")) < layout.LINE for row in rows[1:])
    assert all(row.strip().startswith("&\\quad {}+") for row in rows[1:])
    assert layout.displayed("c", "a + b") == "\\begin{equation*}\n  c = a + b\n\\end{equation*}"


@pytest.mark.parametrize(("letters", "is_aligned"), [(9, True), (35, False)])
def test_lines_are_aligned_behind_a_short_left_side(letters, is_aligned):
    """Of a fifth of a line, but not of more than a half."""
    shown = layout.displayed(" ".join("a" * letters), " + ".join("b" * 60))
    assert ("a &= b" in shown) == is_aligned


def test_an_equation_leaves_room_for_its_number():
    """A formula of 315 points fits a line of 341 points, but not beside a number with a space before it."""
    right = " + ".join(["b"] * 17) + " c" * 2
    assert 310 < layout.width("c = " + right) < 320
    assert "split" not in layout.displayed("c", right)
    assert "split" in layout.displayed("c", right, label="eq:x")
    assert "split" not in layout.displayed("c", " + ".join(["b"] * 15), label="eq:x")


@pytest.mark.parametrize(
    ("text", "latex"),
    [
        ("coefficient of v^3 at v = 0+, 5% & more, e.g. v_s/sqrt(2) < 1",
         r"coefficient of $v^{3}$ at $v = 0^{+}$, 5\% \& more, e.g.~$v_s/\sqrt{2} < 1$"),
        ("a mass, and a of v_s: N mu'(v) + a > 0, a = 0.5 kg/s",
         r"a mass, and $a$ of $v_s$: N $\mu'(v) + a > 0$, $a = 0.5$ kg/s"),
        ("Szabó – μ_α ≤ 10⁻³,\n x₀ → ∞", r"Szabó – $\mu$\_$\alpha$ $\le$ 10$^{-}$$^{3}$, x$_{0}$ $\to$ $\infty$"),
    ],
)  # fmt: skip
def test_prose(text, latex):
    assert layout.prose_latex(text, {"v": "v", "v_s": "v_s", "a": "a", "mu": r"\mu"}) == latex
    with pytest.raises(ss.InputError, match="the character 'Ж' has no sign"):
        layout.prose_latex("Жуков")


def test_a_wrong_formula_is_seen():
    """The negative control: a sign, a power or a factor more would be noticed."""
    form = form_of("exponential", "least_squares")
    tex = ss.export_latex(form)
    assert agrees(form, tex)
    assert not agrees(form, tex.replace(r"2 \alpha^{4} V^{5}", r"2 \alpha^{3} V^{5}"))
    assert not agrees(form, tex.replace("- 3 ", "+ 3 "))


def test_derivations_print_every_step():
    """The law is split, its one profile with a slope is averaged, and the averages are added up."""
    derivation = form_of("exponential", "least_squares").derivation
    text = derivation.latex()
    assert len(re.findall(r"\\begin\{equation\*\}", text)) == len(derivation.steps) == 3
    # What is in units of a scale has a hat, and says what it is; formulas in sentences are formulas.
    assert r"\int_{0}^{2 \hat{V}}" in text
    assert r"here $\hat{v} = \alpha v$, $\hat{V} = \alpha V$." in text
    assert r"Average the profile $\mathrm{e}^{-\hat{v}}$, speeds" in text
    assert r"if $c + N \mu'(V) > 0$." in form_of("exponential", "equilibrium").derivation.latex()
    assert text.startswith(r"\paragraph{The least\_squares criterion for $\mu(v) = \mu_{\mathrm{m}} + ")


# -- widths ----------------------------------------------------------------------------------------


def metrics(font):
    """Points at 10 pt of each glyph in matplotlib's copy of a font: its advance, or the edge of its ink."""
    text = (Path(matplotlib.get_data_path()) / "fonts" / "afm" / f"{font}.afm").read_text()
    rows = re.findall(r"WX ([\d.]+) ; N (\w+) ; B -?\d+ -?\d+ (-?\d+)", text)
    return {glyph: max(float(advance), float(edge)) / 100 for advance, glyph, edge in rows}


def test_widths_of_signs_are_those_of_the_fonts():
    italic, roman, signs, large = map(metrics, ("cmmi10", "cmr10", "cmsy10", "cmex10"))
    thin, medium, thick = 5 / 3, 20 / 9, 25 / 9
    letters = {letter: italic[letter] for letter in ascii_letters}
    for letter, points in letters.items():
        assert points <= layout.width(letter) < points + 3, f"{letter} is as wide as the widest of its class"
    assert sum(map(layout.width, ascii_letters)) < 1.1 * sum(letters.values())
    expected = {
        rf"\{name}": italic[name]
        for name in ("alpha", "beta", "gamma", "delta", "theta", "mu", "pi", "eta", "psi")
    }
    expected |= {sign: italic[name] for sign, name in zip(",/", ("comma", "slash"), strict=True)}
    named = {"(": "parenleft", ")": "parenright", "[": "bracketleft", "]": "bracketright", ";": "semicolon"}
    expected |= {sign: roman[name] for sign, name in named.items()} | {"5": roman["five"], "'": signs["prime"]}
    expected |= {r"\{": signs["braceleft"], r"\}": signs["braceright"], r"\infty": signs["infinity"]}
    relations = {"=": roman["equal"], "<": italic["less"], ">": italic["greater"], r"\to": signs["arrowright"],
                 r"\sim": signs["similar"], r"\approx": signs["approxequal"]}  # fmt: skip
    expected |= {sign: width + 2 * thick for sign, width in relations.items()}
    expected |= {"+": roman["plus"] + 2 * medium, "-": signs["minus"] + 2 * medium}
    expected |= {sign: expected[sign] + thin for sign in ",;"} | {r"\int": large["integraldisplay"] + thin}
    names = ("ln", "sin", "cos", "tan", "sinh", "cosh", "tanh", "coth", "arctan", "exp",
             "arcsin", "arccos", "min", "max")  # fmt: skip
    expected |= {rf"\{name}": sum(roman[letter] for letter in name) + thin for name in names}
    expected |= {rf"\{size}l": large[f"parenleft{size}"] - roman["parenleft"] for size in ("big", "bigg")}
    for sign, points in expected.items():
        assert 0 <= layout.width(sign) - points < 0.11, sign
    for name in ("epsilon", "zeta", "iota", "kappa", "lambda", "nu", "xi", "rho", "tau", "chi", "omega"):
        assert layout.width(rf"\{name}") >= italic[name], name
    assert layout.width(r"\frac{V}{N}") >= max(letters["V"], letters["N"])
