"""CONTRIBUTING begins with the way of one call: the call goes that way, and enters no other folder."""

import re
import sys
from pathlib import Path

import stickslip_sym as ss

PACKAGE = Path(ss.__file__).parent
TEXT = (
    (PACKAGE.parent / "CONTRIBUTING.md").read_text().partition("## The way of one call")[2].partition("\n## ")[0]
)
STOPS = re.findall(r"^\d\. `([\w/]+\.py)`, `([\w.]+)`", TEXT, re.M)
MENTIONED = re.findall(r"`([\w/]+\.py)`", TEXT)


def calls_of(run):
    """Return the result of a function, and the functions of the package that it calls, in order."""
    made, root = [], f"{PACKAGE}/"

    def note(frame, event, _):
        code = frame.f_code
        if event == "call" and code.co_filename.startswith(root):
            made.append((code.co_filename.removeprefix(root), code.co_qualname))

    before = sys.getprofile()
    sys.setprofile(note)
    try:
        result = run()
    finally:
        sys.setprofile(before)
    return result, made


def folder(path):
    """Return a folder of the package, or the part of a wing."""
    parts = path.split("/")[:-1]
    return "/".join(parts[:2])


def test_the_call_goes_the_way_that_is_told():
    text = re.search(r'pure_slip_damping\("(.*?)", V=0.5, N=9.81, m=1, k=100\)', TEXT)[1]
    point = {"V": 0.5, "N": 9.81, "m": 1, "k": 100}
    ss.pure_slip_damping(text, **point)  # so that all modules are loaded
    law = text.replace("3*v", "3.0625*v")  # one that no other test has computed
    threshold, made = calls_of(lambda: ss.pure_slip_damping(law, **point))
    assert threshold.method == "orbit"
    assert 5 <= len(STOPS) <= 8
    assert [made.index(stop) for stop in STOPS] == sorted(made.index(stop) for stop in STOPS)
    told = {folder(path) for path in MENTIONED if (PACKAGE / path).is_file()}
    entered = {folder(path) for path, _ in made} - {"core"}
    assert entered <= told
    assert f"enters {['no', 'one', 'two', 'three', 'four', 'five', 'six', 'seven'][len(entered)]} folders" in TEXT
