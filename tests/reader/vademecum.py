"""A reader of vademecum files, made from `formats/vademecum-1.md` alone.

Headings of that text stand beside the code that needs them. Where the text and the evaluator disagree, one of
the two is wrong; `tests/reader/check` finds out. Arithmetic is binary64 throughout.
"""

import struct
import zlib

import numpy as np
import zstandard

MAGIC = bytes([0x89, 0x56, 0x44, 0x4D, 0x0D, 0x0A, 0x1A, 0x0A])
ELEMENTS = {0: "<u1", 1: "<u4", 2: "<u8", 3: "<f4", 4: "<f8", 5: "<i2"}
REQUIRED = 1
GROUP = 128  # numbers that share a scale

NAMES = """NodeIds NodeCoordinates Triangles ReducedStiffness Eigenvalues SurfaceBasis InteriorBasis
BlockState BlockLoad PatternBasis PatternBlock PatternNames ProbeNames ProbeRows SingularValues ModeTable
AxisPoints Factors RegionStiffness RegionMass EnrichmentHistory RadiusSamples CanonicalParts CanonicalAxes CanonicalFactors
CanonicalTerms CanonicalPositions CanonicalDirection CanonicalCertificate Losses Repairs StructureFigures
DampingRatios ContactResidual ResidualPairs PairResidual ProbeResidual PatternResidual PatternProbeResidual
StaticBound BoundMap FactorOrder FactorGroups FactorRows FactorValues PatternAnswer
StressPoints StressBasis StressResidual PatternStress ElasticConstants ProbeUnits
SupportNames SupportPoints ReactionBasis ReactionLoads PatternReaction BaseFrame RigidBody
StrainSizes StrainLinear StrainTail StrainQuadratic StrainBox StrainLimits StrainModes
MeshError""".split()
MODELS = "Compliance EmbeddedNodes EmbeddedWeights EmbeddedTriangles DampingRows Quadrangles".split()
PORTS = """PortNames PortTable PortFrames PortNodes PortFacets PortRows PortCompliance PortInertia PortResidual
PortProbes PortPatterns ProbeMotions ContactModes PatchPairs PatchResidual ContactPatch""".split()
LIVE = "LiveParameters LiveNames LiveStiffness LiveMass LiveRegions LiveResidual LiveCertificate".split()
LIVE += "LiveReactionStiffness LiveReactionMass LiveLoss LiveDampers LiveWitnesses".split()
KINDS = dict(enumerate(NAMES, start=1)) | dict(enumerate(MODELS, start=75)) | dict(enumerate(PORTS, start=95))
KINDS |= dict(enumerate(LIVE, start=111))


class Refused(Exception):
    """The file is refused, by the name of the table of refusals."""


def need(condition, refusal):
    if not condition:
        raise Refused(refusal)


