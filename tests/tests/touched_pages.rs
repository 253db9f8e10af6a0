//! A large file is used in part: opening it and taking the first step under a contact touches the pages that needs, and no others.
#![cfg(target_os = "linux")]

use std::os::fd::AsRawFd;
use std::time::Instant;

use vademecum_eval::{Contact, Loads, Mapped, Scene, SceneOptions, State, Status};
use vademecum_format::SectionKind;
use vademecum_tests::large;

const PAGE: usize = 4096;

/// Whether each page of the bytes of a map is in memory.
#[allow(unsafe_code)]
fn resident(bytes: &[u8]) -> Vec<bool> {
    let mut pages = vec![0u8; bytes.len().div_ceil(PAGE)];
    let start = bytes.as_ptr().cast_mut().cast();
    // SAFETY: `start` is the first byte of a map (page-aligned), its length is that of the slice, and there is a byte for every page.
    let code = unsafe { libc::mincore(start, bytes.len(), pages.as_mut_ptr()) };
    assert_eq!(code, 0, "mincore: {}", std::io::Error::last_os_error());
    pages.iter().map(|page| page & 1 == 1).collect()
}

/// Writes the bytes to the disk and lets the system forget them.
#[allow(unsafe_code)]
fn write_cold(path: &std::path::Path, bytes: &[u8]) {
    std::fs::write(path, bytes).expect("written");
    let file = std::fs::File::open(path).expect("there");
    file.sync_all().expect("on the disk");
    // SAFETY: a plain call on a descriptor that is open.
    let code = unsafe { libc::posix_fadvise(file.as_raw_fd(), 0, 0, libc::POSIX_FADV_DONTNEED) };
    assert_eq!(code, 0);
}

/// Opens, binds and takes one step under a contact on the first nodes.
fn first_step(mapped: &Mapped) {
    let file = mapped.file().expect("a file");
    let options = SceneOptions::default();
    let sizes = Scene::<f32>::sizes(&file, &options).expect("options");
    let (mut memory, mut work) = (vec![0.0; sizes.scene], vec![0.0; sizes.work]);
    let (mut state, mut loads) = (vec![0.0; sizes.state], vec![0.0; sizes.loads]);
    let scene = Scene::bind(&file, &options, &mut memory, &mut work).expect("bound");
    let mut state = State::new(&scene, &mut state).expect("state memory");
    let mut loads = Loads::new(&scene, &mut loads).expect("load memory");
    let contact = Contact { nodes: [0, 1, 40], weights: [0.2, 0.5, 0.3], force: [1.0, -2.0, 0.5] };
    loads.add_contact(&scene, &contact).expect("a contact");
    assert_eq!(scene.step(&mut state, &loads), Ok(Status::Moving));
}

#[test]
fn the_first_step_touches_only_the_pages_it_needs() {
    // Beside the build's own files: a folder in memory would never be cold.
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a folder");
    let path = folder.path().join("large.vdm");
    let bytes = large::file();
    assert!(bytes.len() > 100_000_000);
    write_cold(&path, &bytes);
    let mapped = Mapped::open(&path).expect("mapped");
    let before = resident(mapped.bytes()).iter().filter(|&&page| page).count();
    assert_eq!(before, 0, "the system kept pages of a file it was told to forget");

    first_step(&mapped);
    let pages = resident(mapped.bytes());
    let touched = pages.iter().filter(|&&page| page).count();
    // The system reads ahead, by a window of its own choice, so what counts is the places: the front of the file, the seam behind each of the five
    // sections (zeros between them are checked), eigenvalues, rows of the surface at three nodes. Neighbours may run together.
    let places = pages.windows(2).filter(|pair| !pair[0] && pair[1]).count() + usize::from(pages[0]);
    assert!(0 < places && places <= 10, "{places} places");
    assert!(touched <= pages.len() / 10, "{touched} of {} pages", pages.len());
    // The inside of the body is read by nobody; 4 MB at its ends for what is read ahead from its seams.
    let file = mapped.file().expect("a file");
    let interior = file.section(SectionKind::InteriorBasis).expect("there").stored();
    let start = (interior.as_ptr() as usize - mapped.bytes().as_ptr() as usize) / PAGE;
    let end = start + interior.len() / PAGE;
    assert_eq!(pages[start + 1024..end - 1024].iter().filter(|&&page| page).count(), 0);

    let mut times: Vec<f64> = (0..21)
        .map(|_| {
            let start = Instant::now();
            first_step(&Mapped::open(&path).expect("mapped"));
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!(
        "{touched} of {} pages; open, bind and step, warm: {:.0} µs (median)",
        pages.len(),
        1e6 * times[10]
    );
    // The goal is 1 ms; the least of 21 runs is what the work costs when nobody else takes the processor.
    assert!(times[0] <= 1e-3, "{} s", times[0]);
}
