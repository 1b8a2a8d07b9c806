"""Long formulas made readable, as LaTeX and as lines of text: what stands in them repeatedly gets a letter."""

from collections import Counter
from collections.abc import Mapping
from operator import itemgetter
from textwrap import fill

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.output.layout import LINE, displayed, width
from stickslip_sym.output.notation import look, notation_of
from stickslip_sym.output.printing import latex
from stickslip_sym.output.tables import WIDTH
from stickslip_sym.output.text_printer import text

_LETTERS = "qphrwgz"
_BLOCK = 40  # characters from which on what stands repeatedly gets a letter, roots always
_LONG = 400  # characters of a formula as text from which on it is broken
_INDENT = "  "
Definitions = list[tuple[Expr, Expr]]


def equation(
    left: str, right: Expr, names: Mapping[str, str], letters: Mapping[Expr, Expr] | None = None, **style: str
) -> str:
    """Return a displayed equation with a side that is LaTeX already, and the definitions that follow it.

    In a formula that is wider than a line wide denominators, which cannot be broken, get letters too.

    - `letters`: symbols of the right side, and the numbers that they stand for.
    - `style`: what `displayed` takes.
    """
    known, definitions = dict(names), Definitions()
    if width(latex(right, names)) > LINE:
        right, definitions = _repeated(right)
        for power in sorted(right.atoms(sp.Pow), key=sp.default_sort_key):
            if power.base.is_Add and power.exp.is_negative and width(latex(power.base, names)) > LINE / 2:
                symbol = sp.Dummy("denominator", positive=True)
                right = right.xreplace({power: symbol**power.exp})
                definitions.append((symbol, power.base))
        right, definitions = _with_letters(right, definitions, names)
        known |= notation_of(symbol.name for symbol, _ in definitions)
    shown = displayed(left, latex(right, known), **style)
    where = [displayed(known[symbol.name], latex(value, known)) for symbol, value in definitions]
    used = set().union(right.free_symbols, *(value.free_symbols for _, value in definitions))
    numbers = [
        f"${latex(symbol, known)} = {latex(value, inline=True)}$"
        for symbol, value in (letters or {}).items()
        if symbol in used
    ]
    parts = [shown, *(["where", *where] if where else []), *([f"where {', '.join(numbers)}."] if numbers else [])]
    return "\n".join(parts)


def formula(left: str, expr: Expr) -> str:
    """Return an equation as indented text: ``left = expr``, in a long one letters for what stands repeatedly."""
    if len(text(expr)) <= _LONG:
        return f"{_INDENT}{left} = {text(expr)}"
    expr, definitions = _with_letters(*_repeated(expr), {})
    where = [f"{_INDENT}where"] if definitions else []
    return "\n".join(
        [_wrapped(left, expr), *where, *(_wrapped(letter.name, value) for letter, value in definitions)]
    )


def _wrapped(left: str, expr: Expr) -> str:
    return fill(
        f"{left} = {text(expr)}", WIDTH, initial_indent=_INDENT, subsequent_indent=3 * _INDENT,
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip


def _repeated(expr: Expr) -> tuple[Expr, Definitions]:
    """Give symbols to what stands repeatedly: the simplest roots first, then the longest other parts."""
    definitions = Definitions()
    while True:
        nodes = [node for node in sp.preorder_traversal(expr) if isinstance(node, sp.Expr) and node.args]
        roots = Counter(node.base for node in nodes if _is_root(node))
        bases = [base for base, count in roots.items() if count > 1]
        blocks = [node for node, count in Counter(nodes).items() if count > 1]
        if bases:
            base = min(bases, key=lambda base: (base.count_ops(), sp.default_sort_key(base)))
            symbol = sp.Dummy("root", positive=True)
            powers = {node for node in nodes if _is_root(node) and node.base == base}
            definitions.append((symbol, sp.sqrt(base)))
            expr = expr.xreplace({power: symbol ** (2 * power.exp) for power in powers})
            continue
        sized = [(len(shown := text(node)), shown, node) for node in blocks]
        size, _, block = max(sized, key=itemgetter(0, 1), default=(0, "", None))  # two roots may be printed alike
        if size < _BLOCK:
            return expr, definitions
        definitions.append((sp.Dummy("block"), block))
        expr = expr.xreplace({block: definitions[-1][0]})


def _is_root(node: Expr) -> bool:
    return bool(node.is_Pow and node.base.is_Add and sp.denom(node.exp) == 2)


def _with_letters(expr: Expr, definitions: Definitions, names: Mapping[str, str]) -> tuple[Expr, Definitions]:
    """Call the symbols by a letter that begins no other name here, neither as it is given nor as it is printed."""
    own = {symbol for symbol, _ in definitions}
    others = set().union(expr.free_symbols, *(value.free_symbols for _, value in definitions)) - own
    written = [*names, *names.values(), *(symbol.name for symbol in others)]
    free = (letter for letter in _LETTERS if not any(look(name).startswith(letter) for name in written))
    letter = next(free, "Q")
    new = {
        symbol: sp.Symbol(letter if len(definitions) == 1 else f"{letter}_{number}", positive=symbol.is_positive)
        for number, (symbol, _) in enumerate(definitions, 1)
    }
    return expr.xreplace(new), [(new[symbol], value.xreplace(new)) for symbol, value in definitions]
