//! The program: a simulated flight, and the service that shows it.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpStream, UdpSocket};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

const PATIENCE: Duration = Duration::from_secs(60);

/// Markup as the name of an area; it appears in alerts of tracks inside.
pub const HOSTILE: &str = "<img src=x onerror=alert(1)>";

/// The crossing, in which the radar falls silent after half of the time, at a site with an alert area and optional tiles.
pub fn fly(folder: &Path, tiles: Option<&str>) {
    simulate(folder, "crossing");
    let radar = fs::read(folder.join("radar.ast")).unwrap();
    fs::write(folder.join("radar.ast"), &radar[..radar.len() / 2]).unwrap();
    let corners = "[[[-0.62,52.48],[-0.54,52.48],[-0.54,52.54],[-0.62,52.54],[-0.62,52.48]]]";
    let area = format!("{{\"type\": \"Polygon\", \"coordinates\": {corners}}}");
    fs::write(folder.join(format!("{HOSTILE}.geojson")), area).unwrap();
    let site = fs::read_to_string(folder.join("site.toml")).unwrap();
    let http = tiles.map_or("[http]".to_owned(), |url| {
        format!("[http]\ntiles = {{ url = \"{url}\", attribution = \"nobody's\" }}")
    });
    let area = format!("\n[[areas]]\nkind = \"alert\"\nfile = \"{HOSTILE}.geojson\"\n");
    fs::write(folder.join("site.toml"), site.replace("[http]", &http) + &area).unwrap();
}

/// Simulates captures and site of a bundled scenario.
pub fn simulate(folder: &Path, scenario: &str) {
    let scenario = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("config/scenarios/{scenario}.toml"));
    simulate_file(folder, &scenario, 1);
}

/// Simulates captures and site of a scenario file.
pub fn simulate_file(folder: &Path, scenario: &Path, seed: u32) {
    let mut simulate = utm_fusion();
    simulate.arg("simulate").arg(scenario).arg("--out").arg(folder).args(["--seed", &seed.to_string()]);
    let made = simulate.output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
}

/// Conflicts found by a replay, one per line.
pub fn conflicts(folder: &Path) -> String {
    let file = folder.join("conflicts.ndjson");
    let ran =
        Service::captures(utm_fusion().arg("replay"), folder).arg("--conflicts").arg(&file).output().unwrap();
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    fs::read_to_string(file).unwrap()
}

/// A running service, stopped at the end of the test.
pub struct Service {
    child: Child,
    address: SocketAddr,
    /// Log so far.
    log: Arc<Mutex<String>>,
    /// Token of the requests.
    pub token: Option<&'static str>,
}

impl Service {
    /// Replays the flight in the `reference` profile, on this port or on a free one.
    pub fn replay(folder: &Path, port: u16) -> Self {
        Self::replay_in("reference", folder, port)
    }

    /// Replays the flight in the given profile.
    pub fn replay_in(profile: &str, folder: &Path, port: u16) -> Self {
        Self::start(&mut Self::replaying(profile, folder), port)
    }

    fn replaying(profile: &str, folder: &Path) -> Command {
        let mut command = utm_fusion();
        Self::captures(command.arg("replay"), folder).args(["--serve", "--profile", profile]);
        command
    }

