r"""A LaTeX document, or a fragment for ``\input``: laws, their criteria, and what is known of them.

Every formula is printed from the expression that is evaluated, and stands once more as exact text in a comment.
"""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from typing import TypeVar

from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import FUNCTIONS
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.formula.slope_average import SlopeAverage
from stickslip_sym.formula.zeros import zeros
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.output import printing
from stickslip_sym.output.abbreviation import equation
from stickslip_sym.output.layout import LINE, displayed, key, prose, width
from stickslip_sym.output.notation import check_known, notation_of

__all__ = ["chapters", "document"]

_PREAMBLE = r"""\documentclass[10pt]{article}
\usepackage[T1]{fontenc}
\usepackage{lmodern}
\usepackage{amsmath}
\usepackage[a4paper,textwidth=120mm,textheight=225mm]{geometry}
\allowdisplaybreaks
\begin{document}
"""
_FRAGMENT = r"% A fragment for \input; it needs \usepackage{amsmath}." + "\n"
_QUADRATURE = "its value by quadrature serves"
_GROWS, _TENDS = r"\sim", r"\to"


def document(
    forms: Sequence[ClosedForm],
    *,
    given: Mapping[str, str],
    fragment: bool,
    steps: bool,
    missing: Sequence[tuple[FrictionLaw, str, str]],
) -> str:
    """Return the text of a document about closed forms; for the parameters see `export.export_latex`."""
    laws = chapters(forms)
    every = [name for law, _ in laws for name in law.parameters]
    check_known(given, ["mu", *symbols.QUANTITIES, *every])
    parts = [_FRAGMENT if fragment else _PREAMBLE + _introduction(given)]
    for (law, found), mark in zip(laws, _marks([law for law, _ in laws]), strict=True):
        if law.curve is not None:
            raise InputError(
                "a law of measured points has no formula to print; export it as --json, --python, --c or --octave"
            )
        absent = [(criterion, reason) for other, criterion, reason in missing if other == law]
        parts.append("\n\n".join(_chapter(law, mark, found, absent, given, fragment, steps)) + "\n")
    return "\n".join(parts) + ("" if fragment else "\n\\end{document}\n")


def _marks(laws: Sequence[FrictionLaw]) -> list[str]:
    """Return for each law what its labels have in common, and no other law's."""
    found: list[str] = []
    for law in laws:
        plain = key(law.name)
        free = (plain if n == 1 else f"{plain}-{n}" for n in itertools.count(1))
        found.append(next(label for label in free if label not in found))
    return found


Form = TypeVar("Form", bound=ClosedForm | SlopeAverage)


def chapters(forms: Sequence[Form]) -> list[tuple[FrictionLaw, list[Form]]]:
    """Return the laws in order, each with its closed forms."""
    found: dict[FrictionLaw, list[Form]] = {}
    for form in forms:
        found.setdefault(form.law, []).append(form)
    return list(found.items())


def _names(law: FrictionLaw | None, given: Mapping[str, str]) -> dict[str, str]:
    return notation_of(["mu", *symbols.QUANTITIES, *([] if law is None else law.parameters)], given)


def _introduction(given: Mapping[str, str]) -> str:
    n = _names(None, given)
    return (
        f"\\noindent A mass ${n['m']}$ on a spring ${n['k']}$ and a damper ${n['c']}$ is pressed "
        f"by the force ${n['N']}$ on a belt of speed ${n['V']}$:\n\\begin{{equation*}}\n"
        f"  {n['m']} \\ddot{{{n['x']}}} + {n['c']} \\dot{{{n['x']}}} + {n['k']} {n['x']} = "
        f"{n['N']} {n['mu']}({n['V']} - \\dot{{{n['x']}}})\n\\end{{equation*}}\n"
        f"Each criterion says how large ${n['c']}$ must be so that the mass does not stick and slip.\n"
    )


def _chapter(
    law: FrictionLaw, mark: str, forms: list[ClosedForm], absent: list[tuple[str, str]], given: Mapping[str, str],
    fragment: bool, steps: bool,
) -> Iterator[str]:  # fmt: skip
    names = _names(law, given)
    if not fragment:
        yield f"\\section{{The law \\texttt{{{prose(law.name)}}}}}" if law.name else r"\section{The law}"
    yield (
        f"The coefficient of friction at the slip speed ${names['v']}$ is\n% exact: mu(v) = {law.text}\n"
        + displayed(f"{names['mu']}({names['v']})", printing.latex(law.expr, names), label=f"eq:{mark}-law")
    )
    about = [
        f"{word}: {prose(text, names)}."
        for word, text in (("Source", law.source), ("Validity", law.validity))
        if text
    ]
    if about:
        yield "\n".join(about)
    yield _table(law, names)
    for form in forms:
        yield from _criterion(form, mark, names, steps)
    for criterion, reason in absent:
        name = prose(criterion.replace("_", "-"))
        yield f"For the {name} criterion no closed form was found; {_QUADRATURE}.\n% {' '.join(reason.split())}"


