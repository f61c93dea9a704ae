"""The command line: one module a command, listed in :mod:`selfmotion.cli.app`.

A command is a function named like its module. It takes what :mod:`selfmotion.cli.options` offers,
imports what is heavy inside itself, and returns an exit code, mostly that of
:func:`selfmotion.cli.output.finish`. It raises on bad input; :mod:`selfmotion.cli.running` turns
that into one line. Its `CONTRACT` gives the schema and the golden example in docs/cli
(`make golden` writes them anew).
"""
