"""A closed form leaves as a page that proves it without this package, and fails at whatever is changed in it."""

import ast
import random
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

import stickslip_sym as ss
from stickslip_sym.certificates.closed_forms import CHECKER, certificate_of_forms
from support.edits_of_proofs import EDITS, JUMPS, outcome
from support.sweeps import sample, some, sweep

ROOT = Path(__file__).parents[2]
WITHOUT_THE_PACKAGE = """
import sys
sys.modules["stickslip_sym"] = None
for path, optimised in zip(sys.argv[1::2], sys.argv[2::2]):
    with open(path) as file:
        exec(compile(file.read(), path, "exec", optimize=int(optimised)), {"__name__": "__main__"})
    print("end of", path)
"""
PAGES = sorted((ROOT / "derivations" / "certificates").glob("*.py"))
CATALOGUE = [(name, criterion) for name in ss.laws for criterion in ("equilibrium", "least_squares", "harmonic")]
KINKS = "0.5 - a*Min(v, v_k)"
LAWS = [("0.3 + 0.1*exp(-v)", "least_squares"), ("0.3 + 0.1*exp(-v)", "harmonic"), (KINKS, "least_squares"),
        (KINKS, "equilibrium"), ("polynomial", "harmonic"), ("mu_0 + a/(1 + v/p)", "harmonic"),
        ("Piecewise((mu_0, v < v_k), (mu_1, True))", "least_squares")]  # fmt: skip


def run(*pages):
    """Run pages where the package cannot be imported, until one fails; optimised, as by -O, without assertions."""
    words = [word for path, optimised in pages for word in (str(path), str(int(optimised)))]
    command = [sys.executable, "-c", WITHOUT_THE_PACKAGE, *words]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def test_a_page_proves_without_the_package_and_fails_without_assertions(tmp_path):
    """Several laws one after another, formatted as the project formats; then, under -O, a false one."""
    forms = [ss.derive("exponential", "harmonic"), ss.derive("linear"), ss.derive("linear", "equilibrium")]
    path = tmp_path / "proof.py"
    path.write_text(certificate_of_forms(forms))
    false = tmp_path / "false.py"
    false.write_text(forms[1].certificate().replace("\nc = N * a_1", "\nc = 2 * N * a_1"))
    done = run((path, False), (false, True))
    *proved, last = [line for line in done.stdout.splitlines() if line.startswith(("proved", "end of"))]
    assert last == f"end of {path}", done.stderr
    assert proved[1:] == ["proved: c = N*a_1"] * 2
    assert "NotProved: c is not the sum of the averages" in done.stderr
    assert proved[0].startswith("proved: c = 2*N*(")
    ruff = shutil.which("ruff", path=sysconfig.get_path("scripts")) or shutil.which("ruff")
    if ruff is not None:
        for command in (["check"], ["format", "--check"]):
            checked = [ruff, *command, "--config", str(ROOT / "pyproject.toml"), str(path)]
            subprocess.run(checked, check=True, capture_output=True)


def test_the_checker_is_the_same_on_every_page_and_knows_no_assertion():
    pages = [ss.derive(law, criterion).certificate() for law, criterion in some(LAWS, 4)]
    ends = {page[page.index("# == CHECKER") :] for page in pages}
    assert ends == {f"{CHECKER}\n\nfor claim in claims:\n    prove(*claim)\n"}
    assert not any(isinstance(node, ast.Assert) for node in ast.walk(ast.parse(CHECKER)))
    for page in pages:
        places = [page.index(f"# == {part}") for part in ("STATEMENT", "DATA", "CHECKER")]
        assert places == sorted(places)


ALWAYS = [LAWS[0], LAWS[2], LAWS[3]]
"""The laws on whose pages edits are tried by default, a third of the kinds on each."""


@sample(2)
@sweep(("law", "criterion"), LAWS, *ALWAYS)
def test_every_edit_that_understands_the_page_is_noticed(law, criterion, request):
    """All edits of each kind with --thorough; by default one of a kind, on one page."""
    page, is_thorough = ss.derive(law, criterion).certificate(), request.config.getoption("--thorough")
    assert outcome(page).startswith("proved: ")
    rng, tried = random.Random(law + criterion), set()
    kinds = list(EDITS.items())
    if not is_thorough:
        kinds = kinds[ALWAYS.index((law, criterion)) :: len(ALWAYS)]
    for name, edit in kinds:
        edits = edit(page)
        if not is_thorough and edits:
            edits = [rng.choice(edits)]
        for edited in edits:
            assert edited != page, name
            assert outcome(edited).startswith("failed: "), name
            tried.add(name)
    assert len(tried) >= 3


@sample(6)
@pytest.mark.parametrize("name", JUMPS)
def test_antiderivatives_that_jump_are_noticed_though_c_jumps_with_them(name):
    """The derivative of what is added is 0: only a walk over the expression sees that it is not constant."""
    page = ss.derive("0.3 - 0.1*exp(-v)").certificate()
    added = JUMPS[name]
    edited = page.replace("\nparts1 = ", f"\naddition = {added}\nA1_0 += addition\nparts1 = ")
    by_c = "c -= Rational(1, 10) * N * (addition.subs(v, 2 * V) - addition.subs(v, 0))"
    edited = edited.replace("\nclaims.append", f"\n{by_c}\nclaims.append")
    assert edited.count("addition") == 4
    assert outcome(edited).startswith("failed: ")


