"""`Derivation`: a list of steps, each with its operation, its reason, its result and a computed verdict."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from textwrap import shorten

import sympy as sp

from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.status import Status
from stickslip_sym.core.symbols import QUANTITIES
from stickslip_sym.formula.proof.proving import Verdict, prove_equal, prove_positive
from stickslip_sym.formula.proof.theorems import By
from stickslip_sym.output import markup, printing
from stickslip_sym.output.abbreviation import equation
from stickslip_sym.output.data import DataResult
from stickslip_sym.output.layout import prose
from stickslip_sym.output.notation import distinct_notation, notation_of

_LONGEST = 200  # characters of a result in a line of text


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
    """

    reported = ("operation", "reason", "statement", "verdict", "label")

    operation: str
    reason: str
    statement: Expr
    verdict: Verdict
    label: str = ""
    by: By | None = None
    lhs: Expr | None = None

    def __repr__(self) -> str:
        label = f" {self.label}" if self.label else ""
        result = shorten(printing.text(self.statement), _LONGEST, placeholder=" ...")
        return f"Step{label}: {self.operation}: {result}, {self.verdict.status.value}"

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {printing.latex(self.statement)}$"


@dataclass
class Derivation(DataResult):
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
        rhs: Expr,
        *,
        label: str = "",
        by: By | None = None,
        shown: Expr | None = None,
    ) -> Expr:
        """Add the step lhs = rhs, prove or refute it, and return `rhs`.

        `shown` is what the equation is printed as, when the left side has a name.
        """
        statement = sp.Eq(lhs if shown is None else shown, rhs, evaluate=False)
        self.steps.append(Step(operation, reason, statement, prove_equal(lhs, rhs, by), label, by, lhs))
        return rhs

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

    def latex(self, names: Mapping[str, str] | None = None, *, heading: str | None = None) -> str:
        """Return the steps as LaTeX paragraphs with displayed equations that fit a text of 120 mm.

        Parameters
        ----------
        names : mapping of str to str, optional
            LaTeX of symbols that shall not be written as usual.
        heading : str, optional
            LaTeX that stands above instead of the title.
        """
        known = notation_of(QUANTITIES) | {"mu": r"\mu"} | dict(names or {})
        names = self._names(names)
        parts = [f"\\paragraph{{{heading or prose(self.title, known)}.}}"]
        for step in self.steps:
            statement = step.statement
            shown = equation(
                printing.latex(statement.lhs, names),
                statement.rhs,
                names,
                relation=statement.rel_op.replace("==", "="),
                tag=step.label,
            )
            words = f"{prose(step.operation, known)}: {prose(step.reason, known)}."
            parts.append(f"{words[0].upper()}{words[1:]}\n{shown}\n% {step.verdict.status.value}")
        return "\n\n".join(parts) + "\n"

    def _names(self, given: Mapping[str, str] | None = None) -> dict[str, str]:
        """Return the LaTeX of every symbol, the same in all steps."""
        symbols = {symbol for step in self.steps for symbol in step.statement.atoms(sp.Symbol)}
        return distinct_notation((symbol.name for symbol in symbols if not symbol.is_Dummy), given or {})

    def _repr_html_(self) -> str:
        names = self._names()
        rows = [
            [
                f"{number} {step.label}".strip(),
                step.operation,
                step.reason,
                markup.formula(f"\\displaystyle {printing.latex(step.statement, names)}"),
                str(step.verdict),
            ]
            for number, step in enumerate(self.steps, 1)
        ]
        header = ["step", "what is done", "because", "result", "verdict"]
        return markup.table(header, rows, caption=f"{self.title} [{self.status.value}]")

    def _repr_latex_(self) -> str:
        names = self._names()
        rows = " \\\\\n".join(printing.latex(step.statement, names).replace("=", "&=", 1) for step in self.steps)
        return f"$$\\begin{{aligned}}\n{rows}\n\\end{{aligned}}$$"

    def __repr__(self) -> str:
        return f"Derivation: {self.name}, {len(self.steps)} steps, {self.status.value}"
