//! A Slurm cluster of one node, without root's services and in a folder of its own, and the script for Slurm on it.

use super::process::{busy_shard, kill, wait_for};
use super::{ASSETS, Place, data};
use crate::interop_asset::{run, volmap};
use std::io::{Read, Write};
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

/// The daemons; they end with it.
struct Cluster {
    folder: PathBuf,
    daemons: Vec<Child>,
}

/// A daemon's file; users' shells don't look where Debian puts it.
fn daemon(name: &str) -> Option<PathBuf> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let folders = std::env::split_paths(&path).chain(["/usr/sbin".into(), "/usr/local/sbin".into()]);
    folders.map(|folder| folder.join(name)).find(|file| file.exists())
}

impl Cluster {
    /// None where Slurm isn't installed.
    fn start(folder: &Path) -> Option<Cluster> {
        let (munged, slurmctld, slurmd) = (daemon("munged")?, daemon("slurmctld")?, daemon("slurmd")?);
        write_settings(folder, &slurmd);
        let mut cluster = Cluster { folder: folder.to_owned(), daemons: vec![] };
        let own = |name: &str| folder.join(name).display().to_string();
        // `--force`: the folder is the user's alone, which munged takes for a mistake.
        let mut command = Command::new(munged);
        command.args(["--force", "--foreground"]).arg(format!("--key-file={}", own("munge.key")));
        command
            .arg(format!("--socket={}", own("munge.socket")))
            .arg(format!("--pid-file={}", own("munge.pid")));
        command
            .arg(format!("--log-file={}", own("munge.log")))
            .arg(format!("--seed-file={}", own("munge.seed")));
        cluster.spawn("munged", &mut command);
        wait_for(10, "socket of munged", || folder.join("munge.socket").exists().then_some(()));
        cluster.spawn("slurmctld", Command::new(slurmctld).args(["-D", "-c"]));
        cluster.spawn("slurmd", Command::new(slurmd).arg("-D"));
        wait_for(60, "idle node", || {
            let output = cluster.command("sinfo").args(["--noheader", "--format=%T"]).output().unwrap();
            (output.stdout == b"idle\n").then_some(())
        });
        Some(cluster)
    }

    fn spawn(&mut self, name: &str, command: &mut Command) {
        let log = std::fs::File::create(self.folder.join(format!("{name}.out"))).unwrap();
        command.env("SLURM_CONF", self.folder.join("slurm.conf")).stdin(Stdio::null());
        command.stdout(log.try_clone().unwrap()).stderr(log);
        self.daemons.push(command.spawn().unwrap());
    }

    fn command(&self, name: impl AsRef<std::ffi::OsStr>) -> Command {
        let mut command = Command::new(name);
        command.env("SLURM_CONF", self.folder.join("slurm.conf"));
        command
    }

    /// State, restarts and exit code of a job, or of all jobs of an array.
    fn show(&self, job: &str) -> String {
        run(self.command("scontrol").args(["--oneliner", "show", "job", job]))
    }
}

impl Drop for Cluster {
    fn drop(&mut self) {
        for mut daemon in self.daemons.drain(..).rev() {
            kill(daemon.id(), "TERM");
            daemon.wait().ok();
        }
        if std::thread::panicking() {
            for name in ["munged", "slurmctld", "slurmd"] {
                let log =
                    std::fs::read_to_string(self.folder.join(format!("{name}.out"))).unwrap_or_default();
                eprintln!("== {name}\n{log}");
            }
        }
    }
}

