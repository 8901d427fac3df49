//! Lines that are connections: to a receiver over TCP, or to a broker of MQTT 5. What comes is translated or cut into ASTERIX
//! blocks, and handed on as if it were datagrams; the connection is made again, more and more seldom, where it fails or falls silent.

use std::io;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use asterix::DataSource;
use rumqttc::v5::mqttbytes::QoS;
use rumqttc::v5::mqttbytes::v5::{Filter, Login, RetainForwardRule, Subscribe};
use tokio::io::AsyncReadExt;
use tokio::net::TcpStream;
use tokio::sync::watch;
use tokio::time::{sleep, sleep_until, timeout};
use tracing::{error, info};

use super::clock::Clock;
use crate::config::{Connection, ConnectionFormat};
use crate::gateways::adsb::{Framing, Place, Translator};
use crate::gateways::blocks::{BlockStream, NotAsterix};
use crate::gateways::remote_id::{Counts, Receivers};
use crate::net::dial::{Dial, Proofs};
use crate::net::listen::{Arrival, Line, LineCounters};
use crate::net::mqtt::{Broken, Caller, Connection as Broker, Found};
use crate::net::secret::secret;
use fusion::time::Time;

/// Pause before the next try: the first one, and the longest.
const PAUSES: [Duration; 2] = [Duration::from_secs(2), Duration::from_secs(30)];
/// Who does not answer a call for this long is not there.
const PATIENCE: Duration = Duration::from_secs(5);
/// A receiver that sends nothing for this long may be gone without a word. By judgement: a busy sky is never silent, and an
/// empty one costs a new connection a minute.
const SILENCE: Duration = Duration::from_secs(60);
/// Octets read in one go.
const CHUNK: usize = 1 << 16;
/// Chunks that are still read of a connection that is to end.
const LAST_CHUNKS: usize = 64;

/// The reader of such a line.
pub(super) struct Door {
    pub(super) index: usize,
    pub(super) line: Arc<Line>,
    pub(super) counters: Arc<LineCounters>,
    pub(super) clock: Clock,
    pub(super) stopped: watch::Receiver<bool>,
    /// SAC and SIC of the sensor.
    pub(super) source: DataSource,
    /// The id of the sensor.
    pub(super) sensor: String,
    /// The origin of the site.
    pub(super) origin: Place,
    /// The sensors with a connection to the same broker.
    pub(super) receivers: Receivers,
}

/// Makes datagrams of a receiver's stream.
enum StreamReader {
    /// Frames of a 1090 MHz receiver.
    Frames(Box<Translator>),
    /// ASTERIX.
    Blocks(BlockStream),
}

impl StreamReader {
    fn take(
        &mut self,
        octets: &[u8],
        received: Time,
        hand_on: impl FnMut(Vec<u8>),
    ) -> Result<(), NotAsterix> {
        match self {
            Self::Frames(translator) => {
                translator.take(octets, received, hand_on);
                Ok(())
            }
            Self::Blocks(blocks) => blocks.take(octets, hand_on),
        }
    }

    fn end(&mut self) {
        match self {
            Self::Frames(translator) => _ = translator.end(),
            Self::Blocks(blocks) => blocks.end(),
        }
    }
}

/// Why a connection is no more.
enum Ended {
    Failed(String),
    Stopped,
}

impl From<Broken> for Ended {
    fn from(broken: Broken) -> Self {
        Self::Failed(broken.to_string())
    }
}

impl From<io::Error> for Ended {
    fn from(error: io::Error) -> Self {
        Self::Failed(error.to_string())
    }
}

