//! The golden files: small files of format versions 1.0, 1.1, 1.3, 1.5 to 1.7 and 1.9 to 1.14 made from
//! numbers alone, the same bytes on every machine with IEEE 754 arithmetic. No logarithm, power or cosine is
//! taken on the way: libraries round those differently; `+ − × ÷ √` they do not.

use crate::canonical::Terms;
use crate::regions::TwoRegions;
use crate::strained::Strained;
use crate::synthetic::{Body, Layout, bathe, newmark, rewritten};
use vademecum_format::scheme::{SchemeTable, StepParameters};
use vademecum_format::{
    Axis, BASE_PATTERNS, Codec, Element, File, Parameter, ParameterRole, Section, SectionInput, SectionKind,
    StrainSizes, encode_into, encoded_len,
};
use vademecum_rewrite::{Keep, strip};

const LAYOUT: Layout = Layout { rows: 3, load_rows: 2, columns: 3, n_interior: 2, r: 3 };
const STEP: StepParameters =
    StepParameters { time_step: 1e-3, alpha: 0.5, beta: 1e-6, density: 1.0, stiffness: 1.0 };

/// A closed basis with eigenvalues that are written here, not computed.
fn body(layout: Layout, seed: u64) -> Body {
    let mut body = Body::closed(layout, seed);
    body.lambda = vec![900.0, 40_000.0, 2_500_000.0];
    body
}

/// A file with two sections more, of numbers written here: a history of the enrichment and samples of the
/// spectral radius.
fn with_separation(bytes: &[u8]) -> Vec<u8> {
    let history = [[1.0, 0.25], [2.0, 0.0625], [27.0, 1e-7]];
    let radii = [[0.5, 0.5, 0.5, 0.5, 0.75], [2.0, 2.0, 2.0, 2.0, 0.9375]];
    let little = |values: &[f64]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let (history, radii) = (little(history.as_flattened()), little(radii.as_flattened()));
    let optional = |kind, shape, stored| SectionInput {
        kind,
        element: Element::F64,
        codec: Codec::Raw,
        required: false,
        shape,
        decoded_length: 8 * shape[0] * shape[1],
        stored,
    };
    let more = [
        optional(SectionKind::EnrichmentHistory, [3, 2, 1], &history),
        optional(SectionKind::RadiusSamples, [2, 5, 1], &radii),
    ];
    rewritten(bytes, |_| (), |_| (), &more)
}

/// A file with an embedded surface of three vertices more, one of them outside of its nodes.
fn embedded(bytes: &[u8]) -> Vec<u8> {
    let nodes: Vec<u8> = [[0u32, 1, 2, 4], [1, 2, 3, 5], [5, 6, 7, 8]]
        .as_flattened()
        .iter()
        .flat_map(|n| n.to_le_bytes())
        .collect();
    let weights = [[0.5, 0.25, 0.125, 0.125], [1.25, -0.5, 0.125, 0.125], [0.0, 0.0, 1.0, 0.0]];
    let weights: Vec<u8> = weights.as_flattened().iter().flat_map(|w: &f64| w.to_le_bytes()).collect();
    let triangles: Vec<u8> = [0u32, 1, 2].iter().flat_map(|v| v.to_le_bytes()).collect();
    let section = |kind, element, shape, stored| SectionInput {
        kind,
        element,
        codec: Codec::Raw,
        required: false,
        shape,
        decoded_length: <[u8]>::len(stored) as u64,
        stored,
    };
    let more = [
        section(SectionKind::EmbeddedNodes, Element::U32, [3, 4, 1], &nodes[..]),
        section(SectionKind::EmbeddedWeights, Element::F64, [3, 4, 1], &weights[..]),
        section(SectionKind::EmbeddedTriangles, Element::U32, [1, 3, 1], &triangles[..]),
    ];
    rewritten(bytes, |_| (), |_| (), &more)
}

