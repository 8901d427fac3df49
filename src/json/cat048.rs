//! CAT048 as JSON.

use asterix::cat048::{
    AircraftIdentification, FlightLevel, Height3D, Mode3A, PolarPosition, Record, TrackNumber, TrackVelocity,
};
use asterix::{DataSource, Fspec, RawItem, TimeOfDay};
use serde::Serialize;

use super::chain::Fields;
use super::values::{Hex, Source, Text, is_zero, rounded};

/// The items of a record, in its order; what is absent is left out.
#[derive(Serialize)]
pub struct Items {
    #[serde(rename = "010", skip_serializing_if = "Option::is_none")]
    data_source: Option<Source>,
    /// Seconds, exact.
    #[serde(rename = "140", skip_serializing_if = "Option::is_none")]
    time_of_day: Option<f64>,
    #[serde(rename = "020", skip_serializing_if = "Option::is_none")]
    target_report: Option<Fields>,
    #[serde(rename = "040", skip_serializing_if = "Option::is_none")]
    polar_position: Option<Polar>,
    #[serde(rename = "070", skip_serializing_if = "Option::is_none")]
    mode_3a: Option<Code>,
    #[serde(rename = "090", skip_serializing_if = "Option::is_none")]
    flight_level: Option<Level>,
    #[serde(rename = "130", skip_serializing_if = "Option::is_none")]
    plot_characteristics: Option<Hex>,
    /// Six hexadecimal digits.
    #[serde(rename = "220", skip_serializing_if = "Option::is_none")]
    aircraft_address: Option<String>,
    #[serde(rename = "240", skip_serializing_if = "Option::is_none")]
    aircraft_identification: Option<Text>,
    #[serde(rename = "250", skip_serializing_if = "Option::is_none")]
    bds_registers: Option<Hex>,
    #[serde(rename = "161", skip_serializing_if = "Option::is_none")]
    track_number: Option<Number>,
    #[serde(rename = "042", skip_serializing_if = "Option::is_none")]
    cartesian_position: Option<Hex>,
    #[serde(rename = "200", skip_serializing_if = "Option::is_none")]
    track_velocity: Option<Velocity>,
    #[serde(rename = "170", skip_serializing_if = "Option::is_none")]
    track_status: Option<Fields>,
    #[serde(rename = "210", skip_serializing_if = "Option::is_none")]
    track_quality: Option<Hex>,
    /// The codes, in their order.
    #[serde(rename = "030", skip_serializing_if = "Option::is_none")]
    warnings: Option<Vec<u8>>,
    #[serde(rename = "080", skip_serializing_if = "Option::is_none")]
    mode_3a_confidence: Option<Hex>,
    #[serde(rename = "100", skip_serializing_if = "Option::is_none")]
    mode_c: Option<Hex>,
    #[serde(rename = "110", skip_serializing_if = "Option::is_none")]
    height_3d: Option<Height>,
    #[serde(rename = "120", skip_serializing_if = "Option::is_none")]
    radial_doppler: Option<Hex>,
    #[serde(rename = "230", skip_serializing_if = "Option::is_none")]
    capability: Option<Hex>,
    #[serde(rename = "260", skip_serializing_if = "Option::is_none")]
    acas_advisory: Option<Hex>,
    #[serde(rename = "055", skip_serializing_if = "Option::is_none")]
    mode_1: Option<Hex>,
    #[serde(rename = "050", skip_serializing_if = "Option::is_none")]
    mode_2: Option<Hex>,
    #[serde(rename = "065", skip_serializing_if = "Option::is_none")]
    mode_1_confidence: Option<Hex>,
    #[serde(rename = "060", skip_serializing_if = "Option::is_none")]
    mode_2_confidence: Option<Hex>,
    #[serde(rename = "SP", skip_serializing_if = "Option::is_none")]
    special_purpose: Option<Hex>,
    #[serde(rename = "RE", skip_serializing_if = "Option::is_none")]
    reserved_expansion: Option<Hex>,
}

impl super::Record for Record {
    type Items = Items;

    fn items(&self) -> Items {
        fn fixed<const N: usize>(item: Option<[u8; N]>) -> Option<Hex> {
            item.map(|octets| Hex::new(&octets))
        }
        let raw = |item: &Option<RawItem>| item.as_ref().map(|item| Hex::new(item.octets()));
        Items {
            data_source: self.data_source.map(Source::from),
            time_of_day: self.time_of_day.map(TimeOfDay::seconds),
            target_report: self.target_report.map(|report| Fields::target_report(*report.chain())),
            polar_position: self.polar_position.map(Polar::from),
            mode_3a: self.mode_3a.map(Code::from),
            flight_level: self.flight_level.map(Level::from),
            plot_characteristics: raw(&self.plot_characteristics),
            aircraft_address: self.aircraft_address.map(|address| address.to_string()),
            aircraft_identification: self.aircraft_identification.map(identification),
            bds_registers: raw(&self.bds_registers),
            track_number: self.track_number.map(Number::from),
            cartesian_position: fixed(self.cartesian_position),
            track_velocity: self.track_velocity.map(Velocity::from),
            track_status: self.track_status.map(|status| Fields::track_status(*status.chain())),
            track_quality: fixed(self.track_quality),
            warnings: self.warnings.map(|warnings| warnings.codes().collect()),
            mode_3a_confidence: fixed(self.mode_3a_confidence),
            mode_c: fixed(self.mode_c),
            height_3d: self.height_3d.map(Height::from),
            radial_doppler: raw(&self.radial_doppler),
            capability: fixed(self.capability),
            acas_advisory: fixed(self.acas_advisory),
            mode_1: fixed(self.mode_1),
            mode_2: fixed(self.mode_2),
            mode_1_confidence: fixed(self.mode_1_confidence),
            mode_2_confidence: fixed(self.mode_2_confidence),
            special_purpose: self.special_purpose.as_ref().map(|field| Hex::new(field.octets())),
            reserved_expansion: self.reserved_expansion.as_ref().map(|field| Hex::new(field.octets())),
        }
    }

