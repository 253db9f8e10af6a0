//! Every hostile file gives the refusal of its name, from the library and from the program, and every refusal
//! has its file.

use vademecum_format::{Codec, Decoder, Element, File, FormatError, Section};
use vademecum_rewrite::check;
use vademecum_tests::hostile;
use vademecum_tests::program::{fixtures, repository, vademecum};

/// Number and name of each refusal on the page.
fn page() -> Vec<(u32, String)> {
    let text = std::fs::read_to_string(repository().join("formats/vademecum-1.md")).expect("the page");
    let (_, refusals) = text.split_once("## Refusals").expect("the section");
    let row = |line: &str| {
        let mut cells = line.strip_prefix("| ")?.split(" | ");
        let number = cells.next()?.trim().parse().ok()?;
        Some((number, cells.next()?.trim().to_string()))
    };
    refusals.lines().take_while(|line| !line.starts_with("## ")).filter_map(row).collect()
}

/// Result of a reader that opens the file, verifies it and asks for all its sections.
fn refusal(bytes: &[u8]) -> Option<FormatError> {
    let decoded = |section: &Section<'_>| {
        Decoder::new()?.decode_into(section, &mut vec![0; section.decoded_length() as usize])
    };
    let asked = |section: Section<'_>| match section.element() {
        _ if matches!(section.codec(), Codec::Shuffled | Codec::Delta) => decoded(&section),
        Element::U8 => section.text().map(|_| ()),
        Element::U32 => section.u32s().map(|_| ()),
        Element::U64 => section.u64s().map(|_| ()),
        _ => section.numbers().map(|_| ()),
    };
    let read = || {
        let file = File::parse(bytes)?;
        file.verify_all()?;
        file.sections().try_for_each(asked)
    };
    read().err()
}

/// The first word of an error's `Debug` text: its variant.
fn variant(error: &impl std::fmt::Debug) -> String {
    let text = format!("{error:?}");
    text.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default().to_string()
}

#[test]
fn the_command_beside_them_writes_the_hostile_files() {
    let (known, made) = (fixtures("hostile"), hostile::all());
    let names = |files: &[(String, Vec<u8>)]| files.iter().map(|f| f.0.clone()).collect::<Vec<_>>();
    assert_eq!(names(&known), names(&made));
    for ((name, known), (_, made)) in known.iter().zip(&made) {
        assert!(known == made, "{name} differs: read fixtures/README.md");
    }
    assert!(known.iter().map(|f| f.1.len()).sum::<usize>() <= 400 * 1024);
}

#[test]
fn every_numbered_refusal_has_a_file_that_gives_it_and_nothing_else() {
    let mut given = vec![];
    let page = page();
    assert!(page.len() >= 31, "the page's table is not read: {page:?}");
    for (name, bytes) in fixtures("hostile") {
        let stem = name.strip_suffix(".vdm").expect("a vademecum file");
        let mut parts = stem.split('-');
        let first = parts.next().expect("a name");
        match first.parse::<u32>() {
            Ok(number) => {
                let expected = parts.next().expect("the refusal's name").to_string();
                let error = refusal(&bytes).unwrap_or_else(|| panic!("{name} is not refused"));
                assert_eq!(variant(&error), expected, "{name}: {error}");
                assert!(page.contains(&(number, expected)), "{name} is not a refusal of the page");
                given.push(number);
            }
            Err(_) => {
                let error = check(&bytes).expect_err(&name);
                assert_eq!(variant(&error), first, "{name}: {error}");
                // The contents are wrong, not the file: it opens.
                assert!(File::parse(&bytes).and_then(|file| file.verify_all()).is_ok(), "{name}");
            }
        }
    }
    // Only a writer hears of these.
    const OF_WRITERS: [&str; 1] = ["LentMemory"];
    let missing: Vec<_> =
        page.iter().filter(|row| !given.contains(&row.0) && !OF_WRITERS.contains(&row.1.as_str())).collect();
    assert!(missing.is_empty(), "refusals without a file: {missing:?}");
}

#[test]
fn the_program_refuses_every_hostile_file_and_does_not_stumble() {
    for (name, _) in fixtures("hostile") {
        let path = repository().join("fixtures/hostile").join(&name);
        let ran = vademecum(&["verify".as_ref(), path.as_os_str(), "--file-only".as_ref()]);
        // A compressed file is sound; only its numbers cannot be mapped.
        if name.starts_with("28-") {
            assert_eq!(ran.code, Some(0), "{name}: {}", ran.stderr);
        } else {
            ran.fails(7, &[name.as_str(), "error: "]);
        }
        let opens = !name.starts_with(|c: char| c.is_ascii_digit())
            || name.starts_with("28")
            || ["29", "36", "37"].iter().any(|number| name.starts_with(number));
        let ran = vademecum(&["info".as_ref(), path.as_os_str()]);
        assert!(
            ran.code == Some(7) || (opens && ran.code == Some(0)),
            "{name}: {:?} {}",
            ran.code,
            ran.stderr
        );
    }
}
