//! What happens to programs and files: kills, damage, full disks, little memory, spoilt texts, odd inputs.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use super::dice::Dice;
use super::invariant::{
    Breach, CODES, Held, ended_well, ended_well_in, nothing_left, old_or_new, refused_by_name, same_bytes,
    whole_table,
};
use super::launch::{Launch, Signal};
use super::life::Done;
use super::place::{Built, Place};
use super::texts;
use crate::hostile::{put, reseal, u32_at};
use crate::program::fixtures;

/// A file that was there before: of the kind that the program may replace.
const OLD: &[u8] = b"\x89VDM\r\n\x1a\nan old file";

/// A command that writes `out.vdm`, and how long it takes.
struct Writer {
    line: String,
    new: Vec<u8>,
    seconds: f64,
}

impl Writer {
    /// One of the commands that make a file, and what it makes, `folder` being where.
    fn draw(place: &Place<'_>, dice: &mut Dice, built: &Built) -> Result<Self, Breach> {
        let keep = if built.kept { "" } else { " --keep-missed" };
        let line = match dice.below(4) {
            0 => format!("build p.toml{keep} -o "),
            1 => format!("pack a.vdm --level {} -o ", dice.whole(1, 22)),
            2 => format!("strip a.vdm --keep {} -o ", dice.pick(&["probes", "surface", "all"])),
            _ => "pack a.vdm --tolerance 1e-3 -o ".to_string(),
        };
        let ended = place.ends(&format!("{line}whole.vdm"), &[0, 7])?;
        let new = place.read("whole.vdm").filter(|_| ended.code == Some(0));
        Ok(Self { line, new: new.unwrap_or_default(), seconds: ended.seconds })
    }

    fn refused(&self) -> bool {
        self.new.is_empty()
    }

    fn launch(&self, output: &str, limit: Duration) -> Launch {
        Launch::new(&format!("{}{output}", self.line).split(' ').collect::<Vec<_>>(), limit)
    }
}

/// Killed at any instant, a command leaves the old file or the new one, and the next run ends as if nothing
/// had been.
///
/// # Errors
/// [`Breach`].
pub fn killed(place: &Place<'_>, dice: &mut Dice) -> Done {
    let Some(built) = place.build(dice)? else { return Ok("refused") };
    if dice.once_in(3) {
        return killed_run(place, dice, &built);
    }
    let writer = Writer::draw(place, dice, &built)?;
    if writer.refused() {
        return Ok("refused");
    }
    let mut old = dice.once_in(2).then(|| OLD.to_vec());
    old.iter().for_each(|bytes| place.write("out.vdm", bytes));
    for _ in 0..3 {
        let mut launch = writer.launch("out.vdm", place.limit);
        launch.kill = Some(instant(dice, writer.seconds));
        ended_well(&place.launch(&launch), &[0])?;
        let found = place.read("out.vdm");
        old_or_new(found.as_deref(), old.as_deref(), &writer.new)?;
        old = found;
    }
    ended_well(&place.launch(&writer.launch("out.vdm", place.limit)), &[0])?;
    same_bytes("after kills and without", &place.read("out.vdm").unwrap_or_default(), &writer.new)?;
    place.left_nothing()?;
    Ok("done")
}

/// When a run of so many seconds is killed, and how.
fn instant(dice: &mut Dice, seconds: f64) -> (Duration, Signal) {
    (Duration::from_secs_f64(dice.between(0.0, 1.2) * seconds), *dice.pick(&Signal::ALL))
}

fn killed_run(place: &Place<'_>, dice: &mut Dice, built: &Built) -> Done {
    let (text, _) = texts::scenario(dice, &built.problem, 20_000);
    place.write("s.toml", text);
    let whole = place.ends("run a.vdm --scenario s.toml -o whole", &[0, 3, 5, 7])?;
    if whole.code != Some(0) {
        return Ok("refused");
    }
    let line: Vec<&str> = "run a.vdm --scenario s.toml -o out".split(' ').collect();
    for _ in 0..3 {
        let mut launch = Launch::new(&line, place.limit);
        launch.kill = Some(instant(dice, whole.seconds));
        ended_well(&place.launch(&launch), &[0])?;
        if let Some(table) = place.read("out/probes.csv") {
            whole_table(&String::from_utf8_lossy(&table), None)?;
        }
    }
    ended_well(&place.launch(&Launch::new(&line, place.limit)), &[0])?;
    let entries = std::fs::read_dir(place.path("whole")).into_iter().flatten().flatten();
    for name in entries.map(|entry| entry.file_name().to_string_lossy().into_owned()) {
        let [one, other] = ["whole", "out"].map(|f| place.read(&format!("{f}/{name}")).unwrap_or_default());
        same_bytes("a run after kills and one without", &one, &other)?;
    }
    place.left_nothing()?;
    Ok("done")
}

