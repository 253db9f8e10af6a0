//! Files that must be refused: one at least for each numbered refusal of `formats/vademecum-1.md` that
//! concerns readers, and those that open and fail `verify --file-only`.
//!
//! Each is a sound file of two and a half kilobytes with one thing wrong and all checksums right (but for the
//! wrong checksums themselves), so that nothing else refuses it. Its name says what must: the number and name
//! of the refusal, then what was done.

use crate::annotate::{place, smallest};
use crate::synthetic::{Body, Layout, bathe, rewritten};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{BLOCK, Codec, Element, File, SectionInput, SectionKind};

/// The number in the file at `at`.
///
/// # Panics
/// If the file ends before.
#[must_use]
pub fn u32_at(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes(bytes[at..at + 4].try_into().expect("four"))
}

/// Overwrites the bytes at `at`.
///
/// # Panics
/// If the file ends before.
pub fn put(bytes: &mut [u8], at: usize, value: &[u8]) {
    bytes[at..at + value.len()].copy_from_slice(value);
}

/// Makes the checksums of header, directory and metadata right again after an edit.
///
/// # Panics
/// If there is no header.
#[must_use]
pub fn reseal(mut bytes: Vec<u8>) -> Vec<u8> {
    let n = u32_at(&bytes, 12) as usize;
    let end = (BLOCK * (1 + n)).min(bytes.len());
    let metadata = end..(end + u32_at(&bytes, 32) as usize).min(bytes.len());
    let (directory, metadata) = (crc32fast::hash(&bytes[BLOCK..end]), crc32fast::hash(&bytes[metadata]));
    put(&mut bytes, 40, &metadata.to_le_bytes());
    put(&mut bytes, 44, &directory.to_le_bytes());
    let header = crc32fast::hash(&bytes[..60]);
    put(&mut bytes, 60, &header.to_le_bytes());
    bytes
}

/// Where the directory entry of a kind begins.
///
/// # Panics
/// If the file does not have it.
#[must_use]
pub fn entry(bytes: &[u8], kind: SectionKind) -> usize {
    let n = u32_at(bytes, 12) as usize;
    (1..=n).map(|i| BLOCK * i).find(|&at| u32_at(bytes, at) == kind.number()).expect("present")
}

/// The smallest file and one probe with its name.
fn base() -> Vec<u8> {
    let row = 1.0f64.to_le_bytes();
    let probe = |kind, element, shape, stored: &'static [u8]| SectionInput {
        kind,
        element,
        codec: Codec::Raw,
        required: true,
        shape,
        decoded_length: stored.len() as u64,
        stored,
    };
    let names = probe(SectionKind::ProbeNames, Element::U8, [3, 1, 1], b"tip");
    let rows = SectionInput {
        stored: &row,
        decoded_length: 8,
        ..probe(SectionKind::ProbeRows, Element::F64, [1, 1, 1], &[])
    };
    rewritten(&smallest(), |m| m.n_probes = 1, |_| {}, &[names, rows])
}

