//! The file format against hostile bytes: what every numbered refusal of `formats/vademecum-1.md` says of
//! what it found (one stored file for each is in `tests/hostile.rs`), every single flipped bit is noticed,
//! every cut is refused, nothing panics.

use proptest::prelude::*;
use vademecum_format::scheme::{SchemeTable, StepParameters, TableError};
use vademecum_format::{
    AxisRole, BLOCK, Chapter, Codec, Element, File, FormatError, MAX_REGIONS, Metadata, Parameter,
    ParameterRole, Quantity, SectionInput, SectionKind, encode_into, encoded_len,
};
use vademecum_tests::hostile::{entry, put, reseal, u32_at};
use vademecum_tests::program::repository;
use vademecum_tests::synthetic::{Body, Layout, bathe};

const LAYOUT: Layout = Layout { rows: 2, load_rows: 2, columns: 2, n_interior: 1, r: 2 };

fn small() -> Vec<u8> {
    let step = StepParameters { time_step: 1e-3, alpha: 0.1, beta: 1e-6, density: 1.0, stiffness: 1.0 };
    Body::closed(LAYOUT, 3).file(&bathe(), &step, Element::F32)
}

/// The refusal of the small file after an edit and new checksums.
fn refusal(edit: impl FnOnce(&mut Vec<u8>)) -> FormatError {
    let mut bytes = small();
    edit(&mut bytes);
    File::parse(&reseal(bytes)).map(|_| ()).expect_err("refused")
}

