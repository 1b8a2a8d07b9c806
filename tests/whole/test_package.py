"""The package as a whole: the direction of imports, what an import loads, and the public names."""

import importlib.util
import inspect
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest

import stickslip_sym as ss

PACKAGE = Path(ss.__file__).parent
ROOT = Path(__file__).parents[2]
MODULES = {
    ".".join(("stickslip_sym", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__"): path
    for path in sorted(PACKAGE.rglob("*.py"))
}
FUNCTIONS = {name: getattr(ss, name) for name in ss.__all__ if inspect.isfunction(getattr(ss, name))}


def lint_imports(configuration):
    """Hold the contracts of a file against the package; return the exit code and what is printed."""
    code = "from importlinter.cli import lint_imports_command; lint_imports_command()"
    command = [sys.executable, "-c", code, "--no-cache", "--config", configuration]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=60, check=False)
    return done.returncode, done.stdout


def test_imports_run_one_way():
    assert lint_imports(ROOT / "pyproject.toml")[0] == 0


def test_imports_against_their_direction_are_noticed(tmp_path):
    """The same contracts with two folders exchanged."""
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    wrong = text.replace('"motion", "formula"', '"formula", "motion"')
    assert wrong != text
    (tmp_path / "pyproject.toml").write_text(wrong, encoding="utf-8")
    code, said = lint_imports(tmp_path / "pyproject.toml")
    assert (code, "stickslip_sym.motion is not allowed to import stickslip_sym.formula" in said) == (1, True)


def test_views_alone_write_html():
    marked = {name for name, path in MODULES.items() if re.search(r"</[a-z]+\d?>", path.read_text("utf-8"))}
    assert "stickslip_sym.views.markup" in marked
    assert {name for name in marked if not name.startswith("stickslip_sym.views.")} == set()


def test_the_top_level_holds_what_it_should():
    """A file that a command wrote, and was committed with the rest, is noticed."""
    folders = {"derivations", "paper_checks", "stickslip_sym", "tests"}
    files = {"CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "LICENSE", "README.md", "pyproject.toml"}
    made = {"build", "dist", "PKG-INFO", "setup.cfg"}  # by builds, and in an unpacked sdist
    found = {path.name for path in ROOT.iterdir() if not path.name.startswith((".", "__"))}
    assert {name for name in found - made if not name.endswith(".egg-info")} == folders | files


def test_declared_pythons_are_those_of_the_workflow():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    classified = [line.split()[-1] for line in project["classifiers"] if line.startswith("Programming Language")]
    declared = [version for version in classified if "." in version]
    workflow = (ROOT / ".github/workflows/tests.yml").read_text(encoding="utf-8")
    assert f"python: {declared}".replace("'", '"') in workflow
    assert project["requires-python"] == f">={declared[0]}"


def run(code):
    command = [sys.executable, "-c", code]
    return subprocess.run(command, capture_output=True, text=True, check=True, cwd=ROOT, timeout=120).stdout


def test_importing_the_package_imports_no_large_library():
    loaded = run("import stickslip_sym, sys; print(*sys.modules)").split()
    large = {"sympy", "scipy", "numpy", "mpmath", "matplotlib", "click", "rich", "dask", "uncertainties"}
    assert not large & set(loaded)


def test_using_the_package_imports_no_extra_and_derivations_compute_nothing_at_import():
    """In one process: the derivations last, as importing them is all that is looked at."""
    code = (
        "import stickslip_sym as ss, sys\n"
        "for name in ss.__all__: getattr(ss, name)\n"
        "ss.derive(ss.laws.polynomial)\n"
        "ss.stick_slip_cycle(ss.laws.polynomial.typical(), ss.Oscillator(m=1, k=100, V=0.5, N=9.81))\n"
        "print(*sys.modules)\n"
        "import stickslip_sym.formula.proof.proving as p, stickslip_sym.formula.closed_form as f\n"
        "def no(*args, **kwargs): raise SystemExit('computed at import')\n"
        "p.prove_equal = p.prove_positive = f.derive = no\n"
        "import derivations, derivations.paper\n"
        "for module in derivations.CHAPTERS.values(): __import__(f'derivations.{module}')\n"
        "print('fine')"
    )
    used, imported = run(code).splitlines()
    loaded = used.split()
    assert not {"matplotlib", "click", "rich", "dask"} & set(loaded)
    assert [name for name in loaded if name.startswith("stickslip_sym.views")] == []
    assert not any(name.startswith("derivations") for name in loaded)
    assert imported == "fine"


def test_public_names_need_no_import_before():
    for module in MODULES:
        importlib.import_module(module)
    modules = {"criteria", "laws", "quadrature", "results", "symbols"}
    for name in ss.__all__:
        value = getattr(ss, name)
        assert value.__doc__
        assert callable(value) != (name in modules), name
    assert set(ss.__all__) <= set(dir(ss))
    assert ss.__version__
    with pytest.raises(AttributeError, match="nonsense"):
        _ = ss.nonsense


def annotated(function):
    """Return the names in what a function says that it returns."""
    return set(re.findall(r"\w+", str(getattr(function, "__annotations__", {}).get("return", ""))))


def test_every_class_that_public_functions_return_is_a_result():
    """And those that their methods and properties return, in turn, where users call them."""
    ours = {}
    for module in MODULES:
        for name, value in vars(importlib.import_module(module)).items():
            if isinstance(value, type) and value.__module__ == module:
                ours.setdefault(name, set()).add(value)
    classes = {name: getattr(ss.results, name) for name in ss.results.__all__}
    assert all(one in ours[name] for name, one in classes.items())
    returned = set().union(*map(annotated, FUNCTIONS.values())) & set(ours)
    assert returned - set(classes) - set(ss.__all__) == set()
    assert len(returned & set(classes)) > 15
    members = [value for one in classes.values() for name, value in vars(one).items() if not name.startswith("_")]
    functions = [getattr(member, "fget", None) or getattr(member, "func", member) for member in members]
    assert set().union(*map(annotated, functions)) & set(ours) - set(classes) - set(ss.__all__) == KERNEL


KERNEL = {"FrictionTable", "GrazingExpansion", "NondimensionalOscillator", "RestPolynomial", "Term"}
"""What results compute with: no user has to name it."""


def test_a_class_of_results_says_where_it_is():
    with pytest.raises(AttributeError, match=r"it is stickslip_sym\.results\.Threshold"):
        _ = ss.Threshold


def test_a_threshold_is_a_number():
    law = ss.laws.exponential.typical()
    threshold = ss.pure_slip_damping(law, V=0.5, N=9.81)
    assert float(threshold) == threshold.value
    with pytest.raises(ss.InputError, match="2 thresholds are no single number"):
        float(ss.pure_slip_damping(law, V=[0.5, 0.6], N=9.81))


def test_signatures_of_public_functions_can_be_read():
    assert len(FUNCTIONS) > 20
    for name, one in FUNCTIONS.items():
        signature = str(inspect.signature(one)).replace("pathlib._local.", "pathlib.")  # of Python 3.13
        assert len(signature) <= 600, name


@pytest.mark.thorough
def test_derivations_print_as_latex():
    """As text the README's tests run them, all of them."""
    for name, code in (("one_threshold", 0), ("nonsense", 2)):
        command = [sys.executable, "-m", "derivations", name, "--latex"]
        done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, timeout=120, check=False)
        assert (done.returncode, "\\begin{equation*}" in done.stdout) == (code, code == 0)


BY_POSITION = {"law": ss.laws.linear.typical(), "of": "N", "over": ("c", [1.0, 2.0])}
BY_NAME = {"c": 1, "t_end": 1, "x0": (0, 1), "v0": (0, 1)}
TAKEN = {name: inspect.signature(function).parameters for name, function in FUNCTIONS.items()}


@pytest.mark.parametrize("osc", [3, {"m": 1.0}])
@pytest.mark.parametrize("name", [name for name, taken in TAKEN.items() if "osc" in taken])
def test_what_is_no_oscillator_is_refused(name, osc):
    values = BY_POSITION | {"osc": osc}
    given = [values[key] for key in TAKEN[name] if key in values]
    with pytest.raises(ss.InputError, match="an Oscillator"):
        FUNCTIONS[name](*given, **{key: value for key, value in BY_NAME.items() if key in TAKEN[name]})


def test_processes_that_tests_start_need_not_compile_the_libraries():
    assert Path(importlib.util.cache_from_source(importlib.util.find_spec("sympy").origin)).exists()
