"""What an error advises is data: Python words it with keywords, the command line with options that exist."""

import ast
import inspect
import re
from pathlib import Path

import click
import pytest

import stickslip_sym as ss
from stickslip_sym.cli.program import program
from stickslip_sym.cli.wording import option_wording
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.core.remedies import Argument

AT = {"V": 0.5, "N": 9.81, "m": 1, "k": 100}
KINKED, LINEAR = ss.FrictionLaw("Abs(v - 0.3)"), ss.laws.linear.typical()
OPEN = ss.FrictionLaw("a - b*v")
OSC = ss.Oscillator(**AT, c=1)
FILES = {
    "plain.csv": "v [m/s],mu\n0,0.5\n0.1,0.4\n0.3,0.3\n1.2,0.25\n",
    "late.csv": "v [m/s],mu\n0.1,0.5\n0.2,0.4\n0.3,0.3\n1.2,0.25\n",
    "turns.csv": "v [rpm],mu\n1,0.5\n",
    "bad.csv": "v,mu\n0.1,0.5\n0.2,n/a\n0.3,0.4\n0.4,0.3\n",
    "twice.csv": "v [m/s],mu,COF\n0.1,0.5,0.4\n0.2,0.4,0.3\n",
    "unit.csv": "speed,mu\n0.1,0.5\n",
    "rolling.csv": "speed [mm/s],SRR [%],mu\n1,50,0.1\n2,50,0.1\n",
    "bare.csv": "what is this\n",
    "long.csv": "v [m/s],mu\n" + "\n".join(f"{0.01 * i},{0.5 - 0.001 * i}" for i in range(70)),
    "off.csv": "v [m/s],mu\n" + "\n".join(f"{0.01 * i},{0.9 if i == 30 else 0.5 - 0.001 * i}" for i in range(60)),
}


def damping(law=OPEN, **more):
    return ss.pure_slip_damping(law, **AT | more)


def read(name, **how):
    return ss.read_measurements(name, **how)


CASES = [
    (lambda: damping(), "damping a-b*v"),
    (lambda: ss.FrictionLaw("a+b*v").bind(b=-1), "derive a+b*v -p b=-1"),
    (lambda: ss.simulate(OPEN, OSC, t_end=1), "simulate a-b*v -c 1"),
    (lambda: ss.motion_map(OPEN, x=("V", [1]), y=("c", [1]), N=1, m=1, k=1), "map a-b*v --x V=1:1:1 --y c=1:1:1"),
    (lambda: ss.tradeoff(OPEN), "tradeoff a-b*v"),
    (lambda: ss.critical(OPEN, "V", c=1, N=9.81, m=1, k=100), "critical a-b*v --of V -c 1"),
    (lambda: damping(KINKED, method="orbit"), "damping Abs(v-0.3) --method orbit"),
    (lambda: damping(KINKED, method="second_order"), "damping Abs(v-0.3) --method second_order"),
    (lambda: damping(LINEAR, rtol=1e-30), "damping linear --rtol 1e-30"),
    (lambda: damping(ss.laws.exponential.typical(), rtol=1e-17, method="orbit"),
     "damping exponential --rtol 1e-17 --method orbit"),
    (lambda: damping(LINEAR, time_limit=-1), "damping linear --time-limit -1"),
    (lambda: ss.simulate(LINEAR, OSC, t_end=1, time_limit=-2), "simulate linear --time-limit -2"),
    (lambda: ss.simulate(LINEAR, OSC, t_end=1, rtol=1), "simulate linear --rtol 1"),
    (lambda: damping(LINEAR, V="0.5 kg"), "damping linear -V 0.5kg"),
    (lambda: ss.laws.linear.typical(a_1="0.3 kg"), "damping linear -p a_1=0.3kg"),
    (lambda: ss.critical(LINEAR, "m", c=1, V=1, N=1, method="harmonic"),
     "critical linear --of m -c 1 --method harmonic"),
    (lambda: ss.critical(ss.FrictionLaw("0.4 - b*v^3").bind(b=0), "b", c=1, **AT),
     "critical 0.4-b*v^3 --of b -c 1 -p b=0"),
    (lambda: ss.critical(LINEAR, "V", c=1, N=9, m=1, k=1, rtol=0), "critical linear --of V -c 1 --rtol 0"),
    (lambda: ss.FrictionLaw("0.5 - speed*0.1"), "derive 0.5-speed*0.1"),
    (lambda: ss.FrictionLaw("pi_*v"), "derive pi_*v"),
    (lambda: ss.FrictionLaw("Piecewise((0.6, v <= 0), (0.4, True))"),
     "derive Piecewise((0.6,v<=0),(0.4,True))"),
    (lambda: ss.FrictionLaw.from_csv("late.csv"), "damping --from-csv late.csv"),
    (lambda: ss.FrictionLaw.from_csv("plain.csv").mu(3.0), "derive --from-csv plain.csv -V 2"),
    (lambda: damping(ss.FrictionLaw.from_csv("plain.csv"), V=1.0), "damping --from-csv plain.csv -V 1"),
    (lambda: ss.FrictionLaw.from_csv("long.csv"), "damping --from-csv long.csv"),
    (lambda: read("turns.csv"), "read turns.csv"),
    (lambda: read("bad.csv"), "fit bad.csv"),
    (lambda: read("twice.csv"), "fit twice.csv"),
    (lambda: read("unit.csv"), "read unit.csv"),
    (lambda: read("rolling.csv"), "read rolling.csv"),
    (lambda: read("bare.csv"), "read bare.csv"),
    (lambda: read("off.csv"), "read off.csv"),
    (lambda: ss.fit(read("plain.csv"), laws="a*b*(1+v)"), "fit plain.csv --law a*b*(1+v)"),
    (lambda: ss.motion_map(LINEAR, x=("V", [1, 2]), y=("c", [1]), N=1, m=1, k=1, workers=0),
     "map linear --x V=1:2:2 --y c=1:1:1 --workers 0"),
    (lambda: ss.derive("exp(-(a*v)^b*sin(v))", time_limit=0), "derive exp(-(a*v)^b*sin(v)) --time-limit 0"),
]  # fmt: skip


