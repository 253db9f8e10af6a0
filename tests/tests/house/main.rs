//! The house: what holds for the sources and documents themselves, read from the files.

mod circles;
mod code;
mod modules;
mod names;
mod prose;
mod sources;

use std::collections::BTreeMap;

use code::{Word, lines_of, words};
use modules::Graph;
use sources::{files, none, product, read};
use vademecum_tests::program::repository;

/// Two files of one room that use each other, and why that is meant: crate, files below its `src`, reason.
/// Everything else must be free of circles once these uses are left out, so a circle of three files cannot be
/// excused.
const PAIRS: [(&str, [&str; 2], &str); 2] = [
    (
        "study",
        ["player/chapter.rs", "player/mod.rs"],
        "the player has a second kind of scene in a file of its own",
    ),
    (
        "format",
        ["chapter.rs", "read.rs"],
        "a file is opened only if the chapter's tables fit; they are read of a file",
    ),
];

fn crates() -> Vec<String> {
    let entries = std::fs::read_dir(repository().join("crates")).expect("crates");
    let name = |entry: std::io::Result<std::fs::DirEntry>| entry.expect("an entry").file_name();
    let mut found: Vec<String> = entries.map(|e| name(e).to_string_lossy().into_owned()).collect();
    found.sort();
    found
}

fn graph(name: &str) -> Graph {
    modules::graph(&repository().join(format!("crates/{name}/src")))
}

/// The listed pairs of a crate.
fn pairs(name: &str) -> Vec<[&'static str; 2]> {
    let name = name.trim_start_matches("vademecum-");
    PAIRS.iter().filter(|(of, ..)| *of == name).map(|(_, pair, _)| *pair).collect()
}

fn no_circles(name: &str) {
    let rest = graph(name).without(&pairs(name));
    assert!(rest.uses.len() > 1, "{name}: the reading of modules is broken");
    let circles: Vec<String> =
        rest.circles().iter().map(|c| format!("{name}: {}\n{}", c.join(", "), rest.lines(c))).collect();
    none("files that use each other", &circles);
}

#[test]
fn the_builder_has_no_circles_of_files() {
    no_circles("vademecum-build");
}

#[test]
fn the_evaluator_has_no_circles_of_files() {
    no_circles("vademecum-eval");
}

#[test]
fn the_format_has_no_circles_of_files() {
    no_circles("vademecum-format");
}

#[test]
fn no_other_crate_has_circles_of_files() {
    let own = ["vademecum-build", "vademecum-eval", "vademecum-format"];
    crates().iter().filter(|name| !own.contains(&name.as_str())).for_each(|name| no_circles(name));
}

#[test]
fn the_rooms_of_the_builder_have_no_circles() {
    let rooms = graph("vademecum-build").rooms();
    assert!(rooms.uses.len() > 10, "the reading of modules is broken");
    let circles: Vec<String> =
        rooms.circles().iter().map(|c| format!("{}\n{}", c.join(", "), rooms.lines(c))).collect();
    none("rooms that use each other", &circles);
}

#[test]
fn every_listed_pair_is_one() {
    let graphs: BTreeMap<String, Graph> =
        crates().into_iter().map(|name| (name.clone(), graph(&name))).collect();
    let stale = |(name, pair, _): &&(&str, [&str; 2], &str)| {
        !graphs.get(&format!("vademecum-{name}")).is_some_and(|graph| graph.is_pair(*pair))
    };
    let stale: Vec<String> =
        PAIRS.iter().filter(stale).map(|(name, [a, b], _)| format!("{name}: {a}, {b}")).collect();
    none("pairs on the list that do not use each other", &stale);
}

