"""Certificates in python-flint run without the package, prove what was proved, and notice what is changed."""

import random
import re
import subprocess
import sys

import pytest

import stickslip_sym as ss
from support.commands import inside
from support.sweeps import sample, sweep

AT = {"V": "0.5", "N": "9.81", "m": 1, "k": 100}
LAWS = {
    "exponential": ss.laws.exponential.typical(),
    "static": ss.laws.exponential.typical().with_static("0.6"),
    "tanh": ss.laws.tanh.typical(),
    "rational": ss.laws.rational.typical(),
    "kinks": ss.FrictionLaw("0.5-0.3*Min(v,0.4)+0.1*Max(v-0.42,0)"),
    "points": ss.FrictionLaw.from_samples([0, 0.1, 0.3, 0.6, 1, 1.5, 3], [0.5, 0.45, 0.4, 0.3, 0.29, 0.3, 0.35]),
    "names": ss.FrictionLaw("exp0 + box*exp(-rate*v)").bind(exp0="0.2", box="0.3", rate=3),
    "root": ss.FrictionLaw("0.5-0.1*sqrt(v)"),
}
BLOCKED = "import sys; sys.modules['stickslip_sym'] = sys.modules['sympy'] = sys.modules['mpmath'] = None\n"
BLOCKED += "exec(sys.stdin.read(), {})"


def run(script, *options):
    """Run a script where nothing but python-flint can be imported."""
    command = [sys.executable, "-I", *options, "-c", BLOCKED]
    return subprocess.run(command, input=script, capture_output=True, text=True, check=False)


def theorem_of(name, **more):
    return ss.pure_slip_damping(LAWS[name], **AT | more, method="proof", rtol=1e-8).theorem


@sample(2)
@sweep("name", list(LAWS), "exponential", "kinks", "names")
def test_the_script_of_a_threshold_proves_it(name):
    theorem = theorem_of(name)
    done = run(theorem.certificate())
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("proved: " + theorem.statement[:40])


@pytest.mark.thorough
def test_a_steep_tanh_loses_no_digits():
    """Far along tanh(50 w) a series by exp(2 z) loses half its bits, and boxes grow too wide."""
    law = ss.FrictionLaw("(0.2 + 0.3*exp(-3*v))*tanh(v/v_0)").bind(v_0="0.01").with_static("0.5")
    theorem = ss.pure_slip_damping(law, **AT, method="proof", rtol=1e-6).theorem
    most = 2 * max(theorem.below.steps, theorem.above.steps)
    script = theorem.certificate().replace("range(20_000)", f"range({most})")
    assert run(script).returncode == 0
    right, wrong = "2 / (1 + (-2 * z).exp()) - 1", "1 - 2 / ((2 * z).exp() + 1)"
    assert right in script
    assert "NotProved: the slip creeps" in run(script.replace(right, wrong)).stderr


def test_a_stiff_slip_has_as_many_bits_as_its_boxes_lose():
    law = ss.FrictionLaw("0.3-0.1*v")
    theorem = ss.pure_slip_damping(law, **AT | {"N": 600}, method="proof", rtol=1e-8).theorem
    assert run(theorem.certificate()).stdout.startswith("proved: ")


def test_what_is_printed_is_what_was_used():
    """A threshold and a law in the words of a page are text; what is printed comes from what was computed with."""
    script = theorem_of("exponential").certificate()
    words, mark, rest = script.partition("from decimal")
    edited = words.replace("2.573078", "1.573078").replace("exp(-alpha*v)", "exp(-2*alpha*v)") + mark + rest
    assert edited.count("-2*alpha*v") == 1
    printed = run(edited).stdout
    assert "2.573078" in printed
    assert "1.573078" not in printed
    assert "mu(v) = mu_m + (-mu_m + mu_s) * (-alpha * v).exp()\nmu_s = 1/2, mu_m = 1/5, alpha = 3\n" in printed


def test_pages_of_balls_have_three_parts_and_one_checker():
    thresholds = [theorem_of(name).certificate() for name in ("exponential", "root")]
    enclosed = [("exponential", "least_squares"), ("root", "harmonic"), ("kinks", "equilibrium")]
    enclosures = [ss.enclose(LAWS[name], kind, V="0.45", N="9.81").certificate() for name, kind in enclosed]
    for pages in (thresholds, enclosures):
        assert len({page[page.index("# == CHECKER") :] for page in pages}) == 1
        for page in pages:
            places = [page.index(f"# == {part}") for part in ("STATEMENT", "DATA", "CHECKER")]
            assert places == sorted(places)