class Cursor:
    """Fields of the metadata, one directly after the other."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, form):
        size = struct.calcsize("<" + form)
        need(self.at + size <= len(self.data), "MetadataEncoding")
        values = struct.unpack_from("<" + form, self.data, self.at)
        self.at += size
        return values[0] if len(values) == 1 else np.array(values)

    def text(self):
        length = self.take("Q")
        need(self.at + length <= len(self.data), "MetadataEncoding")
        self.at += length
        try:
            return self.data[self.at - length : self.at].decode("utf-8")
        except UnicodeDecodeError as error:
            raise Refused("MetadataEncoding") from error

    def flag(self):
        value = self.take("B")
        need(value in (0, 1), "MetadataEncoding")
        return value == 1


# --- Metadata


def read_stage(cursor):
    mass, damping, stiffness, instant = cursor.take("4d")
    loads = cursor.take("4d")
    histories = [cursor.take("6d") for _ in range(3)]
    return {"m": mass, "d": damping, "k": stiffness, "c": instant, "f": loads, "h": histories}


def read_scheme(cursor):
    count = cursor.take("B")
    need(count <= 3, "Scheme")
    start = cursor.at
    stages = [read_stage(cursor) for _ in range(3)]
    finish = cursor.take("18d").reshape(3, 6)
    # No stages: exact steps, and all numbers are zero.
    need(count > 0 or not any(cursor.data[start : cursor.at]), "Scheme")
    return {"stages": stages[:count], "finish": finish}


def read_parameter(cursor):
    parameter = {"name": cursor.text(), "unit": cursor.text(), "role": cursor.take("I")}
    need(parameter["role"] <= 6, "MetadataEncoding")
    parameter["region"] = cursor.take("I") if parameter["role"] in (1, 3) else None
    parameter["log"] = cursor.flag()
    parameter["lower"], parameter["upper"], parameter["nominal"] = cursor.take("3d")
    return parameter


def read_axis(cursor):
    axis = {"name": cursor.text(), "unit": cursor.text(), "role": cursor.take("I")}
    need(axis["role"] <= 1, "MetadataEncoding")
    axis["exponents"] = cursor.take("17d") if axis["role"] == 1 else None
    axis["kind"] = cursor.take("I")
    need(axis["kind"] <= 2, "MetadataEncoding")
    axis["log"] = cursor.flag()
    axis["lower"], axis["upper"] = cursor.take("2d")
    axis["n_points"] = cursor.take("I")
    return axis


CERTIFICATE = ["trajectory_error", "floor", "spectral_radius", "energy_ratio", "map_rms", "map_max", "steps"]


def read_metadata(data):
    cursor = Cursor(data)
    meta = {name: cursor.text() for name in ("program", "problem", "units")}
    meta["mesh_hash"] = bytes(cursor.take("16B").astype(np.uint8))
    for name in ("n_nodes", "n_surface_nodes", "n_load_nodes", "n_triangles", "n_load_triangles", "n_modes",
                 "n_patterns", "n_probes"):
        meta[name] = cursor.take("I")
    meta["scheme_name"] = cursor.text()
    meta["scheme"] = read_scheme(cursor)
    meta["time_step"] = cursor.take("d")
    meta["alpha"], meta["beta"] = cursor.take("2d")
    meta["n_regions"], n_parameters = cursor.take("I"), cursor.take("I")
    need(n_parameters <= 16, "Count")
    meta["parameters"] = [read_parameter(cursor) for _ in range(16)][:n_parameters]
    axes = [read_axis(cursor) for _ in range(12)]
    n_axes, meta["n_terms"] = cursor.take("I"), cursor.take("I")
    need(n_axes <= 12, "Count")
    meta["axes"] = axes[:n_axes]
    meta["diagonal"], meta["block"] = cursor.flag(), cursor.flag()
    for name in ("diagonal_certificate", "block_certificate"):
        meta[name] = dict(zip(CERTIFICATE, cursor.take("7d")))
    need(cursor.at == len(data), "MetadataEncoding")
    return meta


# --- Codecs


def unpack_frame(frame, length):
    """One zstd frame of exactly `length` bytes, with nothing after it."""
    reader = zstandard.ZstdDecompressor(max_window_size=1 << 27).decompressobj()
    try:
        decoded = reader.decompress(frame)
    except zstandard.ZstdError as error:
        raise Refused("Frame") from error
    need(reader.eof and not reader.unused_data and len(decoded) == length, "Frame")
    return decoded


def unshuffle(data, size):
    """Byte `j` of number `i` of `m` numbers was put at `j m + i`."""
    return np.frombuffer(data, np.uint8).reshape(size, -1).T.tobytes()


def undo_delta(data, width):
    coded = np.frombuffer(unshuffle(data, 2), "<u2").astype(np.int64)
    numbers = np.where(coded & 1, -(coded + 1) // 2, coded // 2)
    for first in range(min(width, len(numbers))):
        numbers[first::width] = np.cumsum(numbers[first::width])
    return (numbers & 0xFFFF).astype("<u2").tobytes()


def unpack_blocks(stored, entry):
    need(len(stored) >= 8, "BlockTable")
    length = struct.unpack_from("<Q", stored)[0]
    need(length % 8 == 0 and 8 <= length <= 1 << 20, "BlockTable")
    decoded_length = entry["decoded_length"]
    count = -(-decoded_length // length)
    table = 8 + 8 * count
    need(len(stored) >= table, "BlockTable")
    ends = [0, *struct.unpack_from(f"<{count}Q", stored, 8)]
    need(ends[-1] == len(stored) - table and ends == sorted(ends), "BlockTable")
    size = np.dtype(ELEMENTS[entry["element"]]).itemsize
    width = int(entry["shape"][1] * entry["shape"][2])
    pieces = []
    for index in range(count):
        wanted = min(length, decoded_length - index * length)
        piece = unpack_frame(stored[table + ends[index] : table + ends[index + 1]], wanted)
        pieces.append(unshuffle(piece, size) if entry["codec"] == 2 else undo_delta(piece, width))
    return b"".join(pieces)


def numbers_of(data, entry):
    shape = entry["shape"]
    if entry["element"] != 5:
        numbers = np.frombuffer(data, ELEMENTS[entry["element"]]).reshape(shape)
        return numbers.astype(np.float64) if entry["element"] in (3, 4) else numbers
    n, width = shape[0], shape[1] * shape[2]
    groups = -(-n // GROUP)
    scales = np.frombuffer(data, "<f4", groups * width).reshape(groups, width).astype(np.float64)
    integers = np.frombuffer(data, "<i2", n * width, 4 * groups * width).reshape(n, width)
    return (scales[np.arange(n) // GROUP] * integers).reshape(shape)


# --- The file


class File:
    """Header, directory and metadata of a file, and its sections by name.

    Every checksum and all padding are read on opening, and sections are decoded when they are asked for.
    """

    def __init__(self, data):
        self.data, self.decoded = data, {}
        self.read_header()
        self.read_directory()
        start, length = self.metadata_at
        need(zlib.crc32(data[start : start + length]) == self.metadata_crc, "MetadataChecksum")
        self.meta = read_metadata(data[start : start + length])
        if not self.meta["scheme"]["stages"]:
            canonical = "CanonicalParts" in self.entries
            stepped = self.meta["diagonal"] or "StrainSizes" in self.entries
            need(stepped and not self.meta["block"] and not canonical, "Scheme")
            need(self.minor >= 3, "Scheme")
        need("StrainSizes" not in self.entries or not self.meta["scheme"]["stages"], "Scheme")
        self.check_places(start + length)

    def read_header(self):
        data = self.data
        need(len(data) >= 64, "TooShort")
        need(data[:8] == MAGIC, "Magic")
        major, self.minor, self.count, length, offset, size = struct.unpack_from("<HHIQQQ", data, 8)
        self.metadata_crc, self.directory_crc = struct.unpack_from("<II", data, 40)
        need(major == 1, "MajorVersion")
        need(zlib.crc32(data[:60]) == struct.unpack_from("<I", data, 60)[0], "HeaderChecksum")
        need(not any(data[48:60]), "NotZero")
        need(length == len(data), "FileLength")
        need(self.count <= 256, "SectionCount")
        need(offset == 64 * (1 + self.count), "MetadataOffset")
        need(size <= 1 << 20 and offset + size <= len(data), "MetadataLength")
        self.metadata_at = (offset, size)

    def read_directory(self):
        directory = self.data[64 : 64 * (1 + self.count)]
        need(zlib.crc32(directory) == self.directory_crc, "DirectoryChecksum")
        self.entries, self.every_entry = {}, []
        for index in range(self.count):
            fields = struct.unpack_from("<IBBHQQQQQQII", directory, 64 * index)
            kind, element, codec, flags, a, b, c, offset, stored, decoded, crc, zero = fields
            need(zero == 0, "NotZero")
            entry = {"kind": kind, "element": element, "codec": codec, "shape": (a, b, c), "offset": offset,
                     "stored_length": stored, "decoded_length": decoded, "crc": crc}
            self.every_entry.append(entry)
            if kind not in KINDS:
                need(not flags & REQUIRED, "UnknownKind")
                continue
            need(element in ELEMENTS, "Element")
            need(codec <= 3 and (codec != 3 or element == 5), "Codec")
            need(flags in (0, REQUIRED), "Flags")
            need(KINDS[kind] not in self.entries, "Duplicate")
            size = np.dtype(ELEMENTS[element]).itemsize
            scales = 4 * -(-a // GROUP) * b * c if element == 5 else 0
            need(decoded == size * a * b * c + scales, "Length")
            need(codec != 0 or stored == decoded, "Length")
            self.entries[KINDS[kind]] = entry

    def check_places(self, end):
        for entry in self.every_entry:
            start = -(-end // 64) * 64
            need(entry["offset"] == start, "Offset")
            need(not any(self.data[end:start]), "NotZero")
            end = start + entry["stored_length"]
            need(end <= len(self.data), "Length")
            if entry["kind"] in KINDS:
                need(zlib.crc32(self.data[start:end]) == entry["crc"], "SectionChecksum")
        need(end == len(self.data), "FileLength")

    def __contains__(self, name):
        return name in self.entries

    def section(self, name):
        """The numbers of a section in its shape of three; reals and quantised numbers as binary64."""
        if name not in self.decoded:
            self.decoded[name] = self.decode(name)
        return self.decoded[name]

    def stored(self, name):
        entry = self.entries[name]
        return self.data[entry["offset"] : entry["offset"] + entry["stored_length"]]

    def unpacked(self, name):
        """The decoded bytes of a section."""
        need(name in self.entries, "Missing")
        entry, stored = self.entries[name], self.stored(name)
        if entry["codec"] == 0:
            return stored
        if entry["codec"] == 1:
            return unpack_frame(stored, entry["decoded_length"])
        return unpack_blocks(stored, entry)

    def decode(self, name):
        decoded = self.unpacked(name)
        return numbers_of(decoded, self.entries[name])

    def lines(self, name):
        """The lines of a section of text; none where the section is missing."""
        if name not in self:
            return []
        return self.section(name).tobytes().decode("utf-8").splitlines()


def read(path):
    with open(path, "rb") as file:
        return File(file.read())
