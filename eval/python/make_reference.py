#!/usr/bin/python3
"""Writes the reference page of the Python module from its docstrings.

    PYTHONPATH=build/release/python make_reference.py docs/pages/reference/python.md
"""

import inspect
import re
import sys
from pathlib import Path

import pickbed

MARK = "<!-- Written by make_reference.py from the docstrings of the module. Do not edit. -->"


def escaped(text):
    """Escapes what means something in Markdown, except in `code`."""
    return re.sub(r"(`[^`]+`)|([*_<>|\[\]\\])", lambda m: m.group(1) or "\\" + m.group(2), text)


def call_of(doc):
    """Returns the call and the text of a docstring that begins with a signature, without types."""
    signature, _, text = doc.partition("\n\n")
    name, _, rest = signature.partition("(")
    arguments, depth, found = rest.rpartition(")")[0] if "->" not in rest else rest.rpartition(") ->")[0], 0, [""]
    for character in arguments:
        depth += (character in "([{") - (character in ")]}")
        if character == "," and depth == 0:
            found.append("")
        else:
            found[-1] += character
    names = []
    for argument in (part.strip() for part in found):
        default = re.search(r" = (.*)$", argument)
        name_only = argument.partition(":")[0].strip()
        if name_only and name_only != "self":
            names.append(name_only + (f"={default.group(1)}" if default else ""))
    return f"{name}({', '.join(names)})", text.strip()


def paragraph(text):
    return escaped(" ".join(text.split()))


def rows_of(members):
    return [f"| `{name}` | {paragraph(text)} |" for name, text in members]


def describe(name, value):
    lines = ["", f"## {name}", "", escaped(value.__doc__.strip())]
    properties, methods = [], []
    for member, item in vars(value).items():
        if isinstance(item, property):
            properties.append((member, item.__doc__ or ""))
        elif member == "__init__" and (item.__doc__ or "").startswith("__init__("):
            call, text = call_of(item.__doc__.strip())
            methods.insert(0, (call.replace("__init__", name), text))
        elif not member.startswith("_") and callable(getattr(value, member)):
            methods.append(call_of(getattr(value, member).__doc__.strip()))
    if methods:
        lines += ["", "| call | meaning |", "|---|---|", *rows_of(methods)]
    if properties:
        lines += ["", "| attribute | meaning |", "|---|---|", *rows_of(properties)]
    return lines


def page():
    lines = ["# Python module", "", MARK, ""]
    lines += [escaped(pickbed.__doc__.strip())]
    public = [(name, value) for name, value in vars(pickbed).items() if not name.startswith("_")]
    functions = [call_of(value.__doc__.strip()) for _, value in public if inspect.isbuiltin(value)]
    lines += ["", "## Functions", "", "| call | meaning |", "|---|---|", *rows_of(functions)]
    for name, value in public:
        if inspect.isclass(value) and not issubclass(value, Exception):
            lines += describe(name, value)
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    Path(sys.argv[1]).write_text(page(), encoding="utf-8")
