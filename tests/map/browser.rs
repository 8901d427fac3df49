//! Headless Chromium, controlled by the DevTools protocol: JSON messages on two pipes, each terminated by a zero octet.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

use serde_json::{Value, json};

/// Timeout of an answer, on a machine with other load.
const PATIENCE: Duration = Duration::from_secs(60);

/// Path of the browser, if it is installed.
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
    /// Status and body to answer instead of the service, by the end of the path.
    faults: Vec<(&'static str, u16, &'static str)>,
}

impl Browser {
    /// Starts a browser with an empty profile in its own folder, so that user settings have no effect.
    pub fn start(program: &Path, profile: &Path) -> Self {
        // Chromium reads commands on descriptor 3 and writes answers on 4. The shell maps its own two to them and execs Chromium,
        // so that the child's process id is Chromium's.
        let mut child = Command::new("sh")
            .arg("-c")
            .arg(r#"exec "$@" 3<&0 4>&1 </dev/null >/dev/null 2>/dev/null"#)
            .arg("sh")
            .arg(program)
            .args(["--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--window-size=1440,900"])
            .args(["--disable-background-networking", "--disable-component-update", "--disable-sync"])
            .args(["--remote-debugging-pipe", "--force-device-scale-factor=1"])
            // The `computedName` of an element is the text a screen reader speaks.
            .arg("--enable-blink-features=ComputedAccessibilityInfo")
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
            faults: Vec::new(),
        };
        browser.attach();
        browser
    }

    /// Attaches to a page of its own.
    fn attach(&mut self) {
        let target = self.command("Target.createTarget", &json!({"url": "about:blank"}));
        let attached =
            self.command("Target.attachToTarget", &json!({"targetId": target["targetId"], "flatten": true}));
        self.session = attached["sessionId"].as_str().map(str::to_owned);
        for domain in ["Runtime", "Log", "Page", "Network"] {
            self.command(&format!("{domain}.enable"), &json!({}));
        }
        self.resize(1440, 900, false);
    }

    /// Sets the size of the page in pixels. A phone has touch input instead of a mouse.
    pub fn resize(&mut self, width: u32, height: u32, is_phone: bool) {
        let size = json!({"width": width, "height": height, "deviceScaleFactor": 1, "mobile": is_phone});
        self.command("Emulation.setDeviceMetricsOverride", &size);
        self.command("Emulation.setTouchEmulationEnabled", &json!({"enabled": is_phone}));
    }

    /// From now on, answers requests of these paths with this status and body; the service answers the others.
    pub fn fail(&mut self, faults: &[(&'static str, u16, &'static str)]) {
        self.faults = faults.to_vec();
        let pattern = |(path, ..): &(&str, u16, &str)| json!({"urlPattern": format!("*{path}*")});
        let patterns: Vec<_> = faults.iter().map(pattern).collect();
        match patterns.is_empty() {
            true => self.command("Fetch.disable", &json!({})),
            false => self.command("Fetch.enable", &json!({"patterns": patterns})),
        };
    }

    pub fn open(&mut self, url: &str) {
        let answer = self.command("Page.navigate", &json!({"url": url}));
        assert_eq!(answer.get("errorText"), None, "{url}");
    }

    /// Waits until an expression is true. A false value or a missing element is not an error until the timeout.
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

    /// Clicks the middle of an element with the mouse, like a user: browsers allow sound only after a click.
    pub fn click(&mut self, selector: &str) {
        let found = format!(
            "(() => {{ const node = document.querySelector({selector:?}); node.scrollIntoView({{block: 'nearest'}}); \
                const {{left, top, width, height}} = node.getBoundingClientRect(); \
                return `${{left + width / 2}} ${{top + height / 2}}`; }})()"
        );
        let place = self.text(&found);
        let (x, y) = place.split_once(' ').unwrap();
        let (x, y): (f64, f64) = (x.parse().unwrap(), y.parse().unwrap());
        for kind in ["mousePressed", "mouseReleased"] {
            let event = json!({"type": kind, "x": x, "y": y, "button": "left", "clickCount": 1});
            self.command("Input.dispatchMouseEvent", &event);
        }
    }