EDITS = {
    "WEIGHT = [": "WEIGHT = [fmpq(1), ",
    "c_low = fmpq(": "c_low = 2 * fmpq(",
    '"fmpq(2, 5)"': '"fmpq(3, 5)"',
    'ENDS = ["0", ': 'ENDS = ["1", ',
    ", None]": ', "fmpq(43, 100)"]',
    "BITS = ": "BITS = 20 or ",
    'alpha": fmpq(3)': 'alpha": fmpq(4)',
    "(-alpha * v)": "(alpha * v)",
    "fmpq(1, 2) - 3 * v / 10": "fmpq(1, 2) - 3 * v / 11",
}
"""Edits of the statement and the data of pages of balls."""


@sweep("name", ["exponential", "kinks"], "kinks")
def test_every_edit_of_an_enclosure_is_noticed(name):
    page = ss.enclose(LAWS[name], V="0.45", N="9.81", digits=25).certificate()
    head, mark, checker = page.partition("# == CHECKER")
    edited = [head.replace(old, new) for old, new in EDITS.items() if old in head]
    assert len(edited) >= 4
    for text in edited:
        done = run(text + mark + checker, "-O")
        assert done.returncode != 0
        assert "proved" not in done.stdout


def test_pages_notice_under_optimisation_too():
    enclosed = ss.enclose(LAWS["exponential"], V="0.45", N="9.81", digits=25).certificate()
    moved = enclosed.replace("c_low = fmpq(", "c_low = 2 * fmpq(")
    turned = theorem_of("exponential").certificate().replace("- c * w)", "+ c * w)")
    for script in (moved, turned):
        assert "NotProved" in run(script, "-O").stderr


def changed(script, rng):
    """Return a script with a digit of a number, or a sign, of the law or of its values changed."""
    head, tail = script.split("MU = [", 1)
    law, rest = tail.split("\n]\n", 1)
    (values,) = re.findall(r"(?<=\nV, N, m, k = ).*", head)
    spots = [match.start() for match in re.finditer(r"\d(?=[,)])", values)]
    spot = rng.choice(spots)
    digit = str((int(values[spot]) + rng.randrange(1, 9)) % 10)
    other = values[:spot] + digit + values[spot + 1 :]
    yield head.replace(values, other) + "MU = [" + tail, other
    yield head + "MU = [" + law.replace("(-alpha", "(alpha", 1) + "\n]\n" + rest, "the sign of an exponent"
    yield script.replace("c_low, c_high = ", "c_high, c_low = "), "both ends turned round"
    yield script.replace("- c * w", "+ c * w"), "the sign of the damping"
    yield script.replace("qs.append(((i == 1) - ws[i - 1]) / i)", "qs.append(ws[i - 1] / i)"), "the rate of q"


def test_a_changed_digit_sign_or_end_is_noticed():
    script = theorem_of("exponential").certificate()
    for mutant, what in changed(script, random.Random(1)):
        assert mutant != script, what
        assert run(mutant).returncode != 0, what


@sweep(
    ("name", "criterion"),
    [(name, criterion) for name in LAWS for criterion in ("equilibrium", "least_squares", "harmonic")],
    ("kinks", "harmonic"), ("root", "least_squares"), ("points", "equilibrium"),
)  # fmt: skip
def test_the_script_of_a_criterion_encloses_it(name, criterion):
    enclosed = ss.enclose(LAWS[name], criterion, V="0.45", N="9.81", digits=25)
    script = enclosed.certificate()
    done = run(script)
    assert done.returncode == 0, done.stderr
    assert str(enclosed) in done.stdout
    moved = script.replace(
        f"fmpq({enclosed.high.numerator}, ", f"fmpq({2 * enclosed.low.numerator - enclosed.high.numerator}, "
    )
    assert "NotProved: c_high" in run(moved).stderr


def test_what_has_no_certificate_says_why():
    with pytest.raises(ss.InputError, match="certain digit"):
        ss.enclose("0.3", V=1, N=1).certificate()
    law = ss.FrictionLaw("0.2 + 0.3*exp(-v)*(coth(v) - 1/v)")
    with pytest.raises(ss.InputError, match="Langevin, for which"):
        ss.enclose(law, V=1, N=1).certificate()


def test_a_certificate_is_written_with_a_proof_only(tmp_path):
    target = tmp_path / "proof.py"
    at = [arg for name, value in AT.items() for arg in (f"-{name}", str(value))]
    done = inside("damping", "exponential", *at, "--certificate", str(target))
    assert "--method proof" in done.stderr
    assert not target.exists()
    assert inside("damping", "exponential", *at, "--method", "proof", "--certificate", str(target)).returncode == 0
    assert run(target.read_text()).returncode == 0
