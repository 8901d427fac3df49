//! Bearings from a camera's target reports (CAT015).

use asterix::cat015::{MessageKind, Record, TargetTaxonomy};
use nalgebra::{Rotation3, Vector3};

use super::normaliser::Normaliser;
use super::refusal::Refusal;
use fusion::frames::{AtRadar, Geodetic, TangentPlane};
use fusion::report::{Bearing, CameraTrackKey};
use fusion::time::Time;
use fusion::{Enu, SensorIndex};

/// Position and orientation of a camera.
#[derive(Clone, Debug)]
pub(super) struct CameraSite {
    pub(super) index: SensorIndex,
    /// Rotation from the camera's east, north and up to the site's.
    turn: Rotation3<f64>,
    bearing_correction_deg: f64,
}

impl CameraSite {
    pub(super) fn new(
        index: SensorIndex,
        place: Geodetic,
        bearing_correction_deg: f64,
        site: &TangentPlane,
    ) -> Self {
        Self { index, turn: TangentPlane::<AtRadar>::at(place).turn_to(site), bearing_correction_deg }
    }

    /// Bearing of a record.
    pub(super) fn bearing(
        &self,
        record: &Record,
        site: &Normaliser,
        received: Time,
    ) -> Result<Bearing, Refusal> {
        if record.message_type.is_some_and(|kind| kind.kind() == MessageKind::TrackEnd) {
            return Err(Refusal::NotUsed);
        }
        let time_of_day = record.time_of_day.ok_or(Refusal::NoTime)?;
        match record.target_report.as_ref().map(|report| report.taxonomy()) {
            Some(TargetTaxonomy::Simulated) => return Err(Refusal::Simulated),
            Some(TargetTaxonomy::Reference | TargetTaxonomy::Synthetic) => return Err(Refusal::TestTarget),
            Some(TargetTaxonomy::Actual) | None => {}
        }
        if record.status.as_ref().is_some_and(|status| status.is_position_coasted()) {
            return Err(Refusal::NoDetection);
        }
        let number = record.number.ok_or(Refusal::NoTrackNumber)?.number();
        let azimuth = record.azimuth.as_ref().and_then(|known| known.azimuth).ok_or(Refusal::NoPosition)?;
        let elevation = record.elevation.as_ref().and_then(|known| known.elevation);
        let azimuth = (azimuth.degrees() + self.bearing_correction_deg).to_radians();
        let upward = elevation.map_or(0.0, |elevation| elevation.degrees().to_radians());
        let level = upward.cos();
        let there = self.turn * Vector3::new(azimuth.sin() * level, azimuth.cos() * level, upward.sin());
        Ok(Bearing {
            track: CameraTrackKey { sensor: self.index, number },
            time: site.time(time_of_day, received)?,
            azimuth: there.x.atan2(there.y),
            elevation: elevation.map(|_| there.z.atan2(there.xy().norm())),
        })
    }
}

/// Position of a camera in the site's frame.
pub fn camera_place(latitude_deg: f64, longitude_deg: f64, height_amsl_m: f64, site: &Normaliser) -> Enu {
    let height_m = height_amsl_m + site.undulation_m();
    site.frame().from_geodetic(Geodetic::from_degrees(latitude_deg, longitude_deg, height_m))
}
