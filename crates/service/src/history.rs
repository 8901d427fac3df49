//! History: one picture per second, in an embedded database that is bounded by age and size.
//!
//! A picture is kept as it is until its minute is over. Then the minute is kept track by track (`minute.rs`), in a tenth of
//! the space.
//!
//! There is one writer, on its own thread behind a bounded queue ([`Historian`]), and readers at any time ([`HistoryStore`]). The
//! writer opens the file and verifies it; a damaged one is set aside (`guard.rs`).

mod codec;
mod folds;
mod guard;
mod historian;
mod minute;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock, TryLockError};

use jiff::SignedDuration;
use redb::{Database, ReadTransaction, ReadableDatabase, ReadableTable, TableDefinition};

pub use codec::HistoryTrack;
pub use historian::Historian;

use crate::current::Current;
use crate::live::now;
use crate::state::StateHealth;
use fusion::time::{SECOND, Time};
use site::config::Persistence;

/// Name of the file in the directory of `[state]`.
const NAME: &str = "history.redb";
/// Pictures of minutes that are not over, by time, in nanoseconds since the epoch. Up to version 0.6 all pictures were
/// here.
const PICTURES: TableDefinition<'_, i64, &[u8]> = TableDefinition::new("pictures");
/// Minutes that are over, by the minute since the epoch and a track's id. The empty id holds the times of the pictures, in
/// nanoseconds.
const MINUTES: TableDefinition<'_, (i64, &str), &[u8]> = TableDefinition::new("minutes");
/// Size of both tables in octets, under the key 0.
const SIZES: TableDefinition<'_, u8, u64> = TableDefinition::new("sizes");
/// Places by track id and time, up to version 0.6.
const TRAILS: TableDefinition<'_, (&str, i64), &[u8]> = TableDefinition::new("trails");

/// Approximate size of an entry in the file beside key and value, in octets.
const OVERHEAD: u64 = 24;
/// Cache of the database, in octets. It is small because the system caches the file as well; the default is up to a
/// gigabyte.
const CACHE: usize = 4 << 20;
/// Maximum number of minutes folded in one transaction, and of entries of each kind removed.
const FOLDED: usize = 4;
const BATCH: usize = 256;
const MINUTE: i64 = 60 * SECOND;

/// Limits of the history.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HistoryLimits {
    /// Pictures older than this are removed, a minute at a time.
    pub age: SignedDuration,
    /// Maximum size in octets; above it the oldest pictures are removed.
    pub octets: u64,
}

impl HistoryLimits {
    /// Limits of a configuration; `None`: no history is kept.
    pub fn of(state: &Persistence) -> Option<Self> {
        (state.history_hours > 0.0).then(|| Self {
            age: SignedDuration::from_secs((state.history_hours * 3600.0) as i64),
            octets: u64::from(state.history_mib) << 20,
        })
    }
}

/// The history; cheap to clone.
#[derive(Clone, Debug)]
pub struct HistoryStore(Arc<HistoryState>);

#[derive(Debug)]
struct HistoryState {
    path: PathBuf,
    limits: Current<HistoryLimits>,
    /// `None`: it could not be opened.
    database: RwLock<Option<Database>>,
    /// Records damage.
    health: StateHealth,
    counters: HistoryCounters,
}

#[derive(Debug, Default)]
struct HistoryCounters {
    lost: AtomicU64,
    failing: AtomicBool,
    /// Whether reading or writing has found damage since the file was opened.
    damaged: AtomicBool,
}

/// Reason why the history cannot be opened; the service runs without it.
#[derive(Debug, thiserror::Error)]
#[error("{path}: {source}")]
pub struct StoreError {
    path: PathBuf,
    source: redb::Error,
}

/// A saved picture.
#[derive(Clone, Debug, PartialEq)]
pub struct HistoryPicture {
    /// Time of applicability.
    pub time: Time,
    /// Tracks of the picture.
    pub tracks: Vec<HistoryTrack>,
}

impl HistoryStore {
    /// Opens or creates the file.
    ///
    /// # Errors
    /// The file cannot be created, is in use by another process, or is damaged.
    pub fn open(path: &Path, limits: HistoryLimits) -> Result<Self, StoreError> {
        let store = Self::new(path.to_owned(), limits, StateHealth::default());
        store.reopen()?;
        Ok(store)
    }

