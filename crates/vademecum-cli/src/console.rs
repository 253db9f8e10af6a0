//! Console: progress on standard error, results on standard output.

use std::io::IsTerminal;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use indicatif::{ProgressBar, ProgressStyle};
use vademecum_build::printable::{printable, shortened};
use vademecum_build::progress::Listener;

/// Set by Ctrl-C; long work polls it and ends without leaving half a file.
static CANCELLED: AtomicBool = AtomicBool::new(false);

/// Set while a file goes to standard output: lines go to standard error.
static ASIDE: AtomicBool = AtomicBool::new(false);

/// Keeps lines out of an output that goes to the pipe or file that standard output is.
#[cfg(unix)]
pub(crate) fn make_way_for(output: &Path) {
    use std::os::fd::AsFd;
    use std::os::unix::fs::{FileTypeExt, MetadataExt};
    let standard = std::io::stdout().as_fd().try_clone_to_owned().map(std::fs::File::from);
    let standard = standard.and_then(|file| file.metadata());
    let found = standard.and_then(|standard| Ok((standard, std::fs::metadata(output)?)));
    let is_same = found.is_ok_and(|(a, b)| {
        (a.dev(), a.ino()) == (b.dev(), b.ino()) && (a.is_file() || a.file_type().is_fifo())
    });
    ASIDE.store(is_same, Ordering::Relaxed);
}

#[cfg(not(unix))]
pub(crate) fn make_way_for(_: &Path) {}

/// Turns Ctrl-C and termination into a polite stop; a second one kills.
pub(crate) fn listen_for_ctrl_c() {
    let result = ctrlc::set_handler(|| {
        if CANCELLED.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
    });
    if let Err(error) = result {
        eprintln!("note: Ctrl-C ends the program at once ({error})");
    }
}

/// Prints a line of results on standard output. A reader that has gone has seen enough: the program ends, in
/// peace; any other failure ends it too, since results that are not shown are not done.
///
/// A line may hold names of others: what a terminal would obey is escaped.
pub fn show(line: std::fmt::Arguments<'_>) {
    use std::io::Write;
    let text = line.to_string();
    let line = printable(&text);
    if ASIDE.load(Ordering::Relaxed) {
        eprintln!("{line}");
    } else if let Err(error) = writeln!(std::io::stdout(), "{line}") {
        if error.kind() == std::io::ErrorKind::BrokenPipe {
            std::process::exit(0);
        }
        eprintln!("error: results cannot be printed: {error}");
        std::process::exit(1);
    }
}

/// Progress of a stage of unknown length.
const UNCOUNTED: &str = "{spinner} {msg} ({elapsed})";
/// Progress of a stage of known length.
const COUNTED: &str = "{spinner} {msg:<28} {wide_bar} {pos}/{len} {eta}";

fn style(template: &str) -> ProgressStyle {
    ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar())
}

/// Prints a line on standard error, with the same escapes. If nobody reads it, there is nobody left to tell.
pub fn tell(line: std::fmt::Arguments<'_>) {
    use std::io::Write;
    let _ = writeln!(std::io::stderr(), "{}", printable(&line.to_string()));
}

/// Progress on standard error: a bar on a terminal, a line per stage elsewhere, nothing with `--quiet`.
pub struct Console {
    bar: Option<ProgressBar>,
    quiet: bool,
}

impl Console {
    /// A console; `quiet` shows nothing but results and errors.
    pub fn new(quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::new(0).with_style(style(UNCOUNTED));
            bar.enable_steady_tick(Duration::from_millis(120));
            bar
        });
        Self { bar, quiet }
    }

    /// Removes the bar.
    pub fn clear(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Listener for Console {
    fn stage(&self, name: &str) {
        match &self.bar {
            Some(bar) => {
                // Nothing is known of its length before it says so: no bar of 0/0.
                bar.set_style(style(UNCOUNTED));
                bar.set_message(printable(name).into_owned());
                bar.reset();
            }
            None if !self.quiet => eprintln!("  {name}"),
            None => {}
        }
    }

    fn advance(&self, done: usize, total: usize) {
        if let Some(bar) = &self.bar {
            if bar.length() != Some(total as u64) || bar.position() == 0 {
                bar.set_style(style(COUNTED));
            }
            bar.set_length(total as u64);
            bar.set_position(done as u64);
        }
    }

    fn note(&self, text: &str) {
        let text = shortened(text);
        match &self.bar {
            Some(bar) => bar.println(format!("  note: {}", printable(&text))),
            None if !self.quiet => eprintln!("  note: {text}"),
            None => {}
        }
    }

    fn cancelled(&self) -> bool {
        CANCELLED.load(Ordering::Relaxed)
    }
}
