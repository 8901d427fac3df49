//! Residual misalignment of a radar after correction by its own registration: the check that follows a boresighting
//! (Fasano et al. 2010, figures 12 and 13).

use std::collections::BTreeMap;

use super::types::{ErrorSample, Evaluation, OutputPoint};
use fusion::frames::{AtRadar, Geodetic, TangentPlane};
use fusion::registration::{Correction, Misalignment};
use fusion::{Enu, SensorIndex};
use input::capture::{ReadError, Reception};
use input::pipeline::Pipeline;
use site::areas::Masks;
use site::config::{Config, Profile, Registration, SensorKind};

/// Residuals of a radar's plots of drones.
#[derive(Clone, Debug, PartialEq)]
pub struct RadarResiduals {
    /// Id of the radar.
    pub radar: String,
    /// Number of radar tracks in its registration; older ones count in part.
    pub tracks: f64,
    /// Residuals, in the order of the plots.
    pub plots: Vec<PlotResidual>,
}

/// Residual of a plot with a measured height, relative to the drone's true position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlotResidual {
    /// True azimuth from the radar, degrees clockwise from north, 0 to 360.
    pub azimuth_deg: f64,
    /// True elevation from the radar, degrees.
    pub elevation_deg: f64,
    /// Residual of the original plot.
    pub before: AngularResidual,
    /// Residual of the corrected plot.
    pub after: AngularResidual,
}

/// Residual: measured minus true.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AngularResidual {
    /// Azimuth, degrees.
    pub azimuth_deg: f64,
    /// Elevation, degrees.
    pub elevation_deg: f64,
    /// Angle between the two lines of sight, degrees.
    pub angle_deg: f64,
}

/// Estimates the radars' misalignments at the end of a recording, with the operational profile. Radars whose
/// registration is `off` are estimated too.
///
/// # Errors
/// The capture cannot be read to its end.
pub fn misalignments(
    receptions: impl Iterator<Item = Result<Reception, ReadError>>,
    config: &Config,
    masks: Masks,
) -> Result<BTreeMap<String, Misalignment>, ReadError> {
    let mut config = config.clone();
    // Only a change to the reference profile can fail.
    config.fusion = config.fusion.clone().with_profile(Profile::Operational).unwrap_or(config.fusion);
    for sensor in &mut config.sensors {
        if let SensorKind::Radar(radar) = &mut sensor.kind
            && radar.registration == Registration::Off
        {
            radar.registration = Registration::Propose;
        }
    }
    let mut pipeline = Pipeline::new(&config, masks);
    for reception in receptions {
        pipeline.receive(&reception?);
        // The published points are not needed.
        pipeline.emissions().for_each(drop);
    }
    pipeline.finish();
    let id = |index: SensorIndex| config.sensors.get(usize::from(index.0)).map(|sensor| sensor.id.clone());
    let known = pipeline.engine().registered();
    Ok(known.filter_map(|(index, registered)| Some((id(index)?, registered.estimate))).collect())
}

/// Residuals of each radar whose misalignment is known; `plots` are those that were scored.
pub fn residuals(
    evaluation: &Evaluation,
    plots: &[OutputPoint],
    misalignments: &BTreeMap<String, Misalignment>,
    config: &Config,
) -> Vec<RadarResiduals> {
    let key = |time: fusion::Time, number: u32, latitude_deg: f64| (time, number, latitude_deg.to_bits());
    let sensors: BTreeMap<_, &str> = plots
        .iter()
        .filter_map(|plot| {
            Some((key(plot.time, plot.number, plot.place.latitude_deg), plot.sensor.as_deref()?))
        })
        .collect();
    let samples = evaluation.radar.iter().flat_map(|scored| &scored.samples);
    let sensor_of = |sample: &ErrorSample| {
        sensors.get(&key(sample.time, sample.number, sample.place.latitude_deg)).copied()
    };
    config
        .radars()
        .filter_map(|(sensor, radar)| {
            let estimate = misalignments.get(&sensor.id)?;
            let frame = TangentPlane::<AtRadar>::at(Geodetic::from_degrees(
                radar.latitude_deg,
                radar.longitude_deg,
                radar.height_amsl_m,
            ));
            let correction = Correction::of(estimate);
            let own = samples.clone().filter(|sample| sensor_of(sample) == Some(sensor.id.as_str()));
            let plots = own.filter_map(|sample| residual(sample, &frame, &correction)).collect();
            Some(RadarResiduals { radar: sensor.id.clone(), tracks: estimate.samples, plots })
        })
        .collect()
}

/// Residual of a plot; `None` for a plot of no drone, or without a height.
fn residual(
    sample: &ErrorSample,
    frame: &TangentPlane<AtRadar>,
    correction: &Correction,
) -> Option<PlotResidual> {
    let (error, up_m) = (sample.error?, sample.error?.up_m?);
    // The height of the geoid is taken as equal at the drone and at the radar.
    let place = sample.place;
    let plot = frame.from_geodetic(Geodetic::from_degrees(
        place.latitude_deg,
        place.longitude_deg,
        place.altitude_amsl_m?,
    ));
    let truth = Enu::new(plot.east() - error.east_m, plot.north() - error.north_m, plot.up() - up_m);
    let (azimuth_deg, elevation_deg) = sight(truth);
    let residual = |plot: Enu<AtRadar>| {
        let (azimuth, elevation) = sight(plot);
        AngularResidual {
            azimuth_deg: (azimuth - azimuth_deg + 180.0).rem_euclid(360.0) - 180.0,
            elevation_deg: elevation - elevation_deg,
            angle_deg: plot.0.angle(&truth.0).to_degrees(),
        }
    };
    Some(PlotResidual {
        azimuth_deg,
        elevation_deg,
        before: residual(plot),
        after: residual(correction.apply(plot)),
    })
}

/// Azimuth, 0 to 360, and elevation, degrees.
fn sight(place: Enu<AtRadar>) -> (f64, f64) {
    let azimuth = place.east().atan2(place.north()).to_degrees().rem_euclid(360.0);
    (azimuth, place.up().atan2(place.east().hypot(place.north())).to_degrees())
}
