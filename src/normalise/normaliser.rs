//! Decoded records to reports: which sensor, when, where, who; and why not.

use std::collections::BTreeMap;

use asterix::cat048::{self, DetectionType};
use asterix::cat129::{GnssAccuracy, VerticalVelocity};
use asterix::{DataSource, TimeOfDay, cat034, cat129};

use jiff::SignedDuration;
use nalgebra::{Rotation3, Vector2};

use super::clock::nearest_day;
use super::polar::RadarSite;
use super::service::Service;
use crate::areas::Masks;
use crate::config::{Classification, Config, Radar, SensorKind};
use fusion::frames::{Geodetic, TangentPlane};
use fusion::report::UasItems;
use fusion::time::Time;
use fusion::{Enu, Fix, Identity, Plot, RadarTrackKey, SensorIndex};

/// Why a record gives no report.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Refusal {
    /// No data source identifier (I048/010, I129/010).
    NoDataSource,
    /// No sensor of the configuration has this category, SAC and SIC.
    UnknownSource(DataSource),
    /// No time of day (I048/140, I129/070).
    NoTime,
    /// No position (I048/040, I129/080).
    NoPosition,
    /// No track number (I048/161).
    NoTrackNumber,
    /// The radar track is coasted: TYP = 0 in I048/020.
    NoDetection,
    /// A simulated target: SIM in I048/020.
    Simulated,
    /// A test target: TST in I048/020.
    TestTarget,
    /// Slant range 0.
    ZeroRange,
    /// No serial number, or a blank one (I129/040).
    NoIdentity,
    /// No height above mean sea level (I129/090).
    NoHeight,
    /// Latitude or longitude beyond the poles or the antimeridian (I129/080).
    PositionOutOfRange,
    /// Time of day above 86400 s.
    TimeOutOfRange,
    /// Inside a mask of `[[areas]]`.
    Masked,
    /// Ahead of its reception by more than `max_future_s`.
    Future,
    /// Older than the window.
    Late,
    /// Another sender speaks for this sensor: two have one SAC/SIC.
    OtherSender,
}

impl Refusal {
    /// A short name that stays the same over releases, for counters.
    pub const fn name(self) -> &'static str {
        match self {
            Self::NoDataSource => "no_data_source",
            Self::UnknownSource(_) => "unknown_source",
            Self::NoTime => "no_time",
            Self::NoPosition => "no_position",
            Self::NoTrackNumber => "no_track_number",
            Self::NoDetection => "no_detection",
            Self::Simulated => "simulated",
            Self::TestTarget => "test_target",
            Self::ZeroRange => "zero_range",
            Self::NoIdentity => "no_identity",
            Self::NoHeight => "no_height",
            Self::PositionOutOfRange => "position_out_of_range",
            Self::TimeOutOfRange => "time_out_of_range",
            Self::Masked => "masked",
            Self::Future => "future",
            Self::Late => "late",
            Self::OtherSender => "other_sender",
        }
    }
}

/// A record that gives no report: from which sensor, where that is known, and why.
pub type Refused = (Option<SensorIndex>, Refusal);

/// The site's sensors and its one frame.
#[derive(Clone, Debug)]
pub struct Normaliser {
    frame: TangentPlane,
    undulation_m: f64,
    max_future: SignedDuration,
    masks: Masks,
    radars: BTreeMap<DataSource, RadarSensor>,
    transponders: BTreeMap<DataSource, SensorIndex>,
}

#[derive(Clone, Debug)]
struct RadarSensor {
    index: SensorIndex,
    site: RadarSite,
    /// Whether the common frame is this radar's own.
    is_origin: bool,
    /// Turns a vector of this radar's axes into the common frame's.
    turn: Rotation3<f64>,
    /// Ellipsoidal height of a plot without a measured one, metres.
    assumed_height_m: f64,
    classification: Classification,
}

/// I048/030 codes that are no unmanned aircraft: angel, road vehicle, fixed plot, birds, flock of birds, wind turbine.
const NOT_A_UAV: [u8; 6] = [5, 6, 7, 19, 20, 23];

