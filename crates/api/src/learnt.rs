//! Learnt errors of the sensors, for `/api/v1/sensors`.

use schemars::JsonSchema;
use serde::Serialize;

use fusion::learning::{LearntAxis, LearntRadar, LearntType, LearntValue};
use fusion::report::TransponderType;
use input::json::rounded;
use service::live::{VelocityUse, in_words, make_and_model, type_in_words, velocity_errors};

/// Errors of a radar as learnt by the operational profile.
#[derive(Serialize, JsonSchema)]
pub(super) struct Learnt {
    /// One-line summary.
    summary: String,
    range_m: LearntErrors,
    azimuth_deg: LearntErrors,
    height_m: LearntErrors,
    velocity: LearntVelocity,
}

/// Errors along one axis, in the unit of the axis.
#[derive(Serialize, JsonSchema)]
struct LearntErrors {
    /// Ratio of the total error (bias and noise) to that of the data sheet.
    of_data_sheet: LearntNumber,
    /// Standard deviation of the bias, averaged over straight flight and turns as flown.
    bias: LearntNumber,
    /// Correlation time of the bias, in seconds.
    correlation_s: LearntNumber,
    /// Ratio of the bias in turns to the bias in straight flight.
    turn_factor: LearntNumber,
    /// Standard deviation of the white noise.
    noise: LearntNumber,
    /// Effective number of independent samples of the bias; older samples have less weight.
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

/// Quality of a radar's velocities (I048/200).
#[derive(Serialize, JsonSchema)]
struct LearntVelocity {
    #[schemars(extend("enum" = VelocityUse::NAMES))]
    verdict: &'static str,
    /// Velocity error per axis, in metres per second, once it is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    error_m_s: Option<LearntNumber>,
}

/// Errors common to transponders of one make and model at this receiver; operational profile only.
#[derive(Serialize, JsonSchema)]
#[schemars(rename = "LearntTransponderType")]
pub(super) struct LearntTypeJson {
    /// I129/020, if it is sent.
    #[serde(skip_serializing_if = "Option::is_none")]
    manufacturer: Option<String>,
    /// I129/030, if it is sent.
    #[serde(skip_serializing_if = "Option::is_none")]
    model: Option<String>,
    /// One-line summary.
    summary: String,
    /// Number of reports from which the white noise is estimated.
    reports: u64,
    /// Standard deviation of the white noise per horizontal axis, in metres.
    horizontal_m: LearntNumber,
    /// Standard deviation of the white noise of the height, in metres.
    vertical_m: LearntNumber,
    delay_s: LearntDelay,
}

/// Delay of the times of reports, in seconds.
#[derive(Serialize, JsonSchema)]
struct LearntDelay {
    value: f64,
    /// Standard deviation, in seconds.
    #[schemars(range(min = 0))]
    deviation: f64,
    /// Part of the delay that is certain, by which reports are corrected, in seconds.
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
