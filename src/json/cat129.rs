//! CAT129 as JSON.

use asterix::cat129::fusion_report::{Deviation, Source as PointSource, UavProbability};
use asterix::cat129::{
    Altitude, DataDestination, FusionReport, GnssAccuracy, HorizontalVelocity, OperationalRisk, Position,
    Record, VerticalVelocity,
};
use asterix::{DataSource, Explicit, Fspec, Record as _, TimeOfDay};
use serde::Serialize;

use super::values::{Hex, Source, Text, is_zero, rounded};

/// The items of a record, in its order; what is absent is left out.
#[derive(Serialize)]
pub struct Items {
    #[serde(rename = "010", skip_serializing_if = "Option::is_none")]
    data_source: Option<Source>,
    #[serde(rename = "015", skip_serializing_if = "Option::is_none")]
    data_destination: Option<Destination>,
    #[serde(rename = "020", skip_serializing_if = "Option::is_none")]
    manufacturer: Option<Text>,
    #[serde(rename = "030", skip_serializing_if = "Option::is_none")]
    model: Option<Text>,
    #[serde(rename = "040", skip_serializing_if = "Option::is_none")]
    serial_number: Option<Text>,
    #[serde(rename = "050", skip_serializing_if = "Option::is_none")]
    registration_country: Option<Text>,
    /// Seconds, exact.
    #[serde(rename = "070", skip_serializing_if = "Option::is_none")]
    time_of_day: Option<f64>,
    #[serde(rename = "080", skip_serializing_if = "Option::is_none")]
    position: Option<Degrees>,
    #[serde(rename = "090", skip_serializing_if = "Option::is_none")]
    altitude_amsl: Option<Metres>,
    #[serde(rename = "100", skip_serializing_if = "Option::is_none")]
    altitude_agl: Option<Metres>,
    #[serde(rename = "110", skip_serializing_if = "Option::is_none")]
    gnss_accuracy: Option<Accuracy>,
    #[serde(rename = "120", skip_serializing_if = "Option::is_none")]
    operational_risk: Option<Risk>,
    #[serde(rename = "SP", skip_serializing_if = "Option::is_none")]
    special_purpose: Option<SpecialPurpose>,
    #[serde(rename = "185", skip_serializing_if = "Option::is_none")]
    horizontal_velocity: Option<Horizontal>,
    #[serde(rename = "220", skip_serializing_if = "Option::is_none")]
    vertical_velocity: Option<Vertical>,
}

impl super::Record for Record {
    type Items = Items;

