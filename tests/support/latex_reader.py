r"""Reads back the LaTeX that this package prints: a parser of its own, straight to mpmath numbers.

It shares nothing with the printer. It knows how a person reads \frac, juxtaposition, slashes and brackets, and
refuses what two persons could read in two ways: `a/b c`, `\ln(x)^{2}`, `2 3^{x}`, a brace of cases beside a sum.
"""

import re

import mpmath

HEADS = {
    r"\ln": mpmath.log, r"\exp": mpmath.exp, r"\sin": mpmath.sin, r"\cos": mpmath.cos, r"\tan": mpmath.tan,
    r"\sinh": mpmath.sinh, r"\cosh": mpmath.cosh, r"\tanh": mpmath.tanh, r"\coth": mpmath.coth,
    r"\arctan": mpmath.atan, r"\arcsin": mpmath.asin, r"\arccos": mpmath.acos,
    r"\max": max, r"\min": min, r"\zeta": mpmath.zeta, r"\Gamma": mpmath.gamma,
    r"\gamma": lambda s, x: mpmath.gammainc(s, 0, x), r"\eta": mpmath.altzeta, r"\Pi": mpmath.ellippi,
    "E": mpmath.ellipe, "K": mpmath.ellipk,
    r"\Phi": lambda z, s, a: mpmath.nsum(lambda n: z**n / (n + a) ** s, [0, mpmath.inf], method="d"),
}  # fmt: skip
WORDS = {
    "arsinh": mpmath.asinh, "arcosh": mpmath.acosh, "artanh": mpmath.atanh, "sech": mpmath.sech, "erf": mpmath.erf,
    "erfc": mpmath.erfc, "erfi": mpmath.erfi, "Im": mpmath.im, "Re": mpmath.re, "sgn": mpmath.sign,
    "lowergamma": HEADS[r"\gamma"], "dirichleteta": mpmath.altzeta,
    "zeta": mpmath.zeta, "gamma": mpmath.gamma, "elliptice": mpmath.ellipe, "elliptick": mpmath.ellipk,
    "ellipticpi": mpmath.ellippi, "Lerch": HEADS[r"\Phi"],
}  # fmt: skip
FUNCTIONS = HEADS | {f"\\operatorname{{{word}}}": function for word, function in WORDS.items()}
INDEXED = {
    "I": mpmath.besseli, r"\operatorname{besseli}": mpmath.besseli, r"\operatorname{Li}": mpmath.polylog,
}  # fmt: skip
CONSTANTS = {
    r"\pi": lambda: +mpmath.pi, "G": lambda: +mpmath.catalan, r"\operatorname{Catalan}": lambda: +mpmath.catalan,
    r"\mathrm{i}": lambda: mpmath.mpc(0, 1),
}  # fmt: skip
RAISED = {r"\sin", r"\cos", r"\tan", r"\sinh", r"\cosh", r"\tanh", r"\coth", r"\operatorname{sech}"}
OPEN, CLOSE = ("(", "[", r"\{"), (")", "]", r"\}")
ENDS = ("+", "-", ",", ";", "}", "<", ">", "=", r"\wedge", r"\amp", r"\row", r"\end{cases}", r"\mathrm{d}",
        r"\rvert", *CLOSE)  # fmt: skip
LAYOUT = re.compile(
    r"\\begin\{(?!cases)\w+\*?\}|\\end\{(?!cases)\w+\*?\}|\\label\{[^}]*\}|\\left|\\right|\\[bB]igg?[lr]|\\\\"
    r"|\\q?quad|\\,|\\:|&|\{\}(?!_)"
)
HYPER = re.compile(r"\{\}_\{\d\}F_\{\d\}")
NUMBER = re.compile(r"\d+(\.\d+)?")
DERIVATIVE = re.compile(r"\\frac\{(?:\\mathrm\{d\}|\\partial)\}\{(?:\\mathrm\{d\}|\\partial) ")


def plain(text):
    """Return a formula without its layout; lines of cases and bars keep theirs under names of their own."""
    text = in_cases(text.replace(r"\left|", r"\lvert ").replace(r"\right|", r"\rvert "))
    return LAYOUT.sub("", text)


def in_cases(text):
    """Return a text with names of their own for the layout of cases, which may stand in others."""
    depth, parts = 0, []
    for part in re.split(r"(\\(?:begin|end)\{cases\})", text):
        depth += {r"\begin{cases}": 1, r"\end{cases}": -1}.get(part, 0)
        parts.append(part.replace("\\\\", r"\row ").replace("&", r"\amp ") if depth else part)
    return "".join(parts)


