//! `formats/vademecum-1.ksy` describes the file our reader reads: the parser the Kaitai Struct compiler makes
//! of it and `vademecum-format` are shown the same golden files and must see the same.

use std::path::PathBuf;
use std::process::Command;

use serde_json::{Value, json};
use vademecum_format::scheme::StepParameters;
use vademecum_format::{AxisRole, Blocks, Codec, Element, File, Metadata, ParameterRole, Section};
use vademecum_rewrite::{pack, pack_within};
use vademecum_tests::golden;
use vademecum_tests::program::repository;
use vademecum_tests::synthetic::{Body, Layout, bathe};

/// The folder with the compiler. Outside CI a machine without node or without a registry skips; in CI that is
/// a failure.
fn modules() -> Option<String> {
    let script = repository().join("tests/scripts/kaitai-modules");
    let output = Command::new("sh").arg(script).output().expect("a shell");
    if output.status.success() {
        return Some(String::from_utf8(output.stdout).expect("a path").trim().to_string());
    }
    let why = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(std::env::var_os("CI").is_none(), "no Kaitai Struct compiler: {why}");
    eprintln!("skipped: no Kaitai Struct compiler: {why}");
    None
}

/// Reals as their bits: decimals would hide the last one, and NaN.
fn bits(values: impl IntoIterator<Item = f64>) -> Value {
    values.into_iter().map(|x| Value::from(format!("{:016x}", x.to_bits()))).collect()
}

fn values(section: &Section<'_>) -> Value {
    if section.codec() != Codec::Raw {
        return Value::Null;
    }
    match section.element() {
        Element::U8 => section.raw().expect("raw").iter().copied().collect(),
        Element::U32 => section.u32s().expect("u32").iter().map(|&b| u32::from_le_bytes(b)).collect(),
        Element::U64 => section.u64s().expect("u64").iter().map(|&b| u64::from_le_bytes(b)).collect(),
        _ => bits(section.numbers().expect("numbers").iter()),
    }
}

/// Block length and ends of the frames, as the table has them.
fn blocks(section: &Section<'_>) -> Value {
    let Ok(blocks) = Blocks::new(section) else { return Value::Null };
    let mut table = vec![blocks.block_length()];
    let mut end = 0;
    for index in 0..blocks.len() {
        end += blocks.frame(index).expect("a frame").len() as u64;
        table.push(end);
    }
    json!(table)
}

fn metadata(m: &Metadata<'_>) -> Value {
    let stage = |s: &vademecum_format::scheme::Stage| {
        let head = [s.mass, s.damping, s.stiffness, s.time];
        let histories = [s.mass_history, s.damping_history, s.stiffness_history].concat();
        bits(head.into_iter().chain(s.load).chain(histories))
    };
    let parameter = |p: &vademecum_format::Parameter<'_>| {
        use ParameterRole as R;
        let (role, region) = match p.role {
            R::Stiffness => (0, None),
            R::RegionStiffness { region } => (1, Some(region)),
            R::Density => (2, None),
            R::RegionDensity { region } => (3, Some(region)),
            R::Alpha => (4, None),
            R::Beta => (5, None),
            R::TimeStep => (6, None),
            other => panic!("{other:?} is missing in this table and in the description"),
        };
        json!({ "name": p.name, "unit": p.unit, "role": role, "region": region, "log": u8::from(p.log),
            "range": bits([p.lower, p.upper, p.nominal]) })
    };
    let axis = |a: &vademecum_format::Axis<'_>| {
        let (role, exponents) = match a.role {
            AxisRole::Stage => (0, Value::Null),
            AxisRole::Monomial { theta, stiffness, density } => {
                (1, bits([theta].into_iter().chain(stiffness).chain(density)))
            }
            other => panic!("{other:?} is missing in this table and in the description"),
        };
        json!({ "name": a.name, "unit": a.unit, "role": role, "kind": a.kind as u32, "log": u8::from(a.log),
            "n_points": a.n_points, "exponents": exponents, "range": bits([a.lower, a.upper]) })
    };
    let [n, surface, load, triangles] = [m.n_nodes, m.n_surface_nodes, m.n_load_nodes, m.n_triangles];
    json!({
        "program": m.program, "problem": m.problem, "units": m.units, "mesh_hash": m.mesh_hash,
        "counts": [n, surface, load, triangles, m.n_load_triangles, m.n_modes, m.n_patterns, m.n_probes],
        "scheme_name": m.scheme_name, "n_stages": m.scheme.n_stages,
        "stages": m.scheme.stages.iter().map(stage).collect::<Vec<_>>(),
        "finish": bits(m.scheme.finish.concat()),
        "time": bits([m.time_step, m.alpha, m.beta]), "n_regions": m.n_regions,
        "n_axes": m.n_axes, "n_terms": m.n_terms,
        "parameters": m.active_parameters().iter().map(parameter).collect::<Vec<_>>(),
        "axes": m.active_axes().iter().map(axis).collect::<Vec<_>>(),
        "structures": [u8::from(m.diagonal), u8::from(m.block)],
        "steps_are_nan": [m.certificate.diagonal.steps.is_nan(), m.certificate.block.steps.is_nan()],
    })
}

