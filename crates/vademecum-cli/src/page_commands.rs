//! Commands on the pages of the repository: their arguments are those that the program takes, and what they
//! name is there.

use std::path::{Path, PathBuf};

use clap::Parser;

use super::Arguments;

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Every page below a folder, without what is not part of the repository.
fn pages(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder") {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        if path.is_dir() && !name.starts_with('.') && !["target", "node_modules"].contains(&name.as_str()) {
            pages(&path, found);
        } else if path.extension().is_some_and(|extension| extension == "md") {
            found.push(path);
        }
    }
}

/// The words of each simple command in the blocks of shell commands on a page.
fn commands(page: &str) -> Vec<Vec<String>> {
    let blocks = page.split("```sh\n").skip(1).filter_map(|rest| rest.split("```").next());
    blocks.flat_map(|block| words(&block.replace("\\\n", " "))).collect()
}

/// Splits a text as a shell does, without expanding anything: quotes, comments, separators, redirections.
fn words(text: &str) -> Vec<Vec<String>> {
    let (mut commands, mut command, mut word) = (vec![], vec![], None::<String>);
    let mut quote = None;
    let mut characters = text.chars().peekable();
    while let Some(c) = characters.next() {
        match (quote, c) {
            (Some(mark), c) if c == mark => quote = None,
            (Some(_), c) => word.get_or_insert_default().push(c),
            (None, '\'' | '"') => {
                quote = Some(c);
                word.get_or_insert_default();
            }
            (None, '#') if word.is_none() => while characters.next_if(|&c| c != '\n').is_some() {},
            (None, c) if c.is_whitespace() || ";|&<>".contains(c) => {
                command.extend(word.take());
                if !c.is_whitespace() || c == '\n' {
                    commands.push(std::mem::take(&mut command));
                }
            }
            (None, c) => word.get_or_insert_default().push(c),
        }
    }
    command.extend(word);
    commands.push(command);
    commands.retain(|command| !command.is_empty());
    commands
}

/// The arguments of the program in a command, its own name first.
fn of_program(command: &[String]) -> Option<Vec<String>> {
    let own = |word: &String| word == "vademecum" || word.ends_with("/vademecum");
    if let Some(at) = command.iter().position(own) {
        return Some(command[at..].to_vec());
    }
    let at = command.iter().position(|word| word == "--")?;
    let with_cargo = command[..at].windows(2).any(|pair| pair == ["-p", "vademecum-cli"]);
    with_cargo.then(|| std::iter::once("vademecum".into()).chain(command[at + 1..].iter().cloned()).collect())
}

/// Reason for which a command of a page cannot be given; none for a sound one.
fn fault(command: &[String]) -> Option<String> {
    let there = |path: &str| repository().join(path).exists();
    let after = |flag: &str| command.windows(2).find(|pair| pair[0] == flag).map(|pair| pair[1].as_str());
    if command[0] == "cargo" {
        let package = after("-p").or_else(|| after("--package")).unwrap_or("vademecum-cli");
        let folder = match package {
            "vademecum-tests" => "tests".to_string(),
            "vademecum-examples" => "examples".to_string(),
            package => format!("crates/{package}"),
        };
        let manifest = std::fs::read_to_string(repository().join(&folder).join("Cargo.toml"));
        let Ok(manifest) = manifest else { return Some(format!("no package {package}")) };
        let named = |name: &str| manifest.contains(&format!("name = \"{name}\""));
        let of_kind = |flag, kind: &str| {
            after(flag).filter(|name| {
                let file = |suffix: &str| there(&format!("{folder}/{kind}{name}{suffix}"));
                !(named(name) || file(".rs") || file("/main.rs"))
            })
        };
        let absent = of_kind("--example", if folder == "examples" { "" } else { "examples/" });
        let absent =
            absent.or_else(|| of_kind("--test", "tests/")).or_else(|| of_kind("--bench", "benches/"));
        if let Some(name) = absent {
            return Some(format!("{package} has no {name}"));
        }
    } else if command[0].contains('/') && !command[0].starts_with(['/', '.', '$', '~']) {
        let built = ["target/", "node_modules/"].iter().any(|folder| command[0].contains(folder));
        if !built && !there(&command[0]) && command.len() > 1 {
            return Some("no such script".into());
        }
    }
    let arguments = of_program(command)?;
    Arguments::try_parse_from(&arguments).err().map(|error| error.to_string())
}

#[test]
fn every_command_of_a_page_can_be_given() {
    let mut found = vec![];
    pages(&repository(), &mut found);
    found.sort();
    let (mut of_the_program, mut faults) = (0, vec![]);
    for page in &found {
        for command in commands(&std::fs::read_to_string(page).expect("a page")) {
            of_the_program += usize::from(of_program(&command).is_some());
            if let Some(fault) = fault(&command) {
                faults.push(format!("{}: {}\n{fault}", page.display(), command.join(" ")));
            }
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n\n"));
    assert!(of_the_program > 60, "{of_the_program} commands on {} pages", found.len());
}

#[test]
fn commands_are_split_as_a_shell_splits_them() {
    let split = words("vademecum a 'b c' # no\nx | y -z > out && \"q\"\"r\"\n");
    let wanted: [&[&str]; 5] = [&["vademecum", "a", "b c"], &["x"], &["y", "-z"], &["out"], &["qr"]];
    assert_eq!(split, wanted);
}
