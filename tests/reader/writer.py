"""Writes vademecum files again with other stored bytes, from `formats/vademecum-1.md` alone.

`writer.py codecs FILE OUT` writes the file with every codec of the text: each section in the next one that
its element may have. `damaged` is for the negative control of `controls.py`.
"""

import struct
import sys
import zlib

import numpy as np
import zstandard

import vademecum

BLOCK = 64  # bytes of a block: a multiple of 8, small so that small sections have several


def encode(file, stored, codecs):
    """The bytes of the file with other stored bytes and codecs, by name of the section."""
    start, length = file.metadata_at
    metadata = file.data[start : start + length]
    at, entries, body = start + length, b"", b""
    for name, entry in file.entries.items():
        padding = -at % 64
        section = stored.get(name) or file.stored(name)
        body += b"\0" * padding + section
        flags = struct.unpack_from("<H", file.data, 64 * (1 + len(entries) // 64) + 6)[0]
        codec = codecs.get(name, entry["codec"])
        lengths = len(section), entry["decoded_length"]
        entries += struct.pack("<IBBH", entry["kind"], entry["element"], codec, flags)
        entries += struct.pack("<QQQQQQ", *entry["shape"], at + padding, *lengths)
        entries += struct.pack("<II", zlib.crc32(section), 0)
        at += padding + len(section)
    minor = max(file.minor, 1 if any(codec >= 2 for codec in codecs.values()) else 0)
    header = vademecum.MAGIC + struct.pack("<HHIQQQ", 1, minor, len(file.entries), at, start, length)
    header += struct.pack("<II", zlib.crc32(metadata), zlib.crc32(entries)) + b"\0" * 12
    return header + struct.pack("<I", zlib.crc32(header)) + entries + metadata + body


def shuffle(data, size):
    return np.frombuffer(data, np.uint8).reshape(-1, size).T.tobytes()


def delta(data, width):
    numbers = np.frombuffer(data, "<u2").astype(np.int64)
    before = np.concatenate([np.zeros(width, np.int64), numbers])[: len(numbers)]
    signed = (numbers - before + 0x8000) % 0x10000 - 0x8000
    coded = np.where(signed < 0, -2 * signed - 1, 2 * signed)
    return shuffle(coded.astype("<u2").tobytes(), 2)


def pack(decoded, entry, codec):
    zstd = zstandard.ZstdCompressor()
    if codec == 0:
        return decoded
    if codec == 1:
        return zstd.compress(decoded)
    size = np.dtype(vademecum.ELEMENTS[entry["element"]]).itemsize
    width = entry["shape"][1] * entry["shape"][2]
    frames, ends = b"", b""
    for first in range(0, len(decoded), BLOCK):
        piece = decoded[first : first + BLOCK]
        frames += zstd.compress(shuffle(piece, size) if codec == 2 else delta(piece, width))
        ends += struct.pack("<Q", len(frames))
    return struct.pack("<Q", BLOCK) + ends + frames


def with_every_codec(file):
    stored, codecs = {}, {}
    for turn, (name, entry) in enumerate(file.entries.items()):
        # Tables that a reader takes as they lie stay raw (CanonicalParts, Axes, Positions, Direction).
        raw = name in ("CanonicalParts", "CanonicalAxes", "CanonicalPositions", "CanonicalDirection")
        possible = [0] if raw else [1, 2, 3] if entry["element"] == 5 else [1, 2]
        codecs[name] = possible[turn % len(possible)]
        stored[name] = pack(file.unpacked(name), entry, codecs[name])
    return encode(file, stored, codecs)


def damaged(file, name):
    """A section with one byte changed: the sixth of its largest number; of a space section, at a node that
    every march loads or reads, the first (of the interior the last)."""
    raw, (n, a, b) = bytearray(file.stored(name)), file.entries[name]["shape"]
    numbers = np.abs(np.frombuffer(bytes(raw), "<f8"))
    first, count = {"SurfaceBasis": (0, a * b), "BlockLoad": (0, a * b),
                    "InteriorBasis": ((n - 1) * a * b, a * b)}.get(name, (0, len(numbers)))
    raw[8 * (first + int(np.argmax(numbers[first : first + count]))) + 5] ^= 0x40
    return bytes(raw)


if __name__ == "__main__":
    _, source, target = sys.argv[1:]
    with open(target, "wb") as out:
        out.write(with_every_codec(vademecum.read(source)))
