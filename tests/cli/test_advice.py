"""What a refusal of `derive`, `export` or `slope_average` advises is done, in Python and as a command."""

import ast
import re
import shlex
from pathlib import Path

import pytest

import stickslip_sym as ss
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.core.status import Status
from stickslip_sym.formula import closed_form
from stickslip_sym.formula.evaluation.term_function import TermFunction
from stickslip_sym.formula.proof.proving import Verdict
from stickslip_sym.numerics.known import Unknown

AT = {"V": 0.5, "N": 9.81}
WITHOUT_FORM = "0.3+0.1*tanh(v/0.2)"
STEEP, CUT_OFF = "0.3+0.1*v^(-0.8)", "0.3+0.1*Max(v,0.01)^(-0.8)"
LOGNORMAL = "0.3+0.1*exp(-0.1*log(v/0.005)^2)"
FALLING = "0.3/(1-0.2*v)"


def call(law, criterion="least_squares", **values):
    return ss.slope_average(law, criterion)(**AT, **values)


def by_quadrature(law, criterion="least_squares", **values):
    return ss.quadrature.damping(law, criterion, **AT, **values)


def refused_as_wrong():
    closed_form._require(Verdict(Status.REFUTED, "at V = 1"), ss.criteria.harmonic)


def without_branches():
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(TermFunction, "branches", lambda *_: Unknown("no table was made"))
        ss.export_code(ss.slope_average(LOGNORMAL), "c")


EITHER = {
    "stickslip_sym.slope_average": lambda: call(WITHOUT_FORM, "harmonic"),
    "stickslip_sym.quadrature.damping": lambda: by_quadrature(WITHOUT_FORM, "harmonic"),
}
"""What is advised where there is no closed form, done."""
REFUSALS = {
    "has no closed form that is known here": (
        lambda: ss.derive(WITHOUT_FORM, "harmonic"), EITHER, f"derive {WITHOUT_FORM} --criterion harmonic"),
    "the time limit of": (
        lambda: ss.derive("linear", time_limit=0),
        EITHER | {"time_limit=": lambda: ss.derive("linear", time_limit=60)},
        "derive linear --criterion least_squares --time-limit 0"),
    "a formula was found but refuted": (refused_as_wrong, EITHER, None),
    "a term of dmu/d": (
        lambda: ss.derive("stribeck").sensitivity("delta"),
        EITHER, None),
    "it is not integrable at v = 0+": (
        lambda: ss.derive(STEEP, "harmonic"),
        {"write Max(v, v_c) for v": lambda: call(CUT_OFF, "harmonic")},
        f"derive {STEEP} --criterion harmonic"),
    "mu grows without bound at v = 0+": (
        lambda: call(STEEP, "harmonic"),
        {"write Max(v, v_c) for v": lambda: call(CUT_OFF, "harmonic")},
        f"damping {STEEP} --method harmonic"),
    "code is written for one value of an exponent": (
        lambda: ss.export_code(ss.slope_average("stribeck"), "c"),
        {"law.bind(delta=...)": lambda: ss.export_code(ss.slope_average(ss.laws.stribeck.bind(delta=1.5)), "c")},
        "export stribeck --criterion harmonic --octave a.m"),
    "has no branches that could be written": (
        without_branches, {"stickslip_sym.slope_average": lambda: call(LOGNORMAL)}, None),
    "beyond the range of float64": (
        lambda: ss.slope_average("exponential")(V=1, N=1e308, mu_s=1e9, mu_m=0, alpha=1e9),
        {"evaluate(digits=...)": lambda: ss.derive("exponential").evaluate(
            digits=20, V=1, N=1e308, mu_s=1e9, mu_m=0, alpha=1e9)},
        None),
    "no value for": (
        lambda: ss.slope_average("linear")(**AT), {"a_1=": lambda: call("linear", mu_s=0.5, a_1=0.2)}, None),
    "has no formula to print": (
        lambda: ss.export_latex(ss.derive(POINTS, "equilibrium")),
        {"export_code": lambda: ss.export_code(ss.derive(POINTS, "equilibrium"), "c")}, None),
    "where the script has no rule": (
        lambda: ss.derive(FALLING).certificate(),
        {"print(form.derivation.text())": lambda: ss.derive(FALLING).derivation.text()},
        f"export {FALLING} --criterion least_squares --certificate a.py"),
    "a script in Coq has the harmonic criterion of slopes": (
        lambda: ss.derive("exponential", "harmonic").certificate("coq"),
        {'form.certificate("sympy")': lambda: ss.derive("exponential", "harmonic").certificate("sympy")},
        "export exponential --criterion harmonic --certificate a.v"),
}  # fmt: skip
"""By words of a message: what is refused, what is advised and how it is done, and a command refused so."""
POINTS = ss.FrictionLaw.from_samples([0, 0.1, 0.2, 0.4], [0.5, 0.4, 0.35, 0.3])
ADVISED = re.compile(
    r"stickslip ((?:damping|derive|export) LAW(?: --[a-z-]+(?: [A-Za-z_]+(?:\.[a-z]+)?(?![\w(]))?)*)"
)


