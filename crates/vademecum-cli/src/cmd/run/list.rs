//! `run.json`, the list of the files that a run wrote into its folder. The next run into the folder removes
//! what the list names, so that no results of two runs stand side by side.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use vademecum_build::store::{Kind, Outputs, read_regular};

use crate::console;
use crate::failure::Failure;

/// Name of the list.
const NAME: &str = "run.json";

/// Name of the table of many bodies.
pub(super) const BODIES: &str = "bodies.csv";

/// Files that a run may write; of the fields, the first. Nothing else is ever removed.
pub(super) const FILES: [(&str, Kind); 5] = [
    ("probes.csv", Kind::Csv),
    ("stress.csv", Kind::Csv),
    ("fields.pvd", Kind::Pvd),
    ("field-000000.vtu", Kind::Vtu),
    (BODIES, Kind::Csv),
];

/// Name of a field file.
pub(super) fn field_name(number: usize) -> String {
    format!("field-{number:06}.vtu")
}

/// Content of the list.
#[derive(Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Listed {
    /// Tables and the collection of fields.
    files_of_vademecum_run: Vec<String>,
    /// So many field files, `field-000000.vtu` and on.
    field_files: usize,
}

impl Listed {
    /// The list at `path`; `None` for none, and for a file that is no such list.
    fn read(path: &Path) -> Option<Self> {
        serde_json::from_slice(&read_regular(path).ok()?).ok()
    }
}

/// The list of a run.
pub(super) struct RunList<'a> {
    outputs: &'a Outputs,
    path: PathBuf,
    kind: Kind,
    listed: Listed,
}

impl<'a> RunList<'a> {
    /// Refuses, before any work begins, a folder into which a run cannot write.
    pub fn check(outputs: &Outputs, folder: &Path) -> Result<(), Failure> {
        let path = folder.join(NAME);
        outputs.check_in(folder, &FILES)?;
        outputs.check_in(folder, &[(NAME, kind_at(&path))])?;
        console::make_way_for(&path);
        Ok(())
    }

    /// Removes what the list of an older run names, and lists the files that this run is about to write, so
    /// that those of a run that is killed are known too.
    pub fn begin(
        outputs: &'a Outputs,
        folder: &Path,
        files: &[&str],
        field_files: usize,
    ) -> Result<Self, Failure> {
        let path = folder.join(NAME);
        let kind = kind_at(&path);
        if let Some(older) = Listed::read(&path) {
            remove(outputs, folder, &older)?;
        }
        let listed =
            Listed { files_of_vademecum_run: files.iter().map(ToString::to_string).collect(), field_files };
        let list = Self { outputs, path, kind, listed };
        list.write()?;
        Ok(list)
    }

    /// Writes the list of a run that has written so many fields.
    pub fn finish(&mut self, field_files: usize) -> Result<(), Failure> {
        if self.listed.field_files == field_files {
            return Ok(());
        }
        self.listed.field_files = field_files;
        self.write()
    }

    fn write(&self) -> Result<(), Failure> {
        let text = serde_json::to_string_pretty(&self.listed).unwrap_or_default();
        Ok(self.outputs.write(&self.path, self.kind, |out| writeln!(out, "{text}"))?)
    }
}

/// A list of an older run may be replaced; a file of somebody else's of this name may not.
fn kind_at(path: &Path) -> Kind {
    if Listed::read(path).is_some() { Kind::Json } else { Kind::Own }
}

/// Removes the files of an older run. A list is a file like any other: names that no run writes are let be.
fn remove(outputs: &Outputs, folder: &Path, older: &Listed) -> Result<(), Failure> {
    for (name, kind) in FILES {
        if older.files_of_vademecum_run.iter().any(|listed| listed == name) {
            outputs.remove(&folder.join(name), kind)?;
        }
    }
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let number = name.to_str().and_then(|name| name.strip_prefix("field-")?.strip_suffix(".vtu"));
        let number = number.and_then(|digits| digits.parse::<usize>().ok());
        if number.is_some_and(|n| n < older.field_files && name.to_str() == Some(&field_name(n))) {
            outputs.remove(&folder.join(name), Kind::Vtu)?;
        }
    }
    Ok(())
}
