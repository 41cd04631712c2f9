//! A sweep on a real SLURM with one node, started for it: the script of `luenberger sweep script`, a shard that is
//! killed and requeued, and the same bytes as from one process.
//!
//! The daemons run in the foreground of this program with a configuration of their own, without control groups and
//! without authentication, on ports of the loopback interface, and end with it.

use crate::step::{self, Failure, build_command, program, root, target};
use std::collections::BTreeMap;
use std::fs;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Runs of half a minute, so that a shard can be killed in the middle.
const STUDY: &str = r#"
[plant]
f = ["speed", "-sin(angle) - 0.2*speed + torque"]
h = ["angle"]
states = ["angle", "speed"]
inputs = ["torque"]

[input]
expressions = ["0.5*sin(t)"]

[simulation]
x0 = [1, 0]
duration = 20
samples = 3
scale = [1, 1]
rtol = 1e-10
noise = { amplitude = [0.05], period = 0.05 }

[[observer]]
name = "observer"
kind = "high-gain"
r = 0.2

[sweep]
parameter = "noise"
values = [0.5, 1]
ensemble = 800
"#;

/// How long the jobs may take.
const PATIENCE: Duration = Duration::from_secs(600);

pub(crate) fn run() -> Result<(), Failure> {
    // `sbatch --version` fails where there is no configuration.
    let is_there =
        |name| Command::new(sbin(name)).arg("-V").stdout(Stdio::null()).stderr(Stdio::null()).status().is_ok();
    if !["slurmctld", "slurmd", "sbatch"].into_iter().all(is_there) {
        eprintln!("── SKIPPED: a sweep on SLURM. To have it: apt install slurm-wlm");
        return Ok(());
    }
    let folder = root().join("target/cluster");
    _ = fs::remove_dir_all(&folder);
    fs::create_dir_all(&folder).map_err(|source| Failure::io(&folder, source))?;
    build_command()?;
    let binaries = target().join("debug");
    let study = folder.join("study.toml");
    fs::write(&study, STUDY).map_err(|source| Failure::io(&study, source))?;
    let luenberger = |arguments: &[&str]| step::luenberger(arguments).folder(&folder).variable("NO_COLOR", "1");
    luenberger(&["sweep", "study.toml", "-o", "one", "--block-size", "25"]).output("one process")?;

    let slurm = Slurm::start(&folder)?;
    let script =
        luenberger(&["sweep", "script", "study.toml", "--slurm", "-o", "out", "--shards", "3", "--block-size", "25"]);
    let script = script.output("script")?;
    let known = std::env::var_os("PATH").unwrap_or_default();
    let path = [binaries.clone()].into_iter().chain(std::env::split_paths(&known));
    let path = std::env::join_paths(path).unwrap_or_default();
    let submit = slurm.program("sh").arguments(&["-c", &script]).variable("PATH", &path.to_string_lossy());
    let said = submit.output("submit")?;
    eprintln!("{}", said.trim());
    // A shard is killed in the middle, as when its node fails, and requeued.
    let out = folder.join("out");
    wait("the first blocks", || blocks(&out) >= 4)?;
    let first = slurm.output("squeue", &["--noheader", "--states=RUNNING", "--format=%A"])?;
    let job = first.lines().next().unwrap_or_default().trim().to_owned();
    let steps = slurm.output("scontrol", &["listpids", &job])?;
    let pids = steps.lines().skip(1).filter_map(|line| line.split_whitespace().next());
    let shard = pids.filter(|pid| name_of(pid) == "luenberger").collect::<Vec<_>>();
    if shard.is_empty() {
        return Err(Failure::Cluster(format!("job {job} has no process luenberger:\n{steps}")));
    }
    for pid in &shard {
        program("kill").arguments(&["-9", pid]).step("kill -9 a shard")?;
    }
    wait("the shard to be requeued", || {
        slurm
            .output("scontrol", &["show", "job", &job])
            .is_ok_and(|job| job.contains("Restarts=1") && job.contains("JobState=PENDING"))
    })?;
    // SLURM would hold it for two minutes, so that its node has time to recover.
    slurm.output("scontrol", &["update", &format!("jobid={job}"), "starttime=now"])?;
    wait("the results", || {
        out.join("study.json").exists()
            && slurm.output("squeue", &["--noheader"]).is_ok_and(|jobs| jobs.trim().is_empty())
    })?;
    drop(slurm);
    let (found, expected) = (content(&out)?, content(&folder.join("one"))?);
    // Of the output of the jobs there is nothing in the other folder.
    let found: BTreeMap<_, _> = found.into_iter().filter(|(name, _)| !name.contains("/slurm-")).collect();
    if found != expected {
        let differs = found.iter().find(|(name, bytes)| expected.get(*name) != Some(bytes)).map(|(name, _)| name);
        return Err(Failure::Cluster(format!("the results differ from those of one process: {differs:?}")));
    }
    eprintln!("── SLURM: {} files, the same bytes as from one process", found.len());
    Ok(())
}