/// The small file's metadata and sections after an edit, through the writer.
fn rewritten(edit: impl FnOnce(&mut Metadata<'_>)) -> Result<usize, FormatError> {
    let bytes = small();
    let file = File::parse(&bytes).expect("a file");
    let sections: Vec<SectionInput<'_>> = file.sections().map(SectionInput::from).collect();
    let mut metadata = *file.metadata();
    edit(&mut metadata);
    let mut out = vec![0; encoded_len(&metadata, &sections)?];
    encode_into(&metadata, &sections, &mut out)
}

#[test]
fn refusals_1_to_12_front_of_the_file() {
    let whole = small();
    let parse = |bytes: &[u8]| File::parse(bytes).map(|_| ()).expect_err("refused");
    assert_eq!(parse(&whole[..63]), FormatError::TooShort { found: 63, needed: 64 });
    assert_eq!(refusal(|b| b[3] = b'N'), FormatError::Magic);
    assert_eq!(refusal(|b| b[8] = 2), FormatError::MajorVersion { found: 2 });
    let mut bytes = whole.clone();
    bytes[20] ^= 1;
    assert!(matches!(parse(&bytes), FormatError::HeaderChecksum { .. }));
    assert_eq!(refusal(|b| b[50] = 1), FormatError::NotZero { offset: 50 });
    let length = whole.len() as u64;
    assert_eq!(
        parse(&whole[..whole.len() - 1]),
        FormatError::FileLength { found: length - 1, expected: length }
    );
    let longer = refusal(|b| {
        b.push(0);
        put(b, 16, &(length + 1).to_le_bytes());
    });
    assert_eq!(longer, FormatError::FileLength { found: length + 1, expected: length });
    assert_eq!(
        refusal(|b| put(b, 12, &257u32.to_le_bytes())),
        FormatError::SectionCount { found: 257, limit: 256 }
    );
    assert!(matches!(refusal(|b| put(b, 12, &256u32.to_le_bytes())), FormatError::TooShort { .. }));
    assert!(matches!(refusal(|b| b[24] ^= 64), FormatError::MetadataOffset { .. }));
    assert!(matches!(refusal(|b| put(b, 32, &u64::MAX.to_le_bytes())), FormatError::MetadataLength { .. }));
    let mut bytes = whole.clone();
    bytes[BLOCK + 9] ^= 1;
    assert!(matches!(parse(&bytes), FormatError::DirectoryChecksum { .. }));
    let mut bytes = whole.clone();
    let metadata = BLOCK * (1 + u32_at(&whole, 12) as usize);
    bytes[metadata] ^= 1;
    assert!(matches!(parse(&bytes), FormatError::MetadataChecksum { .. }));
    // A string longer than the file, and metadata that end too early.
    let hostile = refusal(|b| put(b, metadata, &u64::MAX.to_le_bytes()));
    assert!(matches!(hostile, FormatError::MetadataEncoding { understood: 0, .. }), "{hostile:?}");
    let trailing = refusal(|b| {
        let longer = u32_at(b, 32) + 1;
        put(b, 32, &longer.to_le_bytes());
    });
    assert!(
        matches!(trailing, FormatError::MetadataEncoding { understood, length } if understood + 1 == length)
    );
}

#[test]
fn refusals_13_to_17_metadata() {
    let count = |what, edit: fn(&mut Metadata<'_>)| match rewritten(edit) {
        Err(FormatError::Count { what: found, .. }) => assert_eq!(found, what),
        other => panic!("{what:?}: {other:?}"),
    };
    count(Quantity::Modes, |m| m.n_modes = 0);
    count(Quantity::Nodes, |m| m.n_nodes = u32::MAX);
    count(Quantity::SurfaceNodes, |m| m.n_surface_nodes = m.n_nodes + 1);
    count(Quantity::LoadNodes, |m| m.n_load_nodes = m.n_surface_nodes + 1);
    count(Quantity::LoadTriangles, |m| m.n_load_triangles = m.n_triangles + 1);
    count(Quantity::Terms, |m| m.n_terms = 0);
    count(Quantity::Terms, |m| m.block = false);
    count(Quantity::Axes, |m| m.n_axes = 13);
    let number = |what, edit: fn(&mut Metadata<'_>)| match rewritten(edit) {
        Err(FormatError::Number { what: found, .. }) => assert_eq!(found, what),
        other => panic!("{what:?}: {other:?}"),
    };
    number(Quantity::TimeStep, |m| m.time_step = 0.0);
    number(Quantity::TimeStep, |m| m.time_step = f64::NAN);
    number(Quantity::Alpha, |m| m.alpha = -1.0);
    number(Quantity::Beta, |m| m.beta = f64::INFINITY);
    number(Quantity::Certificate, |m| m.certificate.block.map_error_max = f64::INFINITY);
    let scheme = |edit: fn(&mut Metadata<'_>)| match rewritten(edit) {
        Err(FormatError::Scheme(error)) => error,
        other => panic!("{other:?}"),
    };
    assert_eq!(scheme(|m| m.scheme.n_stages = 4), TableError::StageCount { found: 4 });
    assert_eq!(scheme(|m| m.scheme.stages[1].mass = f64::NAN), TableError::NotFinite { stage: 1 });
    assert_eq!(scheme(|m| m.scheme.stages[0].mass_history[3] = 1.0), TableError::BadStage { stage: 0 });
    assert_eq!(scheme(|m| m.scheme.stages[1].stiffness = 0.0), TableError::BadStage { stage: 1 });
    assert!(matches!(scheme(|m| m.scheme.stages[0].mass = 15.0), TableError::Inconsistent { stage: 0, .. }));
    assert!(matches!(scheme(|m| m.scheme.finish[2][0] = 18.0), TableError::Inconsistent { stage: 2, .. }));
    let axis = |place, edit: fn(&mut Metadata<'_>)| {
        assert_eq!(rewritten(edit), Err(FormatError::Axis { axis: place }))
    };
    axis(0, |m| m.axes[0].n_points = 3);
    axis(0, |m| m.axes[0].lower = 2.0);
    axis(0, |m| m.axes[0].upper = f64::NAN);
    axis(0, |m| m.axes[0].log = true);
    axis(5, |m| m.axes[5].n_points = 1);
    axis(0, |m| m.axes[0].role = monomial(f64::NAN, 0));
    axis(0, |m| m.axes[0].role = monomial(1.0, 1));
    assert!(rewritten(|m| m.axes[0].role = monomial(1.0, 0)).is_ok());
    count(Quantity::Regions, |m| m.n_regions = 0);
    count(Quantity::Regions, |m| m.n_regions = 9);
    count(Quantity::Parameters, |m| m.n_parameters = 17);
    let nothing = rewritten(|m| {
        (m.diagonal, m.block, m.n_terms, m.n_axes, m.axes[0]) = (false, false, 0, 0, m.axes[1])
    });
    assert_eq!(nothing, Err(FormatError::NoStructure));
}

/// A file of exact steps and no other structure, as metadata.
fn moved_exactly(metadata: &mut Metadata<'_>) {
    metadata.scheme = SchemeTable::EXACT;
    (metadata.block, metadata.n_terms, metadata.n_axes) = (false, 0, 0);
    metadata.axes[0] = metadata.axes[1];
}

#[test]
fn refusal_15_no_stages() {
    let none = Err(FormatError::Scheme(TableError::StageCount { found: 0 }));
    assert_eq!(rewritten(|m| m.scheme = SchemeTable::EXACT), none, "beside the block structure");
    let alone = rewritten(|m| {
        moved_exactly(m);
        m.diagonal = false;
    });
    assert_eq!(alone, none, "without the diagonal structure");
    type Edit = fn(&mut SchemeTable);
    let not_zero: [(&str, Edit); 5] = [
        ("stages", |scheme| *scheme = SchemeTable { n_stages: 0, ..bathe() }),
        ("an instant", |scheme| scheme.stages[0].time = 1.0),
        ("a history", |scheme| scheme.stages[2].stiffness_history[5] = 1e-300),
        ("a finish", |scheme| scheme.finish[0][0] = 1.0),
        ("a number that is none", |scheme| scheme.stages[1].load[3] = f64::NAN),
    ];
    for (what, edit) in not_zero {
        let found = rewritten(|m| {
            moved_exactly(m);
            edit(&mut m.scheme);
        });
        assert_eq!(found, none, "{what} in a table of no stages");
    }
}

#[test]
fn refusal_15_no_stages_beside_the_canonical_structure() {
    let golden = vademecum_tests::golden::named("canonical.vdm");
    let file = File::parse(&golden).expect("a file");
    assert!(Chapter::read(&file).expect("sound tables").is_some());
    let sections: Vec<SectionInput<'_>> = file.sections().map(SectionInput::from).collect();
    let eigenvalues: Vec<u8> =
        (1..=file.metadata().n_modes).flat_map(|k| f64::from(k).to_le_bytes()).collect();
    let with_diagonal = |scheme: SchemeTable| {
        let mut metadata = *file.metadata();
        (metadata.diagonal, metadata.scheme) = (true, scheme);
        let mut sections = sections.clone();
        sections.retain(|section| section.kind != SectionKind::Eigenvalues);
        sections.push(SectionInput {
            kind: SectionKind::Eigenvalues,
            element: Element::F64,
            codec: Codec::Raw,
            required: true,
            shape: [eigenvalues.len() as u64 / 8, 1, 1],
            decoded_length: eigenvalues.len() as u64,
            stored: &eigenvalues,
        });
        let mut out = vec![0; encoded_len(&metadata, &sections)?];
        encode_into(&metadata, &sections, &mut out)
    };
    // The diagonal structure itself may stand there; it is the table that may not.
    assert!(with_diagonal(file.metadata().scheme).is_ok());
    let found = with_diagonal(SchemeTable::EXACT);
    assert_eq!(found, Err(FormatError::Scheme(TableError::StageCount { found: 0 })));
}

#[test]
fn exact_steps_alone_make_a_file_of_version_1_3() {
    let bytes = vademecum_tests::golden::named("fixed-f64.vdm");
    let file = File::parse(&bytes).expect("a file");
    let stages = |kind: SectionKind| {
        use SectionKind as S;
        matches!(kind, S::BlockState | S::BlockLoad | S::PatternBlock | S::AxisPoints | S::Factors)
    };
    let sections: Vec<SectionInput<'_>> =
        file.sections().filter(|s| !stages(s.kind())).map(SectionInput::from).collect();
    let mut metadata = *file.metadata();
    moved_exactly(&mut metadata);
    let mut out = vec![0; encoded_len(&metadata, &sections).expect("a length")];
    encode_into(&metadata, &sections, &mut out).expect("written");
    let made = File::parse(&out).expect("a file of exact steps opens");
    assert_eq!((made.minor(), made.metadata().scheme), (3, SchemeTable::EXACT));
    assert!(made.sections().all(|section| section.kind().since() == 0));
}

/// A coordinate with the stiffness scale of a region in it.
fn monomial(theta: f64, region: usize) -> AxisRole {
    let mut stiffness = [0.0; MAX_REGIONS];
    stiffness[region] = 1.0;
    AxisRole::Monomial { theta, stiffness, density: [0.0; MAX_REGIONS] }
}

const STIFFNESS: Parameter<'static> = Parameter {
    name: "stiffness",
    unit: "",
    role: ParameterRole::Stiffness,
    log: true,
    lower: 0.5,
    upper: 2.0,
    nominal: 1.0,
};

