"""What a refusal advises, where no other test does it: carried out, it leads on, in Python and as a command.

What `derive`, `export` and `slope_average` advise is in tests/cli/test_advice.py, what a file's refusal advises in
tests/cli/test_advised_readings.py.
"""

import ast
import math
import re
import shlex
from concurrent.futures import Executor
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.core.errors import StickSlipError
from stickslip_sym.model import samples
from stickslip_sym.motion.orbits import damping

PACKAGE = Path(ss.__file__).parent
ELSEWHERE = {"formula", "closed_forms.py", "harmonic.py", "views", "derivations.py"}
"""Folders and files whose advice other tests carry out."""
ADVISES = re.compile(r"\b(Call|Argument|ParameterValues|AnySign)\(")
LAW = ss.laws.exponential.typical()
OSC = ss.Oscillator(m=1, k=100, c=2.3, V=0.5, N=9.81)
AT = {"V": 0.5, "N": 9.81}
MACHINE = {**AT, "m": 1, "k": 100}
SPEEDS, COEFFICIENTS = [0.0, 0.1, 0.3, 0.6], [0.5, 0.4, 0.35, 0.3]
MEASURED = ss.FrictionLaw.from_samples(SPEEDS, COEFFICIENTS)
EXTENDED = ss.FrictionLaw.from_samples(SPEEDS, COEFFICIENTS, extrapolate=True)
MANY = np.linspace(0, 1, samples.MOST + 1)
KINKED = "0.5 - 0.1*Abs(v - 0.5)^0.5"
WAVES = "0.3 + 0.1*sin(log(v))"
AT_ONCE = "0.3 + 0.1*exp(-1/v)"


class Broken(Executor):
    """An executor whose processes have ended."""

    def submit(self, *_, **__):
        raise BrokenProcessPool("a process ended")


# By words of a message: what is refused, what it advises and that done; a command that is refused, and what is
# added to it.
REMEDIES = {
    "is missing: give": (
        lambda: ss.pure_slip_damping(LAW, V=0.5), "N=...", lambda: ss.pure_slip_damping(LAW, **AT), None),
    "needs the mass m and the stiffness k": (
        lambda: ss.pure_slip_damping(LAW, **AT, method="orbit"), 'method="orbit"',
        lambda: ss.pure_slip_damping(LAW, **MACHINE, method="orbit"), None),
    "must be given to find": (
        lambda: ss.critical(LAW, "V", N=9.81), "c=...", lambda: ss.critical(LAW, "V", N=9.81, c=2), None),
    "an average of slopes does not depend on": (
        lambda: ss.critical(LAW, "m", c=2, **AT, method="harmonic"), 'method="orbit"',
        lambda: ss.critical(LAW, "m", c=2.57, k=100, **AT, method="orbit"),
        ("critical exponential --of m -c 2.57 -V 0.5 -N 9.81 --method harmonic",
         "critical exponential --of m -c 2.57 -V 0.5 -k 100 -N 9.81 --method orbit")),
    "the first speed is": (
        lambda: ss.FrictionLaw.from_samples([0.01, *SPEEDS[1:]], COEFFICIENTS), "extrapolate=True",
        lambda: ss.FrictionLaw.from_samples([0.01, *SPEEDS[1:]], COEFFICIENTS, extrapolate=True),
        ("damping --method equilibrium --from-csv late.csv",
         "damping --method equilibrium --from-csv late.csv --extrapolate")),
    "is measured up to v =": (
        lambda: ss.pure_slip_damping(MEASURED, **AT | {"V": 0.7}, method="equilibrium"), "extrapolate=True",
        lambda: ss.pure_slip_damping(EXTENDED, **AT | {"V": 0.7}, method="equilibrium"),
        ("damping --method equilibrium -V 0.7 --from-csv pin.csv",
         "damping --method equilibrium -V 0.7 --from-csv pin.csv --extrapolate")),
    "points were given, and each becomes a piece": (
        lambda: ss.FrictionLaw.from_samples(MANY, 0.4 - 0.1 * MANY), f"bins={samples.MOST}",
        lambda: ss.fit(MANY, 0.4 - 0.1 * MANY, laws="linear"),
        ("damping --method equilibrium --from-csv many.csv",
         "damping --method equilibrium --from-csv many.csv --bins 8 --extrapolate")),
    "no limit mu(0+) was found": (
        lambda: ss.FrictionLaw(WAVES).static_expr, "static=...",
        lambda: ss.FrictionLaw(WAVES, static="0.4").static_expr, None),
    "but the law takes": (
        lambda: ss.FrictionLaw("0.4 + b*v").bind(b=-0.1), "Parameter('b', positive=False)",
        lambda: ss.FrictionLaw("0.4 + b*v", parameters=[ss.Parameter("b", positive=False)]).bind(b=-0.1), None),
    "is negative, but the parameter is declared positive": (
        lambda: ss.Parameter("b", typical="-0.1"), "positive=False",
        lambda: ss.Parameter("b", typical="-0.1", positive=False), None),
    "a piece holds at v = 0 alone": (
        lambda: ss.FrictionLaw("Piecewise((0.5, v <= 0), (0.3 - 0.1*v, True))"), "static=...",
        lambda: ss.FrictionLaw("0.3 - 0.1*v", static="0.5"),
        ("damping --method equilibrium 'Piecewise((0.5, v <= 0), (0.3 - 0.1*v, True))'",
         "damping --method equilibrium '0.3 - 0.1*v' --static 0.5")),
    "has a standard error, and an Oscillator holds numbers alone": (
        lambda: ss.Oscillator(m=1, k=100, c=2.3, V="0.50(1)", N=9.81), "errors={'V': '0.50(1)'}",
        lambda: ss.margins(ss.laws.linear.typical(), OSC, errors={"V": "0.50(1)"}, samples=0), None),
    "vanishes at rest faster than any power of v": (
        lambda: ss.enclose(AT_ONCE, **AT).certificate(), "derive(law).certificate()",
        lambda: ss.derive(AT_ONCE).certificate(), None),
    "takes too many steps: friction is too strong": (
        lambda: damping.needed_damping(LAW, OSC).mismatch(1.5, 0.2), "simulate()",
        lambda: ss.simulate(LAW, OSC, t_end=1.0), None),
    "a threshold is proved for laws that are locally Lipschitz": (
        lambda: ss.pure_slip_damping(KINKED, **MACHINE, method="proof"), 'method="simulation"',
        lambda: ss.pure_slip_damping(KINKED, **MACHINE, method="simulation"),
        (f"damping '{KINKED}' -V 0.5 -N 9.81 -m 1 -k 100 --method proof",
         f"damping '{KINKED}' -V 0.5 -N 9.81 -m 1 -k 100 --method simulation")),
    "the executor ended before its work was done": (
        lambda: ss.simulate(LAW, OSC, t_end=1.0, x0=[0.0, 0.1], workers=Broken()), "workers=1",
        lambda: ss.simulate(LAW, OSC, t_end=1.0, x0=[0.0, 0.1], workers=1), None),
}  # fmt: skip
RARE = {
    "c belongs to the basins of attraction": "it takes half a minute; tests/comparison/test_tradeoff.py does it",
    "the slip that follows stick goes beyond": "a proof beyond measured speeds, where the tables refuse first",
    "are not resolved": "limit cycles that orbits do not resolve, which no law of the tests brings about",
    "gives no finite number for": "an average that is no number, which no law of the tests brings about",
}
"""What is advised and not carried out here, and why."""


