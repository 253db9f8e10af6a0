//! Memory left by the control groups of this process (Linux): containers, job schedulers and services
//! set a limit there, which the machine's free memory does not show.
//!
//! A limit holds for a group and all below it, so that the least of what the own group and those above it
//! leave can be had. Pages of files that were not used lately count as used, and are given up for others.

use std::path::{Path, PathBuf};

/// One of the two kinds of control groups: where it is found, and what its files are called.
struct GroupKind {
    /// Mount point of the groups.
    root: &'static str,
    /// Text before the group in `/proc/self/cgroup`, after the number.
    controllers: &'static str,
    limit: &'static str,
    used: &'static str,
    /// The row of `memory.stat` with the pages that can be given up.
    inactive: &'static str,
}

const KINDS: [GroupKind; 2] = [
    GroupKind {
        root: "/sys/fs/cgroup",
        controllers: "",
        limit: "memory.max",
        used: "memory.current",
        inactive: "inactive_file",
    },
    GroupKind {
        root: "/sys/fs/cgroup/memory",
        controllers: "memory",
        limit: "memory.limit_in_bytes",
        used: "memory.usage_in_bytes",
        inactive: "total_inactive_file",
    },
];

/// Memory that all groups of this process leave \[bytes\]; none where none of them has a limit.
pub(crate) fn left_by_groups() -> Option<u64> {
    let table = std::fs::read_to_string("/proc/self/cgroup").ok()?;
    let of_kind = |kind: &GroupKind| {
        let read = |folder: &Path, name| std::fs::read_to_string(folder.join(name)).ok();
        let left_by = |folder: PathBuf| {
            let [limit, used] = [kind.limit, kind.used].map(|name| read(&folder, name));
            let stat = read(&folder, "memory.stat").unwrap_or_default();
            left(&limit?, &used?, &stat, kind.inactive)
        };
        folders(&table, kind).into_iter().filter_map(left_by).min()
    };
    KINDS.iter().filter_map(of_kind).min()
}

/// The folder of the group of this process and those of the groups above it. Within a container the path may
/// be that of the machine, of which the container shows the last part alone: the root is always among them.
fn folders(table: &str, kind: &GroupKind) -> Vec<PathBuf> {
    let group = |line: &str| {
        let (_, line) = line.split_once(':')?;
        let (controllers, group) = line.split_once(':')?;
        let mut names = controllers.split(',');
        names.any(|name| name == kind.controllers).then(|| group.trim_start_matches('/').to_string())
    };
    let Some(group) = table.lines().find_map(group) else { return vec![] };
    Path::new(&group).ancestors().map(|group| Path::new(kind.root).join(group)).collect()
}

/// Limit less used memory that cannot be reclaimed; none where there is no limit.
fn left(limit: &str, used: &str, stat: &str, inactive: &str) -> Option<u64> {
    let [limit, used] = [limit, used].map(|number| number.trim().parse::<u64>().ok());
    let row = |line: &str| line.strip_prefix(inactive)?.trim().parse().ok();
    let given_up: u64 = stat.lines().find_map(row).unwrap_or(0);
    Some(limit?.saturating_sub(used?.saturating_sub(given_up)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_found_from_the_own_one_upwards() {
        let table = "12:pids:/jobs/7\n4:cpu,memory:/jobs/7\n0::/user.slice/a b\n";
        let of = |kind: &GroupKind| folders(table, kind);
        let [unified, first] = &KINDS;
        let paths = |all: &[&str]| all.iter().map(PathBuf::from).collect::<Vec<_>>();
        let own = ["/sys/fs/cgroup/user.slice/a b", "/sys/fs/cgroup/user.slice", "/sys/fs/cgroup"];
        assert_eq!(of(unified), paths(&own));
        let own = ["/sys/fs/cgroup/memory/jobs/7", "/sys/fs/cgroup/memory/jobs", "/sys/fs/cgroup/memory"];
        assert_eq!(of(first), paths(&own));
        assert_eq!(folders("0::/\n", unified), paths(&["/sys/fs/cgroup"]));
        assert_eq!(folders("0::/\n", first), paths(&[]));
        assert_eq!(folders("no table\n", unified), paths(&[]));
    }

    #[test]
    fn a_limit_leaves_what_is_not_used_and_what_can_be_given_up() {
        let stat = "anon 700\ninactive_file_x 1\ninactive_file 200\n";
        assert_eq!(left("1000\n", "900\n", stat, "inactive_file"), Some(300));
        assert_eq!(left("1000\n", "900\n", "", "inactive_file"), Some(100));
        assert_eq!(left("1000\n", "1100\n", "", "inactive_file"), Some(0));
        assert_eq!(left("max\n", "900\n", stat, "inactive_file"), None);
        // No limit in the first kind is a number beyond all memory.
        let none = "9223372036854771712\n";
        assert!(left(none, "900\n", stat, "total_inactive_file").is_some_and(|left| left > 1 << 62));
    }
}
