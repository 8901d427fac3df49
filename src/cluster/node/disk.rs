//! A copy of each checkpoint on the node's own disk: where the servers have lost theirs, numbers, registration and decisions are
//! still known.

#![expect(clippy::disallowed_methods, reason = "a file of this node")]

use std::io::{self, Write};
use std::path::{Path, PathBuf};

fn path(directory: &Path, region: &str, cell: &str) -> PathBuf {
    directory.join(format!("cluster-{region}-{cell}.engine"))
}

/// Keeps a state of a cell in place of the one before.
///
/// # Errors
/// The directory cannot be written.
pub(super) fn keep(directory: &Path, region: &str, cell: &str, engine: &[u8]) -> io::Result<()> {
    std::fs::create_dir_all(directory)?;
    let path = path(directory, region, cell);
    let new = path.with_extension("new");
    let mut file = std::fs::File::create(&new)?;
    file.write_all(engine)?;
    file.sync_all()?;
    std::fs::rename(new, path)
}

/// The state that was kept last.
pub(super) fn kept(directory: &Path, region: &str, cell: &str) -> Option<Vec<u8>> {
    std::fs::read(path(directory, region, cell)).ok()
}