@pytest.mark.filterwarnings("ignore::stickslip_sym.core.errors.InputWarning")
@pytest.mark.parametrize("words", REMEDIES)
def test_what_is_advised_leads_on(words, monkeypatch):
    refused, advice, follow, _ = REMEDIES[words]
    if words.startswith("takes too many"):
        lost = SimpleNamespace(value=math.nan)
        monkeypatch.setattr(damping, "velocity_mismatch_at", lambda *_, **__: lost)
    with pytest.raises(StickSlipError) as raised:
        refused()
    monkeypatch.undo()
    message = str(raised.value)
    assert words in message
    assert advice in message
    assert follow() is not None


@pytest.mark.parametrize("words", [words for words, (*_, line) in REMEDIES.items() if line is not None])
def test_what_is_advised_leads_on_as_a_command(words, run, tmp_path):
    rows = {
        "pin": (SPEEDS, COEFFICIENTS),
        "late": ([0.01, *SPEEDS[1:]], COEFFICIENTS),
        "many": (MANY, 0.4 - 0.1 * MANY),
    }
    for name, columns in rows.items():
        lines = [f"{v},{mu}" for v, mu in zip(*columns, strict=True)]
        (tmp_path / f"{name}.csv").write_text("\n".join(["v [m/s],mu", *lines, ""]))
    line, following = REMEDIES[words][3]
    code, _, err = run(*shlex.split(line))
    said = " ".join(err.split())
    assert (code in (1, 2), words in said) == (True, True), said
    given = re.findall(r"--[a-z-]+(?: [a-z0-9.]+)?", following.replace("--from-csv ", ""))
    advised = [option for option in given if option not in line and option.split()[0] + "=" not in line]
    assert any(option in said or option.split()[0] in said.replace("--method", "") for option in advised), said
    code, _, err = run(*shlex.split(following))
    assert code == 0, err


def test_every_remedy_of_the_package_is_carried_out_by_a_test():
    found = 0
    for path in PACKAGE.rglob("*.py"):
        if ELSEWHERE & {path.name, *path.relative_to(PACKAGE).parts}:
            continue
        text = path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(text)) if ADVISES.search(text) else ():
            if not isinstance(node, ast.Raise) or node.exc is None:
                continue
            source = re.sub(r"['\"]\s*f?['\"]", "", ast.unparse(node))
            if ADVISES.search(source):
                found += 1
                assert any(words in source for words in (*REMEDIES, *RARE)), source
    assert found >= len(REMEDIES)
