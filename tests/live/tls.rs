//! TLS of the program itself: the handshake, a renewed certificate, and unusable files.

use std::fs;
use std::io::{self, Read, Write};
use std::net::TcpStream;
use std::process::Output;
use std::sync::Arc;
use std::time::Duration;

use rcgen::{CertificateParams, KeyPair, date_time_ymd};
use tokio_rustls::rustls::crypto::ring;
use tokio_rustls::rustls::pki_types::CertificateDer;
use tokio_rustls::rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use utm_fusion::config::{Auth, Config, TlsFiles};

use crate::common::{Running, Scratch, flight, on_own_ports, utm_fusion};

pub(crate) const NAME: &str = "fusion.example";

/// A self-signed certificate, and its key.
pub(crate) struct Issued {
    pub(crate) certificate: String,
    pub(crate) key: String,
    root: CertificateDer<'static>,
}

impl Issued {
    pub(crate) fn new() -> Self {
        Self::until(2099)
    }

    fn until(year: i32) -> Self {
        let mut params = CertificateParams::new(vec![NAME.to_owned()]).unwrap();
        params.not_after = date_time_ymd(year, 1, 1);
        let key = KeyPair::generate().unwrap();
        let certificate = params.self_signed(&key).unwrap();
        Self { certificate: certificate.pem(), key: key.serialize_pem(), root: certificate.der().clone() }
    }

    /// Connects to a server that proves to have this certificate.
    pub(crate) fn connect(&self, port: u16) -> io::Result<Connection> {
        self.connect_from([127, 0, 0, 1], port)
    }

    /// Connects from another address.
    pub(crate) fn connect_from(&self, from: [u8; 4], port: u16) -> io::Result<Connection> {
        let mut roots = RootCertStore::empty();
        roots.add(self.root.clone()).unwrap();
        let config = ClientConfig::builder_with_provider(Arc::new(ring::default_provider()))
            .with_safe_default_protocol_versions()
            .unwrap()
            .with_root_certificates(roots)
            .with_no_client_auth();
        let connection = ClientConnection::new(Arc::new(config), NAME.try_into().unwrap()).unwrap();
        let socket = socket2::Socket::new(socket2::Domain::IPV4, socket2::Type::STREAM, None)?;
        socket.bind(&std::net::SocketAddr::from((from, 0)).into())?;
        socket.connect(&std::net::SocketAddr::from(([127, 0, 0, 1], port)).into())?;
        let socket: TcpStream = socket.into();
        socket.set_read_timeout(Some(Duration::from_secs(60)))?;
        let mut stream = StreamOwned::new(connection, socket);
        // The handshake.
        stream.flush()?;
        Ok(Connection(stream))
    }

    /// Status of a request on a new connection.
    fn status(&self, port: u16) -> io::Result<u16> {
        self.connect(port)?.status("GET /healthz", "")
    }
}

pub(crate) struct Connection(StreamOwned<ClientConnection, TcpStream>);

impl Connection {
    /// Sends a request; the connection stays open.
    pub(crate) fn status(&mut self, what: &str, headers: &str) -> io::Result<u16> {
        write!(self.0, "{what} HTTP/1.1\r\nHost: {NAME}\r\n{headers}\r\n")?;
        let head = self.until("\r\n\r\n")?;
        let length = head.to_lowercase().split("content-length: ").nth(1).map(str::to_owned);
        let length = length.and_then(|rest| rest.split("\r\n").next()?.parse().ok()).unwrap_or(0);
        self.0.read_exact(&mut vec![0; length])?;
        head.split(' ').nth(1).and_then(|status| status.parse().ok()).ok_or_else(|| io::Error::other(head))
    }

    /// Sends a request by HTTP/1.0; returns the answer up to this text.
    pub(crate) fn answer(&mut self, path: &str, headers: &str, end: &str) -> io::Result<String> {
        write!(self.0, "GET {path} HTTP/1.0\r\nHost: {NAME}\r\n{headers}\r\n")?;
        self.until(end)
    }

