"""Results as scripts that prove them without this package, for readers who trust nothing of it.

`closed_forms` and `derivations` write scripts in plain SymPy, `enclosures` and `thresholds` in python-flint, each
with a page of text beside it. The methods that users call, such as `ClosedForm.certificate`, import the writer of
their class when they are called: these are the only arrows that come up to this folder.
"""