/// A file with two ports more: a patch of three nodes, and a frame.
fn ports(bytes: &[u8]) -> Vec<u8> {
    const ROWS: usize = 15;
    let metadata = *File::parse(bytes).expect("a file").metadata();
    let [r, n, probes, patterns] =
        [metadata.n_modes, metadata.n_surface_nodes, metadata.n_probes, metadata.n_patterns];
    // Dyadic numbers, which every program reads and writes alike.
    let f64s = |count: usize| -> Vec<u8> {
        (0..count).flat_map(|k| (((7 * k) % 16) as f64 / 16.0).to_le_bytes()).collect()
    };
    let f32s = |count: usize| -> Vec<u8> {
        (0..count).flat_map(|k| (((7 * k) % 16) as f32 / 16.0).to_le_bytes()).collect()
    };
    let symmetric = |scale: f64| -> Vec<u8> {
        let entry =
            |i: usize, j: usize| if i == j { 4.0 * scale } else { scale / (1 << i.abs_diff(j)) as f64 };
        (0..ROWS * ROWS).flat_map(|k| entry(k / ROWS, k % ROWS).to_le_bytes()).collect()
    };
    let u32s = |numbers: &[u32]| -> Vec<u8> { numbers.iter().flat_map(|k| k.to_le_bytes()).collect() };
    let frame = [0.5, 0.25, 0.125, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let turned = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    let frames = [frame, turned].into_iter().flatten().flat_map(f64::to_le_bytes).collect();
    let facet = [0, 1, 2, u32::MAX, u32::MAX, u32::MAX, u32::MAX, u32::MAX, u32::MAX];
    let made: [(SectionKind, Element, [u64; 3], Vec<u8>); 11] = [
        (SectionKind::PortNames, Element::U8, [8, 1, 1], b"face\npin".to_vec()),
        (SectionKind::PortTable, Element::U32, [2, 7, 1], u32s(&[0, 0, 9, 0, 3, 0, 1, 1, 9, 6, 3, 0, 1, 0])),
        (SectionKind::PortFrames, Element::F64, [2, 12, 1], frames),
        (SectionKind::PortNodes, Element::U32, [3, 1, 1], u32s(&[2, 0, 1])),
        (SectionKind::PortFacets, Element::U32, [1, 9, 1], u32s(&facet)),
        (SectionKind::PortRows, Element::F64, [15, r.into(), 1], f64s(ROWS * r as usize)),
        (SectionKind::PortCompliance, Element::F64, [15, 15, 1], symmetric(1.0)),
        (SectionKind::PortInertia, Element::F64, [15, 15, 1], symmetric(0.25)),
        (SectionKind::PortResidual, Element::F32, [15, n.into(), 3], f32s(3 * ROWS * n as usize)),
        (SectionKind::PortProbes, Element::F64, [15, probes.into(), 1], f64s(ROWS * probes as usize)),
        (SectionKind::PortPatterns, Element::F64, [15, patterns.into(), 1], f64s(ROWS * patterns as usize)),
    ];
    let more: Vec<SectionInput<'_>> = made
        .iter()
        .map(|(kind, element, shape, stored)| SectionInput {
            kind: *kind,
            element: *element,
            codec: Codec::Raw,
            required: false,
            shape: *shape,
            decoded_length: stored.len() as u64,
            stored,
        })
        .collect();
    rewritten(bytes, |_| (), |_| (), &more)
}

/// A file with the residual between all loadable nodes more, and two further modes: what these leave of its
/// blocks of single nodes and of neighbours, and of zero between others.
fn patch(bytes: &[u8]) -> Vec<u8> {
    use SectionKind as S;
    const MODES: usize = 2;
    let file = File::parse(bytes).expect("a file");
    let nodes = file.metadata().n_load_nodes as usize;
    let numbers = |kind| -> Vec<f64> {
        file.section(kind).expect("a section").numbers().expect("raw").iter().collect()
    };
    let (contact, neighbours) = (numbers(S::ContactResidual), numbers(S::PairResidual));
    let rows: Vec<f64> = (0..3 * nodes * MODES).map(|i| ((i % 3) as f64 - 1.0) / 128.0).collect();
    let edges = loadable_pairs(&file);
    let (mut pairs, mut blocks) = (vec![], vec![]);
    for (a, b) in (0..nodes).flat_map(|a| (a..nodes).map(move |b| (a, b))) {
        pairs.extend([a as u32, b as u32].map(u32::to_le_bytes).concat());
        let own = &contact[6 * a..][..6];
        let edge = edges.iter().position(|edge| *edge == [a as u32, b as u32]);
        for at in 0..9 {
            let (i, j) = (at / 3, at % 3);
            let whole = match edge {
                _ if a == b => own[[0, 1, 2, 1, 3, 4, 2, 4, 5][at]],
                Some(edge) => neighbours[9 * edge + at],
                None => 0.0,
            };
            let [p, q] = [(3 * a + i) * MODES, (3 * b + j) * MODES];
            blocks.push(whole - (0..MODES).map(|k| rows[p + k] * rows[q + k]).sum::<f64>());
        }
    }
    let little = |values: &[f64]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let n = (blocks.len() / 9) as u64;
    let more = [
        (S::ContactModes, Element::F64, [nodes as u64, 3, MODES as u64], little(&rows)),
        (S::PatchPairs, Element::U32, [n, 2, 1], pairs),
        (S::PatchResidual, Element::F64, [n, 9, 1], little(&blocks)),
        (S::ContactPatch, Element::F64, [1, 1, 1], little(&[8.0])),
    ];
    // What a contact does not need is in the file that this one is made of.
    let left_out =
        [S::NodeIds, S::InteriorBasis, S::ProbeResidual, S::PatternResidual, S::PatternProbeResidual];
    let is_kept = |section: &Section<'_>| {
        !left_out.contains(&section.kind()) && !matches!(section.kind(), S::StaticBound | S::BoundMap)
    };
    let kept = file.sections().filter(is_kept).map(SectionInput::from);
    let inputs: Vec<SectionInput<'_>> = kept.chain(raw_sections(&more)).collect();
    let mut out = vec![0; encoded_len(file.metadata(), &inputs).expect("a length")];
    encode_into(file.metadata(), &inputs, &mut out).expect("written");
    out
}

/// The file with other bytes of a section, along whose first extent there are fewer or more of them.
///
/// # Panics
/// If the file has no such section.
#[must_use]
pub fn with_raw(bytes: &[u8], kind: SectionKind, raw: &[u8]) -> Vec<u8> {
    let file = File::parse(bytes).expect("a file");
    let mut inputs: Vec<SectionInput<'_>> = file.sections().map(SectionInput::from).collect();
    let own = inputs.iter_mut().find(|own| own.kind == kind).expect("a section");
    let row = own.decoded_length / own.shape[0];
    own.shape[0] = raw.len() as u64 / row;
    own.decoded_length = own.shape[0] * row;
    own.stored = &raw[..own.decoded_length as usize];
    let mut out = vec![0; encoded_len(file.metadata(), &inputs).expect("a length")];
    encode_into(file.metadata(), &inputs, &mut out).expect("written");
    out
}

