"""Exported code run in its language: Python here, C99 without a word of warning, Octave."""

import ctypes
import re
import shutil
import subprocess

PROGRAMS = {"python": None, "c": "cc", "octave": "octave-cli"}
"""What runs the text of a language beside this process."""


def runs(language):
    """Whether this machine runs a language."""
    return PROGRAMS[language] is None or shutil.which(PROGRAMS[language]) is not None


def compiled(text, name, folder):
    """Compile C99, and return its function of that name; its arguments are doubles."""
    (folder / "a.c").write_text(text)
    strict = ["-std=c99", "-pedantic", "-O2", "-Wall", "-Wextra", "-Werror", "-ffp-contract=off"]
    command = ["cc", *strict, "-shared", "-fPIC", "a.c", "-o", "a.so", "-lm"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stderr
    function = getattr(ctypes.CDLL(str(folder / "a.so")), name)
    function.restype = ctypes.c_double
    return lambda *numbers: function(*map(ctypes.c_double, numbers))


def values_of(language, text, calls, folder):
    """Return the values of calls, each a name and numbers, of the functions in a text."""
    if language == "python":
        exec(compile(text, "text", "exec"), module := {})
        return [module[name](*numbers) for name, numbers in calls]
    if language == "c":
        functions = {name: compiled(text, name, folder) for name in dict(calls)}
        return [functions[name](*numbers) for name, numbers in calls]
    file = re.search(r"^function \w+ = (\w+)\(", text, re.M)[1]
    (folder / f"{file}.m").write_text(text)
    several = file == "damping_criteria"
    head = "criteria = damping_criteria();\n" if several else ""
    lines = [
        f"printf('%.17g\\n', {'criteria.' * several}{name}({', '.join(map(str, map(float, numbers)))}));\n"
        for name, numbers in calls
    ]
    (folder / "calls.m").write_text(head + "".join(lines))
    command = ["octave-cli", "--norc", "--quiet", "calls.m"]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=60, check=True)
    return [float(line) for line in done.stdout.splitlines()]
