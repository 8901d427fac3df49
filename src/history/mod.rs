//! History: a picture per second, in an embedded database that is bounded by age and by size.
//!
//! One writer, on a thread of its own behind a bounded queue ([`Historian`]); readers at any time ([`Store`]).

mod codec;
mod historian;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock, TryLockError};

use jiff::SignedDuration;
use redb::{Database, ReadTransaction, ReadableDatabase, ReadableTable, TableDefinition};

pub use codec::SavedTrack;
pub use historian::Historian;

use crate::config::Persistence;
use crate::current::Current;
use fusion::time::Time;

/// Pictures by time, nanoseconds since the epoch.
const PICTURES: TableDefinition<'_, i64, &[u8]> = TableDefinition::new("pictures");
/// Places by track id and time.
const TRAILS: TableDefinition<'_, (&str, i64), &[u8]> = TableDefinition::new("trails");
/// Octets of both, under 0.
const SIZES: TableDefinition<'_, u8, u64> = TableDefinition::new("sizes");

/// Cost of a place in a trail besides its octets: its key's time, and the database's own bookkeeping.
const OVERHEAD: u64 = 24;
/// Cache of the database, octets: the system caches the file as well. By default it takes up to a gigabyte.
const CACHE: usize = 4 << 20;
/// Pictures removed in one transaction.
const BATCH: usize = 256;

/// How much is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Pictures older than this are removed.
    pub age: SignedDuration,
    /// The oldest are removed while there is more than this, octets.
    pub octets: u64,
}

impl Limits {
    /// Those of a configuration; `None`: no history is kept.
    pub fn of(state: &Persistence) -> Option<Self> {
        (state.history_hours > 0.0).then(|| Self {
            age: SignedDuration::from_secs((state.history_hours * 3600.0) as i64),
            octets: u64::from(state.history_mib) << 20,
        })
    }
}

/// The history; cheap to clone.
#[derive(Clone, Debug)]
pub struct Store(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    path: PathBuf,
    limits: Current<Limits>,
    /// `None`: it could not be opened.
    database: RwLock<Option<Database>>,
    counters: Counters,
}

#[derive(Debug, Default)]
struct Counters {
    lost: AtomicU64,
    failing: AtomicBool,
}

/// Why the history cannot be opened; it never disturbs the service.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {source}")]
pub struct StoreError {
    path: PathBuf,
    source: redb::Error,
}

/// A saved picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    /// Its time of applicability.
    pub time: Time,
    /// Its tracks.
    pub tracks: Vec<SavedTrack>,
}

impl Store {
    /// Opens the file, or makes it.
    ///
    /// # Errors
    /// It cannot be made, is in use by another process, or is no history.
    pub fn open(path: &Path, limits: Limits) -> Result<Self, StoreError> {
        let store = Self::closed(path, limits);
        store.reopen()?;
        Ok(store)
    }

    /// A store that is to be opened by [`Store::reopen`].
    pub fn closed(path: &Path, limits: Limits) -> Self {
        Self(Arc::new(Inner {
            path: path.to_owned(),
            limits: limits.into(),
            database: RwLock::default(),
            counters: Counters::default(),
        }))
    }

    /// Opens the file anew, or makes it. After a failed write a database takes and gives nothing until then.
    ///
    /// # Errors
    /// As [`Store::open`].
    pub fn reopen(&self) -> Result<(), StoreError> {
        let path = &self.0.path;
        let mut database = self.0.database.write().unwrap_or_else(PoisonError::into_inner);
        // The old one has the file's lock.
        drop(database.take());
        let open = || -> Result<Database, redb::Error> {
            path.parent().map_or(Ok(()), std::fs::create_dir_all)?;
            let database = Database::builder().set_cache_size(CACHE).create(path)?;
            // A full disk would not take the tables once more.
            if database.begin_read()?.open_table(SIZES).is_err() {
                let writing = database.begin_write()?;
                writing.open_table(PICTURES)?;
                writing.open_table(TRAILS)?;
                writing.open_table(SIZES)?;
                writing.commit()?;
            }
            Ok(database)
        };
        *database = Some(open().map_err(|source| StoreError { path: path.clone(), source })?);
        Ok(())
    }

    /// Sets other limits; what is beyond them is removed with the next write.
    pub fn limit(&self, limits: Limits) {
        self.0.limits.replace(limits);
    }

    /// Pictures that were not kept.
    pub fn lost(&self) -> u64 {
        self.0.counters.lost.load(Ordering::Relaxed)
    }

    /// Whether it cannot be written.
    pub fn is_failing(&self) -> bool {
        self.0.counters.failing.load(Ordering::Relaxed)
    }

