"""Reads the Markdown of the documentation: pages, fenced blocks and comments."""

import re
from pathlib import Path

# In pages that a program writes.
GENERATED_MARK = "Do not edit. -->"


def pages_of(root):
    """Returns README.md and all pages under docs/pages, as far as they exist."""
    readme = root / "README.md"
    pages = sorted((root / "docs/pages").rglob("*.md"))
    return ([readme] if readme.exists() else []) + pages


class Block:
    """A fenced block. `line` is the number of its first fence, from 1. `comments` holds the HTML
    comments directly before it."""

    def __init__(self, line, language, text, comments):
        self.line, self.language, self.text, self.comments = line, language, text, comments


class Comment:
    def __init__(self, line, text):
        self.line, self.text = line, text


def elements(text):
    """Yields the comments and fenced blocks of a page in order. A comment belongs to the block
    after it if only empty lines are between them; it is then yielded only as part of the block."""
    pending, lines, i = [], text.split("\n"), 0
    while i < len(lines):
        line = lines[i]
        fence = re.match(r"^(\s*)(```+|~~~+)\s*(\S*)", line)
        if line.lstrip().startswith("<!--"):
            first, parts = i, [line]
            while "-->" not in parts[-1] and i + 1 < len(lines):
                i += 1
                parts.append(lines[i])
            body = "\n".join(parts).split("<!--", 1)[1].split("-->", 1)[0]
            pending.append(Comment(first + 1, body.strip()))
        elif fence:
            first, indent, mark = i, len(fence.group(1)), fence.group(2)
            body = []
            i += 1
            while i < len(lines) and lines[i].strip() != mark:
                body.append(lines[i][min(indent, len(lines[i]) - len(lines[i].lstrip())):])
                i += 1
            yield Block(first + 1, fence.group(3), "".join(x + "\n" for x in body), pending)
            pending = []
        elif line.strip():
            yield from pending
            pending = []
        i += 1
    yield from pending


def prose(text):
    """Returns (line, text) of each heading-free paragraph and list item, without code, tables and
    comments. Inline code becomes one word, and a link becomes its text."""
    text = re.sub(r"<!--.*?-->", lambda m: re.sub(r"[^\n]", "", m.group()), text, flags=re.S)
    paragraphs, current, start, fence = [], [], 0, None
    for number, line in enumerate(text.split("\n") + [""], 1):
        mark = re.match(r"^\s*(```+|~~~+)", line)
        if mark and fence is None:
            fence, line = mark.group(1), ""
        elif fence is not None:
            if line.strip() == fence:
                fence = None
            line = ""
        stripped = line.strip()
        item = re.match(r"^\s*([-*+]|\d+\.)\s+", line)
        ends = not stripped or stripped.startswith(("#", "|", "!!!", "<")) or item
        if ends and current:
            paragraphs.append((start, " ".join(current)))
            current = []
        if not stripped or stripped.startswith(("#", "|", "!!!", "<")):
            continue
        if not current:
            start = number
        current.append(re.sub(r"^\s*([-*+]|\d+\.)\s+", "", line).strip())
    cleaned = []
    for number, paragraph in paragraphs:
        paragraph = re.sub(r"`[^`]+`", "CODE", paragraph)
        paragraph = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", paragraph)
        cleaned.append((number, re.sub(r"[*_]{1,2}(\S[^*_]*)[*_]{1,2}", r"\1", paragraph)))
    return cleaned


def slug(heading):
    """Returns the anchor that Python-Markdown's toc extension gives to a heading."""
    heading = re.sub(r"`([^`]*)`", r"\1", heading)
    heading = re.sub(r"!?\[([^\]]*)\]\([^)]*\)", r"\1", heading)
    heading = re.sub(r"[^\w\s-]", "", heading).strip().lower()
    return re.sub(r"[-\s]+", "-", heading)


def anchors(text):
    """Returns the anchors of a page. Equal headings get _1, _2 and so on."""
    found, fence = set(), None
    for line in text.split("\n"):
        mark = re.match(r"^\s*(```+|~~~+)", line)
        if mark:
            fence = None if fence == mark.group(1) else fence or mark.group(1)
        heading = re.match(r"^#{1,6}\s+(.*?)\s*#*$", line)
        if fence is None and heading:
            name, n = slug(heading.group(1)), 0
            while (name if n == 0 else f"{name}_{n}") in found:
                n += 1
            found.add(name if n == 0 else f"{name}_{n}")
    return found | set(re.findall(r'\bid="([^"]+)"', text))


def links(text):
    """Yields (line, target) of every link and image outside code."""
    fence = None
    for number, line in enumerate(text.split("\n"), 1):
        mark = re.match(r"^\s*(```+|~~~+)", line)
        if mark:
            fence = None if fence == mark.group(1) else fence or mark.group(1)
        elif fence is None:
            for target in re.findall(r"\]\(([^)\s]+)[^)]*\)", re.sub(r"`[^`]*`", "", line)):
                yield number, target


def shown(page, root):
    return Path(page).relative_to(root).as_posix()