/// A file that was cut or has other bits is refused by name; one whose checksums were corrected gives finite
/// results or an error.
///
/// # Errors
/// [`Breach`].
pub fn damaged(place: &Place<'_>, dice: &mut Dice) -> Done {
    let Some(built) = place.build(dice)? else { return Ok("refused") };
    let (scenario, _) = texts::scenario(dice, &built.problem, 20);
    place.write("s.toml", scenario);
    let packed = dice.once_in(3) && place.ends("pack a.vdm -o p.vdm --level 3", &[0])?.code == Some(0);
    let whole = if packed { place.read("p.vdm").unwrap_or_default() } else { built.bytes };
    for _ in 0..3 {
        let cut = match dice.once_in(3) {
            true => whole[..dice.below(whole.len())].to_vec(),
            false => texts::flipped(dice, whole.clone()),
        };
        if cut == whole {
            continue;
        }
        place.write("damaged.vdm", cut);
        let lines =
            ["verify damaged.vdm --file-only", "info damaged.vdm", "run damaged.vdm --scenario s.toml"];
        for line in lines.into_iter().chain(["unpack damaged.vdm -o u.vdm", "pack damaged.vdm -o q.vdm"]) {
            refused_by_name(&place.run(line), &[7], "damaged.vdm")?;
        }
    }
    for _ in 0..3 {
        place.write("edited.vdm", edited(dice, whole.clone()));
        place.ends("verify edited.vdm --file-only", &[0, 7])?;
        place.ends("info edited.vdm --json", &[0, 7])?;
        let ran = place.ends("run edited.vdm --scenario s.toml -o edited", &[0, 3, 5, 7])?;
        if ran.code == Some(0) {
            let table = place.read("edited/probes.csv").unwrap_or_default();
            whole_table(&String::from_utf8_lossy(&table), None)?;
        }
        for line in ["pack edited.vdm -o q.vdm --tolerance 1e-3", "strip edited.vdm -o q.vdm --keep probes"] {
            place.ends(line, &[0, 7])?;
        }
    }
    Ok("done")
}

/// One to three sections with other content, every checksum right.
fn edited(dice: &mut Dice, mut bytes: Vec<u8>) -> Vec<u8> {
    const NUMBERS: [f64; 8] = [f64::NAN, f64::INFINITY, 1e308, -1.0, 0.0, 1e-308, 1e30, -1e30];
    let sections = u32_at(&bytes, 12) as usize;
    for _ in 0..dice.whole(1, 3) {
        let entry = 64 * dice.whole(1, sections);
        let (offset, length) = (u32_at(&bytes, entry + 32) as usize, u32_at(&bytes, entry + 40) as usize);
        if length >= 8 {
            let at = offset + 8 * dice.below(length / 8);
            match dice.below(3) {
                0 => put(&mut bytes, at, &dice.pick(&NUMBERS).to_le_bytes()),
                1 => put(&mut bytes, at, &(*dice.pick(&NUMBERS) as f32).to_le_bytes()),
                _ => bytes[at] ^= 1 << dice.below(8),
            }
        }
        let checksum = crc32fast::hash(&bytes[offset..offset + length]);
        put(&mut bytes, entry + 56, &checksum.to_le_bytes());
    }
    if dice.once_in(4) {
        // A number of header, directory or metadata.
        let front = 64 * (2 + sections) + 256;
        let at = dice.below(front.min(bytes.len()));
        bytes[at] ^= 1 << dice.below(8);
        // The counts say where the checksums stand: an edit of those cannot be corrected.
        if u32_at(&bytes, 12) as usize == sections && (u32_at(&bytes, 32) as usize) < bytes.len() {
            return reseal(bytes);
        }
    }
    bytes
}

/// A file system in memory, gone when it is dropped.
struct Disk(PathBuf);

impl Disk {
    /// None where we may not mount one.
    fn mount(path: &Path, kib: usize) -> Option<Self> {
        std::fs::create_dir_all(path).ok()?;
        let size = format!("size={kib}k");
        let mounted =
            Command::new("mount").args(["-t", "tmpfs", "-o", &size, "none"]).arg(path).output().ok()?;
        mounted.status.success().then(|| Self(path.into()))
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        // What cannot be unmounted is said by the folder that cannot be removed.
        let _ = Command::new("umount").arg(&self.0).output();
    }
}

