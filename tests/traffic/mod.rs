//! Endless, repeatable traffic for benchmarks and the memory test. Every target circles among four others, radars see it at 4 Hz,
//! and equipped targets report their position every 2 s. Nothing is stored: the reports of a slot are computed.

use std::f64::consts::TAU;

use fusion::frames::RadarFrame;
use fusion::settings::{OperationalRules, Radar, Receiver, ReferenceRules, Sensor};
use fusion::time::{SECOND, Time};
use fusion::{Engine, Enu, Fix, Identity, Plot, Profile, RadarTrackKey, Report, SensorIndex, Settings};

/// Length of a slot, in nanoseconds.
pub const SLOT_NS: i64 = SECOND / 4;
/// Slots between two reports of a transponder: 2 s.
const FIX_SLOTS: i64 = 8;
/// Time from a transponder's report, at the start of its slot, to its reception, in nanoseconds.
const LATENCY_NS: i64 = 3 * SECOND / 10;
/// Number of targets that circle about one place.
const GROUP: u64 = 5;
/// Side, in metres, of a square for 110 targets; the area grows with the number of targets.
const SIDE_M: f64 = 7_000.0;
/// Spacing of the grid of radars, in metres, with one at the origin. Each group is seen by one radar, within about 5 km.
const SITES_M: f64 = 7_000.0;

/// The traffic.
#[derive(Clone, Copy, Debug)]
pub struct Traffic {
    /// Number of targets, each with a radar track.
    pub targets: u64,
    /// Number of targets that are drones with a transponder, the first ones; the others are birds.
    pub drones: u64,
}

impl Traffic {
    /// 50 drones and 60 birds within 5 km of one radar.
    pub const DENSE: Self = Self { targets: 110, drones: 50 };

    /// The reports of `slot`, all received by [`Self::received`].
    pub fn reports(self, slot: i64) -> impl Iterator<Item = Report> {
        (0..self.targets).flat_map(move |target| {
            let is_due = target < self.drones && (slot + target as i64) % FIX_SLOTS == 0;
            let fix = is_due.then(|| Report::Fix(self.fix(target, slot)));
            fix.into_iter().chain([Report::Plot(self.plot(target, slot))])
        })
    }

    /// Time at which the reports of `slot` are received: after its end.
    pub fn received(slot: i64) -> Time {
        Time::from_nanos(slot * SLOT_NS + LATENCY_NS)
    }

    /// Settings of the `reference` profile, for these radars followed by one transponder receiver.
    pub fn reference(self) -> Settings {
        let radars = self
            .sites()
            .map(|origin| Sensor::Radar(Radar { frame: RadarFrame::parallel(origin), ..Radar::default() }));
        let receiver = Sensor::Receiver(Receiver { period_s: 3.0, ..Receiver::default() });
        Settings {
            sensors: radars.chain([receiver]).collect(),
            profile: Profile::Reference(ReferenceRules::default()),
            ..Settings::default()
        }
    }

    /// Settings of the `operational` profile, for these radars followed by one transponder receiver.
    pub fn operational(self) -> Settings {
        Settings { profile: Profile::Operational(OperationalRules::default()), ..self.reference() }
    }

    /// Side of the square over which the targets fly, in metres.
    fn side_m(self) -> f64 {
        SIDE_M * (self.targets as f64 / 110.0).sqrt()
    }

    /// Number of radars on each side of the origin.
    fn sites_beside(self) -> i64 {
        (self.side_m() / 2.0 / SITES_M - 0.5).ceil() as i64
    }

    /// Sites of the radars, row by row from the south-west.
    fn sites(self) -> impl Iterator<Item = Enu> {
        let beside = self.sites_beside();
        let along = move || (-beside..=beside).map(|site| site as f64 * SITES_M);
        along().flat_map(move |north| along().map(move |east| Enu::new(east, north, 0.0)))
    }

