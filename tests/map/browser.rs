//! Chromium without a window, driven over the DevTools protocol: JSON messages on two pipes, each ended by a zero octet.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// The longest that any answer may take, on a machine that does other things as well.
const PATIENCE: Duration = Duration::from_secs(20);

/// The program, where there is one.
pub fn installed() -> Option<PathBuf> {
    let names = ["chromium", "chromium-browser", "google-chrome", "google-chrome-stable"];
    let folders: Vec<_> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    names
        .iter()
        .flat_map(|name| folders.iter().map(move |folder| folder.join(name)))
        .find(|file| file.is_file())
}

pub struct Browser {
    child: Child,
    commands: ChildStdin,
    messages: Receiver<Value>,
    last_id: u64,
    session: Option<String>,
    complaints: Vec<String>,
    requests: Vec<String>,
}

impl Browser {
    /// With an empty profile in a folder of its own, so that nobody's settings matter.
    pub fn start(program: &Path, profile: &Path) -> Self {
        // Chromium reads commands on descriptor 3 and writes answers on 4; the shell makes them of its own two, and
        // becomes Chromium, so that the child's id is Chromium's.
        let mut child = Command::new("sh")
            .arg("-c")
            .arg(r#"exec "$@" 3<&0 4>&1 </dev/null >/dev/null 2>/dev/null"#)
            .arg("sh")
            .arg(program)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--window-size=1440,900"])
            .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
            .args(["--remote-debugging-pipe", "--force-device-scale-factor=1"])
            .arg(format!("--user-data-dir={}", profile.display()))
            .arg("about:blank")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let commands = child.stdin.take().unwrap();
        let mut answers = BufReader::new(child.stdout.take().unwrap());
        let (sender, messages) = channel();
        std::thread::spawn(move || {
            let mut message = Vec::new();
            while answers.read_until(0, &mut message).is_ok_and(|length| length > 0) {
                message.pop();
                if let Ok(value) = serde_json::from_slice(&message)
                    && sender.send(value).is_err()
                {
                    return;
                }
                message.clear();
            }
        });
        let mut browser = Self {
            child,
            commands,
            messages,
            last_id: 0,
            session: None,
            complaints: Vec::new(),
            requests: Vec::new(),
        };
        browser.attach();
        browser
    }

    /// To a page of its own.
    fn attach(&mut self) {
        let target = self.command("Target.createTarget", &json!({"url": "about:blank"}));
        let attached =
            self.command("Target.attachToTarget", &json!({"targetId": target["targetId"], "flatten": true}));
        self.session = attached["sessionId"].as_str().map(str::to_owned);
        for domain in ["Runtime", "Log", "Page", "Network"] {
            self.command(&format!("{domain}.enable"), &json!({}));
        }
        let size = json!({"width": 1440, "height": 900, "deviceScaleFactor": 1, "mobile": false});
        self.command("Emulation.setDeviceMetricsOverride", &size);
    }

    pub fn open(&mut self, url: &str) {
        let answer = self.command("Page.navigate", &json!({"url": url}));
        assert_eq!(answer.get("errorText"), None, "{url}");
    }

    /// Until an expression is true. Not being so yet, or no such element yet, is no error.
    pub fn wait(&mut self, expression: &str, at_most: Duration) {
        let end = Instant::now() + at_most;
        loop {
            let answer = self.evaluate(expression);
            if answer["result"]["value"] == json!(true) {
                return;
            }
            assert!(Instant::now() < end, "not within {at_most:?}: {expression}\n{}", self.state());
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    pub fn run(&mut self, script: &str) {
        let answer = self.evaluate(script);
        assert_eq!(answer.get("exceptionDetails"), None, "{script}");
    }

    pub fn text(&mut self, expression: &str) -> String {
        self.evaluate(expression)["result"]["value"]
            .as_str()
            .unwrap_or_else(|| panic!("no text: {expression}"))
            .to_owned()
    }

    pub fn number(&mut self, expression: &str) -> u64 {
        self.evaluate(expression)["result"]["value"]
            .as_u64()
            .unwrap_or_else(|| panic!("no number: {expression}"))
    }

    /// A key that makes a character.
    pub fn press(&mut self, key: &str) {
        self.command("Input.dispatchKeyEvent", &json!({"type": "keyDown", "key": key, "text": key}));
        self.command("Input.dispatchKeyEvent", &json!({"type": "keyUp", "key": key}));
    }

    pub fn type_text(&mut self, text: &str) {
        self.command("Input.insertText", &json!({"text": text}));
    }

    /// A PNG of the page.
    pub fn screenshot(&mut self) -> Vec<u8> {
        let answer = self.command("Page.captureScreenshot", &json!({"format": "png"}));
        from_base64(answer["data"].as_str().unwrap())
    }

    /// Exceptions, errors in the console and what the browser itself objected to, such as a broken security policy.
    pub fn complaints(&self) -> &[String] {
        &self.complaints
    }

    /// The address of everything that the page asked for.
    pub fn requests(&self) -> &[String] {
        &self.requests
    }

    fn evaluate(&mut self, expression: &str) -> Value {
        let parameters = json!({"expression": expression, "returnByValue": true, "awaitPromise": true});
        self.command("Runtime.evaluate", &parameters)
    }

    /// For whoever reads a failure.
    fn state(&mut self) -> String {
        let body = self.evaluate("document.body.innerText.slice(0, 2000)");
        format!("page: {}\ncomplaints: {:?}", body["result"]["value"], self.complaints)
    }

    fn command(&mut self, method: &str, parameters: &Value) -> Value {
        self.last_id += 1;
        let mut message = json!({"id": self.last_id, "method": method, "params": parameters});
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.commands.write_all(format!("{message}\0").as_bytes()).unwrap();
        let end = Instant::now() + PATIENCE;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let message =
                self.messages.recv_timeout(left).unwrap_or_else(|error| panic!("{method}: {error}"));
            if message["id"] == json!(self.last_id) {
                // While a page is being replaced there is nothing to evaluate in; whoever waits asks again.
                return message.get("result").cloned().unwrap_or_default();
            }
            self.note(&message["method"], &message["params"]);
        }
    }

    fn note(&mut self, method: &Value, parameters: &Value) {
        match method.as_str() {
            Some("Runtime.exceptionThrown") => {
                self.complaints.push(parameters["exceptionDetails"].to_string());
            }
            Some("Runtime.consoleAPICalled") if parameters["type"] == "error" => {
                self.complaints.push(parameters["args"].to_string());
            }
            Some("Log.entryAdded") if parameters["entry"]["level"] == "error" => {
                self.complaints.push(parameters["entry"].to_string());
            }
            Some("Network.requestWillBeSent") => {
                self.requests.push(parameters["request"]["url"].as_str().unwrap_or_default().to_owned());
            }
            _ => {}
        }
    }
}

impl Drop for Browser {
    /// Asks it to go, with all its processes; ends it where it does not.
    fn drop(&mut self) {
        let _ = self.commands.write_all(b"{\"id\":0,\"method\":\"Browser.close\"}\0");
        for _ in 0..50 {
            if matches!(self.child.try_wait(), Ok(Some(_))) {
                return;
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn from_base64(text: &str) -> Vec<u8> {
    let value = |octet: u8| match octet {
        b'A'..=b'Z' => octet - b'A',
        b'a'..=b'z' => octet - b'a' + 26,
        b'0'..=b'9' => octet - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let digits: Vec<_> = text.bytes().filter(|&octet| octet != b'=').map(value).collect();
    let joined = |chunk: &[u8]| chunk.iter().fold(0_u32, |sum, &digit| sum << 6 | u32::from(digit));
    digits
        .chunks(4)
        .flat_map(|chunk| {
            let bits = joined(chunk) << (6 * (4 - chunk.len()));
            bits.to_be_bytes()[1..chunk.len()].to_vec()
        })
        .collect()
}
