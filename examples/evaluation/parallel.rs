//! Runs several flights at a time.

use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Applies `of` to each element and its index, `threads` at a time. Returns the results in the order of `all`.
pub fn each<T: Sync, R: Send>(all: &[T], threads: usize, of: impl Fn(usize, &T) -> R + Sync) -> Vec<R> {
    let next = AtomicUsize::new(0);
    let made: Mutex<Vec<Option<R>>> = Mutex::new(all.iter().map(|_| None).collect());
    std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            scope.spawn(|| {
                while let Some((place, one)) = {
                    let place = next.fetch_add(1, Ordering::Relaxed);
                    all.get(place).map(|one| (place, one))
                } {
                    let result = of(place, one);
                    made.lock().expect("no other one has panicked")[place] = Some(result);
                }
            });
        }
    });
    let made = made.into_inner().expect("none has panicked");
    made.into_iter().map(|one| one.expect("every one was taken")).collect()
}
