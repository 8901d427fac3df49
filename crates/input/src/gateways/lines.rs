//! Lines of text of a sensor without ASTERIX: JSON objects or comma-separated values, whose fields the configuration names.
//! A plot of a radar becomes CAT048, a report of a transponder CAT129.
//!
//! I048/040 has steps of 1/256 NM (7.2 m) and 0.0055°, I048/110 of 25 ft.

#[cfg(test)]
mod tests;
mod track_numbers;

use std::borrow::Cow;

use asterix::cat048::{
    self, DetectionType, Height3D, PolarPosition, TargetReport, TrackNumber, TrackVelocity,
};
use asterix::cat129::{self, Altitude, HorizontalVelocity, Position, WholeSerial};
use asterix::{DataSource, Explicit, encode_block};
use fusion::frames::{AtRadar, Enu, Geodetic, TangentPlane};
use fusion::time::{SECOND, Time};
use jiff::Timestamp;
use serde_json::Value;

use super::remote_id::lines;
use super::{DropCounts, time_of_day};
use crate::normalise::undulation_m;
use site::config::{Config, Connection, LineField, LineMapping, LinePosition, NO_COUNTRY, Radar, SensorKind};
use track_numbers::TrackNumbers;

/// Maximum length of a line, in octets.
const LINE_MAX: usize = 4096;

/// Largest difference between the time of a line and its reception, nanoseconds.
const TIME_OFF_NS: i64 = 3600 * SECOND;

/// Reason for dropping a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LineDropReason {
    /// `line_not_an_object`: not a JSON object, or not as many values as columns.
    NotAnObject,
    /// `line_value`: a needed value is missing, or is no number.
    Value,
    /// `line_time`: neither RFC 3339 nor a number, or more than an hour from its reception: ASTERIX has no date.
    Time,
    /// `line_name`: an empty track, or a serial number that CAT129 cannot hold.
    Name,
    /// `line_too_long`: above 4,096 octets.
    TooLong,
    /// `out_of_range`: no place, or a value that an item cannot hold.
    OutOfRange,
    /// `too_many_tracks`: 4,096 tracks of the last minute have all numbers.
    TooManyTracks,
}

pub(super) const REASONS: [&str; 7] = [
    "line_not_an_object",
    "line_value",
    "line_time",
    "line_name",
    "line_too_long",
    "out_of_range",
    "too_many_tracks",
];

/// Translates datagrams with lines to one block of ASTERIX each.
#[derive(Clone, Debug)]
pub struct LineTranslator {
    source: DataSource,
    mapping: LineMapping,
    radar: Option<RadarPlace>,
    tracks: TrackNumbers,
    dropped: DropCounts<7>,
}

/// The radar whose plots the lines are.
#[derive(Clone, Debug)]
struct RadarPlace {
    frame: TangentPlane<AtRadar>,
    undulation_m: f64,
    /// Height of targets without one, above mean sea level.
    assumed_amsl_m: f64,
}

impl RadarPlace {
    fn new(radar: &Radar, undulation_m: f64) -> Self {
        let height_m = radar.height_amsl_m + undulation_m;
        let place = Geodetic::from_degrees(radar.latitude_deg, radar.longitude_deg, height_m);
        Self { frame: TangentPlane::at(place), undulation_m, assumed_amsl_m: radar.assumed_height_amsl_m }
    }
}

/// Values of a line.
enum LineValues<'a> {
    Object(Value),
    Columns(&'a [String], Vec<&'a str>),
}

impl<'a> LineValues<'a> {
    fn parse(line: &'a [u8], columns: Option<&'a [String]>) -> Option<Self> {
        let Some(columns) = columns else {
            return serde_json::from_slice(line).ok().filter(Value::is_object).map(Self::Object);
        };
        let values: Vec<&str> = std::str::from_utf8(line).ok()?.split(',').map(str::trim).collect();
        (values.len() == columns.len()).then_some(Self::Columns(columns, values))
    }

