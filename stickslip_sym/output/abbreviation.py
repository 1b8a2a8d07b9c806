"""Long formulas made readable: what stands in them repeatedly, or is wide, gets a letter."""

from collections.abc import Mapping

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.output.layout import LINE, displayed, width
from stickslip_sym.output.notation import look, notation_of
from stickslip_sym.output.printing import latex

__all__ = ["abbreviated", "equation", "letter"]

_REPEATED = 2  # times that a root stands in a long formula, from which on it gets a name
_LETTERS = "qphrwgz"


def equation(
    left: str, right: Expr, names: Mapping[str, str], *, relation: str = "=", label: str = "", tag: str = ""
) -> str:
    """Return a displayed equation with a side that is LaTeX already, and the definitions that follow it."""
    expr, definitions, known = abbreviated(right, names)
    shown = displayed(left, latex(expr, known), relation=relation, label=label, tag=tag)
    where = [displayed(known[symbol.name], latex(value, known)) for symbol, value in definitions]
    return "\n".join([shown, "where", *where]) if where else shown


def abbreviated(expr: Expr, names: Mapping[str, str]) -> tuple[Expr, list[tuple[Expr, Expr]], dict[str, str]]:
    """Give names to roots that stand repeatedly in a formula of several lines, and to wide denominators.

    Returns the shorter formula, the new symbols with their definitions, and the LaTeX of all symbols.
    """
    if width(latex(expr, names)) <= LINE:
        return expr, [], dict(names)
    definitions: list[tuple[Expr, Expr]] = []
    while True:
        roots: dict[Expr, int] = {}
        for node in sp.preorder_traversal(expr):
            if node.is_Pow and node.base.is_Add and sp.denom(node.exp) == 2:
                roots[node.base] = roots.get(node.base, 0) + 1
        often = [base for base, count in roots.items() if count >= _REPEATED]
        if not often:
            break
        base = min(often, key=lambda base: (base.count_ops(), sp.default_sort_key(base)))
        symbol = sp.Dummy(f"root{len(definitions)}", positive=True)
        expr = expr.xreplace(
            {p: symbol ** (2 * p.exp) for p in expr.atoms(sp.Pow) if p.base == base and sp.denom(p.exp) == 2}
        )
        definitions.append((symbol, sp.sqrt(base)))
    for power in sorted(expr.atoms(sp.Pow), key=sp.default_sort_key):
        if power.base.is_Add and power.exp.is_negative and width(latex(power.base, names)) > LINE / 2:
            symbol = sp.Dummy("denominator", positive=True)
            expr = expr.xreplace({power: symbol**power.exp})
            definitions.append((symbol, power.base))
    initial = letter(expr, names)
    new = {
        symbol: sp.Symbol(initial if len(definitions) == 1 else f"{initial}_{number}", positive=True)
        for number, (symbol, _) in enumerate(definitions, 1)
    }
    known = dict(names) | notation_of(symbol.name for symbol in new.values())
    return expr.xreplace(new), [(new[symbol], value.xreplace(new)) for symbol, value in definitions], known


def letter(expr: Expr, names: Mapping[str, str]) -> str:
    """Return a letter that begins no name here, neither as it is given nor as it is printed."""
    written = [*names, *names.values(), *(symbol.name for symbol in expr.atoms(sp.Symbol))]
    free = (one for one in _LETTERS if not any(look(name).startswith(one) for name in written))
    return next(free, "Q")
