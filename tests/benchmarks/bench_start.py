"""What the first answer costs, from the prompt; run with ``python tests/benchmarks/bench_start.py``.

User and system seconds of processes, least of nine taken in turn, over those of ``import scipy.optimize``.
"""

import os
import subprocess
import sys

IMPORT = [sys.executable, "-c", "import scipy.optimize"]
COMMAND = [sys.executable, "-c", "from stickslip_sym.cli.program import main; main()"]
LINES = {
    "a threshold of the catalogue": "damping exponential -V 0.5 -N 9.81 -m 1 -k 100",
    "a typo in a law's name": "damping exponentail -V 0.5 -N 9.81",
    "a new law, proved": "derive mu_m+(mu_s-mu_m)/(1+v/v_s)",
    "help": "--help",
}


def seconds(command):
    before = os.times()
    subprocess.run(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    after = os.times()
    return after.children_user + after.children_system - before.children_user - before.children_system


def main():
    commands = {name: [*COMMAND, *line.split()] for name, line in LINES.items()}
    commands["import scipy.optimize"] = IMPORT
    least = dict.fromkeys(commands, float("inf"))
    for _ in range(9):
        for name, command in commands.items():
            least[name] = min(least[name], seconds(command))
    unit = least["import scipy.optimize"]
    for name, found in least.items():
        print(f"{name:30} {found:.2f} s, {found / unit:.2f} x")


if __name__ == "__main__":
    main()