    /// The text of a value; `None` if there is none, or it is empty.
    fn text(&self, field: &LineField) -> Option<Cow<'_, str>> {
        let text = match self {
            Self::Object(object) => {
                match field.path.iter().try_fold(object, |value, name| value.get(name))? {
                    Value::String(text) => Cow::Borrowed(text.trim()),
                    Value::Number(number) => Cow::Owned(number.to_string()),
                    _ => return None,
                }
            }
            Self::Columns(columns, values) => {
                let place = columns.iter().position(|column| Some(column) == field.path.first())?;
                Cow::Borrowed(values[place].trim_matches('"').trim())
            }
        };
        (!text.is_empty()).then_some(text)
    }

    /// A number in the usual unit.
    fn number(&self, field: &LineField) -> Result<f64, LineDropReason> {
        let number = self.text(field).and_then(|text| text.parse::<f64>().ok());
        number
            .filter(|number| number.is_finite())
            .map(|number| number * field.factor)
            .ok_or(LineDropReason::Value)
    }

    /// A number that may be missing, but not be something else.
    fn optional(&self, field: Option<&LineField>) -> Result<Option<f64>, LineDropReason> {
        let Some(field) = field else { return Ok(None) };
        if self.text(field).is_none() {
            return Ok(None);
        }
        self.number(field).map(Some)
    }

    /// The time of the measurement.
    fn time(&self, field: &LineField) -> Result<Time, LineDropReason> {
        let text = self.text(field).ok_or(LineDropReason::Time)?;
        let nanos = match text.parse::<f64>() {
            Ok(number) => {
                let seconds = number * field.factor;
                // Times outside the range of `Time`, in nanoseconds of 64 bits.
                if !(0.0..9e9).contains(&seconds) {
                    return Err(LineDropReason::Time);
                }
                seconds.trunc() as i64 * SECOND + (seconds.fract() * SECOND as f64).round() as i64
            }
            Err(_) => {
                let stamp: Timestamp = text.parse().map_err(|_| LineDropReason::Time)?;
                i64::try_from(stamp.as_nanosecond()).map_err(|_| LineDropReason::Time)?
            }
        };
        Ok(Time::from_nanos(nanos))
    }
}

impl LineTranslator {
    /// A translator for a connection of this sensor, a radar or a transponder; `None` if the connection has no lines.
    pub fn new(config: &Config, sensor: usize, connection: &Connection) -> Option<Self> {
        let sensor = config.sensors.get(sensor)?;
        let radar = match &sensor.kind {
            SensorKind::Radar(radar) => Some(RadarPlace::new(radar, undulation_m(config))),
            _ => None,
        };
        Some(Self {
            source: DataSource { sac: sensor.sac, sic: sensor.sic },
            mapping: connection.line_mapping(radar.is_some()).ok()?,
            radar,
            tracks: TrackNumbers::default(),
            dropped: DropCounts::new(&REASONS),
        })
    }

    /// Numbers of dropped lines, by [`LineDropReason`].
    pub fn dropped(&self) -> &DropCounts<7> {
        &self.dropped
    }

    /// The time that a line states.
    pub fn time(&self, line: &[u8]) -> Option<Time> {
        let values = LineValues::parse(line, self.mapping.columns.as_deref())?;
        values.time(self.mapping.time.as_ref()?).ok()
    }

    /// Takes a datagram with its time of reception. Each of its lines becomes a datagram, which is passed to `out`.
    pub fn take(&mut self, datagram: &[u8], received: Time, mut out: impl FnMut(Vec<u8>)) {
        for line in lines(datagram) {
            match self.line(line, received) {
                Ok(translated) => out(translated),
                Err(reason) => self.dropped.add(reason as usize),
            }
        }
    }

