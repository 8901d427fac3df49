//! State of one aircraft from its squitters, and the CAT021 record of a position.

use asterix::cat021::{
    AircraftAddress, AircraftIdentification, AltitudeReporting, BarometricLevel, Emitter, EmitterCategory,
    GeometricHeight, GroundVector, LinkTechnology, Mode3A, MopsVersion, Position as FinePosition,
    PriorityStatus, QualityIndicators, Record, Standard, TargetReport, TargetStatus, VerticalRate,
};
use asterix::{BuildError, DataSource};
use fusion::time::{SECOND, Time};

use super::cpr::{self, CprPosition, LatLonDeg};
use super::squitter::{Accuracy, Squitter, SquitterContents, SquitterPosition, SquitterVelocity};
use crate::gateways::time_of_day;

/// Maximum time between the two frames of a pair, in the air and on the ground, in nanoseconds. Aircraft on the ground are
/// slower.
const PAIR_NS: [i64; 2] = [10 * SECOND, 25 * SECOND];
/// Maximum age of a place that is the reference of the next one, in nanoseconds.
const REFERENCE_NS: i64 = 60 * SECOND;
/// Maximum age of a velocity, and of its difference of altitudes, that is reported with a position, in nanoseconds.
const VELOCITY_NS: i64 = 10 * SECOND;
/// Maximum age of a Mode A code that is reported with a position, in nanoseconds; it is sent every 5 s.
const CODE_NS: i64 = 60 * SECOND;
/// Speed of the fastest aircraft, in metres per second: 1000 kt.
const FASTEST_M_S: f64 = 514.4;
/// Distance between two places that is accepted at any speed, in metres.
const SLACK_M: f64 = 1000.0;
/// Error of the time between two positions, in seconds: the delays from several receivers differ.
const TIME_ERROR_S: f64 = 1.0;
/// Maximum time after which an equal frame of the same parity is a copy by another receiver, in nanoseconds. An aircraft
/// sends frames of one parity at least 0.8 s apart.
const COPY_NS: i64 = SECOND / 2;
/// Maximum range of a receiver, in metres: 360 NM.
const FARTHEST_M: f64 = 666_720.0;
/// Metres in a foot.
const FOOT_M: f64 = 0.3048;
/// Metres per second in a knot.
const KNOT_M_S: f64 = 1852.0 / 3600.0;

/// Reason why a position gives no record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unplaced {
    /// Copy of the frame before.
    Copy,
    /// No frame of the other parity, and no place nearby.
    Alone,
    /// Impossible speed, or out of the receiver's range.
    Implausible,
}

/// State of an aircraft.
#[derive(Clone, Debug)]
pub(super) struct AdsbAircraft {
    /// Time of the last reception.
    pub(super) heard: Time,
    /// Last even and odd frames, in the air and on the ground.
    frames: [[Option<(CprPosition, Time)>; 2]; 2],
    placed: Option<(LatLonDeg, Time)>,
    /// A place inconsistent with the one before. A second one consistent with it replaces the earlier places.
    astray: Option<(LatLonDeg, Time)>,
    callsign: Option<AircraftIdentification>,
    category: Option<EmitterCategory>,
    velocity: Option<(SquitterVelocity, Time)>,
    code: Option<(u16, PriorityStatus, Time)>,
    standard: Option<Standard>,
    /// Whether the standard is stated but unknown.
    is_standard_unknown: bool,
    accuracy: Option<Accuracy>,
    supplement_a: bool,
    supplement_c: bool,
}

impl AdsbAircraft {
    /// An aircraft without any data yet.
    pub(super) fn new(heard: Time) -> Self {
        Self {
            heard,
            frames: [[None; 2]; 2],
            placed: None,
            astray: None,
            callsign: None,
            category: None,
            velocity: None,
            code: None,
            standard: None,
            is_standard_unknown: false,
            accuracy: None,
            supplement_a: false,
            supplement_c: false,
        }
    }

