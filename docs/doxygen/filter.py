#!/usr/bin/python3
"""Prints a header with its plain comments as Doxygen comments. Doxygen runs it for each input file,
with the Python of Debian, which starts fast.

    filter.py HEADER

A comment before a declaration documents it, and so does a comment at the end of a line. The first
comment of a header documents the file. Comments in function bodies and at the end of a block stay
plain. Characters with a meaning for Doxygen are escaped, and drawings are kept as they are.
"""

import re
import sys

TYPE = re.compile(r"^\s*(template\s*<.*>\s*)?(class|struct|enum|union|namespace|extern)\b")


def escaped(text):
    """Returns the text with all characters escaped that mean something, except in `code`."""
    return re.sub(r"(`[^`]+`)|([\\@<>&#%\"$]|::)", lambda m: m.group(1) or "\\" + m.group(2), text)


def is_drawing(line, in_list):
    """Returns whether a line is kept as it is: a drawing, a formula or an example of a file."""
    return bool(re.search(r"\+-{2,}|^ *\|", line)) or (line.startswith("  ") and not in_list)


def as_paragraphs(lines):
    """Returns the lines of a comment for Doxygen."""
    result, kept, in_list = [], False, False
    for i, line in enumerate(lines):
        if line and not line.startswith(" "):
            in_list = line.startswith("- ")
        rest = [x for x in lines[i:] if x.strip()]
        keep = bool(rest) and is_drawing(rest[0], in_list) and (kept or bool(line.strip()))
        if keep != kept:
            result.append("@verbatim" if keep else "@endverbatim")
            kept = keep
        result.append(line if keep else escaped(line))
    return result + ["@endverbatim"] * kept


def filtered(text):
    blocks = []  # for each open brace: whether declarations can be in it
    previous = ""  # code before the brace, for declarations of several lines
    lines, i, first_comment, result = text.split("\n"), 0, True, []
    while i < len(lines):
        line = lines[i]
        documents = all(blocks)
        comment = re.match(r"^(\s*)//( ?.*)$", line)
        if comment and documents:
            body = []
            while i < len(lines) and (more := re.match(r"^\s*//(.*)$", lines[i])):
                body.append(re.sub("^ ", "", more.group(1)))
                i += 1
            # Doxygen needs an empty line to end the text of a file.
            head = ["/// @file"] if first_comment else []
            first_comment = False
            result += head + [f"{comment.group(1)}/// {x}".rstrip() for x in as_paragraphs(body)]
            continue
        code, slashes, trailing = line.partition("//")
        ends_block, declares_only = code.strip().startswith("}"), re.match(r"\s*(class|struct) \w+;", code)
        if slashes and documents and code.count('"') % 2 == 0 and not ends_block and not declares_only:
            result.append(f"{code}///<{escaped(trailing)}")
            column = len(code)
            # A comment that goes on in the next lines at the same column.
            while i + 1 < len(lines) and re.match(rf"^ {{{column}}}//", lines[i + 1]):
                i += 1
                result.append(" " * column + "///<" + escaped(lines[i][column + 2:]))
        else:
            result.append(line)
        for character in re.sub(r'"([^"\\]|\\.)*"|\'([^\'\\]|\\.)\'', "", code):
            if character == "{":
                blocks.append(bool(TYPE.match(previous)) and "=" not in previous)
                previous = ""
            elif character == "}":
                if blocks:
                    blocks.pop()
                previous = ""
            elif character == ";":
                previous = ""
            else:
                previous += character
        previous += " "
        if line.startswith("#"):
            previous = ""
        i += 1
    return "\n".join(result)


if __name__ == "__main__":
    sys.stdout.write(filtered(open(sys.argv[1], encoding="utf-8").read()))
