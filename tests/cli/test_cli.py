"""The command line, run as a user runs it."""

import re
import signal
import time
from pathlib import Path

import pytest
from commands import inside, shell, started, stickslip
from systems import FOLDER_OPENED, needs_posix_shell

from stickslip_sym import Status, load
from stickslip_sym.cli import program
from stickslip_sym.cli.shared import law
from stickslip_sym.formula.derivation.steps import Derivation


def test_laws_lists_the_catalogue():
    done = stickslip("laws")
    assert done.returncode == 0
    assert re.search(r"^exponential +mu_m \+ \(mu_s - mu_m\)\*exp\(-alpha\*v\) +mu_s = 0.5", done.stdout, re.M)
    assert done.stderr == ""


@pytest.mark.parametrize(
    ("name", "value"), [("exponential", "2.5459496029051"), ("polynomial", "3.0481071428571")]
)
def test_derive_ends_with_a_table_of_three_methods(name, value):
    done = inside("derive", name)
    assert done.returncode == 0, done.stderr
    assert f"ClosedForm: {name}, least_squares, PROVED" in done.stdout
    *_, closed, quadrature, threshold = (re.split(r"\s{2,}", line) for line in done.stdout.splitlines())
    assert [closed[0], quadrature[0], threshold[0]] == [
        "closed form",
        "quadrature, 50 digits",
        "event-driven threshold",
    ]
    assert closed[1].startswith(value)
    assert float(quadrature[2]) < 1e-48
    assert 0.003 < float(threshold[2]) < 0.02
    assert all(re.fullmatch(r"[\d.]+ (us|ms|s)", row[3]) for row in (closed, quadrature, threshold))


def test_derive_takes_values_a_criterion_and_steps():
    done = inside("derive", "exponential", "-p", "alpha=1", "-V", "1/4", "--criterion", "equilibrium", "--steps")
    assert done.returncode == 0, done.stderr
    assert "1. take the slope at the belt speed" in done.stdout
    assert "PROVED: the difference reduces to 0" in done.stdout
    assert re.search(r"closed form +2\.2920107", done.stdout)


def test_derive_takes_a_formula():
    done = inside("derive", "a - b*v")
    assert done.returncode == 0
    assert "c = N*b" in done.stdout
    assert done.stderr == "\nno value for a, b: give -p a=... for a table of values\n"


def test_laws_tells_all_about_one():
    done = inside("laws", "hyperbolic")
    assert done.returncode == 0, done.stderr
    assert done.stdout.startswith("hyperbolic: mu(v) = mu_m + (mu_s - mu_m)/(v/v_s + 1)\n")
    assert re.search(r"^v_s +0\.5 +m/s +Stribeck speed", done.stdout, re.M)
    assert "source: Bochet 1861" in done.stdout
    found = re.findall(r"^(\w+), (PROVED|CHECKED)\n  c = ", done.stdout, re.M)
    assert found == [("equilibrium", "PROVED"), ("least_squares", "PROVED"), ("harmonic", "PROVED")]


def test_derive_takes_all_criteria():
    done = inside("derive", "polynomial", "--criterion", "all")
    assert done.returncode == 0, done.stderr
    names = re.findall(r"ClosedForm: polynomial, (\w+), ", done.stdout)
    assert names == ["equilibrium", "least_squares", "harmonic"]
    assert done.stdout.count("event-driven threshold") == 3


def test_without_a_closed_form_quadrature_serves():
    done = inside("derive", "andersson", "--time-limit", "4")
    assert done.returncode == 1
    assert "no closed form: andersson, least_squares" in done.stdout
    assert re.search(r"quadrature, 50 digits +2\.15420088", done.stdout)
    assert "the term (mu_p - mu_k)*exp(-(v/v_s)**delta)*tanh(v/v_0) resisted" in done.stderr
    assert re.search(r"found nothing in its [12] s|was not asked, as there was no time", done.stderr)


