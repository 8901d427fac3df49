//! `GET /api/v1/stream/ws`: the events of the stream as messages of a WebSocket.
//!
//! Like a reader of Server-Sent Events it is a place in the log: what waits for a client that does not read is one message. Who
//! does not take that in time, or answers no ping, is dropped and counted.

pub mod frames;
mod handshake;

use std::sync::Arc;
use std::time::Duration;

use hyper::upgrade::Upgraded;
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncReadExt, AsyncWriteExt, ReadHalf, WriteHalf, split};
use tokio::time::{Instant, interval_at, timeout};
use tracing::debug;

use super::ask::{Answer, Ask};
use super::door::Place;
use super::payload::Payload;
use super::reader::Reader;
use super::seats::Dropped;
use frames::{Code, Control};
use handshake::Agreed;

/// How long an answer to the last frame is waited for.
const FAREWELL: Duration = Duration::from_secs(1);
/// Frames that a client may send between two events; there is one a second at least.
const FRAMES: u32 = 100;

/// Opens a stream.
pub fn open(ask: &Ask) -> Answer {
    let is_id = |id: &String| {
        id.split_once('-').is_some_and(|(start, number)| are_digits(start) && are_digits(number))
    };
    let last = ask.query.value("last_event_id", "the id of an event", is_id)?;
    let last = last.as_deref().or_else(|| ask.header("last-event-id"));
    let agreed = Agreed::of(&ask.headers);
    let prepare = match &agreed {
        Some(agreed) if agreed.is_deflated => |snapshot: &Payload| _ = snapshot.message(true),
        _ => |snapshot: &Payload| _ = snapshot.message(false),
    };
    let reader = Reader::open(ask, last, prepare)?;
    let (Some(agreed), Some(upgrade)) = (agreed, ask.upgrade.clone()) else {
        return Ok(handshake::required());
    };
    let (place, seats, is_deflated) = (ask.place.clone(), ask.state.seats.clone(), agreed.is_deflated);
    let patience = ask.state.options.patience;
    let session = async move {
        // Whoever goes away before the answer has no connection.
        let Ok(upgraded) = upgrade.await else { return };
        let (input, output) = split(TokioIo::new(upgraded));
        let session = Session {
            reader,
            input,
            output,
            is_deflated,
            patience,
            came: Vec::new(),
            frames: 0,
            _place: place,
        };
        if let Some(dropped) = session.run().await {
            debug!("a WebSocket is dropped: {dropped:?}");
            seats.note_dropped(dropped);
        }
    };
    tokio::spawn(session);
    Ok(agreed.answer())
}

fn are_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|octet| octet.is_ascii_digit())
}

struct Session {
    reader: Reader,
    input: ReadHalf<TokioIo<Upgraded>>,
    output: WriteHalf<TokioIo<Upgraded>>,
    is_deflated: bool,
    /// How long a client may take for a message, and for the answer to a ping.
    patience: Duration,
    /// What the client has sent, up to a frame.
    came: Vec<u8>,
    /// How many frames it has sent since the last event.
    frames: u32,
    /// Its connection counts as long as this lasts.
    _place: Option<Arc<Place>>,
}

/// How a session ends.
enum End {
    /// The client is gone, or has said that it is done.
    Gone,
    /// There is nothing more to say; the last event says why.
    Over,
    /// The client does not keep to what is agreed.
    Refused(Code),
    /// The client takes nothing, so nothing more is sent.
    Lost(Dropped),
}

impl Session {
    /// Until it ends; what was wrong with the client, if something was.
    async fn run(mut self) -> Option<Dropped> {
        let (code, dropped) = match self.serve().await {
            End::Gone => (Code::Normal, None),
            End::Over => (Code::GoingAway, None),
            End::Refused(code) => (code, Some(Dropped::Protocol)),
            End::Lost(dropped) => return Some(dropped),
        };
        self.leave(code).await;
        dropped
    }

    async fn serve(&mut self) -> End {
        let mut ping = interval_at(Instant::now() + self.patience, self.patience);
        let mut is_asked = false;
        let mut chunk = [0; 512];
        loop {
            let sent = tokio::select! {
                event = self.reader.next() => match event {
                    Some(event) => {
                        self.frames = 0;
                        self.send(&event.message(self.is_deflated)).await
                    }
                    None => return End::Over,
                },
                count = self.input.read(&mut chunk) => match count {
                    Ok(0) | Err(_) => return End::Gone,
                    Ok(count) => {
                        is_asked = false;
                        self.came.extend_from_slice(&chunk[..count]);
                        self.heard().await
                    }
                },
                _ = ping.tick() => {
                    if std::mem::replace(&mut is_asked, true) {
                        return End::Lost(Dropped::Silent);
                    }
                    self.send(&frames::ping()).await
                }
            };
            if let Err(end) = sent {
                return end;
            }
        }
    }

    /// Answers what the client has sent.
    async fn heard(&mut self) -> Result<(), End> {
        while let Some(control) = frames::take(&mut self.came).map_err(End::Refused)? {
            self.frames += 1;
            match control {
                _ if self.frames > FRAMES => return Err(End::Refused(Code::Policy)),
                Control::Ping(octets) => self.send(&frames::pong(&octets)).await?,
                Control::Pong => {}
                Control::Close => return Err(End::Gone),
            }
        }
        Ok(())
    }

    async fn send(&mut self, frame: &[u8]) -> Result<(), End> {
        let sending = async {
            self.output.write_all(frame).await?;
            self.output.flush().await
        };
        match timeout(self.patience, sending).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err(End::Gone),
            Err(_) => Err(End::Lost(Dropped::Slow)),
        }
    }

    /// Says that this was all, and waits until the client has heard it: what it has sent meanwhile is read, so that the last
    /// frame is not lost with the connection.
    async fn leave(&mut self, code: Code) {
        let goodbye = async {
            self.output.write_all(&frames::close(code)).await?;
            self.output.shutdown().await?;
            let mut chunk = [0; 512];
            while self.input.read(&mut chunk).await? > 0 {}
            std::io::Result::Ok(())
        };
        // Who is gone already hears nothing.
        let _ = timeout(FAREWELL, goodbye).await;
    }
}
