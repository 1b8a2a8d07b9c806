"""What a command is given: laws, values, files; what is refused, and in which words."""

import re
import shlex

import pytest

from support.commands import read_json

POINTS = "v [m/s],mu\n0,0.5\n0.1,0.4\n0.3,0.3\n1.2,0.25\n"
FORMULA = "a - b*v + d*v^2"
DESCRIBED = ["--static", "0.6", "--name", "pin", "--unit", "b=s/m", "--source", "bench 4", "-p", "a=0.5", "-p",
             "b=0.3", "-p", "d=0.1"]  # fmt: skip


@pytest.mark.parametrize("line", ["derive --criterion equilibrium", "damping --method equilibrium"])
def test_formula_is_described_wherever_it_is_a_law(line, run):
    code, out, err = run(*line.split(), FORMULA, *DESCRIBED, "--json")
    assert (code, err) == (0, "")
    law = read_json(out)["operating_point"]["law"]
    assert (law["name"], law["source"], law["parameters"]["b"]["unit"]) == ("pin", "bench 4", "s/m")
    assert law["static"] == 0.6


@pytest.mark.parametrize("line", ["damping --method equilibrium", "simulate --t-end 0.1"])
def test_measured_points_are_read(line, run, tmp_path):
    (tmp_path / "disc.csv").write_text(POINTS)
    line = [*line.split(), "--from-csv", "disc.csv", "--static", "0.6", "--json"]
    code, out, err = run(*line)
    code_of_read, preview, _ = run("read", "disc.csv")
    assert (code, code_of_read, err) == (0, 0, f"{preview}\n")
    understood = "4 rows, v in m/s, mu from column 2\n"
    assert read_json(out)["operating_point"]["law"]["name"] == "disc"
    (tmp_path / "disc.csv").write_text(POINTS.replace("\n0,", "\n0.01,"))
    code, out, err = run(*line)
    assert (code, read_json(out)["error"]["exit_code"]) == (2, 2)
    assert "add a point there, or hold the first coefficient below it: --extrapolate" in err
    code, out, err = run(*line, "--extrapolate")
    assert code == 0
    assert err.startswith(understood)
    assert "\n\nwarning: nothing was measured below v = 0.01 m/s" in err


