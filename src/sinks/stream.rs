//! Sinks over a connection, TCP or TLS, which is made again where it breaks.

use std::fmt;
use std::future::Future;
use std::io;
use std::sync::Arc;
use std::time::Duration;

use tokio::io::{AsyncRead, AsyncReadExt, AsyncWriteExt, split};
use tokio::time::{sleep, timeout};

use super::counts::Loss;
use super::desk::Desk;
use super::second::Second;
use crate::live::now;
use crate::net::dial::Dial;
use crate::net::peers::{Closing, closed};
use fusion::time::Time;

/// A receiver that takes nothing for this long, or cannot be connected to, is gone. By judgement.
const PATIENCE: Duration = Duration::from_secs(10);
/// What is read at once, octets.
const READ: usize = 16 << 10;
/// A connection shorter than this did not work: then the pauses grow, whatever was sent.
const SOUND: Duration = Duration::from_secs(5);

/// Most octets of answers that wait while something else is sent.
const UNTAKEN: usize = 1 << 20;

/// What is said on a connection, by which format. Sans-IO; it lasts as long as the sink, and each connection begins anew.
pub(crate) trait Dialogue: fmt::Debug + Send {
    /// What a connection begins with.
    fn begin(&mut self, _now: Time) -> Vec<u8> {
        Vec::new()
    }

    /// What is sent of a second.
    ///
    /// # Errors
    /// The connection is to be given up, for this reason.
    fn say(&mut self, second: &Second) -> Result<Said, String>;

    /// Takes octets that the receiver sent, cut anywhere; what is answered.
    ///
    /// # Errors
    /// The connection is to be given up, for this reason.
    fn hear(&mut self, _octets: &[u8], _now: Time) -> Result<Vec<u8>, String> {
        Ok(Vec::new())
    }

    /// What a connection ends with when the service ends.
    fn end(&mut self, _now: Time) -> Vec<u8> {
        Vec::new()
    }
}

/// What is sent of a second.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Said {
    pub(crate) octets: Vec<u8>,
    /// How many messages that is.
    pub(crate) messages: u64,
    /// Tracks that the format cannot hold.
    pub(crate) left_out: u64,
    /// The receiver has not agreed yet: the second is lost.
    pub(crate) is_withheld: bool,
}

/// One sink.
#[derive(Debug)]
pub(super) struct Peer {
    pub(super) desk: Arc<Desk>,
    pub(super) dial: Dial,
    pub(super) dialogue: Box<dyn Dialogue>,
}

/// Why a connection is no more.
struct Broken {
    why: String,
    /// A second was lost with it.
    loss: Option<Loss>,
}

impl<E: fmt::Display> From<E> for Broken {
    fn from(error: E) -> Self {
        Self { why: error.to_string(), loss: None }
    }
}

impl Peer {
    /// Sends what comes until the service ends, and connects again where the connection breaks.
    pub(super) async fn deliver(mut self, mut closing: Closing) {
        loop {
            let Err(Broken { why, loss }) = self.session(&mut closing).await else { return };
            let wait = self.desk.fails(why, loss);
            tokio::select! {
                () = sleep(wait) => {}
                () = closed(&mut closing) => return,
            }
        }
    }

    /// Whether it can be connected to.
    pub(super) async fn reach(&self) -> Result<(), String> {
        let connected = within(PATIENCE, "no connection", self.dial.dial()).await;
        connected.map(drop).map_err(|error| error.to_string())
    }

    /// A connection from its beginning on.
    async fn session(&mut self, closing: &mut Closing) -> Result<(), Broken> {
        let Self { desk, dial, dialogue } = self;
        let stream = tokio::select! {
            stream = within(PATIENCE, "no connection", dial.dial()) => stream?,
            () = closed(closing) => return Ok(()),
        };
        desk.begin();
        let (mut reader, mut writer) = split(stream);
        let mut heard = vec![0; READ];
        let mut octets = dialogue.begin(now());
        // It works once it has lasted: a receiver that closes at once is one that fails.
        let sound = sleep(SOUND);
        tokio::pin!(sound);
        let mut is_sound = false;
        loop {
            while !octets.is_empty() {
                let written = write(&mut writer, &octets);
                let answers = exchange(written, &mut reader, &mut heard, dialogue.as_mut()).await?;
                octets = answers;
            }
            let second = tokio::select! {
                second = desk.next() => second,
                count = reader.read(&mut heard) => {
                    octets = hear(count?, &heard, dialogue.as_mut())?;
                    continue;
                }
                () = &mut sound, if !is_sound => {
                    is_sound = true;
                    desk.works();
                    continue;
                }
                () = closed(closing) => break,
            };
            // Whatever goes wrong with it now, it is lost.
            let lose = |why: String| Broken { why, loss: Some(Loss::Unreachable) };
            let Said { octets: said, messages, left_out, is_withheld } =
                dialogue.say(&second).map_err(lose)?;
            desk.left_out(left_out);
            if is_withheld {
                desk.withheld();
            }
            let written = write(&mut writer, &said);
            let answers = exchange(written, &mut reader, &mut heard, dialogue.as_mut()).await;
            octets = answers.map_err(|broken| lose(broken.why))?;
            desk.sent(messages);
        }
        while let Some(second) = desk.take() {
            let Said { octets, messages, left_out, .. } = dialogue.say(&second)?;
            desk.left_out(left_out);
            write(&mut writer, &octets).await?;
            desk.sent(messages);
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

/// Writes, and reads meanwhile: a receiver that has to be read before it takes more does not stand still. What is answered.
async fn exchange(
    written: impl Future<Output = io::Result<()>>,
    reader: &mut (impl AsyncRead + Unpin),
    heard: &mut [u8],
    dialogue: &mut dyn Dialogue,
) -> Result<Vec<u8>, Broken> {
    tokio::pin!(written);
    let mut answers = Vec::new();
    loop {
        tokio::select! {
            done = &mut written => {
                done?;
                return Ok(answers);
            }
            count = reader.read(heard) => {
                answers.extend(hear(count?, heard, dialogue)?);
                if answers.len() > UNTAKEN {
                    return Err("the receiver asks for more than it takes".into());
                }
            }
        }
    }
}

fn hear(count: usize, heard: &[u8], dialogue: &mut dyn Dialogue) -> Result<Vec<u8>, String> {
    if count == 0 {
        return Err("the receiver closed the connection".to_owned());
    }
    dialogue.hear(&heard[..count], now())
}
