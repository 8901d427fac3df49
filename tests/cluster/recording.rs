//! A recording of a cluster replays to the same octets that the picture sends.

use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use utm_fusion::capture::Capture;
use utm_fusion::net::listen::ConfiguredLine;

use crate::program::{Scratch, utm_fusion};
use crate::site::{NODES, Setup, Site};

/// Duration of the recording.
const LASTS: &str = "15s";

#[tokio::test(flavor = "multi_thread")]
async fn replay_of_a_recording_equals_the_published_output() {
    let Some(site) = Site::start(Setup::default()).await else { return };
    let sink = &site.config.output.asterix[0];
    let (address, port) = (sink.address, sink.port);
    let line = ConfiguredLine { address, port, sources: Vec::new(), sensors: Vec::new(), connection: None };
    let (socket, _) = line.open().unwrap();
    let socket = tokio::net::UdpSocket::from_std(socket).unwrap();

    let scratch = Scratch::new();
    let directory = scratch.path("recorded");
    let mut command = utm_fusion("record");
    command.args(["--cluster", "--duration", LASTS]).stdout(Stdio::null());
    command.arg("--config").arg(site.file(NODES[0])).arg("--dir").arg(&directory);
    let recorder = tokio::task::spawn_blocking(move || command.output().unwrap());
    let mut sent = Vec::new();
    while !recorder.is_finished() {
        let mut datagram = vec![0; 65_536];
        if let Ok(octets) = tokio::time::timeout(Duration::from_millis(100), socket.recv(&mut datagram)).await
        {
            datagram.truncate(octets.unwrap());
            sent.push(datagram);
        }
    }
    let recorded = recorder.await.unwrap();
    assert!(recorded.status.success(), "{}", String::from_utf8_lossy(&recorded.stderr));

    let (input, output) = (only(&directory, "input-", ".pcap"), only(&directory, "output-", ".pcap"));
    let replayed = scratch.path("replayed.pcap");
    let mut replay = utm_fusion("replay");
    replay.arg(&input).arg("--config").arg(only(&directory, "input-", ".site.toml"));
    // The replay starts from the cell's state at the beginning of the recording.
    replay.arg("--state").arg(&input).arg("-o").arg(&replayed);
    let replay = replay.output().unwrap();
    assert!(replay.status.success(), "{}", String::from_utf8_lossy(&replay.stderr));
    let (made, replayed) = (payloads(&output), payloads(&replayed));
    assert!(made.len() > 30 && replayed.len() >= made.len(), "{} {}", made.len(), replayed.len());
    // The replay continues with the slots that the window still held when the recording ended.
    assert!(replayed[..made.len()] == made, "the recording replays to something else");
    let first = made.iter().position(|octets| *octets == sent[0]).expect("what was sent first is recorded");
    let both = (made.len() - first).min(sent.len());
    assert!(both > 20, "{both} of {} sent", sent.len());
    assert!(made[first..first + both] == sent[..both], "something else was sent");
    println!("{both} datagrams sent, {} replayed: equal", made.len());
}

fn only(directory: &Path, begins: &str, ends: &str) -> PathBuf {
    let mut found: Vec<PathBuf> = std::fs::read_dir(directory)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| {
            let name = path.file_name().unwrap().to_string_lossy();
            name.starts_with(begins) && name.ends_with(ends)
        })
        .collect();
    assert_eq!(found.len(), 1, "{begins}*{ends}: {found:?}");
    found.remove(0)
}

fn payloads(file: &Path) -> Vec<Vec<u8>> {
    Capture::open(file).unwrap().map(|datagram| datagram.unwrap().payload).collect()
}
