//! `replay --udp` sends what `replay -o x.pcap` writes, in time, and repeatedly with `--loop`.

use std::net::Ipv4Addr;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use utm_fusion::config::Config;

use crate::common::{Running, Scratch, datagrams, group, joined, on_own_ports, utm_fusion};

struct Stage {
    scratch: Scratch,
    site: PathBuf,
    port: u16,
}

impl Stage {
    fn new(port: u16) -> Self {
        let scratch = Scratch::new();
        let demo = Config::load(demo("site.toml")).unwrap();
        let mut config = on_own_ports(&demo, port, &scratch, None);
        config.output.status = true;
        let site = scratch.file("site.toml", config.to_string());
        Self { scratch, site, port }
    }

    fn replay(&self, args: &[&str]) -> Command {
        let mut command = utm_fusion("replay");
        command.arg(demo("capture.pcap")).arg("--config").arg(&self.site).args(args);
        command
    }

    /// Datagrams that `replay` writes with these arguments.
    fn written(&self, args: &[&str]) -> Vec<Vec<u8>> {
        let out = self.scratch.path("out.pcap");
        let ran = self.replay(args).arg("-o").arg(&out).output().unwrap();
        assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
        datagrams(&out).into_iter().map(|(_, payload)| payload).collect()
    }

    /// Receives the output until stopped, and until half a second of silence.
    fn listen(&self) -> (Sender<()>, JoinHandle<Heard>) {
        let (stop, stopped): (Sender<()>, Receiver<()>) = channel();
        let socket = joined(group(99), self.port, Ipv4Addr::LOCALHOST);
        let listener = std::thread::spawn(move || {
            let mut heard = Heard::default();
            let mut octets = [0; 65536];
            loop {
                match socket.recv(&mut octets) {
                    Ok(length) if octets[0] == 129 => heard.points.push(octets[..length].to_vec()),
                    Ok(length) => heard.statuses.push(octets[..length].to_vec()),
                    Err(_) if stopped.try_recv().is_ok() => return heard,
                    Err(_) => {}
                }
            }
        });
        (stop, listener)
    }
}

#[derive(Default)]
struct Heard {
    points: Vec<Vec<u8>>,
    statuses: Vec<Vec<u8>>,
}

fn demo(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata/demo").join(name)
}

#[test]
fn replay_sends_the_file_at_the_pace_of_the_flight() {
    for (port, span, seconds) in
        [(22_900, &[][..], 81.0), (22_910, &["--start", "+30s", "--end", "00:00:25"], 25.0)]
    {
        let stage = Stage::new(port);
        let written = stage.written(span);
        assert!(written.len() > 50);
        let (stop, listener) = stage.listen();
        let began = Instant::now();
        let ran = stage.replay(&["--udp", "--speed", "20"]).args(span).output().unwrap();
        let took_s = began.elapsed().as_secs_f64();
        stop.send(()).unwrap();
        let heard = listener.join().unwrap();
        assert_eq!(ran.status.code(), Some(0), "{}", String::from_utf8_lossy(&ran.stderr));
        assert!(heard.points == written, "{} heard, {} written", heard.points.len(), written.len());
        assert!((took_s - seconds / 20.0).abs() < 0.6, "{took_s} s for {seconds} s");
        // One status per second of the recording's time, through midnight, and without faults.
        let times: Vec<u32> = heard
            .statuses
            .iter()
            .map(|status| u32::from_be_bytes([0, status[7], status[8], status[9]]) / 128)
            .collect();
        assert!((times.len() as f64 - seconds).abs() <= 2.0, "{times:?}");
        assert!(times.windows(2).all(|pair| (pair[0] + 1) % 86_400 == pair[1]), "{times:?}");
        assert!(heard.statuses.iter().any(|status| status.last() == Some(&0)), "operational");
    }
}

#[test]
fn looped_replay_sends_again_until_ctrl_c() {
    let stage = Stage::new(22_950);
    let span = ["--start", "+30s", "--end", "+34s"];
    let written = stage.written(&span);
    let (stop, listener) = stage.listen();
    let mut replay = Running::start(
        stage.replay(&["--udp", "--loop", "--speed", "8"]).args(span),
        stage.scratch.path("replay.log"),
    );
    replay.says("begins again");
    // Three passes of half a second.
    std::thread::sleep(Duration::from_millis(1200));
    assert!(replay.is_running());
    replay.signal("-INT");
    let (code, log) = replay.wait(Duration::from_secs(1));
    assert_eq!(code, Some(0), "{log}");
    stop.send(()).unwrap();
    let heard = listener.join().unwrap().points;
    let passes = heard.len() as f64 / written.len() as f64;
    assert!((2.0..6.0).contains(&passes), "{passes} passes");
    assert!(heard.iter().eq(written.iter().cycle().take(heard.len())));
}

#[test]
fn ctrl_c_does_not_wait_for_the_next_slot() {
    let stage = Stage::new(22_970);
    // A slot takes four minutes.
    let mut replay =
        Running::start(&mut stage.replay(&["--udp", "--speed", "0.001"]), stage.scratch.path("replay.log"));
    replay.says("capture.pcap");
    std::thread::sleep(Duration::from_millis(500));
    replay.signal("-TERM");
    let (code, log) = replay.wait(Duration::from_secs(1));
    assert_eq!(code, Some(0), "{log}");
}