#[test]
fn refusal_31_parameters() {
    type Edit = fn(&mut Parameter<'_>);
    let with = |second: Parameter<'static>| {
        rewritten(|m| {
            m.n_parameters = 2;
            (m.parameters[0], m.parameters[1]) = (STIFFNESS, second);
        })
    };
    let alpha = Parameter {
        name: "alpha",
        unit: "1/s",
        role: ParameterRole::Alpha,
        log: false,
        lower: 0.0,
        ..STIFFNESS
    };
    assert!(with(alpha).is_ok());
    let refused: [(&str, Edit); 14] = [
        ("a lower end above the upper", |p| p.lower = 3.0),
        ("a range of one value", |p| (p.lower, p.upper) = (1.0, 1.0)),
        ("NaN below", |p| p.lower = f64::NAN),
        ("NaN above", |p| p.upper = f64::NAN),
        ("an infinite end", |p| p.upper = f64::INFINITY),
        ("nominal outside", |p| p.nominal = 2.1),
        ("nominal not a number", |p| p.nominal = f64::NAN),
        ("a negative ratio", |p| p.lower = -0.1),
        ("zero in the logarithm", |p| p.log = true),
        ("no density at all", |p| p.role = ParameterRole::Density),
        ("no time step at all", |p| p.role = ParameterRole::TimeStep),
        ("a region there is not", |p| (p.role, p.lower) = (ParameterRole::RegionDensity { region: 1 }, 0.1)),
        ("a role twice", |p| (p.role, p.lower) = (ParameterRole::Stiffness, 0.1)),
        ("a name twice", |p| p.name = "stiffness"),
    ];
    for (what, edit) in refused {
        let mut second = alpha;
        edit(&mut second);
        assert_eq!(with(second), Err(FormatError::Parameter { parameter: 1 }), "{what}");
    }
    assert_eq!(with(Parameter { name: "", ..alpha }), Err(FormatError::Parameter { parameter: 1 }));
    let unused = rewritten(|m| m.parameters[3] = STIFFNESS);
    assert_eq!(unused, Err(FormatError::Parameter { parameter: 3 }));
    // A region's parameter wants the reduced matrices of the regions.
    for (role, kind) in
        [(ParameterRole::RegionStiffness { region: 0 }, 19), (ParameterRole::RegionDensity { region: 0 }, 20)]
    {
        let missing = with(Parameter { name: "region", role, ..STIFFNESS });
        assert_eq!(missing, Err(FormatError::Missing { kind }));
    }
}

