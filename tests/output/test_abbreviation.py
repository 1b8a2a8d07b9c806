"""Long formulas as lines of text: read back, they are the formula."""

import random
import re

import mpmath
import pytest
import sympy as sp

from stickslip_sym.output import abbreviation, printing, tables
from tests.support.text_reader import read_text

NAMES = ("V", "N", "g_1", "mu_s", "q", "w")
V, N, G, MU, Q, W = SYMBOLS = sp.symbols(NAMES, positive=True)
POINT = dict(zip(NAMES, map(mpmath.mpf, ("0.5", "9.81", "1.25", "0.4", "0.75", "2.5")), strict=True))


def sum_of(chance, blocks):
    """Return a sum of products of blocks and of their functions, some of them repeated."""
    products = []
    for _ in range(chance.randint(1, 6)):
        parts = [chance.choice(blocks) ** chance.choice([-1, 1, sp.Rational(1, 2)]) for _ in range(2)]
        outer = chance.choice([sp.exp, sp.tanh, lambda x: sp.log(1 + x**2), lambda x: x])
        products.append(chance.choice([-3, 1, 5]) * sp.Mul(*parts) * outer(chance.choice(blocks) / 100))
    return sp.Add(*products)


def read(shown):
    """Return the value of an equation and of the definitions below it; blanks and line ends mean nothing."""
    known = dict(POINT)
    first, *definitions = re.split(r"\n  (?:where\n  )?(?=\w+ =)", shown.strip())
    for equation in [*definitions, first]:
        name, value = "".join(equation.split()).split("=")
        known[name] = read_text(value, known)
    return known["c"]


@pytest.mark.parametrize("seed", [0, 1, 2, *(pytest.param(n, marks=pytest.mark.thorough) for n in range(3, 12))])
def test_a_long_formula_can_be_read_back(seed):
    chance = random.Random(seed)
    blocks = [
        sp.Add(*(chance.randint(1, 9) * chance.choice(SYMBOLS) ** power for power in range(5))) for _ in "abc"
    ]
    expr = sum_of(chance, [*blocks, *(sum_of(chance, blocks) ** 2 + 1 for _ in "ab")])
    shown, text = abbreviation.formula("c", expr), printing.text(expr)
    with mpmath.workdps(60):  # for exponentials of exponentials
        assert mpmath.almosteq(read(shown), read_text(text, POINT), rel_eps=1e-30)
    assert max(map(len, shown.splitlines())) <= max(tables.WIDTH, 400 if len(text) <= 400 else 0) + 6
    if "where" not in shown:
        assert "".join(shown.split()) == "".join(f"c={text}".split())


def test_every_term_has_its_line_and_repeated_blocks_one_letter():
    block = sp.Add(*(number * V**number * sp.exp(-number * G) for number in range(1, 9)))
    expr = (
        N / block
        + sp.sqrt(block) * MU
        + Q * block * sum(sp.sin(number * V) * W**number for number in range(1, 25))
    )
    shown = abbreviation.formula("c", expr)
    assert len(re.findall(r"^    [+-]? ?\S", shown, re.M)) >= 3
    assert shown.count("exp(-7*g_1)") == 1
    assert re.search(r"^  where\n  p =", shown, re.M)  # q is taken


def test_a_short_formula_stays_on_its_line():
    assert abbreviation.formula("c", N * MU - V) == f"  c = {printing.text(N * MU - V)}"
