from typing import Any

from sympy.printing.codeprinter import CodePrinter

class NumPyPrinter(CodePrinter):
    def __getattr__(self, name: str) -> Any: ...  # `known_functions`, made with it
