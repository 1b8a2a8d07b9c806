"""Edits of pages that prove closed forms, by someone who understands them: each makes a false or an unproved page.

An edit takes a page and returns those that it makes of it; none where the page has not what it edits.
"""

import contextlib
import io
import re


def outcome(page):
    """Run a page in this process, under -O; return what it printed, or what failed. A half is no success."""
    stream = io.StringIO()
    try:
        with contextlib.redirect_stdout(stream):
            exec(compile(page, "a page", "exec", optimize=2), {})
    except Exception as failure:
        return f"failed: {failure}"
    return stream.getvalue().strip()


def _before_claim(page, *lines):
    """Return pages with one line each just before the claim is made."""
    return [page.replace("\nclaims.append", f"\n{line}\nclaims.append", 1) for line in lines]


def _before_parts(page, *lines):
    """Return pages with one line each before what is known of the first average is put together."""
    return [edited for line in lines for edited in _replaced(page, r"^parts1 = ", f"{line}\nparts1 = ")]


def _replaced(page, pattern, new):
    """Replace a pattern once in the statement or the data."""
    head, mark, tail = page.partition("# == CHECKER")
    edited = re.sub(pattern, new, head, count=1, flags=re.MULTILINE)
    return [] if edited == head else [edited + mark + tail]


def _has(page, pattern):
    """Whether the statement, or the data, have a pattern."""
    return re.search(pattern, page.partition("# == CHECKER")[0], re.MULTILINE) is not None


def _is_average(page):
    return not _has(page, "^w = None")


# -- the statement ---------------------------------------------------------------------------------


def formula(page):
    """Other formulas: twice c, of another sign, with a force more, without the force, at another speed."""
    changes = ["2 * c", "-c", "c + N", "c / N", "c.subs(N, 2 * N)"]
    changes += ["c.subs(V, 2 * V)"] if _has(page, r"^c = .*\bV\b") else []
    return _before_claim(page, *(f"c = {change}" for change in changes))


def law(page):
    """Another law than that of the data."""
    return _before_claim(page, *(f"mu = {e}" for e in ("mu + v", "2 * mu", "mu.subs(v, 2 * v)", "mu + v**2 - v")))


def law_by_terms(page):
    """Amplitudes and c, twice: the sum of the averages is c, and the terms are not mu."""
    row = "terms = [(2 * a, *rest) for a, *rest in terms]"
    return _before_claim(page, f"{row}\nc = 2 * c") if _is_average(page) else []


def weight(page):
    """Another average, what is no average, what is no weight; twice an average, and c with it."""
    edits = [
        "w = sp.Rational(3, 4) * (1 - s**2)",
        "w = 2 * w",
        "w = w + s",
        "w = sp.exp(s)",
        "w = 2 * w\nc = 2 * c",
    ]
    return _before_claim(page, *edits, "w = None") if _is_average(page) else []


def assumptions(page):
    """Speeds and forces of either sign; whole speeds; a slip speed that is not that of the checker."""
    edits = _replaced(page, r"^(V, N.*), positive=True\)", r"\1, real=True)")
    for name, kind in (("V", "positive=True, integer=True"), ("N", "real=True"), ("v", "positive=True")):
        text = f'other = sp.Symbol("{name}", {kind})\nmu, c = (sp.sympify(e).subs({name}, other) for e in (mu, c))'
        edits += _before_claim(page, text) if _has(page, rf"^(mu|c) = .*\b{name}\b") else []
    return edits


def inexact(page):
    """Numbers of finite precision, which any two close numbers may stand for."""
    return _before_claim(page, "c = c * (1 + sp.Float(10) ** -40)")


def pieces(page):
    """Conditions that are not v < place: turned round, of a square, over a stretch; and another place."""
    if not _has(page, r"^mu = .*Piecewise.*v < v_k"):
        return []
    edits = ["v > v_k", "v**2 < v_k * v", "v >= v_k", "(v < v_k) & (v > v_k / 2)", "v < 2 * v_k"]
    change = "mu = mu.replace(lambda e: e in (v < v_k, v_k > v), lambda e: {})"
    return _before_claim(page, *(change.format(edit) for edit in edits))


def mean_at_a_kink(page):
    """One side's slope at a kink where the mean of both is meant."""
    return [] if _is_average(page) else _replaced(page, r"^(c = .*)\bV <= ", r"\1V < ")


def ends_of_pieces(page):
    """A piece that is integrated further than it holds: Min(2 V, p) in c is Min(2 V, 2 p)."""
    further = "lambda *x: sp.Min(*[a if a.has(V) else 2 * a for a in x])"
    return _before_claim(page, f"c = c.replace(sp.Min, {further})") if _has(page, r"^c = .*Min\(") else []


# -- the data --------------------------------------------------------------------------------------


def pieces_of_data(page):
    """A profile whose pieces hold elsewhere than those of the law."""
    moved = "g1 = g1.replace(lambda e: e.is_Relational, lambda e: v < 3)"
    return _before_parts(page, moved) if _has(page, r"^g1 = Piecewise") else []


