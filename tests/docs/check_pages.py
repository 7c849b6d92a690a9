#!/usr/bin/env python3
"""Checks the documentation pages of docs/pages and the links of README.md.

    check_pages.py ROOT

Prints one line PAGE:LINE: FAULT for each fault and exits with 1 if there is one:
- a link, an anchor or a quoted file that does not exist, or a link from a page to a file outside docs/pages
- a page that is not in the navigation of docs/mkdocs.yml, or that no links lead to from index.md
- a page with more than 300 lines, except generated ones
- a sentence with more than 25 words, or a form that the style guide forbids, except in README.md
- a name of a test in a table, such as `Suite.Test` or `Suite.*`, that no source has
"""

import os
import re
import sys
from pathlib import Path

sys.dont_write_bytecode = True  # no cache files in the source tree
from page_text import GENERATED_MARK, anchors, links, pages_of, prose, shown

MAX_LINES = 300
MAX_WORDS = 25
FORBIDDEN = re.compile(
    r"(?:^|\. )Of [a-z]|\bthat of\b|\bthose (?:that|of)\b|\bwhich is what\b|\b[Tt]ells?\b|\b[Tt]old\b"
    r"|\b[Ss]tands?\b|\b[Ss]tood\b|\b[Ll]ies?\b|\b[Aa]lone\b|\b[Nn]obody\b|\b[Ww]hoever\b")
ABBREVIATIONS = re.compile(r"\b(et al|e\.g|i\.e|vs|Sec|sec|eq|Eq|Fig)\.")


def check_links(page, root, pages_root, texts, faults):
    """Returns the pages that this page links to."""
    targets = set()
    for line, target in links(texts[page]):
        if re.match(r"^[a-z]+:", target):
            continue
        path, _, anchor = target.partition("#")
        to = Path(os.path.normpath(page.parent / path)) if path else page
        if not to.exists():
            faults.append((page, line, f"{target} does not exist"))
            continue
        if pages_root in page.parents and pages_root not in to.parents:
            faults.append((page, line, f"{target} is outside docs/pages, so the site does not have it"))
        if to.suffix == ".md":
            targets.add(to)
        if anchor and to in texts and anchor not in anchors(texts[to]):
            faults.append((page, line, f"{target}: there is no heading #{anchor}"))
    return targets


def check_quotes(page, root, text, faults):
    """mkdocs puts the file in the place of a line --8<-- "FILE"."""
    for number, line in enumerate(text.split("\n"), 1):
        quoted = re.match(r'^\s*--8<-- "([^"]+)"$', line)
        if quoted and not (root / quoted.group(1)).is_file():
            faults.append((page, number, f"quotes {quoted.group(1)}, which does not exist"))


def check_navigation(root, pages_root, pages, linked, faults):
    config = root / "docs/mkdocs.yml"
    named = {pages_root / name for name in re.findall(r"[\s:]([\w/.-]+\.md)\s*$", config.read_text(), re.M)}
    for missing in sorted(named - set(pages)):
        faults.append((config, 1, f"{missing.relative_to(pages_root)} does not exist"))
    reached, open_pages = set(), [pages_root / "index.md"]
    while open_pages:
        page = open_pages.pop()
        if page in reached:
            continue
        reached.add(page)
        open_pages += linked.get(page, ())
    for page in pages:
        if page not in named:
            faults.append((page, 1, "is not in the navigation of docs/mkdocs.yml"))
        if page not in reached:
            faults.append((page, 1, "no links lead to it from index.md"))


def check_language(page, text, faults):
    for line, paragraph in prose(text):
        paragraph = ABBREVIATIONS.sub(lambda m: m.group(1), paragraph)
        for sentence in re.split(r"(?<=[.!?])\s+", paragraph):
            words = [word for word in sentence.split() if re.search(r"\w", word)]
            if len(words) > MAX_WORDS:
                faults.append((page, line, f"{len(words)} words: {sentence[:70]}..."))
            form = FORBIDDEN.search(sentence)
            if form:
                faults.append((page, line, f"forbidden form '{form.group().strip()}': {sentence[:70]}"))


def tests_of(root):
    """Returns the names of all unit tests, and `SUITE.*` for each of their suites."""
    found = set()
    for source in sorted((root / "tests").rglob("*_test.cpp")):
        for suite, test in re.findall(r"^TEST(?:_F|_P)?\(\s*(\w+),\s*(\w+)", source.read_text(), re.M):
            found |= {f"{suite}.{test}", f"{suite}.*"}
    return found


def check_tests(page, text, known, faults):
    for number, line in enumerate(text.split("\n"), 1):
        if not line.startswith("|"):
            continue
        for test in re.findall(r"`([A-Z]\w+\.(?:[A-Z]\w+|\*))`", line):
            if test not in known:
                faults.append((page, number, f"there is no test {test}"))


def main():
    root = Path(sys.argv[1]).resolve()
    pages_root = root / "docs/pages"
    texts = {page: page.read_text() for page in pages_of(root)}
    pages = [page for page in texts if pages_root in page.parents]
    faults, linked, tests = [], {}, tests_of(root)
    for page, text in texts.items():
        linked[page] = check_links(page, root, pages_root, texts, faults)
        check_quotes(page, root, text, faults)
        if page not in pages or GENERATED_MARK in text:
            continue
        lines = text.count("\n")
        if lines > MAX_LINES:
            faults.append((page, lines, f"{lines} lines; a page has up to {MAX_LINES}"))
        check_language(page, text, faults)
        check_tests(page, text, tests, faults)
    check_navigation(root, pages_root, pages, linked, faults)
    for page, line, fault in faults:
        print(f"{shown(page, root)}:{line}: {fault}")
    print(f"{len(pages)} pages, {len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
