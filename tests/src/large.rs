//! A file of 100 MB: 90 000 nodes, 48 modes, nothing but numbers that need not mean anything.

use vademecum_format::scheme::StepParameters;
use vademecum_format::{Element, Metadata, SectionKind};

use crate::synthetic::{Body, Layout, Random, bathe, encode};

/// Its layout.
pub const LAYOUT: Layout = Layout { rows: 50, load_rows: 50, columns: 40, n_interior: 88_000, r: 48 };

/// The bytes of the file: diagonal structure, raw binary64 sections.
///
/// # Panics
/// If the writer refuses it.
#[must_use]
pub fn file() -> Vec<u8> {
    let step = StepParameters { time_step: 1e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
    // The metadata of a small body of as many modes, with other counts.
    let small = Body::closed(Layout { rows: 4, load_rows: 4, columns: 8, n_interior: 0, r: LAYOUT.r }, 1)
        .file(&bathe(), &step, Element::F64);
    let small = vademecum_format::File::parse(&small).expect("a file");
    let (triangles, n_load_triangles) = LAYOUT.triangles();
    let metadata = Metadata {
        n_nodes: LAYOUT.n_nodes() as u32,
        n_surface_nodes: LAYOUT.n_surface() as u32,
        n_load_nodes: LAYOUT.n_surface() as u32,
        n_triangles: (triangles.len() / 3) as u32,
        n_load_triangles: n_load_triangles as u32,
        n_patterns: 0,
        n_probes: 0,
        axes: [vademecum_format::Axis::UNUSED; vademecum_format::MAX_AXES],
        n_axes: 0,
        n_terms: 0,
        block: false,
        ..*small.metadata()
    };
    let mut random = Random::new(3);
    let mut numbers = |count: usize| -> Vec<u8> {
        (0..count).flat_map(|_| (1e-3 * random.number()).to_le_bytes()).collect()
    };
    let row = 3 * LAYOUT.r;
    let eigenvalues = (0..LAYOUT.r).flat_map(|k| (100.0 * (1 + k) as f64).to_le_bytes()).collect();
    let contents = vec![
        (SectionKind::NodeCoordinates, Element::F64, numbers(3 * LAYOUT.n_nodes())),
        (SectionKind::Triangles, Element::U32, triangles.iter().flat_map(|t| t.to_le_bytes()).collect()),
        (SectionKind::Eigenvalues, Element::F64, eigenvalues),
        (SectionKind::SurfaceBasis, Element::F64, numbers(row * LAYOUT.n_surface())),
        (SectionKind::InteriorBasis, Element::F64, numbers(row * LAYOUT.n_interior)),
    ];
    encode(&metadata, &contents)
}