#[test]
fn refusals_18_to_26_directory() {
    use SectionKind as S;
    let at = |kind: SectionKind| entry(&small(), kind);
    let number = |kind: SectionKind| kind.number();
    let probes = at(S::ProbeNames);
    assert_eq!(refusal(|b| put(b, probes, &900u32.to_le_bytes())), FormatError::UnknownKind { kind: 900 });
    let kind = number(S::Eigenvalues);
    assert_eq!(refusal(|b| b[at(S::Eigenvalues) + 4] = 3), FormatError::Element { kind, found: 3 });
    assert_eq!(refusal(|b| b[at(S::Eigenvalues) + 4] = 77), FormatError::Element { kind, found: 77 });
    assert_eq!(refusal(|b| b[at(S::Eigenvalues) + 5] = 9), FormatError::Codec { kind, found: 9 });
    assert_eq!(refusal(|b| b[at(S::Eigenvalues) + 6] = 3), FormatError::Flags { kind, found: 3 });
    assert_eq!(
        refusal(|b| b[at(S::Eigenvalues) + 60] = 1),
        FormatError::NotZero { offset: at(S::Eigenvalues) as u64 + 60 }
    );
    // Probe names and pattern names may both have any length, so the second is refused for its kind alone.
    let twice = refusal(|b| put(b, probes, &number(S::PatternNames).to_le_bytes()));
    assert_eq!(twice, FormatError::Duplicate { kind: number(S::PatternNames) });
    for wrong in [0u64, 1, u64::MAX, u64::MAX - 63] {
        let moved = refusal(|b| put(b, at(S::Eigenvalues) + 32, &wrong.to_le_bytes()));
        assert!(matches!(moved, FormatError::Offset { found, .. } if found == wrong), "{moved:?}");
        let long = refusal(|b| put(b, at(S::Factors) + 40, &(wrong | 1 << 40).to_le_bytes()));
        assert!(matches!(long, FormatError::Length { .. }), "{long:?}");
        let shape = refusal(|b| put(b, at(S::BlockState) + 8, &wrong.to_le_bytes()));
        assert!(matches!(shape, FormatError::Shape { axis: 0, .. }), "{shape:?}");
    }
    let free = refusal(|b| put(b, at(S::ProbeNames) + 8, &u64::MAX.to_le_bytes()));
    assert_eq!(free, FormatError::Length { kind: number(S::ProbeNames), found: 5, expected: u64::MAX });
    let decoded = refusal(|b| b[at(S::Eigenvalues) + 48] ^= 1);
    assert_eq!(decoded, FormatError::Length { kind, found: 17, expected: 16 });
    let padding = refusal(|b| {
        let end = u32_at(b, at(S::Eigenvalues) + 32) as usize + 16;
        b[end] = 1;
    });
    assert!(matches!(padding, FormatError::NotZero { .. }));
    // An optional section of an unknown kind is skipped: here it hides one the structures need.
    let hidden = refusal(|b| {
        put(b, at(S::Eigenvalues) + 6, &0u16.to_le_bytes());
        put(b, at(S::Eigenvalues), &900u32.to_le_bytes());
    });
    assert_eq!(hidden, FormatError::Missing { kind });
}

