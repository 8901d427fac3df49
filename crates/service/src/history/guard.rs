//! Guarded access to the database: redb reports most damage of its file as an error, but panics on the rest.

use std::any::Any;
use std::fs;
use std::io::ErrorKind;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use redb::{Database, Error, ReadableDatabase, ReadableTable};

use super::{CACHE, MINUTES, PICTURES, SIZES, TRAILS, cost};

/// Error code of the system: a part of the disk cannot be read.
const EIO: i32 = 5;

/// Runs an access to the database, and converts a panic to an error.
pub(super) fn guarded<T>(access: impl FnOnce() -> Result<T, Error>) -> Result<T, Error> {
    // A panic can leave only the database inconsistent, and the database is not used again.
    catch_unwind(AssertUnwindSafe(access)).unwrap_or_else(|panic| Err(Error::Corrupted(text(&*panic))))
}

fn text(panic: &(dyn Any + Send)) -> String {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("panic").to_owned()
}

/// Whether an error means that the file is damaged, or not a history. A full disk, missing permissions and use by another
/// process are not damage.
pub(super) fn is_damage(error: &Error) -> bool {
    match error {
        Error::Io(error) => {
            let kinds = [ErrorKind::InvalidData, ErrorKind::UnexpectedEof, ErrorKind::InvalidInput];
            kinds.contains(&error.kind()) || error.raw_os_error() == Some(EIO)
        }
        Error::Corrupted(_)
        | Error::UpgradeRequired(_)
        | Error::LockPoisoned(_)
        | Error::TableTypeMismatch { .. }
        | Error::TableIsMultimap(_)
        | Error::TableIsNotMultimap(_)
        | Error::TypeDefinitionChanged { .. }
        | Error::TableDoesNotExist(_) => true,
        _ => false,
    }
}

/// Opens or creates the file, and verifies all of it: a damaged page is found here, not when it is read later.
pub(super) fn open(path: &Path) -> Result<Database, Error> {
    path.parent().map_or(Ok(()), fs::create_dir_all)?;
    if fs::metadata(path).is_ok_and(|metadata| !metadata.is_file()) {
        return Err(Error::Corrupted("it is no file".to_owned()));
    }
    guarded(|| {
        let mut database = Database::builder().set_cache_size(CACHE).create(path)?;
        if !database.check_integrity()? {
            tracing::info!(file = %path.display(), "history was repaired");
        }
        // Written only if the tables do not exist yet: on a full disk the write would fail.
        if database.begin_read()?.open_table(MINUTES).is_err() {
            let writing = database.begin_write()?;
            writing.delete_table(TRAILS)?;
            let mut octets = 0;
            for picture in writing.open_table(PICTURES)?.iter()? {
                octets += cost("", picture?.1.value());
            }
            writing.open_table(MINUTES)?;
            writing.open_table(SIZES)?.insert(0, octets)?;
            writing.commit()?;
        }
        Ok(database)
    })
}
