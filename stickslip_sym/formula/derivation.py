"""`Derivation`: a list of steps, each with its operation, its reason, its result and a computed verdict."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

import sympy as sp

from stickslip_sym.core.aliases import Condition, Expr, Notation, Substitution
from stickslip_sym.core.status import Status
from stickslip_sym.core.symbols import QUANTITIES, V, v
from stickslip_sym.formula.proof.proving import Verdict, prove_equal, prove_positive
from stickslip_sym.formula.proof.theorems import By
from stickslip_sym.output import printing
from stickslip_sym.output.abbreviation import displayed_equation
from stickslip_sym.output.data import DataResult
from stickslip_sym.output.layout import prose_latex
from stickslip_sym.output.notation import distinct_notation, notation_of
from stickslip_sym.output.shown import Shown, views_of


@dataclass(frozen=True)
class Step(DataResult):
    """One step of a derivation.

    Attributes
    ----------
    operation : str
        What is done.
    reason : str
        Why it may be done.
    statement : sympy.Rel
        The equation or inequality that results.
    verdict : Verdict
        What computing it showed.
    label : str
        The number of the equation in its source, like "(16)", or empty.
    by : By, optional
        The theorem by which it was proved, with all that checking it takes.
    lhs : sympy.Expr, optional
        What was proved equal to the right side, where `statement` gives it a name; what was proved positive, its
        derivatives not carried out.
    formulas : tuple of sympy.Basic
        The formulas that stand in `operation` and `reason` as text.
    meanings : tuple of mapping
        What v, V and other symbols of the statement are in terms of the law, for each of its terms, where v and V
        are speeds in units of a scale.
    """

    reported = ("operation", "reason", "statement", "verdict", "label")

    operation: str
    reason: str
    statement: Condition
    verdict: Verdict
    label: str = ""
    by: By | None = None
    lhs: Expr | None = None
    formulas: tuple[Expr | Condition, ...] = ()
    meanings: tuple[Substitution, ...] = ()

    def __repr__(self) -> str:
        return views_of(self).one_line(self)

    def _repr_latex_(self) -> str:
        return views_of(self).notebook_latex(self)


@dataclass
class Derivation(Shown, DataResult):
    """A chain of proved steps from what is given to a result.

    Attributes
    ----------
    name : str
    title : str
        One line that says what is derived from what.
    steps : list of Step
    """

    name: str
    title: str
    steps: list[Step] = field(default_factory=list)

    def equal(
        self,
        operation: str,
        reason: str,
        lhs: Expr,
        rhs: Expr | int,
        *,
        label: str = "",
        by: By | None = None,
        shown: Expr | None = None,
        formulas: tuple[Expr | Condition, ...] = (),
    ) -> Expr:
        """Add the step lhs = rhs, prove or refute it, and return `rhs`.

        `shown` is what the equation is printed as, when the left side has a name; `formulas` stand in the words.
        """
        right = sp.sympify(rhs)
        statement = sp.Eq(lhs if shown is None else shown, right, evaluate=False)
        verdict = prove_equal(lhs, right, by)
        self.steps.append(Step(operation, reason, statement, verdict, label, by, lhs, formulas))
        return right

    def positive(self, operation: str, reason: str, expr: Expr, *, label: str = "") -> None:
        """Add the step expr > 0 with its derivatives carried out, and prove or refute it."""
        value = expr.replace(sp.Derivative, sp.diff)
        statement = sp.Gt(value, 0, evaluate=False)
        self.steps.append(Step(operation, reason, statement, prove_positive(value), label, lhs=expr))

    @property
    def status(self) -> Status:
        """The weakest verdict among the steps."""
        return Status.weakest(step.verdict.status for step in self.steps)

    def __getitem__(self, label: str) -> Step:
        """Return the step with an equation number, e.g. ``derivation["(16)"]``."""
        labelled = {step.label: step for step in self.steps if step.label}
        if label not in labelled:
            raise KeyError(f"no step is labelled {label!r}; there are: {', '.join(labelled)}")
        return labelled[label]

    def text(self) -> str:
        """Return the steps as plain text, one equation a line."""
        lines = [f"{self.title}  [{self.status.value}]"]
        for number, step in enumerate(self.steps, 1):
            lines += [
                "",
                f"{number}. {step.operation}  {step.label}".rstrip(),
                f"   because {step.reason}",
                f"   {printing.text(step.statement)}",
                f"   {step.verdict}",
            ]
        return "\n".join(lines)

    def latex(self, names: Notation | None = None, *, heading: str | None = None) -> str:
        """Return the steps as LaTeX paragraphs with displayed equations that fit a text of 120 mm.

        Parameters
        ----------
        names : mapping of str to str, optional
            LaTeX of symbols that shall not be written as usual.
        heading : str, optional
            LaTeX that stands above instead of the title.
        """
        # Parameters of a law are no words of these sentences: an a is an article.
        known = notation_of(QUANTITIES) | {"mu": r"\mu"}
        known |= {name: latex for name, latex in (names or {}).items() if name in known}
        names = self.notation(names)
        title = _sentence_latex(self.title, [step.statement for step in self.steps[:1]], known, names)
        parts = [f"\\paragraph{{{heading or title}.}}"]
        for step in self.steps:
            statement = step.statement
            written = _hat_scaled_speeds(step, names)
            shown = displayed_equation(
                printing.latex(statement.lhs, written),
                statement.rhs,
                written,
                relation=statement.rel_op.replace("==", "="),
                tag=step.label,
            )
            here = known | {name: latex for name, latex in written.items() if name in known}
            said = [_sentence_latex(text, step.formulas, here, written) for text in (step.operation, step.reason)]
            words = ": ".join(said)
            units = _units(step, names, written)
            parts.append(f"{words[0].upper()}{words[1:]}{units}.\n{shown}\n% {step.verdict.status.value}")
        return "\n\n".join(parts) + "\n"

    def notation(self, given: Notation | None = None) -> dict[str, str]:
        """Return the LaTeX of every symbol, the same in all steps."""
        symbols = {symbol for step in self.steps for symbol in step.statement.atoms(sp.Symbol)}
        return distinct_notation((symbol.name for symbol in symbols if not symbol.is_Dummy), given or {})

    def _repr_latex_(self) -> str:
        return views_of(self).notebook_latex(self)

    def __repr__(self) -> str:
        return f"Derivation: {self.name}, {len(self.steps)} steps, {self.status.value}"


def _sentence_latex(text: str, formulas: Sequence[Expr | Condition], known: Notation, names: Notation) -> str:
    """Return a sentence as LaTeX, the formulas in it as formulas, wherever they stand there as text."""
    for formula in formulas:
        found = re.search(rf"(?<!\w){re.escape(printing.text(formula))}(?!\w)", text)
        if found is not None:
            others = [other for other in formulas if other is not formula]
            before = text[: found.start()]
            after = text[found.end() :]
            shown = f"${printing.latex(formula, names, inline=True)}$"
            return (
                _sentence_latex(before, others, known, names)
                + shown
                + _sentence_latex(after, others, known, names)
            )
    return prose_latex(text, known)


def _hat_scaled_speeds(step: Step, names: Notation) -> dict[str, str]:
    """Return names with a hat on each speed that is in units of a scale, so that a letter means one thing."""
    usual = notation_of(QUANTITIES) | dict(names)
    hats = dict(names)
    for meaning in step.meanings:
        for speed in (v, V):
            if meaning.get(speed, speed) != speed:
                hats[speed.name] = f"\\hat{{{usual[speed.name]}}}"
    return hats


def _units(step: Step, names: Notation, written: Notation) -> str:
    """Say what the speeds in units of a scale, and the shapes of a profile, are."""
    lists = []
    for meaning in step.meanings:
        said = {symbol: value for symbol, value in meaning.items() if symbol != value}
        of_term = [
            f"${printing.latex(symbol, written)} = {printing.latex(value, names, inline=True)}$"
            for symbol, value in said.items()
            if step.statement.has(symbol) or symbol in (v, V)
        ]
        lists.append(", ".join(of_term))
    lists = [text for text in dict.fromkeys(lists) if text]
    if lists:
        return f"; here {', or '.join(lists)}"
    return ""