@pytest.fixture
def files(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, text in FILES.items():
        (tmp_path / name).write_text(text)


def keywords():
    """Return the names of arguments of what is public, and of methods of it."""
    public = [getattr(ss, name) for name in ss.__all__]
    methods = [getattr(kind, name) for kind in public if inspect.isclass(kind) for name in dir(kind)]
    called = [each for each in methods if inspect.isfunction(each) or inspect.ismethod(each)]
    called += [each for each in public if callable(each)]
    return {name for each in called for name in inspect.signature(each).parameters}


def foreign_to_python(message):
    """Return what in a message no user of Python can follow."""
    unbound = re.sub(r"law\.bind\((\w+=[^,)]+(, )?)+\)", "", message)
    unknown = set(re.findall(r"(?<![\w'])([A-Za-z_]\w*)=(?![=\s])", unbound)) - keywords()
    return unknown | set(re.findall(r"(?<![\w-])--?[A-Za-z][\w-]*|\bstickslip \w+", message))


def foreign_to_commands(command, message):
    """Return what in a message no user of a command can follow."""
    context, wrong = click.Context(program), set(re.findall(r"law\.bind|\w+\(\)|\w_\w+\(|\b\w+\.\w+\(", message))
    options = {name: {text for parameter in program.get_command(context, name).params for text in parameter.opts}
               for name in program.list_commands(context)}  # fmt: skip
    # Not "write the formula with -b", which is no option.
    for other, option in re.findall(
        r"(?:stickslip (\w+) (?:LAW )?)?(?<![\w-])(?<!with )(--?[A-Za-z][\w-]*)", message
    ):
        if option not in options.get(other or command, ()):
            wrong.add(f"{other} {option}")
    return wrong | set(
        re.findall(r"(?<!-p )(?<!--unit )(?<!--column )(?<![\w'])([A-Za-z_]\w*)=(?![=\s])", message)
    )


@pytest.mark.filterwarnings("ignore::stickslip_sym.core.errors.InputWarning")
@pytest.mark.parametrize(("call", "line"), CASES, ids=[line for _, line in CASES])
def test_remedies_exist_where_they_are_read(call, line, files, run):
    with pytest.raises(StickSlipError) as raised:
        call()
    message, words = str(raised.value), line.split()
    code, _, err = run(*words)
    assert code in (1, 2)
    assert raised.value.remedies
    assert foreign_to_python(message) == set()
    assert foreign_to_commands(words[0], err[err.index("error: ") :]) == set()
    assert message == str(raised.value)  # the words of the command line end with a command


def test_a_foreign_word_is_noticed():
    assert foreign_to_python("give --rtol 1") == {"--rtol"}
    assert foreign_to_python("give rtl=1") == {"rtl"}
    assert foreign_to_python("give rtol=1, or law.bind(alpha=2, b=...)") == set()
    assert foreign_to_commands("damping", "give rtol=1") == {"rtol"}
    assert foreign_to_commands("study", "try --method orbit") == {" --method"}
    assert foreign_to_commands("study", "try stickslip damping --method orbit, or -p a=1") == set()


def test_an_option_of_another_command_is_named_with_it():
    context = program.make_context("stickslip", ["study", "linear"])
    context.invoked_subcommand = "study"
    assert option_wording(Argument("method", "orbit"), context) == "stickslip damping --method orbit"
    assert option_wording(Argument("c"), context) == "-c ..."


def test_no_message_writes_an_argument_or_an_option_by_hand():
    """Outside of the commands neither stands in the text of a message: it would be the wrong one for the other."""
    python = r"(?<![\w'])[a-z_]{3,}=(?![=\s])|law\.bind|Parameter\(|\w\(\)"
    package, messages = Path(ss.__file__).parent, 0
    for path in package.rglob("*.py"):
        foreign = python if path.parent.name == "cli" else rf"{python}|(?<![\w-])--[a-z]|\bstickslip [a-z]"
        text = path.read_text()
        for node in ast.walk(ast.parse(text)) if any(f"{name}(" in text for name in RAISED) else ():
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") in RAISED:
                messages += 1
                text = " ".join(each for part in node.args for each in texts(part))
                assert not re.search(foreign, text), (path.name, text)
    assert messages > 300


def texts(node):
    """Yield the texts of a message, without those of remedies."""
    if isinstance(node, ast.Constant):
        yield str(node.value)
    elif not isinstance(node, ast.Call):
        for child in ast.iter_child_nodes(node):
            yield from texts(child)


RAISED = {"InputError", "InputWarning", "NoClosedForm", "NoThreshold", "NotConverged", "OutOfTime"}
