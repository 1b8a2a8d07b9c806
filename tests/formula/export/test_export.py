"""Exported files: LaTeX through a real engine, and Python, C and Octave run against many digits."""

import ctypes
import re
import shutil
import subprocess

import numpy as np
import pytest
import sympy as sp

import stickslip_sym as ss
from stickslip_sym.core.special import Lerch
from stickslip_sym.formula.code.languages import LANGUAGES
from stickslip_sym.formula.code.writer import expression_text as written
from stickslip_sym.formula.proof.normal_form import plain
from stickslip_sym.formula.transition_speeds import transition_speeds
from stickslip_sym.output.printing import text as text_of
from support import accuracy
from support.accuracy import MOST_UNITS
from support.closed_forms import NO_LEAST_SQUARES, agrees, form_of
from support.commands import inside
from support.exported_code import PROGRAMS, compiled, runs, values_of
from support.sweeps import sample, sweep

FEW = [
    ("exponential", "least_squares"), ("exponential_viscous", "harmonic"), ("gaussian", "least_squares"),
    ("hyperbolic", "harmonic"), ("tanh", "least_squares"), ("hyperbolic", "equilibrium"),
    ("polynomial", "harmonic"), ("two_exponentials", "harmonic"),
]  # fmt: skip
"""Every kind of branch: one term, several, tables, the slope at one point."""


def pdflatex(text, directory):
    """Compile a document twice, and return what the engine says."""
    (directory / "a.tex").write_text(text)
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "a.tex"]
    for _ in range(2):
        done = subprocess.run(command, cwd=directory, capture_output=True, timeout=60, check=False)
    said = done.stdout.decode("latin-1")
    assert done.returncode == 0, said[-2000:]
    return said


NEEDS_LATEX = pytest.mark.skipif(
    shutil.which("pdflatex") is None, reason="there is no pdflatex; Debian has it in texlive-latex-recommended"
)


HARMONIC = (
    "exponential", "gaussian", "lorentzian", "hyperbolic", "arcsinh", "arctangent", "rational", "kragelskii",
)  # fmt: skip


@sweep("laws", [(("exponential", "andersson"),), (tuple(ss.laws),)], (("exponential", "andersson"),))
def test_many_laws_in_one_document(laws, tmp_path):
    """Every formula is read back as it stands there, and none is wider than the text."""
    wanted = [(name, "equilibrium" if name in NO_LEAST_SQUARES else "least_squares") for name in laws]
    wanted += [(name, "harmonic") for name in HARMONIC if name in laws]
    forms = [form_of(*one) for one in wanted]
    text = ss.export_latex(forms)
    assert [form for form in forms if not agrees(form, text)] == []
    labels = re.findall(r"\\label\{(.*)\}", text)
    assert len(labels) == len(set(labels)) == len(forms) + len(laws)
    if shutil.which("pdflatex"):
        assert re.findall(r"(?:Overfull|Underfull|LaTeX Warning).*", pdflatex(text, tmp_path)) == []


@NEEDS_LATEX
def test_steps_and_other_symbols_compile(tmp_path):
    forms = [form_of("exponential", "least_squares"), form_of("hyperbolic", "harmonic")]
    text = ss.export_latex(forms, steps=True, symbols={"V": "v_b", "alpha": r"\beta"})
    assert text.count("Derivation of") == 2
    assert r"\mathrm{e}^{-2 \beta v_b}" in text
    assert "Warning" not in (said := pdflatex(text, tmp_path))
    assert "Overfull" not in said


HOSTILE = "50% & $x$ _a_ #1 \\input{x} {} ~^\n\n<b> */ μ"


