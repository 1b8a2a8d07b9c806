"""The harmonic criterion of polynomial laws in Coq, over the angle t of v = V (1 - cos t)."""

import sympy as sp

from stickslip_sym.certificates.coq.printer import Unsupported
from stickslip_sym.certificates.coq.tactics import Script
from stickslip_sym.core import symbols
from stickslip_sym.core.aliases import Expr
from stickslip_sym.core.remedies import Call
from stickslip_sym.output import printing

V = symbols.V


class Harmonic(Script):
    """A script on the criterion whose weight is (2/pi) sqrt(1 - s^2).

    The integral over t of sin(t)^2 S(cos t), S a polynomial, is rate t + sin(t) P(cos t): the proof supplies P.
    """

    def text(self) -> str:
        """Return the script."""
        law, weight = self.form.law.expr, self.form.criterion.weight
        if weight != 2 * sp.sqrt(1 - symbols.s**2) / sp.pi:
            raise Unsupported(f"a script in Coq has no weight {printing.text(weight)}")
        if not law.is_polynomial(symbols.v):
            raise Unsupported(
                "a script in Coq has the harmonic criterion of polynomials of v, and no rule for "
                f"mu(v) = {printing.text(law)}; its certificate in SymPy proves it: ",
                Call('form.certificate("sympy")', "export LAW --certificate FILE.py"),
            )
        mu, c = self.words(law, self.v), self.words(self.form.expr, self.v)
        slope = self.words(sp.diff(law, symbols.v), self.v)
        rate, inner = self._rise(sp.diff(law, symbols.v))
        angle = sp.Symbol("t")
        self.names[angle] = "t"
        sine, cosine = sp.Function("sin")(angle), sp.Function("cos")(angle)
        rise = self.words(rate, self.v) * angle + sine * self.words(inner, self.v).xreplace({symbols.s: cosine})
        proof = self.part(
            "harmonic",
            slope=self.code(slope),
            rise=self.code(rise),
        )
        return self.assembled(self.law(mu, self.code(c), [], self.part("weight")), proof)

    def _rise(self, slope: Expr) -> tuple[Expr, Expr]:
        """Return the rate, and P(s), of rate t + sin(t) P(cos t), whose derivative is sin(t)^2 mu'(V (1 - cos t)).

        With P = sum p_i s^i the derivative is rate + sum p_i ((i + 1) s^(i+1) - i s^(i-1)), s = cos t.
        """
        s = symbols.s
        polynomial = sp.Poly((1 - s**2) * slope.subs(symbols.v, V * (1 - s)), s)
        if polynomial.is_zero:
            return sp.S.Zero, sp.S.Zero
        p = dict[int, Expr]()
        for i in range(polynomial.degree() - 1, -1, -1):
            p[i] = sp.factor((polynomial.nth(i + 1) + (i + 2) * p.get(i + 2, sp.S.Zero)) / (i + 1))
        return sp.factor(polynomial.nth(0) + p.get(1, sp.S.Zero)), sp.Add(*[a * s**i for i, a in p.items()])