#[test]
fn refusals_27_to_30_sections_and_lent_memory() {
    use SectionKind as S;
    let mut bytes = small();
    let start = u32_at(&bytes, entry(&bytes, S::PatternNames) + 32) as usize;
    bytes[start] = 0xFF;
    let file = File::parse(&bytes).expect("sections are not read on opening");
    let section = file.section(S::PatternNames).expect("present");
    assert!(matches!(file.verify_all(), Err(FormatError::SectionChecksum { kind: 12, .. })));
    assert_eq!(section.text(), Err(FormatError::Text { kind: 12 }));
    assert_eq!(section.f64s(), Err(FormatError::Element { kind: 12, found: 0 }));
    let mut bytes = small();
    let at = entry(&bytes, S::Eigenvalues);
    bytes[at + 5] = Codec::Zstd as u8;
    let bytes = reseal(bytes);
    let file = File::parse(&bytes).expect("described");
    let section = file.section(S::Eigenvalues).expect("present");
    assert_eq!(section.numbers().map(|n| n.len()), Err(FormatError::Compressed { kind: 5, codec: 1 }));
    let file = small();
    let file = File::parse(&file).expect("a file");
    let mut short = [0u8; 100];
    let refused = encode_into(file.metadata(), &[], &mut short);
    assert!(matches!(refused, Err(FormatError::LentMemory { found: 100, .. })));
}

