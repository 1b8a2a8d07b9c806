"""A closed form leaves as a script that proves it without this package, and fails at whatever is changed in it."""

import ast
import contextlib
import io
import random
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest
from sweeps import sweep

import stickslip_sym as ss
from stickslip_sym.certificates.closed_forms import certificate_of_forms

ROOT = Path(__file__).parents[2]
WITHOUT_THE_PACKAGE = "import runpy, sys; sys.modules['stickslip_sym'] = None; runpy.run_path(sys.argv[1])"
PAGES = sorted((ROOT / "derivations" / "certificates").glob("*.py"))
CATALOGUE = [(name, criterion) for name in ss.laws for criterion in ("equilibrium", "least_squares", "harmonic")]
CHANGED = {
    "law": ("mu = ", "law = "),
    "formula": ("c = ",),
    "weight": ("w = ", "K = "),
    "antiderivative": ("A1",),
    "limit": ("F1",),
    "equation": ("equation = ",),
    "operator": ("q = ", "y = "),
    "function": ("functions[", "roots["),
    "limit of V": ("at_rest = ", "far = ", "like = "),
}
"""What may be changed, by what its lines begin with."""
OPPOSITE = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}


def outcome(script):
    """Run a script in this process; return what it printed, or what its assertion says."""
    stream = io.StringIO()
    try:
        with contextlib.redirect_stdout(stream):
            exec(compile(script, "a certificate", "exec"), {})
    except AssertionError as failure:
        return f"failed: {failure}"
    return stream.getvalue().strip()


def changed(line, rng):
    """Return a line with another sign, number or operation at a random place; the same line where it has none."""
    tree = ast.parse(line)
    value = tree.body[0].value
    nodes = list(ast.walk(value))
    operations = [node for node in nodes if isinstance(node, ast.BinOp) and type(node.op) in OPPOSITE]
    signs = [node for node in nodes if isinstance(node, ast.UnaryOp)]
    numbers = [node for node in nodes if isinstance(node, ast.Constant) and type(node.value) is int]
    kinds = [kind for kind in (operations, signs, numbers) if kind]
    if not kinds:
        return line
    node = rng.choice(rng.choice(kinds))
    if isinstance(node, ast.BinOp):
        node.op = OPPOSITE[type(node.op)]()
    elif isinstance(node, ast.UnaryOp):
        node.op = ast.UAdd()
    else:
        node.value += 1
    return ast.unparse(tree)


def mutants(script, kind, count, rng):
    """Return some scripts with one line of a kind changed."""
    lines = script.splitlines()
    start = next(i for i, line in enumerate(lines) if line.startswith("# -- "))
    places = [
        i for i, line in enumerate(lines)
        if i > start and line.startswith(CHANGED[kind]) and (kind != "limit" or "rise(" in line)
    ]  # fmt: skip
    found = set()
    for _ in range(20 * count):
        if not places or len(found) == count:
            break
        i = rng.choice(places)
        new = changed(lines[i], rng)
        if (new.startswith("like = ") and "1 - s" in new) or "sympify" in new:
            continue  # a symmetric weight averages both alike; a constant is an antiderivative of 0
        if new != lines[i] and ast.dump(ast.parse(new)) != ast.dump(ast.parse(lines[i])):
            found.add("\n".join([*lines[:i], new, *lines[i + 1 :]]))
    return sorted(found)


def test_a_certificate_proves_without_the_package(tmp_path):
    """Several laws one after another, formatted as the project formats."""
    forms = [ss.derive("exponential", "harmonic"), ss.derive("linear"), ss.derive("linear", "equilibrium")]
    path = tmp_path / "proof.py"
    path.write_text(certificate_of_forms(forms))
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_THE_PACKAGE, str(path)], capture_output=True, text=True, check=False
    )
    proved = ["exponential, harmonic", "linear, least_squares", "linear, equilibrium"]
    assert done.stdout.splitlines() == [f"proved: {what}" for what in proved], done.stderr
    ruff = shutil.which("ruff", path=sysconfig.get_path("scripts")) or shutil.which("ruff")
    if ruff is not None:
        for command in (["check"], ["format", "--check"]):
            checked = [ruff, *command, "--config", str(ROOT / "pyproject.toml"), str(path)]
            subprocess.run(checked, check=True, capture_output=True)


@sweep(("law", "criterion"), [("exponential", "least_squares"), ("exponential", "harmonic")], 1)
def test_whatever_is_changed_is_noticed(law, criterion):
    rng, script = random.Random(1), ss.derive(law, criterion).certificate()
    kinds = [kind for kind in CHANGED if mutants(script, kind, 1, rng)]
    assert len(kinds) >= 4
    for kind in kinds:
        for mutant in mutants(script, kind, 2, rng):
            assert outcome(mutant).startswith("failed: "), kind


