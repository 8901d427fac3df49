//! A copy of each checkpoint on the node's own disk: where the servers have lost theirs, numbers, registration and decisions are
//! still known.
//!
//! The file is the first 8 octets of the SHA-256 of the checkpoint, and the checkpoint.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use tracing::{info, warn};

use crate::live::{Trouble, now, state_troubles};
use crate::state::{StateHealth, write_atomically};

/// Description of the file's contents, for people.
const CONTENTS: &str = "copy of a cell's checkpoint";
/// Octets of the hash.
const HASH: usize = 8;

/// The copy of one cell's checkpoint.
#[derive(Clone, Debug)]
pub(super) struct Copy {
    directory: PathBuf,
    name: String,
    health: StateHealth,
}

impl Copy {
    pub(super) fn of(directory: &Path, region: &str, cell: &str, health: &StateHealth) -> Self {
        let name = format!("cluster-{region}-{cell}.engine");
        Self { directory: directory.to_owned(), name, health: health.clone() }
    }

    /// Keeps a state in place of the one before. A failure is logged once and noted, and the next checkpoint tried again.
    pub(super) fn keep(&self, engine: &[u8]) {
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
                health.clear_obstacles(directory, name, CONTENTS, now());
            }
        }
    }

    /// The state that was kept last. A damaged file is set aside.
    pub(super) fn kept(&self) -> Option<Vec<u8>> {
        let Self { directory, name, health } = self;
        health.clear_obstacles(directory, name, CONTENTS, now());
        let path = directory.join(name);
        let read = || -> io::Result<Vec<u8>> {
            if !std::fs::metadata(&path)?.is_file() {
                return Err(io::Error::other("it is no file"));
            }
            std::fs::read(&path)
        };
        let error = match read() {
            Ok(octets) => match octets.split_at_checked(HASH) {
                Some((begin, engine)) if *begin == hash(engine) => return Some(engine.to_owned()),
                _ => io::Error::other("its hash does not fit"),
            },
            Err(error) if error.kind() == ErrorKind::NotFound => return None,
            Err(error) => error,
        };
        health.set_aside(directory, name, CONTENTS, &error, now());
        None
    }
}

/// Troubles of the files of this node, for the report of a cell.
pub(super) fn troubles(health: &StateHealth, node: &str) -> impl Iterator<Item = Trouble> {
    state_troubles(health, now()).into_iter().map(move |trouble| Trouble {
        about: format!("{} {node}", trouble.about).into(),
        text: format!("node {node}: {}", trouble.text),
        ..trouble
    })
}

fn hash(engine: &[u8]) -> [u8; HASH] {
    *Sha256::digest(engine).first_chunk().expect("32 octets")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn damaged_copy_is_set_aside_and_written_anew() {
        let directory = std::env::temp_dir().join(format!("utm-fusion-copy-{}", std::process::id()));
        let health = StateHealth::default();
        let copy = Copy::of(&directory, "north", "all", &health);
        assert_eq!(copy.kept(), None);
        copy.keep(&[7; 100]);
        assert_eq!(copy.kept(), Some(vec![7; 100]));
        let file = directory.join("cluster-north-all.engine");
        let whole = std::fs::read(&file).unwrap();
        for cut in 0..whole.len() {
            std::fs::write(&file, &whole[..cut]).unwrap();
            assert_eq!(copy.kept(), None, "{cut}");
        }
        for place in 0..whole.len() {
            let mut damaged = whole.clone();
            damaged[place] ^= 1;
            std::fs::write(&file, damaged).unwrap();
            assert_eq!(copy.kept(), None, "{place}");
        }
        std::fs::create_dir_all(&file).unwrap();
        assert_eq!(copy.kept(), None);
        std::fs::create_dir_all(directory.join("cluster-north-all.engine.part")).unwrap();
        copy.keep(&[8; 9]);
        assert!(health.all()["cluster-north-all.engine"].failing.is_some(), "a directory is in the way");
        copy.keep(&[8; 9]);
        assert_eq!(copy.kept(), Some(vec![8; 9]));
        assert!(health.all()["cluster-north-all.engine"].failing.is_none());
        std::fs::remove_dir_all(&directory).unwrap();
    }
}
