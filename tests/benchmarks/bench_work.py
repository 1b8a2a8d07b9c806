"""How much work answers are, and what they are: ``python -m pytest tests/benchmarks/bench_work.py -n 0``.

Work is counted in calls of functions of the package, in plain Python and without what was kept from before. Counts
do not depend on the machine or on its load, so that a twentieth more of them in one module is seen, where a time
must grow by a third. They are held against those in work.json, and so are the answers and their stated errors.
After a change that is meant to change them, ``python tests/benchmarks/bench_work.py`` writes them anew: what
became dearer stands in the difference.
"""

import importlib
import json
import multiprocessing
import pkgutil
import sys
import tempfile
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from pathlib import Path

import numpy as np
import pytest

import stickslip_sym as ss
from stickslip_sym.motion.compiled import compiled, is_compiling

for _module in pkgutil.walk_packages(ss.__path__, "stickslip_sym."):
    if "__main__" not in _module.name:
        importlib.import_module(_module.name)  # lest an answer counts what it imports first

RECORDED = Path(__file__).with_name("work.json")
PACKAGE = Path(ss.__file__).parent
MORE = 0.05
"""Of the calls of a module: another release of NumPy rounds otherwise, and a step may be more or less."""
A_FEW = 5
"""Calls, more or less."""
SAME = 1e-6
"""Relative; the answers' own errors are less."""
OTHER_ERROR = 1.5
"""Ratio of stated errors that counts as another error."""

AT = {"N": 9.81, "m": 1.0, "k": 100.0}
LAW = ss.laws.exponential.typical()
OSCILLATOR = ss.Oscillator(V=0.5, c=2.2, **AT)
BISTABLE = ss.laws.exponential.bind(mu_s=1, mu_m=0.5, alpha=2), ss.Oscillator(m=1, k=1, c=0.1, V=1.5, N=1)
BOX = {"x0": (-2.0, 2.0), "v0": (0.0, 2.0)}
SLOPE = "(0.25 + 0.2*exp(-v/0.3))"
LAWS = {
    "exponential": LAW,
    "polynomial": ss.laws.polynomial.typical(),
    "large": LAW.bind(mu_s=5.0),
    "tanh": ss.FrictionLaw(f"{SLOPE}*tanh(v/1e-4)"),
    "root": ss.FrictionLaw(f"{SLOPE}*v/sqrt(v^2 + 1e-6)"),
    "bump": ss.FrictionLaw("0.2 + 0.3*exp(-3*v) - 0.02*exp(-((v - 0.7)/0.001)^2)"),
    "kink": ss.FrictionLaw("0.5 - 0.1*Min(v, 0.4) + 0.05*Max(v - 0.5, 0)"),
    "jump": ss.FrictionLaw("0.5 - 0.1*v + Piecewise((0, v < 0.8), (0.02, True))"),
    "vertical": ss.FrictionLaw("0.5 - 0.1*v^0.3"),
    "waves": ss.FrictionLaw("0.3 + 0.1*exp(-v) + 0.02*sin(12*v)"),
    "static": LAW.with_static(0.6),
    "samples": ss.FrictionLaw.from_samples(
        [0, 0.1, 0.2, 0.5, 1, 2], [0.5, 0.42, 0.37, 0.3, 0.28, 0.27], extrapolate=True
    ),
}
VALUES = {"mu_s": 0.5, "mu_m": 0.2, "v_s": 0.3, "mu_0": 0.4, "a": 0.1, "v_0": 0.2}
FORMULAS = {
    "rational": "mu_m + (mu_s - mu_m)/(1 + v/v_s)",
    "sech": "mu_m + (mu_s - mu_m)*sech(v/v_s)",
    "logarithm": "mu_0 - a*log(1 + v/v_0)",
}


def threshold(name, method, eta=None, rtol=1e-9):
    at = AT if eta is None else AT | {"N": eta * 0.5 * 10}
    found = ss.pure_slip_damping(LAWS[name], V=0.5, **at, method=method, rtol=rtol)
    return {"threshold": found.value, "error": found.error}


def cycles(name):
    found = ss.limit_cycles(LAWS[name], OSCILLATOR)
    return {f"amplitude {i}": one.amplitude for i, one in enumerate(found)}