    /// The radar that sees a target, and its site.
    fn radar(self, target: u64) -> (SensorIndex, Enu) {
        let beside = self.sites_beside();
        let nearest = |metres: f64| ((metres / SITES_M).round() as i64).clamp(-beside, beside);
        let place = self.group_place(target / GROUP);
        let (east, north) = (nearest(place.east()), nearest(place.north()));
        let index = (north + beside) * (2 * beside + 1) + east + beside;
        (SensorIndex(index as u16), Enu::new(east as f64 * SITES_M, north as f64 * SITES_M, 0.0))
    }

    fn fix(self, target: u64, slot: i64) -> Fix {
        let time = Time::from_nanos(slot * SLOT_NS);
        let identity = Identity::new(format!("{:05}", target + 1).as_bytes(), None).expect("it has digits");
        Fix::new(SensorIndex(self.sites().count() as u16), identity, time, self.place(target, time))
    }

    /// A plot with errors of 5 m in range, 1° in azimuth and 10 m in height.
    fn plot(self, target: u64, slot: i64) -> Plot {
        // Every target is detected at its own 1/128 s of the slot.
        let time = Time::from_nanos(slot * SLOT_NS + (target % 32) as i64 * (SLOT_NS / 32));
        let mut position = self.place(target, time).0;
        let (sensor, site) = self.radar(target);
        let (east, north) = (position.x - site.east(), position.y - site.north());
        let [range_error, azimuth_error, height_error, luck] = [0, 1, 2, 3]
            .map(|which| noise(target ^ (slot as u64).wrapping_mul(0x5851_F42D_4C95_7F2D) ^ (which << 60)));
        let range = east.hypot(north) + 5.0 * range_error;
        let azimuth = east.atan2(north) + azimuth_error.to_radians();
        position.x = site.east() + range * azimuth.sin();
        position.y = site.north() + range * azimuth.cos();
        position.z += 10.0 * height_error;
        // Half the plots of a bird resemble a drone.
        let is_uav = target < self.drones || luck > 0.0;
        Plot {
            track: RadarTrackKey { sensor, number: target as u16 },
            time,
            position: position.into(),
            height_measured: true,
            slant_range_m: range.hypot(position.z),
            uav_probability: Some(if is_uav { 0.8 } else { 0.0 }),
            velocity: None,
        }
    }

    /// Position on a circle of 50 to 250 m about the place of the group, with a period of a minute or two.
    fn place(self, target: u64, time: Time) -> Enu {
        let middle = self.group_place(target / GROUP);
        let radius = 50.0 * (1 + target % GROUP) as f64;
        let period_s = 60.0 * (1 + target % 2) as f64;
        let turns = (time.nanos() % (120 * SECOND)) as f64 / SECOND as f64 / period_s;
        let angle = TAU * (turns + unit(target));
        let height_m = 50.0 + 70.0 * unit(target << 16);
        Enu::new(middle.east() + radius * angle.cos(), middle.north() + radius * angle.sin(), height_m)
    }

    fn group_place(self, group: u64) -> Enu {
        let along = |seed| self.side_m() * (unit(seed) - 0.5);
        Enu::new(along(group << 32), along((group << 32) + 1), 0.0)
    }
}

/// Feeds one slot of traffic to the engine; returns the number of points emitted.
pub fn feed(engine: &mut Engine, slot: i64, reports: impl IntoIterator<Item = Report>) -> usize {
    let points = engine.advance(Traffic::received(slot)).map(|emission| emission.points.len()).sum();
    for report in reports {
        engine.handle(report).expect("the traffic is in time");
    }
    points
}

/// A pseudo-random number from 0 to 1 (SplitMix64).
fn unit(seed: u64) -> f64 {
    let mut z = seed.wrapping_add(1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// An error of mean 0 and variance 1, bounded.
fn noise(seed: u64) -> f64 {
    12.0_f64.sqrt() * (unit(seed) - 0.5)
}
