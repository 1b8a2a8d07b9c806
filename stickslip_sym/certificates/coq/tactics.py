"""What scripts in Coq have in common: letters, lemmas of the library, tactics for equations between formulas."""

import re
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from string import Template

import sympy as sp

from stickslip_sym.certificates.coq.printer import NAMED, CoqPrinter, Names
from stickslip_sym.certificates.coq.words import (
    HYPERBOLIC,
    Generators,
    depth,
    differs,
    functions_of,
    is_monomial,
    require_independent,
    rewrite_for_coq,
    roots_of,
    square_free,
    two_factors,
)
from stickslip_sym.certificates.python_printer import WIDTH
from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Condition, Expr, Substitution
from stickslip_sym.formula.closed_form import ClosedForm


def _named_parts(name: str) -> dict[str, str]:
    """Return the parts of a file beside this one, each of which begins with a comment "# name", by their names."""
    text = Path(__file__).with_name(name).read_text(encoding="utf-8")
    return dict(re.findall(r"\(\*# (\w+) \*\)\n(.*?)(?=\(\*# |\Z)", text, re.DOTALL))


LIBRARY, TEMPLATE = _named_parts("library.v"), _named_parts("template.v")

_MADE = r"(?:Lemma|Definition|Ltac|Instance) (\w+)"
_ALWAYS = ("tactics",)
_WORDS_OF = {"hyperbolic": ("tanh", "sinh", "cosh"), "bounds": ("scaled",), "arcsinh": ("arcsinh",)}
"""What stands in a script that needs a part of the library, beside the names that the part makes."""

_VALUES = {
    "exp": "0", "ln": "1", "atan": "0", "arcsinh": "0", "erf": "0", "sqrt": "1", "power": "0", "lower_gamma": "0",
    "sin": "0", "cos": "0",
}  # fmt: skip
"""Arguments at which the library, or Coq's own, has a lemma on the value of a function."""

ROOT_OF_PRODUCT = "rewrite ?sqrt_mult by (solve [assumption | apply Rlt_le; positive])"
_BY_EXPONENTIALS = ("Rpower", "power", "erf", "lower_gamma")
"""Functions that are unfolded to exponentials, or whose derivatives hold one."""


