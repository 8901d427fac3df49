//! Assembly of a process: sockets, hub, API, history, recorder and state files, from start to stop. `run` and `demo --http` build
//! a [`Live`] service; `replay --serve` serves its hub alone ([`Served`]).

mod live;
#[cfg(feature = "cluster")]
mod parts;
mod served;
mod signals;

use std::error::Error;
use std::io;

use tokio::net::TcpListener;
use tokio::runtime::{Builder, Runtime};

use service::net::send::UdpDestinations;
use site::config::{Auth, Config};

pub use live::{Live, LiveBuilder};
#[cfg(feature = "cluster")]
pub use parts::{JoinRefused, Parts};
pub use served::Served;
pub use signals::{Signals, Stop};

/// An error of any kind, to be printed.
pub type AppError = Box<dyn Error + Send + Sync>;

/// A runtime of `threads` threads. HTTP is served by another runtime ([`Served`]).
///
/// # Errors
/// The system cannot start the threads.
pub fn runtime(threads: usize) -> io::Result<Runtime> {
    named_runtime("service", threads).build()
}

/// A runtime for HTTP. Its threads, including those that write responses, have a lower priority than inputs and slots.
fn readers_runtime(name: &str, threads: usize) -> io::Result<Runtime> {
    named_runtime(name, threads).on_thread_start(give_way).build()
}

fn named_runtime(name: &str, threads: usize) -> Builder {
    let mut builder = Builder::new_multi_thread();
    builder.worker_threads(threads).thread_name(name).enable_all();
    builder
}

/// Lowers the priority of this thread, unless it is low already. On Linux each thread has its own nice value (setpriority(2), "C
/// library/kernel differences"). On other systems nothing changes.
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

/// Opens the outputs of a configuration.
///
/// # Errors
/// An output cannot be opened.
pub fn open_sinks(config: &Config) -> Result<UdpDestinations, String> {
    let more = "utm-fusion check --network says what to do";
    UdpDestinations::open(&config.output.asterix).map_err(|error| format!("{error} (output.asterix); {more}"))
}

/// Listener of the API for a command with `--http`; `None` if other machines could reach it without a token.
///
/// # Errors
/// The address is in use.
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
    fn reader_threads_run_at_lower_priority() {
        // proc_pid_stat(5): `nice` is field 19; the name in parentheses is field 2.
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
        // A process with a higher nice value keeps it.
        assert_eq!(of(&readers), [10.max(own); 2]);
        assert_eq!(of(&service), [own; 2]);
    }
}