/// On a full disk a command says so, and the old file stays.
///
/// # Errors
/// [`Breach`].
pub fn full_disk(place: &Place<'_>, dice: &mut Dice) -> Done {
    let Some(built) = place.build(dice)? else { return Ok("refused") };
    let writer = Writer::draw(place, dice, &built)?;
    if writer.refused() {
        return Ok("refused");
    }
    let kib = dice.whole(4, 4 + 2 * writer.new.len() / 1024);
    let Some(disk) = Disk::mount(&place.path("disk"), kib) else { return Ok("skipped: may not mount") };
    let old = dice.once_in(2).then(|| OLD.to_vec());
    old.iter().for_each(|bytes| place.write("disk/out.vdm", bytes));
    let ended = place.launch(&writer.launch("disk/out.vdm", place.limit));
    ended_well(&ended, &[0, 1])?;
    let found = place.read("disk/out.vdm");
    old_or_new(found.as_deref(), old.as_deref(), &writer.new)?;
    nothing_left(&disk.0)?;
    if !built.problem.canonical {
        place.write("s.toml", format!("duration = {:?}\n", 5000.0 * built.problem.step));
        let ran = place.ends("run a.vdm --scenario s.toml -o disk/out", &[0, 1])?;
        if let (Some(0), Some(table)) = (ran.code, place.read("disk/out/probes.csv")) {
            whole_table(&String::from_utf8_lossy(&table), Some(5001))?;
        }
        nothing_left(&disk.0)?;
    }
    Ok("done")
}

/// With little memory a command ends by its code, or by an allocation that the system refused; the old file
/// stays. What asks for more at once than there is must be refused before.
///
/// # Errors
/// [`Breach`].
pub fn little_memory(place: &Place<'_>, dice: &mut Dice) -> Done {
    let limited = |mut launch: Launch, kib: u64| {
        launch.memory_kib = Some(kib);
        place.launch(&launch)
    };
    if dice.once_in(3) {
        let kib = dice.whole(1 << 20, 2 << 20) as u64;
        let huge = dice.pick(&["[400, 400, 400]", "[1000000, 1000000, 1000000]", "[3000, 3000, 1]"]);
        place.write("p.toml", texts::problem(dice).text);
        let text = format!(
            "[mesh]\nblock = {{ lengths = [1.0, 0.1, 0.1], divisions = {huge} }}\n[[material]]\nyoung = 1e9\n\
             poisson = 0.3\ndensity = 1e3\n[[support]]\non = {{ group = \"x_min\" }}\n[load]\n[time]\nscheme.name = \"bathe\"\nstep = 1e-3\n"
        );
        place.write("p.toml", text);
        let mut launch = Launch::new(&["build", "p.toml", "-o", "a.vdm"], place.limit);
        launch.kill = Some((place.limit / 2, Signal::Interrupt));
        ended_well_in(&limited(launch, kib), &[1, 3, 4, 5], kib << 10)?;
        return Ok("done");
    }
    let Some(built) = place.build(dice)? else { return Ok("refused") };
    let writer = Writer::draw(place, dice, &built)?;
    if writer.refused() {
        return Ok("refused");
    }
    place.write("out.vdm", OLD);
    let kib = dice.log(96.0 * 1024.0, 1024.0 * 1024.0) as u64;
    let ended = limited(writer.launch("out.vdm", place.limit), kib);
    ended_well_in(&ended, &CODES, kib << 10)?;
    old_or_new(place.read("out.vdm").as_deref(), Some(OLD), &writer.new)?;
    Ok(if ended.code == Some(0) { "done" } else { "out of memory" })
}

