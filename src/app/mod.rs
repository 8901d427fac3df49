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
    named_runtime("service", threads).build()
}

/// A runtime for readers. Its threads, those that write answers included, give way to inputs and slots.
fn readers_runtime(name: &str, threads: usize) -> io::Result<Runtime> {
    named_runtime(name, threads).on_thread_start(give_way).build()
}

fn named_runtime(name: &str, threads: usize) -> Builder {
    let mut builder = Builder::new_multi_thread();
    builder.worker_threads(threads).thread_name(name).enable_all();
    builder
}

/// Lowers the priority of this thread, unless it is as low already: Linux gives each thread a nice value of its own
/// (setpriority(2), "C library/kernel differences"). On other systems nothing changes.
fn give_way() {
    #[cfg(target_os = "linux")]
    {
        use rustix::process::{getpriority_process, setpriority_process};
        const NICE: i32 = 10;
        let thread = Some(rustix::thread::gettid());
        let lowered = getpriority_process(thread)
            .and_then(|nice| if nice < NICE { setpriority_process(thread, NICE) } else { Ok(()) });
        if let Err(error) = lowered {
            tracing::debug!(%error, "the threads of HTTP keep the priority of the service");
        }
    }
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

#[cfg(test)]
mod tests {
    #[cfg(target_os = "linux")]
    #[test]
    #[expect(clippy::disallowed_methods, reason = "what the kernel says of a thread")]
    fn threads_of_readers_give_way_to_slots() {
        // proc_pid_stat(5): `nice` is field 19, behind the name in parentheses, which is field 2.
        let nice = || -> i32 {
            let stat = std::fs::read_to_string("/proc/thread-self/stat").unwrap();
            let (_, fields) = stat.rsplit_once(") ").unwrap();
            fields.split(' ').nth(19 - 3).unwrap().parse().unwrap()
        };
        let own = nice();
        let readers = super::readers_runtime("http", 1).unwrap();
        let service = super::runtime(1).unwrap();
        let of = |runtime: &tokio::runtime::Runtime| {
            let [task, blocking] = [runtime.spawn(async move { nice() }), runtime.spawn_blocking(nice)];
            runtime.block_on(async { [task.await.unwrap(), blocking.await.unwrap()] })
        };
        // A service that is niced further keeps it.
        assert_eq!(of(&readers), [10.max(own); 2]);
        assert_eq!(of(&service), [own; 2]);
    }
}
