//! Ctrl-C while a command waits for its next moment.

use std::io;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::Duration;

use tokio::signal::unix::{SignalKind, signal};

/// Whether SIGINT or SIGTERM has come; a second one ends the process at once.
pub struct Stop(Receiver<()>);

impl Stop {
    /// From now on they are heard here.
    ///
    /// # Errors
    /// No thread could be started, or signals cannot be had.
    pub fn listen() -> io::Result<Self> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let (mut interrupt, mut terminate) = {
            let _inside = runtime.enter();
            (signal(SignalKind::interrupt())?, signal(SignalKind::terminate())?)
        };
        let (asked, stop) = mpsc::channel();
        let listen = move || {
            runtime.block_on(async {
                for _ in 0..2 {
                    tokio::select! {
                        _ = interrupt.recv() => {}
                        _ = terminate.recv() => {}
                    }
                    // Whoever waited may have ended by himself.
                    let _ = asked.send(());
                }
            });
            std::process::exit(1);
        };
        std::thread::Builder::new().name("signals".to_owned()).spawn(listen)?;
        Ok(Self(stop))
    }

    /// Waits for so long, or until it has come; whether it has.
    pub fn comes_within(&self, time: Duration) -> bool {
        self.0.recv_timeout(time) != Err(RecvTimeoutError::Timeout)
    }
}
