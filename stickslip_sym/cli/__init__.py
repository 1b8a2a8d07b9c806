"""The command line, one file a command.

Imports everything. A command is one file with a function `run` of what was given, and its name in `program`.
"""
