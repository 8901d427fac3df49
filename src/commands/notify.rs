//! Notification of systemd (`sd_notify`): ready, alive, stopping.

use std::ffi::OsString;
use std::io;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};

use tracing::warn;

/// Socket from `NOTIFY_SOCKET`; without this variable no notifications are sent.
pub struct Notifier(Option<(UnixDatagram, SocketAddr)>);

impl Notifier {
    /// Reads `NOTIFY_SOCKET` of this process. A socket that cannot be used is logged, and no notifications are sent.
    pub fn from_env() -> Self {
        let Some(name) = std::env::var_os("NOTIFY_SOCKET").filter(|name| !name.is_empty()) else {
            return Self(None);
        };
        match open(&name) {
            Ok(opened) => Self(Some(opened)),
            Err(error) => {
                warn!(NOTIFY_SOCKET = %name.display(), %error, "systemd is not notified");
                Self(None)
            }
        }
    }

    /// Sends a state such as `READY=1` without waiting. If the manager does not read it, its watchdog restarts the service.
    pub fn notify(&self, state: &str) {
        if let Some((socket, to)) = &self.0 {
            let _ = socket.send_to_addr(state.as_bytes(), to);
        }
    }
}

fn open(name: &OsString) -> io::Result<(UnixDatagram, SocketAddr)> {
    let to = address(name.as_bytes())?;
    let socket = UnixDatagram::unbound()?;
    socket.set_nonblocking(true)?;
    Ok((socket, to))
}

/// Address of a socket: a path, or after `@` a name in the abstract namespace.
fn address(name: &[u8]) -> io::Result<SocketAddr> {
    match name.split_first() {
        #[cfg(target_os = "linux")]
        Some((b'@', name)) => {
            use std::os::linux::net::SocketAddrExt;
            SocketAddr::from_abstract_name(name)
        }
        Some((b'/', _)) => SocketAddr::from_pathname(std::ffi::OsStr::from_bytes(name)),
        _ => Err(io::Error::new(io::ErrorKind::InvalidInput, "neither a path nor @ and a name")),
    }
}
