//! Moves finished files from the temporary folder into the results folder, in place of those of the run before.
//!
//! What the command did not write, or what has been changed since, is never deleted: where it stands in the way it is
//! renamed to `NAME.old`.

use std::io;
use std::path::{Path, PathBuf};

use super::manifest::{Entry, MANIFEST, Manifest, is_absent};
use super::{io_error, rename};
use crate::error::StudyError;

/// Renamed files: the name, and the new one.
pub(super) type Renamed = Vec<(String, String)>;

/// Replaces the files of the manifest `old` by those of `new`, which are below `aside` under the same names.
///
/// While files are moved, the manifest lists both: a process that is killed here leaves a folder whose files are known
/// to the next run.
pub(super) fn replace(
    root: &Path,
    aside: &Path,
    old: Option<&Manifest>,
    new: &Manifest,
) -> Result<Renamed, StudyError> {
    let mut renamed = Renamed::new();
    let json = |manifest: &Manifest| manifest.text().map_err(StudyError::from);
    let before = old.map_or(&[][..], |manifest| &manifest.files);
    let both = Manifest::new(&new.command, new.study.clone(), before.iter().chain(&new.files).cloned().collect());
    if old.is_none() {
        put_aside(root, MANIFEST, &[], &mut renamed)?;
    }
    publish(root, aside, &json(&both)?)?;
    for entry in &new.files {
        let own: Vec<&Entry> = before.iter().chain(&new.files).filter(|own| own.name == entry.name).collect();
        for folder in ancestors(&entry.name) {
            if !root.join(folder).is_dir() {
                put_aside(root, folder, &[], &mut renamed)?;
            }
        }
        put_aside(root, &entry.name, &own, &mut renamed)?;
        let path = root.join(&entry.name);
        if let Some(parent) = path.parent() {
            std::fs::create_dir_all(parent).map_err(io_error(parent))?;
        }
        rename(&aside.join(&entry.name), &path)?;
    }
    for entry in before.iter().filter(|entry| new.files.iter().all(|new| new.name != entry.name)) {
        let path = root.join(&entry.name);
        if entry.is_at(&path).map_err(io_error(&path))? {
            std::fs::remove_file(&path).map_err(io_error(&path))?;
            // Folders that are empty now; one with other files stays.
            for folder in ancestors(&entry.name).into_iter().rev() {
                if std::fs::remove_dir(root.join(folder)).is_err() {
                    break;
                }
            }
        }
    }
    publish(root, aside, &json(new)?)?;
    Ok(renamed)
}

/// Writes the manifest aside and moves it into place.
fn publish(root: &Path, aside: &Path, text: &str) -> Result<(), StudyError> {
    let (from, to) = (aside.join(MANIFEST), root.join(MANIFEST));
    std::fs::write(&from, text).map_err(io_error(&to))?;
    rename(&from, &to)
}

/// The folders of a name, outermost first.
fn ancestors(name: &str) -> Vec<&str> {
    name.match_indices('/').map(|(end, _)| &name[..end]).collect()
}

/// The largest number of renamed files of one name.
const MOST: usize = 10_000;

/// Renames what is at `name`, unless it has the content of one of `own`.
fn put_aside(root: &Path, name: &str, own: &[&Entry], renamed: &mut Renamed) -> Result<(), StudyError> {
    let path = root.join(name);
    let failed = |error: io::Error| StudyError::io(&path, error);
    match path.symlink_metadata() {
        Ok(_) => {}
        Err(error) if is_absent(&error) => return Ok(()),
        Err(error) => return Err(failed(error)),
    }
    for entry in own {
        if entry.is_at(&path).map_err(failed)? {
            return Ok(());
        }
    }
    let free = |number: usize| if number == 1 { format!("{name}.old") } else { format!("{name}.old{number}") };
    let other = (1..=MOST).map(free).find(|other| root.join(other).symlink_metadata().is_err());
    let other = other.ok_or_else(|| failed(io::Error::from(io::ErrorKind::AlreadyExists)))?;
    let to: PathBuf = root.join(&other);
    rename(&path, &to)?;
    renamed.push((name.to_owned(), other));
    Ok(())
}
