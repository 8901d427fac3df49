//! Frames without a UDP datagram, counted by reason.

use std::collections::BTreeMap;
use std::fmt;

/// Reason why a captured frame has no datagram. [`NotIp`](Self::NotIp), [`NotUdp`](Self::NotUdp),
/// [`NotRemoteId`](Self::NotRemoteId), [`NotAdsb`](Self::NotAdsb), [`ReceiverId`](Self::ReceiverId),
/// [`NotPosition`](Self::NotPosition) and [`UnknownSystem`](Self::UnknownSystem) are other traffic. A radio channel loses
/// frames, and a [`Copy`](Self::Copy) loses no data. Any other reason may have cost surveillance data.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum SkipReason {
    /// ARP, spanning tree, LLDP, IEEE 802.3 frames, …
    NotIp,
    /// TCP, ICMP, IGMP, …
    NotUdp,
    /// A fragment of an IP packet whose other fragments are missing.
    Fragment,
    /// The capture holds fewer octets than the frame's headers announce: its snapshot length was too short.
    Truncated,
    /// Contradicting headers, such as a UDP length larger than its IP packet.
    Malformed,
    /// The frame has more headers, tags or tunnels than are read.
    TooDeep,
    /// In a pcapng file or after a PPI header: frames with an unsupported link header.
    LinkType,
    /// In a pcapng file, on an interface that the file does not describe.
    UnknownInterface,
    /// On a radio channel: a frame that carries no Remote ID.
    NotRemoteId,
    /// On 1090 MHz: a reply to an interrogator in Mode A, C or S, or a squitter without usable data.
    NotAdsb,
    /// On 1090 MHz: a frame that identifies the receiver of the following frames.
    ReceiverId,
    /// In a MAVLink log: a message without a position, or a position without a fix.
    NotPosition,
    /// In a MAVLink log: a message of a system that the site does not configure.
    UnknownSystem,
    /// The radio's checksum or the parity failed.
    Checksum,
    /// On 1090 MHz: a repeated frame with the same stamp.
    Copy,
    /// On 1090 MHz: a position that needs two frames, of which one was not received.
    Unplaced,
    /// On 1090 MHz: a position that the aircraft cannot have reached from its last one.
    Implausible,
}

/// A frame without a datagram, or the last of several that were assembled without success.
#[derive(Clone, Copy, Debug)]
pub(super) struct SkippedFrame {
    pub(super) reason: SkipReason,
    /// Number of frames from which it was assembled; 0 if not fragmented.
    pub(super) fragments: u32,
}

impl From<SkipReason> for SkippedFrame {
    fn from(reason: SkipReason) -> Self {
        Self { reason, fragments: 0 }
    }
}

impl fmt::Display for SkipReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::NotIp => "not IP",
            Self::NotUdp => "not UDP",
            Self::Fragment => "fragmented",
            Self::Truncated => "cut short by the capture",
            Self::Malformed => "malformed",
            Self::TooDeep => "nested too deeply",
            Self::LinkType => "of a link type that cannot be read",
            Self::UnknownInterface => "on an interface that the file does not describe",
            Self::NotRemoteId => "without Remote ID",
            Self::NotAdsb => "without ADS-B",
            Self::ReceiverId => "with a receiver's identity",
            Self::NotPosition => "without a position",
            Self::UnknownSystem => "of an unknown system",
            Self::Checksum => "with a failed checksum",
            Self::Copy => "repeated",
            Self::Unplaced => "with half a position",
            Self::Implausible => "with an implausible position",
        })
    }
}

/// Skipped frames by reason, in the order of [`SkipReason`]. `Display`: `3 not IP, 1 fragmented`, or `none`.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SkippedFrames(BTreeMap<SkipReason, u64>);

impl SkippedFrames {
    /// Frames skipped for `reason`.
    pub fn count(&self, reason: SkipReason) -> u64 {
        self.0.get(&reason).copied().unwrap_or(0)
    }

    /// Frames skipped for any reason.
    pub fn total(&self) -> u64 {
        self.0.values().sum()
    }

    /// The reasons that occurred, with their counts.
    pub fn iter(&self) -> impl Iterator<Item = (SkipReason, u64)> {
        self.0.iter().map(|(reason, count)| (*reason, *count))
    }

    pub(super) fn add(&mut self, reason: SkipReason) {
        *self.0.entry(reason).or_default() += 1;
    }

    /// Counts the frames without a datagram. Those counted as fragments before have been assembled since.
    pub(super) fn lost(&mut self, lost: &SkippedFrame) {
        self.joined(lost.fragments);
        *self.0.entry(lost.reason).or_default() += u64::from(lost.fragments.max(1));
    }

    /// Removes the fragments of a complete datagram from the count. The last fragment was not counted.
    pub(super) fn joined(&mut self, fragments: u32) {
        if let Some(count) = self.0.get_mut(&SkipReason::Fragment) {
            *count = count.saturating_sub(u64::from(fragments).saturating_sub(1));
            if *count == 0 {
                self.0.remove(&SkipReason::Fragment);
            }
        }
    }
}

impl fmt::Display for SkippedFrames {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return f.write_str("none");
        }
        for (place, (reason, count)) in self.iter().enumerate() {
            let comma = if place == 0 { "" } else { ", " };
            write!(f, "{comma}{count} {reason}")?;
        }
        Ok(())
    }
}
