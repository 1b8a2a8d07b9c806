"""Rules of the house: imports that run one way, a cheap import, a whole public interface."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import stickslip_sym as ss

PACKAGE = Path(ss.__file__).parent
LAYERS = [
    "errors", "deadline", "interruption", "values", "symbols", "pieces", "spelling",
    "parsing", "units", "notation", "special",
    "brackets", "text_printer", "latex_functions", "latex_printer", "printing", "layout",
    "abbreviation", "codegen", "tables", "html_text", "files", "drawing",
    "parameters", "misspelt", "formula", "headers", "samples", "coefficient", "evaluated", "friction",
    "doubts", "laws", "criteria", "quadrature",
    "normal_form", "theorems", "bounded", "certain", "proving", "derivation",
    "terms", "ladders", "antiderivatives", "harmonics", "search", "integrals", "tidy",
    "bounds", "exact", "conditioned", "branches", "gauss", "fitting", "profile", "splitting", "products",
    "evaluate", "arguments", "dialects", "c_text", "python_text", "octave_text", "code_text",
    "averages", "gate", "closed_form",
    "trees", "law_content", "keeping",
    "oscillator", "steppers", "slip_phase", "slip", "taylor", "engines", "trajectory", "tendency", "automaton",
    "transit", "grazing",
    "perturbation", "collocation", "orbit", "cycles", "rungs", "threshold", "transition",
    "deviation", "crosscheck",
    "limits", "document", "export", "slip_orbits", "regime_plot", "regimes", "classification",
    "workers", "checkpoint", "archive", "axes", "columns", "map_plot", "maps", "basins",
    "newmark", "tradeoff", "tradeoff_thresholds",
    "cli_words", "cli_names", "cli_reading", "cli_json", "cli_law",
    "cli_laws", "cli_derive", "cli_damping", "cli_simulate", "cli_map", "cli_tradeoff", "cli_export", "cli",
]  # fmt: skip
"""The modules of the package in the order in which they may import: each only from those before it."""


def imported_modules(path):
    """Names of this package's modules that a file imports anywhere."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and node.module == "stickslip_sym":
            yield from (alias.name for alias in node.names if alias.name != "__version__")
        elif isinstance(node, ast.ImportFrom) and (node.module or "").startswith("stickslip_sym."):
            yield node.module.split(".")[1]


def test_every_module_has_its_layer():
    assert {path.stem for path in PACKAGE.glob("*.py")} - {"__init__"} == set(LAYERS)


@pytest.mark.parametrize("module", LAYERS)
def test_imports_run_downward(module):
    allowed = set(LAYERS[: LAYERS.index(module)])
    assert set(imported_modules(PACKAGE / f"{module}.py")) <= allowed


def test_files_are_short():
    root = PACKAGE.parent
    paths = [
        path
        for part in ("stickslip_sym", "derivations", "tests", "paper_checks")
        for path in (root / part).rglob("*.py")
    ]
    assert {path.name: n for path in paths if (n := len(path.read_text().splitlines())) > 400} == {}


def run(code):
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    ).stdout


def test_importing_the_package_imports_next_to_nothing():
    loaded = run("import stickslip_sym, sys; print(*sys.modules)").split()
    assert not {"sympy", "scipy", "numpy", "matplotlib", "typer", "heyoka", "dask"} & set(loaded)


def test_using_the_package_imports_no_extra():
    code = (
        "import stickslip_sym as ss, sys\n"
        "for name in ss.__all__: getattr(ss, name)\n"
        "ss.derive(ss.laws.polynomial)\n"
        "ss.stick_slip_cycle(ss.laws.polynomial.typical(), ss.Oscillator(m=1, k=100, V=0.5, N=9.81))\n"
        "print(*sys.modules)"
    )
    assert not {"matplotlib", "typer", "heyoka", "dask"} & set(run(code).split())


def test_every_public_name_is_there_whatever_was_imported_before():
    import importlib

    for module in LAYERS:
        importlib.import_module(f"stickslip_sym.{module}")
    for name in ss.__all__:
        value = getattr(ss, name)
        assert value.__doc__
        if name not in ss._MODULES:
            assert callable(value), name
    assert set(ss.__all__) <= set(dir(ss))
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        _ = ss.nonsense


def test_derivations_and_checks_compute_nothing_at_import():
    code = (
        "import stickslip_sym.proving as p, stickslip_sym.closed_form as f\n"
        "def no(*args, **kwargs): raise SystemExit('computed at import')\n"
        "p.prove_equal = p.prove_positive = f.derive = no\n"
        "import derivations, derivations.paper\n"
        "for module in derivations.CHAPTERS.values(): __import__(f'derivations.{module}')\n"
        "print('fine')"
    )
    assert run(code) == "fine\n"


def test_derivations_print_as_latex():
    """As text the README's tests run them, all of them."""
    root = PACKAGE.parent

    def derivations(*arguments):
        command = [sys.executable, "-m", "derivations", *arguments]
        return subprocess.run(command, capture_output=True, text=True, cwd=root, timeout=120, check=False)

    assert "\\begin{equation*}" in derivations("one_threshold", "--latex").stdout
    assert derivations("nonsense").returncode == 2
