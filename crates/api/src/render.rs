//! Threads that make answers, few at a time, so that neither the tasks that read and write sockets nor the probes wait for them.
//!
//! There are two lanes. Expensive answers have their own, with a limit per client address. An answer counts until the client has
//! received it, because it takes memory until then.

use std::collections::HashMap;
use std::fmt;
use std::pin::Pin;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::task::{Context, Poll};
use std::thread::available_parallelism;
use std::time::Duration;

use axum::body::{Bytes, HttpBody};
use axum::http::StatusCode;
use hyper::body::{Frame, SizeHint};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::task::spawn_blocking;
use tokio::time::timeout;

use super::client::Subscriber;
use super::problem::Problem;

/// Maximum number of expensive answers per client address, in preparation or being sent.
const PER_ADDRESS: usize = 4;
/// Maximum number of expensive answers in total. Each has at most about 10 MB.
const IN_ALL: usize = 32;
/// Maximum waiting time of a request; after it the request is refused.
const PATIENCE: Duration = Duration::from_secs(5);
/// Size of the pieces in which an expensive answer is handed to the connection, in octets.
const CHUNK: usize = 1 << 16;
/// Number of addresses above which those without an answer are removed.
const ADDRESSES: usize = 1_024;

/// Threads that make answers, and the queues for them.
#[derive(Debug)]
pub struct Renderer {
    quick: Arc<Semaphore>,
    expensive: Arc<Semaphore>,
    in_all: Arc<Semaphore>,
    by_address: Mutex<HashMap<Subscriber, Arc<Semaphore>>>,
    refused: AtomicU64,
}

/// An expensive answer in preparation or being sent. Dropped once the client has received it.
#[derive(Debug)]
pub struct InFlight {
    _own: Permit,
    _of_all: Permit,
}

/// `None` would mean a closed semaphore; these are never closed.
type Permit = Option<OwnedSemaphorePermit>;

impl Default for Renderer {
    fn default() -> Self {
        let threads = available_parallelism().map_or(1, usize::from);
        let lane = |threads: usize| Arc::new(Semaphore::new(threads.max(1)));
        Self {
            quick: lane(threads / 2),
            expensive: lane(threads / 4),
            in_all: lane(IN_ALL),
            by_address: Mutex::default(),
            refused: AtomicU64::new(0),
        }
    }
}

impl Renderer {
    /// Runs work of at most a few milliseconds.
    ///
    /// # Errors
    /// The work panicked, or the service stops.
    pub async fn quick<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Problem> {
        on_thread(lane(&self.quick).await, work).await
    }

    /// Runs expensive work for a client that has waited for its turn.
    ///
    /// # Errors
    /// The work panicked, or the service stops.
    pub async fn expensive<T: Send + 'static>(
        &self,
        _: &InFlight,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Problem> {
        on_thread(lane(&self.expensive).await, work).await
    }

    /// Runs expensive work for a request, after a limited wait for its turn.
    ///
    /// # Errors
    /// Too many requests are waiting, the work panicked, or the service stops.
    pub async fn in_time<T: Send + 'static>(
        &self,
        client: Subscriber,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<(T, InFlight), Problem> {
        let turn = async { (self.turn(client).await, lane(&self.expensive).await) };
        let (in_flight, lane) = timeout(PATIENCE, turn).await.map_err(|_| {
            self.refused.fetch_add(1, Ordering::Relaxed);
            let detail = "too many expensive answers are asked for at once: those with trails, and those of the history";
            Problem::new(StatusCode::SERVICE_UNAVAILABLE, detail).retry_after_s(5)
        })?;
        Ok((on_thread(lane, work).await?, in_flight))
    }

    /// Waits until an expensive answer for this client may be made.
    pub async fn turn(&self, client: Subscriber) -> InFlight {
        let own = self.of(client);
        InFlight { _own: lane(&own).await, _of_all: lane(&self.in_all).await }
    }

    /// Number of requests refused because too many others were waiting.
    pub fn refused(&self) -> u64 {
        self.refused.load(Ordering::Relaxed)
    }

    fn of(&self, client: Subscriber) -> Arc<Semaphore> {
        let mut by_address = self.by_address.lock().unwrap_or_else(PoisonError::into_inner);
        if by_address.len() >= ADDRESSES {
            by_address.retain(|_, own| Arc::strong_count(own) > 1);
        }
        by_address.entry(client).or_insert_with(|| Arc::new(Semaphore::new(PER_ADDRESS))).clone()
    }
}

