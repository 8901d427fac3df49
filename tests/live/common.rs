//! Helpers shared by the tests: the program, directories, recordings and own sockets.

use std::fs;
use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddrV4, TcpStream, UdpSocket};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use fusion::time::Time;
use serde_json::Value;
use socket2::{Domain, Protocol, Socket, Type};
use utm_fusion::capture::{Capture, CapturedDatagram};
use utm_fusion::config::{Category, Config, PictureKind, Record};
use utm_fusion::simulate::{Scenario, Simulation, simulate};

pub(crate) use crate::program::{Scratch, utm_fusion};

/// A process that is killed if the test does not end it.
pub(crate) struct Running {
    child: Child,
    log: PathBuf,
}

impl Running {
    /// Starts the process; its standard error goes to the file `log`.
    pub(crate) fn start(command: &mut Command, log: PathBuf) -> Self {
        let file = fs::File::create(&log).unwrap();
        let child = command.stdout(Stdio::null()).stderr(file).spawn().unwrap();
        Self { child, log }
    }

    pub(crate) fn id(&self) -> u32 {
        self.child.id()
    }

    pub(crate) fn log(&self) -> String {
        fs::read_to_string(&self.log).unwrap()
    }

    /// Waits until its log holds `text`.
    pub(crate) fn says(&mut self, text: &str) {
        let until = Instant::now() + Duration::from_secs(20);
        while !self.log().contains(text) {
            let ended = self.child.try_wait().unwrap();
            assert!(ended.is_none() && Instant::now() < until, "{ended:?}, not said: {text}\n{}", self.log());
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Port of its HTTP service.
    pub(crate) fn http_port(&self) -> u16 {
        let log = self.log();
        let address = log.split("url=http://").nth(1).unwrap().split('/').next().unwrap();
        address.split(':').nth(1).unwrap().parse().unwrap()
    }

    pub(crate) fn signal(&self, signal: &str) {
        let sent = Command::new("kill").arg(signal).arg(self.id().to_string()).status().unwrap();
        assert!(sent.success());
    }

    pub(crate) fn is_running(&mut self) -> bool {
        self.child.try_wait().unwrap().is_none()
    }

    /// Sends SIGINT; the process must end within 5 s. Returns its exit code and its log.
    pub(crate) fn stop(mut self) -> (Option<i32>, String) {
        self.signal("-INT");
        self.wait(Duration::from_secs(5))
    }

    pub(crate) fn wait(&mut self, at_most: Duration) -> (Option<i32>, String) {
        let until = Instant::now() + at_most;
        loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                return (status.code(), self.log());
            }
            assert!(Instant::now() < until, "it does not end:\n{}", self.log());
            std::thread::sleep(Duration::from_millis(20));
        }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Simulates a flight from this scenario text.
pub(crate) fn flight(scenario: &str, seed: u64, start: Option<Time>) -> Simulation {
    let scratch = Scratch::new();
    let scenario = Scenario::load(&scratch.file("flight.toml", scenario)).unwrap();
    simulate(&scenario, seed, start).unwrap()
}

/// A configuration that stays on this machine: it uses groups of this process, and this test's ports from `port` on.
///
/// The inputs of the site are replaced, one for each sensor, and its output goes to `port`.
pub(crate) fn on_own_ports(config: &Config, port: u16, scratch: &Scratch, record: Option<Record>) -> Config {
    use utm_fusion::config::{Address, Input, Sink};
    let address = |last| Address::Multicast { group: group(last), interface: Ipv4Addr::LOCALHOST };
    let mut config = config.clone();
    for (index, sensor) in config.sensors.iter_mut().enumerate() {
        let index = index as u16 + 1;
        let (address, port) = (address(index as u8), port + index);
        sensor.inputs = vec![Input { address, port, source: None, trailer_octets: None }];
    }
    config.output.asterix = vec![Sink {
        address: address(99),
        port,
        ttl: 1,
        picture: PictureKind::Lagged,
        category: Category::Cat129,
    }];
    config.output.record = record;
    config.state.dir = scratch.path("state");
    config.http.listen = ([127, 0, 0, 1], 0).into();
    config
}

/// A multicast group of this process, so that two runs of these tests at a time do not interfere.
pub(crate) fn group(last: u8) -> Ipv4Addr {
    Ipv4Addr::new(239, 192, 100 + (std::process::id() % 150) as u8, last)
}

/// A socket that receives the group on this interface, with a timeout of half a second.
pub(crate) fn joined(group: Ipv4Addr, port: u16, interface: Ipv4Addr) -> UdpSocket {
    let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP)).unwrap();
    socket.set_reuse_address(true).unwrap();
    socket.set_recv_buffer_size(1 << 20).unwrap();
    socket.bind(&SocketAddrV4::new(group, port).into()).unwrap();
    socket.join_multicast_v4(&group, &interface).unwrap();
    socket.set_read_timeout(Some(Duration::from_millis(500))).unwrap();
    socket.into()
}