@NEEDS_LATEX
def test_texts_of_users_compile_with_amsmath_only(tmp_path):
    """Two laws of one name have labels of their own; symbols may be styled, also under a dot."""
    described = [ss.Parameter("a", HOSTILE, unit="1", typical="0.5"), ss.Parameter("b", "50 %", unit="s/m")]
    texts = {"name": HOSTILE, "source": HOSTILE, "validity": HOSTILE, "parameters": described}
    made = [ss.derive(ss.FrictionLaw(formula, **texts)) for formula in ("a*exp(-b*v)", "1 + a*exp(-b*v)")]
    symbols_given = {"x": r"\mathrm{x}", "b": r"\hat{b}_{\mathrm{s}}"}
    inside = ss.export_latex(made, symbols=symbols_given, fragment=True)
    (tmp_path / "part.tex").write_text(inside)
    head = "\\documentclass{article}\n\\usepackage{amsmath}\n"
    whole = head + "\\begin{document}\n\\input{part}\n\\end{document}\n"
    assert "multiply defined" not in pdflatex(whole, tmp_path)
    assert "multiply defined" not in pdflatex(ss.export_latex(made, symbols=symbols_given), tmp_path)
    assert f"slip speed $|V - \\dot{{{symbols_given['x']}}}|$" in inside
    assert re.findall(r"\\label\{(.*)\}", inside)[0] == "eq:50-x-_a_-1-input-x-b-law"


def test_code_has_names_that_the_language_takes():
    laws = [ss.FrictionLaw("a*exp(-b*v)", name=name) for name in ("my 1st law", HOSTILE, "μ")]
    text = ss.export_code([ss.derive(law) for law in laws], "python")
    compile(text, "export", "exec")
    names = re.findall(r"^def (damping\w*)\((?!a\))", text, re.M)
    assert names[0] == "damping_my_1st_law_least_squares"
    assert names[2] == "damping_law_3_least_squares"


@NEEDS_LATEX
def test_a_box_that_is_too_wide_would_be_seen(tmp_path):
    """The negative control."""
    text = ss.export_latex(form_of("exponential", "least_squares"))
    joined = re.sub(r"\\\\\n +&\\quad \{\}", " ", text)
    assert joined != text
    assert "Overfull" in pdflatex(joined, tmp_path)


def test_a_fragment_has_no_preamble():
    form = form_of("polynomial", "least_squares")
    text = ss.export_latex(form, fragment=True, missing=[(form.law, "harmonic", "nothing was found")])
    assert not any(word in text for word in ("documentclass", r"\section"))
    assert "For the harmonic criterion no closed form was found" in text
    assert r"\label{eq:polynomial-least_squares}" in text
    assert r"It vanishes at the transition speed $V = \sqrt{546} v_{\mathrm{m}}/26$." in text


def test_measured_points_have_no_formula():
    law = ss.FrictionLaw.from_samples([0, 0.1, 0.2, 0.4], [0.5, 0.4, 0.35, 0.3])
    with pytest.raises(ss.InputError, match="measured points has no formula to print"):
        ss.export_latex(ss.derive(law, "equilibrium"))


# -- limits ------------------------------------------------------------------------------------------


def test_transition_speeds_that_are_exact():
    """Those of a polynomial, two as close as 3e-3; of a slope with one sign none; others are not stated."""
    for gap in (1, 1e-1, 1e-2, 3e-3):
        roots = [0.7, float(f"{0.7 * (1 + gap):.6g}")]
        low, high = roots
        polynomial = ss.derive(f"1 + v^3/3 - ({low} + {high})*v^2/2 + {low}*{high}*v", "equilibrium")
        assert transition_speeds(polynomial).values == pytest.approx(roots, rel=1e-12)
        assert "and nowhere else" in ss.export_latex(polynomial)
    assert transition_speeds(form_of("exponential", "equilibrium")).values == ()  # underflow is no zero
    assert transition_speeds(form_of("coulomb", "harmonic")).everywhere
    form = form_of("gaussian_viscous", "least_squares")
    assert (transition_speeds(form).values, transition_speeds(form).formula) == (None, None)
    assert "No formula was found for its zeros" in ss.export_latex(form)


