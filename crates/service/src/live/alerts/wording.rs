//! Texts of alerts: what is wrong, since when, and what it means, in one sentence.

use super::AlertDetails;
use fusion::Identity;
use fusion::conflicts::Level;
use fusion::integrity::{Reason, State};
use fusion::time::Time;
use picture::conflicts::Conflict;
use picture::{PictureTrack, serial_text};
use site::areas::{Entry, Presence, Zone, ZoneKind};

/// Maximum number of transponders that a text names.
const NAMED: usize = 5;

/// `fused track 60000 (U-60000), serial 1596F3A2`: the track as on the screen, with the serial number for asking the owner.
pub(super) fn described(track: &PictureTrack, id: &str) -> String {
    let serial =
        track.point.source.transponder().map(|part| format!(", serial {}", serial_text(part.identity)));
    format!("{} track {} ({id}){}", track.source_name(), track.point.number, serial.unwrap_or_default())
}

/// Text for a track inside an area; `named` is the track.
pub(super) fn inside(named: &str, presence: &Presence<'_>) -> String {
    let height = if presence.is_height_unknown { "; its height is not known" } else { "" };
    format!("{named} is inside {}{}{height}", presence.label, holding(presence.zone))
}

/// Text for a track about to enter an area; `named` is the track.
pub(super) fn entering(named: &str, entry: &Entry<'_>) -> String {
    let Entry { label, zone, time_s, earliest_s } = entry;
    let (seconds, earliest) = (time_s.map(f64::round), earliest_s.round());
    let when = match seconds {
        // Predicted to be inside; the published picture is older and does not show it there yet.
        Some(_) if *time_s == Some(0.0) => "is by now inside".to_owned(),
        Some(0.0) => "is entering".to_owned(),
        Some(seconds) if earliest < seconds => {
            format!("is {seconds} s ({earliest} s at the earliest) away from entering")
        }
        Some(seconds) => format!("is {seconds} s away from entering"),
        None => format!("is {earliest} s away from entering, unless it passes by,"),
    };
    format!("{named} {when} {label}{}", holding(zone))
}

/// Restriction of a zone, as the end of a sentence.
fn holding(zone: &Zone) -> &'static str {
    match zone.kind {
        Some(ZoneKind::Prohibited) => ", where flights are prohibited",
        Some(ZoneKind::Authorisation) => ", where flights need an authorisation",
        Some(ZoneKind::Conditional) => ", where conditions hold",
        Some(ZoneKind::USpace) => ", which is U-space airspace",
        Some(ZoneKind::NoRestriction) | None => "",
    }
}

/// Text for a suspect or failed transponder.
pub(super) fn lying(details: &AlertDetails, since: Time) -> String {
    let AlertDetails::Integrity { identity, track_id, twin_id, state, reasons, offset_m } = details else {
        return String::new();
    };
    let why: Vec<String> = reasons.iter().map(|reason| clause(reason, *offset_m)).collect();
    let why = if why.is_empty() { "an operator distrusts it".to_owned() } else { listed(&why) };
    let (is, then) = match (state, twin_id) {
        (State::Failed, Some(twin)) => {
            ("is not to be trusted", format!("do not use its position: the aircraft is most likely {twin}"))
        }
        (State::Failed, None) => {
            ("is not to be trusted", "do not use its position: the aircraft may be elsewhere".to_owned())
        }
        (_, Some(twin)) => {
            ("is suspect", format!("its position may be false: look at {twin}, which may be the aircraft"))
        }
        (_, None) => {
            ("is suspect", "its position may be false: do not rely on it until that is cleared up".to_owned())
        }
    };
    format!("{} {is} since {}, because {why}; {then}", who(*identity, track_id.as_deref()), at(since))
}

/// Text of a reason, as the end of "because …".
fn clause(reason: Reason, offset_m: Option<f64>) -> String {
    match (reason, offset_m) {
        (Reason::Radar, Some(metres)) => {
            return format!("radar sees the aircraft {metres:.0} m from where it says it is");
        }
        (Reason::Radar, None) => "radar sees the aircraft elsewhere",
        (Reason::Jump, _) => "its position jumped",
        (Reason::Frozen, _) => "its position stands still to the last digit",
        (Reason::Replay, _) => "it repeats earlier reports",
        (Reason::Duplicate, _) => "two transmitters send under its serial number",
        (Reason::Swapped, _) => "it changed places with another transponder",
        (Reason::Velocity, _) => "the velocity that it states is not that of its positions",
        (Reason::Time, _) => "its time stamps are off",
    }
    .to_owned()
}

