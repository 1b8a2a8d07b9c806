"""A closed form leaves as a script that the proof assistant Coq accepts, and refuses once a digit is changed."""

import random
import re
import shutil
import subprocess
from pathlib import Path

import mpmath
import pytest
import sympy as sp
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.certificates.coq.harmonic import Pole, slope_over_angle
from stickslip_sym.certificates.coq.tactics import LIBRARY
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.symbols import V, v
from support import commands
from support.sweeps import sample, sweep

needs_coq = pytest.mark.skipif(shutil.which("coqc") is None, reason="no coqc here")
LONGEST = 600  # seconds that a script may take on a machine with much else to do
AXIOMS = {"ClassicalDedekindReals.sig_not_dec", "ClassicalDedekindReals.sig_forall_dec",
          "FunctionalExtensionality.functional_extensionality_dep", "Classical_Prop.classic",
          "Eqdep.Eq_rect_eq.eq_rect_eq"}  # fmt: skip
"""Those of Coq's real numbers and of Coquelicot."""
CATALOGUE = [(name, criterion) for name in ss.laws for criterion in ("equilibrium", "least_squares")]
CATALOGUE += [(name, "harmonic") for name, law in ss.laws.items() if sp.diff(law.expr, v).is_rational_function(v)]
WITHOUT_FORM = {("andersson", "least_squares")}
SHORT = [("exponential", "least_squares"), ("tanh", "equilibrium"), ("hyperbolic", "harmonic")]
RATIONAL = "mu_s/(1 + v)", "harmonic"  # of the hyperbolic law, the part that takes a pole
README = Path(__file__).parents[2] / "README.md"
KINKED = "0.2 + (mu_s - 0.2)*Max(0, 1 - v/v_1)"


def compiled(script, folder):
    """Return whether Coq accepts a script, and what it prints."""
    file = folder / "proof.v"
    file.write_text(script, encoding="utf-8")
    done = subprocess.run(["coqc", "-q", file.name], cwd=folder, capture_output=True, text=True, timeout=LONGEST)
    return done.returncode == 0, done.stdout or done.stderr


def script_of(law, criterion="least_squares"):
    return ss.derive(law, criterion).certificate("coq")


@pytest.mark.parametrize(("kinks", "is_written"), [(2, True), (7, False)])
def test_a_script_has_both_sides_of_a_few_kinks(kinks, is_written):
    form = ss.derive(f"0.5 + {' + '.join(f'Abs(v - 0.{i})/9' for i in range(1, kinks + 1))}", "equilibrium")
    if is_written:
        assert "Theorem" in form.certificate("coq")
    else:
        with pytest.raises(ss.InputError, match="a script in Coq has the slopes between"):
            form.certificate("coq")


def changed(script, name, rng):
    """Return a script with another digit in the definition that begins with a name."""
    start = re.search(rf"^Definition {name}\b[^=]*:=", script, re.MULTILINE).end()
    body = script[start : script.index(".\n", start)]
    place = rng.choice([found.start() for found in re.finditer(r"(?<![\w.])\d", body)]) + start
    digit = str(int(script[place]) % 9 + 1)
    return script[:place] + digit + script[place + 1 :]


def proves(script, folder):
    """Whether Coq accepts a script that rests on nothing but the axioms of the real numbers."""
    accepted, printed = compiled(script, folder)
    assert accepted, printed
    assert "Admitted" not in script
    assert "Axiom" not in script
    axioms = re.findall(r"^([\w.]+) *:", printed.split("Axioms:")[1], re.MULTILINE)
    assert axioms
    assert set(axioms) <= AXIOMS
    return printed


