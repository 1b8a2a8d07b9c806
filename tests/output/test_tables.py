"""Tables of text: no line wider than a page, and nothing cut off."""

import random
import re

import pytest

from stickslip_sym.output import tables


def cell(chance):
    """Return a formula, a sentence or a number, sometimes none."""
    kind = chance.randrange(4)
    words = ["mu_s", "v**2/v_s**2", "exp(-v/v_c)", "1e-6", "(mu_s", "mu_m)", "friction,", "sticks", "-0.25", "="]
    chosen = chance.choices(words, k=chance.choice([1, 3, 10, 60]))
    if kind == 0:
        return "*".join(word.rstrip(",") for word in chosen)
    return "" if kind == 1 else (" + " if kind == 2 else " ").join(chosen)


def read(text, header):
    """Read the rows of a table back, without blanks; its first column has a number in the first line of a row."""
    starts = [re.search(rf"\b{name}\b", text).start() for name in header]
    rows = []
    for line in text.splitlines()[1:]:
        parts = [line[start:end].strip() for start, end in zip(starts, [*starts[1:], None], strict=True)]
        if parts[0]:
            rows.append([[] for _ in header])
        for known, part in zip(rows[-1], parts, strict=True):
            known.append(part)
    return [["".join(parts).replace(" ", "") for parts in row] for row in rows]


@pytest.mark.parametrize("seed", range(20))
def test_every_cell_of_a_narrow_table_can_be_read_back(seed):
    chance = random.Random(seed)
    header = ["row", *(f"h{number}" for number in range(chance.randint(1, 4)))]
    rows = [[str(row), *(cell(chance) for _ in header[1:])] for row in range(chance.randint(1, 5))]
    text = tables.table(header, rows)
    assert max(map(len, text.splitlines())) <= tables.WIDTH
    assert read(text, header) == [[content.replace(" ", "") for content in row] for row in rows]
    assert not re.search(r" $", text, re.M)


@pytest.mark.parametrize("seed", range(20))
def test_wrapped_text_is_the_text(seed):
    """Lines that go on with a factor follow without a blank, others with one."""
    chance = random.Random(seed)
    content, width = cell(chance), chance.randint(20, 90)
    lines = tables.wrapped(content, width)
    assert max(map(len, lines)) <= width
    joined = "".join(line if line[:1] in "*/" else f" {line}" for line in lines)
    assert joined.strip() == content
    assert not any(line.startswith("**") or line.endswith("*") for line in lines)


def test_a_word_that_does_not_fit_is_kept():
    word = "w" * 150
    assert "".join(tables.table(["a", "b"], [[word, "x y"]]).split()).count("w") == 150