/// The refusal of the golden file of version 1.1 after an edit of a section's directory entry.
fn refusal_of_separation(kind: SectionKind, edit: impl FnOnce(&mut [u8])) -> FormatError {
    let golden = vademecum_tests::golden::all();
    let (_, mut bytes) = golden.into_iter().find(|(name, _)| *name == "separation.vdm").expect("golden");
    let at = entry(&bytes, kind);
    edit(&mut bytes[at..at + BLOCK]);
    File::parse(&reseal(bytes)).map(|_| ()).expect_err("refused")
}

#[test]
fn history_and_radii_have_the_columns_they_must_have_and_any_number_of_rows() {
    use SectionKind as S;
    for (kind, columns) in [(S::EnrichmentHistory, 2), (S::RadiusSamples, 5)] {
        let number = kind.number();
        let found = refusal_of_separation(kind, |entry| put(entry, 16, &(columns + 1_u64).to_le_bytes()));
        let expected = FormatError::Shape { kind: number, axis: 1, found: columns + 1, expected: columns };
        assert_eq!(found, expected);
        let found = refusal_of_separation(kind, |entry| put(entry, 24, &2u64.to_le_bytes()));
        assert_eq!(found, FormatError::Shape { kind: number, axis: 2, found: 2, expected: 1 });
        // Rows the file does not have.
        let found = refusal_of_separation(kind, |entry| put(entry, 8, &u64::MAX.to_le_bytes()));
        assert!(matches!(found, FormatError::Length { kind, .. } if kind == number), "{found:?}");
        let found = refusal_of_separation(kind, |entry| entry[4] = Element::F32 as u8);
        assert_eq!(found, FormatError::Element { kind: number, found: Element::F32 as u8 });
    }
}

#[test]
fn sections_have_the_names_of_the_text() {
    let text = std::fs::read_to_string(repository().join("formats/vademecum-1.md")).expect("the text");
    for kind in SectionKind::ALL {
        let since = if kind.since() > 0 { format!(" (1.{})", kind.since()) } else { String::new() };
        let row = format!("\n| {} | {kind}{since} | ", kind.number());
        assert!(text.contains(&row), "no row `{}`", row.trim());
    }
}

#[test]
fn optional_sections_of_later_versions_are_skipped() {
    let mut bytes = small();
    let at = entry(&bytes, SectionKind::ProbeNames);
    put(&mut bytes, at, &900u32.to_le_bytes());
    put(&mut bytes, at + 4, &[200, 200, 0, 0x80]);
    put(&mut bytes, 10, &7u16.to_le_bytes());
    let bytes = reseal(bytes);
    let file = File::parse(&bytes).expect("a later minor version");
    assert!(file.section(SectionKind::ProbeNames).is_none());
    assert!(file.section(SectionKind::ProbeRows).is_some());
}