/// A small file with everything in it.
fn whole() -> Vec<u8> {
    let layout = Layout { rows: 2, load_rows: 2, columns: 2, n_interior: 0, r: 1 };
    let step = StepParameters { time_step: 1e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
    Body::closed(layout, 3).file(&bathe(), &step, Element::F32)
}

/// Name and bytes of every hostile file, by name.
#[must_use]
pub fn all() -> Vec<(String, Vec<u8>)> {
    let mut files = front();
    files.extend(metadata());
    files.extend(directory());
    files.extend(sections());
    files.extend(canonical());
    files.extend(contents());
    let mut named: Vec<(String, Vec<u8>)> =
        files.into_iter().map(|(name, bytes)| (format!("{name}.vdm"), bytes)).collect();
    named.sort();
    named
}

type Files = Vec<(&'static str, Vec<u8>)>;

/// The file of everything with a quadrangular facet of these numbers.
fn with_quadrangle(row: [u32; 6]) -> Vec<u8> {
    let stored: Vec<u8> = row.iter().flat_map(|x| x.to_le_bytes()).collect();
    let facet = SectionInput {
        kind: SectionKind::Quadrangles,
        element: Element::U32,
        codec: Codec::Raw,
        required: false,
        shape: [1, 6, 1],
        decoded_length: 24,
        stored: &stored,
    };
    rewritten(&whole(), |_| (), |_| (), &[facet])
}

/// The base file after an edit, checksums of header, directory and metadata right.
fn sealed(edit: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    reseal(edited(edit))
}

fn edited(edit: impl FnOnce(&mut Vec<u8>)) -> Vec<u8> {
    let mut bytes = base();
    edit(&mut bytes);
    bytes
}

/// Refusals 1 to 12: header, lengths, checksums, encoding.
fn front() -> Files {
    let length = base().len() as u64;
    let metadata = BLOCK * (1 + u32_at(&base(), 12) as usize);
    let padding = place(&base(), "padding");
    let entry_end = BLOCK + 60;
    let u64s = |at: usize, value: u64| sealed(|b| put(b, at, &value.to_le_bytes()));
    vec![
        ("01-TooShort-header", base()[..63].to_vec()),
        ("01-TooShort-empty", vec![]),
        ("01-TooShort-directory", sealed(|b| put(b, 12, &256u32.to_le_bytes()))),
        ("02-Magic", sealed(|b| b[4] = b'\n')),
        ("03-MajorVersion-2", sealed(|b| b[8] = 2)),
        ("03-MajorVersion-65535", sealed(|b| put(b, 8, &[0xFF, 0xFF]))),
        ("04-HeaderChecksum", edited(|b| b[61] ^= 1)),
        ("05-NotZero-header", sealed(|b| b[50] = 1)),
        ("05-NotZero-directory", sealed(|b| b[entry_end] = 1)),
        ("05-NotZero-padding", edited(|b| b[padding] = 1)),
        ("06-FileLength-cut", base()[..base().len() - 1].to_vec()),
        ("06-FileLength-more", edited(|b| b.push(0))),
        ("06-FileLength-bytes-after-the-last-section", {
            sealed(|b| {
                b.push(0);
                put(b, 16, &(length + 1).to_le_bytes());
            })
        }),
        ("06-FileLength-overflow", u64s(16, u64::MAX)),
        ("07-SectionCount-257", sealed(|b| put(b, 12, &257u32.to_le_bytes()))),
        ("07-SectionCount-overflow", sealed(|b| put(b, 12, &u32::MAX.to_le_bytes()))),
        ("08-MetadataOffset", u64s(24, metadata as u64 + 64)),
        ("08-MetadataOffset-overflow", u64s(24, u64::MAX)),
        ("09-MetadataLength", u64s(32, length - metadata as u64 + 1)),
        ("09-MetadataLength-overflow", u64s(32, u64::MAX)),
        ("10-DirectoryChecksum", edited(|b| b[BLOCK + 56] ^= 1)),
        ("11-MetadataChecksum", edited(|b| b[metadata + 8] ^= 1)),
        ("12-MetadataEncoding-text-overflow", u64s(metadata, u64::MAX)),
        ("12-MetadataEncoding-text-past-the-end", u64s(metadata, 1 << 19)),
        ("12-MetadataEncoding-not-utf8", sealed(|b| b[metadata + 8] = 0xFF)),
        ("12-MetadataEncoding-flag", {
            let at = place(&base(), "diagonal: present");
            sealed(|b| b[at] = 2)
        }),
        ("12-MetadataEncoding-left-over", {
            let longer = u64::from(u32_at(&base(), 32)) + 1;
            u64s(32, longer)
        }),
    ]
}

/// Refusals 12 to 17 and 31: what the metadata say.
fn metadata() -> Files {
    let set = |field: &str, skip: usize, value: &[u8]| {
        let at = place(&base(), field) + skip;
        sealed(|b| put(b, at, value))
    };
    // In the fourth place, after two empty texts: the enumeration of roles; past it the range.
    let role = |field: &str| set(field, 45 * 3 + 16, &[99]);
    let unused = |field: &str| set(field, 45 * 3 + 25, &[1]);
    let axis = |skip: usize, value: &[u8]| {
        let mut bytes = whole();
        let name = bytes.windows(5).position(|word| word == b"stage").expect("the axis");
        put(&mut bytes, name + 5 + skip, value);
        reseal(bytes)
    };
    let certificate = "certificate of the diagonal structure: not measured";
    vec![
        ("13-Count-no-node", set("n_nodes", 0, &[0])),
        ("13-Count-nodes", set("n_nodes", 0, &u32::MAX.to_le_bytes())),
        ("13-Count-no-mode", set("n_modes", 0, &[0])),
        ("13-Count-modes", set("n_modes", 0, &u32::MAX.to_le_bytes())),
        ("13-Count-triangles", set("n_triangles", 0, &u32::MAX.to_le_bytes())),
        ("13-Count-terms-without-a-block", set("n_terms", 0, &[1])),
        ("13-Count-no-region", set("n_regions", 0, &[0])),
        ("13-Count-parameters", set("n_parameters", 0, &[17])),
        ("14-Number-time-step-nan", set("time_step", 0, &f64::NAN.to_le_bytes())),
        ("14-Number-time-step-zero", set("time_step", 0, &0.0f64.to_le_bytes())),
        ("14-Number-alpha-negative", set("alpha", 0, &(-1.0f64).to_le_bytes())),
        ("14-Number-beta-infinite", set("beta", 0, &f64::INFINITY.to_le_bytes())),
        ("14-Number-certificate-infinite", set(certificate, 16, &f64::INFINITY.to_le_bytes())),
        ("15-Scheme-stages", set("scheme: number of stages", 0, &[4])),
        ("15-Scheme-no-stage", set("scheme: number of stages", 0, &[0])),
        ("15-Scheme-nan", set("stage 0: m, d, k, c", 0, &f64::NAN.to_le_bytes())),
        ("15-Scheme-inconsistent", set("stage 0: m, d, k, c", 0, &5.0f64.to_le_bytes())),
        ("12-MetadataEncoding-axis-role", role("12 axes, none used")),
        ("12-MetadataEncoding-parameter-role", role("16 parameters, none used")),
        ("16-Axis-range-nan", axis(17, &f64::NAN.to_le_bytes())),
        ("16-Axis-range-infinite", axis(25, &f64::INFINITY.to_le_bytes())),
        ("16-Axis-log-of-zero", axis(16, &[1])),
        ("16-Axis-points", axis(33, &u32::MAX.to_le_bytes())),
        ("16-Axis-data-in-an-unused-place", unused("12 axes, none used")),
        ("17-NoStructure", set("diagonal: present", 0, &[0])),
        ("31-Parameter-data-in-an-unused-place", unused("16 parameters, none used")),
        ("31-Parameter-none-where-one-is-counted", set("n_parameters", 0, &[1])),
    ]
}

/// Refusals 18 to 26: what the directory says.
fn directory() -> Files {
    use SectionKind as S;
    let [eigenvalues, surface, names] =
        [S::Eigenvalues, S::SurfaceBasis, S::ProbeNames].map(|kind| entry(&base(), kind));
    let set = |at: usize, value: &[u8]| sealed(|b| put(b, at, value));
    let first = base()[eigenvalues + 32..eigenvalues + 40].to_vec();
    let huge = u64::MAX.to_le_bytes();
    vec![
        ("18-UnknownKind", set(names, &900u32.to_le_bytes())),
        ("19-Element-of-another-kind", set(eigenvalues + 4, &[Element::F32 as u8])),
        ("19-Element-unknown", set(eigenvalues + 4, &[77])),
        ("20-Codec", set(eigenvalues + 5, &[255])),
        ("21-Flags", set(eigenvalues + 6, &[3, 0])),
        ("22-Duplicate", {
            // Probe rows with the kind of the probe names, and their element and shape.
            let rows = entry(&base(), S::ProbeRows);
            let entry = base()[names..names + 32].to_vec();
            sealed(|b| {
                put(b, rows, &entry);
                put(b, rows + 8, &8u64.to_le_bytes());
            })
        }),
        ("23-Offset-overlap", set(surface + 32, &first)),
        ("23-Offset-gap", {
            let next = u64::from(u32_at(&base(), surface + 32)) + 64;
            set(surface + 32, &next.to_le_bytes())
        }),
        ("23-Offset-overflow", set(surface + 32, &huge)),
        ("23-Offset-overflow-aligned", set(surface + 32, &(u64::MAX - 63).to_le_bytes())),
        ("24-Length-overflow", set(surface + 40, &huge)),
        ("24-Length-past-the-end", set(entry(&base(), S::ProbeRows) + 40, &[9])),
        ("24-Length-decoded", set(eigenvalues + 48, &[9])),
        ("24-Length-shape-overflow", set(names + 8, &huge)),
        ("25-Shape", set(surface + 16, &[4])),
        ("25-Shape-overflow", set(surface + 24, &huge)),
        ("25-Shape-quadrangle", {
            let mut bytes = with_quadrangle([0, 2, 0, 1, 3, 2]);
            let width = entry(&bytes, S::Quadrangles) + 16;
            put(&mut bytes, width, &[7]);
            reseal(bytes)
        }),
        ("26-Missing", {
            sealed(|b| {
                put(b, eigenvalues + 6, &[0, 0]);
                put(b, eigenvalues, &900u32.to_le_bytes());
            })
        }),
    ]
}

/// Refusals 27 to 29 and 36 to 38, which are found when a section is asked for.
fn sections() -> Files {
    use SectionKind as S;
    let start = |kind| u32_at(&base(), entry(&base(), kind) + 32) as usize;
    let damaged = start(S::SurfaceBasis) + 3;
    let replaced = |kind, codec, stored: &[u8]| {
        let swap = |section: &mut SectionInput<'_>| section.kind == kind;
        replace(&base(), swap, codec, stored)
    };
    let by_block = |table: &[u64], frames: &[u8]| {
        let table = table.iter().flat_map(|x| x.to_le_bytes());
        replaced(S::Eigenvalues, Codec::Shuffled, &table.chain(frames.iter().copied()).collect::<Vec<_>>())
    };
    let mut triangles =
        File::parse(&whole()).expect("a file").section(S::Triangles).expect("there").stored().to_vec();
    put(&mut triangles, 0, &u32::MAX.to_le_bytes());
    let triangles = replace(&whole(), |section| section.kind == S::Triangles, Codec::Raw, &triangles);
    vec![
        ("27-SectionChecksum", edited(|b| b[damaged] ^= 0x80)),
        ("28-Compressed", replaced(S::Eigenvalues, Codec::Zstd, &frame(0, 8))),
        ("29-Text", replaced(S::ProbeNames, Codec::Raw, &[b't', 0xFF, b'p'])),
        ("36-BlockTable-cut", by_block(&[8], &[])),
        ("36-BlockTable-no-length", by_block(&[0, 11], &frame(0, 8))),
        ("36-BlockTable-length-overflow", by_block(&[u64::MAX - 7, 11], &frame(0, 8))),
        ("36-BlockTable-end-past-the-section", by_block(&[8, u64::MAX], &frame(0, 8))),
        ("36-BlockTable-bytes-after-the-last", by_block(&[8, 9], &frame(0, 8))),
        ("37-Frame-none", by_block(&[8, 10], &[0; 10])),
        ("37-Frame-short", by_block(&[8, 10], &frame(0, 7))),
        ("37-Frame-bomb", by_block(&[8, bomb().len() as u64], &bomb())),
        ("38-Index-triangle", triangles),
        ("38-Index-quadrangle-node", with_quadrangle([0, 2, 0, 1, u32::MAX, 2])),
        ("38-Index-quadrangle-triangles", with_quadrangle([1, u32::MAX, 0, 1, 3, 2])),
    ]
}

/// Refusals 32 to 35: tables of the canonical structure, checksums right.
fn canonical() -> Files {
    use SectionKind as S;
    let layout = Layout { rows: 2, load_rows: 2, columns: 2, n_interior: 0, r: 1 };
    let step = StepParameters { time_step: 1e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
    let body = Body::closed(layout, 3);
    let sound = crate::canonical::file(&body, &bathe(), &step, &[0], crate::canonical::Terms::Apart);
    let set = |kind, at: usize, value: &[u8]| {
        let mut bytes = sound.clone();
        let entry = entry(&bytes, kind);
        let start = u32_at(&bytes, entry + 32) as usize;
        let length = u32_at(&bytes, entry + 40) as usize;
        put(&mut bytes, start + at, value);
        let checksum = crc32fast::hash(&bytes[start..start + length]);
        put(&mut bytes, entry + 56, &checksum.to_le_bytes());
        reseal(bytes)
    };
    let real = |kind, place: usize, value: f64| set(kind, 8 * place, &value.to_le_bytes());
    let whole = |kind, place: usize, value: u32| set(kind, 4 * place, &value.to_le_bytes());
    vec![
        ("32-CanonicalPart-stage", whole(S::CanonicalParts, 0, 7)),
        ("32-CanonicalPart-terms-overflow", whole(S::CanonicalParts, 2, u32::MAX)),
        ("33-CanonicalAxis-range-nan", real(S::CanonicalAxes, 2, f64::NAN)),
        ("33-CanonicalAxis-points-overflow", real(S::CanonicalAxes, 4, 1e300)),
        ("34-CanonicalLength-points", real(S::CanonicalAxes, 4, 1000.0)),
        ("34-CanonicalLength-terms", whole(S::CanonicalParts, 2, 60_000)),
        ("35-CanonicalLoad-position", whole(S::CanonicalPositions, 0, u32::MAX)),
        ("35-CanonicalLoad-direction-nan", real(S::CanonicalDirection, 2, f64::NAN)),
    ]
}

/// Files that open and whose contents are wrong: `verify --file-only` refuses them, and a scene either does
/// not bind or its step is refused. Named for the builder's error.
fn contents() -> Files {
    use SectionKind as S;
    let is = |kind: SectionKind| move |section: &mut SectionInput<'_>| section.kind == kind;
    let numbers = |xs: &[f64]| xs.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let small = |kind, stored: &[u8]| replace(&base(), is(kind), Codec::Raw, stored);
    let large = |kind, stored: &[u8]| replace(&whole(), is(kind), Codec::Raw, stored);
    let packed = |stored: &[u8]| replace(&base(), is(S::Eigenvalues), Codec::Zstd, stored);
    let ids = SectionInput {
        kind: S::NodeIds,
        element: Element::U64,
        codec: Codec::Zstd,
        required: false,
        shape: [(1 << 30) - 1, 1, 1],
        decoded_length: 8 * ((1 << 30) - 1),
        stored: &frame(0, 8),
    };
    let repairs = SectionInput {
        kind: S::Repairs,
        element: Element::U8,
        codec: Codec::Raw,
        required: false,
        shape: [1, 1, 1],
        decoded_length: 1,
        stored: &[0xFF],
    };
    vec![
        ("NotFinite-eigenvalue-nan", small(S::Eigenvalues, &numbers(&[f64::NAN]))),
        ("NotFinite-probe-infinite", small(S::ProbeRows, &numbers(&[f64::NEG_INFINITY]))),
        ("NotFinite-basis-nan", small(S::SurfaceBasis, &[0xFF; 12])),
        ("Names-empty", small(S::ProbeNames, b"\n\n\n")),
        ("Names-repairs", rewritten(&base(), |_| (), |_| {}, &[repairs])),
        ("Points-decreasing", large(S::AxisPoints, &numbers(&[1.0, 0.0]))),
        ("Points-the-same", large(S::AxisPoints, &numbers(&[0.0, 0.0]))),
        ("Frame-none", packed(&[0; 8])),
        ("Frame-short", packed(&frame(0, 7))),
        ("Frame-bomb", packed(&bomb())),
        ("Frame-bytes-after-it", packed(&[frame(0, 8), vec![0]].concat())),
        ("TooLarge", rewritten(&base(), |m| m.n_nodes = (1 << 30) - 1, |_| {}, &[ids])),
    ]
}

/// One section stored as these bytes, its declared length and shape as they are.
fn replace(
    bytes: &[u8],
    which: impl Fn(&mut SectionInput<'_>) -> bool,
    codec: Codec,
    stored: &[u8],
) -> Vec<u8> {
    let bytes = bytes.to_vec();
    let stored = stored.to_vec();
    rewritten(
        &bytes,
        |_| {},
        |section| {
            if which(section) {
                (section.codec, section.stored) = (codec, &stored);
            }
        },
        &[],
    )
}

/// A zstd frame written by hand, so that no version of the library changes it: `count` times a byte in one
/// run.
fn frame(byte: u8, count: u8) -> Vec<u8> {
    // Single segment with its length in one byte; then one block: the last, a run.
    let block = 1 | 1 << 1 | u32::from(count) << 3;
    [&[0x28, 0xB5, 0x2F, 0xFD, 0x20, count][..], &block.to_le_bytes()[..3], &[byte]].concat()
}

/// A frame of 74 bytes that holds two megabytes of zeros.
fn bomb() -> Vec<u8> {
    const RUN: u32 = 1 << 17;
    const RUNS: u32 = 16;
    let mut frame = vec![0x28, 0xB5, 0x2F, 0xFD, 0xA0];
    frame.extend((RUN * RUNS).to_le_bytes());
    for run in 1..=RUNS {
        let block = u32::from(run == RUNS) | 1 << 1 | RUN << 3;
        frame.extend(&block.to_le_bytes()[..3]);
        frame.push(0);
    }
    frame
}
