//! Sinks over a TCP or TLS connection, which is opened again when it breaks.

use std::fmt;
use std::future::Future;
use std::io;
use std::sync::Arc;
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWriteExt, split};
use tokio::time::{sleep, timeout};

use super::counts::SinkLoss;
use super::delivery::SinkQueue;
use super::second::PictureSecond;
use crate::live::now;
use crate::net::dial::Dialer;
use crate::net::peers::{Closing, closed};
use fusion::time::Time;

/// Timeout for connecting, and for a receiver that accepts no data. Chosen by judgement.
const PATIENCE: Duration = Duration::from_secs(10);
/// Maximum number of octets per read.
const READ: usize = 16 << 10;
/// Minimum duration of a working connection. After a shorter one the pauses grow, whatever was sent.
const SOUND: Duration = Duration::from_secs(5);

/// Maximum number of octets of answers waiting while other data is sent.
const UNTAKEN: usize = 1 << 20;

/// Protocol of a format on a connection. Sans-IO; lives as long as the sink, and starts again with each connection.
pub(crate) trait Dialogue: fmt::Debug + Send {
    /// Octets that begin a connection.
    fn begin(&mut self, _now: Time) -> Vec<u8> {
        Vec::new()
    }

    /// Octets for a second.
    ///
    /// # Errors
    /// Reason for which the connection has to be closed.
    fn encode(&mut self, second: &PictureSecond) -> Result<EncodedSecond, String>;

    /// Handles octets from the receiver, cut anywhere; returns the answer.
    ///
    /// # Errors
    /// Reason for which the connection has to be closed.
    fn handle(&mut self, _octets: &[u8], _now: Time) -> Result<Vec<u8>, String> {
        Ok(Vec::new())
    }

    /// Octets that end a connection when the service ends.
    fn end(&mut self, _now: Time) -> Vec<u8> {
        Vec::new()
    }
}

/// Octets sent for a second, with their counts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct EncodedSecond {
    pub octets: Vec<u8>,
    /// Number of messages.
    pub messages: u64,
    /// Tracks that the format cannot represent.
    pub left_out: u64,
    /// Whether the receiver has not accepted the registration yet, so that the second is lost.
    pub(crate) is_withheld: bool,
}

/// A sink over a connection.
#[derive(Debug)]
pub(super) struct StreamSink {
    pub(super) queue: Arc<SinkQueue>,
    pub(super) dial: Dialer,
    pub(super) dialogue: Box<dyn Dialogue>,
}

/// Reason for the end of a connection.
struct StreamFailure {
    why: String,
    /// Reason for which a second was lost with it.
    loss: Option<SinkLoss>,
}

impl<E: fmt::Display> From<E> for StreamFailure {
    fn from(error: E) -> Self {
        Self { why: error.to_string(), loss: None }
    }
}

impl StreamSink {
    /// Sends until the service ends, and connects again when the connection breaks.
    pub(super) async fn deliver(mut self, mut closing: Closing) {
        loop {
            let Err(StreamFailure { why, loss }) = self.session(&mut closing).await else { return };
            let wait = self.queue.fails(why, loss);
            tokio::select! {
                () = sleep(wait) => {}
                () = closed(&mut closing) => return,
            }
        }
    }

    /// Whether the receiver accepts a connection.
    pub(super) async fn reach(&self) -> Result<(), String> {
        let connected = within(PATIENCE, "no connection", self.dial.dial()).await;
        connected.map(drop).map_err(|error| error.to_string())
    }

    /// Runs a connection from its beginning.
    async fn session(&mut self, closing: &mut Closing) -> Result<(), StreamFailure> {
        let Self { queue, dial, dialogue } = self;
        let stream = tokio::select! {
            stream = within(PATIENCE, "no connection", dial.dial()) => stream?,
            () = closed(closing) => return Ok(()),
        };
        queue.begin();
        let (mut reader, mut writer) = split(stream);
        let mut buffer = vec![0; READ];
        let mut octets = dialogue.begin(now());
        // A connection works once it has lasted: a receiver that closes at once is failing.
        let sound = sleep(SOUND);
        tokio::pin!(sound);
        let mut is_sound = false;
        loop {
            while !octets.is_empty() {
                let written = write(&mut writer, &octets);
                let answers = exchange(written, &mut reader, &mut buffer, dialogue.as_mut()).await?;
                octets = answers;
            }
            let second = tokio::select! {
                second = queue.next() => second,
                count = reader.read(&mut buffer) => {
                    octets = receive(count?, &buffer, dialogue.as_mut())?;
                    continue;
                }
                () = &mut sound, if !is_sound => {
                    is_sound = true;
                    queue.works();
                    continue;
                }
                () = closed(closing) => break,
            };
            // From here on any failure loses this second.
            let lose = |why: String| StreamFailure { why, loss: Some(SinkLoss::Unreachable) };
            let EncodedSecond { octets: encoded, messages, left_out, is_withheld } =
                dialogue.encode(&second).map_err(lose)?;
            queue.left_out(left_out);
            if is_withheld {
                queue.withheld();
            }
            let written = write(&mut writer, &encoded);
            let answers = exchange(written, &mut reader, &mut buffer, dialogue.as_mut()).await;
            octets = answers.map_err(|broken| lose(broken.why))?;
            queue.sent(messages);
        }
        while let Some(second) = queue.take() {
            let EncodedSecond { octets, messages, left_out, .. } = dialogue.encode(&second)?;
            queue.left_out(left_out);
            write(&mut writer, &octets).await?;
            queue.sent(messages);
        }
        write(&mut writer, &dialogue.end(now())).await?;
        writer.shutdown().await?;
        Ok(())
    }
}

async fn write(writer: &mut (impl AsyncWriteExt + Unpin), octets: &[u8]) -> io::Result<()> {
    let written = async {
        writer.write_all(octets).await?;
        writer.flush().await
    };
    within(PATIENCE, "nothing taken", written).await
}

async fn within<T>(
    patience: Duration,
    what: &str,
    done: impl Future<Output = io::Result<T>>,
) -> io::Result<T> {
    let late = || io::Error::new(io::ErrorKind::TimedOut, format!("{what} within {} s", patience.as_secs()));
    timeout(patience, done).await.unwrap_or_else(|_| Err(late()))
}

/// Writes, and reads meanwhile, because some receivers accept data only while they are read. Returns the answers.
async fn exchange(
    written: impl Future<Output = io::Result<()>>,
    reader: &mut (impl AsyncRead + Unpin),
    buffer: &mut [u8],
    dialogue: &mut dyn Dialogue,
) -> Result<Vec<u8>, StreamFailure> {
    tokio::pin!(written);
    let mut answers = Vec::new();
    loop {
        tokio::select! {
            done = &mut written => {
                done?;
                return Ok(answers);
            }
            count = reader.read(buffer) => {
                answers.extend(receive(count?, buffer, dialogue)?);
                if answers.len() > UNTAKEN {
                    return Err("the receiver asks for more than it takes".into());
                }
            }
        }
    }
}

fn receive(count: usize, buffer: &[u8], dialogue: &mut dyn Dialogue) -> Result<Vec<u8>, String> {
    if count == 0 {
        return Err("the receiver closed the connection".to_owned());
    }
    dialogue.handle(&buffer[..count], now())
}