/// The file as a parametric model of two live regions, one of them of live density, beside what is not live;
/// where `damped`, a loss factor and dashpots are live in place of the density and `β`.
fn parametric(bytes: &[u8], damped: bool) -> Vec<u8> {
    use SectionKind as S;
    let file = File::parse(bytes).expect("a file");
    let numbers = |kind| -> Vec<f64> {
        file.section(kind).expect("a section").numbers().expect("raw").iter().collect()
    };
    let (lambda, nodes) = (numbers(S::Eigenvalues), file.metadata().n_load_nodes as usize);
    let r = lambda.len();
    // Shares of the regions on the diagonal; beside it they cancel.
    let triangle = |share: f64, off: f64, diagonal: &[f64]| -> Vec<f64> {
        let entry = |i: usize, j: usize| if i == j { share * diagonal[i] } else { off * diagonal[j] };
        (0..r).flat_map(|i| (0..=i).map(move |j| entry(i, j))).collect()
    };
    let matrices = |diagonal: &[f64]| -> Vec<f64> {
        let rows = [(0.25, 0.0), (0.25, 0.0625), (0.5, -0.0625)];
        rows.into_iter().flat_map(|(share, off)| triangle(share, off, diagonal)).collect()
    };
    let [third, fourth] = match damped {
        false => [[3.0, 1.0, 0.0, 0.5, 1.5, 1.0], [5.0, 0.0, 0.0, 0.0, 1e-4, 1e-6]],
        true => [[7.0, 1.0, 0.0, 0.0, 0.25, 0.125], [8.0, 0.0, 0.0, 0.0, 4.0, 1.0]],
    };
    let parameters = [[1.0, 0.0, 1.0, 0.5, 2.0, 1.0], [1.0, 1.0, 1.0, 0.25, 4.0, 1.0], third, fourth];
    let terms = (0..nodes).flat_map(|node| {
        let own = (1 + node % 2) as f64;
        [[node as f64, own, own, 0.0, 0.75], [node as f64, own, 3.0, 0.5, 0.25]]
    });
    let terms: Vec<f64> = terms.flatten().collect();
    let points = [[2.0, 0.25, 1.0, 1e-6, 0.0, 0.015625], [1.0, 1.0, 1.0, 1e-6, 1.0, 0.00390625]];
    let little = |values: &[f64]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let names: &[u8] = match damped {
        false => b"stiffness of the root\nstiffness of the tip\ndensity of the tip\nbeta",
        true => b"stiffness of the root\nstiffness of the tip\nloss of the tip\ndashpot",
    };
    let packed = (r * (r + 1) / 2) as u64;
    let regions: Vec<u8> = [1_u32, 2].iter().flat_map(|region| region.to_le_bytes()).collect();
    let mut more = vec![
        (S::LiveParameters, Element::F64, [4, 6, 1], little(parameters.as_flattened())),
        (S::LiveNames, Element::U8, [names.len() as u64, 1, 1], names.to_vec()),
        (S::LiveStiffness, Element::F64, [3, packed, 1], little(&matrices(&lambda))),
        (S::LiveRegions, Element::U32, [2, 1, 1], regions),
        (S::LiveResidual, Element::F64, [2 * nodes as u64, 5, 1], little(&terms)),
        (S::LiveCertificate, Element::F64, [2, 6, 1], little(points.as_flattened())),
    ];
    if damped {
        // Energies as built: a quarter and a half of each mode.
        let ratios = vec![0.015625 + 0.5 * (0.25 * 0.0625 + 0.5 * 0.125); r];
        let rows: Vec<f64> = (0..2 * r).map(|place| [4.0, -2.0, 16.0, 0.0, 8.0, 32.0][place % 6]).collect();
        let witness = [2.0, 0.25, 0.125, 1.0, 0.015625, 0.0009765625, 0.0625, 0.125, 0.5];
        let groups: Vec<u8> = [0_u32, 1].iter().flat_map(|group| group.to_le_bytes()).collect();
        more.extend([
            (S::DampingRatios, Element::F64, [r as u64, 1, 1], little(&ratios)),
            (S::DampingRows, Element::F64, [2, r as u64, 1], little(&rows)),
            (S::LiveLoss, Element::F64, [3, 1, 1], little(&[0.015625, 0.0625, 0.125])),
            (S::LiveDampers, Element::U32, [2, 1, 1], groups),
            (S::LiveWitnesses, Element::F64, [1, 9, 1], little(&witness)),
        ]);
    } else {
        more.push((S::LiveMass, Element::F64, [3, packed, 1], little(&matrices(&vec![1.0; r]))));
    }
    more.sort_by_key(|section| section.0.number());
    let is_kept = |section: &Section<'_>| {
        let replaced = more.iter().any(|own| own.0 == section.kind());
        !matches!(section.kind(), S::StaticBound | S::BoundMap) && !replaced
    };
    let kept = file.sections().filter(is_kept).map(SectionInput::from);
    let live = raw_sections(&more).into_iter().map(|section| {
        let required = section.kind.is_live() || matches!(section.kind, S::DampingRatios | S::DampingRows);
        SectionInput { required, ..section }
    });
    let inputs: Vec<SectionInput<'_>> = kept.chain(live).collect();
    let mut metadata = *file.metadata();
    (metadata.n_parameters, metadata.parameters[0]) = (0, Parameter::UNUSED);
    let mut out = vec![0; encoded_len(&metadata, &inputs).expect("a length")];
    encode_into(&metadata, &inputs, &mut out).expect("written");
    out
}

