"""Exported code run in its language: Python here, C99 without a word of warning, Octave, JavaScript."""

import ctypes
import json
import re
import shutil
import subprocess

import numpy as np

PROGRAMS = {"python": None, "c": "cc", "octave": "octave-cli", "javascript": "node"}
"""What runs the text of a language beside this process."""


def runs(language):
    """Whether this machine runs a language."""
    return PROGRAMS[language] is None or shutil.which(PROGRAMS[language]) is not None


def compiled(text, folder, allowed=()):
    """Compile C99; return what gives the value of a function of doubles by its name and its arguments."""
    (folder / "a.c").write_text(text)
    strict = ["-std=c99", "-pedantic", "-O2", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off", *allowed]
    command = ["cc", *strict, "-shared", "-fPIC", "a.c", "-o", "a.so", "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    library = ctypes.CDLL(str(folder / "a.so"))

    def value(name, numbers):
        function = getattr(library, name)
        function.restype = ctypes.c_double
        return function(*map(ctypes.c_double, numbers))

    return value


def values_of(language, text, calls, folder, allowed=()):
    """Return the values of calls, each a name and numbers, of the functions in a text.

    In Python and Octave the numbers may be arrays. `allowed` are options of the C compiler that take a warning
    back.
    """
    if language == "python":
        exec(compile(text, "text", "exec"), module := {})
        return [module[name](*numbers) for name, numbers in calls]
    if language == "c":
        value = compiled(text, folder, allowed)
        return [value(name, numbers) for name, numbers in calls]
    if language == "javascript":
        lines = [
            f"console.log({name}({', '.join(json.dumps(float(n)) for n in numbers)}));" for name, numbers in calls
        ]
        text = "\n".join([text, *lines])
        (folder / "calls.js").write_text(text)
        command = ["node", "calls.js"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60, check=True)
        return [float(line) for line in done.stdout.split()]
    file = re.search(r"^function \w+ = (\w+)\(", text, re.M)[1]
    several = file == "damping_criteria"
    head = "criteria = damping_criteria();\n" if several else ""
    if text.startswith("1;"):  # a script
        head = text
    else:
        (folder / f"{file}.m").write_text(text)
    lines = []
    for name, numbers in calls:
        arrays = ", ".join(str(np.ravel(number).astype(float).tolist()) for number in numbers)
        lines.append(f"printf('%.17g\\n', {'criteria.' * several}{name}({arrays}));\n")
    (folder / "calls.m").write_text(head + "".join(lines))
    command = ["octave-cli", "--norc", "--quiet", "calls.m"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60, check=True)
    return [float(line) for line in done.stdout.splitlines()]