    pub(crate) fn until(&mut self, end: &str) -> io::Result<String> {
        let mut text = Vec::new();
        while !String::from_utf8_lossy(&text).contains(end) {
            // One octet at a time, so that later octets remain unread.
            let mut octet = [0];
            self.0.read_exact(&mut octet)?;
            text.push(octet[0]);
        }
        Ok(String::from_utf8_lossy(&text).into_owned())
    }
}

/// A site of this test.
fn site(scratch: &Scratch, port: u16, change: impl FnOnce(&mut Config)) -> Config {
    let scenario = "name = \"still\"\nduration_s = 20\n[drones]\nmultirotors = 1\nequipped = 1\n";
    let mut config = on_own_ports(&flight(scenario, 1, None).config, port, scratch, None);
    config.http.hosts = vec![NAME.to_owned()];
    let files = ["certificate.pem", "key.pem"].map(|name| scratch.path(name));
    let [certificate, key] = files;
    config.http.tls = Some(TlsFiles { certificate, key });
    change(&mut config);
    scratch.file("site.toml", config.to_string());
    config
}

fn write(scratch: &Scratch, certificate: &str, key: &str) {
    fs::write(scratch.path("certificate.pem"), certificate).unwrap();
    fs::write(scratch.path("key.pem"), key).unwrap();
}

/// Sends SIGHUP; returns the log of the reload.
fn reload(service: &Running) -> String {
    let before = service.log().len();
    service.signal("-HUP");
    for _ in 0..1200 {
        std::thread::sleep(Duration::from_millis(50));
        let told = service.log().split_off(before);
        if told.contains("SIGHUP is done") || told.contains("SIGHUP is refused") {
            return told;
        }
    }
    panic!("nothing was read anew:\n{}", service.log());
}

#[test]
fn tls_is_required_and_sighup_renews_the_certificate() {
    let scratch = Scratch::new();
    site(&scratch, 24_100, |_| {});
    let (first, second) = (Issued::new(), Issued::new());
    write(&scratch, &first.certificate, &first.key);
    let mut service = Running::start(
        utm_fusion("run").arg("--config").arg(scratch.path("site.toml")),
        scratch.path("run.log"),
    );
    service.says("url=https://127.0.0.1:");
    let log = service.log();
    let port = log.split("url=https://127.0.0.1:").nth(1).unwrap().split('/').next().unwrap();
    let port: u16 = port.parse().unwrap();

    // A silent client does not delay others.
    let silent = TcpStream::connect(("127.0.0.1", port)).unwrap();
    let mut open = first.connect(port).unwrap();
    assert_eq!(open.status("GET /healthz", "").unwrap(), 200);
    let stream = first.connect(port).unwrap().answer("/api/v1/stream", "", "event: snapshot").unwrap();
    assert!(stream.starts_with("HTTP/1.0 200"), "{stream}");
    let mut plain = TcpStream::connect(("127.0.0.1", port)).unwrap();
    plain.write_all(b"GET /healthz HTTP/1.1\r\nHost: localhost\r\n\r\n").unwrap();
    let mut answer = Vec::new();
    let _ = plain.read_to_end(&mut answer);
    assert!(!answer.starts_with(b"HTTP/"), "plain HTTP is answered");
    assert!(second.status(port).is_err(), "it proves to be somebody else");

    write(&scratch, &second.certificate, &second.key);
    let told = reload(&service);
    assert!(!told.contains("stays as it was") && !told.contains("restart"), "{told}");
    assert_eq!(second.status(port).unwrap(), 200);
    assert!(first.status(port).is_err(), "the old certificate is still shown");
    assert_eq!(open.status("GET /healthz", "").unwrap(), 200, "an open connection goes on");

    // The certificate of one with the key of the other: the reload changes nothing.
    write(&scratch, &first.certificate, &second.key);
    let told = reload(&service);
    assert!(
        told.contains("everything stays as it was") && told.contains("key.pem: this key does not belong"),
        "{told}"
    );
    assert_eq!(second.status(port).unwrap(), 200);

    let metrics =
        second.connect(port).unwrap().answer("/metrics", "", "utm_fusion_http_responses_total").unwrap();
    let value = |name: &str| {
        let line = metrics.lines().find_map(|line| line.strip_prefix(name));
        line.and_then(|value| value.trim().parse::<f64>().ok()).unwrap_or_else(|| panic!("{name}: {metrics}"))
    };
    assert!(value("utm_fusion_http_connections_refused_total{reason=\"tls\"}") >= 3.0);
    assert_eq!(value("utm_fusion_http_certificate_expires_seconds"), 4_070_908_800.0);
    drop(silent);
    let (code, log) = service.stop();
    assert_eq!(code, Some(0), "{log}");
}

