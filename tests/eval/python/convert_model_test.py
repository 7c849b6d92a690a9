"""Converts an archive of an earlier version, made here from the included model, and compares."""

import pathlib
import pickle
import struct
import subprocess
import sys
import tempfile
import zipfile

SOURCES = pathlib.Path(__file__).resolve().parents[3]
CONVERTER = SOURCES / "eval" / "python" / "convert_model.py"


def fnv1a(data):
    value = 14695981039346656037
    for byte in data:
        value = (value ^ byte) * 1099511628211 & 0xFFFFFFFFFFFFFFFF
    return value


def parse(content):
    """Returns header and entries of a model file."""
    assert content[:8] == b"PICKTENS"
    version, check_sum = struct.unpack_from("<QQ", content, 8)
    assert version == 1
    assert check_sum == fnv1a(content[24:]), "the check sum is wrong"
    blocks, at = [], 24
    while at < len(content):
        (size,) = struct.unpack_from("<Q", content, at)
        blocks.append(content[at + 8 : at + 8 + size])
        at += 8 + size
    header = blocks[0].decode()
    names = [line.split('"')[1] for line in header.splitlines() if "name:" in line]
    return header, dict(zip(names, blocks[1:]))


def write_archive(path, entries):
    """Writes what PyTorch wrote: a pickle with the texts, and the values beside it."""
    values = {
        "magic": "pickbed descriptor model",
        "version": 8,
        "info": entries["info"].decode(),
        "training": entries["training"].decode(),
        "weights": ("storage", "0", len(entries["weights"]) // 4),
        "verifier": ("storage", "1", len(entries["verifier"]) // 4),
        "hash": -5,
    }
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("archive/data.pkl", pickle.dumps(values, protocol=2))
        archive.writestr("archive/data/0", entries["weights"])
        archive.writestr("archive/data/1", entries["verifier"])


class Attack:
    """Its pickle runs a command when it is loaded."""

    def __reduce__(self):
        return (pathlib.Path.touch, (pathlib.Path("touched"),))


def main():
    _, entries = parse((SOURCES / "assets" / "models" / "shipped.net").read_bytes())
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_archive(folder / "old.pt", entries)
        subprocess.run([sys.executable, CONVERTER, folder / "old.pt", folder / "new.net"], check=True)
        header, converted = parse((folder / "new.net").read_bytes())
        assert 'kind: "descriptor model"' in header and "version: 8" in header, header[:200]
        assert converted == entries, "a text or a tensor has changed"

        with zipfile.ZipFile(folder / "bad.pt", "w") as archive:
            archive.writestr("archive/data.pkl", pickle.dumps(Attack(), protocol=2))
        refused = subprocess.run(
            [sys.executable, CONVERTER, folder / "bad.pt", folder / "bad.net"],
            cwd=folder, capture_output=True, text=True, check=False)
        assert refused.returncode == 1 and "not a model file" in refused.stderr, refused.stderr
        assert not (folder / "touched").exists(), "the converter ran code of the file"
        assert not (folder / "bad.net").exists()


main()
