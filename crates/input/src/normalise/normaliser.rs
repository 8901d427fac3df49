//! Conversion of decoded records to reports: sensor, time, place and identity, or the reason for a refusal.

use std::collections::BTreeMap;

use asterix::cat048::{self, DetectionType};
use asterix::cat129::{GnssAccuracy, VerticalVelocity, WholeSerial};
use asterix::{DataSource, Record as _, TimeOfDay, cat015, cat021, cat034, cat129};

use jiff::SignedDuration;
use nalgebra::{Rotation3, Vector2};

use super::barometer::Barometer;
use super::camera::CameraSite;
use super::clock::nearest_day;
use super::polar::RadarSite;
use super::refusal::{Refusal, Refused};
use super::service::Service;
use super::{adsb, remote_id};
use fusion::declaration::Declaration;
use fusion::frames::{Geodetic, TangentPlane};
use fusion::report::{Aircraft, Bearing, Host, UasItems};
use fusion::time::Time;
use fusion::{Enu, Fix, Identity, Plot, RadarTrackKey, SensorIndex};
use site::areas::Masks;
use site::config::{Classification, Config, Profile, SensorKind};

/// The site's sensors and its common frame.
#[derive(Clone, Debug)]
pub struct Normaliser {
    frame: TangentPlane,
    undulation_m: f64,
    max_future: SignedDuration,
    masks: Masks,
    radars: BTreeMap<DataSource, RadarSensor>,
    transponders: BTreeMap<DataSource, SensorIndex>,
    adsb: BTreeMap<DataSource, SensorIndex>,
    editions: BTreeMap<DataSource, cat021::Edition>,
    cameras: BTreeMap<DataSource, CameraSite>,
    /// Remote ID receivers by their ids.
    remote_id: BTreeMap<String, SensorIndex>,
    /// Assumed height above the ellipsoid of reports without a height, in metres.
    unsaid_height_m: f64,
    /// Whether reports need a height, by the rules of the `reference` profile.
    needs_height: bool,
    /// Whether bearings are used; the `reference` profile does not use them.
    uses_bearings: bool,
}

/// Place of a report.
pub(super) struct Place {
    /// Position in the site's frame.
    pub(super) position: Enu,
    /// Whether its height was measured.
    pub(super) height_measured: bool,
    /// Rotation from east, north and up at this place to the site's.
    turn: Rotation3<f64>,
}

impl Place {
    /// Horizontal velocity and climb in the site's axes, in m/s, from those at this place. Far away, an aircraft in level
    /// flight descends in the site's axes, and its north differs.
    pub(super) fn motion(
        &self,
        over_ground: Option<Vector2<f64>>,
        climb_m_s: Option<f64>,
    ) -> (Option<Vector2<f64>>, Option<f64>) {
        match over_ground {
            Some(over_ground) => {
                let velocity = self.turn * over_ground.push(climb_m_s.unwrap_or(0.0));
                (Some(velocity.xy()), climb_m_s.map(|_| velocity.z))
            }
            None => (None, climb_m_s),
        }
    }
}

#[derive(Clone, Debug)]
struct RadarSensor {
    index: SensorIndex,
    site: RadarSite,
    /// Whether the common frame is this radar's own.
    is_origin: bool,
    /// Rotation from this radar's axes to the common frame's.
    turn: Rotation3<f64>,
    /// Assumed ellipsoidal height of a plot without a measured one, in metres.
    assumed_height_m: f64,
    classification: Classification,
}

/// I048/030 codes of targets that are not unmanned aircraft: angel, road vehicle, fixed plot, birds, flock of birds, wind
/// turbine.
const NOT_A_UAV: [u8; 6] = [5, 6, 7, 19, 20, 23];

/// Height of the geoid (mean sea level) above the ellipsoid: as configured, or that of EGM96 at the origin, in metres.
pub fn undulation_m(config: &Config) -> f64 {
    let (latitude_deg, longitude_deg, _) = config.origin();
    let at_origin = || egm96::egm96_compute_altitude_offset(latitude_deg, longitude_deg);
    config.site.geoid_undulation_m.unwrap_or_else(at_origin)
}

