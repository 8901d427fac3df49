//! Inputs over connections: TCP to a receiver, or MQTT 5 to a broker. Received data is translated or cut into ASTERIX
//! blocks, and handled like datagrams. A connection that fails or falls silent is opened again, after growing pauses.

use std::io;
use std::net::{Ipv4Addr, SocketAddrV4};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::Duration;

use asterix::DataSource;
use tokio::io::AsyncReadExt;
use tokio::net::TcpStream;
use tokio::sync::watch;
use tokio::time::{sleep, sleep_until, timeout};
use tracing::{error, info};

use crate::clock::WallClock;
use crate::net::dial::{Certificates, Dialer};
use crate::net::listen::{Arrival, ConfiguredLine, LineCounters};
use crate::net::mqtt::{
    BrokerConnection as Broker, BrokerError, ClientIdentity, Login, ReceivedMessage, Subscription,
};
use crate::net::secret::secret;
use fusion::time::Time;
use input::gateways::adsb::{AdsbTranslator, LatLonDeg, ReceiverFraming};
use input::gateways::blocks::{BlockStream, NotAsterix};
use input::gateways::lines::LineTranslator;
use input::gateways::remote_id::{ReceiverIds, RemoteIdLineCounts};
use site::config::{Connection, ConnectionFormat};

/// Pause before a reconnection: the first and the longest.
const PAUSES: [Duration; 2] = [Duration::from_secs(2), Duration::from_secs(30)];
/// Timeout for opening a connection.
const PATIENCE: Duration = Duration::from_secs(5);
/// Silence after which a receiver's connection is opened again. Chosen by judgement: traffic at a busy site never pauses
/// that long, and an empty sky costs one new connection a minute.
const SILENCE: Duration = Duration::from_secs(60);
/// Maximum number of octets per read.
const CHUNK: usize = 1 << 16;
/// Maximum number of chunks still read when a connection is to be closed.
const LAST_CHUNKS: usize = 64;

/// Reader of one connection.
pub(super) struct ConnectionReader {
    pub(super) index: usize,
    pub(super) line: Arc<ConfiguredLine>,
    pub(super) counters: Arc<LineCounters>,
    pub(super) clock: WallClock,
    pub(super) stopped: watch::Receiver<bool>,
    /// SAC and SIC of the sensor.
    pub(super) source: DataSource,
    /// Id of the sensor.
    pub(super) sensor: String,
    /// Origin of the site.
    pub(super) origin: LatLonDeg,
    /// Sensors with a connection to the same broker.
    pub(super) receivers: ReceiverIds,
    /// Translator of the messages of a broker that are text of a sensor.
    pub(super) text: Option<LineTranslator>,
}

/// Converts a receiver's stream to datagrams.
enum StreamReader {
    /// Frames of a 1090 MHz receiver.
    Frames(Box<AdsbTranslator>),
    /// ASTERIX blocks.
    Blocks(BlockStream),
}

impl StreamReader {
    fn take(
        &mut self,
        octets: &[u8],
        received: Time,
        forward: impl FnMut(Vec<u8>),
    ) -> Result<(), NotAsterix> {
        match self {
            Self::Frames(translator) => {
                translator.take(octets, received, forward);
                Ok(())
            }
            Self::Blocks(blocks) => blocks.take(octets, forward),
        }
    }

    fn end(&mut self) {
        match self {
            Self::Frames(translator) => _ = translator.end(),
            Self::Blocks(blocks) => blocks.end(),
        }
    }
}

/// Converts the messages of a broker to datagrams.
enum MessageReader {
    /// Lines of Remote ID, which the pipeline translates.
    RemoteId(RemoteIdLineCounts),
    /// Text of a sensor.
    Text(Box<LineTranslator>),
}

/// Reason for the end of a connection.
enum ConnectionEnd {
    Failed(String),
    Stopped,
}

