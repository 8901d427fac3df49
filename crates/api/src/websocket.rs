//! `GET /api/v1/stream/ws`: the events of the stream as WebSocket messages.
//!
//! As with Server-Sent Events, a reader is a position in the log, with at most one waiting message per client. A client that does
//! not take it in time, or answers no ping, is dropped and counted.

mod handshake;

use std::sync::Arc;
use std::time::Duration;

use hyper::upgrade::Upgraded;
use hyper_util::rt::TokioIo;
use tokio::io::{AsyncReadExt, AsyncWriteExt, ReadHalf, WriteHalf, split};
use tokio::time::{Instant, interval_at, timeout};
use tracing::debug;

use super::connection_limit::CountedConnection;
use super::payload::Payload;
use super::reader::EventStream;
use super::request::{ApiRequest, ApiResult};
use super::stream_limit::StreamDropReason;
use super::websocket_frames::{self as frames, Code, Control};
use handshake::Agreed;

/// Timeout for the client's answer to the close frame.
const FAREWELL: Duration = Duration::from_secs(1);
/// Maximum number of frames from a client between two events. There is at least one event per second.
const FRAMES: u32 = 100;

/// Opens a stream.
pub fn open(request: &ApiRequest) -> ApiResult {
    let is_id = |id: &String| {
        id.split_once('-').is_some_and(|(start, number)| are_digits(start) && are_digits(number))
    };
    let last = request.query.value("last_event_id", "the id of an event", is_id)?;
    let last = last.as_deref().or_else(|| request.header("last-event-id"));
    let agreed = Agreed::of(&request.headers);
    let prepare = match &agreed {
        Some(agreed) if agreed.is_deflated => |snapshot: &Payload| _ = snapshot.message(true),
        _ => |snapshot: &Payload| _ = snapshot.message(false),
    };
    let reader = EventStream::open(request, last, prepare)?;
    let (Some(agreed), Some(upgrade)) = (agreed, request.upgrade.clone()) else {
        return Ok(handshake::required());
    };
    let (connection, stream_limit, is_deflated) =
        (request.connection.clone(), request.state.stream_limit.clone(), agreed.is_deflated);
    let patience = request.state.options.patience;
    let session = async move {
        // A client that leaves before the upgrade has no connection.
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
            _place: connection,
        };
        if let Some(dropped) = session.run().await {
            debug!("a WebSocket is dropped: {dropped:?}");
            stream_limit.record_drop(dropped);
        }
    };
    tokio::spawn(session);
    Ok(agreed.answer())
}

fn are_digits(text: &str) -> bool {
    !text.is_empty() && text.bytes().all(|octet| octet.is_ascii_digit())
}

struct Session {
    reader: EventStream,
    input: ReadHalf<TokioIo<Upgraded>>,
    output: WriteHalf<TokioIo<Upgraded>>,
    is_deflated: bool,
    /// Timeout for sending a message and for the answer to a ping.
    patience: Duration,
    /// Received octets, up to one frame.
    came: Vec<u8>,
    /// Number of frames received since the last event.
    frames: u32,
    /// Counts the connection until the session ends.
    _place: Option<Arc<CountedConnection>>,
}

/// Reason why a session ends.
enum SessionEnd {
    /// The client has left or finished.
    Gone,
    /// The stream has ended; its last event states the reason.
    Over,
    /// The client violates the protocol.
    ConnectionRefusal(Code),
    /// The client takes no data, so no close frame is sent.
    Lost(StreamDropReason),
}

impl Session {
    /// Runs the session to its end. Returns the reason if the client was dropped.
    async fn run(mut self) -> Option<StreamDropReason> {
        let (code, dropped) = match self.serve().await {
            SessionEnd::Gone => (Code::Normal, None),
            SessionEnd::Over => (Code::GoingAway, None),
            SessionEnd::ConnectionRefusal(code) => (code, Some(StreamDropReason::Protocol)),
            SessionEnd::Lost(dropped) => return Some(dropped),
        };
        self.leave(code).await;
        dropped
    }

    async fn serve(&mut self) -> SessionEnd {
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
                    None => return SessionEnd::Over,
                },
                count = self.input.read(&mut chunk) => match count {
                    Ok(0) | Err(_) => return SessionEnd::Gone,
                    Ok(count) => {
                        is_asked = false;
                        self.came.extend_from_slice(&chunk[..count]);
                        self.receive().await
                    }
                },
                _ = ping.tick() => {
                    if std::mem::replace(&mut is_asked, true) {
                        return SessionEnd::Lost(StreamDropReason::Silent);
                    }
                    self.send(&frames::ping()).await
                }
            };
            if let Err(end) = sent {
                return end;
            }
        }
    }

    /// Answers the received frames.
    async fn receive(&mut self) -> Result<(), SessionEnd> {
        while let Some(control) = frames::take(&mut self.came).map_err(SessionEnd::ConnectionRefusal)? {
            self.frames += 1;
            match control {
                _ if self.frames > FRAMES => return Err(SessionEnd::ConnectionRefusal(Code::Policy)),
                Control::Ping(octets) => self.send(&frames::pong(&octets)).await?,
                Control::Pong => {}
                Control::Close => return Err(SessionEnd::Gone),
            }
        }
        Ok(())
    }

    async fn send(&mut self, frame: &[u8]) -> Result<(), SessionEnd> {
        let sending = async {
            self.output.write_all(frame).await?;
            self.output.flush().await
        };
        match timeout(self.patience, sending).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err(SessionEnd::Gone),
            Err(_) => Err(SessionEnd::Lost(StreamDropReason::Slow)),
        }
    }

    /// Sends the close frame, and reads until the client has answered, so that the frame is not lost with the connection.
    async fn leave(&mut self, code: Code) {
        let goodbye = async {
            self.output.write_all(&frames::close(code)).await?;
            self.output.shutdown().await?;
            let mut chunk = [0; 512];
            while self.input.read(&mut chunk).await? > 0 {}
            std::io::Result::Ok(())
        };
        // A client that has left receives nothing.
        let _ = timeout(FAREWELL, goodbye).await;
    }
}
