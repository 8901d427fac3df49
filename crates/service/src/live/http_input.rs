//! Input for gateways that post Remote ID over HTTP. Posted lines are handled like datagrams. Gateway and engine never wait
//! for each other.

use std::fmt;
use std::net::{IpAddr, Ipv4Addr, SocketAddrV4};
use std::sync::atomic::Ordering;
use std::sync::mpsc::SyncSender;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use tokio::sync::watch;

use crate::clock::WallClock;
use crate::net::listen::{Arrival, LineCounters};
use input::gateways::remote_id::{ReceiverIds, RemoteIdLineCounts};

/// The input; cheap to clone. Closed by a stop signal, or when the last clone is dropped.
#[derive(Clone, Debug)]
pub struct HttpInput(Arc<HttpInputState>);

struct HttpInputState {
    line: usize,
    counters: Arc<LineCounters>,
    clock: WallClock,
    /// Sensors that gateways may post for.
    receivers: ReceiverIds,
    /// Maximum number of lines waiting for the engine. Further lines are rejected, so that a flooding gateway costs no
    /// other sensor its datagrams.
    limit: u64,
    /// `None`: closed.
    open: Mutex<Option<OpenQueue>>,
}

struct OpenQueue {
    sender: SyncSender<Arrival>,
    /// Counts since the start.
    counts: RemoteIdLineCounts,
}

impl fmt::Debug for HttpInputState {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("HttpInput").field("line", &self.line).finish_non_exhaustive()
    }
}

/// Result of a post.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PostResult {
    /// Counts of its lines; valid lines are counted as `taken`, unless rejected.
    pub counts: RemoteIdLineCounts,
    /// Number of valid lines rejected because the queue was full: the last ones of the text.
    pub turned_away: u64,
}

/// Reasons for accepting no line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum PostError {
    /// The service is stopping.
    #[error("the service stops")]
    Closed,
}

impl HttpInput {
    /// The open input of that index. At limit `limit` lines wait for the receiver, which counts the handled ones in
    /// `counters`. A line may name only one of the `receivers`.
    pub fn new(
        line: usize,
        counters: Arc<LineCounters>,
        clock: WallClock,
        receivers: ReceiverIds,
        sender: SyncSender<Arrival>,
        limit: u64,
    ) -> Self {
        counters.joined.store(true, Ordering::Relaxed);
        let open = Mutex::new(Some(OpenQueue { sender, counts: RemoteIdLineCounts::default() }));
        Self(Arc::new(HttpInputState { line, counters, clock, receivers, limit, open }))
    }

    /// Accepts the lines of a text, each as a datagram received now; invalid lines are counted.
    ///
    /// # Errors
    /// The input is closed.
    pub fn post(&self, from: Option<IpAddr>, text: &[u8]) -> Result<PostResult, PostError> {
        let HttpInputState { line, counters, clock, receivers, limit, open } = &*self.0;
        // One post at a time, so that lines are queued in the order of their times.
        let mut open = open.lock().unwrap_or_else(PoisonError::into_inner);
        let OpenQueue { sender, counts } = open.as_mut().ok_or(PostError::Closed)?;
        let from = match from.map(|from| from.to_canonical()) {
            Some(IpAddr::V4(from)) => from,
            _ => Ipv4Addr::UNSPECIFIED,
        };
        let (received, from) = (clock.now(), SocketAddrV4::new(from, 0));
        let count = |counter: &std::sync::atomic::AtomicU64| counter.load(Ordering::Relaxed);
        let mut space =
            limit.saturating_sub(count(&counters.received).saturating_sub(count(&counters.handled)));
        let mut posted = PostResult::default();
        posted.counts.lines(text, receivers, |payload| {
            let arrival = Arrival { line: *line, received, from, payload: payload.to_vec() };
            let is_taken = space > 0 && sender.try_send(arrival).is_ok();
            // Once the queue is full, the remaining lines are rejected too.
            space = if is_taken { space - 1 } else { 0 };
            posted.turned_away += u64::from(!is_taken);
            counters.note(received, is_taken);
        });
        posted.counts.taken -= posted.turned_away;
        counts.join(&posted.counts);
        counters.note_untranslated(counts.refused.iter());
        Ok(posted)
    }

    /// Sensors that lines may name.
    pub fn receivers(&self) -> &ReceiverIds {
        &self.0.receivers
    }

