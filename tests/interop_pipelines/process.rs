//! Processes of this machine (Linux), to kill them midway.

use std::path::Path;
use std::process::Command;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Waits for what is looked for, or until so many seconds are over.
pub fn wait_for<T>(seconds: u64, what: &str, look: impl Fn() -> Option<T>) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < Duration::from_secs(seconds), "no {what} after {seconds} s");
        sleep(Duration::from_millis(5));
    }
}

/// The shards that bake into this folder, by their process numbers.
pub fn shards(program: &Path, out: &Path) -> Vec<u32> {
    let is_shard = |process: &Process| {
        let has = |word: &str| process.words.iter().any(|own| own == word);
        process.words[0] == program.to_str().unwrap() && has("--shard") && has(out.to_str().unwrap())
    };
    all().iter().filter(|process| is_shard(process)).map(|process| process.id).collect()
}

/// One of them that has begun, if there is one: it has a worker.
pub fn busy_shard(program: &Path, out: &Path) -> Option<u32> {
    let parents: Vec<u32> = all().iter().map(|process| process.parent).collect();
    shards(program, out).into_iter().find(|shard| parents.contains(shard))
}

struct Process {
    id: u32,
    parent: u32,
    words: Vec<String>,
}

fn all() -> Vec<Process> {
    let ids = std::fs::read_dir("/proc")
        .unwrap()
        .filter_map(|entry| entry.ok()?.file_name().to_str()?.parse().ok());
    ids.filter_map(process).collect()
}

/// None if it has ended.
fn process(id: u32) -> Option<Process> {
    let read = |file: &str| std::fs::read_to_string(format!("/proc/{id}/{file}")).ok();
    let status = read("status")?;
    let parent = status.lines().find_map(|line| line.strip_prefix("PPid:"))?.trim().parse().ok()?;
    let words = read("cmdline")?.split('\0').map(str::to_owned).collect();
    Some(Process { id, parent, words })
}

/// Kills it with a signal, as `KILL`; whether it was there.
pub fn kill(id: u32, signal: &str) -> bool {
    Command::new("kill").arg(format!("-{signal}")).arg(id.to_string()).status().unwrap().success()
}
