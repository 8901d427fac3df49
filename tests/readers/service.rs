//! The live service with simulated sensors, and requests to it.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::program::utm_fusion;

/// A process that is killed at the end of the test.
pub(crate) struct Ending(pub(crate) Child);

impl Drop for Ending {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// `demo --http`, for at most two minutes.
pub(crate) struct Demo {
    pub(crate) address: SocketAddr,
    _process: Ending,
}

impl Demo {
    pub(crate) fn start() -> Self {
        let mut command = utm_fusion("demo");
        command.args(["--http", "127.0.0.1:0", "--duration", "120s"]).stdout(Stdio::null());
        let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
        let mut log = BufReader::new(child.stderr.take().unwrap());
        let process = Ending(child);
        let address = loop {
            let mut line = String::new();
            assert!(log.read_line(&mut line).unwrap() > 0, "it has ended");
            if let Some((address, _)) = line.split_once("http://").and_then(|(_, rest)| rest.split_once('/'))
            {
                break address.parse().unwrap();
            }
        };
        // The rest of the log is discarded, so that it cannot fill the pipe.
        std::thread::spawn(move || std::io::copy(&mut log, &mut std::io::sink()));
        let demo = Self { address, _process: process };
        until("a fused track", || get(demo.address, "/api/v1/tracks").contains("\"source\":\"fused\""));
        demo
    }
}

/// Body of an answer that must be 200. With HTTP/1.0 nothing is chunked.
pub(crate) fn get(address: SocketAddr, path: &str) -> String {
    try_get(address, path).unwrap_or_else(|answer| panic!("{path}: {answer}"))
}

/// Body of a 200 answer. Otherwise the whole answer, or the error.
pub(crate) fn try_get(address: SocketAddr, path: &str) -> Result<String, String> {
    let ask = || {
        let mut socket = TcpStream::connect(address)?;
        socket.set_read_timeout(Some(Duration::from_secs(60)))?;
        write!(socket, "GET {path} HTTP/1.0\r\nHost: {address}\r\n\r\n")?;
        let mut answer = String::new();
        socket.read_to_string(&mut answer).map(|_| answer)
    };
    let answer = ask().map_err(|error| error.to_string())?;
    match answer.split_once("\r\n\r\n") {
        Some((head, body)) if head.split(' ').nth(1) == Some("200") => Ok(body.to_owned()),
        _ => Err(answer),
    }
}

/// Waits until a condition holds.
pub(crate) fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let end = Instant::now() + Duration::from_secs(60);
    while !is_so() {
        assert!(Instant::now() < end, "not within a minute: {what}");
        std::thread::sleep(Duration::from_millis(200));
    }
}

/// Whether the program answers this option. If not, the test reports itself as skipped.
pub(crate) fn is_installed(program: &str, option: &str) -> bool {
    let asked = Command::new(program).arg(option).stdout(Stdio::null()).stderr(Stdio::null()).status();
    let is_there = asked.is_ok_and(|status| status.success());
    if !is_there {
        println!("skipped: {program} is not installed");
    }
    is_there
}
