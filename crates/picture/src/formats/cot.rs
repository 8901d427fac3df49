//! Encoding of a track as a Cursor on Target event, version 2.0 (`docs/OUTPUTS.md`), for TAK clients and servers.

use std::borrow::Cow;
use std::fmt::Write;

use jiff::SignedDuration;

use crate::remote_id_json;
use crate::xml::escape;
use crate::{PictureMaker, PictureTrack, TrackClass, serial_text, text};
use fusion::integrity::{Reason, State};
use fusion::time::Time;

/// Value for an unknown height, radius or error, in metres.
const UNKNOWN_M: f64 = 9_999_999.0;

/// Emitter category of the lightest aeroplanes (I021/020).
const LIGHT: u8 = 1;
/// Emitter category of the fastest aeroplanes (I021/020).
const FAST: u8 = 6;
/// Emitter category of rotorcraft (I021/020).
const ROTORCRAFT: u8 = 10;

/// Writer of events.
#[derive(Clone, Debug)]
pub struct CotWriter {
    /// Name of the site, the prefix of every event's uid.
    pub site: String,
    /// Time for which an event is valid after it was sent.
    pub stale: SignedDuration,
}

/// Values common to all events of a second.
#[derive(Clone, Copy, Debug)]
pub struct CotSecond {
    /// Time of transmission.
    pub due: Time,
    /// Whether the positions are predicted.
    pub is_predicted: bool,
    /// Whether the service or a sensor is degraded.
    pub is_degraded: bool,
}

impl CotWriter {
    /// The uid of a track's events.
    pub fn uid(&self, track: &PictureTrack, maker: &PictureMaker) -> String {
        format!("{}.{}", self.site, maker.track_id(track))
    }

    /// Event that removes the symbol of an ended track, with the uid of its events.
    pub fn delete(&self, uid: &str, due: Time) -> String {
        let (uid, stale) = (escape(uid), due + self.stale);
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <event version=\"2.0\" uid=\"{uid}.ended\" type=\"t-x-d-d\" how=\"m-g\" time=\"{due}\" start=\"{due}\" stale=\"{stale}\">\
             <point lat=\"0\" lon=\"0\" hae=\"{UNKNOWN_M:.1}\" ce=\"{UNKNOWN_M:.1}\" le=\"{UNKNOWN_M:.1}\"/>\
             <detail><link uid=\"{uid}\" type=\"none\" relation=\"none\"/><__forcedelete/></detail></event>\n"
        )
    }

    /// Event of a track with its XML declaration, on one line each; `None` if no event can represent its position.
    pub fn event(&self, track: &PictureTrack, maker: &PictureMaker, second: CotSecond) -> Option<String> {
        let (latitude, longitude) = (track.position.latitude_deg(), track.position.longitude_deg());
        if !((-90.0..=90.0).contains(&latitude) && (-180.0..=180.0).contains(&longitude)) {
            return None;
        }
        let id = maker.track_id(track);
        let is_doubted = is_doubted(track);
        let known = |metres: Option<f64>| metres.filter(|metres| metres.is_finite()).unwrap_or(UNKNOWN_M);
        let height_m = known(track.altitude_amsl_m.map(|_| track.position.height_m));
        let ce_m = known(track.motion.map(|motion| motion.deviation_h_m));
        let le_m = known(track.vertical_motion().map(|motion| motion.deviation_v_m));
        let mut event = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        // Writing to a String does not fail.
        let _ = write!(
            event,
            "<event version=\"2.0\" uid=\"{}\" type=\"{}\" how=\"{}\" time=\"{}\" start=\"{}\" stale=\"{}\">\
             <point lat=\"{latitude:.7}\" lon=\"{longitude:.7}\" hae=\"{height_m:.1}\" ce=\"{ce_m:.1}\" le=\"{le_m:.1}\"/>\
             <detail><contact callsign=\"{}\"/>",
            escape(&self.uid(track, maker)),
            kind(maker.class(track), track, is_doubted),
            how(track, second.is_predicted),
            second.due,
            track.time,
            second.due + self.stale,
            escape(&callsign(track, &id, is_doubted)),
        );
        // Both are needed: readers ignore a speed without a direction.
        let motion = track.motion.filter(|motion| motion.speed().is_finite());
        if let Some((course, motion)) = motion.and_then(|motion| Some((motion.track_deg?, motion))) {
            // A course rounded up to 360 is north.
            let course = (course * 10.0).round() / 10.0 % 360.0;
            let _ = write!(event, "<track course=\"{course:.1}\" speed=\"{:.2}\"/>", motion.speed());
        }
        let _ = writeln!(
            event,
            "<remarks>{}</remarks></detail></event>",
            escape(&remarks(track, maker.class(track), second))
        );
        Some(event)
    }
}

/// Whether the position or the identity of the track is in doubt.
fn is_doubted(track: &PictureTrack) -> bool {
    track.point.integrity.is_some_and(|known| known.state.is_flagged()) || !track.disputed.is_empty()
}