/// Key and settings of a cluster whose state lies in this folder.
fn write_settings(folder: &Path, slurmd: &Path) {
    let mut key = [0; 128];
    std::fs::File::open("/dev/urandom").unwrap().read_exact(&mut key).unwrap();
    std::fs::write(folder.join("munge.key"), key).unwrap();
    run(Command::new("chmod").arg("600").arg(folder.join("munge.key")));
    let user = run(Command::new("id").arg("-un"));
    let host = run(Command::new("uname").arg("-n"));
    let host = host.trim().split('.').next().unwrap();
    let ports: Vec<_> = (0..2).map(|_| TcpListener::bind("127.0.0.1:0").unwrap()).collect();
    let [control, node] = [0, 1].map(|index: usize| ports[index].local_addr().unwrap().port());
    let settings = format!(
        "ClusterName=test\nSlurmctldHost={host}(127.0.0.1)\nSlurmUser={user}SlurmdUser={user}\
         SlurmctldPort={control}\nSlurmdPort={node}\n\
         AuthType=auth/munge\nAuthInfo=socket={folder}/munge.socket\nCredType=cred/munge\n\
         StateSaveLocation={folder}/state\nSlurmdSpoolDir={folder}/spool\n\
         SlurmctldPidFile={folder}/slurmctld.pid\nSlurmdPidFile={folder}/slurmd.pid\n\
         ProctrackType=proctrack/pgid\nTaskPlugin=task/none\nSwitchType=switch/none\nMpiDefault=none\n\
         JobAcctGatherType=jobacct_gather/none\nAccountingStorageType=accounting_storage/none\n\
         ReturnToService=2\nSchedulerParameters=batch_sched_delay=0,bf_interval=1\n\
         SelectType=select/cons_tres\nSelectTypeParameters=CR_Core\n\
         NodeName={host} NodeAddr=127.0.0.1 CPUs={processors}\nPartitionName=all Nodes=ALL Default=YES\n",
        folder = folder.display(),
        processors = std::thread::available_parallelism().unwrap(),
    );
    std::fs::write(folder.join("slurm.conf"), settings).unwrap();
    std::fs::create_dir(folder.join("state")).unwrap();
    std::fs::create_dir(folder.join("spool")).unwrap();
    // Without control groups, which containers may not have. Up to 23.02 that means: version 1, and nothing that uses
    // it.
    let version = run(Command::new(slurmd).arg("-V"));
    let year = version.split_whitespace().last().and_then(|number| number.split('.').next());
    let is_new = year.and_then(|year| year.parse().ok()).is_some_and(|year: u32| year >= 24);
    let plugin = if is_new { "disabled" } else { "cgroup/v1" };
    std::fs::write(folder.join("cgroup.conf"), format!("CgroupPlugin={plugin}\n")).unwrap();
}

/// Submits the script; the numbers of the array and of the job that joins.
fn submit(cluster: &Cluster, place: &Place, out: &str) -> (String, String) {
    let mut command = cluster.command(data("pipelines/slurm.sh"));
    command.args(["the batch.toml", out, "4"]).current_dir(place.at("")).env("VOLMAP", volmap());
    let text = run(&mut command);
    let number = |word| text.lines().find_map(|line| line.strip_prefix(word)).unwrap().trim().to_owned();
    (number("shards"), number("merge"))
}

/// Lets jobs that go back into the queue begin at once (Slurm waits two minutes), until none is left.
fn finish(cluster: &Cluster) {
    wait_for(120, "empty queue", || {
        let output = run(cluster.command("squeue").args(["--noheader", "--format=%i %r"]));
        for line in output.lines().filter(|line| line.ends_with(" BeginTime")) {
            let job = line.split(' ').next().unwrap();
            let update = ["update".into(), format!("JobId={job}"), "StartTime=now".into()];
            // It may have ended since.
            cluster.command("scontrol").args(update).output().unwrap();
        }
        output.is_empty().then_some(())
    });
}

#[test]
fn slurm_goes_on_after_a_killed_shard() {
    let place = Place::new();
    // Paths of sockets are short.
    let folder = tempfile::tempdir().unwrap();
    let Some(cluster) = Cluster::start(folder.path()) else {
        // Not by a macro, whose text tests that pass don't show.
        let cure = "apt-get install slurmctld slurmd slurm-client munge";
        writeln!(std::io::stderr(), "SKIPPED, as there is no Slurm here ({cure}): its script wasn't run")
            .unwrap();
        return;
    };
    let whole = place.undisturbed();
    let (array, merge) = submit(&cluster, &place, "the out");
    let shard = wait_for(30, "shard at work", || busy_shard(&volmap(), &place.at("the out")));
    assert!(kill(shard, "KILL"));
    finish(&cluster);
    let (jobs, joined) = (cluster.show(&array), cluster.show(&merge));
    assert_eq!(jobs.matches("JobState=COMPLETED").count(), 4, "{jobs}");
    assert_eq!(jobs.matches("Restarts=1 ").count(), 1, "{jobs}");
    assert!(joined.contains("JobState=COMPLETED"), "{joined}");
    assert!(place.assets("the out") == whole);
    assert_eq!(place.count("the out", "built") + place.count("the out", "unchanged"), ASSETS);

    // A mesh that can't be baked: the job that joins says so. Nothing else is baked again.
    place.write("the meshes/broken.obj", "v 0 0\n");
    let (array, merge) = submit(&cluster, &place, "the out");
    finish(&cluster);
    let (jobs, joined) = (cluster.show(&array), cluster.show(&merge));
    assert_eq!(jobs.matches("JobState=COMPLETED").count(), 3, "{jobs}");
    assert!(joined.contains("JobState=FAILED") && joined.contains("ExitCode=1:0"), "{joined}");
    assert_eq!((place.count("the out", "failed"), place.count("the out", "unchanged")), (1, ASSETS));
}