/// What our reader sees, in the words of `tests/kaitai/read.cjs`.
fn ours(bytes: &[u8]) -> Value {
    let file = File::parse(bytes).expect("a file");
    file.verify_all().expect("undamaged");
    let origin = bytes.as_ptr() as usize;
    let entry = |s: Section<'_>| {
        let stored = s.stored();
        json!({ "kind": s.kind().number(), "element": s.element() as u8, "codec": s.codec() as u8,
            "required": s.is_required(), "shape": s.shape(), "offset": stored.as_ptr() as usize - origin,
            "stored_length": stored.len(), "decoded_length": s.decoded_length(),
            "crc32": crc32fast::hash(stored),
            "stored_bytes": stored.len(), "values": values(&s), "blocks": blocks(&s) })
    };
    json!({
        "header": { "major": vademecum_format::MAJOR, "minor": file.minor(),
            "n_sections": file.sections().count(), "file_length": bytes.len() },
        "directory": file.sections().map(entry).collect::<Vec<_>>(),
        "metadata": metadata(file.metadata()),
    })
}

#[test]
fn the_generated_parser_and_our_reader_see_the_same() {
    let Some(modules) = modules() else { return };
    let folder = tempfile::tempdir().expect("a folder");
    let mut files: Vec<(PathBuf, Vec<u8>)> = golden::all()
        .into_iter()
        .map(|(name, bytes)| (repository().join("fixtures/golden").join(name), bytes))
        .collect();
    let packed = pack(&files[0].1, 19).expect("packed");
    std::fs::write(folder.path().join("packed.vdm"), &packed).expect("written");
    files.push((folder.path().join("packed.vdm"), packed));
    let layout = Layout { rows: 40, load_rows: 10, columns: 40, n_interior: 100, r: 8 };
    let step = StepParameters { time_step: 1e-3, alpha: 0.0, beta: 0.0, density: 1.0, stiffness: 1.0 };
    let large = Body::closed(layout, 5).file(&bathe(), &step, Element::F64);
    for (name, bytes) in [("blocks.vdm", pack(&large, 3)), ("rounded.vdm", pack_within(&large, 3, 1e-3))] {
        let bytes = bytes.expect("packed");
        let several = |s: Section<'_>| Blocks::new(&s).is_ok_and(|blocks| blocks.len() > 1);
        assert!(name == "rounded.vdm" || File::parse(&bytes).expect("a file").sections().any(several));
        std::fs::write(folder.path().join(name), &bytes).expect("written");
        files.push((folder.path().join(name), bytes));
    }
    let mut node = Command::new("node");
    node.arg(repository().join("tests/kaitai/read.cjs")).arg(modules);
    node.arg(repository().join("formats/vademecum-1.ksy")).args(files.iter().map(|f| &f.0));
    let output = node.output().expect("node");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let theirs: Vec<Value> = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!(theirs.len(), files.len());
    for ((path, bytes), theirs) in files.iter().zip(&theirs) {
        let ours = ours(bytes);
        for part in ["header", "directory", "metadata"] {
            assert_eq!(theirs[part], ours[part], "{part} of {}", path.display());
        }
    }
}
