//! One run of the program: bounded in time, killed on request, its memory watched.

use std::fs::File;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// A signal that ends a program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Signal {
    /// Ctrl-C.
    Interrupt,
    /// What `kill` sends.
    Terminate,
    /// What cannot be heard.
    Kill,
}

impl Signal {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Interrupt, Self::Terminate, Self::Kill];

    /// Its number.
    #[must_use]
    pub fn number(self) -> i32 {
        match self {
            Self::Interrupt => 2,
            Self::Terminate => 15,
            Self::Kill => 9,
        }
    }
}

/// How a run is started and ended.
#[derive(Clone, Debug)]
pub struct Launch {
    /// Arguments of the program.
    pub arguments: Vec<String>,
    /// A run that takes longer is a finding.
    pub limit: Duration,
    /// A signal, and when it is sent.
    pub kill: Option<(Duration, Signal)>,
    /// Most memory \[KiB\] (`ulimit -v`).
    pub memory_kib: Option<u64>,
    /// Threads of a build.
    pub threads: usize,
}

/// What became of a run.
#[derive(Clone, Debug, Default)]
pub struct Ended {
    /// Exit code; none after a signal.
    pub code: Option<i32>,
    /// The signal it died of.
    pub signal: Option<i32>,
    /// The signal it was sent.
    pub sent: Option<Signal>,
    /// It was ended at the limit.
    pub over_time: bool,
    /// Standard output.
    pub stdout: String,
    /// Standard error.
    pub stderr: String,
    /// How long it ran.
    pub seconds: f64,
    /// Largest memory seen \[KiB\], as the system counts it; looked at every few milliseconds.
    pub peak_kib: u64,
}

/// Between two looks at a run.
const LOOK: Duration = Duration::from_millis(2);

impl Launch {
    /// Of these arguments, with two threads and a limit.
    #[must_use]
    pub fn new(arguments: &[&str], limit: Duration) -> Self {
        let arguments = arguments.iter().map(ToString::to_string).collect();
        Self { arguments, limit, kill: None, memory_kib: None, threads: 2 }
    }

    /// As it would be typed.
    #[must_use]
    pub fn line(&self) -> String {
        let quoted = |word: &String| match word.chars().any(|c| c.is_whitespace()) {
            true => format!("'{word}'"),
            false => word.clone(),
        };
        let mut line = format!("RAYON_NUM_THREADS={} ", self.threads);
        if let Some(kib) = self.memory_kib {
            line += &format!("ulimit -v {kib}; ");
        }
        line += "vademecum ";
        line += &self.arguments.iter().map(quoted).collect::<Vec<_>>().join(" ");
        if let Some((after, signal)) = self.kill {
            line += &format!("   # signal {} after {:.4} s", signal.number(), after.as_secs_f64());
        }
        line
    }

    /// Runs `program` in `folder` until it ends, is killed or is over time.
    ///
    /// # Panics
    /// If it cannot be started or its output cannot be read.
    #[must_use]
    pub fn run(&self, program: &Path, folder: &Path) -> Ended {
        let outputs: [PathBuf; 2] = ["stdout.txt", "stderr.txt"].map(|name| folder.join(name));
        let [stdout, stderr] = [0, 1].map(|i: usize| File::create(&outputs[i]).expect("a file"));
        let mut command = self.command(program);
        command.current_dir(folder).stdin(Stdio::null()).stdout(stdout).stderr(stderr);
        let start = Instant::now();
        let mut child = command.spawn().expect("the program starts");
        let mut ended = Ended::default();
        let status = self.wait(&mut child, start, &mut ended);
        ended.seconds = start.elapsed().as_secs_f64();
        (ended.code, ended.signal) = (status.code(), status.signal());
        let text = |path: &PathBuf| {
            let bytes = std::fs::read(path).expect("what it said");
            String::from_utf8_lossy(&bytes[..bytes.len().min(1 << 20)]).into_owned()
        };
        (ended.stdout, ended.stderr) = (text(&outputs[0]), text(&outputs[1]));
        ended
    }

    fn command(&self, program: &Path) -> Command {
        let mut command = match self.memory_kib {
            None => Command::new(program),
            Some(kib) => {
                let mut shell = Command::new("sh");
                shell.args(["-c", "ulimit -v \"$0\" && exec \"$@\"", &kib.to_string()]).arg(program);
                shell
            }
        };
        command.args(&self.arguments).env("RAYON_NUM_THREADS", self.threads.to_string());
        command.env_remove("RUST_BACKTRACE");
        command
    }

    fn wait(&self, child: &mut Child, start: Instant, ended: &mut Ended) -> ExitStatus {
        loop {
            if let Some(status) = child.try_wait().expect("a status") {
                return status;
            }
            // The last look counts: before the program is loaded, the process has the memory of its parent.
            ended.peak_kib = Some(peak_kib(child.id())).filter(|kib| *kib > 0).unwrap_or(ended.peak_kib);
            if let (Some((after, signal)), None) = (self.kill, ended.sent)
                && start.elapsed() >= after
            {
                ended.sent = Some(signal);
                send(child, signal);
            }
            if start.elapsed() >= self.limit {
                ended.over_time = true;
                let _ = child.kill();
                return child.wait().expect("a status");
            }
            std::thread::sleep(LOOK);
        }
    }
}

/// Our own child, which is not waited for yet: its number cannot be another's.
fn send(child: &mut Child, signal: Signal) {
    if signal == Signal::Kill {
        // It may have ended meanwhile.
        let _ = child.kill();
        return;
    }
    let _ = Command::new("kill").args([format!("-{}", signal.number()), child.id().to_string()]).status();
}

/// Largest memory of a process so far; 0 where the system does not tell or it has ended.
fn peak_kib(process: u32) -> u64 {
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    line.and_then(|rest| rest.split_whitespace().next()?.parse().ok()).unwrap_or(0)
}