REFUSED = [
    ("derive expnential", "there is no law 'expnential' (did you mean 'exponential'?)"),
    ("damping exponential -p alfa=3", "did you mean 'alpha'?"),
    ("derive exponential --latex missing/form.tex", "there is no folder 'missing'; make it first"),
    ("derive exponential -p alpha=1 -p alpha=2", "alpha is given twice, as 1 and 2; give it once"),
    ("simulate linear -V 1 -V2", "-V is given twice; give it once"),
    ("simulate linear --json --csv /dev/stdout", "--csv /dev/stdout and --json would print into each other"),
    ("derive exponential -V 1e-400", "V is too small; give a size from 1e-20 to 1e+20"),
    ("derive exponential -p alpha", "'alpha' is not NAME=VALUE; write for example"),
    ("derive", "no law: give a name (see: stickslip laws), a formula in v, or --from-csv FILE"),
    ("derive linear --from-csv a.csv", "the law is given twice, as 'linear' and by --from-csv"),
    ("derive --from-csv none.csv", "cannot read 'none.csv': No such file"),
    ("damping linear --metod orbit", "Did you mean one of: '--method'"),
    ("damping linear -v 1", "No such option '-v'; did you mean -V, the belt speed? See: stickslip damping --help"),
    ("critical exponential --of N", "critical values are computed at a given damping: add -c VALUE"),
    ("critical exponential --of alpha -c 1 --within 3", "is not LOW:HIGH"),
    ("critical exponential --of alpha -c 1 --rtol 0", "rtol = 0 is outside"),
    ("simulate exponential --x0 here", "x0 = 'here' is not a number"),
    ("simulate exponential --plot a.doc", "its ending is none of .svg, .png, .pdf"),
    *((f"map exponential --x {text} --y c=1:2:2", message) for text, message in (
        ("V=0.1:1", "--x 'V=0.1:1' is not NAME=START:STOP:COUNT"),
        ("V=nan:1:5", "the start of V = 'nan' is not a number"),
        ("V=0.1:1:1.5", "the count must be a whole number"),
        ("V=0.1:1:99999999", "a whole number from 1 to 1000000"),
        ("V=1:1:5", "the start must lie below the stop"),
    )),
    ("map exponential --x alpha=1:2:2 --y c=1:2:2 -p alpha=3", "alpha is an axis, and given by -p too"),
    ("damping a-b*v --unit b", "write for example --unit alpha=s/m"),
    # measurements
    ("study linear --fit disc.csv --from-csv disc.csv", "given twice, by --fit and by --from-csv"),
    ("study --fit disc.csv --static 0.7", "--static does nothing here"),
    ("fit disc.csv --law linear -p mu_s=0.5+/-0.1", "linear: mu_s is fixed with a standard error, which no fit"),
    ("study --fit bad.csv", "line 3, column 2, 'mu'"),
    ("fit bad.csv", "mend the row, begin it with #, or leave out rows like it: --leave-out"),
    ("damping --from-csv turns.csv", "give the radius of the track in m, like --radius"),
    ("study linear -o page.txt", "--output page.txt: its ending is none of .html, .htm, .xhtml"),
    ("study linear -c 1 --point ok.toml --point q/ok.toml", "several files of values are called 'ok'"),
    ("fit disc.csv --law linear -p beta=1", "no law that is fitted has a parameter 'beta'; leave -p beta=... out"),
    ("fit disc.csv --law a*b*(1+v)", "do not tell a and b apart; fix one: -p "),
    # in other words for Python's users
    ("damping a-b*v", "the law has no value for a, b; give it first: -p a=... -p b=..."),
    ("map a-b*v --x V=1:1:1 --y c=1:1:1", "make one an axis, or give it first: -p a=... -p b=..."),
    ("derive a+b*v -p b=-1", "if any sign is meant, write the formula with -b, and give a positive value"),
    ("damping Abs(v-0.3) --method orbit", "try --method simulation"),
    # options that would do nothing
    ("damping exponential --name q", "--name does nothing here"),
    ("damping exponential --unit alpha=s/m", "--unit does nothing here"),
    ("derive linear --extrapolate", "--extrapolate does nothing here"),
    ("export linear --c --latex", "--c --latex: an option is no name of a file; write --c FILE, or ./--latex"),
    ("tradeoff linear -c 1", "-c does nothing here"),
    ("critical linear --of N -c 1 -N 2", "-N does nothing here"),
    ("critical linear -c 1 --within 1:2", "--within does nothing here"),
    ("damping linear --all --method orbit", "--method does nothing here"),
    ("damping exponential --static 0.4", "the static coefficient 0.4 is below mu(0+) = 0.5"),
    # standard errors that would be dropped
    ("derive exponential -p mu_s=0.5+/-0.1", "derive takes no standard errors: leave +/- out of -p mu_s"),
    ("simulate exponential -V 0.5(1)", "simulate takes no standard errors: leave +/- out of -V"),
    ("map exponential -N 9+/-1 --x V=1:1:1 --y c=1:1:1", "map takes no standard errors: leave +/- out of -N"),
    # files of values
    ("damping --point none.toml", "cannot read 'none.toml'"),
    ("damping --point bad.toml", "there is no speed; a point has lines such as V = 0.5, for law"),
    ("damping --point broken.toml", "lines such as V = 0.5"),
    ("damping --point latin.toml", "latin.toml': 'utf-8' codec can't decode"),
    ("damping --point number.toml", "law is text, and parameters a table"),
    ("simulate --point ok.toml --point ok.toml", "simulate takes one --point; damping and study take several"),
    # files to write
    *((f"export {line}", message) for line, message in (
        ("exponential", "nothing to write"),
        ("--c x", "no law"), ("exponential --c x --c y", "--c is given twice"),
        ("exponential --c x --save ./x", "two outputs have the same file"),
        ("linear linear --c x", "'linear' is given twice"), ("linear --all --c x", "--all is every law already"),
        ("linear --c x --steps", "--steps does nothing here"),
        ("linear --latex x --symbol a_1=a+b", "is not one symbol"),
        ("exponential --latex x --symbol alfa=a", "did you mean 'alpha'"),
        ("linear --latex x --c nowhere/y", "cannot write 'nowhere/y'"),
    )),
]  # fmt: skip


