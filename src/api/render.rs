//! Where answers are written: on threads of their own, few at a time, so that neither the tasks that read and write sockets
//! nor the probes wait for it.
//!
//! There are two lanes. What takes long has its own, in which an address has few answers at a time: they count until the
//! client has taken them, because until then they take memory.

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

/// Expensive answers of one address that are made, or on their way, at the same time.
const PER_ADDRESS: usize = 4;
/// Expensive answers of all addresses. Each has at most some 10 MB.
const IN_ALL: usize = 32;
/// A request that waits for longer than this is refused.
const PATIENCE: Duration = Duration::from_secs(5);
/// Octets of an expensive answer that are handed to the connection at once.
const CHUNK: usize = 1 << 16;
/// Addresses that are remembered before those without an answer are forgotten.
const ADDRESSES: usize = 1_024;

/// The threads that write answers, and who waits for them.
#[derive(Debug)]
pub struct Renderer {
    quick: Arc<Semaphore>,
    expensive: Arc<Semaphore>,
    in_all: Arc<Semaphore>,
    by_address: Mutex<HashMap<Subscriber, Arc<Semaphore>>>,
    refused: AtomicU64,
}

/// An expensive answer that is made or on its way. Dropped once the client has taken it.
#[derive(Debug)]
pub struct InFlight {
    _own: Permit,
    _of_all: Permit,
}

/// `None` of a semaphore that is closed, which none of these ever is.
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
    /// Does what takes a few milliseconds at most.
    ///
    /// # Errors
    /// It panicked, or the service ends.
    pub async fn quick<T: Send + 'static>(
        &self,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Problem> {
        on_thread(lane(&self.quick).await, work).await
    }

    /// Does what takes long, for a client that has waited for its turn.
    ///
    /// # Errors
    /// It panicked, or the service ends.
    pub async fn expensive<T: Send + 'static>(
        &self,
        _: &InFlight,
        work: impl FnOnce() -> T + Send + 'static,
    ) -> Result<T, Problem> {
        on_thread(lane(&self.expensive).await, work).await
    }

    /// The same for a request, which does not wait long for its turn.
    ///
    /// # Errors
    /// Too many others are before it, it panicked, or the service ends.
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

    /// Waits until an expensive answer of this client may be made.
    pub async fn turn(&self, client: Subscriber) -> InFlight {
        let own = self.of(client);
        InFlight { _own: lane(&own).await, _of_all: lane(&self.in_all).await }
    }

    /// Requests that were refused because others were before them.
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

/// Runs the work on a blocking thread. The lane stays occupied until the work ends, also where the client has gone.
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

/// The problem of an error that no request can cause.
pub fn bug(error: &dyn fmt::Display) -> Problem {
    Problem::new(StatusCode::INTERNAL_SERVER_ERROR, format!("this is a bug: {error}"))
}

/// The body of an expensive answer: handed on piece by piece as the client takes it.
#[derive(Debug)]
pub struct Taken {
    rest: Bytes,
    _in_flight: InFlight,
}

impl Taken {
    /// These octets, for as long as they take.
    pub fn new(octets: Bytes, in_flight: InFlight) -> Self {
        Self { rest: octets, _in_flight: in_flight }
    }
}

impl HttpBody for Taken {
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
        // Taken by its client.
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
        let body = axum::body::Body::new(Taken::new(made, in_flight));
        assert_eq!(body.size_hint().exact(), Some(octets.len() as u64));
        let own = renderer.of(client(1));
        assert_eq!(own.available_permits(), PER_ADDRESS - 1);
        assert_eq!(axum::body::to_bytes(body, usize::MAX).await.unwrap(), octets);
        assert_eq!(own.available_permits(), PER_ADDRESS);
    }
}