impl Normaliser {
    /// The frame is east-north-up at the first radar, or at the configured origin. Without a configured geoid undulation,
    /// that of EGM96 at the origin is used. Plots inside `masks` are dropped.
    pub fn new(config: &Config, masks: Masks) -> Self {
        let (latitude_deg, longitude_deg, height_amsl_m) = config.origin();
        let undulation_m = undulation_m(config);
        let origin = Geodetic::from_degrees(latitude_deg, longitude_deg, height_amsl_m + undulation_m);
        let frame = TangentPlane::at_site(origin);
        let mut radars = BTreeMap::new();
        let mut transponders = BTreeMap::new();
        let mut adsb = BTreeMap::new();
        let mut remote_id = BTreeMap::new();
        let mut cameras = BTreeMap::new();
        for (index, sensor) in config.sensors.iter().enumerate() {
            let index = SensorIndex(index as u16);
            let source = DataSource { sac: sensor.sac, sic: sensor.sic };
            let radar = match &sensor.kind {
                SensorKind::Radar(radar) => radar,
                SensorKind::Transponder(_) => {
                    transponders.insert(source, index);
                    continue;
                }
                SensorKind::AdsB(_) => {
                    adsb.insert(source, index);
                    continue;
                }
                SensorKind::RemoteId(_) => {
                    remote_id.insert(sensor.id.clone(), index);
                    continue;
                }
                SensorKind::Camera(of) => {
                    let height_m = of.height_amsl_m + undulation_m;
                    let place = Geodetic::from_degrees(of.latitude_deg, of.longitude_deg, height_m);
                    cameras.insert(source, CameraSite::new(index, place, of.bearing_correction_deg, &frame));
                    continue;
                }
            };
            let is_origin = radars.is_empty();
            let height_m = radar.height_amsl_m + undulation_m;
            let position = Geodetic::from_degrees(radar.latitude_deg, radar.longitude_deg, height_m);
            let site = RadarSite::new(position, radar.bearing_correction_deg);
            let turn = site.frame().turn_to(&frame);
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
            frame,
            undulation_m,
            max_future: config.fusion.max_future,
            masks,
            radars,
            transponders,
            adsb,
            editions: config.editions(),
            remote_id,
            cameras,
            unsaid_height_m: origin.height_m,
            needs_height: config.fusion.profile == Profile::Reference,
            uses_bearings: config.fusion.profile != Profile::Reference,
        }
    }

    /// East-north-up at the first radar, or at the configured origin.
    pub fn frame(&self) -> &TangentPlane {
        &self.frame
    }

    /// Height of the geoid (mean sea level) above the ellipsoid at the site, in metres.
    pub fn undulation_m(&self) -> f64 {
        self.undulation_m
    }

    /// The sensor with this SAC and SIC for records of this category.
    pub fn sensor(&self, category: u8, source: DataSource) -> Option<SensorIndex> {
        match category {
            cat034::Record::CATEGORY | cat048::Record::CATEGORY => {
                self.radars.get(&source).map(|radar| radar.index)
            }
            cat129::Record::CATEGORY => self.transponders.get(&source).copied(),
            cat021::Record::CATEGORY => self.adsb.get(&source).copied(),
            cat015::Record::CATEGORY => self.cameras.get(&source).map(|camera| camera.index),
            _ => None,
        }
    }

    /// Plot from a radar's record, received at `received`.
    pub fn plot(&self, record: &cat048::Record, received: Time) -> Result<Plot, Refused> {
        let source = record.data_source.ok_or((None, Refusal::NoDataSource))?;
        let unknown = (None, Refusal::UnknownSource { category: cat048::Record::CATEGORY, source });
        let radar = self.radars.get(&source).ok_or(unknown)?;
        radar.plot(record, self, received).map_err(|refusal| (Some(radar.index), refusal))
    }

