"""Expressions as lines of a Python script in plain SymPy, formatted as ruff does."""

import ast
import builtins
import re
from collections.abc import Mapping

import sympy as sp
from sympy.printing.str import StrPrinter

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.functions import elementary
from stickslip_sym.output.text_printer import Readable

WIDTH = 115
"""Characters of a line."""

_LONG = "  # fmt: skip  # noqa: E501"


class _Script(Readable, StrPrinter):
    def __init__(self, names: Mapping[Expr, str]) -> None:
        super().__init__()
        self.names = names

    def _print_Symbol(self, expr: Expr) -> str:
        return self.names[expr]

    _print_Dummy = _print_Symbol

    def _print_Rational(self, expr: Expr) -> str:
        return f"Rational({expr.p}, {expr.q})"

    def _print_Exp1(self, expr: Expr) -> str:
        return "exp(1)"

    def _print_Derivative(self, expr: sp.Derivative) -> str:
        variables = [x for x, count in expr.variable_count for _ in range(count)]
        return f"sp.diff({', '.join(map(self._print, [expr.expr, *variables]))})"

    def _print_NumberPower(self, expr: Expr) -> str:
        base, exponent = map(self._print, expr.args)
        return f"Pow({base}, {exponent}, evaluate=False)"

    def _print_Lerch(self, expr: Expr) -> str:
        return f"lerchphi({', '.join(map(self._print, expr.args))})"


def python_code(expr: Expr, names: Mapping[Expr, str]) -> str:
    """Return an expression as Python; `names` are those of its symbols."""
    return formatted(_Script(names).doprint(elementary(expr)))


def formatted(text: str) -> str:
    """Return a Python expression with spaces and parentheses as ruff sets them. It is parsed, and not run."""
    return re.sub(r"\b_\(", "(", ast.unparse(_Powers().visit(ast.parse(text, mode="eval"))))


class _Powers(ast.NodeTransformer):
    """Write x**2 without spaces, -(x**2) and y ** (x**2) with parentheses, which unparsing would leave out."""

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.AST:
        is_power = isinstance(node.operand, ast.BinOp) and isinstance(node.operand.op, ast.Pow)
        node.operand = self._enclosed(node.operand) if is_power else self.visit(node.operand)
        return node

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        if not isinstance(node.op, ast.Pow):
            return self.generic_visit(node)
        operands = []
        for operand in (node.left, node.right):
            is_power = isinstance(operand, ast.BinOp) and isinstance(operand.op, ast.Pow)
            operands.append(self._enclosed(operand) if is_power else self.visit(operand))
        node.left, node.right = operands
        sides = [ast.unparse(operand) for operand in operands]
        simple = re.fullmatch(r"\w+", sides[0]) and re.fullmatch(r"-?\w+", sides[1])
        if simple:
            return ast.Name(f"{sides[0]}**{sides[1]}")
        return node

    def _enclosed(self, node: ast.AST) -> ast.Call:
        return ast.Call(ast.Name("_"), [self.visit(node)], [])


def assignment(name: str, text: str) -> str:
    """Return an assignment on one line."""
    return script_line(f"{name} = {formatted(text)}")


def script_line(text: str) -> str:
    """Return a line of a script, which ruff leaves as it is where it is long."""
    return text if len(text) <= WIDTH else text + _LONG


def imports(body: str) -> str:
    """Return the imports that a script in SymPy and mpmath needs, in the order of ruff."""
    tree = ast.parse(body)
    names = [node for node in ast.walk(tree) if isinstance(node, ast.Name)]
    made = {node.id for node in names if isinstance(node.ctx, ast.Store)} | set(dir(builtins))
    made |= {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}
    made |= {node.arg for node in ast.walk(tree) if isinstance(node, ast.arg)}
    used = {node.id for node in names} - made
    wanted = sorted((name for name in used if hasattr(sp, name)), key=lambda name: (name.islower(), name.lower()))
    standard = "".join(f"import {name}\n" for name in ("itertools", "random") if name in used)
    standard += "\n" * bool(standard)
    others = "import mpmath\n" * ("mpmath" in used)
    functions = f"from sympy import {', '.join(wanted)}"
    if len(functions) > WIDTH:
        functions = "\n".join(["from sympy import (", *(f"    {name}," for name in wanted), ")"])
    return f"\n{standard}{others}import sympy as sp\n{functions}\n"