class Reader:
    """One formula; `symbols` gives the value of each symbol by its LaTeX."""

    def __init__(self, text, symbols):
        self.text = re.sub(r"\s+", " ", plain(text)).strip()
        self.symbols = dict(sorted(symbols.items(), key=lambda item: -len(item[0])))
        self.at = 0

    def value(self):
        result = self.sum()
        assert self.at == len(self.text), f"unread: {self.text[self.at :]!r}"
        return result

    # -- characters ------------------------------------------------------------------------------------

    def peek(self, *texts):
        while self.text[self.at : self.at + 1] == " ":
            self.at += 1
        for text in texts:
            end = self.at + len(text)
            word = text.startswith("\\") and text[-1].isalpha()
            if self.text.startswith(text, self.at) and not (word and self.text[end : end + 1].isalpha()):
                return text
        return None

    def take(self, *texts):
        found = self.peek(*texts)
        if found:
            self.at += len(found)
        return found

    def need(self, *texts):
        found = self.take(*texts)
        assert found, f"expected one of {texts} at {self.text[self.at : self.at + 40]!r}"
        return found

    def ended(self):
        return self.peek(*ENDS) is not None or self.at == len(self.text)

    # -- sums and products -----------------------------------------------------------------------------

    def sum(self):
        if self.take(r"\begin{cases}"):
            chosen = self.cases()
            assert self.ended(), "what follows a brace of cases seems to belong to its last line"
            assert not self.peek("+", "-"), "what follows a brace of cases seems to belong to its last line"
            return chosen
        total = -self.term() if self.take("-") else self.term()
        while sign := self.take("+", "-"):
            total += self.term() if sign == "+" else -self.term()
        return total

    def term(self):
        product, before = None, ""
        while True:
            start = self.at
            found = self.opened()
            factor = self.factor() if found is None else found
            product = factor if product is None else product * factor
            if found is not None:
                assert self.ended(), "where the integral or the derivative ends is not to be seen"
                return product
            before = self.text[start : self.at].strip()
            if self.ended():
                return product
            if self.take("/"):
                product /= self.factor()
                assert self.ended(), f"does the denominator go on? {self.text[max(self.at - 20, 0) :]!r}"
                return product
            if not self.take(r"\times", r"\cdot"):
                self.peek()
                assert not self.text[self.at].isdigit(), "two numbers beside each other"
                assert not (before.isdigit() and self.peek(r"\frac")), "a mixed number?"

    def opened(self):
        """An integral or a derivative, which take in all that follows in their term; else None."""
        if self.take(r"\int"):
            self.need("_")
            low = self.group()
            self.need("^")
            high, start = self.group(), self.at
            ends = []

            def integrand(place, name):
                self.at = start
                known, self.symbols = self.symbols, self.symbols | ({name: place} if name else {})
                value = self.term()
                self.need(r"\mathrm{d}")
                ends.append(self.need(*self.symbols))
                self.symbols = known
                return value

            integrand(None, "")
            return mpmath.quad(lambda place: integrand(place, ends[0]), [low, high])
        self.peek()
        if found := DERIVATIVE.match(self.text, self.at):
            self.at = found.end()
            name = self.need(*self.symbols)
            self.need("}")
            start = self.at

            def function(place):
                self.at = start
                known, self.symbols = self.symbols, self.symbols | {name: place}
                value = self.factor()
                self.symbols = known
                return value

            return mpmath.diff(function, self.symbols[name])
        return None

    def factor(self):
        base, may_be_raised = self.atom()
        if self.take("^"):
            assert may_be_raised, f"what is raised? {self.text[: self.at]!r}"
            base **= self.group()
            assert not self.peek("^"), "two exponents"
        return base

    # -- what stands in braces and brackets ------------------------------------------------------------

    def group(self):
        self.need("{")
        inside = self.sum()
        self.need("}")
        return inside

    def bracketed(self):
        found, *others = self.groups()
        assert not others, "semicolons"
        return found

    def groups(self):
        """In brackets, parted by semicolons; all but the last may be empty."""
        opened, found, mark = self.need(*OPEN), [], ";"
        while mark not in CLOSE:
            found += [[]] if mark == ";" else []
            if mark == "," or not self.peek(";"):
                found[-1].append(self.sum())
            mark = self.need(",", ";", *CLOSE)
        assert mark == CLOSE[OPEN.index(opened)]
        return found

    def arguments(self):
        """In brackets, around which SymPy puts braces."""
        braces = self.take("{")
        found = self.bracketed()
        if braces:
            self.need("}")
        return found

    def cases(self):
        chosen, done = None, False
        while not done:
            value = self.sum()
            self.need(r"\amp")
            if self.take(r"\text{otherwise}"):
                holds = done = True
            else:
                self.need(r"\text{for}")
                holds = self.condition()
                while self.take(r"\wedge"):
                    holds = self.condition() and holds
            assert not (chosen is None and holds is None), "is it the first line that holds?"
            chosen = value if chosen is None and holds else chosen
            self.need(r"\end{cases}" if done else r"\row")
        return chosen

    def condition(self):
        """Whether it holds; None where a side is not real, as may be below the line that is chosen."""
        left, sign, right = self.sum(), self.need("<", ">"), self.sum()
        if isinstance(left, mpmath.mpc) or isinstance(right, mpmath.mpc):
            return None
        return left < right if sign == "<" else left > right

    # -- the smallest parts ----------------------------------------------------------------------------

    def atom(self):
        """A value, and whether an exponent behind it is the exponent of all of it."""
        self.peek()
        if match := HYPER.match(self.text, self.at):
            self.at = match.end()
            above, below, last = self.groups()
            assert [str(len(above)), str(len(below))] == re.findall(r"\d", match[0])
            return mpmath.hyper(above, below, *last), False
        if match := NUMBER.match(self.text, self.at):
            self.at = match.end()
            return mpmath.mpf(match[0]), True
        if self.take(r"\frac"):
            return self.group() / self.group(), False
        if self.take(r"\sqrt"):
            return mpmath.sqrt(self.group()), False
        if self.take(r"\mathrm{e}"):
            assert "e" not in self.symbols, "e has two meanings"
            return (mpmath.exp(self.group()), False) if self.take("^") else (+mpmath.e, True)
        if self.take(r"\lvert"):
            size = abs(self.group())
            self.need(r"\rvert")
            return size, True
        if self.peek(*OPEN):
            (inside,) = self.bracketed()
            return inside, True
        if self.take("{"):  # braces are not seen
            inside, _ = self.atom()
            self.need("}")
            return inside, True
        if found := self.take(*self.symbols):
            assert not self.peek("_"), f"not a known symbol at {self.text[self.at - 10 :]!r}"
            return self.symbols[found], "^" not in found and not re.search(r"\w [A-Za-z\\]", found)
        if found := self.take(*INDEXED):
            self.need("_")
            index = self.group()
            return INDEXED[found](index, *self.bracketed()), False
        if found := self.take(*CONSTANTS):
            return CONSTANTS[found](), True
        found = self.need(*FUNCTIONS)
        power = 1
        if self.take("^"):
            power = self.group()
            assert found in RAISED, "what is raised, the function or its argument?"
            assert power in range(2, 100), "an inverse function?"
        return FUNCTIONS[found](*self.arguments()) ** power, False