    fn captures<'a>(command: &'a mut Command, folder: &Path) -> &'a mut Command {
        command.arg(folder.join("radar.ast")).arg(folder.join("transponder.ast"));
        command.arg("--config").arg(folder.join("site.toml")).args(["--date", "2026-03-14"])
    }

    /// Replays the flight with more options of the program, on a free port.
    pub fn replay_with(profile: &str, folder: &Path, options: &[&str]) -> Self {
        Self::start(Self::replaying(profile, folder).args(options), 0)
    }

    /// The live service over simulated sensors.
    pub fn demo() -> Self {
        Self::start(utm_fusion().arg("demo"), 0)
    }

    /// The live service of a simulated site, on ports of its own that no sensor sends to.
    pub fn without_input(folder: &Path) -> Self {
        let site = fs::read_to_string(folder.join("site.toml")).unwrap();
        let free = || UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let lines = site.lines().map(|line| match line.trim_start().starts_with("{ group") {
            true => format!("{{ address = \"127.0.0.1\", port = {} }},\n", free()),
            false => format!("{line}\n"),
        });
        let file = folder.join("silent.toml");
        let site = lines.collect::<String>();

        fs::write(&file, site.replace("127.0.0.1:8080", "127.0.0.1:0")).unwrap();
        Self::run(utm_fusion().arg("run").arg("silent.toml").current_dir(folder))
    }

    fn start(command: &mut Command, port: u16) -> Self {
        Self::run(command.args(["--http", &format!("127.0.0.1:{port}")]))
    }

    fn run(command: &mut Command) -> Self {
        command.stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut log = BufReader::new(child.stderr.take().unwrap());
        let mut said = String::new();
        let address = loop {
            let line_starts = said.len();
            assert!(log.read_line(&mut said).unwrap() > 0, "it has ended: {said}");
            let address =
                said[line_starts..].split_once("http://").and_then(|(_, rest)| rest.split_once('/'));
            if let Some((address, _)) = address {
                break address.parse().unwrap();
            }
        };
        let kept = Arc::new(Mutex::new(said));
        let keeper = Arc::clone(&kept);
        std::thread::spawn(move || {
            for line in log.lines().map_while(Result::ok) {
                *keeper.lock().unwrap() += &format!("{line}\n");
            }
        });
        Self { child, address, log: kept, token: None }
    }

    /// URL of the service; ends in a slash.
    pub fn url(&self) -> String {
        format!("http://{}/", self.address)
    }

    pub fn port(&self) -> u16 {
        self.address.port()
    }

    /// Moves the replay to a time of day, and waits until it is shown.
    pub fn seek(&self, time: &str) {
        self.ask("POST", &format!("/api/v1/replay/seek?time=2026-03-14T{time}Z"));
        self.wait(&format!("T{}", &time[..7]));
    }

    pub fn order(&self, what: &str) {
        self.ask("POST", &format!("/api/v1/replay/{what}"));
    }

    /// Waits until the state of the replay, which includes its time, contains this text.
    fn wait(&self, text: &str) {
        let end = Instant::now() + PATIENCE;
        while !self.ask("GET", "/api/v1/info").contains(text) {
            assert!(Instant::now() < end, "it does not come to {text}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// An answer of the API.
    pub fn get(&self, path: &str) -> serde_json::Value {
        let answer = self.ask("GET", path);
        serde_json::from_str(answer.split_once("\r\n\r\n").unwrap().1).unwrap()
    }

    /// Lines of the log so far that contain this text.
    pub fn logged(&self, text: &str) -> Vec<String> {
        let log = self.log.lock().unwrap();
        log.lines().filter(|line| line.contains(text)).map(str::to_owned).collect()
    }

    fn ask(&self, method: &str, path: &str) -> String {
        let mut connection = TcpStream::connect(self.address).unwrap();
        let token = self.token.map_or_else(String::new, |token| format!("authorization: Bearer {token}\r\n"));
        let request =
            format!("{method} {path} HTTP/1.1\r\nhost: localhost\r\n{token}connection: close\r\n\r\n");
        connection.write_all(request.as_bytes()).unwrap();
        let mut answer = String::new();
        connection.read_to_string(&mut answer).unwrap();
        assert!(answer.starts_with("HTTP/1.1 200"), "{path}: {answer}");
        answer
    }

    /// Stops or continues the whole process, with its connections open.
    pub fn freeze(&self, is_frozen: bool) {
        let signal = if is_frozen { "-STOP" } else { "-CONT" };
        let sent = Command::new("kill").args([signal, &self.child.id().to_string()]).status().unwrap();
        assert!(sent.success());
    }
}

impl Drop for Service {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn utm_fusion() -> Command {
    Command::new(env!("CARGO_BIN_EXE_utm-fusion"))
}
