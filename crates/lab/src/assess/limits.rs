//! Statements that a recording does not permit, with reasons.

use super::scene::AssessmentScene;
use super::subject::{AssessedSubject, SubjectKind};
use super::types::Limit;

/// Statements that do not follow from the recording.
pub(super) fn limits(
    scene: &AssessmentScene<'_>,
    subjects: &[AssessedSubject<'_>],
    bearings: &[(&str, u64)],
) -> Vec<Limit> {
    let mut limits = Vec::new();
    let mut limit = |what: &str, why: &str| limits.push(Limit { what: what.to_owned(), why: why.to_owned() });
    if scene.is_truth() {
        limit(
            "Whether a false track is a fault",
            "the truth names the aircraft of the trial only: birds, vehicles and other aircraft count as false tracks.",
        );
        limit(
            "Errors above 150 m",
            "a point belongs to the nearest aircraft within 150 m. One further away counts as a false track, and as a missed update.",
        );
        limit(
            "Errors of the truth itself",
            "the figures contain them. Use a truth whose error is a tenth of the sensor's.",
        );
    } else {
        limit(
            "Accuracy",
            "without a truth, the reference is what transponders report. Radar figures contain the transponders' errors, and the \
            picture is made of the same reports: its figures show agreement, not accuracy.",
        );
        limit(
            "Errors of a radar alone",
            "a plot belongs to the nearest transponder within 150 m: plots of a bird or an aircraft without a transponder near it \
            count as differences.",
        );
        limit(
            "Detection of aircraft without a transponder",
            "they are in no reference. Detection figures hold for aircraft with a transponder, in sight of its receiver.",
        );
        limit(
            "False tracks, and classification",
            "a track without a transponder may be an aircraft, a bird, or clutter.",
        );
        limit(
            "Detection by the receivers of transponders",
            "a report that was not received leaves no trace; only the intervals between received reports are known.",
        );
        limit(
            "False positions of transponders",
            "a transponder that lies is its own reference. Flags of the engine are listed under Integrity.",
        );
    }
    if scene.aircraft == 0 {
        limit(
            "Any figure on aircraft",
            "no aircraft of the reference has a slot that counts: the first 10 s and the last 7.5 s do not, nor do holes over 5 s.",
        );
    } else if let Some(block_s) = scene.block_s() {
        limit(
            "The difference between aircraft",
            &format!(
                "fewer than 8 aircraft of the reference fly ({}), so the blocks are pieces of {block_s} s of each. The intervals \
                hold for these aircraft, not for others.",
                scene.aircraft
            ),
        );
    }
    for subject in subjects {
        if subject.kind != SubjectKind::Picture && subject.reports.is_empty() {
            limit(&format!("Anything about {}", subject.title), "the recording has no report of it.");
        } else if subject.kind != SubjectKind::Picture
            && subject.reports.iter().all(|report| report.received.is_none())
        {
            limit(&format!("Latency of {}", subject.title), "the file does not state times of reception.");
        }
        let has_height =
            |report: &super::recording::SensorReport| report.point.place.altitude_amsl_m.is_some();
        if subject.kind == SubjectKind::Radar
            && !subject.reports.is_empty()
            && !subject.reports.iter().any(has_height)
        {
            limit(&format!("Height errors of {}", subject.title), "it measures no height.");
        }
    }
    for (sensor, count) in bearings {
        limit(
            &format!("Detection and accuracy of the camera {sensor}"),
            &format!("a bearing is no position; its {count} bearings are used in the picture."),
        );
    }
    if scene.class_names().is_empty() {
        limit("Figures by type of aircraft", "the truth has no column `class`.");
    }
    limit(
        "Latency of the published picture in service",
        "a recording is processed without a clock. A live service measures it (utm_fusion_slot_lateness_seconds).",
    );
    limit(
        "Performance elsewhere",
        "the figures hold for the site, the weather, the aircraft and the flown area of this recording. Bins without \
        flights are missing.",
    );
    limits
}
