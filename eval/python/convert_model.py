"""Converts a model file of an earlier version of pickbed into the present format.

Earlier versions wrote PyTorch archives, which can run code when PyTorch reads them. This program
reads such an archive as data: it runs no code of the file and needs no PyTorch.

    python3 eval/python/convert_model.py OLD.pt NEW.net
"""

import pickletools
import struct
import sys
import zipfile

MAGIC = b"PICKTENS"
FORMAT_VERSION = 1
KINDS = {"pickbed descriptor model": "descriptor model", "pickbed verifiers": "file of verifiers"}
TEXTS = {"info", "training", "objects", "estimator", "sensor", "network"}
TENSORS = {"weights", "verifier", "verifiers"}


def fnv1a(data):
    """Returns the 64-bit FNV-1a hash of bytes, the check sum of pickbed's files."""
    value = 14695981039346656037
    for byte in data:
        value = (value ^ byte) * 1099511628211 & 0xFFFFFFFFFFFFFFFF
    return value


def read_archive(path):
    """Returns the attributes of the archived module: texts, integers, and tensors as raw bytes.

    Only constants are taken from the pickle. A tensor is the constants between its name and the
    next name: its storage's key and its number of values are among them.
    """
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        pickle = next(name for name in names if name.endswith("/data.pkl"))
        folder = pickle[: -len("data.pkl")]
        storages = {
            name[len(folder) + 5:]: archive.read(name)
            for name in names
            if name.startswith(folder + "data/")
        }
        instructions = pickletools.genops(archive.read(pickle))
        constants = [arg for op, arg, _ in instructions if is_constant(op.name)]
    values = {}
    for name, following in zip(constants, constants[1:]):
        if name in TEXTS | {"magic", "version"} and name not in values:
            values[name] = following
    order = [name for name in constants if name in TENSORS]
    for name, key in zip(order, sorted(storages, key=int)):
        values[name] = storages[key]
    return values


def is_constant(name):
    return name in ("BINUNICODE", "BININT", "BININT1", "BININT2", "LONG1")


def block(data):
    return struct.pack("<Q", len(data)) + data


def tensor_file(values):
    """Returns the bytes of the new file: head, header, and one block for each entry."""
    entries = []
    for name in sorted(values.keys() & (TEXTS | TENSORS)):
        value = values[name]
        if name in TEXTS:
            value = value.encode()
            entries.append((name, "text", len(value), value))
        else:
            entries.append((name, "float32", len(value) // 4, value))
    kind = KINDS[values["magic"]]
    header = f'kind: "{kind}"\nversion: {values["version"]}\nentries:\n'
    for name, kind, count, _ in entries:
        header += f'  - {{name: "{name}", type: "{kind}", shape: "{count}"}}\n'
    body = block(header.encode()) + b"".join(block(data) for *_, data in entries)
    return MAGIC + struct.pack("<QQ", FORMAT_VERSION, fnv1a(body)) + body


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    try:
        values = read_archive(sys.argv[1])
        content = tensor_file(values)
    except (OSError, zipfile.BadZipFile, KeyError, StopIteration, ValueError) as error:
        sys.exit(f"{sys.argv[1]}: not a model file of an earlier version of pickbed ({error!r})")
    with open(sys.argv[2], "wb") as file:
        file.write(content)


if __name__ == "__main__":
    main()