def test_derive_reads_measured_points_and_keeps_the_form(tmp_path):
    (tmp_path / "pin.csv").write_text("v,mu\n0,0.5\n0.1,0.4\n0.3,0.3\n1.2,0.25\n")
    done = inside("derive", "--from-csv", "pin.csv", "--save", "pin.json", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "ClosedForm: pin, least_squares, PROVED" in done.stdout
    form = load(tmp_path / "pin.json", verify=True)
    assert form.verdict.status is Status.PROVED
    assert f"{form(V=0.5, N=9.81):.9f}"[:8] in done.stdout
    beyond = inside("derive", "--from-csv", "pin.csv", "-V", "0.7", cwd=tmp_path)
    assert (beyond.returncode, beyond.stdout) == (2, "")
    assert "measured up to v = 1.2 m/s, and its value at 1.4 m/s is needed" in beyond.stderr
    held = inside("derive", "--from-csv", "pin.csv", "-V", "0.7", "--extrapolate", cwd=tmp_path)
    assert held.returncode == 0, held.stderr


def _is_gone(child):
    """Whether a process is no more, or dead and not yet buried by the system."""
    try:
        return "(zombie)" in Path(f"/proc/{child}/status").read_text()
    except (FileNotFoundError, ProcessLookupError):
        return True


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs /proc to see a process's children")
def test_ctrl_c_leaves_nothing_behind(tmp_path):
    """Interrupted while SymPy's integrator runs in its own process."""
    line = ["derive", "andersson", "--save", "kept.json", "--latex", "kept.tex"]
    with started(*line, cwd=tmp_path) as process:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        deadline = time.monotonic() + 60
        while not (integrators := children.read_text().split()) and time.monotonic() < deadline:
            time.sleep(0.05)
        assert integrators
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30)
    assert (process.returncode, out, err.strip()) == (130, "", "")
    # A child that was only just being started ends when it finds that nobody is there.
    while not all(map(_is_gone, integrators)) and time.monotonic() < deadline:
        time.sleep(0.05)
    assert all(map(_is_gone, integrators))
    assert list(tmp_path.iterdir()) == []