/// Texts with something wrong are refused, or mean something else and are built.
///
/// # Errors
/// [`Breach`].
pub fn mutated(place: &Place<'_>, dice: &mut Dice) -> Done {
    let polite = |line: &str| {
        let mut launch = Launch::new(&line.split(' ').collect::<Vec<_>>(), place.limit);
        // What was asked for may take for ever; it must end when it is asked to.
        launch.kill = Some((place.limit / 2, Signal::Interrupt));
        launch.memory_kib = Some(4 << 20);
        place.launch(&launch)
    };
    let held = |ended: &super::launch::Ended, codes: &[i32]| ended_well_in(ended, codes, 4 << 30);
    match dice.below(3) {
        0 => {
            let problem = texts::problem(dice);
            place.write("p.toml", texts::mutated(dice, problem.text.as_bytes()));
            let ended = polite("build p.toml -o a.vdm --keep-missed");
            held(&ended, &CODES)?;
            if ended.code == Some(0) {
                place.ends("verify a.vdm --file-only", &[0])?;
            }
        }
        1 => {
            let Some(built) = place.build(dice)? else { return Ok("refused") };
            let (text, _) = texts::scenario(dice, &built.problem, 50);
            place.write("s.toml", texts::mutated(dice, text.as_bytes()));
            let ended = polite("run a.vdm --scenario s.toml -o out");
            held(&ended, &CODES)?;
            if let (Some(0), Some(table)) = (ended.code, place.read("out/probes.csv")) {
                whole_table(&String::from_utf8_lossy(&table), None)?;
            }
        }
        _ => {
            let meshes = fixtures("meshes/bar");
            let (name, bytes) = dice.pick(&meshes);
            // Both files of a pair are needed; the other one stays as it was.
            for (other, whole) in meshes.iter().filter(|(other, _)| other.starts_with("tetgen.")) {
                place.write(other, whole);
            }
            place.write(name, texts::mutated(dice, bytes));
            held(&polite(&format!("mesh {name}")), &[0, 4])?;
            let problem = texts::problem(dice).text;
            let from = problem.find("[mesh]").unwrap_or(0);
            let to = from + problem[from..].find("[[material]]").unwrap_or(0);
            let text = [&problem[..from], "[mesh]\nfile = \"", name, "\"\n", &problem[to..]].concat();
            place.write("p.toml", text);
            held(&polite("build p.toml -o a.vdm --keep-missed"), &CODES)?;
        }
    }
    place.left_nothing()?;
    Ok("done")
}

/// What is no regular file is refused by name at every input, and nobody waits.
///
/// # Errors
/// [`Breach`].
pub fn odd_inputs(place: &Place<'_>, dice: &mut Dice) -> Done {
    let Some(built) = place.build(dice)? else { return Ok("refused") };
    place.write("s.toml", format!("duration = {:?}\n", built.problem.step));
    let _ = std::fs::create_dir(place.path("folder"));
    let _ = Command::new("mkfifo").arg(place.path("fifo")).status();
    let _socket = std::os::unix::net::UnixListener::bind(place.path("socket"));
    let odd = *dice.pick(&["/dev/zero", "/dev/random", "fifo", "folder", "socket"]);
    let table = "[load]\n[time]\nscheme.name = \"bathe\"\nstep = 1e-3\n";
    let material = "[[material]]\nyoung = 1e9\npoisson = 0.3\ndensity = 1e3\n";
    let block = "[mesh]\nblock = { lengths = [1.0, 1.0, 1.0], divisions = [1, 1, 1] }\n\
                 [[support]]\non = { group = \"x_min\" }\n";
    let problems = [
        format!("[mesh]\nfile = \"{odd}\"\n{material}{table}"),
        format!(
            "[mesh]\ntables = {{ coordinates = \"{odd}\", connectivity = \"{odd}\" }}\n{material}{table}"
        ),
        format!("[mesh.matrices]\nmass = \"{odd}\"\nstiffness = \"{odd}\"\ndofs = \"{odd}\"\n{table}"),
        format!("{block}{material}{table}[snapshots]\nnpy = \"{odd}\"\n"),
        format!("{block}{material}{table}[snapshots]\nvtu = [\"{odd}\"]\n"),
    ];
    for text in problems {
        place.write("odd.toml", text);
        named(place, "build odd.toml -o o.vdm", odd)?;
    }
    for line in ["build ODD -o o.vdm", "mesh ODD", "info ODD", "verify ODD --file-only", "pack ODD -o o.vdm"]
        .into_iter()
        .chain(["run a.vdm --scenario ODD", "run ODD --scenario s.toml", "run ODD --scenario s.toml --copy"])
        .chain(["strip ODD -o o.vdm --keep probes", "unpack ODD -o o.vdm", "report ODD -o r.html"])
    {
        named(place, &line.replace("ODD", odd), odd)?;
    }
    Ok("done")
}

fn named(place: &Place<'_>, line: &str, odd: &str) -> Held {
    let mut launch =
        Launch::new(&line.split(' ').collect::<Vec<_>>(), place.limit.min(Duration::from_secs(10)));
    launch.memory_kib = Some(2 << 20);
    refused_by_name(&place.launch(&launch), &[3, 4, 7], odd)
}