def test_what_is_printed_is_what_was_checked():
    """Text that an edit may change is not printed: a docstring, a comment, the name of a law."""
    page = ss.derive("mu_s - 0.1*v").certificate()
    edited = page.replace("mu_s - v/10, least_squares", "mu_s - 2.57*v, least_squares")
    assert edited != page
    printed = outcome(page)
    assert outcome(edited) == printed
    assert "2.57" not in printed
    assert printed.splitlines()[1] == "for mu(v) = mu_s - v/10"


def test_exceptional_parameters_and_jumps_are_named():
    form = ss.derive("mu_0/((1 + v/p)*(1 + v/q))")
    assert "where p - q = 0, by continuity: " in outcome(form.certificate())
    form = ss.derive("Piecewise((mu_0, v < v_k), (mu_1, True))")
    printed = outcome(form.certificate())
    assert "mu jumps at v = v_k, by -mu_0 + mu_1: mu' has there this jump times a delta function" in printed
    assert "c has the term -N w(v_k/V - 1) (-mu_0 + mu_1)/V where 0 < v_k < 2 V" in printed


KINDS = {
    "law": ("mu = ",),
    "formula": ("c = ",),
    "weight": ("w = ",),
    "profile": ("g1",),
    "antiderivative": ("A1",),
    "average": ("y1",),
    "function": ("    besseli", "    exp_V", "    root", "roots1"),
}
"""What may be changed at random, by what its lines begin with."""
OPPOSITE = {ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult}


def changed(line, rng):
    """Return a line with another sign, number or operation at a random place; the same line where it has none."""
    name, mark, value = line.partition(": " if line.startswith("    ") else " = ")
    tree = ast.parse(value.rstrip().rstrip(","), mode="eval")
    nodes = list(ast.walk(tree))
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
    return f"{name}{mark}{ast.unparse(tree)}{',' if line.startswith('    ') else ''}"


def mutants(page, kind, count, rng):
    """Return some pages with one line of a kind changed."""
    head, mark, tail = page.partition("# == CHECKER")
    lines = head.splitlines()
    places = [i for i, line in enumerate(lines) if line.startswith(KINDS[kind])]
    found = set()
    for _ in range(20 * count):
        if not places or len(found) == count:
            break
        i = rng.choice(places)
        bare = lines[i].partition("  #")[0]
        new = changed(bare, rng)
        if ast.unparse(ast.parse(f"{{{new}}}" if new.startswith("    ") else new)) != ast.unparse(
            ast.parse(f"{{{bare}}}" if bare.startswith("    ") else bare)
        ):
            found.add("\n".join([*lines[:i], new, *lines[i + 1 :]]) + f"\n{mark}{tail}")
    return sorted(found)


@sweep(
    ("law", "criterion"),
    [("exponential", "least_squares"), ("exponential", "harmonic")],
    ("exponential", "harmonic"),
)
def test_whatever_is_changed_is_noticed(law, criterion):
    rng, page = random.Random(1), ss.derive(law, criterion).certificate()
    kinds = [kind for kind in KINDS if mutants(page, kind, 1, rng)]
    assert len(kinds) >= 4
    for kind in kinds:
        for mutant in mutants(page, kind, 2, rng):
            assert outcome(mutant).startswith("failed: "), kind


@pytest.mark.thorough
@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_pages_of_the_derivations_prove_without_the_package(page):
    assert run(page).stdout.startswith("proved: ")


@pytest.mark.thorough
@pytest.mark.parametrize(("law", "criterion"), CATALOGUE)
def test_the_catalogue_leaves_with_its_proofs(law, criterion):
    try:
        page = ss.derive(law, criterion).certificate()
    except ss.NoClosedForm:
        return
    assert outcome(page).startswith("proved: ")
    rng = random.Random(law)
    for kind in KINDS:
        for mutant in mutants(page, kind, 2, rng):
            assert outcome(mutant).startswith("failed: "), kind


