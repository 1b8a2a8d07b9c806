"""Notebooks: their cells run as Jupyter runs them, in plain Python.

``python tests/support/notebooks.py FILE`` writes what the cells of a notebook give.
"""

import ast
import base64
import contextlib
import io
import json
import sys
from pathlib import Path

DPI = 72  # of a picture in a notebook that is committed


def run(source, names):
    """Run a cell; return what it prints, and the value of its last line."""
    tree, last = ast.parse(source), None
    if tree.body and isinstance(tree.body[-1], ast.Expr):
        last = ast.Expression(tree.body.pop().value)
    stream = io.StringIO()
    with contextlib.redirect_stdout(stream):
        exec(compile(tree, "a cell", "exec"), names)
        value = None if last is None else eval(compile(last, "a cell", "eval"), names)
    return stream.getvalue(), value


def outputs(printed, value, count):
    """Return the outputs of a cell as a notebook keeps them: text, and a figure as a picture."""
    kept = []
    if printed:
        kept.append({"output_type": "stream", "name": "stdout", "text": printed.splitlines(keepends=True)})
    if value is not None:
        data = {"text/plain": [repr(value)]}
        if hasattr(value, "savefig"):
            stream = io.BytesIO()
            value.savefig(stream, format="png", dpi=DPI)
            data = {"image/png": base64.b64encode(stream.getvalue()).decode(), "text/plain": ["<Figure>"]}
        kept.append({"output_type": "execute_result", "execution_count": count, "metadata": {}, "data": data})
    return kept


def code_cells(notebook):
    return [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]


def text_of(kept):
    """Return the lines of the outputs that are text."""
    lines = []
    for output in kept:
        lines += output.get("text") or output["data"]["text/plain"]
    return [line.rstrip("\n") for line in lines]


def main(path):
    """Run a notebook in its own folder, and write what its cells give."""
    notebook, names = json.loads(path.read_text(encoding="utf-8")), {}
    with contextlib.chdir(path.parent):
        for count, cell in enumerate(code_cells(notebook), 1):
            cell["execution_count"] = count
            cell["outputs"] = outputs(*run("".join(cell["source"]), names), count)
    path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main(Path(sys.argv[1]).resolve())