impl Normaliser {
    /// The frame is east-north-up at the first radar; without a configured geoid undulation EGM96's there is used. Plots
    /// inside `masks` are dropped.
    ///
    /// # Panics
    /// Without a radar: a [`Config`] has one.
    pub fn new(config: &Config, masks: Masks) -> Self {
        let mut frame = None;
        let mut undulation_m = 0.0;
        let mut radars = BTreeMap::new();
        let mut transponders = BTreeMap::new();
        for (index, sensor) in config.sensors.iter().enumerate() {
            let index = SensorIndex(index as u16);
            let source = DataSource { sac: sensor.sac, sic: sensor.sic };
            let radar = match &sensor.kind {
                SensorKind::Radar(radar) => radar,
                SensorKind::Transponder(_) => {
                    transponders.insert(source, index);
                    continue;
                }
            };
            let is_origin = frame.is_none();
            if is_origin {
                undulation_m = config.site.geoid_undulation_m.unwrap_or_else(|| undulation_at(radar));
            }
            let height_m = radar.height_amsl_m + undulation_m;
            let position = Geodetic::from_degrees(radar.latitude_deg, radar.longitude_deg, height_m);
            let site = RadarSite::new(position, radar.bearing_correction_deg);
            let common = frame.get_or_insert_with(|| TangentPlane::at_site(position));
            let turn = site.frame().turn_to(common);
            radars.insert(
                source,
                RadarSensor {
                    index,
                    site,
                    is_origin,
                    turn,
                    assumed_height_m: radar.assumed_height_amsl_m + undulation_m,
                    classification: radar.classification,
                },
            );
        }
        Self {
            frame: frame.expect("a configuration has a radar"),
            undulation_m,
            max_future: config.fusion.max_future,
            masks,
            radars,
            transponders,
        }
    }

    /// East-north-up at the first radar.
    pub fn frame(&self) -> &TangentPlane {
        &self.frame
    }

    /// Height of the geoid (mean sea level) above the ellipsoid at the site, metres.
    pub fn undulation_m(&self) -> f64 {
        self.undulation_m
    }

    /// A radar's record, received at `received`.
    pub fn plot(&self, record: &cat048::Record, received: Time) -> Result<Plot, Refused> {
        let source = record.data_source.ok_or((None, Refusal::NoDataSource))?;
        let radar = self.radars.get(&source).ok_or((None, Refusal::UnknownSource(source)))?;
        radar.plot(record, self, received).map_err(|refusal| (Some(radar.index), refusal))
    }

    /// A transponder's record, received at `received`.
    pub fn fix(&self, record: &cat129::Record, received: Time) -> Result<Fix, Refused> {
        let source = record.data_source.ok_or((None, Refusal::NoDataSource))?;
        let sensor = *self.transponders.get(&source).ok_or((None, Refusal::UnknownSource(source)))?;
        self.fix_of(sensor, record, received).map_err(|refusal| (Some(sensor), refusal))
    }

    /// What a radar's service message (CAT034) says.
    pub fn service(&self, record: &cat034::Record) -> Result<(SensorIndex, Service), Refused> {
        let source = record.data_source.ok_or((None, Refusal::NoDataSource))?;
        let radar = self.radars.get(&source).ok_or((None, Refusal::UnknownSource(source)))?;
        let common = record.system_status.as_ref().and_then(|status| status.common);
        let kind = record.message_type.map(cat034::MessageType::kind);
        let displaced_m = record.source_position.map(|said| {
            let height_m = said.height_m() + self.undulation_m;
            let place = Geodetic::from_degrees(said.latitude_deg(), said.longitude_deg(), height_m);
            radar.site.frame().from_geodetic(place).0.norm().round() as u32
        });
        let service = Service {
            nogo: common.map(cat034::CommonStatus::is_nogo),
            reset: common.map(cat034::CommonStatus::is_reset),
            time_invalid: common.map(cat034::CommonStatus::is_time_invalid),
            north_marker: kind == Some(cat034::MessageKind::NorthMarker),
            displaced_m,
        };
        Ok((radar.index, service))
    }

    fn is_masked(&self, position: Enu) -> bool {
        if self.masks.is_empty() {
            return false;
        }
        let place = self.frame.to_geodetic(position);
        self.masks.contain(place.longitude_deg(), place.latitude_deg())
    }

