//! What was learnt of the sensors' errors, as `/api/v1/sensors` has it.

use schemars::JsonSchema;
use serde::Serialize;

use crate::json::rounded;
use crate::live::{VelocityUse, in_words, make_and_model, type_in_words, velocity_errors};
use fusion::learning::{LearntAxis, LearntRadar, LearntType, LearntValue};
use fusion::report::TransponderType;

/// A radar's errors as they have shown themselves; operational profile only, where they are learnt.
#[derive(Serialize, JsonSchema)]
pub(super) struct Learnt {
    /// In a line.
    summary: String,
    range_m: LearntErrors,
    azimuth_deg: LearntErrors,
    height_m: LearntErrors,
    velocity: LearntVelocity,
}

/// The errors of one axis, in its unit.
#[derive(Serialize, JsonSchema)]
struct LearntErrors {
    /// Bias and noise together over those of the data sheet.
    of_data_sheet: LearntNumber,
    /// One standard deviation of the bias, turns included as often as they are flown.
    bias: LearntNumber,
    /// Its correlation time.
    correlation_s: LearntNumber,
    /// How many times as large it is in turns.
    turn_factor: LearntNumber,
    /// One standard deviation of the white noise.
    noise: LearntNumber,
    /// Independent samples of the bias that this rests upon; older ones count in part.
    #[schemars(range(min = 0))]
    samples: f64,
}

#[derive(Serialize, JsonSchema)]
struct LearntNumber {
    #[schemars(range(min = 0))]
    value: f64,
    /// Standard deviation.
    #[schemars(range(min = 0))]
    deviation: f64,
}

/// Whether a radar's velocities (I048/200) are of use.
#[derive(Serialize, JsonSchema)]
struct LearntVelocity {
    #[schemars(extend("enum" = VelocityUse::NAMES))]
    verdict: &'static str,
    /// How far they are off, each axis, once that is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    error_m_s: Option<LearntNumber>,
}

/// What transponders of one make and model that this receiver hears have in common; operational profile only.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "LearntTransponderType")]
pub(super) struct LearntTypeJson {
    /// I129/020, where it is sent.
    #[serde(skip_serializing_if = "Option::is_none")]
    manufacturer: Option<String>,
    /// I129/030, where it is sent.
    #[serde(skip_serializing_if = "Option::is_none")]
    model: Option<String>,
    /// In a line.
    summary: String,
    /// Reports that the white noise rests upon.
    reports: u64,
    /// One standard deviation of the white noise, each axis over ground.
    horizontal_m: LearntNumber,
    /// One standard deviation of the white noise in height.
    vertical_m: LearntNumber,
    delay_s: LearntDelay,
}

/// How late the times of reports are.
#[derive(Serialize, JsonSchema)]
struct LearntDelay {
    value: f64,
    /// Standard deviation.
    #[schemars(range(min = 0))]
    deviation: f64,
    /// As much of it as is evident: what reports are moved by.
    #[schemars(range(min = 0))]
    applied: f64,
}

impl From<&(TransponderType, LearntType)> for LearntTypeJson {
    fn from((kind, learnt): &(TransponderType, LearntType)) -> Self {
        let [manufacturer, model] = make_and_model(kind);
        let number = |value: &LearntValue| LearntNumber {
            value: rounded(value.value, 3),
            deviation: rounded(value.deviation, 3),
        };
        Self {
            manufacturer,
            model,
            summary: type_in_words(learnt),
            reports: learnt.reports,
            horizontal_m: number(&learnt.horizontal_m),
            vertical_m: number(&learnt.vertical_m),
            delay_s: LearntDelay {
                value: rounded(learnt.delay_s.value, 3),
                deviation: rounded(learnt.delay_s.deviation, 3),
                applied: rounded(learnt.applied_s, 3),
            },
        }
    }
}

impl From<&LearntRadar> for Learnt {
    fn from(learnt: &LearntRadar) -> Self {
        let errors = |axis: &LearntAxis, unit: f64| {
            let number = |value: &LearntValue, unit: f64| LearntNumber {
                value: rounded(value.value * unit, 4),
                deviation: rounded(value.deviation * unit, 4),
            };
            LearntErrors {
                of_data_sheet: number(&axis.of_data_sheet, 1.0),
                bias: number(&axis.bias, unit),
                correlation_s: number(&axis.correlation_s, 1.0),
                turn_factor: number(&axis.turn_factor, 1.0),
                noise: number(&axis.noise, unit),
                samples: rounded(axis.tracks, 1),
            }
        };
        let error_m_s = velocity_errors(&learnt.velocity).map(|errors| LearntNumber {
            value: rounded(errors.sigma_m_s, 2),
            deviation: rounded(errors.deviation_m_s, 2),
        });
        Self {
            summary: in_words(learnt),
            range_m: errors(&learnt.range_m, 1.0),
            azimuth_deg: errors(&learnt.azimuth, 1_f64.to_degrees()),
            height_m: errors(&learnt.height_m, 1.0),
            velocity: LearntVelocity { verdict: VelocityUse::from(&learnt.velocity).name(), error_m_s },
        }
    }
}