impl From<BrokerError> for ConnectionEnd {
    fn from(broken: BrokerError) -> Self {
        Self::Failed(broken.to_string())
    }
}

impl From<io::Error> for ConnectionEnd {
    fn from(error: io::Error) -> Self {
        Self::Failed(error.to_string())
    }
}

impl ConnectionReader {
    /// Connects and reads until stopped. `forward` returns `false` if an arrival was lost.
    pub(super) async fn keep_reading(mut self, forward: impl Fn(Arrival) -> bool) {
        let Some(connection) = self.line.connection.clone() else { return };
        let mut stopped = self.stopped.clone();
        let (mut pause, mut failing) = (PAUSES[0], false);
        // The translator keeps its state of the aircraft over a short interruption.
        let frames = |framing| {
            StreamReader::Frames(Box::new(AdsbTranslator::new(framing, self.source, Some(self.origin))))
        };
        let mut reader = match connection.format {
            ConnectionFormat::Asterix => StreamReader::Blocks(BlockStream::default()),
            ConnectionFormat::Avr => frames(ReceiverFraming::Avr),
            _ => frames(ReceiverFraming::Beast),
        };
        let mut messages = match self.text.take() {
            Some(translator) => MessageReader::Text(Box::new(translator)),
            None => MessageReader::RemoteId(RemoteIdLineCounts::default()),
        };
        loop {
            let session = async {
                match connection.is_subscription() {
                    true => self.broker(&connection, &mut messages, &forward).await,
                    false => self.receiver(&mut reader, &forward).await,
                }
            };
            let Err(ended) = session.await;
            let was_open = self.counters.joined.swap(false, Ordering::Relaxed);
            let ConnectionEnd::Failed(why) = ended else { return };
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

    /// Reads a receiver's stream.
    async fn receiver(
        &self,
        reader: &mut StreamReader,
        forward: &impl Fn(Arrival) -> bool,
    ) -> Result<std::convert::Infallible, ConnectionEnd> {
        let address = self.line.destination();
        let mut stopped = self.stopped.clone();
        let connected = tokio::select! {
            connected = timeout(PATIENCE, TcpStream::connect(address)) => connected,
            () = stop(&mut stopped) => return Err(ConnectionEnd::Stopped),
        };
        let silent = |_| io::Error::new(io::ErrorKind::TimedOut, "no answer");
        let mut stream = connected.map_err(silent)??;
        self.counters.joined.store(true, Ordering::Relaxed);
        info!("connected");
        let mut buffer = vec![0; CHUNK];
        let mut take = |octets: &[u8]| {
            let received = self.clock.now();
            let taken = reader.take(octets, received, |payload| {
                let arrival = Arrival { line: self.index, received, from: address, payload };
                self.counters.note(received, forward(arrival));
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
                    // Data that has arrived by now.
                    for _ in 0..LAST_CHUNKS {
                        match stream.try_read(&mut buffer) {
                            Ok(length) if length > 0 && take(&buffer[..length]).is_ok() => {}
                            _ => break,
                        }
                    }
                    break ConnectionEnd::Stopped;
                }
            };
            match read {
                Ok(Ok(0)) => break ConnectionEnd::Failed("the receiver closed the connection".to_owned()),
                Ok(Ok(length)) => {
                    if let Err(error) = take(&buffer[..length]) {
                        break ConnectionEnd::Failed(error.to_string());
                    }
                }
                Ok(Err(error)) => break error.into(),
                Err(_) => break ConnectionEnd::Failed(format!("nothing came for {} s", SILENCE.as_secs())),
            }
        };
        reader.end();
        Err(ended)
    }

    /// Reads a broker's messages, each with one or more lines.
    async fn broker(
        &self,
        of: &Connection,
        messages: &mut MessageReader,
        forward: &impl Fn(Arrival) -> bool,
    ) -> Result<std::convert::Infallible, ConnectionEnd> {
        let (dial, login) = dial(of).map_err(ConnectionEnd::Failed)?;
        let DataSource { sac, sic } = self.source;
        let usual = || format!("utm-fusion-{sac}-{sic}-{}", self.sensor);
        let client_id = of.client_id.clone().unwrap_or_else(usual);
        let mut stopped = self.stopped.clone();
        let mut take = |message: ReceivedMessage| {
            let received = self.clock.now();
            let from = SocketAddrV4::new(Ipv4Addr::UNSPECIFIED, self.line.port);
            let note = |payload: Vec<u8>| {
                let arrival = Arrival { line: self.index, received, from, payload };
                self.counters.note(received, forward(arrival));
            };
            match messages {
                MessageReader::RemoteId(counts) => {
                    counts.lines(&message.payload, &self.receivers, |line| note(line.to_vec()));
                    self.counters.note_untranslated(counts.refused.iter());
                }
                MessageReader::Text(translator) => {
                    translator.take(&message.payload, received, note);
                    self.counters.note_untranslated(translator.dropped().iter());
                }
            }
        };
        let open = async {
            let caller = ClientIdentity { client_id: &client_id, login, will: None };
            let mut broker = Broker::open(&dial, caller).await?;
            // Retained messages are old.
            let subscription = Subscription { filter: of.topic.clone(), nolocal: false, retained: false };
            broker.subscribed(subscription, &mut take).await?;
            Ok::<_, BrokerError>(broker)
        };
        let mut broker = tokio::select! {
            broker = open => broker?,
            () = stop(&mut stopped) => return Err(ConnectionEnd::Stopped),
        };
        self.counters.joined.store(true, Ordering::Relaxed);
        info!("subscribed");
        loop {
            let ping_due = broker.ping_due();
            tokio::select! {
                heard = broker.listen() => heard?.into_iter().for_each(&mut take),
                () = sleep_until(ping_due) => broker.ping(&mut take).await?,
                () = stop(&mut stopped) => {
                    // A broker answers in order: messages sent before arrive before the answer.
                    let _ = broker.ping(&mut take).await;
                    let _ = broker.end().await;
                    return Err(ConnectionEnd::Stopped);
                }
            }
        }
    }
}

/// Waits for the stop signal, or until its sender is dropped.
async fn stop(stopped: &mut watch::Receiver<bool>) {
    let _ = stopped.wait_for(|stopped| *stopped).await;
}

fn dial(of: &Connection) -> Result<(Dialer, Option<Login>), String> {
    let broker = of.broker().ok_or("the address is no broker's")?;
    let dial = match broker.tls {
        true => Dialer::tls(
            &broker.host,
            broker.port,
            &Certificates { ca: of.ca.as_deref(), ..Certificates::default() },
        )?,
        false => Dialer::plain(&broker.host, broker.port),
    };
    let password = secret(of.password_file.as_deref(), of.password_env.as_deref())?.unwrap_or_default();
    let login = of.username.clone().map(|username| Login { username, password });
    Ok((dial, login))
}

#[cfg(test)]
#[cfg(feature = "mqtt")]
mod tests {
    use super::*;
    use crate::net::mqtt::scripted::pings_while_flooded;
    use site::config::Address;

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
            let line = ConfiguredLine {
                address: Address::Unicast(Ipv4Addr::LOCALHOST),
                port,
                sources: Vec::new(),
                sensors: vec![0],
                connection: Some(connection),
            };
            let door = ConnectionReader {
                index: 0,
                line: Arc::new(line),
                counters,
                clock: WallClock::default(),
                stopped,
                source: DataSource { sac: 25, sic: 1 },
                sensor: "gateway".to_owned(),
                origin: [52.0, 4.0],
                receivers: ReceiverIds::default(),
                text: None,
            };
            door.keep_reading(|_| true).await;
        });
        let pings = pings.await;
        assert!(pings >= 2, "{pings} pings");
        assert!(heard.joined.load(Ordering::Relaxed));
        drop(stop);
    }
}