def test_a_document_says_no_more_than_is_known():
    """Of a law without typical values nothing is said of them, and signs that hold for all parameters as such."""
    text = ss.export_latex(ss.derive("mu_0 + a/(1 + (v/v_s)^2)"))
    assert r"It has no zeros: $\mu(v)$ falls at all slip speeds, so $c > 0$ at all belt speeds." in text
    assert "typical" not in text
    assert r"$\mu_{0}$, $a$, $v_{\mathrm{s}}$ & parameters of the law &  \\" in text
    rising = ss.export_latex(ss.derive("mu_0 + a*v", "equilibrium"))
    assert r"rises at all slip speeds, so $c < 0$" in rising
    typical = ss.export_latex(form_of("exponential", "least_squares"))
    assert r"For the typical values it has no zeros: $\mu(v)$ falls" in typical
    assert "typical value" in typical


def test_the_sign_of_a_discriminant_is_said():
    """One formula holds for either sign; its argument is in lowest terms, and its cases stand below."""
    form = ss.derive("a/(1 + b*v + d*v^2)")
    text = ss.export_latex(form)
    assert r"{}_{2}F_{1}\bigl[1/2, 1; 3/2; V^{2} (b^{2} - 4 d)/(1 + b V)^{2}\bigr]" in text
    assert r"its argument has the sign of $b^{2} - 4 d$." in text
    node, z = sp.hyper((sp.Rational(1, 2), 1), (sp.Rational(3, 2),), sp.Symbol("z")), sp.Symbol("z")
    for value in ("1/3", "-7/5"):
        elementary = plain(node.subs(z, sp.Rational(value)))
        assert not elementary.has(sp.hyper)
        assert abs(sp.N(elementary - node.subs(z, sp.Rational(value)), 30)) < 1e-28
    for e in (1, 2, 5):
        node = sp.hyper((sp.Rational(7, 10), e), (e + 1,), sp.Rational(-7, 5))
        assert not plain(node).has(sp.hyper)
        assert abs(sp.N(plain(node) - node, 30)) < 1e-28


# -- code --------------------------------------------------------------------------------------------


ODD = {"np": 0.5, "float": 0.3, "zip": 2.0, "M_PI": 0.2, "NAN": 0.1, "typeof": 0.4, "sum": 0.6, "sum_": 0.7}
"""Names of parameters that a language keeps, and their values."""


@sample(2)
@pytest.mark.parametrize("language", PROGRAMS)
def test_several_criteria_in_one_file(language, tmp_path):
    if not runs(language):
        pytest.skip(f"there is no {PROGRAMS[language]} on this machine; Debian has it")
    odd = ss.FrictionLaw("np*Abs(v - float) + zip*exp(-v/M_PI) + NAN*v^2 + typeof*v*sum/sum_",
                         parameters=[ss.Parameter("NAN")])  # fmt: skip
    forms = [*(form_of(*one) for one in FEW), ss.derive(odd)]
    points = [accuracy.samples(form.law, "middle", 1, seed=6) for form in forms[:-1]]
    points.append({key: np.array([value]) for key, value in ({"V": 0.5, "N": 2.0} | ODD).items()})
    names = [f"damping_{form.law.name}_{form.criterion.name}" for form in forms]
    names[-1] = f"damping_law_{len({form.law for form in forms})}_least_squares"
    calls = [(name, [float(point[key][0]) for key in form.arguments])
             for name, form, point in zip(names, forms, points, strict=True)]  # fmt: skip
    values = values_of(language, ss.export_code(forms, language), calls, tmp_path)
    for form, point, value in zip(forms[:-1], points, values, strict=False):
        assert accuracy.units(form, point, np.array([value])).max() <= MOST_UNITS, form
    assert values[-1] == pytest.approx(forms[-1](**points[-1])[0], rel=1e-12)


@pytest.mark.parametrize("language", LANGUAGES.values(), ids=LANGUAGES)
def test_no_part_of_written_code_overflows_and_numbers_are_read_back(language):
    """SymPy's printers would write hyperbolic functions by exponentials, and a third as 1/3 or in 15 digits."""
    x = ss.symbols.V
    text = written(sp.sech(x) + sp.coth(x) + sp.Rational(1, 3) * sp.csch(x), {x: "x"}, language)
    assert "exp" not in text
    assert all(name in text for name in ("cosh", "tanh", "sinh"))
    number = 0.1 + 0.2
    assert repr(number) in written(sp.Float(number, 40) * x, {x: "x"}, language)
    with pytest.raises(ss.InputError, match="lacks Lerch"):
        written(Lerch(-x, 2, sp.S.Half), {x: "x"}, language)