    fn fix_of(&self, sensor: SensorIndex, record: &cat129::Record, received: Time) -> Result<Fix, Refusal> {
        let time_of_day = record.time_of_day.ok_or(Refusal::NoTime)?;
        let position = record.position.ok_or(Refusal::NoPosition)?;
        let serial_number = record.serial_number.ok_or(Refusal::NoIdentity)?;
        let identity = Identity::new(&serial_number, record.registration_country.as_ref());
        let identity = identity.ok_or(Refusal::NoIdentity)?;
        let altitude = record.altitude_amsl.ok_or(Refusal::NoHeight)?;
        if !position.in_range() {
            return Err(Refusal::PositionOutOfRange);
        }
        let height_m = altitude.metres() + self.undulation_m;
        let place = Geodetic::from_degrees(position.latitude_deg(), position.longitude_deg(), height_m);
        Ok(Fix {
            sensor,
            identity,
            items: UasItems {
                manufacturer: record.manufacturer,
                model: record.model,
                serial_number,
                registration_country: record.registration_country,
            },
            time: self.time(time_of_day, received)?,
            position: self.frame.from_geodetic(place),
            accuracy_m: record.gnss_accuracy.and_then(GnssAccuracy::metres),
            velocity: record
                .horizontal_velocity
                .map(|velocity| Vector2::new(velocity.east_m_s(), velocity.north_m_s())),
            climb_m_s: record.vertical_velocity.map(VerticalVelocity::up_m_s),
        })
    }

    /// The report's time: on the day nearest to its reception, and not too far ahead of it.
    fn time(&self, time_of_day: TimeOfDay, received: Time) -> Result<Time, Refusal> {
        let time = nearest_day(time_of_day.count(), received).ok_or(Refusal::TimeOutOfRange)?;
        if time - received > self.max_future { Err(Refusal::Future) } else { Ok(time) }
    }
}

impl RadarSensor {
    fn plot(&self, record: &cat048::Record, site: &Normaliser, received: Time) -> Result<Plot, Refusal> {
        let time_of_day = record.time_of_day.ok_or(Refusal::NoTime)?;
        let polar = record.polar_position.ok_or(Refusal::NoPosition)?;
        let number = record.track_number.ok_or(Refusal::NoTrackNumber)?.number();
        if let Some(report) = &record.target_report {
            if report.detection() == DetectionType::NoDetection {
                return Err(Refusal::NoDetection);
            } else if report.is_simulated() {
                return Err(Refusal::Simulated);
            } else if report.is_test() {
                return Err(Refusal::TestTarget);
            }
        }
        let slant_range_m = polar.range_m();
        if slant_range_m <= 0.0 {
            return Err(Refusal::ZeroRange);
        }
        let measured = record.height_3d.map(|height| height.height_m() + site.undulation_m);
        let height_m = measured.unwrap_or(self.assumed_height_m);
        let local = self.site.position(slant_range_m, polar.azimuth_deg().to_radians(), height_m);
        let position = if self.is_origin {
            local.0.into()
        } else {
            site.frame.from_ecef(self.site.frame().to_ecef(local))
        };
        if site.is_masked(position) {
            return Err(Refusal::Masked);
        }
        Ok(Plot {
            track: RadarTrackKey { sensor: self.index, number },
            time: site.time(time_of_day, received)?,
            position,
            height_measured: measured.is_some(),
            slant_range_m,
            uav_probability: self.uav_probability(record),
            velocity: record.track_velocity.map(|velocity| {
                let own = self.site.velocity(velocity.speed_m_s(), velocity.heading_deg().to_radians());
                (self.turn * own.push(0.0)).xy()
            }),
        })
    }

    fn uav_probability(&self, record: &cat048::Record) -> Option<f64> {
        match self.classification {
            Classification::SpecialPurpose { octet } => {
                let field = record.special_purpose.as_ref()?;
                field.contents().get(octet).map(|&n| f64::from(n) / 255.0)
            }
            Classification::TargetClassification => {
                let mut codes = record.warnings.iter().flat_map(cat048::Warnings::codes);
                Some(if codes.any(|code| NOT_A_UAV.contains(&code)) { 0.0 } else { 1.0 })
            }
            Classification::Constant { value } => Some(value),
        }
    }
}

/// EGM96's geoid undulation at a radar, metres.
fn undulation_at(radar: &Radar) -> f64 {
    egm96::egm96_compute_altitude_offset(radar.latitude_deg, radar.longitude_deg)
}