    /// Translates a line received at this time.
    ///
    /// # Errors
    /// The line is no report.
    pub fn line(&mut self, line: &[u8], received: Time) -> Result<Vec<u8>, LineDropReason> {
        if line.len() > LINE_MAX {
            return Err(LineDropReason::TooLong);
        }
        let mapping = self.mapping.clone();
        let values =
            LineValues::parse(line, mapping.columns.as_deref()).ok_or(LineDropReason::NotAnObject)?;
        let time = match &mapping.time {
            Some(field) => values.time(field)?,
            None => received,
        };
        if (time.nanos() - received.nanos()).abs() > TIME_OFF_NS {
            return Err(LineDropReason::Time);
        }
        match self.radar.clone() {
            Some(radar) => self.plot(&values, &mapping, &radar, (time, received)),
            None => report(self.source, &values, &mapping, time),
        }
    }

    fn plot(
        &mut self,
        values: &LineValues<'_>,
        mapping: &LineMapping,
        radar: &RadarPlace,
        (time, received): (Time, Time),
    ) -> Result<Vec<u8>, LineDropReason> {
        let Polar { range_m, azimuth_deg, height_amsl_m } = radar.polar(values, mapping)?;
        let track = values.text(&mapping.identity).ok_or(LineDropReason::Name)?;
        let number = self.tracks.number(&track, received).ok_or(LineDropReason::TooManyTracks)?;
        let out_of_range = LineDropReason::OutOfRange;
        let mut record = cat048::Record::builder(
            self.source,
            time_of_day(time),
            TargetReport::new(DetectionType::Primary),
        )
        .polar_position(Some(PolarPosition::new(range_m, azimuth_deg).ok_or(out_of_range)?))
        .track_number(TrackNumber::new(number));
        if let Some(height_m) = height_amsl_m {
            record = record.height_3d(Some(Height3D::from_metres(height_m).ok_or(out_of_range)?));
        }
        if let Some((speed_m_s, course_deg)) = velocity(values, mapping)? {
            record =
                record.track_velocity(Some(TrackVelocity::new(speed_m_s, course_deg).ok_or(out_of_range)?));
        }
        let probability = match &mapping.class {
            Some((class, drones)) => {
                values.text(class).map(|class| f64::from(drones.iter().any(|drone| *drone == class)))
            }
            None => values.optional(mapping.probability.as_ref())?,
        };
        if let Some(probability) = probability {
            if !(0.0..=1.0).contains(&probability) {
                return Err(out_of_range);
            }
            record = record.special_purpose(Explicit::new(&[(probability * 255.0).round() as u8]));
        }
        block(&[record.build().map_err(|_| out_of_range)?])
    }
}

/// A plot as the radar measures it.
struct Polar {
    range_m: f64,
    azimuth_deg: f64,
    /// Height above mean sea level, if it was measured.
    height_amsl_m: Option<f64>,
}

impl RadarPlace {
    fn polar(&self, values: &LineValues<'_>, mapping: &LineMapping) -> Result<Polar, LineDropReason> {
        let height_amsl_m = values.optional(mapping.height.as_ref())?;
        match &mapping.position {
            LinePosition::Polar { range, azimuth, elevation } => {
                let (range_m, azimuth_deg) = (values.number(range)?, values.number(azimuth)?);
                let elevation = values.optional(elevation.as_ref())?.map(f64::to_radians);
                let height_amsl_m = elevation.map_or(height_amsl_m, |elevation| {
                    let (east, north) = azimuth_deg.to_radians().sin_cos();
                    let ground_m = range_m * elevation.cos();
                    let up_m = range_m * elevation.sin();
                    Some(self.amsl_m(&Enu::new(ground_m * east, ground_m * north, up_m)))
                });
                Ok(Polar { range_m, azimuth_deg: azimuth_deg.rem_euclid(360.0), height_amsl_m })
            }
            LinePosition::Local(east, north, up) => {
                let up_m = values.optional(up.as_ref())?;
                let place = Enu::new(values.number(east)?, values.number(north)?, up_m.unwrap_or(0.0));
                let measured = up_m.map(|_| self.amsl_m(&place));
                Ok(Polar { height_amsl_m: height_amsl_m.or(measured), ..polar(&place) })
            }
            LinePosition::Geodetic(latitude, longitude) => {
                let (latitude_deg, longitude_deg) = place(values, latitude, longitude)?;
                let height_m = height_amsl_m.unwrap_or(self.assumed_amsl_m) + self.undulation_m;
                let place = Geodetic::from_degrees(latitude_deg, longitude_deg, height_m);
                Ok(Polar { height_amsl_m, ..polar(&self.frame.from_geodetic(place)) })
            }
        }
    }

