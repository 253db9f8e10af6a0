//! Any bytes, opened and read: no panic, no read past the end, and what a file says of itself holds.
#![no_main]

mod seal;

use libfuzzer_sys::fuzz_target;
use vademecum_format::{Element, File, SectionKind};

fn read(bytes: &[u8]) {
    let Ok(file) = File::parse(bytes) else { return };
    let _ = file.verify_all();
    let others = [SectionKind::CanonicalParts, SectionKind::StrainSizes];
    let others = others.map(|kind| file.section(kind).is_some());
    file.metadata().check(others).expect("checked when it was opened");
    for section in file.sections() {
        let stored = section.stored();
        let start = stored.as_ptr() as usize - bytes.as_ptr() as usize;
        assert!(start + stored.len() <= bytes.len());
        let _ = (section.verify(), section.text(), section.u32s(), section.u64s(), section.f64s());
        if let Ok(numbers) = section.numbers() {
            assert_eq!(numbers.len(), numbers.iter().count());
            assert_eq!(numbers.get(numbers.len()), None);
            assert!(numbers.row(usize::MAX, 2).is_none());
        }
        // A raw section is as long as its shape says; quantised numbers have scales beside them.
        if section.raw().is_ok() && section.element() != Element::U8 {
            let n: u64 = section.shape().iter().product();
            let numbers = n * section.element().size();
            assert!(numbers == stored.len() as u64 || section.element() == Element::I16);
            assert_eq!(section.decoded_length(), stored.len() as u64);
        }
    }
    for kind in SectionKind::ALL {
        assert!(file.section(kind).is_none_or(|section| section.kind() == kind));
    }
}

fuzz_target!(|bytes: &[u8]| {
    read(bytes);
    read(&seal::seal(bytes.to_vec()));
});