    /// History of a state directory, to be opened by its [`Historian`]. Damage is recorded in `health`.
    pub fn closed(directory: &Path, limits: HistoryLimits, health: StateHealth) -> Self {
        Self::new(directory.join(NAME), limits, health)
    }

    fn new(path: PathBuf, limits: HistoryLimits, health: StateHealth) -> Self {
        Self(Arc::new(HistoryState {
            path,
            limits: limits.into(),
            database: RwLock::default(),
            health,
            counters: HistoryCounters::default(),
        }))
    }

    /// Opens the file again, or creates it. After a failed write the database is unusable until then.
    ///
    /// # Errors
    /// As for [`HistoryStore::open`].
    pub fn reopen(&self) -> Result<(), StoreError> {
        self.open_again().map_err(|source| StoreError { path: self.0.path.clone(), source })
    }

    fn open_again(&self) -> Result<(), redb::Error> {
        let mut database = self.0.database.write().unwrap_or_else(PoisonError::into_inner);
        // The old database holds the file's lock.
        if let Some(old) = database.take() {
            match self.0.counters.damaged.load(Ordering::Relaxed) {
                // Closing it would write to the damaged file, and may panic again.
                true => std::mem::forget(old),
                false => guard::guarded(|| {
                    drop(old);
                    Ok(())
                })?,
            }
        }
        *database = Some(guard::open(&self.0.path)?);
        self.0.counters.damaged.store(false, Ordering::Relaxed);
        Ok(())
    }

    /// Opens the file again, or creates it; a damaged one is set aside, and a new one begun.
    fn open_or_replace(&self) -> Result<(), redb::Error> {
        match self.is_damaged() {
            true => self.replace(&"a page cannot be read"),
            false => match self.open_again() {
                Err(error) if guard::is_damage(&error) => self.replace(&error),
                opened => opened,
            },
        }
    }

    /// Sets the damaged file aside, and begins a new one.
    fn replace(&self, error: &dyn std::fmt::Display) -> Result<(), redb::Error> {
        self.0.counters.damaged.store(true, Ordering::Relaxed);
        let path = &self.0.path;
        let name = path.file_name().and_then(|name| name.to_str()).unwrap_or(NAME);
        self.0.health.set_aside(path.parent().unwrap_or(Path::new("")), name, "history", error, now());
        self.open_again()
    }

    fn is_open(&self) -> bool {
        self.0.database.read().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    /// Whether reading or writing has found damage since the file was opened.
    fn is_damaged(&self) -> bool {
        self.0.counters.damaged.load(Ordering::Relaxed)
    }

    /// Accesses the database; records damage, so that the writer sets the file aside.
    fn access<T>(&self, access: impl FnOnce() -> Result<T, redb::Error>) -> Result<T, redb::Error> {
        let accessed = guard::guarded(access);
        if accessed.as_ref().is_err_and(guard::is_damage) {
            self.0.counters.damaged.store(true, Ordering::Relaxed);
        }
        accessed
    }

    /// Sets new limits; pictures beyond them are removed with the next write.
    pub fn limit(&self, limits: HistoryLimits) {
        self.0.limits.replace(limits);
    }

    /// Number of pictures that were not kept.
    pub fn lost(&self) -> u64 {
        self.0.counters.lost.load(Ordering::Relaxed)
    }

    /// Whether the file cannot be written.
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
        let database = database.as_ref().ok_or(redb::Error::DatabaseClosed)?;
        if self.is_damaged() {
            return Err(redb::Error::Corrupted("it is about to be set aside".to_owned()));
        }
        self.access(|| what(database.begin_read()?))
    }

    /// Saves all pictures or none, and removes those beyond the limits.
    ///
    /// # Errors
    /// The disk is full, for example; then none of the pictures is kept.
    pub fn keep(&self, pictures: &[HistoryPicture]) -> Result<(), redb::Error> {
        let database = self.0.database.read().unwrap_or_else(PoisonError::into_inner);
        let database = database.as_ref().ok_or(redb::Error::DatabaseClosed)?;
        self.access(|| self.write(database, pictures))
    }