def order_of_pieces(page):
    """Antiderivatives of other pieces, and of too few."""
    return [e for new in ("[A1_1, A1_0]", "[A1_0]") for e in _replaced(page, r"\[A1_0, A1_1\]", new)]


def antiderivative(page):
    """An antiderivative of something else: with a term in v, in pieces, with a pole, without a rule."""
    added = ["v", "sp.Piecewise((7, v <= 1), (0, True))", "1 / (v - 10)", "sp.floor(v)", "sp.log(v)"]
    return _before_parts(page, *(f"A1_0 += {e}" for e in added)) if _has(page, "^A1_0 = ") else []


def missing_data(page):
    """No proof of an average, of a sum, or no terms at all; and what is compared where it is false."""
    row = "for a, b, x, g, parts in terms]"
    edits = ["terms = []", f"terms = [(a, b, x, g, []) {row}\nc = sp.Integer(0)"]
    edits.append(f'terms = [(a, b, x, g, [("compared", g, N)] if parts else []) {row}')
    return _before_claim(page, *edits) if _is_average(page) else []


def scales(page):
    """Scales that are not positive, or depend on the speed, or are others than the law's."""
    row = "terms = [(a, {} if parts else b, x, g, parts) for a, b, x, g, parts in terms]"
    edits = [row.format(edit) for edit in ("-b", "b * v", "b * V", "2 * b")]
    return _before_claim(page, *edits) if _has(page, r"parts1\)") else []


def shapes(page):
    """Values of shapes that their assumptions exclude."""
    row = "terms = [(a, b, {x: -y for x, y in shapes.items()}, g, parts) for a, b, shapes, g, parts in terms]"
    return _before_claim(page, row) if _has(page, r"\{p_1:") else []


def functions_of_speed(page):
    """Functions that are others than their slopes and first terms say."""
    names = re.findall(r"^    (besseli_1|exp_V|root): \(", page, re.MULTILINE)
    changes = "(f.subs(V, 2 * V), slope)", "(2 * f, slope)", "(f, 2 * slope)", "(f, slope + 1)", "(-f, slope)"
    edits = [
        f"functions1[{x}] = (lambda f, slope: {change})(*functions1[{x}])" for x in names for change in changes
    ]
    return _before_parts(page, *edits)


def equations(page):
    """Another equation of the profile, another operator, too few terms left open; twice V F, and c with it."""
    if not _has(page, "^proof1 = "):
        return []
    edits = ["a = a[:-1]", "a = [a[0] + 1, *a[1:]]", "rest = rest + v", "q = q[:-1]", "q = [2 * q[0], *q[1:]]"]
    edits += ["q = [e / V for e in q]", "count = 0", "count = 1", "y = 2 * y", "y = 2 * y\nc = 2 * c", "y = y + V"]
    row = "a, rest, q, count, y, *more"
    return _before_parts(page, *(f"{row} = proof1\n{edit}\nproof1 = {row}" for edit in edits))


# -- what holds at every point that is compared, and not beyond -------------------------------------


def formula_far_out(page):
    """Formulas that are others for V > 10 only, where nothing is compared."""
    changes = ["c * sp.Max(1, V - 9)", "sp.Piecewise((c, V < 10), (0, True))", "c + N * (sp.Abs(V - 10) + V - 10)"]
    changes += ["c * sp.sqrt((V - 10) ** 2) / (10 - V)"]
    return _before_claim(page, *(f"c = {change}" for change in changes))


def law_far_out(page):
    """Laws that are others for v > 10 only, in their text, and in the terms too."""
    changes = ["sp.Piecewise((mu, v < 10), (0, True))", "mu * sp.Max(1, v - 9)", "mu + sp.Max(v, 10) - 10"]
    edits = _before_claim(page, *(f"mu = {change}" for change in changes))
    row = "terms = [(a, b, x, sp.Piecewise((g, v < 10), (0, True)), parts) for a, b, x, g, parts in terms]"
    return edits + _before_claim(page, f"mu = {changes[0]}\n{row}") if _is_average(page) else edits


def parameters_far_out(page):
    """Formulas that are others for large parameters only."""
    edit = "for x in sorted(c.free_symbols - {V, N}, key=str):\n    c = c.subs(x, sp.Min(x, 10))"
    return (
        _before_claim(page, edit) if _has(page, r"^mu = .*\b(mu_0|v_k|p|mu_s)\b") and _c_has_letters(page) else []
    )


def _c_has_letters(page):
    """Whether the formula has a parameter."""
    return _has(page, r"^c = .*\b(a|a_1|b|p|v_k|mu_[01ms]|v_m)\b")


# -- what is not what it looks like ------------------------------------------------------------------


