"""Criteria as text for others: LaTeX documents with limits and verdicts, and code.

Every formula of a document is printed from the expression that is evaluated, and stands once more as exact text in
a comment.
"""

import itertools
import re
from collections.abc import Iterable, Iterator, Sequence
from itertools import compress
from typing import Any

from stickslip_sym.core import symbols as quantities
from stickslip_sym.core.aliases import Expr, Notation
from stickslip_sym.core.errors import InputError
from stickslip_sym.core.functions import FUNCTIONS
from stickslip_sym.formula.closed_form import ClosedForm
from stickslip_sym.formula.code import writer
from stickslip_sym.formula.proof.normal_form import arguments_of_arctangents, factor_of_sign
from stickslip_sym.formula.slope_average import SlopeAverage
from stickslip_sym.formula.transition_speeds import Sign, transition_speeds
from stickslip_sym.model.law import FrictionLaw
from stickslip_sym.output import printing
from stickslip_sym.output.abbreviation import displayed_equation
from stickslip_sym.output.layout import LINE, displayed, key, prose_latex, width
from stickslip_sym.output.notation import check_known, notation_of

_PREAMBLE = r"""\documentclass[10pt]{article}
\usepackage[T1]{fontenc}
\usepackage{lmodern}
\usepackage{amsmath}
\usepackage[a4paper,textwidth=120mm,textheight=225mm]{geometry}
\allowdisplaybreaks
\begin{document}
"""
_FRAGMENT = r"% A fragment for \input; it needs \usepackage{amsmath}." + "\n"
_TABLE = r"""\begin{center}
\begin{tabular}{@{}%s@{}}
  \hline
  %s \\
  \hline
%s
  \hline
\end{tabular}
\end{center}"""
_COLUMNS = {"symbol": "l", "meaning": "p{66mm}", "unit": "l", "typical value": "l"}
"""What is said of a symbol, and how the column is set."""
_UNDESCRIBED = "parameters of the law"


def _as_list(items: Any, kind: Any, expected: str) -> list[Any]:
    """Return one item, or several, as a list; refuse none, and any of another kind."""
    if isinstance(items, Iterable) and not isinstance(items, str):
        listed = list(items)
    else:
        listed = [items]
    for item in listed:
        if not isinstance(item, kind):
            raise InputError(f"{type(item).__name__} cannot be exported; give {expected}")
    if not listed:
        raise InputError("there is nothing to export; give at least one closed form")
    return listed


def export_code(forms: SlopeAverage | Sequence[SlopeAverage], language: str, *, name: str = "damping") -> str:
    """Return text of a language: one form as ``damping``, several as ``damping_<law>_<criterion>``.

    The text holds the branches of a call and needs nothing of this package. It gives NaN where a call refuses.

    Parameters
    ----------
    forms : SlopeAverage, such as a ClosedForm, or a sequence of them
    language : str
        "python", "c" (C99 with libm), "octave" (MATLAB reads it too) or "javascript". Python and Octave take
        arrays, and C has ``damping_array``.
    name : str
        The name of the function, for one form; in Octave it is that of its file.

    Returns
    -------
    str

    Raises
    ------
    InputError
        If there is no such language, nothing to write, two functions would have one name, or a profile has a shape
        without a value: bind it first.

    Examples
    --------
    >>> from stickslip_sym import derive
    >>> print(export_code(derive("0.4 - 0.1*v"), "c").split("value. */")[1].split("void")[0].strip())
    double damping(double V, double N)
    {
        const double a[] = {V, N};
        return checked(damping_term_0(a), a, "11", HUGE_VAL);
    }
    """
    listed = _as_list(forms, SlopeAverage, "closed forms or slope averages: derive(law), slope_average(law)")
    if len(listed) == 1:
        return writer.code({code_name(name): (listed[0], listed[0].described)}, language)
    laws = list(dict.fromkeys(form.law for form in listed))
    named: dict[str, tuple[SlopeAverage, str]] = {}
    for form in sorted(listed, key=lambda form: laws.index(form.law)):
        label = re.sub(r"\W+", "_", form.law.name or "", flags=re.ASCII).strip("_")
        name = f"damping_{label or f'law_{laws.index(form.law) + 1}'}_{form.criterion.label}"
        if name in named:
            raise InputError(f"two of the forms would both be called {name}; give the laws different names")
        named[name] = form, form.described
    return writer.code(named, language)