/// A file with two lines about repairs more.
fn with_repairs(bytes: &[u8]) -> Vec<u8> {
    let text =
        "spectral radius 1+2.0e-4 with 2 terms: 4 terms\nspectral radius 1+1.0e-6 with 4 terms: 8 terms";
    let repairs = SectionInput {
        kind: SectionKind::Repairs,
        element: Element::U8,
        codec: Codec::Raw,
        required: false,
        shape: [text.len() as u64, 1, 1],
        decoded_length: text.len() as u64,
        stored: text.as_bytes(),
    };
    rewritten(bytes, |_| (), |_| (), &[repairs])
}

/// The file of one quadratic tetrahedron: ten nodes, all of them on its surface, four triangles a face,
/// middles of edges as corners of triangles like any other node. The order of elements is nowhere else in a
/// file.
fn quadratic() -> Vec<u8> {
    const CORNERS: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];
    /// Corners of each face, outward, then the middles of its edges.
    const FACES: [[u32; 6]; 4] =
        [[0, 2, 1, 6, 5, 4], [0, 1, 3, 4, 8, 7], [1, 2, 3, 5, 9, 8], [2, 0, 3, 6, 7, 9]];
    let middles = EDGES.map(|[a, b]| std::array::from_fn(|c| 0.5 * (CORNERS[a][c] + CORNERS[b][c])));
    let nodes: Vec<[f64; 3]> = CORNERS.into_iter().chain(middles).collect();
    let parts = |face: [u32; 6]| {
        [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]].map(|part: [usize; 3]| part.map(|i| face[i]))
    };
    let triangles: Vec<u8> =
        FACES.iter().flat_map(|&face| parts(face)).flatten().flat_map(u32::to_le_bytes).collect();
    let coordinates: Vec<u8> = nodes.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let ten = Layout { rows: 2, load_rows: 2, columns: 5, n_interior: 0, r: 3 };
    let grid = body(ten, 3).file(&bathe(), &STEP, Element::F64);
    rewritten(
        &grid,
        |metadata| (metadata.n_triangles, metadata.n_load_triangles) = (16, 16),
        |section| match section.kind {
            SectionKind::NodeCoordinates => section.stored = &coordinates,
            SectionKind::Triangles => {
                section.shape[0] = 16;
                section.decoded_length = triangles.len() as u64;
                section.stored = &triangles;
            }
            _ => {}
        },
        &[],
    )
}

/// A file whose loadable surface is a facet of nine nodes, one of four, and two triangles.
fn quadrangles() -> Vec<u8> {
    const NONE: u32 = u32::MAX;
    const FACETS: [[u32; 11]; 2] =
        [[0, 8, 0, 2, 8, 6, 1, 5, 7, 3, 4], [8, 2, 6, 7, 10, 9, NONE, NONE, NONE, NONE, NONE]];
    let layout = Layout { rows: 4, load_rows: 4, columns: 3, n_interior: 2, r: 3 };
    let grid = body(layout, 7).file(&bathe(), &STEP, Element::F64);
    let stored: Vec<u8> = FACETS.as_flattened().iter().flat_map(|x| x.to_le_bytes()).collect();
    let more = [(SectionKind::Quadrangles, Element::U32, [2, 11, 1], stored)];
    rewritten(&grid, |_| (), |_| (), &raw_sections(&more))
}

/// The bytes of one golden file.
///
/// # Panics
/// If there is none of that name.
#[must_use]
pub fn named(name: &str) -> Vec<u8> {
    all().into_iter().find(|file| file.0 == name).expect("a golden file").1
}