def twins(page):
    """Two letters of one name, so that what is printed means something else; names that are formulas."""
    row = 'terms += [(sp.Symbol("{}", real=True), sp.Integer(1), {{}}, sp.Integer(1), [])]'
    edits = [
        'mu += sp.Symbol("a", real=True) - sp.Symbol("a", positive=True)',
        'mu += sp.Symbol("b", positive=True)\n' + row.format("b"),
        'mu += sp.Symbol("v**2 - 1", real=True)\n' + row.format("v**2 - 1"),
        'mu += sp.Symbol("", real=True)',
    ]
    return _before_claim(page, *edits[:1], *(edits[1:] if _is_average(page) else edits[3:]))


def liars(page):
    """A symbol of a class of the page's own, which prints something else."""
    kind = "class Liar(sp.Symbol):\n    def _sympystr(self, printer):\n        return '0'"
    return _before_claim(page, f"{kind}\nmu = mu + Liar('z', real=True)")


def own_functions(page):
    """Functions of the page's own, with names of known ones: one without rules, one that is 0 far out."""
    own = "class tanh(sp.Function):\n    @classmethod\n    def eval(cls, x):\n"
    own += "        return sp.Integer(7) if x.is_number and x > 10 else sp.Integer(0) if x.is_number else None\n"
    own += "    def fdiff(self, argindex=1):\n        return sp.Integer(0)"
    edits = _before_claim(
        page, 'c = c + N * sp.Function("exp")(V) * 0 + sp.Function("exp")(-V)', f"{own}\nc += N * tanh(V)"
    )
    return edits + (_before_parts(page, f"{own}\nA1_0 += tanh(v)") if _has(page, "^A1_0 = ") else [])


def inexact_data(page):
    """Data of finite precision, and a c that is off by less than what points show."""
    off = "c = c * (1 + Rational(1, 10**30))"
    shaken = 'sp.Float("1.0", 25)'
    edits = _before_parts(page, f"A1_0 = A1_0 * {shaken}") if _has(page, "^A1_0 = ") else []
    row = "a, rest, q, count, y, *more"
    if _has(page, "^proof1 = "):
        edits += _before_parts(page, f"{row} = proof1\ny = y * {shaken}\nproof1 = {row}")
    rows = "terms = [(a * {}, *rest) for a, *rest in terms]"
    edits += _before_claim(page, rows.format(shaken), rows.format("1.0")) if _is_average(page) else []
    return [e for edited in edits for e in _before_claim(edited, off.replace("Rational", "sp.Rational"))]


def imaginary(page):
    """Amplitudes, and scales, that are no real numbers, times others that make up for them."""
    rows = "terms = [(a * sp.I, b, x, g, parts) for a, b, x, g, parts in terms]"
    edits = _before_claim(page, f"{rows}\nmu, c = sp.I * mu, sp.I * c") if _is_average(page) else []
    return [*edits, *_before_claim(page, "mu, c = sp.I * mu, sp.I * c", "mu = mu + sp.I")]


def other_speeds(page):
    """A formula, a law and a weight in speeds that are not those of the checker, but print like them."""
    edits = ['c = c.subs(V, sp.Symbol("V")) + V - sp.Symbol("V")', 'mu = mu + v - sp.Symbol("v", real=True)']
    return _before_claim(page, *edits, *(['w = w.subs(s, sp.Symbol("s")) + s - s'] if _is_average(page) else []))


def empty_claims(page):
    """No claim at all, one without terms, one of another length."""
    return [
        page.replace("\nclaims.append(", "\nclaims.append(())\nclaims.append(", 1),
        page.replace("\nclaims.append((mu, w, c,", "\nclaims.append((mu, w, 2 * c,", 1),
    ]


EDITS = {
    edit.__name__: edit
    for edit in (
        formula, law, law_by_terms, weight, assumptions, inexact, pieces, mean_at_a_kink, ends_of_pieces,
        pieces_of_data, order_of_pieces, antiderivative, missing_data, scales, shapes, functions_of_speed,
        equations, formula_far_out, law_far_out, parameters_far_out, twins, liars, own_functions, inexact_data,
        imaginary, other_speeds, empty_claims,
    )
}  # fmt: skip
"""Every kind of edit, by its name."""

JUMPS = {
    "two arctangents": "sp.atan(v - 10) + sp.atan(1 / (v - 10))",
    "an argument": "sp.im(sp.log(v - 10))",
    "two logarithms": "sp.log(v - 10) - sp.log(10 - v)",
    "a root of a square over what it is of": "sp.sqrt((v - 10) ** 2) / (v - 10)",
    "pieces": "sp.Piecewise((7, v < 10), (0, True))",
    "pieces turned round": "sp.Piecewise((7, v > 10), (0, True))",
    "a floor": "sp.floor(v)",
    "a step": "sp.Heaviside(v - 10)",
    "a sign": "sp.sign(v - 10)",
    "an arctangent of a tangent": "sp.atan(sp.tan(v)) - v",
    "an arccosine of a cosine": "sp.acos(sp.cos(v)) - v",
    "a root of a power": "(-1) ** sp.floor(v / 10)",
}
"""Functions of v that jump, and whose derivatives are 0 as SymPy differentiates, but for the places."""
