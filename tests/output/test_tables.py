"""Tables of text, and long formulas as lines: none wider than a page, nothing cut off, and read back the same."""

import random
import re

import mpmath
import pytest
import sympy as sp

from stickslip_sym.output import abbreviation, printing, tables
from support.sweeps import sample
from support.text_reader import read_text

WORDS = ["mu_s", "v**2/v_s**2", "exp(-v/v_c)", "1e-6", "(mu_s", "mu_m)", "friction,", "sticks", "-0.25", "="]
NAMES = ("V", "N", "g_1", "mu_s", "q", "w")
V, N, G, MU, Q, W = SYMBOLS = sp.symbols(NAMES, positive=True)
POINT = dict(zip(NAMES, map(mpmath.mpf, ("0.5", "9.81", "1.25", "0.4", "0.75", "2.5")), strict=True))


def cell(chance):
    """Return a formula, a sentence or a number, sometimes none."""
    joint = chance.choice(["*", "", " + ", " "])
    chosen = [
        word.rstrip(",") if joint == "*" else word for word in chance.choices(WORDS, k=chance.choice([1, 3, 60]))
    ]
    return joint.join(chosen) if joint else ""


def read(text, header):
    """Read the rows of a table back, without blanks; its first column has a number in the first line of a row."""
    places = [re.search(rf"\b{name}\b", text).start() for name in header]
    rows = []
    for line in text.splitlines()[1:]:
        parts = [line[a:b].replace(" ", "") for a, b in zip(places, [*places[1:], None], strict=True)]
        if parts[0]:
            rows.append(parts)
        else:
            rows[-1] = [known + part for known, part in zip(rows[-1], parts, strict=True)]
    return rows


@pytest.mark.parametrize("seed", range(20))
def test_cells_of_a_table_are_read_back(seed):
    chance = random.Random(seed)
    header = ["row", *(f"h{number}" for number in range(chance.randint(1, 4)))]
    rows = [[str(row), *(cell(chance) for _ in header[1:])] for row in range(chance.randint(1, 5))]
    text = tables.aligned_table(header, rows)
    assert max(map(len, text.splitlines())) <= tables.TERMINAL_WIDTH
    assert read(text, header) == [[content.replace(" ", "") for content in row] for row in rows]
    assert not re.search(r" $", text, re.M)


def sum_of(chance, blocks):
    """Return a sum of products of blocks and of their functions, some of them repeated."""
    products = []
    for _ in range(chance.randint(1, 6)):
        parts = [chance.choice(blocks) ** chance.choice([-1, 1, sp.Rational(1, 2)]) for _ in range(2)]
        outer = chance.choice([sp.exp, sp.tanh, lambda x: sp.log(1 + x**2), lambda x: x])
        products.append(chance.choice([-3, 1, 5]) * sp.Mul(*parts) * outer(chance.choice(blocks) / 100))
    return sp.Add(*products)


@sample(1)
@pytest.mark.parametrize("seed", [0, 1, 2, *(pytest.param(n, marks=pytest.mark.thorough) for n in range(3, 12))])
def test_a_long_formula_can_be_read_back(seed):
    """From its definitions, each of which uses those above it; blanks and line ends mean nothing."""
    chance = random.Random(seed)
    blocks = [
        sp.Add(*(chance.randint(1, 9) * chance.choice(SYMBOLS) ** power for power in range(5))) for _ in "abc"
    ]
    expr = sum_of(chance, [*blocks, *(sum_of(chance, blocks) ** 2 + 1 for _ in "ab")])
    shown, text, known = abbreviation.indented_equation("c", expr), printing.text(expr), dict(POINT)
    first, *definitions = re.split(r"\n  (?:where\n  )?(?=\w+ =)", shown.strip())
    with mpmath.workdps(60):  # for exponentials of exponentials
        for equation in [*definitions, first]:
            name, value = "".join(equation.split()).split("=")
            assert name not in known
            known[name] = read_text(value, known)
        assert mpmath.almosteq(known["c"], read_text(text, POINT), rel_eps=1e-30)
    assert max(map(len, shown.splitlines())) <= max(tables.TERMINAL_WIDTH, 400 if len(text) <= 400 else 0) + 6
    if "where" not in shown:
        assert "".join(shown.split()) == "".join(f"c={text}".split())


def test_repeated_blocks_have_one_letter():
    block = sp.Add(*(number * V**number * sp.exp(-number * G) for number in range(1, 9)))
    waves = sum(sp.sin(number * V) * W**number for number in range(1, 25))
    shown = abbreviation.indented_equation("c", N / block + sp.sqrt(block) * MU + Q * block * waves)
    assert shown.count("exp(-7*g_1)") == 1
    assert re.search(r"^  where\n  p =", shown, re.M)  # q is taken
    assert abbreviation.indented_equation("c", N * MU - V) == f"  c = {printing.text(N * MU - V)}"


@pytest.mark.parametrize(("count", "is_whole"), [(40, True), (160, False)])
def test_a_formula_of_some_lines_is_broken(count, is_whole):
    shown = abbreviation.indented_equation("c", sp.Add(*sp.symbols(f"a100:{100 + count}", positive=True)))
    assert (len(shown.splitlines()) == 1) == is_whole


@pytest.mark.parametrize(("count", "has_letter"), [(3, False), (9, True)])
def test_a_letter_saves_some_characters(count, has_letter):
    """A block twice, in a formula of many terms."""
    block = sp.Add(*sp.symbols(f"b100:{100 + count}", positive=True))
    rest = sp.Add(*sp.symbols("a100:180", positive=True))
    shown = abbreviation.indented_equation("c", rest + sp.exp(block) + sp.tanh(block))
    assert ("where" in shown) == has_letter


@pytest.mark.parametrize(("symbols", "count", "has_letter"), [(140, 3, False), (450, 3, True), (450, 2, False)])
def test_short_blocks_have_a_letter_in_a_formula_of_many_lines(symbols, count, has_letter):
    """One of 25 characters, and if it stands there more than twice: two letters and a line would be no shorter."""
    block = sp.Add(*sp.symbols("b100:104", positive=True))
    functions = [sp.exp, sp.tanh, sp.sinh][:count]
    rest = sp.Add(*sp.symbols(f"a100:{100 + symbols}", positive=True))
    shown = abbreviation.indented_equation("c", rest + sp.Add(*(function(block) for function in functions)))
    assert ("where" in shown) == has_letter


def test_columns_are_two_blanks_apart_and_lines_as_long_as_those_of_a_terminal():
    assert tables.aligned_table(["name", "value"], [["mu_s", "0.5"]]) == "name  value\nmu_s  0.5"
    longest = max(map(len, tables.fitted("word " * 100).splitlines()))
    assert 70 < longest <= 80


def test_beside_a_number_of_many_digits_there_is_room_for_other_columns():
    shown = tables.aligned_table(["value", "why"], [["0." + "1234567890" * 8, "word " * 40]])
    assert 30 < max(map(len, shown.splitlines())) - 84 < 50


def test_a_table_shows_nothing_by_itself_in_jupyter(monkeypatch):
    monkeypatch.setattr("rich.console._is_jupyter", lambda: True)
    shown = []
    monkeypatch.setattr("rich.jupyter.display", lambda *given: shown.append(given))
    assert "mu_s" in tables.aligned_table(["name", "value"], [["mu_s", "0.5"]])
    assert shown == []