def critical(name, of, **given):
    at = AT | {"V": 0.5, "c": 2.2} | given
    del at[of]
    return {f"value {i}": one.value for i, one in enumerate(ss.critical(LAWS[name], of, **at))}


def margins():
    found = ss.margins(LAW, OSCILLATOR, errors={"V": "0.5+-0.02", "N": "9.81+-0.2"})
    changes = {row.name: row.change for row in found.rows if row.change is not None}
    return {"threshold": found.threshold.value, "stick-slip": found.probability} | changes


def regime(name):
    found = ss.regime(LAWS[name], OSCILLATOR)
    return {"separatrices": len(found.separatrices), "rest": found.rest.x}


def simulated(name, method="events"):
    found = ss.simulate(LAWS[name], OSCILLATOR, t_end=3.0, x0=0.03, method=method)
    return {"x": found.x[-1], "samples": len(found.t), "events": len(found.events)}


def classes():
    found = ss.classify(LAW, OSCILLATOR, x0=np.linspace(-0.1, 0.1, 5), v0=0.3)
    return {"stick-slip": sum(one is ss.Motion.STICK_SLIP for one in found)}


def motion_map(name, other, values):
    given = AT | {"c": 2.2}
    del given[other]
    found = ss.motion_map(LAWS[name], x=("V", np.linspace(0.2, 0.9, 4)), y=(other, values), **given)
    return {"stick-slip": np.sum(found.motion == ss.Motion.STICK_SLIP)}


def basins():
    places = {name: np.linspace(*ends, 20) for name, ends in BOX.items()}
    return {"disagreements": ss.basin_map(*BISTABLE, **places).disagreements}


def sweep():
    found = ss.basin_sweep(*BISTABLE, ("V", np.linspace(0.5, 2.5, 9)), **BOX)
    return {f"{change.kind} {i}": change.value for i, change in enumerate(found.changes)}


def closed_form(name):
    form = ss.derive(ss.FrictionLaw(FORMULAS[name]))
    point = {symbol: VALUES[symbol] for symbol in map(str, form.law.parameters)}
    speeds = 0.3 * 10.0 ** np.arange(-12, 9, 2)
    values = form(V=speeds, N=9.81, **point)
    return {f"at {V:.0e} m/s": value for V, value in zip(speeds, values, strict=True)}


def averages(name):
    """Return the criterion by quadrature, in balls and by its function."""
    law, at = LAWS[name], {"V": 0.5, "N": 9.81}
    enclosed = ss.enclose(law, **at)
    return {
        "quadrature": float(ss.quadrature.damping(law, **at, digits=30)),
        "enclosed": float(enclosed.mid),
        "error of the enclosed": float(enclosed.radius),
        "function": ss.slope_average(law)(**at),
    }


def exported():
    return {language: len(ss.export_code(ss.slope_average(LAW), language)) for language in ("c", "octave")}


def rows(count, noise):
    """Return speeds and coefficients of friction with noise."""
    v = np.geomspace(0.02, 3, count)
    return v, 0.2 + 0.3 * np.exp(-2 * v) + noise * np.random.default_rng(1).standard_normal(count)


def fits(count):
    found = ss.fit(*rows(count, 0.005))
    return {one.name: one.aicc for one in found.fits[:3]} | {"error": found.best.standard_errors["mu_s"]}


def sweeps_in_a_file():
    v, mu = rows(1000, 0.004)
    speeds, coefficients = np.r_[v, v[::-1]], np.r_[mu, mu[::-1] + 0.02]
    lines = [f"{t}\t{1000 * v:.3f}\t{mu:.4f}" for t, v, mu in zip(range(2000), speeds, coefficients, strict=True)]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sweeps.txt"
        path.write_text("\n".join(["Time (s)\tSpeed (mm/s)\tCOF", *lines]))
        found = ss.read_measurements(path)
    return {"rows": len(found.v)}


def compared():
    rows = ss.compare(LAW, OSCILLATOR).rows
    return {"rows": len(rows)}


def studied():
    return {"threshold": ss.study(LAW, OSCILLATOR).threshold.value}