/// Event type. The service does not know friends and enemies: a track with an undoubted transponder is neutral, any other is
/// unknown. The table of types has no civil drone with rotors; readers know `M-H-Q` for one.
fn kind(class: TrackClass, track: &PictureTrack, is_doubted: bool) -> String {
    let part = track.point.source.transponder();
    let whose = if part.is_some() && !is_doubted { 'n' } else { 'u' };
    let what = match (class, part.and_then(|part| part.aircraft.emitter_category)) {
        (TrackClass::Drone, _) => "A-M-H-Q",
        (TrackClass::Crewed, Some(ROTORCRAFT)) => "A-C-H",
        (TrackClass::Crewed, Some(LIGHT..=FAST)) => "A-C-F",
        (TrackClass::Crewed, _) => "A-C",
        (TrackClass::Vehicle, _) => "G-E-V",
        (TrackClass::Other | TrackClass::Unknown, _) => "A",
    };
    format!("a-{whose}-{what}")
}

/// How the coordinates were obtained: predicted, fused, from the aircraft's GNSS receiver, or relayed from a radar.
fn how(track: &PictureTrack, is_predicted: bool) -> &'static str {
    let source = &track.point.source;
    match (source.radar(), source.transponder()) {
        _ if is_predicted => "m-p",
        _ if matches!(source, fusion::Source::Cameras) => "m-f",
        (Some(_), Some(_)) => "m-f",
        (None, Some(_)) => "m-g",
        (_, None) => "m-r",
    }
}

/// Name on the screen: the callsign, else the identity of its transponder, else the id of the track. A doubtful one is marked.
fn callsign(track: &PictureTrack, id: &str, is_doubted: bool) -> String {
    let part = track.point.source.transponder();
    let own = part.and_then(|part| text(&part.aircraft.callsign).map(Cow::into_owned));
    let name = own.or_else(|| Some(serial_text(part?.identity).trim().to_owned()));
    let name = name.filter(|name| !name.is_empty()).unwrap_or_else(|| id.to_owned());
    if is_doubted { format!("? {name}") } else { name }
}

/// Text about the track: doubts first, state of the service last.
fn remarks(track: &PictureTrack, class: TrackClass, second: CotSecond) -> String {
    let mut said: Vec<String> = Vec::new();
    let part = track.point.source.transponder();
    let declared = part.map(|part| part.aircraft.declared).unwrap_or_default();
    if declared.is_emergency() {
        said.push("EMERGENCY: declared by the aircraft.".to_owned());
    }
    if let Some(known) = track.point.integrity.filter(|known| known.state.is_flagged()) {
        let state = if known.state == State::Failed { "is wrong" } else { "is suspect" };
        let reasons: Vec<&str> = known.reasons.iter().map(Reason::name).collect();
        let reasons = if reasons.is_empty() { String::new() } else { format!(" ({})", reasons.join(", ")) };
        said.push(format!("DOUBTED: the transponder {state}{reasons}."));
    }
    if !track.disputed.is_empty() {
        said.push(format!(
            "DISPUTED: {} claims to be the same aircraft elsewhere.",
            track.disputed.join(", ")
        ));
    }
    if track.is_uncooperative {
        said.push("Without a transponder where one would be heard.".to_owned());
    }
    let source = &track.point.source;
    said.push(
        match (source.radar(), source.transponder()) {
            _ if matches!(source, fusion::Source::Cameras) => "Cameras alone.",
            (Some(_), Some(_)) => "Fused from radar and transponder.",
            (None, Some(_)) => "Transponder alone, not seen by radar.",
            (_, None) => "Radar alone.",
        }
        .to_owned(),
    );
    match class {
        TrackClass::Other => said.push("The radar holds it for something else than a drone.".to_owned()),
        TrackClass::Unknown => said.push("What it is is not known.".to_owned()),
        TrackClass::Drone | TrackClass::Crewed | TrackClass::Vehicle => {}
    }
    if track.is_coasting() {
        let last = track.motion.and_then(|motion| motion.last_measurement);
        said.push(match last {
            Some(last) => format!("Extrapolated: last measured at {last}."),
            None => "Extrapolated.".to_owned(),
        });
    }
    if second.is_predicted {
        said.push("Predicted position.".to_owned());
    }
    if let Some(motion) = track.motion {
        said.push(format!("95 % within {:.0} m.", motion.accuracy_h_m.ceil()));
    }
    if let Some(height) = declared.height {
        let above = if height.is_above_ground { "ground" } else { "take-off" };
        said.push(format!("{:.1} m above {above}, as declared.", 0.5 * f64::from(height.half_metres)));
    }
    let declarations = [
        ("Type", remote_id_json::ua_type(&declared).filter(|name| *name != remote_id_json::UA_TYPES[0])),
        ("Status", remote_id_json::status(&declared).filter(|name| *name != remote_id_json::STATUSES[0])),
    ];
    said.extend(declarations.into_iter().filter_map(|(what, name)| Some(format!("{what}: {}.", name?))));
    if let Some(id) = remote_id_json::operator_id(&declared) {
        said.push(format!("Operator: {id}."));
    }
    if let Some(operator) = &declared.operator {
        let [latitude, longitude] = remote_id_json::degrees(operator);
        said.push(format!("Operator at {latitude:.5}, {longitude:.5}."));
    }
    if track.altitude_amsl_m.is_none() {
        said.push("Height not known.".to_owned());
    }
    if second.is_degraded {
        said.push("The service reports that it is degraded.".to_owned());
    }
    said.join(" ")
}

#[cfg(test)]
mod tests;