    /// Records the data of a squitter other than a position.
    pub(super) fn note(&mut self, contents: &SquitterContents, at: Time) {
        match *contents {
            SquitterContents::Identity { callsign, category } => {
                self.callsign = callsign.or(self.callsign);
                self.category = Some(category);
            }
            SquitterContents::Velocity(velocity) => self.velocity = Some((velocity, at)),
            SquitterContents::Status { code, priority } => self.code = Some((code, priority, at)),
            SquitterContents::Target(accuracy) => {
                // Values that this message lacks are kept from the operational status.
                let before = self.accuracy;
                self.accuracy = Some(Accuracy {
                    geometric: before.and_then(|before| before.geometric),
                    design: before.and_then(|before| before.design),
                    ..accuracy
                });
            }
            SquitterContents::Operation { standard, accuracy, supplement_a, supplement_c } => {
                self.is_standard_unknown = standard.is_none();
                self.standard = standard.or(Some(Standard::Do260C));
                self.accuracy = accuracy;
                self.supplement_a = supplement_a;
                self.supplement_c = supplement_c.unwrap_or(self.supplement_c);
            }
            SquitterContents::Position(_) | SquitterContents::Other => {}
        }
    }

    /// Place of the aircraft from this position; `receiver` is the place of the receiver.
    pub(super) fn place(
        &mut self,
        position: &SquitterPosition,
        at: Time,
        receiver: Option<LatLonDeg>,
    ) -> Result<LatLonDeg, Unplaced> {
        let ground = usize::from(position.on_ground);
        let (frame, odd) = (position.place, usize::from(position.place.odd));
        let is_copy = |(before, then): (CprPosition, Time)| before == frame && apart(at, then) < COPY_NS;
        if self.frames[ground][odd].is_some_and(is_copy) {
            return Err(Unplaced::Copy);
        }
        let partner = self.frames[ground][1 - odd].filter(|(_, then)| apart(at, *then) <= PAIR_NS[ground]);
        self.frames[ground][odd] = Some((frame, at));
        let before = self.placed.filter(|(_, then)| apart(at, *then) <= REFERENCE_NS);
        let reference = before.map(|(place, _)| place);
        let paired = partner.and_then(|(partner, _)| {
            if position.on_ground {
                cpr::surface_pair(frame, partner, reference.or(receiver)?)
            } else {
                cpr::pair(frame, partner)
            }
        });
        let near = || cpr::near(frame, position.on_ground, reference?);
        let place = paired.or_else(near).ok_or(Unplaced::Alone)?;
        if receiver.is_some_and(|receiver| cpr::distance_m(receiver, place) > FARTHEST_M) {
            return Err(Unplaced::Implausible);
        }
        let fits = |(other, then): (LatLonDeg, Time)| {
            let seconds = apart(at, then) as f64 / SECOND as f64 + TIME_ERROR_S;
            cpr::distance_m(other, place) <= SLACK_M + FASTEST_M_S * seconds
        };
        if !before.is_none_or(fits) {
            // Two consistent pairs contradict the earlier place, which was wrong.
            let confirmed = paired.is_some() && self.astray.is_some_and(fits);
            self.astray = paired.map(|place| (place, at));
            if !confirmed {
                return Err(Unplaced::Implausible);
            }
        }
        self.astray = None;
        self.placed = Some((place, at));
        Ok(place)
    }

