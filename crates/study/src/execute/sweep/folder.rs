//! Blocks in a folder that several processes, on several machines, write at the same time.
//!
//! A block is written aside, flushed to the disk and renamed: a file with the name of a block is complete. Its content
//! depends on the plan alone, so that two writers of one block would only waste time; a lock keeps the second one off.
//! The lock is one of the operating system, which releases it when its process ends in whatever way. On file systems
//! without locks there are none, and each writer has an own temporary name.
//!
//! | file | content |
//! |---|---|
//! | `plan.json` | the [`Plan`] |
//! | `study/` | the study, and the files that it reads |
//! | `00000012.npz` | block 12 |
//! | `.00000012.lock`, `.00000012.partial` | block 12 is being computed, or its process was killed |

use std::fs::{File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use super::plan::Plan;
use crate::digest;
use crate::error::StudyError;
use crate::error::sweep::{PLAN, SweepError};
use crate::execute::folder::io_error;
use crate::read::Format;
use crate::study::{DataFiles, Study};

/// The folder of the study in that of the blocks.
const STUDY: &str = "study";

/// A folder of blocks.
#[derive(Debug, Clone)]
pub(super) struct BlockFolder {
    path: PathBuf,
    /// Whether files are flushed to the disk: not those that do not outlive the process.
    is_durable: bool,
}

/// The right to write a block; released when dropped.
pub(super) struct Claim {
    block: u64,
    /// None on file systems without locks.
    lock: Option<File>,
}

impl BlockFolder {
    /// A folder that is deleted with the process.
    pub(super) fn temporary(path: PathBuf) -> Result<Self, StudyError> {
        std::fs::create_dir_all(&path).map_err(io_error(&path))?;
        Ok(Self { path, is_durable: false })
    }

    /// The folder of a sweep with this plan, which is created if it is missing. With `restart` the blocks of any other
    /// plan are deleted.
    pub(super) fn open(path: PathBuf, plan: &Plan, study: &Study, restart: bool) -> Result<Self, StudyError> {
        let folder = Self { path, is_durable: true };
        let path = &folder.path;
        std::fs::create_dir_all(path).map_err(io_error(path))?;
        if restart {
            folder.clear()?;
        }
        if !path.join(PLAN).exists() {
            folder.copy(study)?;
            // Of several processes that begin at the same time, one writes the plan.
            let json = serde_json::to_string_pretty(plan)? + "\n";
            let aside = path.join(format!(".plan-{}.partial", unique()));
            folder.write(&aside, json.as_bytes())?;
            let linked = std::fs::hard_link(&aside, path.join(PLAN));
            match linked {
                Ok(()) => _ = std::fs::remove_file(&aside),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => _ = std::fs::remove_file(&aside),
                // Some file systems have no links.
                Err(_) => std::fs::rename(&aside, path.join(PLAN)).map_err(io_error(path))?,
            }
            folder.flush();
        }
        let found = Self::plan(path)?;
        found.check_version(path)?;
        match difference(&found, plan) {
            None => Ok(folder),
            Some(what) => Err(SweepError::Other { folder: path.clone(), what }.into()),
        }
    }

    /// The plan of a folder.
    pub(super) fn plan(path: &Path) -> Result<Plan, StudyError> {
        let file = path.join(PLAN);
        let text = match std::fs::read(&file) {
            Ok(text) => text,
            Err(error) if crate::execute::folder::is_absent(&error) => {
                return Err(SweepError::NoSweep { folder: path.to_owned() }.into());
            }
            Err(error) => return Err(StudyError::io(&file, error)),
        };
        serde_json::from_slice(&text).map_err(|_| SweepError::Plan { path: file }.into())
    }

    /// Copies the study and the files that it reads.
    fn copy(&self, study: &Study) -> Result<(), StudyError> {
        let folder = self.path.join(STUDY);
        std::fs::create_dir_all(&folder).map_err(io_error(&folder))?;
        self.publish(&folder.join(copy_of_study(study.format)), study.source.text().as_bytes())?;
        for (number, file) in study.files.iter().enumerate() {
            let from = study.data.path(&file.name);
            let content = study.data.read(&file.name).map_err(io_error(&from))?;
            if digest::sha256(&content) != file.sha256 {
                return Err(StudyError::io(&from, io::Error::other("the file changes while it is read")));
            }
            self.publish(&folder.join(copy_of_file(number)), &content)?;
        }
        Ok(())
    }

    /// The study whose sweep this is, from its copy.
    pub(super) fn study(path: &Path, plan: &Plan) -> Result<Study, StudyError> {
        let folder = path.join(STUDY);
        let format = if plan.json { Format::Json } else { Format::Toml };
        let copy = folder.join(copy_of_study(format));
        let text = std::fs::read_to_string(&copy).map_err(io_error(&copy))?;
        let copies =
            plan.files.iter().enumerate().map(|(k, file)| (file.name.clone(), folder.join(copy_of_file(k)))).collect();
        let data = DataFiles::Folder { path: folder.clone(), copies };
        let study = crate::read::study(&plan.study.name, &text, format, &data)?;
        if digest::sha256(text.as_bytes()) != plan.study.sha256 || study.files != plan.files {
            let what = format!("the copy of the study in {} was changed", folder.display());
            return Err(SweepError::Other { folder: path.to_owned(), what }.into());
        }
        Ok(study)
    }

    /// Its path.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The file of a block.
    pub(super) fn file(&self, block: u64) -> PathBuf {
        self.path.join(format!("{block:08}.npz"))
    }

    fn lock_file(&self, block: u64) -> PathBuf {
        self.path.join(format!(".{block:08}.lock"))
    }

    /// The bytes of a block, if there is one.
    pub(super) fn read(&self, block: u64) -> Result<Option<Vec<u8>>, StudyError> {
        let path = self.file(block);
        match std::fs::read(&path) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(None),
            Err(error) => Err(StudyError::io(&path, error)),
        }
    }

    /// The right to write a block; none while another process has it.
    pub(super) fn claim(&self, block: u64) -> Result<Option<Claim>, StudyError> {
        let path = self.lock_file(block);
        let file = File::options().create(true).truncate(false).write(true).open(&path).map_err(io_error(&path))?;
        match file.try_lock() {
            Ok(()) => Ok(Some(Claim { block, lock: Some(file) })),
            Err(TryLockError::WouldBlock) => Ok(None),
            // Some network file systems have no locks, and say so in different ways.
            Err(TryLockError::Error(_)) => Ok(Some(Claim { block, lock: None })),
        }
    }

    /// Gives a block back that has been written, by this process or, before the claim, by another one.
    pub(super) fn release(&self, claim: &Claim) {
        // Only a finished block has no lock file: whoever opens it later finds the block.
        _ = std::fs::remove_file(self.lock_file(claim.block));
    }

    /// Deletes the lock of a finished block, whose process was killed just before it did so.
    pub(super) fn tidy(&self, block: u64) -> Result<(), StudyError> {
        if self.lock_file(block).exists()
            && let Some(claim) = self.claim(block)?
        {
            self.release(&claim);
        }
        Ok(())
    }

    /// Writes a block. Without a lock it has a temporary name that no other process uses.
    pub(super) fn put(&self, block: u64, claim: Option<&Claim>, bytes: &[u8]) -> Result<(), StudyError> {
        let aside = match claim {
            Some(Claim { lock: Some(_), .. }) => format!(".{block:08}.partial"),
            _ => format!(".{block:08}-{}.partial", unique()),
        };
        let written = self.rename(&self.path.join(aside), &self.file(block), bytes);
        written.map_err(|error| match error {
            StudyError::Io { path, error } => SweepError::Write { path, error }.into(),
            other => other,
        })?;
        if let Some(claim) = claim {
            self.release(claim);
        }
        Ok(())
    }

    /// Writes a file of which several processes may write the same content at the same time.
    pub(super) fn publish(&self, path: &Path, bytes: &[u8]) -> Result<(), StudyError> {
        self.rename(&self.path.join(format!(".{}.partial", unique())), path, bytes)
    }

    fn rename(&self, aside: &Path, path: &Path, bytes: &[u8]) -> Result<(), StudyError> {
        // Messages name the file as the user knows it.
        let written = self.write(aside, bytes).and_then(|()| std::fs::rename(aside, path).map_err(io_error(path)));
        if let Err(error) = written {
            _ = std::fs::remove_file(aside);
            return Err(match error {
                StudyError::Io { error, .. } => StudyError::io(path, error),
                other => other,
            });
        }
        self.flush();
        Ok(())
    }

    fn write(&self, path: &Path, bytes: &[u8]) -> Result<(), StudyError> {
        let mut file = File::create(path).map_err(io_error(path))?;
        file.write_all(bytes).map_err(io_error(path))?;
        if self.is_durable { file.sync_all().map_err(io_error(path)) } else { Ok(()) }
    }

    /// Flushes the names of the files, where directories can be opened.
    fn flush(&self) {
        if self.is_durable {
            _ = File::open(&self.path).and_then(|folder| folder.sync_all());
        }
    }

    /// What is in a folder of blocks.
    pub(super) fn list(path: &Path) -> Result<Listed, StudyError> {
        let mut listed = Listed::default();
        for entry in std::fs::read_dir(path).map_err(io_error(path))? {
            let name = entry.map_err(io_error(path))?.file_name().to_string_lossy().into_owned();
            let number = |digits: &str| digits.parse().ok().filter(|_| digits.len() >= 8);
            let block = |end: &str| number(name.strip_suffix(end)?);
            let hidden = |end: &str| number(name.strip_prefix('.')?.strip_suffix(end)?);
            if let Some(block) = block(".npz") {
                listed.blocks.push(block);
            } else if let Some(block) = hidden(".lock") {
                listed.locks.push(block);
            } else if block(".csv").is_some() || name.starts_with('.') && name.ends_with(".partial") {
                listed.others.push(name);
            }
        }
        listed.blocks.sort_unstable();
        listed.locks.sort_unstable();
        Ok(listed)
    }

    /// Blocks that a process computes now, of those with a lock.
    pub(super) fn running(&self, locks: &[u64]) -> Vec<u64> {
        let is_locked = |block: &&u64| {
            let file = File::options().write(true).open(self.lock_file(**block));
            file.is_ok_and(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
        };
        locks.iter().filter(is_locked).copied().collect()
    }

    /// The folder at a path that has a plan.
    pub(super) fn existing(path: PathBuf) -> Self {
        Self { path, is_durable: true }
    }

    /// Deletes the blocks, the plan and the study.
    fn clear(&self) -> Result<(), StudyError> {
        let listed = Self::list(&self.path)?;
        if !self.running(&listed.locks).is_empty() {
            return Err(SweepError::InUse { folder: self.path.clone() }.into());
        }
        let remove = |path: PathBuf| match std::fs::remove_file(&path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => Err(StudyError::io(&path, error)),
            _ => Ok(()),
        };
        // The plan first: a folder without one has no blocks that count.
        remove(self.path.join(PLAN))?;
        let files = listed.blocks.iter().map(|block| self.file(*block));
        let files = files.chain(listed.locks.iter().map(|block| self.lock_file(*block)));
        files.chain(listed.others.iter().map(|name| self.path.join(name))).try_for_each(remove)?;
        let copies = self.path.join(STUDY);
        if copies.is_dir() { std::fs::remove_dir_all(&copies).map_err(io_error(&copies)) } else { Ok(()) }
    }
}

/// Content of a folder of blocks.
#[derive(Debug, Default)]
pub(super) struct Listed {
    pub(super) blocks: Vec<u64>,
    pub(super) locks: Vec<u64>,
    others: Vec<String>,
}

fn copy_of_study(format: Format) -> &'static str {
    match format {
        Format::Toml => "study.toml",
        Format::Json => "study.json",
    }
}

fn copy_of_file(number: usize) -> String {
    format!("file-{}.csv", number + 1)
}

/// A name that no other process uses at the same time.
fn unique() -> String {
    use std::sync::atomic::{AtomicU64, Ordering};
    static COUNT: AtomicU64 = AtomicU64::new(0);
    let time = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).map_or(0, |time| time.as_nanos());
    format!("{}-{time:x}-{}", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed))
}

/// What distinguishes the plan of a folder from another one.
fn difference(found: &Plan, plan: &Plan) -> Option<String> {
    if found == plan {
        return None;
    }
    if found.study.name != plan.study.name {
        return Some(format!("their study is {}", found.study.name));
    }
    if found.study.sha256 != plan.study.sha256 {
        return Some(format!("{} has changed since", plan.study.name));
    }
    if let Some(file) = plan.files.iter().find(|file| !found.files.contains(file)) {
        return Some(format!("{}, which the study reads, has changed since", file.name));
    }
    if found.block_size != plan.block_size {
        return Some(format!("their block size is {}, not {}", found.block_size, plan.block_size));
    }
    Some("their plan differs".to_owned())
}