    fn data_source(&self) -> Option<DataSource> {
        self.data_source
    }

    fn time_of_day(&self) -> Option<TimeOfDay> {
        self.time_of_day
    }

    fn padded_fspec(&self) -> Option<Fspec> {
        (self.fspec_padding > 0).then(|| self.fspec())
    }
}

/// I048/040.
#[derive(Serialize)]
struct Polar {
    rho_m: f64,
    theta_deg: f64,
}

impl From<PolarPosition> for Polar {
    fn from(position: PolarPosition) -> Self {
        Self { rho_m: rounded(position.range_m(), 1), theta_deg: rounded(position.azimuth_deg(), 3) }
    }
}

/// I048/070.
#[derive(Serialize)]
struct Code {
    v: u8,
    g: u8,
    l: u8,
    #[serde(skip_serializing_if = "is_zero")]
    spare: u8,
    /// Four octal digits.
    mode_3a: String,
}

impl From<Mode3A> for Code {
    fn from(code: Mode3A) -> Self {
        Self {
            v: (!code.is_validated()).into(),
            g: code.is_garbled().into(),
            l: code.is_not_extracted().into(),
            spare: (code.word() >> 12 & 1) as u8,
            mode_3a: code.to_string(),
        }
    }
}

/// I048/090.
#[derive(Serialize)]
struct Level {
    v: u8,
    g: u8,
    flight_level: f64,
}

impl From<FlightLevel> for Level {
    fn from(level: FlightLevel) -> Self {
        Self {
            v: (!level.is_validated()).into(),
            g: level.is_garbled().into(),
            flight_level: level.flight_level(),
        }
    }
}

/// I048/240: the octets where a code stands for no character.
fn identification(identification: AircraftIdentification) -> Text {
    let characters = identification.characters();
    let text = Text::ascii(&characters);
    match &text {
        Text::Plain(plain) if AircraftIdentification::new(plain) == Some(identification) => text,
        _ => Text::Octets { hex: Hex::new(&identification.octets()) },
    }
}

/// I048/161.
#[derive(Serialize)]
struct Number {
    #[serde(skip_serializing_if = "is_zero")]
    spare: u8,
    track_number: u16,
}

impl From<TrackNumber> for Number {
    fn from(number: TrackNumber) -> Self {
        Self { spare: (number.word() >> 12) as u8, track_number: number.number() }
    }
}

/// I048/200.
#[derive(Serialize)]
struct Velocity {
    speed_m_s: f64,
    heading_deg: f64,
}

impl From<TrackVelocity> for Velocity {
    fn from(velocity: TrackVelocity) -> Self {
        Self { speed_m_s: rounded(velocity.speed_m_s(), 2), heading_deg: rounded(velocity.heading_deg(), 3) }
    }
}

/// I048/110.
#[derive(Serialize)]
struct Height {
    #[serde(skip_serializing_if = "is_zero")]
    spare: u8,
    height_m: f64,
}

impl From<Height3D> for Height {
    fn from(height: Height3D) -> Self {
        Self { spare: (height.word() >> 14) as u8, height_m: rounded(height.height_m(), 2) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_number_rounds_back_to_its_count() {
        for word in 0..=u16::MAX {
            let position = PolarPosition { rho: word, theta: word };
            let polar = Polar::from(position);
            assert_eq!(PolarPosition::new(polar.rho_m, polar.theta_deg), Some(position));
            let velocity = TrackVelocity { speed: word, heading: word };
            let printed = Velocity::from(velocity);
            assert_eq!(TrackVelocity::new(printed.speed_m_s, printed.heading_deg), Some(velocity));
            let height = Height::from(Height3D::from_word(word));
            let count = Height3D::from_metres(height.height_m).unwrap().word();
            assert_eq!(u16::from(height.spare) << 14 | count, word);
            let level = Level::from(FlightLevel::from_word(word));
            let count = FlightLevel::new(level.flight_level).unwrap().word();
            assert_eq!(u16::from(level.v) << 15 | u16::from(level.g) << 14 | count, word);
        }
    }
}