PROFILES = (
    "exp(-v/p)", "v*exp(-q*v)", "exp(-(v/p)^2)", "1/(1 + v/p)", "1/(1 + (v/q)^2)", "(1 + v/p)^(-3)",
    "log(1 + q*v)", "tanh(q*v)", "sech(v/p)", "atan(q*v)", "asinh(v/p)", "sqrt(v)", "v^3", "v^1.5",
    "sqrt(1 + v/p)", "cos(q*v)", "erf(q*v)", "v*atan(v/p)", "1/sqrt(1 + (v/p)^2)", "Max(p - v, 0)",
    "Min(v, p)", "Min(v/q, 1)*exp(-v)", "log(1 + v^2)", "1/((1 + v/p)*(1 + v/q))", "v^(-1/3)", "(1 + v)^(-p)",
    "Max(p - q*v, 0.1)", "1/((1 + v)*(2 + v)*(3 + v))", "v^(1/3)",
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
    page = form.certificate()
    assert outcome(page).startswith("proved: ")
    for kind in ("law", "formula", "average", "function"):
        for mutant in mutants(page, kind, 1, rng):
            assert outcome(mutant).startswith("failed: "), kind


def test_the_limit_at_rest_is_that_of_c():
    printed = outcome(ss.derive("a + b*v + d*exp(-v)", "harmonic").certificate())
    assert printed.splitlines()[-1] == "as V falls to 0, c tends to -N mu'(0) = -N*(b - d)"
    printed = outcome(ss.derive("0.5 - 0.1*sqrt(v)").certificate())
    assert "as V falls" not in printed


@sweep(
    "text",
    ["0.2 + 0.1*(coth(v) - 1/v)", "0.5 - 0.3*Min(v, v_k)*exp(-v)", "mu_0", "0.4 - 0.1*v^(-0.3)"],
    "0.2 + 0.1*(coth(v) - 1/v)", "mu_0",
)  # fmt: skip
def test_what_cancels_at_rest_or_meets_a_kink_is_proved(text):
    assert outcome(ss.derive(text).certificate()).startswith("proved: ")


@sweep("criterion", ["least_squares", "harmonic"], "harmonic")
def test_names_of_parameters_mean_nothing_else_in_a_script(criterion):
    form = ss.derive("gamma + F1*exp(-v/sum) + n*v + theta*v**2 - lambda1*s + check*prove", criterion)
    assert outcome(form.certificate()).startswith("proved: ")


def test_what_is_not_proved_is_named():
    page = ss.derive("mu_s - a*Min(v, v_k)", "harmonic").certificate()
    assert page.splitlines()[0].startswith('"""Not proved here')
    printed = outcome(page)
    assert printed.startswith("compared at points only: ")
    assert "not proved, and compared at points: the average of Piecewise" in printed


def test_a_sensitivity_starts_from_the_law_that_it_is_of():
    page = ss.derive("exponential").sensitivity("alpha").certificate()
    assert "mu is the derivative by alpha of " in outcome(page)
    (law,) = [line for line in page.splitlines() if line.startswith("law = mu_m")]
    assert (
        outcome(page.replace(law, law.replace("alpha", "2 * alpha")))
        == "failed: mu is not the derivative of the law"
    )


def test_the_verdict_says_which_certificate_has_run():
    form = ss.derive("linear", "equilibrium")
    assert form.verdict.evidence.endswith("its page in SymPy and its script in Coq are run every night")
    assert ss.derive("exponential", "harmonic").verdict.evidence.endswith("its page in SymPy is run every night")
    own = ss.derive("mu_s - 0.07*v", "equilibrium")
    assert own.verdict.evidence.endswith("; no certificate was run here")
    assert own.verify() == own.verdict
    assert own.verdict.evidence.endswith("; its page in SymPy has proved it here")
    assert "has proved it here" in ss.export_latex(own)


@pytest.mark.parametrize(
    ("page", "said"),
    [
        ("raise ValueError('c is not the sum of the averages')", "stops here: ValueError: c is not the sum"),
        ("print('compared at points only: c = 1')", "has compared it here, at points only"),
        ("import stickslip_sym", "stops here: ModuleNotFoundError"),
    ],
)
def test_a_formula_whose_certificate_proves_nothing_is_checked_at_most(page, said, monkeypatch):
    form = ss.derive("mu_s - 0.07*v", "equilibrium")
    monkeypatch.setattr(type(form), "certificate", lambda *_: page)
    assert form.verify().status is ss.Status.CHECKED
    assert said in form.verdict.evidence


def test_a_certificate_that_takes_too_long_says_nothing_of_the_formula(monkeypatch):
    form = ss.derive("mu_s - 0.07*v", "equilibrium")
    monkeypatch.setattr(type(form), "certificate", lambda *_: "import time; time.sleep(60)")
    with pytest.raises(ss.OutOfTime, match="before the certificate had run"):
        form.verify(time_limit=0.2)
    assert form.verdict.status is ss.Status.PROVED
    assert form.verdict.evidence.endswith("no certificate was run here")


@sweep(
    ("law", "criterion"),
    [
        ("mu_0 + a*Min(v, p)*Min(v, q)", "least_squares"),
        ("mu_0 + a*Min(v, p)*Max(v - q, 0)", "least_squares"),
        ("Max(mu_0 - a*v, 0.1)", "least_squares"),
        ("mu_0 + a*Min(v, p)*Min(v, q)", "equilibrium"),
    ],
    ("Max(mu_0 - a*v, 0.1)", "least_squares"),
    ("mu_0 + a*Min(v, p)*Min(v, q)", "equilibrium"),
)
def test_kinks_in_unknown_order_are_proved_in_each_order(law, criterion):
    assert outcome(ss.derive(law, criterion).certificate()).startswith("proved: ")
