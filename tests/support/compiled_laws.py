"""The laws of the catalogue as functions of NumPy; ``python tests/support/compiled_laws.py`` writes the module.

`stickslip_sym.model.compiled` is what this prints, and a test holds it to that: whoever adds or changes a law
writes it again.
"""

from pathlib import Path

import sympy as sp
from sympy.printing.numpy import SciPyPrinter

import stickslip_sym as ss
from stickslip_sym.core import symbols

PATH = Path(ss.__file__).parent / "model" / "compiled.py"

_HEAD = '''"""mu and its slope as functions of NumPy arrays, for every law of the catalogue.

Written by tests/support/compiled_laws.py from the formulas; not to be edited. The functions are those that
`core.lambdify` would make, without SymPy.
"""

# ruff: noqa: D103, E501
# mypy: disable-error-code="no-untyped-def,no-any-return"
# fmt: off

'''


def module():
    """Return the module as text."""
    printer = SciPyPrinter({"fully_qualified_modules": False, "inline": True, "allow_unknown_functions": True})
    functions = []
    for name, law in ss.laws.catalogue.items():
        arguments = ", ".join(["v", *law.parameters])
        for kind, expr in (("mu", law.expr), ("slope", sp.diff(law.expr, symbols.v))):
            functions.append(f"def {name}_{kind}({arguments}):\n    return {printer.doprint(expr)}\n")
    used = sorted({name for library in printer.module_imports.values() for name in library})
    return f"{_HEAD}from numpy import {', '.join(used)}\n\n\n" + "\n\n".join(functions)


if __name__ == "__main__":
    PATH.write_text(module(), encoding="utf-8")
