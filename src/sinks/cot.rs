//! `[[output.cot]]`: Cursor on Target, to a group or a host over UDP, or to a TAK server over TCP or TLS.

use std::collections::BTreeSet;
use std::net::Ipv4Addr;
use std::sync::Arc;

use super::Sink;
use super::datagrams::Datagrams;
use super::desk::Desk;
use super::second::Second;
use super::stream::{Dialogue, Peer, Said};
use crate::config::{self, Carrier, PictureKind, Site};
use crate::formats::{CotSecond, CotWriter};
use crate::live::Level;
use crate::net::dial::{Dial, Proofs};
use crate::net::peers::is_local;

/// Opens a sink; nobody is connected to yet.
pub(super) fn open(cot: &config::Cot, site: &Site) -> Result<Sink, String> {
    let desk = Arc::new(Desk::new(format!("cot:{}", cot.id), cot.picture));
    let writer = CotWriter { site: site.name.clone(), stale: cot.stale_s };
    let proofs = Proofs {
        ca: cot.ca.as_deref(),
        server_name: cot.server_name.as_deref(),
        own: cot.certificate.as_deref().zip(cot.key.as_deref()),
    };
    let dial = match &cot.url.carrier {
        Carrier::Udp(to) => {
            let is_group = to.ip().is_multicast();
            let interface = is_group.then_some(cot.interface.unwrap_or(Ipv4Addr::UNSPECIFIED));
            // A group stays in its network unless somebody says otherwise; a host may be anywhere.
            let ttl = cot.ttl.unwrap_or(if is_group { 1 } else { 64 });
            return Ok(Sink::Datagrams(Datagrams {
                messages: Box::new(datagrams(CotEvents::new(writer), desk.clone())),
                desk,
                to: *to,
                interface,
                ttl,
            }));
        }
        Carrier::Tcp(host, port) => Dial::plain(host, *port),
        Carrier::Tls(host, port) => Dial::tls(host, *port, &proofs)?,
    };
    Ok(Sink::Peer(Peer { desk, dial, dialogue: Box::new(Events { events: CotEvents::new(writer) }) }))
}

/// For people.
pub(super) fn line(cot: &config::Cot) -> String {
    let who = if cot.certificate.is_some() { ", with a certificate of its own" } else { "" };
    format!("picture to cot:{}: {}, {}{who}", cot.id, cot.url, cot.picture.name())
}

/// What works and should not stay so.
pub(super) fn warning(cot: &config::Cot) -> Option<String> {
    let Carrier::Tcp(host, _) = &cot.url.carrier else { return None };
    (!is_local(host)).then(|| format!("cot:{}: the picture travels beyond this machine without TLS", cot.id))
}

/// Events on a connection. What a TAK server sends, the events of others among it, is of no use here.
#[derive(Debug)]
struct Events {
    events: CotEvents,
}

impl Dialogue for Events {
    fn say(&mut self, second: &Second) -> Result<Said, String> {
        let mut said = Said::default();
        said.left_out = self.events.of(second, |event| {
            said.octets.extend(event.into_bytes());
            said.messages += 1;
        });
        Ok(said)
    }
}

fn datagrams(mut events: CotEvents, desk: Arc<Desk>) -> impl FnMut(&Second) -> Vec<Vec<u8>> {
    move |second| {
        let mut datagrams = Vec::new();
        let left_out = events.of(second, |event| datagrams.push(event.into_bytes()));
        desk.left_out(left_out);
        datagrams
    }
}

/// The events of each second, and the deletion of the tracks that have ended.
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

    /// Hands on the events of a second; the number of tracks that no event can hold.
    fn of(&mut self, second: &Second, mut hand_on: impl FnMut(String)) -> u64 {
        let of_second = CotSecond {
            due: second.due,
            is_predicted: second.kind == PictureKind::Now,
            is_degraded: second.level > Level::Ok,
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