ANSWERS = {
    **{f"threshold of {name}": partial(threshold, name, "simulation") for name in LAWS},
    **{f"threshold of {name}, strong": partial(threshold, name, "simulation", 20.0) for name in LAWS},
    **{
        f"threshold at eta = {eta:g}": partial(threshold, "exponential", "orbit", eta)
        for eta in (1e-4, 1.0, 1e2, 1e3)
    },
    "threshold, a thousandth": partial(threshold, "exponential", "auto", rtol=1e-3),
    "threshold, 1e-12": partial(threshold, "exponential", "orbit", rtol=1e-12),
    "threshold, proved": partial(threshold, "exponential", "proof"),
    **{f"cycles of {name}": partial(cycles, name) for name in ("exponential", "kink", "samples")},
    **{f"critical {of}": partial(critical, "exponential", of) for of in "VcmN"},
    "margins": margins,
    **{
        f"regime of {name}": partial(regime, name)
        for name in ("exponential", "polynomial", "kink", "waves", "samples")
    },
    **{f"motion of {name}": partial(simulated, name) for name in LAWS},
    "motion by SciPy": partial(simulated, "exponential", "solve_ivp"),
    "classes": classes,
    "map over N": partial(motion_map, "exponential", "N", [3.0, 9.81, 20.0]),
    "map over c": partial(motion_map, "exponential", "c", [1.0, 2.2, 3.0]),
    "basins": basins,
    "basins over V": sweep,
    **{f"closed form, {name}": partial(closed_form, name) for name in FORMULAS},
    **{f"averages of {name}": partial(averages, name) for name in LAWS},
    "code": exported,
    **{f"fit of {count} rows": partial(fits, count) for count in (8, 60)},
    "file": sweeps_in_a_file,
    "comparison": compared,
    "study": studied,
}
"""What is asked."""


def module_of(code):
    """Return the module of the package that a function stands in, without the ending."""
    path = Path(code.co_filename)
    return str(path.relative_to(PACKAGE).with_suffix("")) if path.is_relative_to(PACKAGE) else None


def is_function(code):
    """Whether it has a name: a comprehension is no call in later releases of Python."""
    return not code.co_name.startswith("<")


def run_in_plain_python():
    """Let nothing be compiled."""
    sys.modules["numba"] = None
    is_compiling.cache_clear()
    compiled.cache_clear()


def work_of(name):
    """Return what an answer says, and the calls of functions by module."""
    run_in_plain_python()
    calls = Counter()

    def note(frame, event, _):
        if event == "call":
            calls[frame.f_code] += 1

    sys.setprofile(note)
    try:
        answer = ANSWERS[name]()
    finally:
        sys.setprofile(None)
    of_modules = Counter()
    for code, count in calls.items():
        if (module := module_of(code)) is not None and is_function(code):
            of_modules[module] += count
    return {
        "answer": {what: float(value) for what, value in answer.items()},
        "calls": {module: count for module, count in sorted(of_modules.items()) if count > A_FEW},
    }


def work_anew(name):
    """Return the work of an answer in a copy of this process, which keeps nothing of it."""
    with ProcessPoolExecutor(1, multiprocessing.get_context("fork")) as copy:
        return copy.submit(work_of, name).result()


def is_another(what, value, before):
    """Whether a number of an answer differs."""
    if "error" in what:
        return not before / OTHER_ERROR <= value <= before * OTHER_ERROR
    return value != before and not abs(value - before) <= SAME * abs(before)


@pytest.mark.parametrize("name", ANSWERS)
def test_work(name):
    """An answer is what it was, and no module is asked more often, or less, than it was."""
    before, now = json.loads(RECORDED.read_text())[name], work_anew(name)
    differences = [
        f"{what}: {value:.12g}, recorded as {before['answer'].get(what)}"
        for what, value in now["answer"].items()
        if is_another(what, value, before["answer"].get(what, float("nan")))
    ]
    for module in sorted(before["calls"] | now["calls"]):
        count, recorded = now["calls"].get(module, A_FEW), before["calls"].get(module, A_FEW)
        if abs(count - recorded) > A_FEW + MORE * recorded:
            differences.append(f"{module}: {count} calls, recorded are {recorded}")
    assert now["answer"].keys() == before["answer"].keys()
    assert not differences, "\n".join(differences)


def record():
    """Write down the work of all answers, a line each."""
    lines = [f"{json.dumps(name)}: {json.dumps(work_anew(name))}" for name in ANSWERS]
    RECORDED.write_text("{\n" + ",\n".join(lines) + "\n}\n")


if __name__ == "__main__":
    record()