    /// Fix from a transponder's record, received at `received`.
    pub fn fix(&self, record: &cat129::Record, received: Time) -> Result<Fix, Refused> {
        let source = record.data_source.ok_or((None, Refusal::NoDataSource))?;
        let unknown = (None, Refusal::UnknownSource { category: cat129::Record::CATEGORY, source });
        let sensor = *self.transponders.get(&source).ok_or(unknown)?;
        self.fix_of(sensor, record, received).map_err(|refusal| (Some(sensor), refusal))
    }

    /// Edition of CAT021 that a receiver uses; `None` if it is not configured.
    pub fn edition(&self, source: DataSource) -> Option<cat021::Edition> {
        self.editions.get(&source).copied()
    }

    /// Also accepts ADS-B and Remote ID without a height under the rules of `reference`, at an assumed height.
    pub fn with_optional_heights(self) -> Self {
        Self { needs_height: false, ..self }
    }

    /// Whether the site has a camera.
    pub fn has_cameras(&self) -> bool {
        !self.cameras.is_empty()
    }

    /// Bearing from a camera's record, received at `received`; the `reference` profile does not use bearings.
    pub fn bearing(&self, record: &cat015::Record, received: Time) -> Result<Bearing, Refused> {
        let source = record.data_source.ok_or((None, Refusal::NoDataSource))?;
        let unknown = (None, Refusal::UnknownSource { category: cat015::Record::CATEGORY, source });
        let camera = self.cameras.get(&source).ok_or(unknown)?;
        let bearing = match self.uses_bearings {
            true => camera.bearing(record, self, received),
            false => Err(Refusal::NotUsed),
        };
        bearing.map_err(|refusal| (Some(camera.index), refusal))
    }

    /// Whether the site has an ADS-B receiver.
    pub fn has_adsb(&self) -> bool {
        !self.adsb.is_empty()
    }

    /// The editions of all ADS-B receivers.
    pub fn editions(&self) -> BTreeMap<DataSource, cat021::Edition> {
        self.editions.clone()
    }

    /// Fix from an ADS-B receiver's record, received at `received`; `barometer` learns from it.
    pub fn adsb(
        &self,
        record: &cat021::Record,
        received: Time,
        barometer: &mut Barometer,
    ) -> Result<Fix, Refused> {
        let source = record.data_source.ok_or((None, Refusal::NoDataSource))?;
        let unknown = (None, Refusal::UnknownSource { category: cat021::Record::CATEGORY, source });
        let sensor = *self.adsb.get(&source).ok_or(unknown)?;
        adsb::fix(self, sensor, record, received, barometer).map_err(|refusal| (Some(sensor), refusal))
    }

    /// The Remote ID receiver with this id or, without an id, the only one.
    pub fn remote_id_receiver(&self, id: Option<&str>) -> Result<SensorIndex, Refused> {
        let found = match id {
            Some(id) => self.remote_id.get(id),
            None => self.remote_id.values().next().filter(|_| self.remote_id.len() == 1),
        };
        found.copied().ok_or((None, Refusal::UnknownReceiver))
    }

    /// The Remote ID receivers.
    pub fn remote_id_receivers(&self) -> impl Iterator<Item = SensorIndex> {
        self.remote_id.values().copied()
    }

    /// Fix from a drone's Location, with the other declarations of its transmitter, received by this receiver at
    /// `received`. `stamped` is the time of reception that the gateway states.
    pub fn remote_id(
        &self,
        sensor: SensorIndex,
        drone: (Identity, &::remote_id::Location, Declaration),
        received: Time,
        stamped: Option<Time>,
        barometer: &mut Barometer,
    ) -> Result<Fix, Refused> {
        remote_id::fix(self, sensor, drone, received, stamped, barometer)
            .map_err(|refusal| (Some(sensor), refusal))
    }

