#!/usr/bin/env python3
"""Runs the commands of README.md and docs/pages, so that they stay right.

    run_commands.py PICKBED ROOT [PAGE...]

Each fenced block of language sh runs with bash in a temporary folder, with pickbed on PATH. The
blocks of a page run in order in one folder. A comment directly before a block changes this:

    <!-- run: COMMANDS -->       runs these commands instead, for example a reduced form
    <!-- run: none (REASON) -->  runs nothing
    <!-- file: NAME -->          writes the block, in any language, to this file

A comment <!-- setup: COMMANDS --> runs at its place and needs no block. The first failed command
of a page is printed as PAGE:LINE with the end of its output; the exit status is then 1.
"""

import os
import re
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

sys.dont_write_bytecode = True  # no cache files in the source tree
from page_text import Block, elements, pages_of, shown

TIMEOUT_S = 300


class Fault(Exception):
    def __init__(self, line, text):
        super().__init__(text)
        self.line = line


def steps_of(text):
    """Yields (line, commands or None, file name or None, file text) in the order of the page."""
    for element in elements(text):
        comments = element.comments if isinstance(element, Block) else [element]
        commands = element.text if isinstance(element, Block) and element.language == "sh" else None
        line = element.line
        for comment in comments:
            kind, _, rest = comment.text.partition(":")
            rest = rest.strip()
            if kind == "setup":
                yield comment.line, rest, None, None
            elif kind == "file":
                yield comment.line, None, rest, element.text
                commands = None
            elif kind == "run":
                if rest.startswith("none"):
                    if not re.fullmatch(r"none \(.+\)", rest, re.S):
                        raise Fault(comment.line, "write the reason: run: none (REASON)")
                    commands = None
                else:
                    commands = rest
                line = comment.line
        if commands is not None:
            yield line, commands, None, None


def run(commands, folder, environment):
    """Returns the exit status and the output."""
    try:
        done = subprocess.run(["bash", "-euo", "pipefail", "-c", commands], cwd=folder, env=environment,
                              stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, timeout=TIMEOUT_S, check=False)
    except subprocess.TimeoutExpired as expired:
        return 124, (expired.stdout or b"") + b"time limit reached\n"
    return done.returncode, done.stdout


def cpu_s():
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def run_page(page, environment):
    """Returns the number of commands that ran. Throws Fault for the first failed one."""
    count = 0
    with tempfile.TemporaryDirectory(prefix="pickbed_docs_") as folder:
        for line, commands, name, text in steps_of(page.read_text()):
            if name is not None:
                file = Path(folder, name)
                file.parent.mkdir(parents=True, exist_ok=True)
                file.write_text(text)
                continue
            status, output = run(commands, folder, environment)
            count += 1
            if status != 0:
                tail = output.decode(errors="replace").rstrip().split("\n")[-15:]
                raise Fault(line, "\n  ".join([f"exit status {status}: {commands.strip()}"] + tail))
    return count


def main():
    pickbed, root = Path(sys.argv[1]).resolve(), Path(sys.argv[2]).resolve()
    pages = [Path(page).resolve() for page in sys.argv[3:]] or pages_of(root)
    failed = False
    with tempfile.TemporaryDirectory(prefix="pickbed_bin_") as programs:
        # Only this program, not the others of its folder.
        os.symlink(pickbed, Path(programs, "pickbed"))
        # Debian's Python has the packages of packages.txt. Another one may be first in PATH.
        os.symlink("/usr/bin/python3", Path(programs, "python3"))
        environment = dict(os.environ, PATH=f"{programs}:{os.environ['PATH']}")
        if shutil.which("pickbed", path=environment["PATH"]) is None:
            print(f"{pickbed} is not a program")
            return 1
        for page in pages:
            before_s = cpu_s()
            try:
                count = run_page(page, environment)
            except Fault as fault:
                print(f"{shown(page, root)}:{fault.line}: {fault}")
                failed = True
                continue
            if count:
                print(f"{shown(page, root)}: {count} commands, {cpu_s() - before_s:.1f} s of CPU time")
    print(f"{cpu_s():.1f} s of CPU time in all")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