#[test]
fn every_flipped_bit_is_noticed_and_every_cut_refused() {
    let whole = small();
    assert!(File::parse(&whole).is_ok_and(|file| file.verify_all().is_ok()));
    for at in 0..whole.len() {
        let mut bytes = whole.clone();
        bytes[at] ^= 1 << (at % 8);
        let noticed = File::parse(&bytes).and_then(|file| file.verify_all()).is_err();
        assert!(noticed, "byte {at}");
        assert!(File::parse(&whole[..at]).is_err(), "cut at {at}");
        // The same flip with honest checksums may open; it must not panic, here or in what is read then.
        let bytes = reseal(bytes);
        if let Ok(file) = File::parse(&bytes) {
            let readable =
                file.sections().filter(|s| s.numbers().is_ok_and(|n| n.iter().count() == n.len())).count();
            assert!(readable > 0);
        }
    }
}

proptest! {
    #[test]
    fn what_is_written_opens_as_it_was(
        problem in ".{0,200}",
        program in ".{0,20}",
        hash in any::<[u8; 16]>(),
        numbers in proptest::collection::vec(-1e9f64..1e9, 3),
        names in "[a-z\n]{0,30}",
    ) {
        let stiffness: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let base = small();
        let file = File::parse(&base).expect("a file");
        let mut metadata = *file.metadata();
        (metadata.problem, metadata.program, metadata.mesh_hash) = (&problem, &program, hash);
        (metadata.block, metadata.n_terms, metadata.n_axes, metadata.n_modes) = (false, 0, 0, 3);
        metadata.axes[0] = metadata.axes[1];
        let names_of_it = if program.is_empty() { "p" } else { &program };
        metadata.n_parameters = 1;
        metadata.parameters[0] = Parameter { name: names_of_it, unit: &names, ..STIFFNESS };
        let section = |kind, element, stored| SectionInput {
            kind, element, codec: Codec::Raw, required: false,
            shape: if kind == SectionKind::Eigenvalues { [3, 1, 1] } else { [names.len() as u64, 1, 1] },
            decoded_length: <[u8]>::len(stored) as u64, stored,
        };
        let sections = [
            section(SectionKind::PatternNames, Element::U8, names.as_bytes()),
            section(SectionKind::Eigenvalues, Element::F64, &stiffness),
        ];
        let length = encoded_len(&metadata, &sections).expect("length");
        let (mut once, mut twice) = (vec![1; length + 5], vec![2; length]);
        prop_assert_eq!(encode_into(&metadata, &sections, &mut once), Ok(length));
        prop_assert_eq!(encode_into(&metadata, &sections, &mut twice), Ok(length));
        prop_assert_eq!(&once[..length], &twice[..]);
        let opened = File::parse(&twice).expect("opens");
        prop_assert_eq!(opened.verify_all(), Ok(()));
        // Certificates are NaN, so compare what Debug shows.
        prop_assert_eq!(format!("{:?}", opened.metadata()), format!("{:?}", metadata));
        prop_assert_eq!(opened.section(SectionKind::PatternNames).expect("names").text(), Ok(names.as_str()));
        let back = opened.section(SectionKind::Eigenvalues).expect("values").numbers().expect("numbers");
        prop_assert_eq!(back.iter().collect::<Vec<_>>(), numbers);
    }

    #[test]
    fn random_edits_never_panic(
        edits in proptest::collection::vec((0usize..4000, any::<u8>()), 1..12),
        seal in any::<bool>(),
    ) {
        let mut bytes = small();
        let length = bytes.len();
        edits.iter().for_each(|&(at, value)| bytes[at % length] = value);
        let bytes = if seal { reseal(bytes) } else { bytes };
        if let Ok(file) = File::parse(&bytes) {
            prop_assert!(file.sections().count() <= 256);
            let _ = file.verify_all();
        }
    }
}

#[test]
fn the_bytes_of_version_1_0_are_those_of_the_text() {
    // Golden: a change of the writer that nobody meant shows here. The text is renewed by
    // `cargo run --release -p vademecum-tests --example annotate`, never by this test.
    let text = include_str!("../../../formats/vademecum-1.md");
    let bytes = vademecum_tests::annotate::smallest();
    assert!(text.contains(&vademecum_tests::annotate::annotate(&bytes)));
}