    /// State of a radar from its service message (CAT034).
    pub fn service(&self, record: &cat034::Record) -> Result<(SensorIndex, Service), Refused> {
        let source = record.data_source.ok_or((None, Refusal::NoDataSource))?;
        let unknown = (None, Refusal::UnknownSource { category: cat034::Record::CATEGORY, source });
        let radar = self.radars.get(&source).ok_or(unknown)?;
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
        // The whole serial number, if it is longer than the item.
        let whole = record.special_purpose.as_ref().and_then(WholeSerial::read);
        let whole = whole.filter(|whole| whole.last() == serial_number);
        let serial = whole.as_ref().map_or(&serial_number[..], |whole| whole.octets());
        let identity = Identity::new(serial, record.registration_country.as_ref());
        let identity = identity.ok_or(Refusal::NoIdentity)?;
        let altitude = record.altitude_amsl.ok_or(Refusal::NoHeight)?;
        if !position.in_range() {
            return Err(Refusal::PositionOutOfRange);
        }
        let height_m = altitude.metres() + self.undulation_m;
        let place = Geodetic::from_degrees(position.latitude_deg(), position.longitude_deg(), height_m);
        Ok(Fix {
            sensor,
            host: Host::default(),
            identity,
            aircraft: Aircraft::default(),
            height_measured: true,
            height_sigma_m: None,
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

    /// Time of a report: on the day nearest to its reception, and not too far ahead of it.
    pub(super) fn time(&self, time_of_day: TimeOfDay, received: Time) -> Result<Time, Refusal> {
        let time = nearest_day(time_of_day.count(), received).ok_or(Refusal::TimeOutOfRange)?;
        self.not_ahead(time, received)
    }

    /// Checks that a time is not too far ahead of its reception.
    pub(super) fn not_ahead(&self, time: Time, received: Time) -> Result<Time, Refusal> {
        if time - received > self.max_future { Err(Refusal::Future) } else { Ok(time) }
    }

    /// Height above the ellipsoid from a pressure altitude, with its standard deviation, in metres. The `reference` profile
    /// does not use the accuracy of heights, so it needs a difference shown by other aircraft.
    pub(super) fn height_by_pressure(
        &self,
        altitude_m: f64,
        time: Time,
        barometer: &mut Barometer,
    ) -> Option<(f64, f64)> {
        match self.needs_height {
            true => barometer.shown_m(altitude_m, time),
            false => Some(barometer.height_m(altitude_m, self.undulation_m, time)),
        }
    }

    /// Place of a report: latitude and longitude in degrees, and the height above the ellipsoid in metres, if stated.
    pub(super) fn place(
        &self,
        [latitude_deg, longitude_deg]: [f64; 2],
        height_m: Option<f64>,
    ) -> Result<Place, Refusal> {
        if latitude_deg.abs() > 90.0 || longitude_deg.abs() > 180.0 {
            return Err(Refusal::PositionOutOfRange);
        }
        if height_m.is_none() && self.needs_height {
            return Err(Refusal::NoHeight);
        }
        let height = height_m.unwrap_or(self.unsaid_height_m);
        let place = Geodetic::from_degrees(latitude_deg, longitude_deg, height);
        Ok(Place {
            position: self.frame.from_geodetic(place),
            height_measured: height_m.is_some(),
            turn: TangentPlane::at_site(place).turn_to(&self.frame),
        })
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
            Classification::SpecialPurpose(stated) => {
                stated.probability(record.special_purpose.as_ref()?.contents())
            }
            Classification::SpecialPurposeCategory(category) => {
                category.probability(record.special_purpose.as_ref()?.contents())
            }
            Classification::TargetClassification => {
                let mut codes = record.warnings.iter().flat_map(cat048::Warnings::codes);
                Some(if codes.any(|code| NOT_A_UAV.contains(&code)) { 0.0 } else { 1.0 })
            }
            Classification::Constant { value } => Some(value),
        }
    }
}
