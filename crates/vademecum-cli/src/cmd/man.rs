//! `vademecum man`: a manual page of each command.

use std::path::PathBuf;

use vademecum_build::store::Outputs;

use crate::arguments::OutputArguments;
use crate::failure::Failure;
use crate::files::{check_own, outputs, write_own};

/// Writes manual pages, one for each command, such as `vademecum-build.1`.
#[derive(clap::Args)]
#[command(after_help = "Example:
  vademecum man ~/.local/share/man/man1 && man vademecum-build")]
pub(crate) struct Man {
    /// Folder for the pages; made if missing.
    folder: PathBuf,
    #[command(flatten)]
    outputs: OutputArguments,
}

impl Man {
    /// Writes the pages of `program`, the whole command line, and of its commands.
    pub(crate) fn run(&self, mut program: clap::Command) -> Result<(), Failure> {
        program.build();
        let outputs: Outputs = outputs(&self.outputs, &[], None);
        let mut pages = vec![];
        collect(&program, "vademecum", &mut pages)?;
        outputs.make_folder(&self.folder)?;
        // One of an older version is replaced on request only: another program may have written it.
        pages.iter().try_for_each(|(name, text)| check_own(&outputs, &self.folder.join(name), text))?;
        pages.iter().try_for_each(|(name, text)| write_own(&outputs, &self.folder.join(name), text))?;
        println!("{}: {} pages", self.folder.display(), pages.len());
        Ok(())
    }
}

/// The page of a command under the name `name`, and those of its own commands.
fn collect(command: &clap::Command, name: &str, pages: &mut Vec<(String, String)>) -> Result<(), Failure> {
    let mut text = vec![];
    clap_mangen::Man::new(command.clone())
        .render(&mut text)
        .map_err(|error| Failure::io(std::path::Path::new(name), error))?;
    pages.push((format!("{name}.1"), String::from_utf8_lossy(&text).into_owned()));
    for below in command.get_subcommands() {
        collect(below, &format!("{name}-{}", below.get_name()), pages)?;
    }
    Ok(())
}
