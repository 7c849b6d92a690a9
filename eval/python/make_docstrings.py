#!/usr/bin/python3
"""Writes the comments of C++ headers as a table of docstrings for the Python module.

    make_docstrings.py OUTPUT HEADER...

The table holds the comment before a declaration, or the one at the end of its line. Its names have no
namespace: "Mssd", "GraspOutcome::slip_m".
"""

import re
import sys
from pathlib import Path

SCOPE = re.compile(r"^(?:template\s*<.*?>\s*)?(class|struct|enum|union|namespace|extern)\b")
IN_PYTHON = [(re.compile(r"\b(?:nullopt|[Nn]ull)\b"), "None"),
             (re.compile(r"\bstd::(?:logic_error|invalid_argument)\b"), "ValueError"),
             (re.compile(r"\bkMinBinsOfInterval\b"), "MIN_BINS_OF_INTERVAL"), (re.compile(r"\bstd::"), ""),
             (re.compile(r"\bThrow"), "Raise"), (re.compile(r"\bthrow"), "raise")]


def text_of(lines):
    """Joins the lines of a comment. Lists and indented lines stay as they are."""
    result = []
    for line in lines:
        starts_new = not line.strip() or line.startswith(("- ", "  ", "+", "|")) or re.match(r"\d\. ", line)
        joins = result and result[-1].strip() and not starts_new
        if line.startswith("  ") and result and result[-1].startswith("- "):
            joins, line = True, line.strip()
        if joins:
            result[-1] += " " + line.strip()
        else:
            result.append(line.rstrip())
    text = "\n".join(result).strip()
    for pattern, word in IN_PYTHON:
        text = pattern.sub(word, text)
    return text


def without_templates(code):
    """Removes everything between < and >, so that only the parentheses of functions are left."""
    depth, result = 0, ""
    for i, character in enumerate(code):
        if character == "<":
            depth += 1
        elif character == ">" and code[i - 1] != "-":
            depth = max(0, depth - 1)
        elif depth == 0:
            result += character
    return result


def names_of(statement):
    """Returns the names that a declaration declares."""
    code = without_templates(re.sub(r"^template\s*<.*?>\s*", "", statement))
    head = re.split(r"[={]", code)[0]
    function = re.search(r"(~?\w+)\s*\(", head)
    if function:
        return [function.group(1)]
    # Several variables can share one type: "int above = -1, below = -1;".
    return [m.group(1) for m in re.finditer(r"(\w+)\s*(?:=[^,;]*|\{[^}]*\})?\s*[,;]", code)]


class Reader:
    def __init__(self):
        self.docs = {}

    def add(self, scopes, names, lines):
        prefix = "::".join(name for kind, name in scopes if kind != "namespace" and name)
        text = text_of(lines)
        for name in names:
            key = f"{prefix}::{name}" if prefix else name
            if text and key not in self.docs:
                self.docs[key] = text
        return [f"{prefix}::{name}" if prefix else name for name in names]

    def read(self, path):
        scopes, pending, statement, skipped = [], [], "", 0
        last, column, trailing = [], -1, []
        for line in path.read_text(encoding="utf-8").split("\n"):
            comment = re.match(r"^(\s*)//( ?.*)$", line)
            if comment and not statement and not skipped:
                if column >= 0 and len(comment.group(1)) == column:  # continues a comment behind code
                    trailing.append(comment.group(2).strip())
                    for key in last:
                        self.docs[key] = text_of(trailing)
                    continue
                column = -1
                pending.append(comment.group(2)[1:] if comment.group(2).startswith(" ") else comment.group(2))
                continue
            if not comment:
                column = -1
            code, slashes, behind = line.partition("//")
            if not code.strip() and not slashes:
                if not statement:
                    pending = []
                continue
            if code.startswith("#"):
                pending = []
                continue
            if skipped:  # the body of an inline function
                skipped += code.count("{") - code.count("}")
                if skipped <= 0:
                    skipped, statement, pending = 0, "", []
                continue
            statement = (statement + " " + code.strip()).strip()
            if statement.startswith("}"):
                if scopes:
                    scopes.pop()
                statement, pending = "", []
                continue
            if re.match(r"^(public|private|protected):$", statement):
                statement, pending = "", []
                continue
            is_scope = SCOPE.match(statement)
            if is_scope and statement.endswith("{"):
                named = re.match(r"(?:template\s*<.*?>\s*)?(?:enum\s+class|class|struct|enum|union|namespace|extern)\s+"
                                 r"(?:\[\[.*?\]\]\s*)?([\w:]*)", statement)
                name = named.group(1) if named else ""
                if is_scope.group(1) != "namespace":
                    self.add(scopes, [name], pending)
                scopes.append((is_scope.group(1), name))
                statement, pending = "", []
                continue
            if statement.count("(") != statement.count(")"):
                continue
            opens = statement.count("{") - statement.count("}")
            is_function = re.search(r"\w\s*\(", re.split(r"[={]", without_templates(statement))[0])
            if opens > 0:
                if is_function:
                    self.add(scopes, names_of(statement), pending)
                    skipped, statement, pending = opens, "", []
                continue  # an initializer of several lines
            in_enum = bool(scopes) and scopes[-1][0] == "enum"
            ends = statement.endswith(";") or (is_function and statement.endswith("}"))
            if not ends and not in_enum:
                continue
            names = [re.match(r"\w+", statement).group()] if in_enum else names_of(statement)
            if not re.match(r"^(using|friend|class|struct|static_assert)\b", statement):
                lines = [behind.strip()] if slashes and behind.strip() else pending
                last = self.add(scopes, names, lines)
                column = len(code) if slashes else -1
                trailing = [behind.strip()]
            statement, pending = "", []


def main():
    reader = Reader()
    for path in sys.argv[2:]:
        reader.read(Path(path))
    lines = ["// Written by eval/python/make_docstrings.py from the comments of the headers.", "#pragma once", "",
             "namespace pickbed::eval {", "", "struct Docstring {", "  const char* name;", "  const char* text;",
             "};", "inline constexpr Docstring kDocstrings[] = {"]
    lines += [f'    {{"{name}", R"doc({text})doc"}},' for name, text in sorted(reader.docs.items())]
    lines += ["};", "", "}  // namespace pickbed::eval", ""]
    Path(sys.argv[1]).write_text("\n".join(lines), encoding="utf-8")


if __name__ == "__main__":
    main()
