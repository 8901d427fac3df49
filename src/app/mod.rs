//! The rooms put together: sockets, hub, API, history, recorder, keepers, and how they end. `run` and `demo --http` build a
//! [`Live`] service, `replay --serve` serves its hub alone ([`Served`]).

mod live;
#[cfg(feature = "cluster")]
mod parts;
mod served;
mod signals;

use std::error::Error;
use std::io;

use tokio::net::TcpListener;
use tokio::runtime::{Builder, Runtime};

use crate::api;
use crate::config::{Auth, Config};
use crate::net::send::Sinks;

pub use live::{Live, LiveBuilder};
#[cfg(feature = "cluster")]
pub use parts::{Parts, Refused};
pub use served::Served;
pub use signals::{Signals, Stop};

/// Any error, for people.
pub type Failure = Box<dyn Error + Send + Sync>;

/// A runtime of that many threads. HTTP is served by another one ([`Served`]).
///
/// # Errors
/// The system gives no threads.
pub fn runtime(threads: usize) -> io::Result<Runtime> {
    named_runtime("service", threads)
}

fn named_runtime(name: &str, threads: usize) -> io::Result<Runtime> {
    Builder::new_multi_thread().worker_threads(threads).thread_name(name).enable_all().build()
}

/// The outputs of a configuration.
///
/// # Errors
/// One cannot be opened.
pub fn open_sinks(config: &Config) -> Result<Sinks, String> {
    let more = "utm-fusion check --network says what to do";
    Sinks::open(&config.output.asterix).map_err(|error| format!("{error} (output.asterix); {more}"))
}

/// The address of the API of a command that takes it from `--http`; `None` where anybody could reach it without a token.
///
/// # Errors
/// The address is taken.
pub fn listen_locally(config: &Config) -> Result<Option<TcpListener>, String> {
    let listen = config.http.listen;
    if config.http.auth == Auth::None && !config.http.is_local() {
        return Ok(None);
    }
    api::listen(listen)
        .map(Some)
        .map_err(|error| format!("cannot listen on {listen}: {error}; --http takes another address"))
}