/// Name and bytes of every golden file.
///
/// # Panics
/// If the writer refuses one.
#[must_use]
pub fn all() -> Vec<(&'static str, Vec<u8>)> {
    let fixed = body(LAYOUT, 1).file(&bathe(), &STEP, Element::F64);
    let probes = strip(&fixed, Keep::Probes).expect("a file with probes");
    let undamped = StepParameters { alpha: 0.0, beta: 0.0, ..STEP };
    // θ of both stages at the file's Δt = 10⁻³ (Δt²/16 and Δt²/9) lies within the range of the first axis.
    let common = [2e-8, 1e-7, 3e-7];
    let parameters =
        TwoRegions::new(1).separated(&bathe(), &undamped, &common, &[0.5, 1.0, 2.0], &[0.5, 1.25, 2.0]);
    let exact = exact(&body(LAYOUT, 4).file(&bathe(), &STEP, Element::F64));
    let canonical = crate::canonical::file(&body(LAYOUT, 1), &bathe(), &undamped, &[0, 2, 5], Terms::Apart);
    vec![
        ("canonical.vdm", canonical),
        ("embedded.vdm", embedded(&fixed)),
        ("fixed-f64.vdm", fixed),
        ("fixed-f32.vdm", body(LAYOUT, 2).file(&newmark(0.25, 0.5), &STEP, Element::F32)),
        ("repairs.vdm", with_repairs(&probes)),
        ("separation.vdm", with_separation(&parameters)),
        ("parameters.vdm", parameters),
        ("probes.vdm", probes),
        ("quadrangles.vdm", self::exact(&quadrangles())),
        ("quadratic.vdm", quadratic()),
        ("quantised.vdm", quantised(&body(LAYOUT, 3).file(&bathe(), &STEP, Element::F64))),
        ("dashpots.vdm", with_dashpots(&reactions(&exact), &[4.0, -2.0, 16.0, 0.0, 8.0, 32.0])),
        ("ports.vdm", ports(&exact)),
        ("patch.vdm", patch(&exact)),
        ("parametric.vdm", parametric(&exact, false)),
        ("damped.vdm", parametric(&exact, true)),
        ("reactions.vdm", reactions(&exact)),
        ("base.vdm", base(&exact)),
        ("bent.vdm", bent(&body(LAYOUT, 6).file(&bathe(), &STEP, Element::F64), &[])),
        ("swinging.vdm", bent(&body(LAYOUT, 6).file(&bathe(), &STEP, Element::F64), &[30.0, 0.0, 1500.0])),
        ("stress.vdm", stress(&exact, (SectionKind::ElasticConstants, &ISOTROPIC))),
        ("anisotropic.vdm", stress(&exact, (SectionKind::Compliance, &compliances()))),
        ("exact-f64.vdm", exact),
        ("free.vdm", free(&self::exact(&body(LAYOUT, 5).file(&bathe(), &STEP, Element::F64)))),
    ]
}

/// The file with a strain map in place of its structures: one coordinate that interacts, one that couples
/// with it, a tail of one, and two rows beside those of the coordinates; natural modes where `modes` says.
fn bent(bytes: &[u8], modes: &[f64]) -> Vec<u8> {
    let sizes = StrainSizes { interacting: 1, coupled: 1, rows: 5, coordinates: 3, substeps: 1 };
    let quadratic = [24.0, -8.0, 40.0, 56.0, -32.0, 16.0, 12.0, 20.0, 4.0, -28.0];
    let strained = Strained {
        sizes,
        linear: vec![30.0, 0.0, 6.0, 200.0, 12.0, -20.0],
        tail: vec![1500.0],
        quadratic: quadratic.to_vec(),
        modes: modes.to_vec(),
        training: vec![2.0, 0.5, 0.0, 0.0, 4.0, -0.25, 0.0, 0.0, 8.0],
        limits: [3.0, 5000.0],
    };
    strained.into_file(bytes)
}

/// The file with its body free: a live density, six patterns of the angular velocity behind its own, and
/// mass, centre and moments of inertia about tilted axes. Numbers are small fractions whose denominators are
/// powers of two.
fn free(bytes: &[u8]) -> Vec<u8> {
    use SectionKind as S;
    let file = File::parse(bytes).expect("a file");
    let own = file.metadata().n_patterns as usize;
    let longer = |kind: SectionKind, per_pattern: usize, unit: f64| -> Vec<u8> {
        let more = (0..6 * per_pattern).map(|i| unit * ((i * i + 3) % 13) as f64 - 4.0 * unit);
        let more: Vec<u8> = more.flat_map(f64::to_le_bytes).collect();
        [file.section(kind).expect("a section").stored(), &more].concat()
    };
    let metadata = file.metadata();
    let (r, nodes) = (metadata.n_modes as usize, metadata.n_load_nodes as usize);
    let names = file.section(S::PatternNames).expect("names").text().expect("text");
    let centrifugal = ["xx", "yy", "zz", "xy", "yz", "zx"].map(|pair| format!("\ncentrifugal {pair}"));
    let [xx, xy, xz, yy, yz, zz] = [0.5, 0.0625, -0.03125, 0.625, 0.015625, 0.75];
    let moments = [
        [0.0, xz, -xy],
        [-yz, 0.0, xy],
        [yz, -xz, 0.0],
        [-xz, yz, xx - yy],
        [yy - zz, -xy, xz],
        [xy, zz - xx, -yz],
    ];
    let of_own = (0..6 * own).map(|i| 0.25 * (i % 5) as f64 - 0.5);
    let of_spin = moments.into_iter().flat_map(|moment| [0.0; 3].into_iter().chain(moment));
    let rigid = [2.0, 0.125, 0.0625, -0.25, xx, xy, xz, yy, yz, zz, own as f64];
    let rigid: Vec<u8> = rigid.into_iter().chain(of_own).chain(of_spin).flat_map(f64::to_le_bytes).collect();
    let changed: Vec<(SectionKind, Vec<u8>)> = vec![
        (S::PatternBasis, longer(S::PatternBasis, r, 1.0 / 64.0)),
        (S::PatternResidual, longer(S::PatternResidual, 3 * nodes, 1.0 / 65_536.0)),
        (
            S::PatternProbeResidual,
            longer(S::PatternProbeResidual, metadata.n_probes as usize, 1.0 / 65_536.0),
        ),
        (S::PatternNames, [names.as_bytes(), centrifugal.concat().as_bytes()].concat()),
    ];
    let body = SectionInput {
        kind: S::RigidBody,
        element: Element::F64,
        codec: Codec::Raw,
        required: false,
        shape: [rigid.len() as u64 / 8, 1, 1],
        decoded_length: rigid.len() as u64,
        stored: &rigid,
    };
    rewritten(
        bytes,
        |metadata| {
            metadata.n_patterns += 6;
            let stiffness = metadata.parameters[0];
            metadata.parameters[0] = Parameter { name: "density", role: ParameterRole::Density, ..stiffness };
        },
        |section| {
            if let Some((_, stored)) = changed.iter().find(|(kind, _)| *kind == section.kind) {
                section.stored = stored;
                section.decoded_length = stored.len() as u64;
                section.shape[0] = match section.kind {
                    S::PatternNames => stored.len() as u64,
                    _ => own as u64 + 6,
                };
            }
        },
        &[body],
    )
}

