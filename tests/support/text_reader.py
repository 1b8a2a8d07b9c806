"""Reads back what this package writes as a line of text, by Python's grammar, straight to mpmath numbers."""

import ast

import mpmath

from support.random_formulas import KNOWN

FUNCTIONS = {function.__name__: value for function, value in KNOWN.items()} | {
    "sqrt": mpmath.sqrt, "Max": max, "Min": min, "hyper": mpmath.hyper,
}  # fmt: skip
CONSTANTS = {"pi": mpmath.pi, "Catalan": mpmath.catalan}
BINARY = {
    ast.Add: lambda a, b: a + b, ast.Sub: lambda a, b: a - b, ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b, ast.Pow: lambda a, b: a**b,
}  # fmt: skip


def read_text(text, symbols):
    """Return the value of a formula; `symbols` gives the value of each symbol by its name."""

    def walk(node, known):
        match node:
            case ast.Constant(value=int() | float()):
                return mpmath.mpf(ast.get_source_segment(text, node))
            case ast.Name(id=name):
                return known[name] if name in known else +CONSTANTS[name]
            case ast.UnaryOp(op=ast.USub()):
                return -walk(node.operand, known)
            case ast.BinOp():
                return BINARY[type(node.op)](walk(node.left, known), walk(node.right, known))
            case ast.Compare(ops=[operator], comparators=[other]):
                left, right = walk(node.left, known), walk(other, known)
                return left < right if isinstance(operator, ast.Lt) else left > right
            case ast.Tuple(elts=parts):
                return [walk(part, known) for part in parts]
            case ast.Call(func=ast.Name(id="Piecewise"), args=parts):
                return walk(next(p.elts[0] for p in parts if held(p.elts[1], known)), known)
            case ast.Call(func=ast.Name(id="Integral"), args=[function, ast.Tuple(elts=[ast.Name(id=x), *ends])]):
                low, high = (walk(end, known) for end in ends)
                return mpmath.quad(lambda place: walk(function, known | {x: place}), [low, high])
            case ast.Call(func=ast.Name(id="Derivative"), args=[function, ast.Name(id=x)]):
                return mpmath.diff(lambda place: walk(function, known | {x: place}), known[x])
            case ast.Call(func=ast.Name(id=name)):
                return FUNCTIONS[name](*(walk(argument, known) for argument in node.args))
        raise AssertionError(f"{ast.unparse(node)} is no formula")

    def held(condition, known):
        return isinstance(condition, ast.Constant) or walk(condition, known)

    return walk(ast.parse(text, mode="eval").body, symbols)
