//! Learned errors of the sensors, for the interfaces.

use fusion::learning::{LearntRadar, LearntType, LearntValue, VelocityErrors, VelocityVerdict};
use fusion::report::TransponderType;
use picture::text;

/// Number of independent samples below which a radar's learned errors are mostly those of its data sheet.
const TELLING_TRACKS: f64 = 8.0;

/// Use of a radar's velocities.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocityUse {
    /// Undecided: too few samples.
    Unknown,
    /// The velocities are used.
    Used,
    /// The velocities are ignored.
    Ignored,
}

fusion::interface_names!(VelocityUse { Unknown = "unknown", Used = "used", Ignored = "ignored" });

impl From<&VelocityVerdict> for VelocityUse {
    fn from(verdict: &VelocityVerdict) -> Self {
        match verdict {
            VelocityVerdict::Unknown => Self::Unknown,
            VelocityVerdict::Used(_) => Self::Used,
            VelocityVerdict::Ignored(_) => Self::Ignored,
        }
    }
}

/// Errors of the velocities, once they are known.
pub fn velocity_errors(verdict: &VelocityVerdict) -> Option<VelocityErrors> {
    match *verdict {
        VelocityVerdict::Unknown => None,
        VelocityVerdict::Used(errors) | VelocityVerdict::Ignored(errors) => Some(errors),
    }
}

/// Learned errors by name, each as a ratio to the error in the data sheet.
pub fn of_data_sheet(learnt: &LearntRadar) -> [(&'static str, LearntValue); 3] {
    let LearntRadar { range_m, azimuth, height_m, .. } = learnt;
    [("range", range_m.of_data_sheet), ("azimuth", azimuth.of_data_sheet), ("height", height_m.of_data_sheet)]
}

/// Formats the learned errors: "range 0.4 ± 0.1, azimuth 0.9 ± 0.2, height 0.8 ± 0.2 of its data sheet (31 samples);
/// velocities ignored: 9.1 m/s off".
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

/// Name of a transponder type: make and model, "?" if not transmitted.
pub fn type_name(kind: &TransponderType) -> String {
    let [manufacturer, model] = make_and_model(kind).map(|text| text.unwrap_or_else(|| "?".to_owned()));
    format!("{manufacturer} {model}")
}

/// Make and model of a transponder type, if transmitted.
pub fn make_and_model(kind: &TransponderType) -> [Option<String>; 2] {
    [kind.manufacturer, kind.model].map(|octets| Some(text(&octets?)?.into_owned()))
}

/// Formats the learned errors of a type: "white noise 0.02 ± 0.01 m over ground, 0.05 ± 0.01 m in height (1500 reports);
/// delay 0.10 ± 0.05 s, 0.08 s applied".
pub fn type_in_words(learnt: &LearntType) -> String {
    let LearntType { horizontal_m, vertical_m, reports, delay_s, applied_s } = learnt;
    format!(
        "white noise {:.2} ± {:.2} m over ground, {:.2} ± {:.2} m in height ({reports} reports); delay {:.2} ± {:.2} s, \
         {applied_s:.2} s applied",
        horizontal_m.value,
        horizontal_m.deviation,
        vertical_m.value,
        vertical_m.deviation,
        delay_s.value,
        delay_s.deviation
    )
}