/// The file with exact steps in place of its scheme: no block structure, a live stiffness, damping ratios of
/// the modes (light, none, overdamped) and a residual flexibility with its bound. The numbers are small
/// fractions whose denominators are powers of two; blocks are dominated by their diagonals.
fn exact(bytes: &[u8]) -> Vec<u8> {
    use Element::{F64, U32};
    use SectionKind as S;
    let file = File::parse(bytes).expect("a file");
    let metadata = file.metadata();
    let (nodes, probes) = (metadata.n_load_nodes as usize, metadata.n_probes as usize);
    let patterns = metadata.n_patterns as usize;
    let edges = loadable_pairs(&file);
    // Residual answers of a ten-thousandth of a metre a newton, as large as what the modes show.
    let unit = 1.0 / 8192.0;
    let wave = |i: usize, period: usize| (i % period) as f64 - (period / 2) as f64;
    let diagonal = |node: usize| {
        let own = (8 + node) as f64;
        [own, 1.0, -0.5, own + 2.0, 0.25, own + 1.0].map(|x| unit * x)
    };
    let contact: Vec<f64> = (0..nodes).flat_map(diagonal).collect();
    let pairs: Vec<f64> = (0..9 * edges.len()).map(|i| unit * wave(i, 7) / 8.0).collect();
    let at_probes: Vec<f64> = (0..3 * probes * nodes).map(|i| unit * wave(i, 5)).collect();
    let of_patterns: Vec<f64> = (0..3 * patterns * nodes).map(|i| unit * wave(i, 11)).collect();
    let patterns_at_probes: Vec<f64> = (0..patterns * probes).map(|i| unit * (i + 1) as f64).collect();
    let relative = |node: usize| (nodes - node) as f64 / 16.0;
    let map: Vec<f64> = (0..nodes)
        .flat_map(|node| diagonal(node).map(|x| unit * x).into_iter().chain([relative(node)]))
        .collect();
    let bound = [0.0, relative(0), relative(nodes / 2), relative(1)];
    let little = |values: &[f64]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let pair_bytes = edges.iter().flatten().flat_map(|node| node.to_le_bytes()).collect();
    let counts = [nodes, probes, patterns, edges.len()].map(|n| n as u64);
    let [n, p, q, e] = counts;
    let more: Vec<(SectionKind, Element, [u64; 3], Vec<u8>)> = vec![
        (S::DampingRatios, F64, [3, 1, 1], little(&[0.03125, 0.0, 1.5])),
        (S::ContactResidual, F64, [n, 6, 1], little(&contact)),
        (S::ResidualPairs, U32, [e, 2, 1], pair_bytes),
        (S::PairResidual, F64, [e, 9, 1], little(&pairs)),
        (S::ProbeResidual, F64, [p, n, 3], little(&at_probes)),
        (S::PatternResidual, F64, [q, n, 3], little(&of_patterns)),
        (S::PatternProbeResidual, F64, [q, p, 1], little(&patterns_at_probes)),
        (S::StaticBound, F64, [4, 1, 1], little(&bound)),
        (S::BoundMap, F64, [n, 7, 1], little(&map)),
    ];
    let of_stages =
        |kind| matches!(kind, S::BlockState | S::BlockLoad | S::PatternBlock | S::AxisPoints | S::Factors);
    let kept = file.sections().filter(|s| !of_stages(s.kind())).map(SectionInput::from);
    let added = more.iter().map(|(kind, element, shape, stored)| SectionInput {
        kind: *kind,
        element: *element,
        codec: Codec::Raw,
        required: *kind == S::DampingRatios,
        shape: *shape,
        decoded_length: stored.len() as u64,
        stored,
    });
    let inputs: Vec<SectionInput<'_>> = kept.chain(added).collect();
    let mut metadata = *metadata;
    (metadata.scheme_name, metadata.scheme) = ("exact", SchemeTable::EXACT);
    (metadata.block, metadata.n_terms, metadata.n_axes, metadata.axes[0]) = (false, 0, 0, Axis::UNUSED);
    metadata.n_parameters = 1;
    metadata.parameters[0] = Parameter {
        name: "stiffness",
        unit: "",
        role: ParameterRole::Stiffness,
        log: false,
        lower: 0.5,
        upper: 2.0,
        nominal: 1.0,
    };
    let mut out = vec![0; encoded_len(&metadata, &inputs).expect("a length")];
    encode_into(&metadata, &inputs, &mut out).expect("written");
    out
}