    fn write(&self, database: &Database, pictures: &[HistoryPicture]) -> Result<(), redb::Error> {
        let limits = self.0.limits.get();
        let writing = database.begin_write()?;
        {
            let mut recent = writing.open_table(PICTURES)?;
            let mut minutes = writing.open_table(MINUTES)?;
            let mut sizes = writing.open_table(SIZES)?;
            let mut octets = sizes.get(0)?.map_or(0, |octets| octets.value());
            for picture in pictures {
                let whole = codec::picture(&picture.tracks);
                octets += cost("", &whole);
                if let Some(before) = recent.insert(picture.time.nanos(), whole.as_slice())? {
                    octets = octets.saturating_sub(cost("", before.value()));
                }
            }
            let newest = recent.last()?.map_or(i64::MIN, |(time, _)| time.value());
            for _ in 0..FOLDED {
                let first = recent.first()?.map(|(time, _)| time.value().div_euclid(MINUTE));
                let Some(over) = first.filter(|minute| *minute < newest.div_euclid(MINUTE)) else { break };
                octets = octets.saturating_add_signed(folds::fold(over, &mut recent, &mut minutes)?);
            }
            let oldest = newest.saturating_sub(limits.age.as_nanos() as i64);
            for _ in 0..BATCH {
                let is_too_much = octets > limits.octets;
                let Some(removed) = folds::forget(oldest, is_too_much, &mut recent, &mut minutes)? else {
                    break;
                };
                octets = octets.saturating_sub(removed);
            }
            sizes.insert(0, octets)?;
        }
        writing.commit()?;
        Ok(())
    }

    /// The latest picture at `at` or at most `within` before; `None` if there is none.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn snapshot(&self, at: Time, within: SignedDuration) -> Result<Option<HistoryPicture>, redb::Error> {
        self.read(|reading| {
            let from = at.nanos().saturating_sub(within.as_nanos() as i64);
            let recent = reading.open_table(PICTURES)?;
            let last = recent.range(from..=at.nanos())?.next_back().transpose()?;
            let last =
                last.map(|(time, whole)| (time.value(), codec::tracks(whole.value()).unwrap_or_default()));
            let folded = folds::picture(&reading.open_table(MINUTES)?, from, at.nanos())?;
            let latest = [last, folded].into_iter().flatten().max_by_key(|(time, _)| *time);
            Ok(latest.map(|(time, tracks)| HistoryPicture { time: Time::from_nanos(time), tracks }))
        })
    }

    /// Places of a track from `since` to `until`, in order of time; at most the `limit` latest.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn trail(
        &self,
        id: &str,
        since: Time,
        until: Time,
        limit: usize,
    ) -> Result<Vec<(Time, HistoryTrack)>, redb::Error> {
        self.read(|reading| {
            let span = since.nanos()..=until.nanos();
            let mut places = folds::trail(&reading.open_table(MINUTES)?, id, &span, limit)?;
            for entry in reading.open_table(PICTURES)?.range(span)? {
                let (time, whole) = entry?;
                let track = codec::tracks(whole.value()).into_iter().flatten().find(|track| track.id == id);
                places.extend(track.map(|track| (Time::from_nanos(time.value()), track)));
            }
            // A clock that was set back writes into minutes that are over.
            places.sort_by_key(|(time, _)| *time);
            places.drain(..places.len().saturating_sub(limit));
            Ok(places)
        })
    }

    /// Times of the first and the last picture.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn span(&self) -> Result<Option<(Time, Time)>, redb::Error> {
        self.read(|reading| {
            let recent = reading.open_table(PICTURES)?;
            let ends = [recent.first()?, recent.last()?].into_iter().flatten();
            let mut times: Vec<i64> = ends.map(|(time, _)| time.value()).collect();
            times.extend(folds::ends(&reading.open_table(MINUTES)?)?);
            let span = times.iter().min().zip(times.iter().max());
            Ok(span.map(|(first, last)| (Time::from_nanos(*first), Time::from_nanos(*last))))
        })
    }

    /// Approximate size of the history, in octets.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn octets(&self) -> Result<u64, redb::Error> {
        self.read(|reading| Ok(reading.open_table(SIZES)?.get(0)?.map_or(0, |octets| octets.value())))
    }
}

/// Approximate size of an entry in the file, in octets; `id` is the id in its key. Pages are half full if keys are added in
/// order.
fn cost(id: &str, value: &[u8]) -> u64 {
    2 * ((id.len() + value.len()) as u64 + OVERHEAD)
}

#[cfg(test)]
mod damaged;
#[cfg(test)]
mod tests;