    fn amsl_m(&self, place: &Enu<AtRadar>) -> f64 {
        self.frame.to_geodetic(*place).height_m - self.undulation_m
    }
}

fn polar(place: &Enu<AtRadar>) -> Polar {
    let ground_m = place.east().hypot(place.north());
    Polar {
        range_m: ground_m.hypot(place.up()),
        azimuth_deg: place.east().atan2(place.north()).to_degrees().rem_euclid(360.0),
        height_amsl_m: None,
    }
}

/// Latitude and longitude, degrees.
fn place(
    values: &LineValues<'_>,
    latitude: &LineField,
    longitude: &LineField,
) -> Result<(f64, f64), LineDropReason> {
    let (latitude_deg, longitude_deg) = (values.number(latitude)?, values.number(longitude)?);
    let is_place = latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 180.0;
    if is_place { Ok((latitude_deg, longitude_deg)) } else { Err(LineDropReason::OutOfRange) }
}

/// Speed over ground in m/s, and course in degrees.
fn velocity(values: &LineValues<'_>, mapping: &LineMapping) -> Result<Option<(f64, f64)>, LineDropReason> {
    let Some((speed, course)) = &mapping.velocity else { return Ok(None) };
    let (speed_m_s, course_deg) = (values.optional(Some(speed))?, values.optional(Some(course))?);
    Ok(speed_m_s.zip(course_deg).map(|(speed_m_s, course_deg)| (speed_m_s, course_deg.rem_euclid(360.0))))
}

/// The report of a transponder.
fn report(
    source: DataSource,
    values: &LineValues<'_>,
    mapping: &LineMapping,
    time: Time,
) -> Result<Vec<u8>, LineDropReason> {
    let LinePosition::Geodetic(latitude, longitude) = &mapping.position else {
        return Err(LineDropReason::Value);
    };
    let (latitude_deg, longitude_deg) = place(values, latitude, longitude)?;
    let height_m = values.optional(mapping.height.as_ref())?.ok_or(LineDropReason::Value)?;
    let out_of_range = LineDropReason::OutOfRange;
    let text = values.text(&mapping.identity).ok_or(LineDropReason::Name)?;
    let is_printable = text.bytes().all(|octet| (b' '..=b'~').contains(&octet));
    let serial = WholeSerial::new(text.as_bytes()).filter(|_| is_printable).ok_or(LineDropReason::Name)?;
    let position = Position::new(latitude_deg, longitude_deg).ok_or(out_of_range)?;
    let time = time_of_day(time).ok_or(out_of_range)?;
    let mut record = cat129::Record::builder(source, NO_COUNTRY, time, position)
        .serial_number(Some(serial.last()))
        .altitude_amsl(Some(Altitude::from_metres(height_m).ok_or(out_of_range)?));
    if !serial.octets().ends_with(b"        ") {
        record = record.special_purpose(Some(serial.to_field()));
    }
    if let Some((speed_m_s, course_deg)) = velocity(values, mapping)? {
        let (east, north) = course_deg.to_radians().sin_cos();
        let velocity = HorizontalVelocity::new(speed_m_s * east, speed_m_s * north).ok_or(out_of_range)?;
        record = record.horizontal_velocity(Some(velocity));
    }
    block(&[record.build().map_err(|_| out_of_range)?])
}

fn block<R: asterix::Record>(records: &[R]) -> Result<Vec<u8>, LineDropReason> {
    let mut datagram = Vec::new();
    encode_block(records, &mut datagram).map_err(|_| LineDropReason::OutOfRange)?;
    Ok(datagram)
}
