"""What messages name on the command line: options, where they name Python's arguments elsewhere."""

import re
from collections.abc import Callable

__all__ = ["in_options"]

_SCENE = ("V", "N", "m", "k", "c")
_OPTIONS = (
    "method", "criterion", "workers", "time_limit", "rtol", "t_end", "x0", "v0", "static",
    "name", "source", "radius", "speeds",
)  # fmt: skip
_RULES: list[tuple[str, str | Callable[[re.Match[str]], str]]] = [
    (r"bind them first: law\.bind\(([^()]*)\)", r"give \1"),
    (r"(?:bind it first: )?\blaw\.bind\((\w+=[\w.]+)\)", r"-p \1"),
    (r"bind them first", "give each by -p NAME=VALUE"),
    (r"declare it with Parameter\('(\w+)', positive=False\) if any sign is meant",
     r"write the formula with -\1, and give a positive value, if any sign is meant"),
    (r"use evaluate\(digits=\.\.\.\)", "stickslip derive computes it to 50 digits"),
    (r"columns=\{'(\w+)': '?([^'}]*)'?, '(\w+)': '?([^'}]*)'?\}", r'--column \1="\2" --column \3="\4"'),
    (r"columns=\{'(\w+)': '?([^'}]*)'?\}", r'--column \1="\2"'),
    (r"\b(leave|keep)_(out|outliers)=True", r"--\1-\2"),
    (r"pass extrapolate=True", "give --extrapolate"),
    (r"extrapolate=True", "--extrapolate"),
    (r"\bsimulate\(\)", "stickslip simulate"),
    (r"within=\(low, high\)", "--within LOW:HIGH"),
    (r"units=\{'(\w+)': \.\.\.\}", r"--unit \1=..."),
    (rf"\b({'|'.join(_OPTIONS)})=(\"?)([\w.+-]+)\2", lambda m: f"--{m[1].replace('_', '-')} {m[3]}"),
    (rf"(?<![\w-])({'|'.join(_SCENE)})=\.\.\.", r"-\1 ..."),
    (r"(?<!-p )(?<!--unit )(?<!--symbol )(?<![\w-])(\w+)=\.\.\.", r"-p \1=..."),
    (r"(=?\.\.\.), (?=-)", r"\1 "),
]  # fmt: skip
"""Python's words in a message, and those of the command line, replaced in this order."""


def in_options(message: str) -> str:
    """Return a message of the package as a user of the command line can follow it."""
    for python, option in _RULES:
        message = re.sub(python, option, message)
    return message
