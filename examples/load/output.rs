//! Lateness of slots at a downstream system, and lateness of timers on this machine.

use std::collections::BTreeMap;
use std::error::Error;
use std::net::{Ipv4Addr, SocketAddrV4, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use asterix::blocks;
use asterix::cat129::Record;
use fusion::time::{SECOND, Time};
use socket2::{Domain, Protocol, Socket, Type};
use utm_fusion::config::{Address, PictureKind, Sink};
use utm_fusion::live::now;

/// Time from the centre of a slot until it is due, nanoseconds: it is published 6.25 s after it opens.
/// `NOW_AFTER_CENTRE` applies to the current picture, which is due when the slot opens.
const AFTER_CENTRE: i64 = 6_125_000_000;
const NOW_AFTER_CENTRE: i64 = -125_000_000;
const SLOT: i64 = SECOND / 4;
const DAY: i64 = 86_400 * SECOND;

/// Lateness in seconds, by due time.
#[derive(Debug, Default)]
pub struct LatenessByTime(BTreeMap<Time, f64>);

impl LatenessByTime {
    fn note(&mut self, due: Time, at: Time) {
        let late_s = at.seconds_since(due);
        // A slot is complete with its last datagram.
        self.0.entry(due).and_modify(|known| *known = known.max(late_s)).or_insert(late_s);
    }

    /// Lateness of items due from `begin` to `end`.
    pub fn between(&self, begin: Time, end: Time) -> impl Iterator<Item = f64> {
        self.0.range(begin..end).map(|(_, &late_s)| late_s)
    }
}

/// A member of the output's multicast group.
pub struct OutputListener {
    socket: UdpSocket,
    /// Time from the centre of a slot until it is due, nanoseconds.
    after_centre: i64,
}

impl OutputListener {
    /// Joins the group.
    pub fn listen(sink: Sink) -> Result<Self, Box<dyn Error + Send + Sync>> {
        let Address::Multicast { group, .. } = sink.address else {
            return Err("the output is no group".into());
        };
        let socket = Socket::new(Domain::IPV4, Type::DGRAM, Some(Protocol::UDP))?;
        socket.set_reuse_address(true)?;
        socket.set_recv_buffer_size(4 << 20)?;
        socket.bind(&SocketAddrV4::new(group, sink.port).into())?;
        socket.join_multicast_v4(&group, &Ipv4Addr::LOCALHOST)?;
        socket.set_read_timeout(Some(Duration::from_millis(200)))?;
        let after_centre = match sink.picture {
            PictureKind::Lagged => AFTER_CENTRE,
            PictureKind::Now => NOW_AFTER_CENTRE,
        };
        Ok(Self { socket: socket.into(), after_centre })
    }

    /// Receives until `stop`.
    pub fn hear(&self, stop: &AtomicBool) -> LatenessByTime {
        let mut lateness = LatenessByTime::default();
        let mut octets = [0; 2048];
        while !stop.load(Ordering::Relaxed) {
            let Ok(length) = self.socket.recv(&mut octets) else { continue };
            let at = now();
            let first = blocks(&octets[..length]).flatten().find(|block| block.category == 129);
            let time_of_day = first.and_then(|block| {
                block.records::<Record>().flatten().find_map(|located| located.record.time_of_day)
            });
            if let Some(time_of_day) = time_of_day {
                let since_midnight = (time_of_day.seconds() * SECOND as f64) as i64 + self.after_centre;
                // The day that puts it nearest to now.
                let late = (at.nanos() - since_midnight + DAY / 2).rem_euclid(DAY) - DAY / 2;
                lateness.note(Time::from_nanos(at.nanos() - late), at);
            }
        }
        lateness
    }
}

/// Measures a thread that only sleeps until each slot is due, like an idle service.
pub fn idle_timer(stop: &AtomicBool) -> LatenessByTime {
    let mut lateness = LatenessByTime::default();
    while !stop.load(Ordering::Relaxed) {
        let due = Time::from_nanos((now().nanos() / SLOT + 1) * SLOT);
        thread::sleep(Duration::try_from(due - now()).unwrap_or_default());
        lateness.note(due, now());
    }
    lateness
}
