//! Texts of alerts: what is wrong, since when, and what it means, in one sentence.

use super::AlertDetails;
use super::details::ClosestPair;
use fusion::integrity::{Reason, State};
use fusion::time::Time;
use picture::conflicts::Conflict;
use site::areas::{Entry, Presence, Zone, ZoneKind};

/// Maximum number of aircraft or transponders that a text names.
const NAMED: usize = 5;

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
///
/// `name` names the transponder. `twin` names the track that radar sees in its place, if that track is in the picture.
pub(super) fn lying(name: &str, twin: Option<&str>, details: &AlertDetails, since: Time) -> String {
    let AlertDetails::Integrity { twin_id, state, reasons, offset_m, .. } = details else {
        return String::new();
    };
    let why: Vec<String> = reasons.iter().map(|reason| clause(reason, *offset_m)).collect();
    let why = if why.is_empty() { "an operator distrusts it".to_owned() } else { listed(&why) };
    let twin = twin_id.as_ref().map(|_| twin.unwrap_or("another track"));
    let (is, then) = match (state, twin) {
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
    format!("transponder {name} {is} since {}, because {why}; {then}", at(since))
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
pub(super) fn silent(name: &str, heard: Time) -> String {
    format!(
        "transponder {name} has been silent since {}, and radar still sees the aircraft: its track rests on radar alone",
        at(heard)
    )
}

/// Text for a transponder whose heights differ from those of radars by this offset, with this standard deviation, metres.
pub(super) fn contradicted_height(name: &str, (offset_m, deviation_m): (f64, f64), since: Time) -> String {
    let side = if offset_m < 0.0 { "below" } else { "above" };
    format!(
        "transponder {name} has reported heights {:.0} m (±{:.0} m) {side} those of radar since {}: their reference is \
         unknown, so its height is not to be relied on within that",
        offset_m.abs(),
        deviation_m.ceil(),
        at(since)
    )
}

/// Text for a transponder whose heights agree with those of radars again.
pub(super) fn was_contradicted(name: &str, offset_m: f64) -> String {
    let side = if offset_m < 0.0 { "below" } else { "above" };
    format!("transponder {name} reported heights {:.0} m {side} those of radar", offset_m.abs())
}

/// Text for many transponders that fell silent at once.
pub(super) fn jamming(names: &[String], since: Time) -> String {
    format!(
        "{} transponders fell silent together from {} on and may be jammed ({}): there, drones that radar does not see are \
         not shown",
        names.len(),
        at(since),
        first_few(names).join(", ")
    )
}

/// Text for many transponders that fell silent at once and are not missed any more.
pub(super) fn were_jammed(names: &[String], since: Time) -> String {
    let named = first_few(names).join(", ");
    format!("{} transponders fell silent together from {} on ({named})", names.len(), at(since))
}

/// Text for a drone without a transponder.
pub(super) fn uncooperative(name: &str, since: Time) -> String {
    format!(
        "{name} has flown since {} without a transponder where one would be heard: its operator is not known",
        at(since)
    )
}

/// Text for an aircraft that declares an emergency.
pub(super) fn emergency(name: &str, since: Time) -> String {
    format!("{name} has declared an emergency since {}", at(since))
}

/// Text for a drone without a transponder that was identified: names of its track, if it is in the picture, and of its
/// transponder.
pub(super) fn resolved(name: Option<&str>, transponder: Option<&str>) -> String {
    let name = name.unwrap_or("the drone");
    match transponder {
        Some(transponder) => format!("{name} is resolved: it flies with transponder {transponder}"),
        None => format!("{name} is resolved: it is where a transponder that is suspect should be"),
    }
}

/// Text for a pair in conflict, true at the time of its figures. `closest` is the pair's closest approach so far.
pub(super) fn approaching(conflict: &Conflict, closest: &ClosestPair) -> String {
    let ([a, b], found, volume) = (&conflict.names, &conflict.found, &conflict.volume);
    let now = &found.relative;
    let height_m = now.vertical.map(|vertical| vertical.height_m);
    let apart = distances(now.position.norm(), height_m);
    if !conflict.is_seen() {
        return format!(
            "{a} and {b} were {apart} ({volume}) at {}; one of them is missing since",
            at(conflict.seen)
        );
    }
    let approach = &found.approach;
    let percent = 100.0 * found.probability;
    if conflict.is_entered() {
        format!("{a} and {b} are too close ({volume}): {apart}")
    } else if approach.t_cpa_s > 0.0 && found.probability > 0.0 {
        let then = distances(approach.horizontal_m(), approach.vertical.map(|(height_m, _)| height_m));
        format!(
            "{a} and {b} come close in {:.0} s ({volume}): then {then}, probability {percent:.0} %",
            approach.t_cpa_s
        )
    } else if found.exit_s.is_some() {
        // Aircraft that are nearest over ground now may still come to the same height.
        format!(
            "{a} and {b} come close in {:.0} s ({volume}): now {apart}, probability {percent:.0} %",
            found.entry_s
        )
    } else {
        format!("{}; now {apart}", passed(&conflict.names, volume, closest))
    }
}

/// Text for a pair that was in conflict: its closest approach.
pub(super) fn passed([a, b]: &[String; 2], volume: &str, closest: &ClosestPair) -> String {
    let apart = distances(closest.horizontal_m, closest.vertical_m);
    format!("{a} and {b} were closest at {} ({volume}): {apart}", at(closest.at))
}

/// Text for several aircraft in conflict with one another; `pair` is the text of the worst pair.
pub(super) fn cluster(names: &[String], pair: &str) -> String {
    format!("{} are near one another: {pair}", listed(&first_few(names)))
}

/// The first names, and the number of the others.
fn first_few(names: &[String]) -> Vec<String> {
    let mut few: Vec<String> = names.iter().take(NAMED).cloned().collect();
    if names.len() > NAMED {
        few.push(format!("{} more", names.len() - NAMED));
    }
    few
}

fn distances(over_ground_m: f64, height_m: Option<f64>) -> String {
    match height_m {
        Some(height_m) => format!("{over_ground_m:.0} m apart and {:.0} m in height", height_m.abs()),
        None => format!("{over_ground_m:.0} m apart, their heights not known"),
    }
}

/// Formats a time as `10:05:05 UTC`.
pub(super) fn at(time: Time) -> String {
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
