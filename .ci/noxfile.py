"""Jobs in environments of their own: ``nox -f .ci/noxfile.py -l`` lists them; arguments after -- go to pytest.

The workflow runs all but `mutants`, which takes hours and is run by hand; `nightly` has a workflow of its own.
"""

import datetime
import re
import tomllib
from pathlib import Path

import nox

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
PYTHONS = [line.split()[-1] for line in PROJECT["classifiers"] if re.search(r":: 3\.\d+$", line)]

nox.options.envdir = str(ROOT / "build" / "nox")
nox.options.sessions = ["lint", "tests"]
nox.options.default_venv_backend = "venv"
nox.options.error_on_missing_interpreters = True

USES = """
from importlib.metadata import files, metadata
import stickslip_sym as ss

[getattr(ss, name) for name in ss.__all__]
names = {str(path) for path in files("stickslip_sym")}
assert "stickslip_sym/py.typed" in names and any(name.endswith("licenses/LICENSE") for name in names)
assert not any(name.startswith(("tests", "paper_checks", "derivations")) for name in names)
assert metadata("stickslip_sym")["Version"] == ss.__version__
"""


@nox.session
def lint(session):
    """Run ruff, mypy and the contracts on the direction of imports."""
    session.chdir(ROOT)
    session.install("-e", ".[test]")
    for command in ("ruff check .", "ruff format --check .", "mypy", "lint-imports"):
        session.run(*command.split())


@nox.session(python=PYTHONS)
def tests(session):
    """Run the tests on each Python that the project declares; one that is missing is a failure."""
    session.chdir(ROOT)
    session.install("-e", ".[test]")
    session.run("python", "-m", "pip", "list")
    session.run("pytest", "-ra", *session.posargs)


@nox.session
def nightly(session):
    """Run what takes long, with new examples and in another order; the seed of the day is printed."""
    session.chdir(ROOT)
    session.install("-e", ".[test]")
    seed = datetime.datetime.now(datetime.UTC).strftime("%Y%m%d")
    session.run("pytest", "--thorough", "--fresh", seed, "--order", seed, "-ra", *session.posargs)
    session.run("pytest", "-n", "0", "tests/benchmarks/bench_work.py")


@nox.session
def lowest(session):
    """Run the tests with the lowest versions that pyproject.toml allows; old ones warn of newer neighbours."""
    session.chdir(ROOT)
    extras = PROJECT["optional-dependencies"]
    wanted = sorted({*PROJECT["dependencies"], *extras["plot"], *extras["test"]})
    session.install("-e", ".", *(requirement.replace(">=", "==") for requirement in wanted))
    deprecations = ["-W", "ignore::DeprecationWarning", "-W", "ignore::PendingDeprecationWarning"]
    session.run("pytest", *deprecations, *session.posargs)


@nox.session
def package(session):
    """Build the sdist, from it the wheel; use the wheel where nothing else is; test the unpacked sdist."""
    session.chdir(ROOT)
    session.install("build", "twine")
    folder = Path(session.create_tmp())
    session.run("python", "-m", "build", "--outdir", str(folder), ".")
    (wheel,), (source,) = folder.glob("*.whl"), folder.glob("*.tar.gz")
    session.run("twine", "check", "--strict", str(wheel), str(source))
    session.run("python", "-m", "venv", "--clear", str(folder / "user"))
    user = folder / "user" / "bin"
    session.run(str(user / "pip"), "install", "--quiet", str(wheel), external=True)
    with session.chdir(folder):  # away from the checkout, which Python would import
        session.run(str(user / "python"), "-c", USES, external=True)
        session.run(str(user / "stickslip"), "derive", "exponential", external=True)
    session.run("tar", "--extract", "--file", str(source), "--directory", str(folder), external=True)
    with session.chdir(folder / source.name.removesuffix(".tar.gz")):
        session.install(".[test]")
        session.run("pytest", *session.posargs)


@nox.session
def documentation(session):
    """Build the documentation, of which a warning is an error, and compare README's pictures by their texts."""
    session.chdir(ROOT)
    session.install("-e", ".[plot,docs]")
    session.run("python", "-W", "error", ".ci/documentation/build.py")
    session.run("python", ".ci/pictures.py")


@nox.session
def mutants(session):
    """Mutate the functions that arguments name, as in ``-- "stickslip_sym.core.*"``, and list what survives."""
    session.chdir(ROOT)
    session.install("-e", ".[test]", "mutmut")
    session.run("mutmut", "run", *session.posargs)
    session.run("mutmut", "results")
