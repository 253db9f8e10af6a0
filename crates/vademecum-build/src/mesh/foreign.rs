//! Formats that hold meshes and are not read: their names, and what makes a readable file of them.

/// Remedy for what Python's meshio reads.
const MESHIO: &str = "write it as Gmsh .msh, VTU or Abaqus .inp, for example with Python: \
                      vademecum.problem_from_meshio(meshio.read(FILE), \"mesh.inp\")";
/// Remedy for decks of LS-DYNA.
const DYNA: &str = "write the mesh as Nastran .bdf, Abaqus .inp, Gmsh .msh or VTU with the preprocessor that \
                    made it";

/// Remedy for a packed surface.
const SURFACE: &str = "write the surface as STL, OBJ, PLY or GLB";

/// Extensions of decks of LS-DYNA.
pub const LS_DYNA_EXTENSIONS: [&str; 3] = ["k", "key", "dyn"];

const LS_DYNA: (&str, &str) = ("an LS-DYNA keyword file", DYNA);
const MED: (&str, &str) = ("a MED file", MESHIO);
const EXODUS: (&str, &str) = ("an Exodus file", MESHIO);
const CGNS: (&str, &str) = ("a CGNS file", MESHIO);
const XDMF: (&str, &str) = ("an XDMF file", MESHIO);

/// Name, with its article, and remedy of a format that is not read, by the first words of the file, else by
/// its extension in small letters.
pub(super) fn foreign(head: &[u8], extension: &str) -> Option<(&'static str, &'static str)> {
    by_words(head, extension).or(match extension {
        _ if LS_DYNA_EXTENSIONS.contains(&extension) => Some(LS_DYNA),
        "med" => Some(MED),
        "exo" | "ex2" | "exii" => Some(EXODUS),
        "cgns" => Some(CGNS),
        "xdmf" | "xmf" => Some(XDMF),
        "3mf" => Some(("a 3MF file", SURFACE)),
        _ => None,
    })
}

/// The same by the first words alone; binary containers take their name from the extension.
fn by_words(head: &[u8], extension: &str) -> Option<(&'static str, &'static str)> {
    let hdf = head.starts_with(b"\x89HDF\r\n\x1a\n");
    if hdf || [&b"CDF\x01"[..], b"CDF\x02", b"CDF\x05"].iter().any(|magic| head.starts_with(magic)) {
        return Some(match extension {
            "med" | "rmed" | "mmed" => MED,
            "cgns" => CGNS,
            "e" | "g" | "exo" | "ex2" | "exii" | "ncdf" => EXODUS,
            _ if hdf => ("an HDF5 file", MESHIO),
            _ => EXODUS,
        });
    }
    if head.get(..64.min(head.len())).is_some_and(|start| contains(start, b"ADF Database")) {
        return Some(CGNS);
    }
    if head.starts_with(b"<") && contains(head.get(..1000).unwrap_or(head), b"<Xdmf") {
        return Some(XDMF);
    }
    let mut lines = head.split(|b| *b == b'\n').map(<[u8]>::trim_ascii).filter(|line| !line.is_empty());
    let first = lines.find(|line| !line.starts_with(b"$")).unwrap_or_default();
    first.get(..8).is_some_and(|word| word.eq_ignore_ascii_case(b"*KEYWORD")).then_some(LS_DYNA)
}

fn contains(text: &[u8], word: &[u8]) -> bool {
    text.windows(word.len()).any(|window| window == word)
}
