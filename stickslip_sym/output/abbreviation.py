"""Long formulas made readable, as LaTeX and as lines of text: what stands in them repeatedly gets a letter."""

from collections import Counter
from functools import cache
from operator import itemgetter
from textwrap import fill

import sympy as sp

from stickslip_sym.core.aliases import Expr, Notation, Substitution
from stickslip_sym.output.layout import LINE, displayed, width
from stickslip_sym.output.notation import look, notation_of
from stickslip_sym.output.printing import latex, latex_value
from stickslip_sym.output.tables import TERMINAL_WIDTH
from stickslip_sym.output.text_printer import text

_LETTERS = "qphrwgz"
_CHARACTERS_TO_SAVE = 40  # characters that a letter for what stands repeatedly must save; roots always have one
_LEAST_BLOCK = {False: 40, True: 10}  # characters of what gets a letter, in a formula and in one of many lines
_MANY_LINES = 4.0  # from which on short blocks, and the terms of the sum, get letters too
_CHARACTERS_OF_LINE = 400  # characters of a formula as text from which on it is broken
_INDENT = "  "
Definitions = list[tuple[Expr, Expr]]


def displayed_equation(
    left: str, right: Expr, names: Notation, letters: Substitution | None = None, **style: str
) -> str:
    """Return a displayed equation with a side that is LaTeX already, and the definitions that follow it.

    In a formula that is wider than a line wide denominators, which cannot be broken, get letters too.

    - `letters`: symbols of the right side, and the numbers that they stand for.
    - `style`: what `displayed` takes.
    """
    known = dict(names)
    definitions = Definitions()
    wide = width(latex(right, names))
    if wide > LINE:
        right, definitions = _repeated(right, is_long=wide > _MANY_LINES * LINE)
        for power in sorted(right.atoms(sp.Pow), key=sp.default_sort_key):
            if power.base.is_Add and power.exp.is_negative and width(latex(power.base, names)) > LINE / 2:
                symbol = sp.Dummy("denominator", positive=True)
                right = right.xreplace({power: symbol**power.exp})
                definitions.append((symbol, power.base))
        right, terms = _summed(right, names)
        right, definitions = _assign_letters(right, [*definitions, *terms], names)
        known |= notation_of(symbol.name for symbol, _ in definitions)
    shown = displayed(left, latex(right, known), **style)
    used = set().union(right.free_symbols, *(value.free_symbols for _, value in definitions))
    where = [displayed(known[symbol.name], latex(value, known)) for symbol, value in definitions]
    numbers = [
        f"${latex(symbol, known)} = {latex_value(value)}$"
        for symbol, value in (letters or {}).items()
        if symbol in used
    ]
    said = ""
    if numbers:
        said = f"{'with' if where else 'where'} {_listed(numbers)}."
    return "\n".join([shown, *(["where", *where] if where else []), *([said] if said else [])])


def _listed(items: list[str]) -> str:
    """Return items as a list in a sentence."""
    return " and ".join(filter(None, [", ".join(items[:-1]), items[-1]]))


def _summed(expr: Expr, names: Notation) -> tuple[Expr, Definitions]:
    """Give symbols to the wide terms of a sum of many lines."""
    if not expr.is_Add or width(latex(expr, names)) < _MANY_LINES * LINE:
        return expr, Definitions()
    terms: Definitions = [
        (sp.Dummy("term", real=True), term) for term in expr.args if width(latex(term, names)) > LINE
    ]
    return expr.xreplace({term: symbol for symbol, term in terms}), terms


def indented_equation(left: str, expr: Expr) -> str:
    """Return an equation as indented text: ``left = expr``, in a long one letters for what stands repeatedly."""
    if len(text(expr)) <= _CHARACTERS_OF_LINE:
        return f"{_INDENT}{left} = {text(expr)}"
    expr, definitions = _assign_letters(
        *_repeated(expr, is_long=len(text(expr)) > _MANY_LINES * _CHARACTERS_OF_LINE), {}
    )
    where = [f"{_INDENT}where"] if definitions else []
    return "\n".join(
        [_wrapped(left, expr), *where, *(_wrapped(letter.name, value) for letter, value in definitions)]
    )


def _wrapped(left: str, expr: Expr) -> str:
    return fill(
        f"{left} = {text(expr)}", TERMINAL_WIDTH, initial_indent=_INDENT, subsequent_indent=3 * _INDENT,
        break_long_words=False, break_on_hyphens=False,
    )  # fmt: skip


def _repeated(expr: Expr, *, is_long: bool) -> tuple[Expr, Definitions]:
    """Give symbols to what stands repeatedly: the simplest roots first, then the longest other parts.

    In a formula that `is_long`, shorter parts have one too if they stand there often.
    """
    definitions = Definitions()
    written = cache(text)
    while True:
        nodes = [node for node in sp.preorder_traversal(expr) if isinstance(node, sp.Expr) and node.args]
        roots = Counter(node.base for node in nodes if _is_root(node))
        bases = [base for base, count in roots.items() if count > 1]
        if bases:
            base = min(bases, key=lambda base: (base.count_ops(), sp.default_sort_key(base)))
            symbol = sp.Dummy("root", positive=True)
            powers = {node for node in nodes if _is_root(node) and node.base == base}
            definitions.append((symbol, sp.sqrt(base)))
            expr = expr.xreplace({power: symbol ** (2 * power.exp) for power in powers})
            continue
        sized = [
            (len(written(node)), written(node), node)
            for node, count in Counter(nodes).items()
            if (count - 1) * len(written(node)) >= _CHARACTERS_TO_SAVE
            and len(written(node)) >= _LEAST_BLOCK[is_long]
            and node.has(sp.Add, sp.Function)  # a^4 is read as it stands
        ]
        if not sized:
            return expr, definitions
        *_, block = max(sized, key=itemgetter(0, 1))  # two roots may be printed alike
        definitions.append((sp.Dummy("block", positive=block.is_positive), block))
        expr = expr.xreplace({block: definitions[-1][0]})


def _is_root(node: Expr) -> bool:
    return bool(node.is_Pow and node.base.is_Add and sp.denom(node.exp) == 2)


def _assign_letters(expr: Expr, definitions: Definitions, names: Notation) -> tuple[Expr, Definitions]:
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
