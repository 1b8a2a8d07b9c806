"""Rules of the house: folders in their order, imports one way, a cheap import, a whole public interface."""

import ast
import importlib
import re
import subprocess
import sys
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import stickslip_sym as ss

PACKAGE = Path(ss.__file__).parent
FOLDERS = ["core", "output", "model", "criteria", "formula", "motion", "comparison", "cli"]
"""The folders of the package in the order in which they may import: each only from those before it."""
ROOMS = {
    "output": ["page"],
    "model": ["expression", "measured"],
    "formula": ["integration", "evaluation", "code", "derivation", "export"],
    "motion": ["simulation", "ensemble", "orbits", "thresholds", "margins", "regimes", "maps"],
    "comparison": ["study"],
    "cli": ["shared"],
}
"""The rooms inside a folder, in the same sense; what stands in the folder itself comes after them."""
LONGEST = 320
MOST_FILES = 15
MODULES = {
    ".".join(("stickslip_sym", *path.relative_to(PACKAGE).with_suffix("").parts)).removesuffix(".__init__"): path
    for path in sorted(PACKAGE.rglob("*.py"))
}


def imported(path):
    """Modules of this package that a file imports anywhere."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("stickslip_sym"):
            for alias in node.names:
                whole = f"{node.module}.{alias.name}"
                yield whole if whole in MODULES else node.module


def place(module):
    """Return where a module stands in the order: its folder, then its room."""
    folder, *rest = module.split(".")[1:]
    rooms = ROOMS.get(folder, [])
    return FOLDERS.index(folder), rooms.index(rest[0]) if rest and rest[0] in rooms else len(rooms)


def is_face(module):
    """Whether a module is the package itself or a folder's __init__, which hands names on."""
    return MODULES[module].name == "__init__.py"


def test_the_folders_are_these():
    folders = {path.parent.relative_to(PACKAGE) for path in MODULES.values()} - {Path()}
    assert folders == {Path(folder) for folder in FOLDERS} | {
        Path(folder, room) for folder, rooms in ROOMS.items() for room in rooms
    }
    assert [path.name for path in PACKAGE.glob("*.py")] == ["__init__.py"]


@pytest.mark.parametrize("module", [module for module in MODULES if not is_face(module)])
def test_imports_run_one_way(module):
    wrong = [name for name in imported(MODULES[module]) if name != "stickslip_sym" and place(name) > place(module)]
    assert wrong == []


def test_no_imports_run_in_a_circle():
    graph = {module: set(imported(path)) - {module} for module, path in MODULES.items() if not is_face(module)}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"{error.args[1]} import each other")


def test_one_arrow_crosses_from_motion_to_formula():
    """Otherwise a cross-check of one by the other would check nothing."""
    crossing = {
        (module.split(".")[2], name.split(".")[2])
        for module, path in MODULES.items()
        if module.startswith("stickslip_sym.motion.")
        for name in imported(path)
        if name.startswith("stickslip_sym.formula.")
    }
    assert crossing == {("thresholds", "evaluation")}
    back = [
        module
        for module, path in MODULES.items()
        if module.startswith("stickslip_sym.formula.")
        and any(name.startswith("stickslip_sym.motion") for name in imported(path))
    ]
    assert back == []


def test_each_folder_says_what_it_is_for():
    for module in filter(is_face, MODULES):
        assert ast.get_docstring(ast.parse(MODULES[module].read_text())), module


def test_the_readme_tells_the_folders_in_their_order():
    told = re.findall(r"^\| `(\w+)` \| (.*) \|", (PACKAGE / "README.md").read_text(encoding="utf-8"), re.M)
    assert [folder for folder, _ in told] == FOLDERS
    for folder in ("formula", "motion"):
        assert re.findall(r"`(\w+)`", dict(told)[folder]) == ROOMS[folder]


def test_files_are_short_and_folders_small():
    root = PACKAGE.parent
    paths = [
        path
        for part in ("stickslip_sym", "derivations", "tests", "paper_checks")
        for path in (root / part).rglob("*.py")
    ]
    lengths = {str(path.relative_to(root)): len(path.read_text().splitlines()) for path in paths}
    assert {name: n for name, n in lengths.items() if n > LONGEST} == {}
    folders = {path.parent for path in paths if "stickslip_sym" in path.parts}
    assert {folder.name: n for folder in folders if (n := len(list(folder.glob("*.py")))) > MOST_FILES} == {}


def run(code):
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    ).stdout


def test_importing_the_package_imports_no_large_library():
    loaded = run("import stickslip_sym, sys; print(*sys.modules)").split()
    assert not {
        "sympy",
        "scipy",
        "numpy",
        "mpmath",
        "matplotlib",
        "typer",
        "heyoka",
        "dask",
        "uncertainties",
    } & set(loaded)


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
    for module in MODULES:
        importlib.import_module(module)
    modules = {"criteria", "laws", "quadrature", "symbols"}
    for name in ss.__all__:
        value = getattr(ss, name)
        assert value.__doc__
        assert callable(value) != (name in modules), name
    assert set(ss.__all__) <= set(dir(ss))
    assert ss.__version__
    with pytest.raises(AttributeError, match="nonsense"):
        _ = ss.nonsense


def test_every_law_of_the_catalogue_is_an_attribute():
    assert set(ss.laws.catalogue) <= set(dir(ss.laws))
    for name, law in ss.laws.catalogue.items():
        assert getattr(ss.laws, name) is law
    with pytest.raises(AttributeError, match=r"exponental.*did you mean 'exponential'"):
        _ = ss.laws.exponental


def test_derivations_and_checks_compute_nothing_at_import():
    code = (
        "import stickslip_sym.formula.derivation.proving as p, stickslip_sym.formula.derivation.closed_form as f\n"
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