def test_latex_file(tmp_path):
    done = inside("derive", "polynomial", "--latex", "form.tex", "--steps", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    text = (tmp_path / "form.tex").read_text()
    assert "\\label{eq:polynomial-least_squares}\n  c = \\frac{N (\\mu_{\\mathrm{s}} - \\mu_{\\mathrm{m}})" in text
    assert text.count("\\begin{equation*}") == text.count("\n% PROVED") >= 3


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["derive", "expnential"], "there is no law 'expnential' (did you mean 'exponential'?)"),
        (["derive", "exponential", "--criterion", "harmonics"], "there is no criterion 'harmonics'"),
        (
            ["derive", "exponential", "--latex", "missing/form.tex"],
            f"cannot write {str(Path('missing/form.tex'))!r}: there is no folder",
        ),
        (["derive", "exponential", "--latex", "."], f"cannot write '.': {FOLDER_OPENED}"),
        (
            ["derive", "exponential", "-p", "alpha=1", "-p", "alpha=2"],
            "alpha is given twice, as 1 and 2; give it once",
        ),
        (
            ["derive", "exponential", "--criterion", "harmonic", "--criterion", "equilibrium"],
            "--criterion is given twice; give it once",
        ),
        (
            ["derive", "exponential", "--latex", "a", "--latex", "b"],
            "--latex is given twice; give it once",
        ),
        (["derive", "exponential", "-V", "1e-400"], "V is below what double precision can hold"),
        (["derive", "exponential", "-V", "1e300"], "V is too large; give a size from 1e-20 to 1e+20"),
        (["derive", "exponential", "-m", "1e-30"], "m is too small"),
        (["derive", "exponential", "-p", "alpha=1e4000"], "alpha is beyond what double precision can hold"),
        (["derive", "exponential", "-V", "1", "-V", "2"], "-V is given twice; give it once"),
        (["derive", "exponential", "-p", "alpha=fast"], "alpha = 'fast' is not a number; write it like"),
        (["derive", "exponential", "-p", "alpha"], "'alpha' is not NAME=VALUE; write for example"),
        (["derive", "exponential", "-p", "beta=1"], "has no parameter 'beta'"),
        (["derive", "exponential", "-V", "0,5"], "V = '0,5' is not a number"),
        (["derive", "exponential", "-V", "-1"], "V = -1 must be positive: it is the belt speed"),
        (["derive", "exponential", "-m", "0"], "m = 0 must be positive"),
        (["derive"], "no law: give a name (see: stickslip laws), a formula in v, or --from-csv FILE"),
        (["derive", "linear", "--from-csv", "a.csv"], "the law is given twice, as 'linear' and by --from-csv"),
        (["derive", "linear", "--extrapolate"], "--extrapolate belongs to --from-csv"),
        (["derive", "--from-csv", "a.csv"], "cannot read 'a.csv': No such file"),
        (["derive", "linear", "--criterion", "all", "--save", "f"], "--save keeps one closed form; name one"),
        (["laws", "expnential"], "there is no law 'expnential' (did you mean 'exponential'?)"),
        (["derive", "exponential", "--stepps"], "No such option"),
        (["derives"], "No such command 'derives'"),
    ],
)
def test_bad_input_is_one_or_two_lines_on_stderr(arguments, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.argv", ["stickslip", *arguments])
    with pytest.raises(SystemExit) as end:
        program.main()
    printed = capsys.readouterr()
    assert end.value.code == 2
    assert printed.out == ""
    assert printed.err.startswith("error: ")
    assert message in printed.err
    assert len(printed.err.splitlines()) <= 2
    assert list(tmp_path.iterdir()) == []


def test_latex_of_a_derivation_escapes_its_words():
    derivation = Derivation("d", r"a\b {c}_d^e ~ 5% & #1 $")
    expected = r"\paragraph{a\textbackslash{}b \{$c$\}\_d\textasciicircum{}e \textasciitilde{} 5\% \& \#1 \$.}"
    assert derivation.latex() == expected + "\n"


def test_no_closed_form_has_its_own_exit_code():
    done = inside("derive", "tanh(exp(a*v))")
    assert done.returncode == 1
    assert done.stderr.startswith("error: ")
    assert len(done.stderr.splitlines()) <= 2


def test_the_bare_command_prints_its_help():
    done = inside()
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == inside("--help").stdout
    assert "How much damping does a mass" in done.stdout


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize("arguments", ["laws", "--help"])
def test_a_full_disk_is_one_line(arguments, tmp_path):
    done = shell(f"$RUN {arguments} > /dev/full", tmp_path)
    assert done.returncode == 1
    assert done.stderr == "error: cannot write the output: No space left on device\n"


@needs_posix_shell
def test_a_closed_pipe_ends_quietly(tmp_path):
    done = shell("$RUN laws | head -0", tmp_path)
    assert (done.stdout, done.stderr) == ("", "")


def test_an_interrupt_ends_quietly(monkeypatch, capsys):
    def interrupt(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr(law.LawOptions, "bound", interrupt)
    monkeypatch.setattr("sys.argv", ["stickslip", "derive", "linear"])
    with pytest.raises(SystemExit) as end:
        program.main()
    assert end.value.code == 130
    assert capsys.readouterr().err.strip() == ""


@needs_posix_shell
@pytest.mark.parametrize("sink", ["| cat", "> out.txt; code=$?; cat out.txt; exit $code"])
def test_latex_to_standard_output_loses_nothing(sink, tmp_path):
    done = shell(f"$RUN derive coulomb --latex /dev/stdout {sink}", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.startswith("% ClosedForm: coulomb")
    assert "event-driven threshold" in done.stdout


def test_help_of_every_command_has_an_example():
    for command in ("laws", "derive", "damping", "tradeoff"):
        done = inside(command, "--help")
        assert done.returncode == 0
        assert "Example: stickslip " in done.stdout
