//! How much memory a batch may take: what is free, of the machine and of the container or the job that it runs in.

use std::path::{Path, PathBuf};

/// A size in a process's status (`self` or its number), bytes.
pub fn of_process(process: &str, name: &str) -> Option<u64> {
    kib(&std::fs::read_to_string(format!("/proc/{process}/status")).ok()?, name)
}

/// Three quarters of what is free, bytes, where the system tells (Linux).
pub fn free_memory() -> Option<u64> {
    let machine = kib(&std::fs::read_to_string("/proc/meminfo").ok()?, "MemAvailable:")?;
    let group = std::fs::read_to_string("/proc/self/cgroup").ok().and_then(|text| free_of_groups(&text));
    Some(group.map_or(machine, |group| group.min(machine)) / 4 * 3)
}

/// A size in kB on a line that begins with this name, bytes.
fn kib(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    Some(line.trim().trim_end_matches(" kB").parse::<u64>().ok()? << 10)
}

/// The least that is free of the control groups (version 2, then 1) of this process and all around them.
fn free_of_groups(text: &str) -> Option<u64> {
    let groups = text.lines().filter_map(|line| {
        let mut parts = line.splitn(3, ':').skip(1);
        let (controllers, path) = (parts.next()?, parts.next()?);
        let path = path.trim_start_matches('/');
        match controllers {
            "" => Some((Path::new("/sys/fs/cgroup").join(path), ["memory.max", "memory.current"])),
            _ if controllers.split(',').any(|name| name == "memory") => Some((
                Path::new("/sys/fs/cgroup/memory").join(path),
                ["memory.limit_in_bytes", "memory.usage_in_bytes"],
            )),
            _ => None,
        }
    });
    let free = |(folder, files): (PathBuf, [&str; 2])| {
        folder.ancestors().filter_map(|folder| free_of_group(folder, files)).min()
    };
    groups.filter_map(free).min()
}

/// None where there is no limit, or what stands there is no number.
fn free_of_group(folder: &Path, files: [&str; 2]) -> Option<u64> {
    let [limit, used] = files.map(|file| {
        std::fs::read_to_string(folder.join(file)).ok().and_then(|text| text.trim().parse::<u64>().ok())
    });
    // Files that can be read again from the disk count as used; a container begins with few.
    Some(limit?.saturating_sub(used?))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_of_groups_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let names = ["memory.max", "memory.current"];
        assert_eq!(free_of_group(folder.path(), names), None);
        std::fs::write(folder.path().join("memory.current"), "1000\n").unwrap();
        for (limit, free) in [("max\n", None), ("5000\n", Some(4000)), ("500\n", Some(0))] {
            std::fs::write(folder.path().join("memory.max"), limit).unwrap();
            assert_eq!(free_of_group(folder.path(), names), free);
        }
        assert_eq!(kib("MemTotal: 5 kB\nMemAvailable:   3 kB\n", "MemAvailable:"), Some(3072));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn there_is_some() {
        assert!(free_memory().unwrap() > 1 << 20);
    }
}
