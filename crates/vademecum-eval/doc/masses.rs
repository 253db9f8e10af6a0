// A body made by hand: one node, one mode, and the frame `end`.

use vademecum_eval::format::scheme::SchemeTable;
use vademecum_eval::format::{
    Axis, Certificate, Codec, Element, MAX_AXES, MAX_PARAMETERS, Metadata, Parameter, SectionInput,
    SectionKind, encode_into, encoded_len,
};

/// A mass of 1 kg at the origin that moves along x, on a spring \[N/m\] to the ground.
#[allow(dead_code)]
fn mass_on_spring(stiffness: f64) -> Vec<u8> {
    damped_mass(stiffness, 0.0)
}

/// The same in a fluid, with a damping \[kg/s\].
fn damped_mass(stiffness: f64, alpha: f64) -> Vec<u8> {
    let metadata = Metadata {
        program: "by hand",
        problem: "",
        units: "m, kg, s",
        mesh_hash: [0; 16],
        n_nodes: 1,
        n_surface_nodes: 1,
        n_load_nodes: 0,
        n_triangles: 0,
        n_load_triangles: 0,
        n_modes: 1,
        n_patterns: 0,
        n_probes: 0,
        scheme_name: "exact",
        scheme: SchemeTable::EXACT,
        time_step: 1e-2,
        alpha,
        beta: 0.0,
        n_regions: 1,
        n_parameters: 0,
        parameters: [Parameter::UNUSED; MAX_PARAMETERS],
        axes: [Axis::UNUSED; MAX_AXES],
        n_axes: 0,
        n_terms: 0,
        diagonal: true,
        block: false,
        certificate: Certificate::default(),
    };
    let reals = |numbers: &[f64]| -> Vec<u8> { numbers.iter().flat_map(|x| x.to_le_bytes()).collect() };
    // A frame at the origin, six rows of which the first is the displacement; no residual flexibility.
    let table: Vec<u8> = [1u32, 0, 6, 0, 0, 0, 0].iter().flat_map(|n| n.to_le_bytes()).collect();
    let frame = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    let rows = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0];
    let sections = [
        (SectionKind::NodeCoordinates, Element::F64, [1, 3, 1], reals(&[0.0; 3])),
        (SectionKind::Eigenvalues, Element::F64, [1, 1, 1], reals(&[stiffness])),
        (SectionKind::SurfaceBasis, Element::F64, [1, 3, 1], reals(&[1.0, 0.0, 0.0])),
        (SectionKind::PortNames, Element::U8, [3, 1, 1], b"end".to_vec()),
        (SectionKind::PortTable, Element::U32, [1, 7, 1], table),
        (SectionKind::PortFrames, Element::F64, [1, 12, 1], reals(&frame)),
        (SectionKind::PortRows, Element::F64, [6, 1, 1], reals(&rows)),
        (SectionKind::PortCompliance, Element::F64, [6, 6, 1], reals(&[0.0; 36])),
        (SectionKind::PortResidual, Element::F64, [6, 1, 3], reals(&[0.0; 18])),
    ];
    let inputs: Vec<SectionInput<'_>> = sections
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
    let mut bytes = vec![0; encoded_len(&metadata, &inputs).expect("a length")];
    encode_into(&metadata, &inputs, &mut bytes).expect("a file");
    bytes
}