impl Door {
    /// Connects and reads until it is stopped. `hand_on` is `false` where an arrival was lost.
    pub(super) async fn keep_reading(self, hand_on: impl Fn(Arrival) -> bool) {
        let Some(connection) = self.line.connection.clone() else { return };
        let mut stopped = self.stopped.clone();
        let (mut pause, mut failing) = (PAUSES[0], false);
        // The translator, and what it knows of aircraft, outlives a short break.
        let frames = |framing| {
            StreamReader::Frames(Box::new(Translator::new(framing, self.source, Some(self.origin))))
        };
        let mut reader = match connection.format {
            ConnectionFormat::Asterix => StreamReader::Blocks(BlockStream::default()),
            ConnectionFormat::Avr => frames(Framing::Avr),
            _ => frames(Framing::Beast),
        };
        let mut counts = Counts::default();
        loop {
            let session = async {
                match connection.format {
                    ConnectionFormat::Mqtt => self.broker(&connection, &mut counts, &hand_on).await,
                    _ => self.receiver(&mut reader, &hand_on).await,
                }
            };
            let Err(ended) = session.await;
            let was_open = self.counters.joined.swap(false, Ordering::Relaxed);
            let Ended::Failed(why) = ended else { return };
            if was_open {
                (pause, failing) = (PAUSES[0], false);
            }
            if !std::mem::replace(&mut failing, true) {
                let retry_s = pause.as_secs();
                error!(error = why, retry_s, "input cannot be read: connected again");
            }
            tokio::select! {
                () = sleep(pause) => pause = (pause * 2).min(PAUSES[1]),
                () = stop(&mut stopped) => return,
            }
        }
    }

    /// A receiver's stream.
    async fn receiver(
        &self,
        reader: &mut StreamReader,
        hand_on: &impl Fn(Arrival) -> bool,
    ) -> Result<std::convert::Infallible, Ended> {
        let address = self.line.destination();
        let mut stopped = self.stopped.clone();
        let dialled = tokio::select! {
            dialled = timeout(PATIENCE, TcpStream::connect(address)) => dialled,
            () = stop(&mut stopped) => return Err(Ended::Stopped),
        };
        let silent = |_| io::Error::new(io::ErrorKind::TimedOut, "no answer");
        let mut stream = dialled.map_err(silent)??;
        self.counters.joined.store(true, Ordering::Relaxed);
        info!("connected");
        let mut buffer = vec![0; CHUNK];
        let mut take = |octets: &[u8]| {
            let received = self.clock.now();
            let taken = reader.take(octets, received, |payload| {
                let arrival = Arrival { line: self.index, received, from: address, payload };
                self.counters.note(received, hand_on(arrival));
            });
            if let StreamReader::Frames(translator) = &*reader {
                self.counters.note_untranslated(translator.counts().dropped.iter());
            }
            taken
        };
        let ended = loop {
            let read = tokio::select! {
                read = timeout(SILENCE, stream.read(&mut buffer)) => read,
                () = stop(&mut stopped) => {
                    // What has arrived by now.
                    for _ in 0..LAST_CHUNKS {
                        match stream.try_read(&mut buffer) {
                            Ok(length) if length > 0 && take(&buffer[..length]).is_ok() => {}
                            _ => break,
                        }
                    }
                    break Ended::Stopped;
                }
            };
            match read {
                Ok(Ok(0)) => break Ended::Failed("the receiver closed the connection".to_owned()),
                Ok(Ok(length)) => {
                    if let Err(error) = take(&buffer[..length]) {
                        break Ended::Failed(error.to_string());
                    }
                }
                Ok(Err(error)) => break error.into(),
                Err(_) => break Ended::Failed(format!("nothing came for {} s", SILENCE.as_secs())),
            }
        };
        reader.end();
        Err(ended)
    }