def code_name(name: str) -> str:
    """Return a name as that of a function in any language."""
    label = re.sub(r"\W+", "_", name, flags=re.ASCII).strip("_")
    if label and not label[0].isdigit():
        return label
    return f"damping_{label}".rstrip("_")


def export_latex(
    forms: ClosedForm | Sequence[ClosedForm],
    *,
    symbols: Notation | None = None,
    fragment: bool = False,
    steps: bool = False,
    missing: Sequence[tuple[FrictionLaw, str, str]] = (),
    certificate: str = "",
) -> str:
    r"""Return a LaTeX document about closed forms, or a fragment for ``\input``.

    For each law: its formula, a table of symbols with units, and for each criterion the formula, numbered and
    labelled ``eq:<law>-<criterion>``, its limits for low and high belt speeds, where it vanishes, and how it was
    verified. Formulas are broken to fit a text of 120 mm; each stands as exact text in a comment beside it.

    Parameters
    ----------
    forms : ClosedForm or sequence of ClosedForm
    symbols : mapping of str to str, optional
        Names and the LaTeX that they shall be printed as, e.g. ``{"V": "v_b", "alpha": r"\beta"}``.
    fragment : bool
        Leave out the preamble and the headings.
    steps : bool
        Print every step of the derivations.
    missing : sequence of (FrictionLaw, str, str)
        Laws, criteria that have no closed form for them, and why; the document says so.
    certificate : str
        The name of a file with their certificates, for a footnote.

    Returns
    -------
    str

    Raises
    ------
    InputError
        For symbols that cannot be used, or a law of measured points, which has no formula to print.

    Examples
    --------
    >>> from stickslip_sym import derive
    >>> text = export_latex(derive("mu_s - a*v"), fragment=True, symbols={"V": "v_b"})
    >>> text.count(r"\begin{equation}")
    2
    """
    listed = _as_list(forms, ClosedForm, "closed forms: derive(law)")
    laws = dict.fromkeys(form.law for form in listed)
    given = symbols or {}
    every = ["mu", *quantities.QUANTITIES]
    check_known(given, [*every, *(name for law in laws for name in law.parameters)])
    if any(law.curve is not None for law in laws):
        raise InputError("a law of measured points has no formula to print; write it by export_code or save")
    parts = [_FRAGMENT if fragment else _PREAMBLE + _introduction(notation_of(every, given))]
    marks = set[str]()
    for law in laws:
        plain = key(law.name)
        numbered = (plain if n == 1 else f"{plain}-{n}" for n in itertools.count(1))
        mark = next(label for label in numbered if label not in marks)
        marks.add(mark)
        names = notation_of([*every, *law.parameters], given)
        heading = "The law"
        if law.name:
            heading = f"The law \\texttt{{{prose_latex(law.name)}}}"
        chapter = [] if fragment else [f"\\section{{{heading}}}"]
        chapter += _describe_law(law, mark, names)
        for form in listed:
            if form.law == law:
                chapter += _criterion_section(form, mark, given, steps, certificate)
        chapter += [
            f"For the {prose_latex(criterion.replace('_', '-'))} criterion no closed form was found; its value by "
            f"quadrature remains.\n% {' '.join(reason.split())}"
            for other, criterion, reason in missing
            if other == law
        ]
        parts.append("\n\n".join(chapter) + "\n")
    return "\n".join(parts) + ("" if fragment else "\n\\end{document}\n")


