//! `[[output.cot]]`: Cursor on Target, to a group or a host over UDP, or to a TAK server over TCP or TLS.

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
                messages: Box::new(datagrams(writer, desk.clone())),
                desk,
                to: *to,
                interface,
                ttl,
            }));
        }
        Carrier::Tcp(host, port) => Dial::plain(host, *port),
        Carrier::Tls(host, port) => Dial::tls(host, *port, &proofs)?,
    };
    Ok(Sink::Peer(Peer { desk, dial, dialogue: Box::new(Events { writer }) }))
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
    writer: CotWriter,
}

impl Dialogue for Events {
    fn say(&mut self, second: &Second) -> Result<Said, String> {
        let mut said = Said::default();
        for event in events(&self.writer, second) {
            match event {
                Some(event) => {
                    said.octets.extend(event.into_bytes());
                    said.messages += 1;
                }
                None => said.left_out += 1,
            }
        }
        Ok(said)
    }
}

fn datagrams(writer: CotWriter, desk: Arc<Desk>) -> impl FnMut(&Second) -> Vec<Vec<u8>> {
    move |second| {
        let (mut datagrams, mut left_out) = (Vec::new(), 0);
        for event in events(&writer, second) {
            match event {
                Some(event) => datagrams.push(event.into_bytes()),
                None => left_out += 1,
            }
        }
        desk.left_out(left_out);
        datagrams
    }
}

fn events(writer: &CotWriter, second: &Second) -> impl Iterator<Item = Option<String>> {
    let of_second = CotSecond {
        due: second.due,
        is_predicted: second.kind == PictureKind::Now,
        is_degraded: second.level > Level::Ok,
    };
    second.tracks().map(move |track| writer.event(track, &second.maker, of_second))
}
