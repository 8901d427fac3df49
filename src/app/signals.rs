//! SIGINT and SIGTERM, for commands that wait in a runtime and for those that do not.

use std::io;
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::time::Duration;

use tokio::signal::unix::{Signal, SignalKind, signal};

/// Signals that ask the process to end.
#[derive(Debug)]
pub struct Signals {
    interrupt: Signal,
    terminate: Signal,
}

impl Signals {
    /// Starts to listen for the signals. Needs a runtime.
    ///
    /// # Errors
    /// The system cannot deliver the signals.
    pub fn listen() -> io::Result<Self> {
        Ok(Self { interrupt: signal(SignalKind::interrupt())?, terminate: signal(SignalKind::terminate())? })
    }

    /// Waits for the next signal.
    pub async fn stop(&mut self) {
        tokio::select! {
            _ = self.interrupt.recv() => {}
            _ = self.terminate.recv() => {}
        }
    }
}

/// Signals without a runtime. A second signal ends the process at once.
#[derive(Debug)]
pub struct Stop(Receiver<()>);

impl Stop {
    /// Starts to listen for the signals.
    ///
    /// # Errors
    /// No thread could be started, or the system cannot deliver the signals.
    pub fn listen() -> io::Result<Self> {
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let mut signals = runtime.block_on(async { Signals::listen() })?;
        let (asked, stop) = mpsc::channel();
        let listen = move || {
            for _ in 0..2 {
                runtime.block_on(signals.stop());
                // The receiver may have ended by itself.
                let _ = asked.send(());
            }
            std::process::exit(1);
        };
        std::thread::Builder::new().name("signals".to_owned()).spawn(listen)?;
        Ok(Self(stop))
    }

    /// Waits for `time`, or until a signal arrives. Returns whether one did.
    pub fn comes_within(&self, time: Duration) -> bool {
        self.0.recv_timeout(time) != Err(RecvTimeoutError::Timeout)
    }
}
