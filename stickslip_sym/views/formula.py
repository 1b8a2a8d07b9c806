"""What is shown of closed forms and of the steps that lead to them."""

from textwrap import shorten

from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.formula.derivation import Derivation, Step
from stickslip_sym.output import printing
from stickslip_sym.views import dispatch, markup

_MOST_TEXT_CHARACTERS = 200  # characters of a result in a line of text


@dispatch.notebook_html.register(ClosedForm)
def form_as_html(form: ClosedForm) -> str:
    """Return what it is of, the formula and the verdict."""
    where = f"{form.law.name or form.law.text}, {form.criterion.name}: damping coefficient in kg/s"
    return markup.block(where, markup.inline_formula(f"\\displaystyle {form.latex()}"), str(form.verdict))


@dispatch.notebook_latex.register(ClosedForm)
def form_as_latex(form: ClosedForm) -> str:
    """Return the formula."""
    return f"$\\displaystyle {form.latex()}$"


@dispatch.one_line.register(Step)
def step_in_a_line(step: Step) -> str:
    """Return what was done, the result and the verdict."""
    label = f" {step.label}" if step.label else ""
    result = shorten(printing.text(step.statement), _MOST_TEXT_CHARACTERS, placeholder=" ...")
    return f"Step{label}: {step.operation}: {result}, {step.verdict.status.value}"


@dispatch.notebook_latex.register(Step)
def step_as_latex(step: Step) -> str:
    """Return the result."""
    return f"$\\displaystyle {printing.latex(step.statement)}$"


@dispatch.notebook_html.register(Derivation)
def derivation_as_html(derivation: Derivation) -> str:
    """Return a table of the steps."""
    names = derivation.notation()
    rows = [
        [
            f"{number} {step.label}".strip(),
            step.operation,
            step.reason,
            markup.inline_formula(f"\\displaystyle {printing.latex(step.statement, names)}"),
            str(step.verdict),
        ]
        for number, step in enumerate(derivation.steps, 1)
    ]
    header = ["step", "what is done", "because", "result", "verdict"]
    return markup.html_table(header, rows, caption=f"{derivation.title} [{derivation.status.value}]")


@dispatch.notebook_latex.register(Derivation)
def derivation_as_latex(derivation: Derivation) -> str:
    """Return the results, one below the other."""
    names = derivation.notation()
    equations = [printing.latex(step.statement, names).replace("=", "&=", 1) for step in derivation.steps]
    rows = " \\\\\n".join(equations)
    return f"$$\\begin{{aligned}}\n{rows}\n\\end{{aligned}}$$"