/// The file with reactions of two supports, which carry a quarter and three quarters of every force.
fn reactions(bytes: &[u8]) -> Vec<u8> {
    use SectionKind as S;
    const POINTS: [[f64; 3]; 2] = [[-0.5, 0.0, 0.25], [2.0, 1.0, 0.0]];
    const SHARES: [f64; 2] = [0.25, 0.75];
    let file = File::parse(bytes).expect("a file");
    let metadata = file.metadata();
    let numbers = |kind| file.section(kind).expect("present").numbers().expect("raw");
    let places: Vec<f64> = numbers(S::NodeCoordinates).iter().collect();
    // Under a unit force along `c` at `x`: the force, then the moment about the point.
    let held = |x: [f64; 3], s: usize| -> [f64; 18] {
        std::array::from_fn(|k| {
            let (row, c) = (k / 3, k % 3);
            let arm: [f64; 3] = std::array::from_fn(|i| x[i] - POINTS[s][i]);
            let along = |i: usize| if i == c { -SHARES[s] } else { 0.0 };
            match row.checked_sub(3) {
                None => along(row),
                Some(i) => arm[(i + 1) % 3] * along((i + 2) % 3) - arm[(i + 2) % 3] * along((i + 1) % 3),
            }
        })
    };
    let nodes = places.as_chunks::<3>().0.iter().take(metadata.n_load_nodes as usize);
    let loads: Vec<f64> = (0..2).flat_map(|s| nodes.clone().flat_map(move |&x| held(x, s))).collect();
    let r = metadata.n_modes as usize;
    let wave = |i: usize| (i % 13) as f64 / 16.0 - 0.375;
    let basis: Vec<f64> = (0..12 * r).map(wave).collect();
    let patterns = metadata.n_patterns as usize;
    let of_patterns: Vec<f64> = (0..12 * patterns).map(|i| 1.0 - 0.5 * wave(i)).collect();
    let little = |values: &[f64]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let names = b"left\nright foot".to_vec();
    let [n, p, r] = [u64::from(metadata.n_load_nodes), patterns as u64, r as u64];
    let more: Vec<(SectionKind, Element, [u64; 3], Vec<u8>)> = vec![
        (S::SupportNames, Element::U8, [names.len() as u64, 1, 1], names),
        (S::SupportPoints, Element::F64, [2, 3, 1], little(POINTS.as_flattened())),
        (S::ReactionBasis, Element::F64, [2, 6, r], little(&basis)),
        (S::ReactionLoads, Element::F64, [2, n, 18], little(&loads)),
        (S::PatternReaction, Element::F64, [p, 2, 6], little(&of_patterns)),
    ];
    rewritten(bytes, |_| (), |_| (), &raw_sections(&more))
}

/// The file with rows of dashpots that couple its modes.
///
/// # Panics
/// If the writer refuses it.
#[must_use]
pub fn with_dashpots(bytes: &[u8], rows: &[f64]) -> Vec<u8> {
    let r = File::parse(bytes).expect("a file").metadata().n_modes as usize;
    let stored: Vec<u8> = rows.iter().flat_map(|x| x.to_le_bytes()).collect();
    let section = SectionInput {
        kind: SectionKind::DampingRows,
        element: Element::F64,
        codec: Codec::Raw,
        required: true,
        shape: [(rows.len() / r) as u64, r as u64, 1],
        decoded_length: stored.len() as u64,
        stored: &stored,
    };
    rewritten(bytes, |_| (), |_| (), &[section])
}

/// Young's modulus and Poisson's ratio of two regions.
const ISOTROPIC: [f64; 4] = [2.0, 0.25, 8.0, 0.125];

/// Upper triangles of the compliances of two regions, with every constant.
fn compliances() -> [f64; 42] {
    std::array::from_fn(|i| {
        // Places of the diagonal in a triangle of six rows.
        let diagonal = [0, 6, 11, 15, 18, 20].contains(&(i % 21));
        if diagonal { 2.0 + (i / 21) as f64 } else { ((i * i + 1) % 7) as f64 / 16.0 - 0.1875 }
    })
}

/// The file with the stress at three points, two of them one node in two regions, constants of these, and a
/// gauge for its first probe.
fn stress(bytes: &[u8], (kind, constants): (SectionKind, &[f64])) -> Vec<u8> {
    use SectionKind as S;
    const POINTS: [u32; 6] = [0, 0, 4, 0, 4, 1];
    let file = File::parse(bytes).expect("a file");
    let metadata = file.metadata();
    let [nodes, patterns, r] = [metadata.n_load_nodes, metadata.n_patterns, metadata.n_modes].map(u64::from);
    let wave = |length: u64, size: f64| -> Vec<u8> {
        (0..length).flat_map(|i| (size * ((i % 19) as f64 / 8.0 - 1.125)).to_le_bytes()).collect()
    };
    let points = POINTS.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let per_region = constants.len() as u64 / 2;
    let constants = constants.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let units: Vec<&str> = (0..metadata.n_probes).map(|probe| if probe == 0 { "1" } else { "m" }).collect();
    let units = units.join("\n").into_bytes();
    let more: Vec<(SectionKind, Element, [u64; 3], Vec<u8>)> = vec![
        (S::StressPoints, Element::U32, [3, 2, 1], points),
        (S::StressBasis, Element::F64, [3, 6, r], wave(18 * r, 1.0)),
        (S::StressResidual, Element::F64, [3, nodes, 18], wave(54 * nodes, 0.25)),
        (S::PatternStress, Element::F64, [patterns, 3, 6], wave(18 * patterns, 0.5)),
        (kind, Element::F64, [2, per_region, 1], constants),
        (S::ProbeUnits, Element::U8, [units.len() as u64, 1, 1], units),
    ];
    rewritten(bytes, |_| (), |_| (), &raw_sections(&more))
}