class Script:
    """The letters and the texts of a script on a closed form."""

    def __init__(self, form: ClosedForm) -> None:
        self.form = form if form.general is None else form.general
        self.title = f"{form.criterion.name.replace('_', ' ')}: mu(v) = {self.form.law.text}"
        if form.general is not None:
            values = ", ".join(f"{letter} = {value}" for letter, value in form.meanings.items())
            self.title += f"\n   Here {values}, in the law {form.law.text}"
        self.v = sp.Symbol("v", positive=True)
        self.letters = sorted(self.form.law.expr.free_symbols - {symbols.v}, key=str)
        made = re.findall(_MADE, "\n".join(LIBRARY.values()))
        self._safe = Names(" ".join([*TEMPLATE.values(), *made, *NAMED.values(), *_VALUES, "R PI Rmin Rmax"]))
        self.names: dict[Expr, str] = {self.v: "v", symbols.V: "V", symbols.N: "N"}
        for letter in self.letters:
            self.name(letter)

    # -- texts ---------------------------------------------------------------------------------------

    def name(self, letter: Expr) -> str:
        """Return the name of a letter, the same each time."""
        if letter not in self.names:
            self.names[letter] = self._safe.new(letter.name)
        return self.names[letter]

    @property
    def printer(self) -> CoqPrinter:
        """A printer with the names of all letters so far."""
        return CoqPrinter(self.names)

    def code(self, expr: Expr) -> str:
        """Return an expression in Coq."""
        return self.printer.doprint(expr)

    def whole(self, expr: Expr) -> str:
        """Return an expression in Coq as an argument."""
        return self.printer.whole(expr)

    def part(self, name: str, **values: object) -> str:
        """Return a part of the template with its values."""
        return Template(TEMPLATE[name]).substitute(values)

    def words(self, expr: Expr, speed: Expr) -> Expr:
        """Return an expression of the package in the words of a script, with another letter for the slip speed."""
        return rewrite_for_coq(sp.sympify(expr).xreplace({symbols.v: speed}), speed)

    def hypotheses(
        self,
        letters: Iterable[Expr],
        excluded: Iterable[Expr],
        relations: Iterable[Condition] = (),
        label: str = "",
    ) -> str:
        """Return what is assumed of letters: their signs, relations, and that no denominator vanishes."""
        lines = list[str]()
        for letter in letters:
            if letter.is_nonnegative:
                sign = "<" if letter.is_positive else "<="
                lines.append(f"Hypothesis {self.name(letter)}_sign : 0 {sign} {self.name(letter)}.")
        for i, relation in enumerate(relations):
            lines.append(
                f"Hypothesis relation{label}{i} : {self.whole(relation.lts)} < {self.whole(relation.gts)}."
            )
        lines += [f"Hypothesis excluded{label}{i} : {self.code(expr)} <> 0." for i, expr in enumerate(excluded)]
        return "\n".join(lines)

    def law(self, mu: Expr, c: str, excluded: Iterable[Expr], kernel: str = "") -> str:
        """Return the statement: letters, what is assumed of them, the law and the closed form, in Coq."""
        letters = [symbols.N, symbols.V, *self.letters]
        hypotheses = self.hypotheses(letters, excluded, self.form.conditions)
        names = " ".join(map(self.name, letters))
        return self.part("law", kernel=kernel, letters=names, hypotheses=hypotheses, mu=self.code(mu), c=c)

    def assembled(self, law: str, proof: str) -> str:
        """Return a script with those parts of the library that it needs."""
        text = law + proof
        needed = list[str]()
        for name, lemmas in reversed(LIBRARY.items()):  # each needs those before it only
            words = {*_WORDS_OF.get(name, ()), *re.findall(_MADE, lemmas)}
            if name in _ALWAYS or words & set(
                re.findall(r"\w+", re.sub(r"\(\*.*?\*\)", "", text, flags=re.DOTALL))
            ):
                needed.insert(0, name)
                text = lemmas + text
        library = "\n".join(_kept_lemmas(LIBRARY[name], needed).rstrip() for name in needed)
        head = self.part("head", title=_comment_text(self.title), library=library)
        return "\n".join(map(_wrap_line, (head + law + proof + TEMPLATE["end"]).splitlines())) + "\n"

    # -- equations -----------------------------------------------------------------------------------

    def equation(
        self, generators: Generators, *exprs: Expr, values: bool = True, moves: Iterable[str] = ()
    ) -> str:
        """Return tactics that prove an equation between formulas in which these expressions stand.

        Functions are written in the generators first, then take their values at 0 and 1, and equal ones are given
        one text; `field` does the rest. `moves` come before all that.
        """
        written = [generators.of(expr) for expr in exprs]
        require_independent(roots_of(*written))
        radicands = [square_free(root.args[0])[0] for root in roots_of(*exprs)]
        parts = list[Expr]()
        for radicand in filter(is_monomial, radicands):
            parts += radicand.args
        roots = [*roots_of(*written), *map(sp.Function("sqrt"), sorted(parts, key=str))]
        facts, using = self.facts(list(dict.fromkeys(roots)))
        tactics = [*moves, *self.rewritten(generators, *exprs)]
        if values:
            tactics += self.valued(using, *written)
        facts = facts.replace(". ", "; ")  # one sentence, which all cases of an equation share
        return f"{facts}{'; '.join([*tactics, *self.unified(using, *written), solved(using)])}."

    def facts(self, roots: Sequence[Expr]) -> tuple[str, str]:
        """Return tactics that state root * root = radicand, and how `field` is to use it."""
        facts = ""
        for i, root in enumerate(roots):
            y = self.whole(root.args[0])
            facts += f"assert (square{i} : sqrt {y} * sqrt {y} = {y}) by square_of_root. "
        return facts, f" [{' '.join(f'square{i}' for i in range(len(roots)))}]" if roots else ""

    def rewritten(self, generators: Generators, *exprs: Expr) -> Iterator[str]:
        """Yield tactics that write functions of formulas in the generators."""
        if any(isinstance(node, HYPERBOLIC) for expr in exprs for node in sp.preorder_traversal(expr)):
            yield "rewrite ?tanh_is, ?cosh_is, ?sinh_is"
        made = [square_free(root.args[0]) for root in roots_of(*exprs)]
        yield from self.one_roots(made)
        if any(is_monomial(radicand) for radicand, _ in made):
            yield ROOT_OF_PRODUCT
        for radicand in sorted({radicand for radicand, _ in made if not is_monomial(radicand)}, key=str):
            if parts := [f"sqrt {self.whole(part)}" for part in two_factors(radicand)]:
                yield (
                    f"replace (sqrt {self.whole(radicand)}) with ({' * '.join(parts)}) "
                    "by (rewrite <- sqrt_mult by (apply Rlt_le; positive); f_equal; ring)"
                )
        for node in sorted(generators.exponentials(exprs), key=sp.default_sort_key):
            written = generators.of(node)
            if written != sp.Function("exp")(node.args[0]):
                yield f"exponential {self.whole(generators.argument(node))} {self.whole(written)}"

    def one_roots(self, roots: Iterable[tuple[Expr, Expr]]) -> Iterator[str]:
        """Yield tactics that write roots by those of radicands without squares, each with its divisor."""
        for radicand, divisor in sorted(set(roots), key=str):
            yield f"one_root {self.whole(radicand)} {self.whole(divisor)}"

    def valued(self, using: str, *exprs: Expr, at: Sequence[Substitution] = ({},)) -> Iterator[str]:
        """Yield tactics for the values of functions at 0 and 1, where letters are as in `at`."""
        for head in self.heads(*exprs):
            name = head.strip("()").split()[0]
            if name in _VALUES and self._may_be(name, sp.Integer(_VALUES[name]), exprs, at):
                yield f"value {head} {_VALUES[name]} by {_equality_tactic(using)}"
                yield f"rewrite ?{name}_{_VALUES[name]}"
            if name == "sqrt" and self._may_be(name, sp.S.Zero, exprs, at):
                yield f"value sqrt 0 by {_equality_tactic(using)}"
                yield "rewrite ?sqrt_0"
            if name == "atan":
                if self._may_be(name, sp.S.One, exprs, at):
                    yield "rewrite ?atan_1"
                if any(expr.has(sp.Function("sqrt")(3)) for expr in exprs):
                    yield f"value atan (sqrt 3 / 3) by {_equality_tactic(using)}"
                    yield "rewrite ?atan_sixth"

    def _may_be(self, name: str, value: Expr, exprs: Sequence[Expr], at: Sequence[Substitution]) -> bool:
        """Tell whether a function may stand at a value in some expressions: no number tells it from that."""
        nodes = functions_of(*exprs)
        if name == "exp" and any(node.func.__name__ in _BY_EXPONENTIALS for node in nodes):
            return True
        bases = [node.args[0] for node in nodes if node.func.__name__ == "Rpower"]
        arguments = [node.args[-1] for node in nodes if NAMED.get(node.func.__name__, node.func.__name__) == name]
        arguments += [node.args[-1] for node in nodes if name == "ln" and node.func.__name__ == "power"]
        if name == "ln":
            arguments += bases
        return any(not differs(argument.xreplace(letters), value) for argument in arguments for letters in at)

    def unified(self, using: str, *exprs: Expr) -> Iterator[str]:
        """Yield tactics that give equal arguments of a function one text; `using` are squares of roots."""
        if has_powers(*exprs):
            powers = [head for head in self.heads(*exprs) if head.startswith("(power ")]
            yield from (f"same {head} by {_equality_tactic(using)}" for head in powers)
            yield "split_powers"
            yield "rewrite ?ln_1, ?Rmult_0_r, ?exp_0"
        for head in self.heads(*exprs):
            yield f"same {head} by {_equality_tactic(using)}"

    def heads(self, *exprs: Expr) -> list[str]:
        """Return the functions of formulas as they stand before their last argument, inner ones first.

        A function that stands both within another and around it comes twice.
        """
        levels = dict[int, set[str]]()
        for node in functions_of(*exprs):
            level = depth(node)
            name = node.func.__name__
            head = self.printer.head(node)
            levels.setdefault(level, set()).add("ln" if name == "Rpower" else f"({head})" if " " in head else head)
            if name in _BY_EXPONENTIALS:
                levels.setdefault(level + 1, set()).add("exp")
            if name == "lower_gamma":
                levels[level].add(f"(power {self.whole(node.args[1])})")
        return [head for level in sorted(levels) for head in sorted(levels[level])]


