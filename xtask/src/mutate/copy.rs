//! A copy of the workspace's sources that preserves modification times of unchanged files, so that cargo builds them
//! once.

use std::fs;
use std::path::Path;

use crate::step::Failure;

/// Makes `to` have the files of `from` and no others; build output and hidden entries are left out.
pub(super) fn mirror(from: &Path, to: &Path) -> Result<(), Failure> {
    let failed = |path: &Path| {
        let path = path.to_path_buf();
        move |source| Failure::io(path, source)
    };
    fs::create_dir_all(to).map_err(failed(to))?;
    for entry in fs::read_dir(to).map_err(failed(to))? {
        let path = entry.map_err(failed(to))?.path();
        let original = path.file_name().map(|name| from.join(name));
        if original.is_none_or(|original| !original.exists()) {
            let remove = if path.is_dir() { fs::remove_dir_all } else { fs::remove_file };
            remove(&path).map_err(failed(&path))?;
        }
    }
    for entry in fs::read_dir(from).map_err(failed(from))? {
        let (path, name) = entry.map(|entry| (entry.path(), entry.file_name())).map_err(failed(from))?;
        let word = name.to_string_lossy();
        if word == "target" || word.starts_with('.') {
            continue;
        }
        let copy = to.join(&name);
        if path.is_dir() {
            mirror(&path, &copy)?;
            continue;
        }
        let wanted = fs::read(&path).map_err(failed(&path))?;
        if fs::read(&copy).ok().as_ref() != Some(&wanted) {
            fs::write(&copy, wanted).map_err(failed(&copy))?;
        }
    }
    Ok(())
}
