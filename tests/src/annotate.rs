//! The annotated bytes of `formats/vademecum-1.md`: a file as small as one can be, field by field.

use crate::synthetic::{encode, newmark};
use std::fmt::Write;
use vademecum_format::{
    Axis, BLOCK, Certificate, Element, File, MAX_AXES, MAX_PARAMETERS, Metadata, Parameter, SectionKind,
};

/// One node, one mode, the diagonal structure, the trapezoidal rule.
#[must_use]
pub fn smallest() -> Vec<u8> {
    let metadata = Metadata {
        program: "example",
        problem: "",
        units: "m, kg, s",
        mesh_hash: [0xAB; 16],
        n_nodes: 1,
        n_surface_nodes: 1,
        n_load_nodes: 1,
        n_triangles: 0,
        n_load_triangles: 0,
        n_modes: 1,
        n_patterns: 0,
        n_probes: 0,
        scheme_name: "newmark",
        scheme: newmark(0.25, 0.5),
        time_step: 0.5,
        alpha: 0.0,
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
    let basis = [0.0f32, 1.0, 0.0].iter().flat_map(|x| x.to_le_bytes()).collect();
    let contents = [
        (SectionKind::Eigenvalues, Element::F64, 4.0f64.to_le_bytes().to_vec()),
        (SectionKind::SurfaceBasis, Element::F32, basis),
    ];
    encode(&metadata, &contents)
}

/// `(length, label)` of every field, in file order.
fn fields(bytes: &[u8]) -> Vec<(usize, String)> {
    let file = File::parse(bytes).expect("a file");
    let mut fields: Vec<(usize, String)> = Vec::new();
    let mut add = |length: usize, label: &str| fields.push((length, label.to_string()));
    let header = [
        (8, "magic"),
        (2, "major version 1"),
        (2, "minor version 0"),
        (4, "number of sections"),
        (8, "file length"),
        (8, "metadata offset"),
        (8, "metadata length"),
        (4, "CRC-32 of the metadata"),
        (4, "CRC-32 of the directory"),
        (12, "zero"),
        (4, "CRC-32 of bytes 0 to 59"),
    ];
    header.iter().for_each(|&(length, label)| add(length, label));
    for section in file.sections() {
        add(4, &format!("section kind {}: {:?}", section.kind().number(), section.kind()));
        add(2, &format!("element {:?}, codec {:?}", section.element(), section.codec()));
        add(2, "flags: required");
        add(24, "shape");
        [(8, "offset"), (8, "stored length"), (8, "decoded length"), (4, "CRC-32"), (4, "zero")]
            .iter()
            .for_each(|&(length, label)| add(length, label));
    }
    let m = file.metadata();
    for (name, text) in [("program", m.program), ("problem", m.problem), ("units", m.units)] {
        add(8, &format!("length of `{name}`"));
        add(text.len(), name);
    }
    add(16, "mesh_hash");
    let counts = [
        "nodes",
        "surface_nodes",
        "load_nodes",
        "triangles",
        "load_triangles",
        "modes",
        "patterns",
        "probes",
    ];
    counts.iter().for_each(|name| add(4, &format!("n_{name}")));
    add(8, "length of `scheme_name`");
    add(m.scheme_name.len(), "scheme_name");
    add(1, "scheme: number of stages");
    for stage in 0..3 {
        add(32, &format!("stage {stage}: m, d, k, c"));
        add(32, "  load weights");
        [("M", 48), ("C", 48), ("K", 48)]
            .iter()
            .for_each(|(name, length)| add(*length, &format!("  history of {name}")));
    }
    ["u", "Δt u̇", "Δt² ü"].iter().for_each(|row| add(48, &format!("finish row of {row}")));
    ["time_step", "alpha", "beta"].iter().for_each(|name| add(8, name));
    add(4, "n_regions");
    add(4, "n_parameters");
    add(45 * MAX_PARAMETERS, "16 parameters, none used");
    add(45 * MAX_AXES, "12 axes, none used");
    add(4, "n_axes");
    add(4, "n_terms");
    add(1, "diagonal: present");
    add(1, "block: absent");
    add(56, "certificate of the diagonal structure: not measured");
    add(56, "certificate of the block structure: not measured");
    for section in file.sections() {
        let at: usize = fields.iter().map(|(length, _)| length).sum();
        fields.push((at.next_multiple_of(BLOCK) - at, "padding".to_string()));
        fields.push((section.stored().len(), format!("{:?}", section.kind())));
    }
    fields
}

/// Where the first field with this label begins.
///
/// # Panics
/// If there is none.
#[must_use]
pub fn place(bytes: &[u8], label: &str) -> usize {
    let fields = fields(bytes);
    let found = fields.iter().position(|field| field.1 == label).expect("a field of the smallest file");
    fields[..found].iter().map(|(length, _)| length).sum()
}

/// Offset, bytes and meaning, 16 bytes a line at most; whole lines of zeros inside a field are left out.
///
/// # Panics
/// If the fields do not add up to the file: the text above has fallen behind the format.
#[must_use]
pub fn annotate(bytes: &[u8]) -> String {
    let mut text = String::new();
    let mut at = 0;
    for (length, label) in fields(bytes) {
        for (line, chunk) in bytes[at..at + length].chunks(16).enumerate() {
            if line > 0 && chunk.iter().all(|&byte| byte == 0) {
                continue;
            }
            let hex: Vec<String> = chunk.iter().map(|byte| format!("{byte:02x}")).collect();
            let label = if line == 0 { label.as_str() } else { "" };
            let row = format!("{:04x}  {:<47}  {label}", at + 16 * line, hex.join(" "));
            writeln!(text, "{}", row.trim_end()).expect("text");
        }
        at += length;
    }
    assert_eq!(at, bytes.len(), "the fields cover the file");
    text
}
