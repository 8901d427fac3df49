//! What systemd is told (`sd_notify`): that the service is ready, alive, stopping.

use std::ffi::OsString;
use std::io;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::net::{SocketAddr, UnixDatagram};

use tracing::warn;

/// The socket that `NOTIFY_SOCKET` names; silent where the variable is not set.
pub struct Notifier(Option<(UnixDatagram, SocketAddr)>);

impl Notifier {
    /// As the environment of the process says. A socket that cannot be used is told, and nothing is notified.
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

    /// Sends a state such as `READY=1`; never waits. A manager that does not read it restarts the service by itself.
    pub fn tell(&self, state: &str) {
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

/// A path, or after `@` a name in the abstract namespace.
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
