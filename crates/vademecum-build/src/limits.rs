//! Limits of a build: sizes of texts and numbers, available memory.
//!
//! Everything that is asked for by name is compared with a bound before anything is allocated, so that a
//! hostile or a mistyped problem ends in a sentence and not in an abort.

mod groups;

/// Smallest and largest magnitude of a physical number in any unit system.
///
/// Energies are sums of products of four such numbers (a modulus, two displacements, a length), and double
/// precision ends at 1e±308: with thirty digits to both sides no product of the builder comes near that end.
/// Unit systems differ by far less (a modulus is 2e11 in SI, 2e5 in mm-N-tonne, 2e23 in km-kg-ns).
pub(crate) const MAGNITUDE: (f64, f64) = (1e-30, 1e30);

/// Longest text of a problem: the vademecum file stores it in its metadata, with names and tables.
pub(crate) const MAX_TEXT: usize = vademecum_format::MAX_METADATA - (1 << 17);

/// Memory in a refusal or an announcement, in words: `1.5 GB`.
pub fn memory_in_words(bytes: u64) -> String {
    let bytes = bytes as f64;
    match bytes {
        b if b < 1e6 => format!("{:.0} kB", b / 1e3),
        b if b < 1e9 => format!("{:.0} MB", b / 1e6),
        b if b < 1e15 => format!("{:.1} GB", b / 1e9),
        b => format!("{:.0e} GB", b / 1e9),
    }
}

/// Keeps the number of threads to that of the cores: `RAYON_NUM_THREADS` may ask for more, which helps nobody
/// and, by mistake, starts thousands. Before anything runs in parallel; gives a note if it changed something.
pub fn bound_threads() -> Option<String> {
    let asked: usize = std::env::var("RAYON_NUM_THREADS").ok()?.trim().parse().ok()?;
    let cores = std::thread::available_parallelism().ok()?.get();
    if asked <= cores {
        return None;
    }
    rayon::ThreadPoolBuilder::new().num_threads(cores).build_global().ok()?;
    Some(format!("RAYON_NUM_THREADS is {asked}, and there are {cores} cores: {cores} threads are used"))
}

/// More memory than there is, or than was allowed.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "{what} need about {} of memory; {} can be had: ask for less{instead}, or allow more with `--memory SIZE` if \
     the machine has it",
    memory_in_words(*.needed), memory_in_words(*.limit)
)]
pub struct TooMuchMemory {
    /// The operation that needs it.
    pub what: String,
    /// Bytes it needs.
    pub needed: u64,
    /// Bytes allowed.
    pub limit: u64,
    /// The remedy, from a space on; may be empty.
    pub(crate) instead: &'static str,
}

/// Memory that may be used \[bytes\].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Memory(u64);

impl Memory {
    /// This much and no more.
    pub fn bytes(limit: u64) -> Self {
        Self(limit)
    }

    /// The requested limit, else the free memory within the limits of the process; unlimited where the
    /// system does not tell.
    pub fn asked_or_available(asked: Option<u64>) -> Self {
        Self(asked.or_else(available).unwrap_or(u64::MAX))
    }

    /// Bytes allowed.
    pub fn limit(self) -> u64 {
        self.0
    }

    /// Refuses what needs more. `needed` counts in floating point, where nothing overflows.
    ///
    /// # Errors
    /// [`TooMuchMemory`].
    pub fn check(
        self,
        needed: f64,
        instead: &'static str,
        what: impl FnOnce() -> String,
    ) -> Result<(), TooMuchMemory> {
        // Whatever is not below the limit is refused, NaN too.
        if needed <= self.0 as f64 {
            return Ok(());
        }
        Err(TooMuchMemory { what: what(), needed: needed as u64, limit: self.0, instead })
    }
}

/// Memory that can still be had (Linux): what the machine has free, and what a limit on the address space of
/// this process (`ulimit -v`) and those of its control groups leave.
fn available() -> Option<u64> {
    let free = kilobytes(&std::fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:");
    let used = || kilobytes(&std::fs::read_to_string("/proc/self/status").ok()?, "VmSize:");
    let limits = std::fs::read_to_string("/proc/self/limits").unwrap_or_default();
    let space = address_space(&limits).map(|limit| limit.saturating_sub(used().unwrap_or(0)));
    free.into_iter().chain(space).chain(groups::left_by_groups()).min()
}

/// The number behind `name` in a table of the kernel, in bytes.
fn kilobytes(table: &str, name: &str) -> Option<u64> {
    let line = table.lines().find_map(|line| line.strip_prefix(name))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}

/// The soft limit on the address space \[bytes\]; none where it is unlimited.
fn address_space(limits: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix("Max address space"))?;
    line.split_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tables_of_the_kernel_are_read() {
        let table = "MemTotal:       24 kB\nMemAvailable:   16 kB\n";
        assert_eq!(kilobytes(table, "MemAvailable:"), Some(16 * 1024));
        assert_eq!(kilobytes(table, "MemFree:"), None);
        let limits =
            "Max cpu time   unlimited  unlimited  seconds\nMax address space  4096000 unlimited bytes\n";
        assert_eq!(address_space(limits), Some(4_096_000));
        assert_eq!(address_space("Max address space   unlimited  unlimited  bytes\n"), None);
    }

    #[test]
    fn what_fits_is_allowed_and_what_does_not_is_named() {
        let memory = Memory::bytes(1000);
        assert_eq!(memory.check(1000.0, "", String::new), Ok(()));
        for needed in [1001.0, 1e300, f64::NAN] {
            let refused = memory.check(needed, "", || "ten matrices".into()).unwrap_err().to_string();
            assert!(refused.contains("ten matrices need about") && refused.contains("--memory"), "{refused}");
        }
    }
}
