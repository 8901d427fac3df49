//! The line that gateways post to over HTTP. What is posted goes the way of a datagram; a gateway never waits for the engine,
//! nor the engine for a gateway.

use std::fmt;
use std::net::{IpAddr, Ipv4Addr, SocketAddrV4};
use std::sync::atomic::Ordering;
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use tokio::sync::watch;

use super::clock::Clock;
use crate::gateways::remote_id::{Counts, Receivers};
use crate::net::listen::{Arrival, LineCounters};

/// The line; cheap to clone. It is closed with the last of its clones, or when it is told to.
#[derive(Clone, Debug)]
pub struct Posts(Arc<Inner>);

struct Inner {
    line: usize,
    counters: Arc<LineCounters>,
    clock: Clock,
    /// The sensors that are posted to.
    receivers: Receivers,
    /// Lines that may wait for the engine: what is beyond is turned away, so that a gateway without measure costs no sensor
    /// its datagrams.
    most: u64,
    /// `None`: it is closed.
    open: Mutex<Option<Open>>,
}

struct Open {
    sender: SyncSender<Arrival>,
    /// Since the start.
    counts: Counts,
}

impl fmt::Debug for Inner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Posts").field("line", &self.line).finish_non_exhaustive()
    }
}

/// What came of a text that was posted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Posted {
    /// Its lines; those that were sound are `taken`, or turned away.
    pub counts: Counts,
    /// Sound lines that there was no room for: the last ones of the text.
    pub turned_away: u64,
}

/// Why nothing was taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NotPosted {
    /// The service ends, and hears nothing any more.
    #[error("the service stops")]
    Closed,
}

impl Posts {
    /// The line of that index, open; of what is posted at most `most` lines wait for who receives them, who counts what it
    /// has taken in `counters`. A line may name one of the `receivers` only.
    pub fn new(
        line: usize,
        counters: Arc<LineCounters>,
        clock: Clock,
        receivers: Receivers,
        sender: SyncSender<Arrival>,
        most: u64,
    ) -> Self {
        counters.joined.store(true, Ordering::Relaxed);
        let open = Mutex::new(Some(Open { sender, counts: Counts::default() }));
        Self(Arc::new(Inner { line, counters, clock, receivers, most, open }))
    }

    /// Takes the lines of a text, each as a datagram that is received now; those that are unsound are counted.
    ///
    /// # Errors
    /// The line is closed.
    pub fn post(&self, from: Option<IpAddr>, text: &[u8]) -> Result<Posted, NotPosted> {
        let Inner { line, counters, clock, receivers, most, open } = &*self.0;
        // One after the other: what is taken is in the order of its times.
        let mut open = open.lock().unwrap_or_else(PoisonError::into_inner);
        let Open { sender, counts } = open.as_mut().ok_or(NotPosted::Closed)?;
        let from = match from.map(|from| from.to_canonical()) {
            Some(IpAddr::V4(from)) => from,
            _ => Ipv4Addr::UNSPECIFIED,
        };
        let (received, from) = (clock.now(), SocketAddrV4::new(from, 0));
        let count = |counter: &std::sync::atomic::AtomicU64| counter.load(Ordering::Relaxed);
        let mut room =
            most.saturating_sub(count(&counters.received).saturating_sub(count(&counters.handled)));
        let mut posted = Posted::default();
        posted.counts.lines(text, receivers, |payload| {
            let arrival = Arrival { line: *line, received, from, payload: payload.to_vec() };
            let is_taken = room > 0 && sender.try_send(arrival).is_ok();
            // Where one has no room, none behind it has.
            room = if is_taken { room - 1 } else { 0 };
            posted.turned_away += u64::from(!is_taken);
            counters.note(received, is_taken);
        });
        posted.counts.taken -= posted.turned_away;
        counts.join(&posted.counts);
        counters.note_untranslated(counts.refused.iter());
        Ok(posted)
    }

    /// The sensors that lines may name.
    pub fn receivers(&self) -> &Receivers {
        &self.0.receivers
    }