/// Sections as the writer takes them, as they are.
fn raw_sections(more: &[(SectionKind, Element, [u64; 3], Vec<u8>)]) -> Vec<SectionInput<'_>> {
    let mut sections = vec![];
    for (kind, element, shape, stored) in more {
        let (decoded_length, codec) = (stored.len() as u64, Codec::Raw);
        let (kind, element, shape) = (*kind, *element, *shape);
        sections.push(SectionInput { kind, element, codec, required: false, shape, decoded_length, stored });
    }
    sections
}

/// The file on a base that moves: twelve patterns more.
fn base(bytes: &[u8]) -> Vec<u8> {
    use SectionKind as S;
    let file = File::parse(bytes).expect("a file");
    let metadata = file.metadata();
    let [r, nodes, probes] = [metadata.n_modes, metadata.n_load_nodes, metadata.n_probes].map(|n| n as usize);
    let patterns = metadata.n_patterns as usize + BASE_PATTERNS.len();
    let little = |values: Vec<f64>| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    // What the file has, and numbers of that size behind it.
    let longer = |kind, length: usize, size: f64| -> Vec<u8> {
        let known = file.section(kind).expect("present").numbers().expect("raw");
        let more = (known.len()..length).map(|i| size * ((i % 17) as f64 / 8.0 - 0.875));
        little(known.iter().chain(more).collect())
    };
    let unit = 1.0 / 8192.0;
    let basis = longer(S::PatternBasis, patterns * r, 1.0);
    let residual = longer(S::PatternResidual, patterns * nodes * 3, unit);
    let at_probes = longer(S::PatternProbeResidual, patterns * probes, unit);
    let names: Vec<&str> = file.pattern_names().chain(BASE_PATTERNS).collect();
    let names = names.join("\n").into_bytes();
    let point = little(vec![0.0, 0.5, -0.25]);
    let frame = SectionInput {
        kind: S::BaseFrame,
        element: Element::F64,
        codec: Codec::Raw,
        required: false,
        shape: [3, 1, 1],
        decoded_length: 24,
        stored: &point,
    };
    rewritten(
        bytes,
        |metadata| metadata.n_patterns = patterns as u32,
        |section| {
            let (stored, first) = match section.kind {
                S::PatternBasis => (&basis, patterns),
                S::PatternResidual => (&residual, patterns),
                S::PatternProbeResidual => (&at_probes, patterns),
                S::PatternNames => (&names, names.len()),
                _ => return,
            };
            section.shape[0] = first as u64;
            (section.stored, section.decoded_length) = (stored, stored.len() as u64);
        },
        &[frame],
    )
}

/// Pairs of nodes that share a loadable facet, the first below the second, ascending.
fn loadable_pairs(file: &File<'_>) -> Vec<[u32; 2]> {
    let triangles = file.section(SectionKind::Triangles).expect("triangles").u32s().expect("numbers");
    let quadrangles = file.quadrangles().expect("facets");
    let mut pairs = vec![];
    for (index, triangle) in (0..file.metadata().n_load_triangles).zip(triangles.as_chunks::<3>().0) {
        let whole = quadrangles.of_triangle(index).map(|facet| facet.nodes().to_vec());
        let nodes = whole.unwrap_or_else(|| triangle.map(u32::from_le_bytes).to_vec());
        let with = |&a: &u32| nodes.iter().filter(move |&&b| a < b).map(move |&b| [a, b]).collect::<Vec<_>>();
        pairs.extend(nodes.iter().flat_map(with));
    }
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}

/// The file with its space sections as 16-bit numbers, each column with a scale of its own. Scales have few
/// bits, so every operation is exact but for one division, and rounding half away from zero is the same
/// everywhere.
fn quantised(bytes: &[u8]) -> Vec<u8> {
    use SectionKind as S;
    let file = File::parse(bytes).expect("a file");
    let space = |kind| matches!(kind, S::SurfaceBasis | S::InteriorBasis | S::BlockLoad);
    let stored: Vec<Vec<u8>> =
        file.sections().map(|s| if space(s.kind()) { quantise(&s) } else { s.stored().to_vec() }).collect();
    let inputs: Vec<SectionInput<'_>> = file
        .sections()
        .zip(&stored)
        .map(|(s, stored)| SectionInput {
            kind: s.kind(),
            element: if space(s.kind()) { Element::I16 } else { s.element() },
            codec: Codec::Raw,
            required: s.is_required(),
            shape: s.shape(),
            decoded_length: stored.len() as u64,
            stored,
        })
        .collect();
    let mut out = vec![0; encoded_len(file.metadata(), &inputs).expect("a length")];
    encode_into(file.metadata(), &inputs, &mut out).expect("written");
    out
}

fn quantise(section: &Section<'_>) -> Vec<u8> {
    let columns = (section.shape()[1] * section.shape()[2]) as usize;
    let scale = |column: usize| (4 + column % 3) as f32 / 65_536.0;
    let values = section.numbers().expect("numbers");
    let number = |(i, value): (usize, f64)| (value / f64::from(scale(i % columns))).round() as i16;
    let scales = (0..columns).flat_map(|column| scale(column).to_le_bytes());
    scales.chain(values.iter().enumerate().flat_map(|(i, x)| number((i, x)).to_le_bytes())).collect()
}