/// Text for a silent transponder whose aircraft radar still sees.
pub(super) fn silent(identity: Identity, track_id: Option<&str>, heard: Time) -> String {
    format!(
        "{} has been silent since {}, and radar still sees the aircraft: its track rests on radar alone",
        who(identity, track_id),
        at(heard)
    )
}

/// Text for a transponder whose heights differ from those of radars by this offset, with this standard deviation, metres.
pub(super) fn contradicted_height(
    identity: Identity,
    track_id: Option<&str>,
    (offset_m, deviation_m): (f64, f64),
    since: Time,
) -> String {
    let side = if offset_m < 0.0 { "below" } else { "above" };
    format!(
        "{} has reported heights {:.0} m (±{:.0} m) {side} those of radar since {}: their reference is unknown, so its height \
         is not to be relied on within that",
        who(identity, track_id),
        offset_m.abs(),
        deviation_m.ceil(),
        at(since)
    )
}

/// Text for many transponders that fell silent at once.
pub(super) fn jamming(identities: &[Identity], since: Time) -> String {
    let mut named: Vec<String> =
        identities.iter().take(NAMED).map(|&identity| serial_text(identity)).collect();
    if identities.len() > NAMED {
        named.push(format!("{} more", identities.len() - NAMED));
    }
    format!(
        "{} transponders fell silent together from {} on and may be jammed ({}): there, drones that radar does not see are \
         not shown",
        identities.len(),
        at(since),
        named.join(", ")
    )
}

/// Text for a drone without a transponder.
pub(super) fn uncooperative(track: &PictureTrack, id: &str, since: Time) -> String {
    format!(
        "{} has flown since {} without a transponder where one would be heard: nobody knows whose it is",
        described(track, id),
        at(since)
    )
}

/// Text for an aircraft that declares an emergency.
pub(super) fn emergency(track: &PictureTrack, id: &str, since: Time) -> String {
    format!("{} has declared an emergency since {}", described(track, id), at(since))
}

/// Text for a drone without a transponder that was identified.
pub(super) fn resolved(id: &str, identity: Option<Identity>) -> String {
    match identity {
        Some(identity) => format!("{id} is resolved: it flies with {}", who(identity, None)),
        None => format!("{id} is resolved: it is where a transponder that is suspect should be"),
    }
}

/// Text for a conflict.
pub(super) fn approaching(conflict: &Conflict) -> String {
    let ([a, b], found) = (&conflict.tracks, &conflict.found);
    let metres = |over_ground_m: f64, height_m: Option<f64>| match height_m {
        Some(height_m) => format!("{over_ground_m:.0} m apart and {:.0} m in height", height_m.abs()),
        None => format!("{over_ground_m:.0} m apart, their heights not known"),
    };
    if conflict.level() == Some(Level::Violation) {
        let now = &found.relative;
        let apart = metres(now.position.norm(), now.vertical.map(|vertical| vertical.height_m));
        return format!("{a} and {b} are too close ({}): {apart}", conflict.volume);
    }
    let approach = &found.approach;
    let apart = metres(approach.horizontal_m(), approach.vertical.map(|(height_m, _)| height_m));
    // Aircraft that are nearest over ground now may still come to the same height.
    let (when_s, then) =
        if approach.t_cpa_s > 0.0 { (approach.t_cpa_s, "then") } else { (found.entry_s, "now") };
    format!(
        "{a} and {b} come close in {when_s:.0} s ({}): {then} {apart}, probability {:.0} %",
        conflict.volume,
        100.0 * found.probability
    )
}

fn who(identity: Identity, track_id: Option<&str>) -> String {
    let track = track_id.map_or_else(String::new, |id| format!(" ({id})"));
    format!("transponder {}{track}", serial_text(identity))
}

/// Formats a time as `10:05:05 UTC`.
fn at(time: Time) -> String {
    let second = time.since_midnight() / fusion::time::SECOND;
    format!("{:02}:{:02}:{:02} UTC", second / 3600, second / 60 % 60, second % 60)
}

/// Formats a list as `a, b and c`.
fn listed(parts: &[String]) -> String {
    match parts {
        [] => String::new(),
        [one] => one.clone(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}