    /// Closes it as soon as that is `true`, or nobody keeps it any more; what was taken by then stays taken.
    pub(super) fn close_when(&self, mut stopped: watch::Receiver<bool>) -> impl Future<Output = ()> + use<> {
        let inner: Weak<Inner> = Arc::downgrade(&self.0);
        async move {
            let _ = stopped.wait_for(|stopped| *stopped).await;
            inner.upgrade().iter().for_each(|inner| inner.close());
        }
    }
}

impl Inner {
    fn close(&self) {
        *self.open.lock().unwrap_or_else(PoisonError::into_inner) = None;
        self.counters.joined.store(false, Ordering::Relaxed);
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        self.close();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, sync_channel};

    use super::*;

    const LINE: &str = r#"{"transmitter":"a","message":"10"}"#;

    fn line(most: u64, queue: usize) -> (Posts, Arc<LineCounters>, Receiver<Arrival>) {
        let counters = Arc::<LineCounters>::default();
        let (sender, arrivals) = sync_channel(queue);
        (
            Posts::new(3, counters.clone(), Clock::default(), Receivers::default(), sender, most),
            counters,
            arrivals,
        )
    }

    #[test]
    fn what_has_no_room_is_turned_away_and_counted_and_never_waits() {
        for (most, queue) in [(2, 100), (100, 2)] {
            let (posts, counters, arrivals) = line(most, queue);
            let text = format!("{LINE}\nnonsense\n\n{LINE}\n{LINE}\n{LINE}");
            let posted = posts.post(Some([10, 0, 0, 7].into()), text.as_bytes()).unwrap();
            assert_eq!((posted.counts.lines, posted.counts.taken, posted.turned_away), (5, 2, 2));
            assert_eq!(posted.counts.refused.total(), 1);
            let again = posts.post(None, LINE.as_bytes()).unwrap();
            assert_eq!((again.counts.taken, again.turned_away), (0, 1));
            let taken: Vec<Arrival> = arrivals.try_iter().collect();
            assert!(taken.iter().all(|arrival| arrival.line == 3 && arrival.payload == LINE.as_bytes()));
            assert_eq!((taken.len(), taken[0].from.to_string()), (2, "10.0.0.7:0".to_owned()));
            let count = |counter: &std::sync::atomic::AtomicU64| counter.load(Ordering::Relaxed);
            assert_eq!([&counters.received, &counters.queue_full].map(count), [2, 3]);
            assert_eq!(counters.untranslated()[0], ("line_not_an_object", 1));
            // The engine has taken them: there is room again.
            counters.handled.fetch_add(2, Ordering::Relaxed);
            assert_eq!(
                posts.post(Some("::ffff:10.0.0.8".parse().unwrap()), LINE.as_bytes()).unwrap().turned_away,
                0
            );
            assert_eq!(arrivals.try_recv().unwrap().from.ip(), &Ipv4Addr::new(10, 0, 0, 8));
            assert_eq!(
                posts.post(Some("2001:db8::1".parse().unwrap()), LINE.as_bytes()).unwrap().turned_away,
                0
            );
            assert_eq!(arrivals.try_recv().unwrap().from.ip(), &Ipv4Addr::UNSPECIFIED);
        }
    }

    #[tokio::test]
    async fn what_was_taken_before_it_is_closed_is_there_and_nothing_comes_behind() {
        let (posts, counters, arrivals) = line(9, 9);
        assert!(counters.joined.load(Ordering::Relaxed));
        let (stop, stopped) = watch::channel(false);
        let closed = posts.close_when(stopped);
        posts.post(None, LINE.as_bytes()).unwrap();
        stop.send_replace(true);
        closed.await;
        assert_eq!(posts.post(None, LINE.as_bytes()), Err(NotPosted::Closed));
        assert!(!counters.joined.load(Ordering::Relaxed));
        assert_eq!(arrivals.iter().count(), 1, "and the queue is at its end");
    }

    #[test]
    fn where_nobody_keeps_it_it_is_closed() {
        let (posts, counters, arrivals) = line(9, 9);
        drop(posts);
        assert!(!counters.joined.load(Ordering::Relaxed) && arrivals.recv().is_err());
    }
}