@pytest.mark.thorough
@pytest.mark.parametrize(
    "page", sorted((ROOT / "derivations" / "certificates").glob("*")), ids=lambda page: page.stem
)
def test_pages_of_the_derivations_prove_without_the_package(page):
    command = [sys.executable, "-c", WITHOUT_THE_PACKAGE, str(page)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.startswith("proved: ")


@pytest.mark.thorough
@pytest.mark.parametrize(("law", "criterion"), CATALOGUE)
def test_the_catalogue_leaves_with_its_proofs(law, criterion):
    try:
        script = ss.derive(law, criterion).certificate()
    except ss.NoClosedForm:
        return
    assert outcome(script) == f"proved: {law}, {criterion}"
    rng = random.Random(law)
    for kind in CHANGED:
        for mutant in mutants(script, kind, 2, rng):
            assert outcome(mutant).startswith("failed: "), kind


PROFILES = (
    "exp(-v/p)", "v*exp(-q*v)", "exp(-(v/p)^2)", "1/(1 + v/p)", "1/(1 + (v/q)^2)", "(1 + v/p)^(-3)",
    "log(1 + q*v)", "tanh(q*v)", "sech(v/p)", "atan(q*v)", "asinh(v/p)", "sqrt(v)", "v^3", "v^1.5",
    "sqrt(1 + v/p)", "cos(q*v)", "erf(q*v)", "v*atan(v/p)", "1/sqrt(1 + (v/p)^2)", "Max(p - v, 0)",
    "Min(v, p)", "Min(v/q, 1)*exp(-v)", "log(1 + v^2)",
)  # fmt: skip
"""Profiles of laws that have closed forms by one criterion at least."""


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(40))
def test_random_laws_leave_with_their_proofs(seed):
    rng = random.Random(seed)
    first, second = rng.sample(PROFILES, 2)
    try:
        form = ss.derive(f"mu_0 + a*{first} - {rng.choice(('b', '0.07'))}*{second}", rng.choice(CATALOGUE[:3])[1])
    except ss.NoClosedForm:
        return
    if form.verdict.status is not ss.Status.PROVED:
        return
    script = form.certificate()
    assert outcome(script).startswith("proved: ")
    for kind in ("law", "formula", "equation", "operator", "function"):
        for mutant in mutants(script, kind, 1, rng):
            assert outcome(mutant).startswith("failed: "), kind


@sweep(
    ("law", "criterion", "stated"),
    [
        ("0.5 - 0.1*sqrt(v)", "least_squares", "at_rest = 13 * sqrt(2) * N / (315 * sqrt(V))"),
        ("a + b*v**2", "harmonic", "far = -2 * N * V * b_"),
        ("0.4 - 0.1*v*log(v)", "equilibrium", "at_rest = -sp.oo"),
        ("exponential", "least_squares", "far = 0"),
        ("-a*v*atan(v/p) - a*sech(v/p)", "least_squares", "far = pi * N * a / 2"),
    ],
    0, 2, 3,
)  # fmt: skip
def test_limits_are_stated_and_checked(law, criterion, stated):
    script = ss.derive(law, criterion).certificate()
    assert stated in script
    assert outcome(script).startswith("proved: ")
    name, _, value = stated.partition(" = ")
    wrong = outcome(script.replace(stated, f"{name} = -2 * ({value}) + 1", 1))
    assert wrong.startswith("failed: the limit for ")


@sweep("text", ["0.2 + 0.1*(coth(v) - 1/v)", "0.5 - 0.3*Min(v, v_k)*exp(-v)", "mu_0"], 0, 2)  # the last is 0
def test_what_cancels_at_rest_or_meets_a_kink_is_proved(text):
    assert outcome(ss.derive(text).certificate()).startswith("proved: ")


@sweep("criterion", ["least_squares", "harmonic"], "harmonic")
def test_names_of_parameters_mean_nothing_else_in_a_script(criterion):
    form = ss.derive("gamma + F1*exp(-v/sum) + n*v + theta*v**2 - lambda1*s", criterion)
    assert outcome(form.certificate()) == f"proved: {form.law.text}, {criterion}"


def test_pieces_are_proved_between_kinks_and_what_is_not_proved_is_named():
    text = "mu_s - a*Min(v, v_k)"
    assert outcome(ss.derive(text).certificate()).startswith("proved: ")
    script = ss.derive(text, "harmonic").certificate()
    assert script.splitlines()[0].startswith('"""Not proved here')
    assert outcome(script).startswith("compared: ")
    assert outcome(script.replace("g1.subs", "2 * g1.subs", 1)).startswith("failed: the split")


def test_a_sensitivity_starts_from_the_law_that_it_is_of():
    script = ss.derive("exponential").sensitivity("alpha").certificate()
    assert outcome(script).startswith("proved: ")
    (law,) = [line for line in script.splitlines() if line.startswith("law = mu_m")]
    assert outcome(script.replace(law, law.replace("alpha", "2 * alpha"))) == "failed: the derivative of the law"