    /// Reads; never waits for the file to be opened.
    fn read<T>(
        &self,
        what: impl FnOnce(ReadTransaction) -> Result<T, redb::Error>,
    ) -> Result<T, redb::Error> {
        let database = match self.0.database.try_read() {
            Ok(database) => database,
            Err(TryLockError::Poisoned(poisoned)) => poisoned.into_inner(),
            Err(TryLockError::WouldBlock) => return Err(redb::Error::DatabaseClosed),
        };
        what(database.as_ref().ok_or(redb::Error::DatabaseClosed)?.begin_read()?)
    }

    /// Saves pictures, all or none, and removes what is too old or too much.
    ///
    /// # Errors
    /// The disk is full, for example: nothing of these is kept then.
    pub fn keep(&self, pictures: &[Snapshot]) -> Result<(), redb::Error> {
        let limits = self.0.limits.get();
        let database = self.0.database.read().unwrap_or_else(PoisonError::into_inner);
        let writing = database.as_ref().ok_or(redb::Error::DatabaseClosed)?.begin_write()?;
        {
            let mut by_time = writing.open_table(PICTURES)?;
            let mut trails = writing.open_table(TRAILS)?;
            let mut sizes = writing.open_table(SIZES)?;
            let mut octets = sizes.get(0)?.map_or(0, |octets| octets.value());
            for picture in pictures {
                let time = picture.time.nanos();
                let whole = codec::picture(&picture.tracks);
                octets += cost(&picture.tracks, whole.len());
                by_time.insert(time, whole.as_slice())?;
                for track in &picture.tracks {
                    trails.insert((track.id.as_str(), time), codec::place(track).as_slice())?;
                }
            }
            let newest = by_time.last()?.map_or(i64::MIN, |(time, _)| time.value());
            let oldest = newest.saturating_sub(limits.age.as_nanos() as i64);
            for _ in 0..BATCH {
                let Some((time, whole)) =
                    by_time.first()?.map(|(time, whole)| (time.value(), whole.value().to_vec()))
                else {
                    break;
                };
                if time >= oldest && octets <= limits.octets {
                    break;
                }
                let tracks = codec::tracks(&whole).unwrap_or_default();
                octets = octets.saturating_sub(cost(&tracks, whole.len()));
                for track in &tracks {
                    trails.remove((track.id.as_str(), time))?;
                }
                by_time.remove(time)?;
            }
            sizes.insert(0, octets)?;
        }
        writing.commit()?;
        Ok(())
    }

    /// The latest picture at `at` or at most `within` before; `None` where there is none.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn snapshot(&self, at: Time, within: SignedDuration) -> Result<Option<Snapshot>, redb::Error> {
        self.read(|reading| {
            let table = reading.open_table(PICTURES)?;
            let from = at.nanos().saturating_sub(within.as_nanos() as i64);
            let Some(last) = table.range(from..=at.nanos())?.next_back() else { return Ok(None) };
            let (time, whole) = last?;
            let tracks = codec::tracks(whole.value()).unwrap_or_default();
            Ok(Some(Snapshot { time: Time::from_nanos(time.value()), tracks }))
        })
    }

    /// Where a track was from `since` to `until`, in order of time; at most `limit` places, the latest ones.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn trail(
        &self,
        id: &str,
        since: Time,
        until: Time,
        limit: usize,
    ) -> Result<Vec<(Time, SavedTrack)>, redb::Error> {
        self.read(|reading| {
            let table = reading.open_table(TRAILS)?;
            let mut places = Vec::new();
            for entry in table.range((id, since.nanos())..=(id, until.nanos()))?.rev().take(limit) {
                let (key, place) = entry?;
                let track = codec::track(id, place.value());
                places.extend(track.map(|track| (Time::from_nanos(key.value().1), track)));
            }
            places.reverse();
            Ok(places)
        })
    }

    /// The times of the first and the last picture.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn span(&self) -> Result<Option<(Time, Time)>, redb::Error> {
        self.read(|reading| {
            let table = reading.open_table(PICTURES)?;
            let first = table.first()?.map(|(time, _)| Time::from_nanos(time.value()));
            let last = table.last()?.map(|(time, _)| Time::from_nanos(time.value()));
            Ok(first.zip(last))
        })
    }

    /// Octets that are kept, about.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn octets(&self) -> Result<u64, redb::Error> {
        self.read(|reading| Ok(reading.open_table(SIZES)?.get(0)?.map_or(0, |octets| octets.value())))
    }
}

fn cost(tracks: &[SavedTrack], whole: usize) -> u64 {
    let places: u64 =
        tracks.iter().map(|track| (codec::place(track).len() + track.id.len()) as u64 + OVERHEAD).sum();
    places + whole as u64 + OVERHEAD
}

#[cfg(test)]
mod tests;
