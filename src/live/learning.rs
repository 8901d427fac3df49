//! What was learnt of the radars' errors, for the interfaces.

use fusion::learning::{LearntRadar, LearntValue, VelocityErrors, VelocityVerdict};

/// Before so many independent samples a radar's errors are those of its data sheet, more or less.
const TELLING_TRACKS: f64 = 8.0;

/// The verdict's name.
pub fn verdict_name(verdict: &VelocityVerdict) -> &'static str {
    match verdict {
        VelocityVerdict::Unknown => "unknown",
        VelocityVerdict::Used(_) => "used",
        VelocityVerdict::Ignored(_) => "ignored",
    }
}

/// How wrong the velocities are, once that is known.
pub fn velocity_errors(verdict: &VelocityVerdict) -> Option<VelocityErrors> {
    match *verdict {
        VelocityVerdict::Unknown => None,
        VelocityVerdict::Used(errors) | VelocityVerdict::Ignored(errors) => Some(errors),
    }
}

/// The errors of each axis over those of the data sheet, by name.
pub fn of_data_sheet(learnt: &LearntRadar) -> [(&'static str, LearntValue); 3] {
    let LearntRadar { range_m, azimuth, height_m, .. } = learnt;
    [("range", range_m.of_data_sheet), ("azimuth", azimuth.of_data_sheet), ("height", height_m.of_data_sheet)]
}

/// In a line: "range 0.4 ± 0.1, azimuth 0.9 ± 0.2, height 0.8 ± 0.2 of its data sheet (31 samples); velocities ignored: 9.1 m/s
/// off".
pub fn in_words(learnt: &LearntRadar) -> String {
    let tracks = learnt.azimuth.tracks;
    let parts = of_data_sheet(learnt)
        .map(|(name, LearntValue { value, deviation })| format!("{name} {value:.2} ± {deviation:.2}"));
    let few = if tracks < TELLING_TRACKS { ", too few to tell yet" } else { "" };
    let velocities = match learnt.velocity {
        VelocityVerdict::Unknown => String::new(),
        VelocityVerdict::Used(errors) => format!("; velocities used: {:.1} m/s off", errors.sigma_m_s),
        VelocityVerdict::Ignored(errors) => format!("; velocities ignored: {:.1} m/s off", errors.sigma_m_s),
    };
    format!("{} of its data sheet ({tracks:.0} samples{few}){velocities}", parts.join(", "))
}
