//! Any text as an assembly file, whose parts are golden files: joined to one body, or marched as a world for
//! a while. No panic, what is joined opens, and no number of a row that is not finite.
#![no_main]

use std::path::PathBuf;

use libfuzzer_sys::fuzz_target;
use vademecum_assembly::{
    AssemblyFile, WorldPlan, WorldRow, WorldRunError, WorldRunOptions, WorldSink, assemble, run_world,
};
use vademecum_build::progress::Silent;
use vademecum_format::File;

/// Files of the parts, in turn: ports of a held body, a free body, a contact patch, other sections.
const FILES: [&str; 5] = ["ports.vdm", "free.vdm", "patch.vdm", "exact-f64.vdm", "quadrangles.vdm"];

/// Rows of a march.
const ROWS: usize = 50;

fuzz_target!(|bytes: &[u8]| {
    let Ok(text) = std::str::from_utf8(bytes) else { return };
    let golden = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/golden"));
    let Ok(mut file) = AssemblyFile::parse(text, "assembly.toml", golden) else { return };
    // No other file of the machine is read. More parts or contacts take time and memory, and nothing else.
    if file.parts.len() > 6
        || file.parts.iter().any(|part| part.rigid.as_ref().is_some_and(|r| r.surface.is_some()))
    {
        return;
    }
    for part in file.parts.iter_mut().filter(|part| part.rigid.is_none()) {
        let number = part.file.as_os_str().len();
        part.file = FILES
            .iter()
            .map(PathBuf::from)
            .find(|name| *name == part.file)
            .unwrap_or_else(|| FILES[number % FILES.len()].into());
    }
    let Some(world) = &mut file.world else {
        if let Ok(assembled) = assemble(&file) {
            File::parse(&assembled.bytes).expect("a joined file opens");
        }
        return;
    };
    world.contacts = world.contacts.min(64);
    world.sweeps = world.sweeps.min(20);
    let options = WorldRunOptions { every: 1, surfaces: true };
    let _ = run_world(&file, &options, &Silent, &mut Rows(0));
});

/// Rows shown so far.
struct Rows(usize);

/// The end of a march.
#[derive(Debug)]
enum End {
    /// Refused.
    Run,
    /// Long enough.
    Enough,
}

impl From<WorldRunError> for End {
    fn from(_: WorldRunError) -> Self {
        Self::Run
    }
}

impl WorldSink for Rows {
    type Error = End;

    fn begin(&mut self, plan: &WorldPlan) -> Result<(), End> {
        if plan.columns.is_empty() { Err(End::Run) } else { Ok(()) }
    }

    fn show(&mut self, row: &WorldRow<'_>) -> Result<(), End> {
        assert!(row.time.is_finite() && row.values.iter().all(|x| x.is_finite()), "{row:?}");
        assert!(row.nodes.as_flattened().iter().all(|x| x.is_finite()));
        self.0 += 1;
        if self.0 < ROWS { Ok(()) } else { Err(End::Enough) }
    }
}