    fn items(&self) -> Items {
        Items {
            data_source: self.data_source.map(Source::from),
            data_destination: self.data_destination.map(Destination::from),
            manufacturer: self.manufacturer.map(|text| Text::ascii(&text)),
            model: self.model.map(|text| Text::ascii(&text)),
            serial_number: self.serial_number.map(|text| Text::ascii(&text)),
            registration_country: self.registration_country.map(|text| Text::ascii(&text)),
            time_of_day: self.time_of_day.map(TimeOfDay::seconds),
            position: self.position.map(Degrees::from),
            altitude_amsl: self.altitude_amsl.map(Metres::from),
            altitude_agl: self.altitude_agl.map(Metres::from),
            gnss_accuracy: self.gnss_accuracy.map(Accuracy::from),
            operational_risk: self.operational_risk.map(Risk::from),
            special_purpose: self.special_purpose.as_ref().map(SpecialPurpose::from),
            horizontal_velocity: self.horizontal_velocity.map(Horizontal::from),
            vertical_velocity: self.vertical_velocity.map(Vertical::from),
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

/// I129/015.
#[derive(Serialize)]
struct Destination {
    dac: u8,
    dic: u8,
}

impl From<DataDestination> for Destination {
    fn from(destination: DataDestination) -> Self {
        Self { dac: destination.dac, dic: destination.dic }
    }
}

/// I129/080.
#[derive(Serialize)]
struct Degrees {
    latitude_deg: f64,
    longitude_deg: f64,
}

impl From<Position> for Degrees {
    fn from(position: Position) -> Self {
        Self {
            latitude_deg: rounded(position.latitude_deg(), 8),
            longitude_deg: rounded(position.longitude_deg(), 8),
        }
    }
}

/// I129/090, 100.
#[derive(Serialize)]
struct Metres {
    altitude_m: f64,
}

impl From<Altitude> for Metres {
    fn from(altitude: Altitude) -> Self {
        Self { altitude_m: altitude.metres() }
    }
}

/// I129/110; `null` where the item says that it is unknown.
#[derive(Serialize)]
struct Accuracy {
    accuracy_m: Option<u16>,
}

impl From<GnssAccuracy> for Accuracy {
    fn from(accuracy: GnssAccuracy) -> Self {
        Self { accuracy_m: accuracy.metres().map(|_| accuracy.count()) }
    }
}

/// I129/120.
#[derive(Serialize)]
struct Risk {
    certification_category: u8,
    /// ARC, 1 to 4.
    air_risk_category: u8,
    airspace_encounter_category: u8,
    /// The octets that the edition does not describe, where the item has three.
    #[serde(skip_serializing_if = "Option::is_none")]
    undescribed: Option<Hex>,
}

impl From<OperationalRisk> for Risk {
    fn from(risk: OperationalRisk) -> Self {
        Self {
            certification_category: risk.octet >> 6,
            air_risk_category: risk.air_risk_category(),
            airspace_encounter_category: risk.airspace_encounter_category(),
            undescribed: risk.undescribed.map(|octets| Hex::new(&octets)),
        }
    }
}

/// SP: understood where it is the service's own layout and nothing would be lost, otherwise the whole item.
#[derive(Serialize)]
#[serde(untagged)]
enum SpecialPurpose {
    Fusion { uf: Box<Fusion> },
    Octets(Hex),
}

impl From<&Explicit> for SpecialPurpose {
    fn from(field: &Explicit) -> Self {
        match FusionReport::read(field) {
            Some(report) if report.to_field() == *field => Self::Fusion { uf: Box::new(report.into()) },
            _ => Self::Octets(Hex::new(field.octets())),
        }
    }
}

/// The service's own SP, layout `UF` version 1; what is unknown or does not contribute is left out.
#[derive(Serialize)]
struct Fusion {
    source: &'static str,
    track_number: u32,
    #[serde(skip_serializing_if = "Option::is_none")]
    radar_track: Option<u16>,
    #[serde(skip_serializing_if = "Option::is_none")]
    transponder: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    horizontal_deviation_m: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    vertical_deviation_m: Option<f64>,
    /// Names of the bits that are set, the lowest first.
    flags: Vec<&'static str>,
    #[serde(skip_serializing_if = "Option::is_none")]
    uav_probability: Option<f64>,
}

/// The flags of the fusion report, the lowest bit first; version 1 does not name the last two.
const FLAGS: [&str; 8] = [
    "interpolated",
    "extrapolated",
    "integrity_suspect",
    "integrity_failed",
    "uncooperative",
    "height_not_measured",
    "bit_7",
    "bit_8",
];

impl From<FusionReport> for Fusion {
    fn from(report: FusionReport) -> Self {
        let metres = |deviation: Deviation| deviation.metres();
        let flags = FLAGS.iter().enumerate().filter(|(bit, _)| report.flags.0 >> bit & 1 == 1);
        Self {
            source: match report.source {
                PointSource::Fused => "fused",
                PointSource::Radar => "radar",
                PointSource::Transponder => "transponder",
            },
            track_number: report.track_number,
            radar_track: report.radar_track,
            transponder: report.transponder,
            horizontal_deviation_m: metres(report.horizontal_deviation),
            vertical_deviation_m: metres(report.vertical_deviation),
            flags: flags.map(|(_, &name)| name).collect(),
            uav_probability: UavProbability::probability(report.uav_probability)
                .map(|probability| rounded(probability, 3)),
        }
    }
}

/// I129/185.
#[derive(Serialize)]
struct Horizontal {
    east_m_s: f64,
    north_m_s: f64,
}

impl From<HorizontalVelocity> for Horizontal {
    fn from(velocity: HorizontalVelocity) -> Self {
        Self { east_m_s: velocity.east_m_s(), north_m_s: velocity.north_m_s() }
    }
}

/// I129/220.
#[derive(Serialize)]
struct Vertical {
    #[serde(skip_serializing_if = "is_zero")]
    spare: u8,
    up_m_s: f64,
}

impl From<VerticalVelocity> for Vertical {
    fn from(velocity: VerticalVelocity) -> Self {
        let up_m_s = velocity.up_m_s();
        let clean = VerticalVelocity::new(up_m_s) == Some(velocity);
        Self { spare: if clean { 0 } else { spare_bits(velocity) }, up_m_s }
    }
}

/// The four spare bits of I129/220. The codec has no accessor for them, so the item, the last of a record, is encoded.
fn spare_bits(velocity: VerticalVelocity) -> u8 {
    let mut octets = Vec::new();
    Record { vertical_velocity: Some(velocity), ..Record::default() }.encode_into(&mut octets);
    octets[octets.len() - 3] >> 4
}

#[cfg(test)]
mod tests {
    use super::*;

    proptest::proptest! {
        #[test]
        fn a_position_rounds_back_to_its_counts(
            latitude in -(1 << 29)..=1 << 29, longitude in -(1 << 30)..=1 << 30,
        ) {
            let position = Position { latitude, longitude };
            let printed = Degrees::from(position);
            proptest::prop_assert_eq!(Position::new(printed.latitude_deg, printed.longitude_deg), Some(position));
        }
    }

    #[test]
    fn a_probability_rounds_back_to_its_count() {
        for count in 0..=254 {
            let probability = UavProbability::from_probability(f64::from(count) / 254.0);
            let printed = rounded(probability.probability().unwrap(), 3);
            assert_eq!(UavProbability::from_probability(printed), probability);
        }
    }
}