@pytest.mark.parametrize(("line", "message"), REFUSED, ids=[line for line, _ in REFUSED])
def test_bad_input_is_a_line_on_stderr(line, message, run, tmp_path):
    files = {
        "disc.csv": POINTS, "bad.toml": "speed = 1\n", "broken.toml": "V: 1\n", "number.toml": "law = 3\n",
        "ok.toml": 'law = "linear"\n', "latin.toml": 'law = "µ"\n', "q/ok.toml": "V = 0.5\n",
        "turns.csv": "v [rpm],mu\n1,0.5\n", "bad.csv": "v,mu\n0.1,0.5\n0.2,n/a\n0.3,0.4\n0.4,0.3\n",
    }  # fmt: skip
    (tmp_path / "q").mkdir()
    for name, text in files.items():
        (tmp_path / name).write_text(text, encoding="latin-1")
    code, out, err = run(*line.split())
    assert code == 2
    assert "--json" in line or out == ""
    assert re.search("^error: ", err, re.M)
    assert message in err
    assert len(err.splitlines()) <= 3  # with a line on what was read, or one that points into a formula
    assert {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*.*")} == set(files)


def test_warning_is_a_line(run):
    code, _, err = run(*["damping", "a-b*v", "-p", "a=0.1", "-p", "b=0.5", "--all"])
    assert code == 0
    assert err.startswith("warning: mu = -0.4 is negative at the slip speed v = 1 m/s; ")
    assert len(err.splitlines()) == 1
    code, _, err = run(*["map", "a-b*v", "--x", "b=0.01:0.5:2", "--y", "c=9:9:1", "-p", "a=0.1"])
    assert (code, err.count("warning: mu = ")) == (0, 1)


@pytest.mark.parametrize("line", ["simulate coulomb --t-end 0.1 --csv a.out", "export coulomb --c a.out"])
def test_nothing_is_overwritten_unless_asked(line, run, tmp_path):
    path, words = tmp_path / "a.out", line.split()
    path.write_text(POINTS)
    code, out, err = run(*words)
    assert (code, out, path.read_text()) == (2, "", POINTS)
    assert f"'{path.name}' exists: name another file by --" in err
    assert "add --overwrite to replace it" in err
    assert run(*words, "--overwrite")[0] == 0
    assert path.read_bytes() != POINTS.encode()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("damping exponential -v 0.5", "did you mean -V, the belt speed?"),
        ("damping exponential -V '30 rpm' -N 9.81", "2 pi r n/60"),
    ],
)
def test_a_near_miss_names_what_is_understood(words, said, run):
    code, out, err = run(*shlex.split(words))
    assert (code, out) == (2, "")
    assert said in err


def test_a_standard_error_is_read_as_people_write_it(run):
    texts = [run("damping", "exponential", "-V", "0.5", "-N", "9.81", "-p", f"mu_s={text}")
             for text in ("0.5+-0.02", "0.5+/-0.02", "0.50(2)")]  # fmt: skip
    assert texts[0][0] == 0
    assert "0.172" in texts[0][1]
    assert len({out.replace("0.5+-0.02", "").replace("0.5+/-0.02", "").replace("0.50(2)", "")
                for _, out, _ in texts}) == 1  # fmt: skip


def test_a_converted_unit_is_shown_by_its_digits(run):
    assert "k = 17512.6835246 N/m" in run("damping", "linear", "-m", "1", "-k", "100 lbf/in")[1]
    assert "k = 1/3 N/m" in run("damping", "linear", "-m", "1", "-k", "1/3")[1]
