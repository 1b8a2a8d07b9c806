"""Text of others steers no terminal, wherever it comes in and wherever it goes out."""

import json
import unicodedata

import pytest
from hypothesis import given
from hypothesis import strategies as st

import stickslip_sym as ss
from stickslip_sym.core.foreign import printable

EVIL = "\x1b]0;owned\x07\x1b[2J\x9b31m\x00\u202egnp\r\nmu\ud800"
STEERING = {"Cc", "Cs", "Zl", "Zp"}


def steering(text):
    return {char for char in text if unicodedata.category(char) in STEERING} - {"\n", "\t"}


@given(st.text())
def test_what_is_printable_stays_and_the_rest_steers_nothing(text):
    shown = printable(text)
    assert not {char for char in shown if unicodedata.category(char) in STEERING}
    shown.encode()
    if text.isprintable():
        assert shown == text
    assert len(shown) == len(text)
    assert not steering(printable(text, lines=True)) - {"\r", "\u2028", "\u2029"}


@pytest.fixture
def law():
    parameters = [ss.Parameter("mu_s", meaning=EVIL, typical="0.5"), ss.Parameter("a", typical="0.1")]
    return ss.FrictionLaw("mu_s - a*v", name=EVIL, source=EVIL, validity=EVIL, parameters=parameters)


def test_no_view_of_a_law_or_form_holds_what_it_was_named(law, tmp_path):
    form = ss.derive(law)
    views = [str(law), repr(law), law._repr_html_(), repr(form), form._repr_html_(), form.latex()]
    views += [form.code(language) for language in ("python", "c", "octave", "javascript")]
    views += [form.certificate(), str(ss.pure_slip_damping(law.typical(), V=0.5, N=9.81, m=1, k=10))]
    for view in views:
        assert not steering(view)
    compile(form.code("python"), "code", "exec")
    compile(form.certificate(), "certificate", "exec")
    ss.save(law, tmp_path / "law.json")
    assert ss.load(tmp_path / "law.json") == law


def test_titles_of_columns_and_options_reach_no_terminal_raw(run, tmp_path):
    (tmp_path / "a.csv").write_bytes(
        b"\x1b[31mv [m/s],mu,\x1b]0;owned\x07x\n" + b"".join(b"0.%d,0.%d,1\n" % (i, 9 - i) for i in range(1, 9))
    )
    lines = [["read", "a.csv"], ["derive", "a*v", "--name", EVIL], ["derive", f"a*v{EVIL}"], ["laws", EVIL]]
    lines += [["damping", "linear", f"-V{EVIL}"], ["fit", f"{EVIL}.csv".replace("\0", "")]]
    for line in lines:
        _, out, err = run(*(part.encode(errors="replace").decode() for part in line))
        assert not steering(out + err), line
    _, out, _ = run("derive", "a*v", "--name", EVIL.replace("\ud800", ""), "--json")
    assert not steering(out)
    assert json.loads(out)


def test_a_typical_value_is_text():
    with pytest.raises(ss.InputError, match="typical is decimal text, got float"):
        ss.Parameter("a", typical=0.1)