def _introduction(n: Notation) -> str:
    return (
        f"\\noindent A mass ${n['m']}$ on a spring ${n['k']}$ and a damper ${n['c']}$ is pressed "
        f"by the force ${n['N']}$ on a belt of speed ${n['V']}$:\n\\begin{{equation*}}\n"
        f"  {n['m']} \\ddot{{{n['x']}}} + {n['c']} \\dot{{{n['x']}}} + {n['k']} {n['x']} = "
        f"{n['N']} {n['mu']}({n['V']} - \\dot{{{n['x']}}})\n\\end{{equation*}}\n"
        f"Each criterion says how large ${n['c']}$ must be so that the mass does not stick and slip.\n"
    )


def _describe_law(law: FrictionLaw, mark: str, names: Notation) -> Iterator[str]:
    """Give the formula of a law, its source and validity, and a table of its symbols."""
    yield (
        f"The coefficient of friction at the slip speed ${names['v']}$ is\n% exact: mu(v) = {law.text}\n"
        + displayed(f"{names['mu']}({names['v']})", printing.latex(law.expr, names), label=f"eq:{mark}-law")
    )
    texts = {"Source": law.source, "Validity": law.validity}
    if any(texts.values()):
        yield "\n".join(f"{word}: {prose_latex(text, names)}." for word, text in texts.items() if text)
    yield _symbol_table(law, names)


def _symbol_table(law: FrictionLaw, names: Notation) -> str:
    """Return the table of symbols, without columns that would be empty; what is not described is one row."""
    known = {name: quantities.QUANTITIES[name] for name in "cNVv"}
    rows = [(f"${names[name]}$", _meaning(quantity.meaning, names), _unit(quantity.unit), "")
            for name, quantity in known.items()]  # fmt: skip
    undescribed = []
    for p in law.parameters.values():
        symbol = f"${names[p.name]}$"
        if not (p.meaning or p.unit or p.typical):
            undescribed.append(symbol)
            continue
        typical = f"${p.typical}$" if p.typical else ""
        rows.append((symbol, _meaning(p.meaning, names), _unit(p.unit or ""), typical))
    if undescribed:
        rows.append((", ".join(undescribed), _UNDESCRIBED.removesuffix("s" * (len(undescribed) == 1)), "", ""))
    filled = [any(column) for column in zip(*rows, strict=True)]
    kept = list(compress(_COLUMNS, filled))
    lines = [f"  {' & '.join(compress(row, filled))} \\\\" for row in rows]
    return _TABLE % ("".join(_COLUMNS[title] for title in kept), " & ".join(kept), "\n".join(lines))


def _meaning(text: str, names: Notation) -> str:
    before, slip, after = text.replace("|x' - V|", "|V - x'|").partition("|V - x'|")
    speed = ""
    if slip:
        speed = f"$|{names['V']} - \\dot{{{names['x']}}}|$"
    return f"\\raggedright {prose_latex(before, names)}{speed}{prose_latex(after, names)}"


def _unit(text: str) -> str:
    """Return a unit upright, its powers raised."""
    raised = re.sub(r"\^(.)", r"^{\1}", text).replace("*", r"\,")
    return f"$\\mathrm{{{raised}}}$" if text not in ("", "1") else text


def criterion_latex(form: ClosedForm, label: str) -> str:
    """Return a closed form as one displayed equation, its long numbers as letters with their values below it."""
    shown, letters = form.readable
    names = notation_of(["c", *shown.arguments])
    return displayed_equation(names["c"], shown.expr, names, label=label, letters=letters)


