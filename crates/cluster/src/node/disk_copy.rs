//! A copy of each checkpoint on the node's own disk. If the servers lose theirs, numbers, registration and decisions are restored
//! from it.
//!
//! The file consists of the first 8 octets of the checkpoint's SHA-256, and the checkpoint.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use tracing::{info, warn};

use service::live::{ServiceFault, now, state_troubles};
use service::state::{StateHealth, write_atomically};

/// Description of the file, for the operator.
const DESCRIPTION: &str = "copy of a cell's checkpoint";
/// Size of the hash, in octets.
const HASH_OCTETS: usize = 8;

/// Copy of one cell's checkpoint.
#[derive(Clone, Debug)]
pub(super) struct DiskCopy {
    directory: PathBuf,
    name: String,
    health: StateHealth,
}

impl DiskCopy {
    pub(super) fn of(directory: &Path, region: &str, cell: &str, health: &StateHealth) -> Self {
        let name = format!("cluster-{region}-{cell}.engine");
        Self { directory: directory.to_owned(), name, health: health.clone() }
    }

    /// Writes a state in place of the previous one. A failure is logged once and noted; the next checkpoint is tried again.
    pub(super) fn maintain_role(&self, engine: &[u8]) {
        let Self { directory, name, health } = self;
        let octets = [&hash(engine)[..], engine].concat();
        let written =
            std::fs::create_dir_all(directory).and_then(|()| write_atomically(&directory.join(name), octets));
        match written {
            Ok(()) if health.note_success(name) => info!(file = name, "state is written again"),
            Ok(()) => {}
            Err(error) => {
                if health.note_failure(name, &error) {
                    let directory = directory.display();
                    warn!(file = name, %error, %directory, "no copy of the checkpoint is kept here: tried again");
                }
                health.clear_obstacles(directory, name, DESCRIPTION, now());
            }
        }
    }

    /// Reads the stored state. A damaged file is set aside.
    pub(super) fn read(&self) -> Option<Vec<u8>> {
        let Self { directory, name, health } = self;
        health.clear_obstacles(directory, name, DESCRIPTION, now());
        let path = directory.join(name);
        let read = || -> io::Result<Vec<u8>> {
            if !std::fs::metadata(&path)?.is_file() {
                return Err(io::Error::other("it is no file"));
            }
            std::fs::read(&path)
        };
        let error = match read() {
            Ok(octets) => match octets.split_at_checked(HASH_OCTETS) {
                Some((begin, engine)) if *begin == hash(engine) => return Some(engine.to_owned()),
                _ => io::Error::other("its hash does not fit"),
            },
            Err(error) if error.kind() == ErrorKind::NotFound => return None,
            Err(error) => error,
        };
        health.set_aside(directory, name, DESCRIPTION, &error, now());
        None
    }
}

/// Problems with the files of this node, for the report of a cell.
pub(super) fn troubles(health: &StateHealth, node: &str) -> impl Iterator<Item = ServiceFault> {
    state_troubles(health, now()).into_iter().map(move |trouble| ServiceFault {
        about: format!("{} {node}", trouble.about).into(),
        text: format!("node {node}: {}", trouble.text),
        ..trouble
    })
}

fn hash(engine: &[u8]) -> [u8; HASH_OCTETS] {
    *Sha256::digest(engine).first_chunk().expect("32 octets")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damaged_copy_is_set_aside_and_written_again() {
        let directory = std::env::temp_dir().join(format!("utm-fusion-copy-{}", std::process::id()));
        let health = StateHealth::default();
        let copy = DiskCopy::of(&directory, "north", "all", &health);
        assert_eq!(copy.read(), None);
        copy.maintain_role(&[7; 100]);
        assert_eq!(copy.read(), Some(vec![7; 100]));
        let file = directory.join("cluster-north-all.engine");
        let whole = std::fs::read(&file).unwrap();
        for cut in 0..whole.len() {
            std::fs::write(&file, &whole[..cut]).unwrap();
            assert_eq!(copy.read(), None, "{cut}");
        }
        for place in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[place] ^= 1;
            std::fs::write(&file, damaged).unwrap();
            assert_eq!(copy.read(), None, "{place}");
        }
        std::fs::create_dir_all(&file).unwrap();
        assert_eq!(copy.read(), None);
        std::fs::create_dir_all(directory.join("cluster-north-all.engine.part")).unwrap();
        copy.maintain_role(&[8; 9]);
        assert!(health.all()["cluster-north-all.engine"].failing.is_some(), "a directory is in the way");
        copy.maintain_role(&[8; 9]);
        assert_eq!(copy.read(), Some(vec![8; 9]));
        assert!(health.all()["cluster-north-all.engine"].failing.is_none());
        std::fs::remove_dir_all(&directory).unwrap();
    }
}