def _table(law: FrictionLaw, names: Mapping[str, str]) -> str:
    rows = [(name, symbols.QUANTITIES[name].meaning, symbols.QUANTITIES[name].unit, "") for name in "cNVv"]
    rows += [(p.name, p.meaning, p.unit or "", p.typical or "") for p in law.parameters.values()]
    rows = [
        (name, meaning.replace("|x' - V|", "|V - x'|"), unit, typical) for name, meaning, unit, typical in rows
    ]
    lines = [
        f"  ${names[name]}$ & {_meaning(meaning, names)} & {_unit(unit)} & {_number(typical)} \\\\"
        for name, meaning, unit, typical in rows
    ]
    head = "  symbol & meaning & unit & typical value \\\\"
    return "\n".join(
        [
            "\\begin{center}\n\\begin{tabular}{@{}lp{66mm}ll@{}}\n  \\hline",
            head,
            "  \\hline",
            *lines,
            "  \\hline\n\\end{tabular}\n\\end{center}",
        ]
    )


def _meaning(text: str, names: Mapping[str, str]) -> str:
    speed = f"$|{names['V']} - \\dot{{{names['x']}}}|$"
    before, found, after = text.partition("|V - x'|")
    return f"\\raggedright {prose(before, names)}{speed if found else ''}{prose(after, names)}"


def _unit(text: str) -> str:
    """Return a unit upright, its powers raised."""
    if not text:
        return ""
    written = "".join(f"^{{{c}}}" if before == "^" else "" if c == "^" else r"\," if c == "*" else c
                      for before, c in zip(" " + text, text, strict=False))  # fmt: skip
    return f"$\\mathrm{{{written}}}$"


def _number(text: str) -> str:
    return f"${text}$" if text else ""


def _criterion(form: ClosedForm, mark: str, names: dict[str, str], steps: bool) -> Iterator[str]:
    criterion = form.criterion
    name = prose(criterion.name.replace("_", "-"))
    source = f" ({prose(criterion.source, {'V': names['V']})})" if criterion.source else ""
    lines = [f"The {name} criterion{source} is"]
    lines.append(f"% exact: c = {printing.text(form.expr)}")
    label = f"eq:{mark}-{criterion.label}"
    lines.append(equation(names["c"], form.expr, names, label=label))
    lines += [f"Here {row.meaning}." for row in FUNCTIONS.values() if row.meaning and form.expr.has(row.kind)]
    lines += [*_ends(form, names), *_zeros(form, names)]
    lines.append(f"Verification: {form.verdict.status.value}; {prose(form.verdict.evidence)}.")
    yield "\n".join(lines)
    if steps:
        yield form.derivation.latex(names, heading=f"Derivation of (\\ref{{{label}}})")


def _ends(form: ClosedForm, names: Mapping[str, str]) -> Iterator[str]:
    found = form.limits
    for where, value in (("0", found.at_rest), ("\\infty", found.far)):
        place = f"${names['V']} \\to {where}$"
        if value is None:
            yield f"Its limit for {place} was not found."
        elif value.has(symbols.V):
            yield f"For {place} it grows as {_stated(names['c'], value, names, relation=_GROWS)}"
        else:
            yield f"For {place} it tends to {_stated(names['c'], value, names, relation=_TENDS)}"


def _stated(left: str, value: Expr, names: Mapping[str, str], *, relation: str) -> str:
    """Return the end of a sentence: a relation in the line, or displayed where it is long."""
    text = printing.latex(value, names, inline=True)
    if width(text) < LINE / 3:
        return f"${text}$." if relation == _TENDS else f"${left} {relation} {text}$."
    return "\n" + displayed(left, printing.latex(value, names), relation=relation)


def _zeros(form: ClosedForm, names: Mapping[str, str]) -> Iterator[str]:
    found = zeros(form)
    V = names["V"]
    if found.everywhere:
        yield "It is $0$ at all belt speeds."
    elif found.formula is not None:
        yield f"It vanishes at the transition speed {_stated(V, found.formula, names, relation='=')}"
    elif found.values is None:
        yield "No formula was found for its zeros, the transition speeds of the undamped oscillator."
    elif not found.values:
        yield "For the typical values no zero of it, that is, no transition speed without damping, was found."
    else:
        values = " and ".join(f"${V} = {value:.6g}$\\,m/s" for value in found.values)
        yield f"For the typical values it vanishes at {values}; no formula for this is known here."