fn check(scratch: &Scratch) -> (Option<i32>, String) {
    let Output { status, stderr, .. } =
        utm_fusion("check").arg("--config").arg(scratch.path("site.toml")).output().unwrap();
    (status.code(), String::from_utf8_lossy(&stderr).into_owned())
}

#[test]
fn unusable_certificate_file_is_named_with_the_reason() {
    let scratch = Scratch::new();
    site(&scratch, 24_200, |_| {});
    let (told, code) = check(&scratch);
    assert!(told == Some(3) && code.contains("certificate.pem: the certificate cannot be read"), "{code}");
    let (own, other) = (Issued::new(), Issued::new());
    let cut = &own.certificate[..own.certificate.len() / 2];
    let encrypted = "-----BEGIN ENCRYPTED PRIVATE KEY-----\nMIIB\n-----END ENCRYPTED PRIVATE KEY-----\n";
    let garbage = "-----BEGIN CERTIFICATE-----\nTm8gY2VydGlmaWNhdGU=\n-----END CERTIFICATE-----\n";
    for (certificate, key, file, problem) in [
        (&*own.certificate, &*other.key, "key.pem", "does not belong to the first certificate in"),
        (&own.key, &own.certificate, "certificate.pem", "are certificate and key exchanged?"),
        (&own.certificate, &own.certificate, "key.pem", "are certificate and key exchanged?"),
        ("", &own.key, "certificate.pem", "holds no certificate; it has to be PEM"),
        (cut, &own.key, "certificate.pem", "not whole PEM text"),
        (garbage, &own.key, "certificate.pem", "cannot be used"),
        (&own.certificate, "", "key.pem", "holds no private key"),
        (&own.certificate, encrypted, "key.pem", "the key is encrypted"),
    ] {
        write(&scratch, certificate, key);
        let (code, told) = check(&scratch);
        assert_eq!(code, Some(3), "{told}");
        assert!(told.contains(file) && told.contains(problem), "{file}: {problem}\n{told}");
    }
    write(&scratch, &own.certificate, &own.key);
    assert_eq!(check(&scratch), (Some(0), String::new()));
    // Valid files with a weakness.
    let expired = Issued::until(2020);
    write(&scratch, &expired.certificate, &expired.key);
    let (code, told) = check(&scratch);
    assert!(
        code == Some(0) && told.contains("the certificate expired at 2020-01-01T00:00:00.000Z"),
        "{told}"
    );
}

#[test]
fn unencrypted_tokens_are_warned_of() {
    let scratch = Scratch::new();
    let own = Issued::new();
    write(&scratch, &own.certificate, &own.key);
    scratch
        .file("tokens.toml", format!("desk = {{ sha256 = \"{}\", scopes = [\"read\"] }}\n", "0".repeat(64)));
    let warned = |change: &dyn Fn(&mut Config)| {
        site(&scratch, 24_300, |config| {
            config.http.listen = ([0, 0, 0, 0], 0).into();
            config.http.auth = Auth::Tokens { tokens_file: scratch.path("tokens.toml") };
            change(config);
        });
        let (code, told) = check(&scratch);
        assert_eq!(code, Some(0), "{told}");
        told.contains("tokens travel beyond this machine without TLS")
    };
    let clear = |config: &mut Config| config.http.tls = None;
    assert!(warned(&clear));
    assert!(!warned(&|_| {}), "with TLS");
    assert!(!warned(&|config| {
        clear(config);
        config.http.listen = ([127, 0, 0, 1], 0).into();
    }));
    assert!(!warned(&|config| {
        clear(config);
        config.http.trusted_proxies = vec!["10.0.0.1".parse().unwrap()];
    }));
}