def solved(using: str) -> str:
    """Return a tactic for an equation, which may need the squares of roots."""
    return f"first [field; positive | field{using}; positive]" if using else "field; positive"


def _equality_tactic(using: str) -> str:
    """Return a tactic for equal arguments of functions, which may need the squares of roots."""
    return f"with_roots (field{using})" if using else "equal"


def has_powers(*exprs: Expr) -> bool:
    """Tell whether there are powers whose exponents are no whole numbers."""
    return any(node.func.__name__ in ("power", "Rpower") for node in functions_of(*exprs))


def unfolded(*exprs: Expr) -> str:
    """Return what else is unfolded where these expressions stand."""
    if any(node.func.__name__ == "Rpower" for node in functions_of(*exprs)):
        return ", Rpower"
    return ""


def _kept_lemmas(lemmas: str, needed: Sequence[str]) -> str:
    """Return lemmas without the lines for parts of the library that a script does not need: (*? powers *)."""
    lines = [line.partition("  (*? ") for line in lemmas.splitlines()]
    return "\n".join(line for line, _, part in lines if not part or part.removesuffix(" *)") in needed)


def _wrap_line(line: str) -> str:
    """Return a line as several where it is long."""
    indent = " " * (len(line) - len(line.lstrip()) + 2)
    lines = textwrap.wrap(line, WIDTH, subsequent_indent=indent, break_long_words=False, break_on_hyphens=False)
    return "\n".join(lines)


def _comment_text(text: str) -> str:
    """Return text that may stand in a comment of Coq."""
    return text.replace('"', "'").replace("(*", "( *").replace("*)", "* )")