    /// Record of a position at this place, from the sensor `source`.
    pub(super) fn record(
        &self,
        source: DataSource,
        squitter: &Squitter,
        position: &SquitterPosition,
        place: LatLonDeg,
        at: Time,
    ) -> Result<Record, BuildError> {
        let time = time_of_day(at);
        let altitude_reporting = match position.height {
            Some(height) if height.is_coarse => AltitudeReporting::Feet100,
            Some(_) => AltitudeReporting::Feet25,
            None => AltitudeReporting::Unknown,
        };
        let mut target_report = TargetReport::default()
            .with_address_type(squitter.address_type)
            .with_altitude_reporting(altitude_reporting);
        if position.on_ground {
            target_report = target_report.with_on_ground(true);
        }
        let velocity = self.velocity.filter(|(_, then)| apart(at, *then) <= VELOCITY_NS);
        // The address in a message has 24 bits.
        let address = AircraftAddress::new(squitter.address).unwrap_or_default();
        let mut builder = Record::builder(source, target_report, address)
            .fine_position(FinePosition::new(place[0], place[1]))
            .position_reception(time)
            .quality(self.quality(position, velocity.map_or(0, |(velocity, _)| velocity.category)))
            .mops_version(Some(
                MopsVersion::default()
                    .with_unsupported(self.is_standard_unknown)
                    .with_standard(self.standard.unwrap_or(Standard::Do260))
                    .with_technology(LinkTechnology::ExtendedSquitter),
            ));
        if let Some(height) = position.height {
            let feet = f64::from(height.feet);
            let above = velocity.and_then(|(velocity, _)| velocity.above_barometric_ft).map(f64::from);
            let geometric = if height.is_geometric { Some(feet) } else { above.map(|above| feet + above) };
            let barometric = if height.is_geometric { above.map(|above| feet - above) } else { Some(feet) };
            if let Some(feet) = geometric {
                builder = builder.geometric_height(GeometricHeight::default().with_height_m(feet * FOOT_M));
            }
            if let Some(feet) = barometric {
                builder = builder.flight_level(BarometricLevel::default().with_flight_level(feet / 100.0));
            }
        }
        if let Some((velocity, then)) = velocity.filter(|_| !position.on_ground) {
            if let Some(up_m_s) = velocity.climb_ft_min.map(|climb| f64::from(climb) * FOOT_M / 60.0) {
                let rate = VerticalRate::default().with_up_m_s(up_m_s);
                builder = if velocity.is_climb_barometric {
                    builder.barometric_rate(rate)
                } else {
                    builder.geometric_rate(rate)
                };
            }
            if let Some(knots) = velocity.ground_kt {
                let [east, north] = knots.map(|knots| f64::from(knots) * KNOT_M_S);
                let vector = GroundVector::new(east.hypot(north), libm::atan2(east, north).to_degrees());
                builder = builder.ground_vector(vector);
            }
            builder = builder.velocity_reception(time_of_day(then));
        }
        if let Some(callsign) = self.callsign {
            builder = builder.target_identification(Some(callsign));
        }
        if let Some(category) = self.category {
            builder = builder.emitter(Some(Emitter::default().with_category(category)));
        }
        if let Some((code, priority, _)) = self.code.filter(|(.., then)| apart(at, *then) <= CODE_NS) {
            builder = builder
                .mode_3a(Mode3A::default().with_code(code))
                .target_status(Some(TargetStatus::default().with_priority(priority)));
        }
        builder.build()
    }

    /// I021/090, from the type code and the quality data, by the aircraft's version.
    fn quality(&self, position: &SquitterPosition, velocity_category: u8) -> Option<QualityIndicators> {
        let quality = QualityIndicators::default()
            .with_velocity_category(velocity_category)?
            .with_position_category(self.position_category(position))?;
        let Some(accuracy) = self.accuracy else { return Some(quality) };
        let quality = quality
            .with_altitude_checked(accuracy.is_altitude_checked)
            .with_integrity_level(accuracy.integrity)?
            .with_accuracy_category(accuracy.position)?;
        let (Some(geometric), design) = (accuracy.geometric.or(accuracy.design.map(|_| 0)), accuracy.design)
        else {
            return Some(quality);
        };
        quality
            .with_level_per_sample(accuracy.is_per_sample)
            .with_design_assurance(design.unwrap_or(0))?
            .with_geometric_category(geometric)
    }

    /// NUCp in version 0 (DO-260 table 2-11), NIC in later ones (DO-260B table 2-14), by type code and supplements.
    fn position_category(&self, position: &SquitterPosition) -> u8 {
        let (a, b, c) = (self.supplement_a, position.supplement_b, self.supplement_c);
        match (self.standard.unwrap_or(Standard::Do260), position.kind) {
            (Standard::Do260, kind @ 5..=8) => 14 - kind,
            (Standard::Do260, kind @ 9..=18) => 18 - kind,
            (Standard::Do260, 20) => 9,
            (Standard::Do260, 21) => 8,
            (Standard::Do260, _) => 0,
            (_, 5 | 9 | 20) => 11,
            (_, 6 | 10 | 21) => 10,
            (_, 7) => 8 + u8::from(a),
            (Standard::Do260A, 8) => 0,
            (_, 8) => match (a, c) {
                (true, true) => 7,
                (false, false) => 0,
                _ => 6,
            },
            (Standard::Do260A, 11) => 8 + u8::from(a),
            (_, 11) => 8 + u8::from(a && b),
            (_, kind @ 12..=15) => 19 - kind,
            (Standard::Do260A, 16) => 2 + u8::from(a),
            (_, 16) => 2 + u8::from(a && b),
            (_, 17) => 1,
            _ => 0,
        }
    }
}

fn apart(a: Time, b: Time) -> i64 {
    a.nanos().saturating_sub(b.nanos()).saturating_abs()
}
