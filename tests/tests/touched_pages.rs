//! A large file is used in part: opening it and taking the first step under a contact reads the pages that
//! needs, and no others.
//!
//! The test takes away the right to read the mapped file. The first read of each page then faults; the
//! handler notes the page and gives the right back. So the test counts what the code reads, whatever the
//! system caches or reads ahead and however fast the disk is.
#![cfg(target_os = "linux")]

use std::collections::BTreeSet;
use std::ops::Range;
use std::os::fd::AsRawFd;
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::time::Instant;

use vademecum_eval::{Contact, Loads, Mapped, OpenError, Place, Scene, SceneOptions, State, Status};
use vademecum_format::{File, SectionKind};
use vademecum_tests::large;

/// Pages whose first read faults: where they start, how long one is, how many there are, and which have been
/// read.
static START: AtomicUsize = AtomicUsize::new(0);
static PAGE: AtomicUsize = AtomicUsize::new(0);
static COUNT: AtomicUsize = AtomicUsize::new(0);
static READ: [AtomicBool; 1 << 15] = [const { AtomicBool::new(false) }; 1 << 15];

/// Notes the page of a fault and lets it be read; a fault elsewhere is a real one and ends the process.
#[allow(unsafe_code)]
extern "C" fn note(_: libc::c_int, info: *mut libc::siginfo_t, _: *mut libc::c_void) {
    let [start, page, count] = [&START, &PAGE, &COUNT].map(|x| x.load(Ordering::SeqCst));
    // SAFETY: the system calls this with a valid record of the fault; `mprotect` is given a page of the map
    // that `trace` holds.
    unsafe {
        let place = ((*info).si_addr() as usize).wrapping_sub(start) / page;
        if place >= count || libc::mprotect((start + place * page) as *mut _, page, libc::PROT_READ) != 0 {
            libc::abort();
        }
        READ[place].store(true, Ordering::SeqCst);
    }
}

/// The pages of the bytes of a map that `work` reads.
#[allow(unsafe_code)]
fn trace(bytes: &[u8], work: impl FnOnce()) -> BTreeSet<usize> {
    // SAFETY: a plain question.
    let page = unsafe { libc::sysconf(libc::_SC_PAGESIZE) } as usize;
    let count = bytes.len().div_ceil(page);
    assert!(count <= READ.len());
    START.store(bytes.as_ptr() as usize, Ordering::SeqCst);
    PAGE.store(page, Ordering::SeqCst);
    COUNT.store(count, Ordering::SeqCst);
    // SAFETY: the action is filled in whole before it is installed. The bytes are a map of whole pages that
    // nobody else uses (this file has one test); they can be read again after the first fault on each page,
    // and all of them before this function returns.
    unsafe {
        let mut action: libc::sigaction = std::mem::zeroed();
        action.sa_sigaction = note as *const () as usize;
        action.sa_flags = libc::SA_SIGINFO | libc::SA_ONSTACK;
        let mut before: libc::sigaction = std::mem::zeroed();
        assert_eq!(libc::sigaction(libc::SIGSEGV, &action, &mut before), 0);
        assert_eq!(libc::mprotect(bytes.as_ptr() as *mut _, bytes.len(), libc::PROT_NONE), 0);
        work();
        assert_eq!(libc::mprotect(bytes.as_ptr() as *mut _, bytes.len(), libc::PROT_READ), 0);
        assert_eq!(libc::sigaction(libc::SIGSEGV, &before, std::ptr::null_mut()), 0);
    }
    (0..count).filter(|&place| READ[place].load(Ordering::SeqCst)).collect()
}

/// How many pages of the bytes of a map are in memory.
#[allow(unsafe_code)]
fn resident(bytes: &[u8]) -> usize {
    let mut pages = vec![0u8; bytes.len().div_ceil(4096)];
    let start = bytes.as_ptr().cast_mut().cast();
    // SAFETY: `start` is the first byte of a map (page-aligned), its length is that of the slice, and there
    // is a byte for every page of 4096 bytes or more.
    let code = unsafe { libc::mincore(start, bytes.len(), pages.as_mut_ptr()) };
    assert_eq!(code, 0, "mincore: {}", std::io::Error::last_os_error());
    pages.iter().filter(|&page| page & 1 == 1).count()
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

/// Nodes of the contact.
const NODES: [u32; 3] = [0, 1, 40];

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
    let contact = Contact::new(Place::triangle(NODES, [0.2, 0.5, 0.3]), [1.0, -2.0, 0.5]);
    loads.add_contact(&scene, &contact).expect("a contact");
    assert_eq!(scene.step(&mut state, &loads), Ok(Status::Moving));
}