    /// Presses a key that produces a character.
    pub fn press(&mut self, key: &str) {
        self.command("Input.dispatchKeyEvent", &json!({"type": "keyDown", "key": key, "text": key}));
        self.command("Input.dispatchKeyEvent", &json!({"type": "keyUp", "key": key}));
    }

    pub fn type_text(&mut self, text: &str) {
        self.command("Input.insertText", &json!({"text": text}));
    }

    /// Screenshot of the page as PNG.
    pub fn screenshot(&mut self) -> Vec<u8> {
        let answer = self.command("Page.captureScreenshot", &json!({"format": "png"}));
        from_base64(answer["data"].as_str().unwrap())
    }

    /// Exceptions, console errors, and complaints of the browser, such as violations of the content security policy.
    pub fn complaints(&self) -> &[String] {
        &self.complaints
    }

    /// URLs of all requests of the page.
    pub fn requests(&self) -> &[String] {
        &self.requests
    }

    fn evaluate(&mut self, expression: &str) -> Value {
        let parameters = json!({"expression": expression, "returnByValue": true, "awaitPromise": true});
        self.command("Runtime.evaluate", &parameters)
    }

    /// State of the page, for failure messages.
    fn state(&mut self) -> String {
        let body = self.evaluate("document.body.innerText.slice(0, 2000)");
        format!("page: {}\ncomplaints: {:?}", body["result"]["value"], self.complaints)
    }

    /// Sends a command. Returns the id of its answer.
    fn send(&mut self, method: &str, parameters: &Value) -> u64 {
        self.last_id += 1;
        let mut message = json!({"id": self.last_id, "method": method, "params": parameters});
        if let Some(session) = &self.session {
            message["sessionId"] = json!(session);
        }
        self.commands.write_all(format!("{message}\0").as_bytes()).unwrap();
        self.last_id
    }

    fn command(&mut self, method: &str, parameters: &Value) -> Value {
        let id = self.send(method, parameters);
        let end = Instant::now() + PATIENCE;
        loop {
            let left = end.saturating_duration_since(Instant::now());
            let message =
                self.messages.recv_timeout(left).unwrap_or_else(|error| panic!("{method}: {error}"));
            if message["id"] == json!(id) {
                // While a page is being replaced nothing can be evaluated; the caller tries again.
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
            Some("Fetch.requestPaused") => self.answer(parameters),
            _ => {}
        }
    }

    /// Answers a request instead of the service.
    fn answer(&mut self, paused: &Value) {
        let url = paused["request"]["url"].as_str().unwrap_or_default();
        let path = url.split('?').next().unwrap_or_default();
        let request = &paused["requestId"];
        match self.faults.iter().find(|(end, ..)| path.ends_with(end)) {
            Some(&(_, status, body)) => {
                let kind = json!([{"name": "content-type", "value": "application/json"}]);
                let body = to_base64(body.as_bytes());
                let answer = json!({"requestId": request, "responseCode": status, "responseHeaders": kind, "body": body});
                self.send("Fetch.fulfillRequest", &answer);
            }
            None => {
                self.send("Fetch.continueRequest", &json!({"requestId": request}));
            }
        }
    }
}

impl Drop for Browser {
    /// Asks the browser to exit with all its processes, and kills it if it does not.
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

const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

fn to_base64(octets: &[u8]) -> String {
    let digits = |chunk: &[u8]| {
        let bits = (0..3).fold(0_usize, |bits, at| bits << 8 | usize::from(*chunk.get(at).unwrap_or(&0)));
        let digit =
            |at: usize| if at > chunk.len() { '=' } else { char::from(DIGITS[bits >> (18 - 6 * at) & 63]) };
        (0..4).map(digit).collect::<String>()
    };
    octets.chunks(3).map(digits).collect()
}

fn from_base64(text: &str) -> Vec<u8> {
    let value = |octet: u8| DIGITS.iter().position(|&digit| digit == octet).unwrap_or(0) as u8;
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