/// The builder looks at what it made through the evaluator, on encoded bytes; nobody below knows who is
/// above.
#[test]
fn crates_know_only_what_is_below_them() {
    let known: [(&str, &[&str]); 10] = [
        ("format", &[]),
        ("eval", &["format"]),
        ("rewrite", &["format"]),
        ("web", &["format", "eval"]),
        ("build", &["format", "eval"]),
        ("deck", &["build"]),
        ("chapter", &["format", "eval", "build"]),
        ("study", &["format", "eval", "rewrite", "build", "chapter"]),
        ("cli", &["format", "eval", "rewrite", "build", "deck", "chapter", "study"]),
        ("lab", &["format", "eval", "rewrite", "build", "chapter", "study", "cli"]),
    ];
    for (name, below) in known {
        let manifest = manifest(&format!("crates/vademecum-{name}"));
        let uses = |other: &str| manifest.contains(&format!("vademecum-{other}"));
        let others = known.map(|(other, _)| other).into_iter().filter(|other| *other != name);
        let strangers: Vec<&str> = others.filter(|other| uses(other) && !below.contains(other)).collect();
        assert!(strangers.is_empty(), "{name} depends on {strangers:?}");
    }
}

/// A manifest without its comments.
fn manifest(folder: &str) -> String {
    let text = read(&format!("{folder}/Cargo.toml"));
    text.lines().map(|line| line.split('#').next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// `unsafe` in what is not the product: what these tests do cannot be done without.
const UNSAFE_TESTS: [(&str, &str); 15] = [
    ("crates/vademecum-fmu/tests/host/calls.rs", "a master that calls from the other side"),
    ("crates/vademecum-fmu/tests/host/arrays.rs", "the same"),
    ("crates/vademecum-fmu/tests/host/derivatives.rs", "the same"),
    ("crates/vademecum-fmu/tests/host/early_return.rs", "the same"),
    ("crates/vademecum-fmu/tests/host/numbers.rs", "the same"),
    ("crates/vademecum-fmu/tests/host/parameters.rs", "the same"),
    ("crates/vademecum-fmu/tests/host/states.rs", "the same"),
    ("crates/vademecum-fmu/tests/host/unit.rs", "the same"),
    ("examples/firmware/src/board.rs", "registers of a processor and semihosting"),
    ("examples/firmware/src/main.rs", "the section of flash that the file lies in"),
    ("examples/godot/src/node.rs", "the declaration of an extension of Godot"),
    ("tests/bare-metal/src/lib.rs", "the boundary of a library for C"),
    ("tests/src/denormals.rs", "the processor's flags"),
    ("tests/tests/no_heap.rs", "an allocator that counts"),
    ("tests/tests/touched_pages.rs", "a handler of faults"),
];

#[test]
fn unsafe_is_where_contributing_says() {
    let page = read("CONTRIBUTING.md");
    let section = page.split("## Unsafe code\n").nth(1).expect("the section of unsafe code");
    let section = section.split("\n## ").next().expect("its end");
    let mut listed: Vec<String> = section
        .split('`')
        .skip(1)
        .step_by(2)
        .filter(|word| word.ends_with(".rs"))
        .map(String::from)
        .collect();
    listed.extend(UNSAFE_TESTS.map(|(path, _)| path.to_string()));
    listed.sort();
    let mut found = files("rs");
    found.retain(|source| !lines_of(&words(&source.path, &source.text), &["unsafe"]).is_empty());
    let found: Vec<String> = found.into_iter().map(|source| source.path).collect();
    assert_eq!(found, listed, "files with `unsafe`, and those that CONTRIBUTING.md and this test list");
}

const BROWSER_MODULE: &str = "crates/vademecum-cli/assets/evaluator.wasm";
/// The size that the browser module may have, in bytes. It reads every quantity, filters residuals, moves
/// coupled modes together and shares contacts over facets, in both precisions, and names what it refuses.
/// Live regions take 160 kB of it: the eigenproblem and the file at its modes, both once, and the change of a
/// body and the binding of that file in each precision.
const BROWSER_MODULE_LIMIT: usize = 760_000;
/// The module of worlds: one precision, contacts and joints, and memory of its own.
const WORLD_MODULE: &str = "crates/vademecum-cli/assets/world.wasm";
const WORLD_MODULE_LIMIT: usize = 520_000;

#[test]
fn the_browser_modules_are_small() {
    for (module, limit) in [(BROWSER_MODULE, BROWSER_MODULE_LIMIT), (WORLD_MODULE, WORLD_MODULE_LIMIT)] {
        let size = std::fs::metadata(repository().join(module)).expect("the module").len() as usize;
        assert!(size > 10_000 && size <= limit, "{module}: {size} bytes of at most {limit}");
    }
}

#[test]
fn documents_give_the_size_of_the_browser_module() {
    let [size, world] = [BROWSER_MODULE, WORLD_MODULE]
        .map(|module| std::fs::metadata(repository().join(module)).expect("the module").len() as usize);
    let mut wrong = vec![];
    for page in files("md").iter().filter(|page| !page.path.contains("/records/")) {
        for paragraph in page.text.split("\n\n") {
            let about = page.path.ends_with("decisions/wasm.md")
                || ["evaluator.wasm", "browser module", "WebAssembly"]
                    .iter()
                    .any(|word| paragraph.contains(word));
            // A sentence that names another library gives that library's size.
            let sentences = paragraph.split(". ").filter(|sentence| about && !sentence.contains("three.js"));
            for (number, unit) in sentences.flat_map(sizes) {
                // As many decimals as are given.
                let decimals = number.split_once('.').map_or(0, |(_, decimals)| decimals.len());
                let right = [size, BROWSER_MODULE_LIMIT, world, WORLD_MODULE_LIMIT]
                    .map(|b| format!("{:.decimals$}", b as f64 / unit));
                if !right.contains(&number) {
                    wrong.push(format!("{}: {number} × {unit} bytes; the module has {size}", page.path));
                }
            }
        }
    }
    none("sizes that the browser module does not have", &wrong);
}

/// Numbers before `kB`, `MB` and `bytes`, with the unit in bytes. Blanks and commas may group the digits.
fn sizes(text: &str) -> Vec<(String, f64)> {
    let text = text.replace(['\u{a0}', '\u{202f}', ',', '\n'], " ");
    let units = [(" kB", 1e3), (" KB", 1e3), (" MB", 1e6), (" bytes", 1.0)];
    let before = |end: usize| -> Option<String> {
        let is_number = |c: &char| c.is_ascii_digit() || [' ', '.'].contains(c);
        let digits: String = text[..end].chars().rev().take_while(is_number).filter(|c| *c != ' ').collect();
        let number: String = digits.chars().rev().collect();
        number.parse::<f64>().is_ok().then_some(number)
    };
    let found = |(word, unit): (&'static str, f64)| {
        let places: Vec<usize> = text.match_indices(word).map(|(at, _)| at).collect();
        places.into_iter().filter_map(|end| Some((before(end)?, unit))).collect::<Vec<_>>()
    };
    units.into_iter().flat_map(found).collect()
}

#[test]
fn sizes_are_read_with_their_units() {
    let found = sizes("a module of 291 828 bytes, or 0.3\nMB; kB and 3 modes, 12,5 kB");
    let found: Vec<(&str, f64)> = found.iter().map(|(number, unit)| (number.as_str(), *unit)).collect();
    assert_eq!(found, [("125", 1e3), ("0.3", 1e6), ("291828", 1.0)]);
}

#[test]
fn no_line_is_too_wide() {
    none("lines wider than 110 characters", &prose::wide_lines());
}

#[test]
fn every_link_leads_somewhere() {
    none("links that lead nowhere", &prose::broken_links());
}

const CLI: &str = "crates/vademecum-cli";

/// The sources of the program, in words.
fn cli_words() -> Vec<(String, Vec<Word>)> {
    let mut sources = product();
    sources.retain(|source| source.path.starts_with(CLI));
    assert!(sources.len() > 5);
    sources.into_iter().map(|s| (s.path.clone(), words(&s.path, &s.text))).collect()
}

#[test]
fn the_program_depends_on_no_library_of_numerics() {
    let manifest = manifest(CLI);
    let found =
        ["faer", "rayon", "libm", "wide"].map(|name| (name, manifest.lines().any(|l| l.starts_with(name))));
    let mut found: Vec<String> =
        found.iter().filter(|(_, there)| *there).map(|(name, _)| format!("Cargo.toml: {name}")).collect();
    for (path, words) in cli_words() {
        found.extend(["faer", "rayon"].iter().flat_map(|name| {
            lines_of(&words, &[name])
                .into_iter()
                .map(|line| format!("{path}:{line}: {name}"))
                .collect::<Vec<_>>()
        }));
    }
    none("libraries of numerics in the program", &found);
}

#[test]
fn the_program_steps_no_scene() {
    let found: Vec<String> = cli_words()
        .iter()
        .flat_map(|(path, words)| {
            lines_of(words, &["Scene"]).into_iter().map(move |line| format!("{path}:{line}"))
        })
        .collect();
    none("uses of a scene in the program", &found);
}

/// Functions of numbers that the program may call: file below its `src`, function, what it is for.
const FORMATTING: [(&str, &str, &str); 10] = [
    ("pictures.rs", "powf", "margins of a logarithmic axis"),
    ("pictures/axis.rs", "ln", "places on a logarithmic axis"),
    ("pictures/axis.rs", "log10", "ticks of an axis"),
    ("pictures/axis.rs", "powf", "ticks of an axis"),
    ("pictures/axis.rs", "powi", "ticks of an axis"),
    ("words.rs", "log10", "digits of a printed time"),
    ("words.rs", "powi", "digits of a printed time"),
    ("outline.rs", "sqrt", "the shade of a triangle, the direction of an arrow"),
    ("cmd/report/page.rs", "log10", "digits of a printed ratio"),
    ("cmd/report/page.rs", "powf", "digits of a printed ratio"),
];

#[test]
fn the_program_computes_nothing() {
    let functions = [
        "sqrt", "cbrt", "powi", "powf", "exp", "exp2", "ln", "log2", "log10", "sin", "cos", "tan", "atan2",
        "hypot", "mul_add",
    ];
    let mut found = vec![];
    for (path, words) in cli_words() {
        for function in functions {
            let allowed = |(file, name, _): &(&str, &str, &str)| {
                path.ends_with(&format!("src/{file}")) && *name == function
            };
            if !FORMATTING.iter().any(allowed) {
                let lines = lines_of(&words, &[".", function, "("]);
                found.extend(lines.into_iter().map(|line| format!("{path}:{line}: {function}")));
            }
        }
    }
    none("functions of numbers in the program", &found);
}

#[test]
fn nothing_is_left_undone() {
    let mut found = vec![];
    for source in files("rs") {
        let words = words(&source.path, &source.text);
        for name in ["todo", "unimplemented", "dbg"] {
            let lines = lines_of(&words, &[name, "!"]);
            found.extend(lines.into_iter().map(|line| format!("{}:{line}: {name}!", source.path)));
        }
    }
    none("marks of unfinished code", &found);
}

#[test]
fn an_ignored_test_says_why_and_the_gate_runs_it() {
    let mut without = vec![];
    let mut ignored = 0;
    for source in files("rs") {
        let words = words(&source.path, &source.text);
        without.extend(
            lines_of(&words, &["[", "ignore", "]"]).iter().map(|line| format!("{}:{line}", source.path)),
        );
        ignored += lines_of(&words, &["[", "ignore", "="]).len();
    }
    none("ignored tests without a reason", &without);
    assert!(ignored == 0 || read(".ci/run").contains("-- --ignored"), "the gate runs no ignored test");
}

/// Files where a text of `Debug` alone is made for people or for a key, not for a field of a report.
const DEBUG_TEXTS: [(&str, &str); 5] = [
    ("crates/vademecum-build/src/mesh/select.rs", "an error shows the selection as it was read"),
    ("crates/vademecum-build/src/input/problem/check.rs", "an error shows what was found"),
    ("crates/vademecum-build/src/input/problem/ranges.rs", "an error shows what was found"),
    ("crates/vademecum-build/src/store/inputs.rs", "the key of a stage on disk, all digits of its inputs"),
    ("crates/vademecum-study/src/scenario/check.rs", "an error shows what was found"),
];

#[test]
fn no_debug_text_is_data() {
    let mut found = vec![];
    for source in product().iter().filter(|source| DEBUG_TEXTS.iter().all(|(path, _)| source.path != *path)) {
        let text = source.text.split("#[cfg(test)]").next().unwrap_or_default();
        for (index, line) in text.lines().enumerate() {
            let debug = line.split("format!(\"{").skip(1).any(|rest| {
                let placeholder = rest.split('"').next().unwrap_or_default();
                placeholder.ends_with(":?}") && placeholder.matches('{').count() == 0
            });
            if debug {
                found.push(format!("{}:{}: {}", source.path, index + 1, line.trim()));
            }
        }
    }
    none("fields that are texts of `Debug`", &found);
}

/// What opens, moves or makes a file, in words of a source.
const OPENERS: [&[&str]; 16] = [
    &["fs", ":", ":", "write"],
    &["fs", ":", ":", "rename"],
    &["fs", ":", ":", "copy"],
    &["fs", ":", ":", "hard_link"],
    &["File", ":", ":", "create"],
    &["File", ":", ":", "create_new"],
    &["File", ":", ":", "options"],
    &["OpenOptions"],
    &["NamedTempFile"],
    &["tempfile"],
    &["SVGBackend", ":", ":", "new"],
    &["BitMapBackend"],
    &["set_len"],
    &["set_permissions"],
    &["MmapMut"],
    &["mkfifo"],
];

/// Files that open outputs: everything else asks them to, so that no command replaces what it must not.
const OPENING: [&str; 3] = ["disk.rs", "growing.rs", "part.rs"];

#[test]
fn outputs_are_opened_in_one_place() {
    let mut found = vec![];
    let mut in_place = 0;
    for source in product() {
        let text = source.text.split("#[cfg(test)]\nmod tests").next().unwrap_or_default();
        let words = words(&source.path, text);
        let lines = OPENERS.iter().flat_map(|opener| lines_of(&words, opener));
        let name = source.path.strip_prefix("crates/vademecum-build/src/store/");
        if name.is_some_and(|name| OPENING.contains(&name)) {
            in_place += lines.count();
        } else {
            found.extend(lines.map(|line| format!("{}:{line}", source.path)));
        }
    }
    assert!(in_place > 4, "the reading of sources is broken");
    none("outputs that `vademecum_build::store::Outputs` does not open", &found);
}

/// Public type names that stand more than once in their crate: a list that only shrinks.
const DOUBLE_TYPES: [(&str, &str); 0] = [];

#[test]
fn a_public_type_name_stands_once_per_crate() {
    let found = names::double_types();
    let is_listed = |of: &str, name: &str| DOUBLE_TYPES.contains(&(of, name));
    let new: Vec<String> = found
        .iter()
        .filter(|(of, name, _)| !is_listed(of, name))
        .map(|(of, name, files)| format!("{of}: {name} in {}", files.join(", ")))
        .collect();
    none("names of several public types", &new);
    let stale: Vec<String> = DOUBLE_TYPES
        .iter()
        .filter(|(of, name)| !found.iter().any(|(crate_of, known, _)| crate_of == of && known == name))
        .map(|(of, name)| format!("{of}: {name}"))
        .collect();
    none("names on the list that stand once", &stale);
}

/// Largest share of doc comments of a crate that may open with What, How, Whether, Where or That \[%\].
const QUESTION_SHARE: f64 = 3.0;

#[test]
fn doc_comments_begin_with_nouns_and_verbs() {
    let mut found = vec![];
    for (of, share) in names::shares_of_openers() {
        if share > QUESTION_SHARE {
            found.push(format!("{of}: {share:.1} % of at most {QUESTION_SHARE} %"));
        }
    }
    none("crates whose doc comments open with What, How, Whether, Where or That too often", &found);
}

/// Phrases that the pages and comments do not use, and the words of the field or of plain English for them.
const PHRASES: [(&str, &str); 14] = [
    ("static residual", "residual flexibility"),
    ("the odd thing", "note, or nothing"),
    ("could mend", "projection error"),
    ("is told", "is reported, hears"),
    ("are told", "are reported, hear"),
    ("was told", "was reported, heard"),
    ("lets go of", "drops, releases"),
    ("whom to tell", "callback"),
    ("nobody knows", "unknown"),
    ("is let go in", "is relaxed"),
    ("made anew", "made again"),
    ("states of least energy", "static equilibria"),
    ("asked of the network", "network requests"),
    ("the answer of the body to", "response"),
];

#[test]
fn pages_and_comments_use_plain_words() {
    none("phrases with a plainer word", &prose::phrases(&PHRASES));
}
