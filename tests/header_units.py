#!/usr/bin/env python3
"""Groups headers into units that can be compiled together, for check_headers.sh.

    header_units.py UNITS HEADER...

Writes the units to the file UNITS, one per line. Prints an error for each header that uses a name of a standard
header, of Eigen or of libtorch, and includes no header that declares it, also not through our other headers.

In a unit, a header must not see a declaration that it needs and does not include. So a header may follow
another one only if it includes that one, or if the two have nothing in common: it contains no name that
the other declares, and it uses no member with a name that occurs in the other. A third-party header
that is not in the table must not come before a header that does not include it.
"""

import re
import sys
from pathlib import Path

# Names (regular expressions), and the headers that declare them.
DECLARED_BY = [(re.compile(name), headers.split()) for name, headers in {
    "std::vector": "vector",
    "std::string[^_a-z]": "string",
    "std::string_view": "string_view string",
    "std::(optional|nullopt)": "optional",
    "std::function[^a-z]": "functional",
    "std::map": "map",
    "std::set[^_a-z]": "set",
    "std::((unique|shared|weak)_ptr|make_(unique|shared))": "memory",
    "std::array": "array",
    "std::span": "span",
    "std::filesystem": "filesystem",
    "[^_a-z]u?int(8|16|32|64)_t": "cstdint",
    "std::chrono": "chrono",
    "std::numeric_limits": "limits",
    "std::exception_ptr": "exception",
    "std::(runtime|logic)_error": "stdexcept",
    "std::(clamp|min|max|sort)[({]": "algorithm",
    "std::(sqrt|sin|cos|acos|atan2|hypot|pow|isfinite)": "cmath",
    "std::tuple": "tuple",
    "std::unordered_map": "unordered_map",
    "std::variant": "variant",
    "std::mutex": "mutex",
    "std::thread": "thread",
    "std::atomic": "atomic",
    "std::numbers": "numbers",
    "std::initializer_list": "initializer_list",
    "Eigen::": "Eigen/Core Eigen/Geometry",
    "Eigen::(Quaternion|AngleAxis|Isometry|Affine)": "Eigen/Geometry",
    "(torch|at|c10)::": "torch/types.h ATen/core/Tensor.h",
    "torch::[a-z_]+\\(": "torch/types.h",
    "torch::(nn::Module[^a-zA-Z]|nn::.*register_module)": "torch/nn/module.h torch/nn/modules/conv.h "
                                                        "torch/nn/modules/linear.h torch/nn/modules/batchnorm.h",
    "torch::nn::Conv": "torch/nn/modules/conv.h",
    "torch::nn::Linear": "torch/nn/modules/linear.h",
    "torch::nn::BatchNorm": "torch/nn/modules/batchnorm.h",
    "torch::optim::Adam": "torch/optim/adam.h",
}.items()]
IN_TABLE = re.compile(r"[a-z_]+$|Eigen/")
TORCH = re.compile(r"torch/|ATen/")
COMMENT_OR_STRING = re.compile(r'//[^\n]*|/\*.*?\*/|"(?:\\.|[^"\\\n])*"', re.S)
NAME = r"[A-Za-z_]\w*"
NO_NAMES = set("""alignas auto bool case char class const consteval constexpr decltype default delete do double else enum
explicit false final float for friend if inline int long mutable namespace noexcept nullptr operator override private
protected public return short sizeof static static_assert std struct switch template this true typename union unsigned
using virtual void while Eigen""".split())


class Header:
    def __init__(self, path):
        text = Path(path).read_text()
        self.path = path
        self.includes = re.findall(r'^#include [<"]([^>"]+)[>"]', text, re.M)
        code = COMMENT_OR_STRING.sub(" ", text)
        self.lines = ["" if line.startswith("#include") else line for line in code.split("\n")]
        code = "\n".join(self.lines)
        self.names = set(re.findall(NAME, code)) - NO_NAMES
        self.members = set(re.findall(rf"(?:\.|->)\s*({NAME})", code)) - NO_NAMES
        self.declared = set()
        for line in self.lines:  # the formatter puts declarations of a namespace at the start of a line
            if re.match(r"[A-Za-z_]|#define", line) and not line.startswith("namespace"):
                while line != (shorter := re.sub(r"<[^<>]*>", "", line)):  # template arguments
                    line = shorter
                types = re.findall(rf"(?:enum class|struct|class|enum|union|using|concept|define)\s+({NAME})", line)
                end = r"\(" if "(" in line else r"(?:[{\[=;]|$)"
                self.declared |= set(types or re.findall(rf"({NAME})\s*{end}", line))
                if re.match(r"enum (?!class)", line):  # its values are names of the namespace
                    self.declared |= self.names
        self.declared -= NO_NAMES


def close(headers):
    """Sets all headers that each header includes, also through others: ours, and third-party ones."""
    def reach(path, inside):
        for other in headers[path].includes:
            if other not in inside:
                inside.add(other)
                if other in headers:
                    reach(other, inside)
        return inside
    for header in headers.values():
        header.inside = reach(header.path, set())
        header.ours = {path for path in header.inside if path in headers}
        foreign = {path for path in header.inside - header.ours if not IN_TABLE.match(path)}
        header.foreign = {"torch" if TORCH.match(path) else path for path in foreign}


def missing(header):
    """Yields (line number, name, header) of names without the header that declares them."""
    for name, declared_by in DECLARED_BY:
        if TORCH.match(declared_by[0]) and "torch" not in header.foreign:
            continue  # it may declare a class of libtorch itself
        if header.inside.isdisjoint(declared_by):
            for number, line in enumerate(header.lines, 1):
                if name.search(line + " "):
                    yield number, name.pattern, declared_by[0]
                    break


def units_of(headers):
    def independent(header, other):
        return header.names.isdisjoint(other.declared) and header.members.isdisjoint(other.names)

    units = []  # (headers of the unit, all of our headers that it reads, third-party headers)
    for header in sorted(headers.values(), key=lambda each: (len(each.foreign), len(each.ours), each.path)):
        for paths, read, foreign in sorted(units, key=lambda unit: -len(unit[2])):  # libtorch is read in few units
            if foreign <= header.foreign and all(
                    independent(header, headers[path]) for path in read - header.ours):
                break
        else:
            paths, read, foreign = [], set(), set()
            units.append((paths, read, foreign))
        paths.append(header.path)
        read |= header.ours | {header.path}
        foreign |= header.foreign
    return [paths for paths, _, _ in units]


def main():
    headers = {path: Header(path) for path in sys.argv[2:]}
    close(headers)
    for header in headers.values():
        for number, name, declared_by in missing(header):
            print(f"{header.path}:{number}: error: {name} without <{declared_by}>")
    Path(sys.argv[1]).write_text("".join(" ".join(paths) + "\n" for paths in units_of(headers)))


if __name__ == "__main__":
    main()