def _criterion_section(
    form: ClosedForm, mark: str, given: Notation, steps: bool, certificate: str
) -> Iterator[str]:
    criterion = form.criterion
    (shown, letters) = form.readable
    names = notation_of(["mu", *quantities.QUANTITIES, *shown.law.parameters], given)
    source = ""
    if criterion.source:
        source = f" ({prose_latex(criterion.source, {'V': names['V']})})"
    label = f"eq:{mark}-{criterion.label}"
    lines = [
        f"The {prose_latex(criterion.name.replace('_', '-'))} criterion{source} is",
        f"% exact: c = {printing.text(form.expr)}",
        displayed_equation(names["c"], shown.expr, names, label=label, letters=letters),
    ]
    lines += [f"Here {row.meaning}." for row in FUNCTIONS.values() if row.meaning and shown.expr.has(row.kind)]
    lines += [_hypergeometric_cases(z, names) for z in arguments_of_arctangents(shown.expr)]
    lines += [*_limit_sentences(shown, names), _vanishing(form, names)]
    kind = "Proof for Coq" if certificate.endswith(".v") else "Certificate"
    note = ""
    if certificate:
        note = f"\\footnote{{{kind}: \\texttt{{{prose_latex(certificate)}}}.}}"
    lines.append(f"Verification: {form.verdict.status.value}; {prose_latex(form.verdict.evidence)}.{note}")
    yield "\n".join(lines)
    if steps:
        yield form.derivation.latex(names, heading=f"Derivation of (\\ref{{{label}}})")


def _hypergeometric_cases(z: Expr, names: Notation) -> str:
    """Say what 2F1(1/2, 1; 3/2; z) is for either sign of z, which is that of a discriminant."""
    deciding = printing.latex(factor_of_sign(z), names, inline=True)
    positive = r"$\operatorname{artanh}(\sqrt{z})/\sqrt{z}$ for $z > 0$"
    negative = r"$\arctan(\sqrt{-z})/\sqrt{-z}$ for $z < 0$"
    return (
        f"The function ${{}}_{{2}}F_{{1}}(1/2, 1; 3/2; z)$ is {positive}, {negative}, and $1$ for $z = 0$; "
        f"its argument has the sign of ${deciding}$."
    )


def _limit_sentences(form: ClosedForm, names: Notation) -> Iterator[str]:
    for where, value in (("0", form.limits.at_rest), ("\\infty", form.limits.far)):
        place = f"${names['V']} \\to {where}$"
        if value is None:
            yield f"Its limit for {place} was not found."
            continue
        relation, verb = (r"\sim", "grows as") if value.has(quantities.V) else (r"\to", "tends to")
        text = printing.latex(value, names, inline=True)
        if width(text) < LINE / 3:
            yield f"For {place} it {verb} ${text}$."
        else:
            yield f"For {place}\n" + displayed(names["c"], printing.latex(value, names), relation=relation)


def _vanishing(form: ClosedForm, names: Notation) -> str:
    """Say at which belt speeds a criterion vanishes, or what its sign is at all of them."""
    vanishing = transition_speeds(form)
    V = names["V"]
    if vanishing.everywhere:
        return "It is $0$ at all belt speeds."
    if vanishing.formula is not None:
        text = printing.latex(vanishing.formula, names, inline=True)
        if width(text) < LINE / 3:
            return f"It vanishes at the transition speed ${V} = {text}$."
        return "It vanishes at the transition speed\n" + displayed(V, printing.latex(vanishing.formula, names))
    if vanishing.values is None:
        return "No formula was found for its zeros, the transition speeds of the undamped oscillator."
    given = "For the typical values it" if vanishing.at_typical_values else "It"
    if vanishing.sign is not None:
        falls, relation = ("falls", ">") if vanishing.sign is Sign.POSITIVE else ("rises", "<")
        return (
            f"{given} has no zeros: ${names['mu']}({names['v']})$ {falls} at all slip speeds, so "
            f"${names['c']} {relation} 0$ at all belt speeds."
        )
    if not vanishing.values:
        return f"{given} has no zeros: there is no transition speed of the undamped oscillator."
    speeds = " and ".join(f"at ${V} = {value:.6g}$\\,m/s" for value in vanishing.values)
    return f"{given} vanishes {speeds}, and nowhere else; no formula for this is known here."