    /// Closes the input when the signal is `true` or its sender is dropped; lines accepted before are kept.
    pub(super) fn close_when(&self, mut stopped: watch::Receiver<bool>) -> impl Future<Output = ()> + use<> {
        let inner: Weak<HttpInputState> = Arc::downgrade(&self.0);
        async move {
            let _ = stopped.wait_for(|stopped| *stopped).await;
            inner.upgrade().iter().for_each(|inner| inner.close());
        }
    }
}

impl HttpInputState {
    fn close(&self) {
        *self.open.lock().unwrap_or_else(PoisonError::into_inner) = None;
        self.counters.joined.store(false, Ordering::Relaxed);
    }
}

impl Drop for HttpInputState {
    fn drop(&mut self) {
        self.close();
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::{Receiver, sync_channel};

    use super::*;

    const LINE: &str = r#"{"transmitter":"a","message":"10"}"#;

    fn line(limit: u64, queue: usize) -> (HttpInput, Arc<LineCounters>, Receiver<Arrival>) {
        let counters = Arc::<LineCounters>::default();
        let (sender, arrivals) = sync_channel(queue);
        (
            HttpInput::new(3, counters.clone(), WallClock::default(), ReceiverIds::default(), sender, limit),
            counters,
            arrivals,
        )
    }

    #[test]
    fn lines_beyond_the_queue_are_rejected_without_waiting() {
        for (limit, queue) in [(2, 100), (100, 2)] {
            let (input, counters, arrivals) = line(limit, queue);
            let text = format!("{LINE}\nnonsense\n\n{LINE}\n{LINE}\n{LINE}");
            let posted = input.post(Some([10, 0, 0, 7].into()), text.as_bytes()).unwrap();
            assert_eq!((posted.counts.lines, posted.counts.taken, posted.turned_away), (5, 2, 2));
            assert_eq!(posted.counts.refused.total(), 1);
            let again = input.post(None, LINE.as_bytes()).unwrap();
            assert_eq!((again.counts.taken, again.turned_away), (0, 1));
            let taken: Vec<Arrival> = arrivals.try_iter().collect();
            assert!(taken.iter().all(|arrival| arrival.line == 3 && arrival.payload == LINE.as_bytes()));
            assert_eq!((taken.len(), taken[0].from.to_string()), (2, "10.0.0.7:0".to_owned()));
            let count = |counter: &std::sync::atomic::AtomicU64| counter.load(Ordering::Relaxed);
            assert_eq!([&counters.received, &counters.queue_full].map(count), [2, 3]);
            assert_eq!(counters.untranslated()[0], ("line_not_an_object", 1));
            // The engine has handled them: the queue accepts lines again.
            counters.handled.fetch_add(2, Ordering::Relaxed);
            assert_eq!(
                input.post(Some("::ffff:10.0.0.8".parse().unwrap()), LINE.as_bytes()).unwrap().turned_away,
                0
            );
            assert_eq!(arrivals.try_recv().unwrap().from.ip(), &Ipv4Addr::new(10, 0, 0, 8));
            assert_eq!(
                input.post(Some("2001:db8::1".parse().unwrap()), LINE.as_bytes()).unwrap().turned_away,
                0
            );
            assert_eq!(arrivals.try_recv().unwrap().from.ip(), &Ipv4Addr::UNSPECIFIED);
        }
    }

    #[tokio::test]
    async fn closing_keeps_accepted_lines_and_rejects_later_ones() {
        let (input, counters, arrivals) = line(9, 9);
        assert!(counters.joined.load(Ordering::Relaxed));
        let (stop, stopped) = watch::channel(false);
        let closed = input.close_when(stopped);
        input.post(None, LINE.as_bytes()).unwrap();
        stop.send_replace(true);
        closed.await;
        assert_eq!(input.post(None, LINE.as_bytes()), Err(PostError::Closed));
        assert!(!counters.joined.load(Ordering::Relaxed));
        assert_eq!(arrivals.iter().count(), 1, "and the queue is at its end");
    }

    #[test]
    fn dropping_the_last_clone_closes_the_input() {
        let (input, counters, arrivals) = line(9, 9);
        drop(input);
        assert!(!counters.joined.load(Ordering::Relaxed) && arrivals.recv().is_err());
    }
}
