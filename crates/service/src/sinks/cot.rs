//! `[[output.cot]]`: Cursor on Target, to a group or a host over UDP, or to a TAK server over TCP or TLS.

use std::collections::BTreeSet;
use std::net::Ipv4Addr;
use std::sync::Arc;

use super::PictureSink;
use super::datagrams::DatagramSink;
use super::delivery::SinkQueue;
use super::second::PictureSecond;
use super::stream::{Dialogue, EncodedSecond, StreamSink};
use crate::live::ServiceLevel;
use crate::net::dial::{Certificates, Dialer};
use crate::net::peers::is_local;
use picture::formats::{CotSecond, CotWriter};
use site::config::{self, Carrier, PictureKind, Site};

/// Opens a sink; no connection is made yet.
pub(super) fn open(cot: &config::Cot, site: &Site) -> Result<PictureSink, String> {
    let queue = Arc::new(SinkQueue::new(format!("cot:{}", cot.id), cot.picture));
    let writer = CotWriter { site: site.name.clone(), stale: cot.stale_s };
    let proofs = Certificates {
        ca: cot.ca.as_deref(),
        server_name: cot.server_name.as_deref(),
        own: cot.certificate.as_deref().zip(cot.key.as_deref()),
    };
    let dial = match &cot.url.carrier {
        Carrier::Udp(to) => {
            let is_group = to.ip().is_multicast();
            let interface = is_group.then_some(cot.interface.unwrap_or(Ipv4Addr::UNSPECIFIED));
            // By default multicast stays within the local network, while a host may be anywhere.
            let ttl = cot.ttl.unwrap_or(if is_group { 1 } else { 64 });
            return Ok(PictureSink::Datagrams(DatagramSink {
                messages: Box::new(datagrams(CotEvents::new(writer), queue.clone())),
                queue,
                to: *to,
                interface,
                ttl,
            }));
        }
        Carrier::Tcp(host, port) => Dialer::plain(host, *port),
        Carrier::Tls(host, port) => Dialer::tls(host, *port, &proofs)?,
    };
    Ok(PictureSink::Peer(StreamSink {
        queue,
        dial,
        dialogue: Box::new(CotDialogue { events: CotEvents::new(writer) }),
    }))
}

/// A description of the sink, without secrets.
pub(super) fn line(cot: &config::Cot) -> String {
    let who = if cot.certificate.is_some() { ", with a certificate of its own" } else { "" };
    format!("picture to cot:{}: {}, {}{who}", cot.id, cot.url, cot.picture.name())
}

/// A weakness of the configuration that the operator should remove.
pub(super) fn warning(cot: &config::Cot) -> Option<String> {
    let Carrier::Tcp(host, _) = &cot.url.carrier else { return None };
    (!is_local(host)).then(|| format!("cot:{}: the picture travels beyond this machine without TLS", cot.id))
}

/// Events on a connection. Messages from a TAK server, such as events of other clients, are ignored.
#[derive(Debug)]
struct CotDialogue {
    events: CotEvents,
}

impl Dialogue for CotDialogue {
    fn encode(&mut self, second: &PictureSecond) -> Result<EncodedSecond, String> {
        let mut said = EncodedSecond::default();
        said.left_out = self.events.of(second, |event| {
            said.octets.extend(event.into_bytes());
            said.messages += 1;
        });
        Ok(said)
    }
}

fn datagrams(mut events: CotEvents, queue: Arc<SinkQueue>) -> impl FnMut(&PictureSecond) -> Vec<Vec<u8>> {
    move |second| {
        let mut datagrams = Vec::new();
        let left_out = events.of(second, |event| datagrams.push(event.into_bytes()));
        queue.left_out(left_out);
        datagrams
    }
}

/// The events of each second, and deletions of tracks that have ended.
#[derive(Debug)]
struct CotEvents {
    writer: CotWriter,
    /// The uids that the receiver shows.
    shown: BTreeSet<String>,
}

impl CotEvents {
    fn new(writer: CotWriter) -> Self {
        Self { writer, shown: BTreeSet::new() }
    }

    /// Passes the events of a second to `hand_on`. Returns the number of tracks that no event can represent.
    fn of(&mut self, second: &PictureSecond, mut hand_on: impl FnMut(String)) -> u64 {
        let of_second = CotSecond {
            due: second.due,
            is_predicted: second.kind == PictureKind::Now,
            is_degraded: second.level > ServiceLevel::Ok,
        };
        let (mut shown, mut left_out) = (BTreeSet::new(), 0);
        for track in second.tracks() {
            match self.writer.event(track, &second.maker, of_second) {
                Some(event) => {
                    shown.insert(self.writer.uid(track, &second.maker));
                    hand_on(event);
                }
                None => left_out += 1,
            }
        }
        let ended = self.shown.difference(&shown);
        ended.for_each(|uid| hand_on(self.writer.delete(uid, second.due)));
        self.shown = shown;
        left_out
    }
}
