"""What the prover must never do: prove something false."""

import pytest
import sympy as sp

from stickslip_sym import Status
from stickslip_sym.core.symbols import V, a, b, mu, s, u
from stickslip_sym.formula.proof.normal_form import expand_above, normal_form
from stickslip_sym.formula.proof.proving import prove_equal, prove_positive
from stickslip_sym.formula.proof.theorems import Antiderivative, ChangeOfVariable, PieceByPiece

Int = sp.Integral
r, xi, y = sp.symbols("r xi y", real=True)
w = sp.Symbol("w", positive=True)

FALSE = {
    "a pole inside": (Int(1 / (u - V) ** 2, (u, 0, 2 * V)), -2 / V, Antiderivative(-1 / (u - V), u)),
    "a logarithm across its pole": (
        Int(1 / (u - V), (u, 0, 3 * V)), sp.log(2 * V) - sp.log(-V), Antiderivative(sp.log(u - V), u),
    ),
    "an arctangent that jumps": (Int(1 / (r**2 + 1), (r, -1, 1)), -sp.pi / 2, Antiderivative(-sp.atan(1 / r), r)),
    "an arctangent of a tangent": (Int(1, (r, 0, sp.pi)), sp.Integer(0), Antiderivative(sp.atan(sp.tan(r)), r)),
    "a double integral": (Int(u * y, (u, 0, 1), (y, 0, 2)), y / 2, None),
    "a variable captured": (
        Int(s * mu(u), (u, 0, V)), Int(s * V * mu(V * s), (s, 0, 1)), ChangeOfVariable(u, s, V * s),
    ),
    "a name captured": (Int(xi * mu(u), (u, 0, 1)), Int(u * mu(u), (u, 0, 1)), None),
    "infinity": (sp.oo, sp.oo, None),
    "not a number": (sp.nan, sp.Integer(0), None),
    "a logarithm of a product": (sp.log(a * b), sp.log(a) + sp.log(b), None),
    "a root of a square": (sp.sqrt(a**2), a, None),
    "a divergent integral": (Int(1 / r, (r, -V, V)), sp.Integer(0), None),
    "a piece too few": (
        Int(sp.Piecewise((u, u < w), (w, True)), (u, 0, 2 * V)), 2 * V**2, PieceByPiece([u**2 / 2], u, []),
    ),
    "a near miss": (V**2 * (1 + sp.Rational(1, 10**15)), V**2, None),
}  # fmt: skip


@pytest.mark.parametrize("name", FALSE)
def test_nothing_false_is_proved_or_checked(name):
    lhs, rhs, by = FALSE[name]
    verdict = prove_equal(lhs, rhs, by)
    assert verdict.status is Status.REFUTED
    assert verdict.evidence


def test_an_indefinite_integral_is_no_number():
    with pytest.raises(ValueError, match="not a definite integral"):
        normal_form(Int(mu(u), u) + 1)


def test_the_limits_must_suit_the_variable():
    """u is nonnegative, so sqrt(u^2) is u to SymPy: not on [-1, 1]."""
    verdict = prove_equal(Int(sp.sqrt(u**2), (u, -1, 1)), sp.Integer(0), by=Antiderivative(u**2 / 2, u))
    assert verdict.status is not Status.PROVED


@pytest.mark.parametrize(
    ("integrand", "primitive"),
    [
        (1 / (u + w), sp.log(1 + u / w)),
        (1 / (u**2 - u + 1), 2 / sp.sqrt(3) * sp.atan((2 * u - 1) / sp.sqrt(3))),
        (sp.tanh(u / w), u + w * sp.log(1 + sp.exp(-2 * u / w))),
        ((u + w) ** -3, -((u + w) ** -2) / 2),
        (sp.exp(-(u**2)), sp.sqrt(sp.pi) / 2 * sp.erf(u)),
    ],
)
def test_smooth_primitives_are_accepted(integrand, primitive):
    value = primitive.subs(u, V) - primitive.subs(u, 0)
    assert prove_equal(Int(integrand, (u, 0, V)), value, by=Antiderivative(primitive, u)).status is Status.PROVED


def test_pieces():
    kinked = sp.Piecewise((w - u, u < w), (2 * (u - w), True))
    primitives = [w * u - u**2 / 2, u**2 - 2 * w * u]
    end = sp.Min(w, V)
    value = primitives[0].subs(u, end) + primitives[1].subs(u, V) - primitives[1].subs(u, end)
    assert prove_equal(Int(kinked, (u, 0, V)), value, by=PieceByPiece(primitives, u, [w])).status is Status.PROVED
    wrong = value + primitives[0].subs(u, V)
    assert prove_equal(Int(kinked, (u, 0, V)), wrong, by=PieceByPiece(primitives, u, [w])).status is Status.REFUTED


def _in_pieces(low, high, end, place, other=0):
    """Return a*v below a place, b up to the next one, and a constant above."""
    return sp.Piecewise((a * low + other, u < place), (b * high, u < place + w), (end, True))


def test_functions_in_pieces_are_equal_piece_by_piece():
    left = _in_pieces(sp.sqrt(u) * (u + 1), u, w, V / a)
    right = w * _in_pieces(sp.sqrt(u) / w + u ** sp.Rational(3, 2) / w, u / w, sp.Integer(1), V / a)
    assert prove_equal(left, right).status is Status.PROVED
    both = sp.Piecewise((u, u < w), (w, True)) + left
    assert prove_equal(both, right + sp.Piecewise((u * b, u < w), (w * b, True)) / b).status is Status.PROVED


@pytest.mark.parametrize(
    "tampered",
    [
        _in_pieces(u, u, w, V / a, other=sp.Rational(1, 10**15)),
        _in_pieces(u, u * (1 + sp.Rational(1, 10**15)), w, V / a),
        _in_pieces(u, u, w * (1 + sp.Rational(1, 10**15)), V / a),
        _in_pieces(u, u, w, V / a * (1 + sp.Rational(1, 10**15))),
        _in_pieces(u, u, w, V / b),
        sp.Piecewise((a * u, u < V / a), (w, True)),
        sp.Piecewise((b * u, u < V / a), (a * u, u < V / a + w), (w, True)),
    ],
)
def test_a_tampered_piece_or_place_is_not_proved(tampered):
    assert prove_equal(_in_pieces(u, u, w, V / a), tampered).status is not Status.PROVED


def test_pieces_under_an_integral_are_not_taken_one_by_one():
    """With either piece in both places the two sides are the same; with the step they are not."""
    step = sp.Piecewise((sp.Integer(1), u < w), (sp.Integer(2), True))
    total = Int(step * mu(u), (u, 0, V))
    assert prove_equal(total, step.subs(u, V) * Int(mu(u), (u, 0, V))).status is not Status.PROVED


def test_positivity_of_what_is_not_real():
    assert prove_positive(sp.I * V).status is Status.REFUTED
    assert prove_positive(sp.log(a)).status is Status.REFUTED


def test_expanding_leaves_denominators_whole():
    expr = (1 + u) ** 2 * (w + 1 / (1 + u / w)) / (u + w) ** 2
    expanded = expand_above(expr)
    assert sp.simplify(expanded - expr) == 0
    assert all(term.has((u + w) ** -2) for term in sp.Add.make_args(expanded))