def test_code_of_one_form_is_its_own():
    form = form_of("polynomial", "harmonic")
    for language in ("c", "python", "octave", "javascript"):
        assert ss.export_code([form], language) == ss.export_code(form, language) == form.code(language)


def test_code_says_its_formula_and_has_the_name_that_it_is_given():
    form = form_of("exponential", "least_squares")
    for language in ("c", "python", "octave", "javascript"):
        text = ss.export_code(form, language, name="2nd brake-pad")
        assert f"c = {text_of(form.expr)}" in text
        assert f"mu(v) = {form.law.text}" in text
        assert "damping_2nd_brake_pad(" in text
        assert "damping(" not in text


def test_c_takes_arrays(tmp_path):
    form = form_of("exponential", "harmonic")
    point = accuracy.samples(form.law, "middle", 50, seed=3)
    compiled(ss.export_code(form, "c"), tmp_path)
    function = ctypes.CDLL(str(tmp_path / "a.so")).damping_array
    columns, values = [np.ascontiguousarray(point[key], float) for key in form.arguments], np.empty(50)
    pointers = [column.ctypes.data_as(ctypes.c_void_p) for column in (*columns, values)]
    function(ctypes.c_int(50), *pointers)
    assert accuracy.units(form, point, values).max() <= MOST_UNITS


def test_octave_takes_arrays_in_which_some_values_are_extreme(tmp_path):
    """Products that would leave the range of floats go another way, for all elements together."""
    if not runs("octave"):
        pytest.skip("there is no octave-cli on this machine; Debian has it")
    form = ss.derive(ss.laws.exponential.typical())
    V = np.array([1e-200, 1e-3, 0.5, 1e150, -1.0, np.nan])
    names = {"V": V, "N": 2.0} | {name: float(value) for name, value in form.law.values.items()}
    got = values_of("octave", form.code("octave"), [("damping", [names[key] for key in form.arguments])], tmp_path)
    expected = [form(V=float(speed), N=2.0) for speed in V[:4]]
    assert got[:4] == pytest.approx(expected, rel=1e-13)
    assert np.isnan(got[4:]).all()


def test_octave_text_is_matlab_too():
    """MATLAB has no names that begin with an underscore, and another sign for inequality."""
    text = ss.export_code([form_of(*one) for one in FEW], "octave")
    assert re.findall(r"(?<![\w.])_\w|!=|endfunction|endif|printf|#", text) == []
    assert text.count("\nend\n") >= text.count("function ") > 8


def test_a_shape_is_bound_before_code_is_written():
    law = ss.laws.stribeck
    with pytest.raises(ss.InputError, match=r"delta of the law stribeck .* give it first: law.bind\(delta"):
        ss.derive(law).code("c")
    assert "delta" not in ss.derive(law.bind(delta="1.5")).code("python").split("def damping(")[1].split(")")[0]


# -- the command -------------------------------------------------------------------------------------


def test_command_writes_all_outputs(tmp_path):
    files = {kind: f"a.{kind}" for kind in ("latex", "python", "c", "octave", "javascript", "save")}
    options = [word for kind, name in files.items() for word in (f"--{kind}", name)]
    done = inside("export", "polynomial", *options, "--symbol", "V=v_b", cwd=tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    said = {kind: "1 law" if kind == "save" else "1 criterion" for kind in files}
    assert done.stdout.splitlines() == [f"{kind}: {said[kind]} in {name}" for kind, name in files.items()]
    assert "v_b^{2}" in (tmp_path / "a.latex").read_text()
    (law,) = ss.load(tmp_path / "a.save")
    assert ss.derive(law).code("octave") == (tmp_path / "a.octave").read_text()
