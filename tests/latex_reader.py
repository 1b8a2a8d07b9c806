r"""Reads back the LaTeX that this package prints: a parser of its own, straight to mpmath numbers.

It shares nothing with the printer: it knows how a person reads \frac, juxtaposition, slashes and brackets.
"""

import re

import mpmath

FUNCTIONS = {
    r"\ln": mpmath.log, r"\exp": mpmath.exp, r"\tanh": mpmath.tanh, r"\arctan": mpmath.atan, r"\sin": mpmath.sin,
    r"\operatorname{arsinh}": mpmath.asinh, r"\operatorname{sech}": mpmath.sech, r"\operatorname{erf}": mpmath.erf,
    r"\operatorname{Im}": mpmath.im, r"\gamma": lambda s, x: mpmath.gammainc(s, 0, x), r"\eta": mpmath.altzeta,
    r"\Pi": mpmath.ellippi, "E": mpmath.ellipe,
}  # fmt: skip
INDEXED = {"I": mpmath.besseli, r"\operatorname{Li}": mpmath.polylog}
CONSTANTS = {r"\pi": lambda: mpmath.mpf(mpmath.pi), "G": lambda: mpmath.mpf(mpmath.catalan),
             r"\mathrm{i}": lambda: mpmath.mpc(0, 1)}  # fmt: skip
OPEN, CLOSE = ("(", "[", r"\{"), (")", "]", r"\}")
LAYOUT = re.compile(
    r"\\begin\{\w+\*?\}|\\end\{\w+\*?\}|\\label\{[^}]*\}|\\[lr]eft|\\[bB]igg?[lr]|\\\\|\\q?quad|\\,|&|\{\}(?!_)"
)
HYPER = re.compile(r"\{\}_\{\d\}F_\{\d\}")
NUMBER = re.compile(r"\d+")


class Reader:
    """One formula; `symbols` gives the value of each symbol by its LaTeX."""

    def __init__(self, text, symbols):
        self.text = re.sub(r"\s+", " ", LAYOUT.sub("", text)).replace(r"\times", "").strip()
        self.symbols = dict(sorted(symbols.items(), key=lambda item: -len(item[0])))
        self.at = 0

    def value(self):
        result = self.sum()
        assert self.at == len(self.text), f"unread: {self.text[self.at :]!r}"
        return result

    def peek(self, *texts):
        while self.text[self.at : self.at + 1] == " ":
            self.at += 1
        return next((text for text in texts if self.text.startswith(text, self.at)), None)

    def take(self, *texts):
        found = self.peek(*texts)
        if found:
            self.at += len(found)
        return found

    def need(self, *texts):
        found = self.take(*texts)
        assert found, f"expected one of {texts} at {self.text[self.at : self.at + 40]!r}"
        return found

    def sum(self):
        total = -self.term() if self.take("-") else self.term()
        while sign := self.take("+", "-"):
            total += self.term() if sign == "+" else -self.term()
        return total

    def term(self):
        product = self.factor()
        while self.at < len(self.text) and not self.peek("+", "-", ",", ";", "}", *CLOSE):
            if self.take("/"):
                product /= self.factor()
            else:
                product *= self.factor()
        return product

    def factor(self):
        base = self.atom()
        return base ** self.group() if self.take("^") else base

    def group(self):
        self.need("{")
        inside = self.sum()
        self.need("}")
        return inside

    def bracketed(self):
        opened = self.need(*OPEN)
        found = [self.sum()]
        while self.take(",", ";"):
            found.append(self.sum())
        assert self.need(*CLOSE) == CLOSE[OPEN.index(opened)]
        return found

    def atom(self):
        self.peek()
        if match := HYPER.match(self.text, self.at):
            self.at = match.end()
            a, b = map(int, re.findall(r"\d", match[0]))
            arguments = self.bracketed()
            assert len(arguments) == a + b + 1
            return mpmath.hyper(arguments[:a], arguments[a : a + b], arguments[-1])
        if match := NUMBER.match(self.text, self.at):
            self.at = match.end()
            return mpmath.mpf(match[0])
        if self.take(r"\frac"):
            return self.group() / self.group()
        if self.take(r"\sqrt"):
            return mpmath.sqrt(self.group())
        if self.take(r"\mathrm{e}"):
            self.need("^")
            return mpmath.exp(self.group())
        if self.peek(*OPEN):
            (inside,) = self.bracketed()
            return inside
        if found := self.take(*self.symbols):
            return self.symbols[found]
        if found := self.take(*INDEXED):
            self.need("_")
            index = self.group()
            return INDEXED[found](index, *self.bracketed())
        if found := self.take(*CONSTANTS):
            return CONSTANTS[found]()
        found = self.need(*FUNCTIONS)
        power = self.group() if self.take("^") else 1
        return FUNCTIONS[found](*self.bracketed()) ** power


def read(text, symbols):
    """Return the value of a formula."""
    return Reader(text, symbols).value()


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
    left, right = LAYOUT.sub("", equation).split("=", 1)
    return left.strip(), right
