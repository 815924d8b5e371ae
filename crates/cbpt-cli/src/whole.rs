//! Files that are written whole or not at all.
//!
//! What is written goes to a new file in the same folder, then to the disk, and takes the place of the old one in a single step:
//! whatever fails, the old file is still there as it was. A symbolic link is followed: the file that it leads to is replaced, and
//! the link stays. What is no plain file (`/dev/stdout`, a pipe) is written to as it is.

use std::fs::{self, File};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

/// Writes a file.
pub(crate) fn write(path: &Path, contents: &[u8]) -> io::Result<()> {
    let target = followed(path)?;
    let there = fs::metadata(&target).ok();
    if there.as_ref().is_some_and(|there| !there.is_file()) {
        return fs::write(&target, contents);
    }
    let name = target.file_name().ok_or(io::ErrorKind::InvalidFilename)?;
    let new = target.with_file_name(format!(".{}.{}.new", name.display(), std::process::id()));
    let written = (|| {
        let mut file = File::create(&new)?;
        file.write_all(contents)?;
        if let Some(there) = there {
            file.set_permissions(there.permissions())?;
        }
        file.sync_all()?;
        fs::rename(&new, &target)
    })();
    if written.is_err() {
        // What is left of it helps nobody; the error of writing is the one to tell.
        let _ = fs::remove_file(&new);
    }
    written
}

/// The file that a path leads to, through symbolic links, whether it is there or not.
pub(crate) fn followed(path: &Path) -> io::Result<PathBuf> {
    const MOST: usize = 40;
    let mut found = path.to_owned();
    for _ in 0..MOST {
        match fs::read_link(&found) {
            Ok(to) => found = found.parent().unwrap_or(Path::new("")).join(to),
            Err(_) => return Ok(found),
        }
    }
    Err(io::Error::other("too many symbolic links"))
}