/// Files of a directory whose names begin and end like this, in order.
pub(crate) fn files(directory: &Path, prefix: &str, suffix: &str) -> Vec<PathBuf> {
    let mut files: Vec<PathBuf> = fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            let name = path.file_name().unwrap().to_str().unwrap();
            name.starts_with(prefix) && name.ends_with(suffix)
        })
        .collect();
    files.sort();
    files
}

/// The only file with such a name.
pub(crate) fn only(directory: &Path, prefix: &str, suffix: &str) -> PathBuf {
    let mut files = files(directory, prefix, suffix);
    assert_eq!(files.len(), 1, "{prefix}*{suffix} in {}: {files:?}", directory.display());
    files.remove(0)
}

/// Datagrams of a capture, and whether it is undamaged.
pub(crate) fn read(path: &Path) -> (Vec<CapturedDatagram>, bool) {
    let mut whole = true;
    let datagrams = Capture::open(path)
        .unwrap()
        .filter_map(|datagram| {
            whole &= datagram.is_ok();
            datagram.ok()
        })
        .collect();
    (datagrams, whole)
}

/// Time and payload of each datagram of an undamaged capture.
pub(crate) fn datagrams(path: &Path) -> Vec<(Time, Vec<u8>)> {
    let (datagrams, whole) = read(path);
    assert!(whole, "{}", path.display());
    datagrams.into_iter().map(|datagram| (datagram.received.unwrap(), datagram.payload)).collect()
}

/// Path of a file beside an input file.
pub(crate) fn beside(input: &Path, extension: &str) -> PathBuf {
    let name = input.file_name().unwrap().to_str().unwrap();
    let name = name.split(".pcap").next().unwrap();
    input.with_file_name(format!("{name}.{extension}"))
}

/// Octets of the pcap file from a `replay` of a recording with the files beside it.
pub(crate) fn replayed(input: &Path) -> Vec<u8> {
    replayed_at("lagged", "pcap", input)
}

/// Octets of a `replay` of a recording as CAT062.
pub(crate) fn replayed_as_cat062(picture: &str, input: &Path) -> Vec<u8> {
    replayed_at(picture, "cat062-pcap", input)
}

/// Datagrams of the present pictures from a `replay` of a recording.
pub(crate) fn replayed_now(input: &Path) -> Vec<(Time, Vec<u8>)> {
    let scratch = Scratch::new();
    let file = scratch.path("now.pcap");
    fs::write(&file, replayed_at("now", "pcap", input)).unwrap();
    datagrams(&file)
}

fn replayed_at(picture: &str, format: &str, input: &Path) -> Vec<u8> {
    let scratch = Scratch::new();
    let out = scratch.path("out.pcap");
    let output = utm_fusion("replay")
        .arg(input)
        .arg("--config")
        .arg(beside(input, "site.toml"))
        .arg("--state")
        .arg(input.with_extension(""))
        .args(["--at", picture, "--output-format", format])
        .arg("-o")
        .arg(&out)
        .output()
        .unwrap();
    assert!(out.exists(), "{}", String::from_utf8_lossy(&output.stderr));
    fs::read(out).unwrap()
}

/// Datagrams from a `replay` of a recording ([`replayed`]).
pub(crate) fn replayed_datagrams(input: &Path) -> Vec<(Time, Vec<u8>)> {
    let scratch = Scratch::new();
    let file = scratch.path("replayed.pcap");
    fs::write(&file, replayed(input)).unwrap();
    datagrams(&file)
}

/// Opening of the first slot from which on a file's replay equals the output.
pub(crate) fn complete_from(input: &Path) -> Time {
    let text = fs::read_to_string(beside(input, "site.toml")).unwrap();
    let line = text.lines().find_map(|line| line.strip_prefix("# complete_from = ")).unwrap();
    let stamp: jiff::Timestamp = line.parse().unwrap();
    Time::from_nanos(stamp.as_nanosecond() as i64)
}

/// Status and JSON of an answer of the service.
pub(crate) fn ask(port: u16, method: &str, path: &str) -> (u16, Value) {
    ask_with(port, method, path, "")
}

/// Status and JSON of the answer to a request with a body.
pub(crate) fn ask_with(port: u16, method: &str, path: &str, body: &str) -> (u16, Value) {
    let length = body.len();
    let mut socket = TcpStream::connect(("127.0.0.1", port)).unwrap();
    socket
        .write_all(
            format!(
                "{method} {path} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\
                 Content-Length: {length}\r\n\r\n{body}"
            )
            .as_bytes(),
        )
        .unwrap();
    let mut answer = String::new();
    socket.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    (head.split(' ').nth(1).unwrap().parse().unwrap(), serde_json::from_str(body).unwrap())
}
