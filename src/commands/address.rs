//! Parsing of addresses to listen on.

use std::net::{Ipv4Addr, SocketAddr};

/// Parses `127.0.0.1:8080` or `[::1]:8080`; `8080` and `localhost:8080` mean this port on 127.0.0.1.
///
/// # Errors
/// The text has another form. The error says what to write.
pub fn listen_address(text: &str) -> Result<SocketAddr, String> {
    let port = text.strip_prefix("localhost:").unwrap_or(text);
    let local = || Some(SocketAddr::from((Ipv4Addr::LOCALHOST, port.parse().ok()?)));
    text.parse().ok().or_else(local).ok_or_else(|| {
        "write an address of this machine and a port, such as 127.0.0.1:8080, or only the port: 8080"
            .to_owned()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn port_alone_listens_on_loopback() {
        for (text, address) in [
            ("8080", "127.0.0.1:8080"),
            ("localhost:8080", "127.0.0.1:8080"),
            ("127.0.0.1:0", "127.0.0.1:0"),
            ("0.0.0.0:80", "0.0.0.0:80"),
            ("[::1]:8080", "[::1]:8080"),
        ] {
            assert_eq!(listen_address(text).map(|address| address.to_string()).as_deref(), Ok(address));
        }
        // `:8080` means every address of the machine for some programs, and only this machine for others.
        for text in ["", ":8080", "localhost", "127.0.0.1", "65536", "host:8080", "http://localhost:8080/"] {
            assert!(listen_address(text).unwrap_err().contains("127.0.0.1:8080"), "{text}");
        }
    }
}