@sample(2)
@needs_coq
@sweep(("law", "criterion"), [*SHORT, RATIONAL, (KINKED, "least_squares")], SHORT[0], RATIONAL)
def test_coq_accepts_a_closed_form(law, criterion, tmp_path):
    printed = proves(script_of(law, criterion), tmp_path)
    if law == "exponential":
        shown = re.search(r"^```coq\n(.*?)^```", README.read_text(encoding="utf-8"), re.MULTILINE | re.DOTALL)[1]
        assert printed.split("Axioms:")[0].split() == shown.split()
    stated = {
        "equilibrium": "is_derive (mu",
        "least_squares": "is_RInt (fun v : R => N * mu",
        "harmonic": "is_RInt (fun v : R => - N * w (v / V - 1) * Derive (mu",
    }
    assert stated[criterion] in " ".join(printed.split())


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize(("law", "criterion"), sorted(set(CATALOGUE) - set(SHORT) - WITHOUT_FORM))
def test_coq_accepts_every_law_of_the_catalogue(law, criterion, tmp_path):
    proves(script_of(law, criterion), tmp_path)


@needs_coq
@pytest.mark.parametrize("name", ["c", pytest.param("mu", marks=pytest.mark.thorough),
                                  pytest.param("K", marks=pytest.mark.thorough),
                                  pytest.param("A1_0", marks=pytest.mark.thorough)])  # fmt: skip
def test_coq_refuses_a_changed_digit(name, tmp_path):
    script, rng = script_of("gaussian"), random.Random(51)
    accepted, _ = compiled(changed(script, name if name != "mu" else "g1", rng), tmp_path)
    assert not accepted


@needs_coq
@pytest.mark.thorough
@pytest.mark.parametrize("name", ["c", "slope1", "rise1", "I1"])
@pytest.mark.parametrize("law", ["hyperbolic", "lorentzian"])
def test_coq_refuses_a_changed_digit_over_the_angle(law, name, tmp_path):
    script = script_of(law, "harmonic")
    accepted, _ = compiled(changed(script, name, random.Random(7)), tmp_path)
    assert not accepted


@needs_coq
@sweep("law", [
    "mu_0 + a/((1 + v/p)*(1 + v/q))",
    "mu_0 + a/(1 + v/w)^2 + 0.1/(1 + (v/w)^2)^2 + b*v/(1 + v/q)",
    "mu_0 + 0.3*log(1 + (v/w)^2) + b*v^3/(2 + v)^2",
])  # fmt: skip
def test_coq_accepts_harmonic_forms_with_several_poles(law, tmp_path):
    proves(script_of(law, "harmonic"), tmp_path)


_RATES = st.lists(st.integers(-3, 3), min_size=1, max_size=4)
_BASES = st.sampled_from([v + 2, v + 1, v**2 + 1, v**2 + v + 1, v**2 + 3 * v + 4])


@given(_RATES, _BASES, st.integers(1, 3))
def test_a_fraction_over_the_angle_is_a_slope_and_its_poles(rates, base, power):
    above = sp.Add(*[rate * v**i for i, rate in enumerate(rates)])
    rate, wave, poles = slope_over_angle(above, base, power)
    sine_squared = v * (2 * V - v) / V**2
    slope = rate + (1 - v / V) * wave + V * sine_squared * sp.diff(wave, v)
    fractions = sp.Add(*[multiple * top / base for top, multiple in poles.items()])
    assert sp.cancel(sine_squared * above / base**power - slope - fractions) == 0


@pytest.mark.parametrize(("top", "base"), [(1, v + 2), (1, v**2 + 1), (v, v**2 + 3 * v + 4)])
@mpmath.workdps(30)
def test_the_integral_of_a_pole_is_that_of_its_fraction(top, base):
    pole = Pole(sp.S.One, sp.sympify(top), base)
    fraction = sp.lambdify(v, top / base, "mpmath")
    number = mpmath.quad(lambda t: fraction(3 * (1 - mpmath.cos(t))), [0, mpmath.pi])
    assert abs(number - pole.integral.subs(V, 3).evalf(20)) < 1e-12


def test_a_law_is_stated_in_its_own_words():
    script = script_of("tanh")
    assert "Definition mu (v : R) : R := mu_s - (mu_s - mu_m) * tanh (v / v_s)." in script
    assert "Definition K (V v : R) : R := 5 * (V - v)^3 / (2 * V^5)." in script


def test_a_script_takes_of_the_library_what_it_needs():
    assert "polylog" not in script_of("exponential")
    with_polylogarithms = script_of("tanh")
    assert "Lemma derive_polylog4" in with_polylogarithms
    assert "These three values are not proved here" in with_polylogarithms


