//! mosquitto, a broker of MQTT 5, on this machine; and a client that reads its messages.

use std::collections::BTreeMap;
use std::fs;
use std::net::TcpListener;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use rumqttc::v5::mqttbytes::QoS;
use rumqttc::v5::mqttbytes::v5::Packet;
use rumqttc::v5::{Client, Connection, Event, MqttOptions};

use super::{PATIENCE, wait_for};
use crate::common::Scratch;

pub(crate) struct Broker {
    scratch: Scratch,
    pub(crate) port: u16,
    child: Child,
}

impl Broker {
    /// Starts the broker, with the lines `more` in its configuration. `None`, with a message, if it is not installed.
    pub(crate) fn start(more: &str) -> Option<Self> {
        Self::start_in(Scratch::new(), more)
    }

    /// Starts the broker with the files of `scratch`.
    pub(crate) fn start_in(scratch: Scratch, more: &str) -> Option<Self> {
        let Some(program) = program() else {
            eprintln!("skipped: mosquitto is not installed");
            return None;
        };
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let text = format!("listener {port} 127.0.0.1\nallow_anonymous true\npersistence false\n{more}");
        scratch.file("mosquitto.conf", text);
        let child = spawn(&program, &scratch);
        let broker = Self { scratch, port, child };
        broker.is_up();
        Some(broker)
    }

    /// Stops the broker, which loses its state.
    pub(crate) fn stop(&mut self) {
        self.child.kill().unwrap();
        self.child.wait().unwrap();
    }

    pub(crate) fn start_again(&mut self) {
        self.child = spawn(&program().unwrap(), &self.scratch);
        self.is_up();
    }

    fn is_up(&self) {
        wait_for("the broker is up", || std::net::TcpStream::connect(("127.0.0.1", self.port)).is_ok());
    }

    pub(crate) fn listener(&self) -> Listener {
        Listener::new(self.port)
    }

    /// Retained messages, by topic.
    pub(crate) fn retained(&self) -> BTreeMap<String, String> {
        let mut listener = self.listener();
        listener.client.publish("mark", QoS::AtLeastOnce, false, "").unwrap();
        let mut retained = BTreeMap::new();
        loop {
            match listener.next() {
                (topic, _, _) if topic == "mark" => return retained,
                (topic, message, true) => _ = retained.insert(topic, message),
                _ => {}
            }
        }
    }

    /// Waits until exactly these topics are retained.
    pub(crate) fn comes_to_retain(&self, topics: &[&str]) {
        let mut last = Vec::new();
        wait_for(&format!("{topics:?} are retained"), || {
            last = self.retained().into_keys().collect();
            last == topics
        });
    }
}

impl Drop for Broker {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn program() -> Option<PathBuf> {
    ["/usr/sbin/mosquitto", "/usr/local/sbin/mosquitto", "/usr/bin/mosquitto", "/opt/homebrew/sbin/mosquitto"]
        .iter()
        .map(PathBuf::from)
        .find(|path| path.exists())
}

fn spawn(program: &PathBuf, scratch: &Scratch) -> Child {
    let log = fs::File::create(scratch.path("mosquitto.log")).unwrap();
    let mut command = Command::new(program);
    command.arg("-c").arg(scratch.path("mosquitto.conf")).current_dir(scratch.path(""));
    command.stdout(Stdio::null()).stderr(log).spawn().unwrap()
}

/// Client that subscribes to all topics.
pub(crate) struct Listener {
    pub(crate) client: Client,
    connection: Connection,
}

impl Listener {
    fn new(port: u16) -> Self {
        static COUNT: std::sync::atomic::AtomicU32 = std::sync::atomic::AtomicU32::new(0);
        let number = COUNT.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
        let options = MqttOptions::new(format!("listener-{number}"), "127.0.0.1", port);
        let (client, connection) = Client::new(options, 16);
        client.subscribe("#", QoS::AtLeastOnce).unwrap();
        Self { client, connection }
    }

    /// The next message: topic, text, and whether it was retained.
    pub(crate) fn next(&mut self) -> (String, String, bool) {
        loop {
            let event = self.connection.recv_timeout(PATIENCE).expect("a message comes");
            if let Event::Incoming(Packet::Publish(publish)) = event.unwrap() {
                let text = |octets: &[u8]| String::from_utf8(octets.to_vec()).unwrap();
                return (text(&publish.topic), text(&publish.payload), publish.retain);
            }
        }
    }

    /// Waits for the broker's acknowledgement of the subscription.
    pub(crate) fn ready(mut self) -> Self {
        loop {
            let event = self.connection.recv_timeout(PATIENCE).expect("an answer comes");
            if let Event::Incoming(Packet::SubAck(_)) = event.unwrap() {
                return self;
            }
        }
    }

    /// Publishes, and waits for the broker's acknowledgement.
    pub(crate) fn retain(&mut self, topic: &str, text: &str) {
        self.client.publish(topic, QoS::AtLeastOnce, true, text.to_owned()).unwrap();
        while let Ok(event) = self.connection.recv_timeout(Duration::from_secs(5)) {
            if let Event::Incoming(Packet::PubAck(_)) = event.unwrap() {
                return;
            }
        }
        panic!("the broker does not take {topic}");
    }
}
