//! Work shared by threads, on each item independently, so that the number of threads affects only the duration.

use std::num::NonZeroUsize;
use std::thread;

use super::tuning::THREAD_LEAST;

/// Number of items for a thread. Each thread has at least [`THREAD_LEAST`], so that it is worth its start.
fn share(count: usize, threads: NonZeroUsize) -> usize {
    count.div_ceil((count / THREAD_LEAST).clamp(1, threads.get())).max(1)
}

/// Processes parts of the items, each on a thread of its own, the first on this one.
pub(super) fn on_parts<T: Send>(threads: NonZeroUsize, things: &mut [T], work: impl Fn(&mut [T]) + Sync) {
    let share = share(things.len(), threads);
    if things.len() <= share {
        return work(things);
    }
    let (own, others) = things.split_at_mut(share);
    thread::scope(|scope| {
        let work = &work;
        for part in others.chunks_mut(share) {
            scope.spawn(move || work(part));
        }
        work(own);
    });
}

/// Processes each item.
pub(super) fn on_each<T: Send>(threads: NonZeroUsize, things: &mut [T], work: impl Fn(&mut T) + Sync) {
    on_parts(threads, things, |part| part.iter_mut().for_each(&work));
}

/// Maps each item; the results are in the same order.
pub(super) fn map<'a, T: Sync, R: Send>(
    threads: NonZeroUsize,
    things: &'a [T],
    work: impl Fn(&'a T) -> R + Sync,
) -> Vec<R> {
    let share = share(things.len(), threads);
    if things.len() <= share {
        return things.iter().map(work).collect();
    }
    let (own, others) = things.split_at(share);
    let of_part = |part: &'a [T]| part.iter().map(&work).collect::<Vec<R>>();
    thread::scope(|scope| {
        let of_part = &of_part;
        let parts: Vec<_> = others.chunks(share).map(|part| scope.spawn(move || of_part(part))).collect();
        let mut all = of_part(own);
        for part in parts {
            match part.join() {
                Ok(results) => all.extend(results),
                Err(panic) => std::panic::resume_unwind(panic),
            }
        }
        all
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_is_worked_on_once_and_in_order() {
        for count in [0, 1, THREAD_LEAST, THREAD_LEAST + 1, 5 * THREAD_LEAST + 7] {
            for threads in [1, 2, 3, 8] {
                let threads = NonZeroUsize::new(threads).unwrap();
                let mut things: Vec<usize> = (0..count).collect();
                let doubled: Vec<usize> = (0..count).map(|thing| 2 * thing).collect();
                assert_eq!(map(threads, &things, |thing| 2 * thing), doubled);
                on_each(threads, &mut things, |thing| *thing *= 2);
                assert_eq!(things, doubled);
            }
        }
    }
}