/// Runs the work on a blocking thread. The lane is occupied until the work ends, even if the client has gone.
async fn on_thread<T: Send + 'static>(
    lane: Permit,
    work: impl FnOnce() -> T + Send + 'static,
) -> Result<T, Problem> {
    let done = spawn_blocking(move || {
        let done = work();
        drop(lane);
        done
    });
    done.await.map_err(|error| bug(&error))
}

async fn lane(lane: &Arc<Semaphore>) -> Permit {
    lane.clone().acquire_owned().await.ok()
}

/// Problem for an error that no request can cause.
pub fn bug(error: &dyn fmt::Display) -> Problem {
    Problem::new(StatusCode::INTERNAL_SERVER_ERROR, format!("this is a bug: {error}"))
}

/// Body of an expensive answer, handed over in pieces as the client takes it.
#[derive(Debug)]
pub struct ChunkedBody {
    rest: Bytes,
    _in_flight: InFlight,
}

impl ChunkedBody {
    /// Body of `octets`; `in_flight` is held until they are taken.
    pub fn new(octets: Bytes, in_flight: InFlight) -> Self {
        Self { rest: octets, _in_flight: in_flight }
    }
}

impl HttpBody for ChunkedBody {
    type Data = Bytes;
    type Error = std::convert::Infallible;

    fn poll_frame(
        mut self: Pin<&mut Self>,
        _: &mut Context<'_>,
    ) -> Poll<Option<Result<Frame<Bytes>, Self::Error>>> {
        let length = self.rest.len().min(CHUNK);
        let next = self.rest.split_to(length);
        Poll::Ready((length > 0).then(|| Ok(Frame::data(next))))
    }

    fn is_end_stream(&self) -> bool {
        self.rest.is_empty()
    }

    fn size_hint(&self) -> SizeHint {
        SizeHint::with_exact(self.rest.len() as u64)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::mpsc::channel;

    use super::*;

    fn client(number: u8) -> Subscriber {
        Subscriber::at([192, 0, 2, number].into())
    }

    #[tokio::test]
    async fn quick_answer_does_not_wait_for_expensive_ones() {
        let renderer = Arc::new(Renderer::default());
        let (go_on, waits) = channel::<()>();
        let in_flight = renderer.turn(client(1)).await;
        let slow = renderer.clone();
        let slow = tokio::spawn(async move {
            slow.expensive(&in_flight, move || waits.recv().is_ok()).await.is_ok_and(|went_on| went_on)
        });
        tokio::task::yield_now().await;
        assert_eq!(renderer.quick(|| 7).await.ok(), Some(7));
        assert!(!slow.is_finished());
        go_on.send(()).unwrap();
        assert!(slow.await.unwrap());
    }

    #[tokio::test]
    async fn address_with_many_answers_leaves_turns_to_others() {
        let renderer = Renderer::default();
        let mut held = Vec::new();
        for _ in 0..PER_ADDRESS {
            held.push(renderer.turn(client(1)).await);
        }
        let moment = Duration::from_millis(20);
        assert!(timeout(moment, renderer.turn(client(1))).await.is_err());
        assert!(timeout(moment, renderer.turn(client(2))).await.is_ok());
        // The client has received the answer.
        held.pop();
        assert!(timeout(moment, renderer.turn(client(1))).await.is_ok());
    }

    #[tokio::test]
    async fn addresses_without_answers_are_forgotten() {
        let renderer = Renderer::default();
        let held = renderer.turn(client(1)).await;
        for number in 0..3 * ADDRESSES as u32 {
            drop(renderer.turn(Subscriber::at(std::net::Ipv4Addr::from(number).into())).await);
        }
        assert!(renderer.by_address.lock().unwrap().len() <= ADDRESSES);
        assert!(renderer.by_address.lock().unwrap().contains_key(&client(1)));
        drop(held);
    }

    #[tokio::test]
    async fn answer_counts_until_its_last_chunk_is_taken() {
        let renderer = Renderer::default();
        let octets: Vec<u8> = (0..CHUNK * 2 + 5).map(|index| index as u8).collect();
        let made = Bytes::from(octets.clone());
        let (made, in_flight) = renderer.in_time(client(1), move || made).await.unwrap();
        let body = axum::body::Body::new(ChunkedBody::new(made, in_flight));
        assert_eq!(body.size_hint().exact(), Some(octets.len() as u64));
        let own = renderer.of(client(1));
        assert_eq!(own.available_permits(), PER_ADDRESS - 1);
        assert_eq!(axum::body::to_bytes(body, usize::MAX).await.unwrap(), octets);
        assert_eq!(own.available_permits(), PER_ADDRESS);
    }
}