def test_no_function_of_the_library_is_unfolded_to_find_its_derivative():
    lemmas = "\n".join(LIBRARY.values())
    with_derivatives = set(re.findall(r"UnaryDiff'? \(?(\w+)", lemmas))
    opaque = " ".join(re.findall(r"^Global Typeclasses Opaque (.*)\.$", lemmas, re.MULTILINE)).split()
    assert with_derivatives == set(opaque)


def test_letters_that_mean_something_in_coq_get_other_names():
    script = script_of("mu_0*exp(-fun*v/K) + R*u*v^2 + end_1*v*r")
    letters = re.search(r"^Variables N V (.*) : R\.$", script, re.MULTILINE)[1].split()
    assert not {"fun", "K", "R"} & set(letters)
    assert len(set(letters)) == 7


@sample(3)
@pytest.mark.parametrize(
    ("law", "criterion", "words"),
    [
        ("exponential", "harmonic", "the harmonic criterion of slopes that are quotients of polynomials"),
        ("mu_0 + 0.1/(1 + a*v + v^2)", "harmonic", "zeros are not known to be complex"),
        ("0.3/(1+v) + 0.1*exp(-v)/(1+v)", "least_squares", "expint"),
        ("mu_s - 0.1*log(v/v_0)", "least_squares", "cannot tell that .*, in log"),
        ("0.3 + 0.1*log(1 - v/w)", "equilibrium", "cannot tell that .*, in log"),
        ("0.3 + 0.1*v^(-1/4)", "least_squares", "is positive"),
    ],
)
def test_what_the_scripts_do_not_have_is_refused_by_its_name(law, criterion, words):
    with pytest.raises(InputError, match=words):
        script_of(law, criterion)


def test_a_document_says_which_proof_stands_beside_it():
    form = ss.derive("linear")
    assert r"\footnote{Proof for Coq: \texttt{linear.v}.}" in ss.export_latex(form, certificate="linear.v")
    assert r"\footnote{Certificate: \texttt{linear.py}.}" in ss.export_latex(form, certificate="linear.py")


def test_there_are_two_languages():
    with pytest.raises(InputError, match="no certificate in 'isabelle'; give 'sympy' or 'coq'"):
        ss.derive("linear").certificate("isabelle")


def test_the_command_writes_a_file_in_coq(tmp_path):
    target = tmp_path / "linear.v"
    done = commands.inside("export", "linear", "--criterion", "least_squares", "--certificate", str(target))
    assert done.returncode == 0, done.stderr
    assert target.read_text(encoding="utf-8") == script_of("linear")
    done = commands.inside("export", "linear", "--criterion", "all", "--certificate", str(tmp_path / "all.v"))
    assert done.returncode == 2
    assert "one proof" in done.stderr


_NUMBERS = st.integers(1, 9).map(lambda n: f"0.{n}")
_SPEEDS = st.sampled_from(["w", "v_1", "0.5", "2"])
_TERMS = st.one_of(
    st.builds("{}*exp(-v/{})".format, _NUMBERS, _SPEEDS),
    st.builds("{}*tanh(v/{})".format, _NUMBERS, _SPEEDS),
    st.builds("{}*v^2/{}".format, _NUMBERS, _SPEEDS),
    st.builds("{}/(1 + v/{})".format, _NUMBERS, _SPEEDS),
    st.builds("{}*exp(-(v/{})^2)".format, _NUMBERS, _SPEEDS),
    st.builds("{}*atan(v/{})".format, _NUMBERS, _SPEEDS),
    st.builds("{}*log(1 + v/{})".format, _NUMBERS, _SPEEDS),
    st.builds("{}*Max(0, 1 - v/{})".format, _NUMBERS, _SPEEDS),
    st.builds("a*{}*asinh(v/{})".format, _NUMBERS, _SPEEDS),
)


@needs_coq
@pytest.mark.thorough
@given(st.lists(_TERMS, min_size=1, max_size=3))
def test_coq_accepts_random_laws(tmp_path_factory, terms):
    proves(script_of("mu_0 + " + " + ".join(terms)), tmp_path_factory.mktemp("coq"))
