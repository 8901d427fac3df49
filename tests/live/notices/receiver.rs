//! An HTTP server with prescribed answers.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpListener;
use std::sync::mpsc::{Receiver as Heard, RecvTimeoutError, Sender, channel};
use std::time::Duration;

use serde_json::Value;

use super::PATIENCE;

/// An answer.
#[derive(Clone, Copy)]
pub(crate) enum Say {
    /// A status, and header lines.
    Status(u16, &'static str),
    /// No answer; the connection stays open.
    Nothing,
}

/// A posted request.
#[derive(Debug)]
pub(crate) struct Posted {
    pub(crate) path: String,
    /// Headers by their names in lower case.
    pub(crate) headers: BTreeMap<String, String>,
    pub(crate) body: Vec<u8>,
}

impl Posted {
    pub(crate) fn json(&self) -> Value {
        serde_json::from_slice(&self.body).unwrap()
    }

    /// Id of the alert, its latest change, and its earlier changes.
    pub(crate) fn told(&self) -> (String, String, Vec<String>) {
        let json = self.json();
        let text = |value: &Value| value.as_str().unwrap().to_owned();
        let earlier = json.get("earlier").and_then(Value::as_array).into_iter().flatten().map(text).collect();
        (text(&json["alert"]["id"]), text(&json["change"]), earlier)
    }
}

pub(crate) struct Receiver {
    pub(crate) port: u16,
    heard: Heard<Posted>,
}

impl Receiver {
    /// Gives these answers in order, and then 204.
    pub(crate) fn start(answers: &[Say]) -> Self {
        Self::on(TcpListener::bind("127.0.0.1:0").unwrap(), answers)
    }

    /// Answers 204, each time once the test allows it.
    pub(crate) fn held() -> (Self, Sender<()>) {
        let (answer, held) = channel();
        (Self::open(TcpListener::bind("127.0.0.1:0").unwrap(), &[], Some(held)), answer)
    }

    pub(crate) fn on(listener: TcpListener, answers: &[Say]) -> Self {
        Self::open(listener, answers, None)
    }

    fn open(listener: TcpListener, answers: &[Say], held: Option<Heard<()>>) -> Self {
        let port = listener.local_addr().unwrap().port();
        let (hears, heard) = channel();
        let mut answers = answers.to_vec();
        answers.reverse();
        std::thread::spawn(move || {
            let mut unanswered = Vec::new();
            for stream in listener.incoming() {
                let mut stream = stream.unwrap();
                let Some(posted) = posted(&mut BufReader::new(&stream)) else { continue };
                if hears.send(posted).is_err() {
                    return;
                }
                held.iter().for_each(|held: &Heard<()>| _ = held.recv());
                match answers.pop().unwrap_or(Say::Status(204, "")) {
                    Say::Status(status, headers) => {
                        let answer = format!("HTTP/1.1 {status} X\r\n{headers}Content-Length: 0\r\n\r\n");
                        stream.write_all(answer.as_bytes()).unwrap();
                    }
                    Say::Nothing => unanswered.push(stream),
                }
            }
        });
        Self { port, heard }
    }

    pub(crate) fn url(&self) -> String {
        format!("http://127.0.0.1:{}/hook?key=1", self.port)
    }

    pub(crate) fn next(&self) -> Posted {
        self.heard.recv_timeout(PATIENCE).expect("something is posted")
    }

    /// Whether no other request was posted.
    pub(crate) fn is_done(&self) -> bool {
        matches!(self.heard.recv_timeout(Duration::from_millis(1)), Err(RecvTimeoutError::Timeout))
    }
}

/// The next request, if there is one.
pub(crate) fn posted(stream: &mut impl BufRead) -> Option<Posted> {
    let mut line = String::new();
    stream.read_line(&mut line).ok()?;
    let path = line.split(' ').nth(1)?.to_owned();
    assert!(line.starts_with("POST "), "{line}");
    let mut headers = BTreeMap::new();
    loop {
        let mut line = String::new();
        stream.read_line(&mut line).ok()?;
        let Some((name, value)) = line.trim().split_once(':') else { break };
        headers.insert(name.to_lowercase(), value.trim().to_owned());
    }
    let mut body = vec![0; headers.get("content-length")?.parse().ok()?];
    stream.read_exact(&mut body).ok()?;
    Some(Posted { path, headers, body })
}

/// Requests over TLS, one connection after the other.
pub(crate) fn over_tls(listener: TcpListener, certificate: &str, key: &str) -> Heard<Posted> {
    use tokio_rustls::rustls::crypto::ring;
    use tokio_rustls::rustls::pki_types::pem::PemObject;
    use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer};
    use tokio_rustls::rustls::{ServerConfig, ServerConnection, StreamOwned};

    let chain = vec![CertificateDer::from_pem_slice(certificate.as_bytes()).unwrap()];
    let key = PrivateKeyDer::from_pem_slice(key.as_bytes()).unwrap();
    let config = ServerConfig::builder_with_provider(ring::default_provider().into())
        .with_safe_default_protocol_versions()
        .unwrap()
        .with_no_client_auth()
        .with_single_cert(chain, key)
        .unwrap();
    let config = std::sync::Arc::new(config);
    let (hears, heard): (Sender<Posted>, _) = channel();
    std::thread::spawn(move || {
        for stream in listener.incoming() {
            let connection = ServerConnection::new(config.clone()).unwrap();
            let mut stream = BufReader::new(StreamOwned::new(connection, stream.unwrap()));
            let Some(posted) = posted(&mut stream) else { continue };
            if hears.send(posted).is_err() {
                return;
            }
            let _ = stream.get_mut().write_all(b"HTTP/1.1 200 OK\r\nContent-Length: 0\r\n\r\n");
        }
    });
    heard
}