fn name_of(pid: &str) -> String {
    fs::read_to_string(format!("/proc/{pid}/comm")).unwrap_or_default().trim().to_owned()
}

fn blocks(out: &Path) -> usize {
    let files = fs::read_dir(out.join("blocks"));
    files.map_or(0, |files| {
        files.flatten().filter(|file| file.path().extension().is_some_and(|end| end == "npz")).count()
    })
}

fn wait(what: &str, mut is_there: impl FnMut() -> bool) -> Result<(), Failure> {
    let began = Instant::now();
    while !is_there() {
        if began.elapsed() > PATIENCE {
            return Err(Failure::Cluster(format!("waited {} s for {what}", PATIENCE.as_secs())));
        }
        sleep(Duration::from_millis(200));
    }
    Ok(())
}

/// The content of a folder, by names.
fn content(folder: &Path) -> Result<BTreeMap<String, Vec<u8>>, Failure> {
    let failed = |source| Failure::io(folder, source);
    let mut content = BTreeMap::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            content.extend(self::content(&path)?.into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
        } else {
            content.insert(name, fs::read(&path).map_err(failed)?);
        }
    }
    Ok(content)
}

/// A controller and a node.
struct Slurm {
    folder: PathBuf,
    daemons: Vec<Child>,
}

impl Slurm {
    fn start(folder: &Path) -> Result<Self, Failure> {
        let own = folder.join("slurm");
        for name in ["state", "spool"] {
            fs::create_dir_all(own.join(name)).map_err(|source| Failure::io(&own, source))?;
        }
        let host = program("hostname").arguments(&["-s"]).quiet_output("name of the machine")?;
        let user = program("id").arguments(&["-un"]).quiet_output("name of the user")?;
        let (host, user, at) = (host.trim(), user.trim(), own.display());
        let [controller, node] = [port()?, port()?];
        let text = format!(
            "ClusterName=sweep\nSlurmctldHost={host}(127.0.0.1)\nSlurmUser={user}\nSlurmdUser={user}\nAuthType=auth/none\n\
             CredType=cred/none\nSlurmctldPort={controller}\nSlurmdPort={node}\nSlurmctldPidFile={at}/slurmctld.pid\n\
             SlurmdPidFile={at}/slurmd.pid\nStateSaveLocation={at}/state\nSlurmdSpoolDir={at}/spool\n\
             ProctrackType=proctrack/linuxproc\nTaskPlugin=task/none\nMpiDefault=none\nReturnToService=2\n\
             SelectType=select/cons_tres\nSelectTypeParameters=CR_CPU\nNodeName={host} NodeAddr=127.0.0.1 CPUs=2\n\
             PartitionName=main Nodes={host} Default=YES\n"
        );
        let path = own.join("slurm.conf");
        fs::write(&path, text).map_err(|source| Failure::io(&path, source))?;
        let mut slurm = Self { folder: folder.to_owned(), daemons: Vec::new() };
        for name in ["slurmctld", "slurmd"] {
            let log =
                fs::File::create(own.join(name).with_extension("log")).map_err(|source| Failure::io(&own, source))?;
            let daemon =
                Command::new(sbin(name)).arg("-D").env("SLURM_CONF", &path).stdout(Stdio::null()).stderr(log).spawn();
            slurm.daemons.push(daemon.map_err(|source| Failure::io(name, source))?);
        }
        wait("the node", || {
            slurm.output("sinfo", &["--noheader", "--format=%t"]).is_ok_and(|state| state.trim() == "idle")
        })?;
        Ok(slurm)
    }

    fn program(&self, name: &str) -> crate::step::Step {
        let conf = self.folder.join("slurm/slurm.conf");
        program(name).folder(&self.folder).variable("SLURM_CONF", &conf.to_string_lossy())
    }

    fn output(&self, name: &str, arguments: &[&str]) -> Result<String, Failure> {
        self.program(name).arguments(arguments).quiet_output(name)
    }
}

impl Drop for Slurm {
    /// Ends the daemons, the node first.
    fn drop(&mut self) {
        for daemon in self.daemons.iter_mut().rev() {
            // On SIGTERM they end their jobs, too; SIGKILL would leave these.
            _ = Command::new("kill").arg(daemon.id().to_string()).status();
            _ = daemon.wait();
        }
    }
}

/// The path of a daemon: Debian has them where the users' PATH does not lead.
fn sbin(name: &str) -> PathBuf {
    let there = Path::new("/usr/sbin").join(name);
    if there.exists() { there } else { name.into() }
}

/// A port that is free now.
fn port() -> Result<u16, Failure> {
    let listener = TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr());
    listener.map(|address| address.port()).map_err(|source| Failure::io("127.0.0.1", source))
}
