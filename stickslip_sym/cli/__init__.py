"""The command line, one file a command.

Imports everything. One more command is one file with its function, and its line in `program`; it takes
the options of a law and of a scene as groups, from `shared.law` and `shared.options`.
"""
