//! `vademecum help`: commands, and the pages about the files that people write.

use vademecum_build::suggest::did_you_mean;

use crate::failure::{Cause, Failure};
use crate::reference::{PAGES, Page};

/// Prints the help of a command, or all keys of a problem or scenario file.
#[derive(clap::Args)]
#[command(after_help = "Examples:
  vademecum help problem              every key of the problem file
  vademecum help problem basis        one section of it
  vademecum help scenario             every key of the scenario file
  vademecum help sweep                every key of the sweep file
  vademecum help json                 what commands print with `--json`
  vademecum help export matrices      the same as `vademecum export matrices --help`")]
pub(crate) struct Help {
    /// A command, or `problem`, `scenario`, `sweep` or `json`, and a section of that page.
    topic: Vec<String>,
}

impl Help {
    /// Help on the topic; `program` is the whole command line.
    pub(crate) fn run(&self, mut program: clap::Command) -> Result<(), Failure> {
        program.build();
        let topics = || {
            let commands = program.get_subcommands().map(|command| command.get_name().to_string());
            commands.chain(PAGES.iter().map(|page| page.name.to_string())).collect::<Vec<_>>()
        };
        if let Some(page) = self.topic.first().and_then(|name| PAGES.iter().find(|page| page.name == name)) {
            return show(page, &self.topic[1..].join(" "));
        }
        let mut command = &program;
        for name in &self.topic {
            command = command.find_subcommand(name).ok_or_else(|| unknown(name, &topics()))?;
        }
        println!("{}", command.clone().render_long_help().to_string().trim_end());
        if self.topic.is_empty() {
            println!("\nPages, with `vademecum help PAGE`:");
            PAGES.iter().for_each(|page| println!("  {:<10} {}", page.name, page.about));
        }
        Ok(())
    }
}

/// A page, or one section of it.
fn show(page: &Page, section: &str) -> Result<(), Failure> {
    if section.is_empty() {
        println!("{}", page.whole().trim_end());
        println!("\nSections, with `vademecum help {} SECTION`: {}", page.name, page.sections().join(", "));
        return Ok(());
    }
    let Some(text) = page.section(section) else {
        return Err(unknown(section, &page.sections()));
    };
    println!("{}", text.trim_end());
    Ok(())
}

fn unknown(name: &str, known: &[String]) -> Failure {
    let nearest = did_you_mean(name, known.iter().map(String::as_str));
    Failure::new(Cause::Usage, format!("no help on `{name}`; known: {}{nearest}", known.join(", ")))
}