/// Where the bytes lie that opening and the first step need: the front of the file, the zeros behind each
/// section, the eigenvalues, and the rows of the surface at the nodes of the contact.
fn needed(file: &File<'_>) -> Vec<Range<usize>> {
    let origin = file.bytes().as_ptr() as usize;
    let place =
        |stored: &[u8]| stored.as_ptr() as usize - origin..stored.as_ptr() as usize - origin + stored.len();
    let mut sections: Vec<_> = file.sections().map(|s| place(s.stored())).collect();
    sections.sort_by_key(|s| s.start);
    let mut ranges: Vec<_> = sections.windows(2).map(|pair| pair[0].end..pair[1].start).collect();
    ranges.push(0..sections[0].start);
    ranges.push(place(file.section(SectionKind::Eigenvalues).expect("there").stored()));
    let surface = place(file.section(SectionKind::SurfaceBasis).expect("there").stored()).start;
    let row = 3 * large::LAYOUT.r * 8;
    ranges.extend(NODES.map(|node| surface + node as usize * row..surface + (node as usize + 1) * row));
    ranges
}

#[allow(unsafe_code)]
fn map(path: &Path) -> Result<Mapped, OpenError> {
    // SAFETY: the files of these tests lie in folders of their own and are replaced by renaming only.
    unsafe { Mapped::map(path) }
}

#[test]
fn a_mapped_file_is_the_file_also_when_another_is_renamed_over_it() {
    let folder = tempfile::tempdir().expect("a folder");
    let [path, newer] = ["body.vdm", "newer.vdm"].map(|name| folder.path().join(name));
    let (_, bytes) = vademecum_tests::golden::all().swap_remove(0);
    std::fs::write(&path, &bytes).expect("written");
    let mapped = map(&path).expect("mapped");
    assert_eq!(mapped.bytes(), bytes);
    std::fs::write(&newer, b"newer").expect("written");
    std::fs::rename(&newer, &path).expect("renamed");
    assert_eq!(mapped.bytes(), bytes);
    mapped.file().expect("a file").verify_all().expect("whole");
    let missing = map(&folder.path().join("none.vdm")).expect_err("missing");
    assert!(std::error::Error::source(&missing).is_some());
}

#[test]
fn the_first_step_reads_only_the_pages_it_needs() {
    // Beside the build's own files: a folder in memory would never be cold.
    let folder = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).expect("a folder");
    let path = folder.path().join("large.vdm");
    let bytes = large::file();
    assert!(bytes.len() > 100_000_000);
    write_cold(&path, &bytes);
    let mapped = map(&path).expect("mapped");
    first_step(&mapped);
    let brought_in = resident(mapped.bytes());

    let read = trace(mapped.bytes(), || first_step(&mapped));
    let page = PAGE.load(Ordering::SeqCst);
    let pages = |range: &Range<usize>| range.start / page..range.end.div_ceil(page);
    let needed: BTreeSet<usize> =
        needed(&mapped.file().expect("a file")).iter().filter(|r| !r.is_empty()).flat_map(pages).collect();
    assert_eq!(read, needed, "pages of {page} bytes that were read, and those that are needed");

    // For the record only: what the system brings in from a cold disk, and the time, are the machine's.
    let mut times: Vec<f64> = (0..21)
        .map(|_| {
            let start = Instant::now();
            first_step(&map(&path).expect("mapped"));
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!(
        "{} of {} pages read, {brought_in} brought in from a cold disk; open, bind and step, warm: {:.0} µs \
         (median)",
        read.len(),
        mapped.bytes().len().div_ceil(page),
        1e6 * times[10]
    );
}