def read(text, symbols):
    """Return the value of a formula."""
    return Reader(text, symbols).value()


def rows(equation):
    r"""Return the lines of an equation as they are set; each must be sound by itself, or TeX stops."""
    inside = re.sub(r"\\(?:begin|end)\{(?:equation\*?|split)\}|\\label\{[^}]*\}", "", equation)
    found = in_cases(inside).split("\\\\\n")
    for number, row in enumerate(found):
        plain = re.sub(r"\\[{}]", "", row)
        assert plain.count("{") == plain.count("}"), row
        assert len(re.findall(r"\\left\b", row)) == len(re.findall(r"\\right\b", row)), row
        assert not re.search(r"[-+=/,]\s*$", row), f"an operator ends the line {row!r}"
        if number:
            assert re.match(r"\s*&\\q?quad \{\}[-+=]", row), f"what begins the line {row!r}?"
    return found


def equations(tex):
    """Return each criterion of a document: its label, its exact text, its formula and the definitions after it."""
    block = re.compile(
        r"^% exact: c = ([^\n]*)\n\\begin\{equation\}\n +\\label\{([^}]*)\}\n(.*?)\\end\{equation\}"
        r"((?:\nwhere|\n\\begin\{equation\*\}\n(?:(?!\\end).)*(?:\\end\{split\}\n)?\\end\{equation\*\})*)",
        re.M | re.S,
    )
    single = re.compile(r"\\begin\{equation\*\}(.*?)\\end\{equation\*\}", re.S)
    for exact, label, shown, after in block.findall(tex):
        yield label, exact, shown, single.findall(after) if after.startswith("\nwhere") else []


def sides(equation):
    """Return the left side without layout, and the right one."""
    left, right = plain(equation).split("=", 1)
    return left.strip(), right