    /// A broker's messages, each some lines.
    async fn broker(
        &self,
        of: &Connection,
        counts: &mut Counts,
        hand_on: &impl Fn(Arrival) -> bool,
    ) -> Result<std::convert::Infallible, Ended> {
        let (dial, login) = dial(of).map_err(Ended::Failed)?;
        let DataSource { sac, sic } = self.source;
        let usual = || format!("utm-fusion-{sac}-{sic}-{}", self.sensor);
        let client_id = of.client_id.clone().unwrap_or_else(usual);
        let mut stopped = self.stopped.clone();
        let mut take = |message: Found| {
            let received = self.clock.now();
            let from = SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, self.line.port);
            counts.lines(&message.payload, &self.receivers, |line| {
                let arrival = Arrival { line: self.index, received, from, payload: line.to_vec() };
                self.counters.note(received, hand_on(arrival));
            });
            self.counters.note_untranslated(counts.refused.iter());
        };
        let open = async {
            let caller = Caller { client_id: &client_id, login, will: None };
            let mut broker = Broker::open(&dial, caller).await?;
            broker.subscribed(subscription(&of.topic), &mut take).await?;
            Ok::<_, Broken>(broker)
        };
        let mut broker = tokio::select! {
            broker = open => broker?,
            () = stop(&mut stopped) => return Err(Ended::Stopped),
        };
        self.counters.joined.store(true, Ordering::Relaxed);
        info!("subscribed");
        loop {
            let ping_due = broker.ping_due();
            tokio::select! {
                heard = broker.listen() => heard?.into_iter().for_each(&mut take),
                () = sleep_until(ping_due) => broker.ping(&mut take).await?,
                () = stop(&mut stopped) => {
                    // A broker answers in order: what it has sent by now comes before the answer.
                    let _ = broker.ping(&mut take).await;
                    let _ = broker.end().await;
                    return Err(Ended::Stopped);
                }
            }
        }
    }
}

/// Waits until it is to end, also where nobody is left who could say so.
async fn stop(stopped: &mut watch::Receiver<bool>) {
    let _ = stopped.wait_for(|stopped| *stopped).await;
}

fn dial(of: &Connection) -> Result<(Dial, Option<Login>), String> {
    let broker = of.broker().ok_or("the address is no broker's")?;
    let dial = match broker.tls {
        true => Dial::tls(&broker.host, broker.port, &Proofs { ca: of.ca.as_deref(), ..Proofs::default() })?,
        false => Dial::plain(&broker.host, broker.port),
    };
    let password = secret(of.password_file.as_deref(), of.password_env.as_deref())?;
    let login = of
        .username
        .as_ref()
        .map(|username| Login { username: username.clone(), password: password.unwrap_or_default() });
    Ok((dial, login))
}

/// Messages as they are published; what is retained is of another time.
fn subscription(topic: &str) -> Subscribe {
    let filter = Filter {
        path: topic.to_owned(),
        qos: QoS::AtMostOnce,
        nolocal: false,
        preserve_retain: false,
        retain_forward_rule: RetainForwardRule::Never,
    };
    Subscribe::new(filter, None)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::Address;
    use crate::net::mqtt::scripted::pings_while_flooded;

    #[tokio::test]
    async fn busy_broker_gets_pings_within_the_keep_alive() {
        let counters = Arc::<LineCounters>::default();
        let (heard, (stop, stopped)) = (counters.clone(), watch::channel(false));
        let pings = pings_while_flooded("remote-id/a", |port| async move {
            let connection = Connection {
                format: ConnectionFormat::Mqtt,
                address: format!("mqtt://127.0.0.1:{port}"),
                topic: "remote-id/a".to_owned(),
                ..Connection::default()
            };
            let line = Line {
                address: Address::Unicast(Ipv4Addr::LOCALHOST),
                port,
                sources: Vec::new(),
                sensors: vec![0],
                connection: Some(connection),
            };
            let door = Door {
                index: 0,
                line: Arc::new(line),
                counters,
                clock: Clock::default(),
                stopped,
                source: DataSource { sac: 25, sic: 1 },
                sensor: "gateway".to_owned(),
                origin: [52.0, 4.0],
                receivers: Receivers::default(),
            };
            door.keep_reading(|_| true).await;
        });
        let pings = pings.await;
        assert!(pings >= 2, "{pings} pings");
        assert!(heard.joined.load(Ordering::Relaxed));
        drop(stop);
    }
}