@pytest.mark.parametrize("words", REFUSALS)
def test_advice_in_python_leads_on(words):
    refused, advice, _ = REFUSALS[words]
    with pytest.raises(StickSlipError) as raised:
        refused()
    message = str(raised.value)
    assert words in message
    for text, follow in advice.items():
        assert text in message
        assert follow() is not None


@pytest.mark.filterwarnings("ignore::stickslip_sym.core.errors.InputWarning")
@pytest.mark.parametrize("words", [words for words, (*_, line) in REFUSALS.items() if line is not None])
def test_advice_of_the_command_line_leads_on(words, run, tmp_path, monkeypatch):
    """Commands that are named answer, and so does the command itself with the option that is named."""
    monkeypatch.chdir(tmp_path)
    line = REFUSALS[words][2]
    law = line.split()[1]
    code, _, err = run(*line.split())
    assert code in (1, 2)
    message = " ".join(err[err.index("error: ") :].split())
    assert words in message
    commands = ADVISED.findall(message)
    followed = [
        shlex.split(each.replace("LAW", law).replace("FILE.", "new.").replace("FILE", "new.py"))
        for each in commands
    ]
    if (option := re.search(r"give it (?:first|more time with)[: ]*(-p \w+=|--time-limit)", message)) is not None:
        given = [option[1] + "1.5"] if option[1].startswith("-p") else ["--time-limit 60"]
        kept = line.replace(" --time-limit 0", "")
        followed.append([*kept.split(), *given[0].split()])
    if "write Max(v, v_c) for v" in message:
        followed.append(["damping", CUT_OFF, "--method", "harmonic"])
    assert followed, message
    for command in followed:
        assert command != line.split(), "that is the command just given"
        code, _, err = run(*command)
        assert code == 0, (command, err)


ADVISES = re.compile(r"\b(Call|Argument|ParameterValues|_other_ways)\(")


def test_every_refusal_that_advises_something_is_in_the_table():
    package = Path(ss.__file__).parent
    files = [*(package / "formula").rglob("*.py"), package / "cli" / "derive.py", package / "cli" / "export.py"]
    files += [package / "certificates" / "closed_forms.py", package / "certificates" / "coq" / "harmonic.py"]
    advised = 0
    for path in files:
        text = path.read_text()
        for node in ast.walk(ast.parse(text)) if ADVISES.search(text) else ():
            if not isinstance(node, ast.Raise) or node.exc is None:
                continue
            source = ast.unparse(node)
            if not ADVISES.search(source):
                continue
            advised += 1
            assert any(words in _said(node, path) for words in REFUSALS), source
    assert advised >= 8


def _said(node, path):
    """Return the constant texts of a message, or of the function in which it is made."""
    whole = ast.parse(path.read_text())
    functions = [each for each in ast.walk(whole) if isinstance(each, ast.FunctionDef)]
    inside = min(
        (f for f in functions if f.lineno <= node.lineno <= f.end_lineno), key=lambda f: f.end_lineno - f.lineno
    )
    texts = [str(each.value) for each in ast.walk(inside) if isinstance(each, ast.Constant)]
    return "".join(texts) + " a formula was found but refuted" * ("a formula was found but " in "".join(texts))
