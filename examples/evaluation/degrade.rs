//! Degrades a clean transponder to real conditions: noise, delay, drops, and gaps of 30 to 60 s.

use std::collections::BTreeMap;

use asterix::cat129::{self, Altitude, Position};
use asterix::{Record, blocks, encode_block};
use fusion::time::Time;
use jiff::SignedDuration;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use utm_fusion::capture::Reception;

/// Position noise per axis, one standard deviation, metres. Nine tenths of it are a slow drift, as in
/// `docs/SIMULATION.md`.
const SLOW_M: f64 = 1.8;
const WHITE_M: f64 = 0.5;
/// Time constant of the drift, seconds.
const SLOW_S: f64 = 60.0;
/// Share of reports that are lost.
const DROPPED: f64 = 0.1;
/// Additional delay from transponder to service, seconds.
const DELAY_S: (f64, f64) = (0.3, 1.5);
/// Duration of gaps, seconds. `BETWEEN_GAPS_S` is the time between two gaps.
const GAP_S: (f64, f64) = (30.0, 60.0);
const BETWEEN_GAPS_S: (f64, f64) = (60.0, 120.0);
/// Approximate length of a degree of latitude, metres; accurate enough for noise.
const METRES_A_DEGREE: f64 = 111_200.0;

/// State of one transponder.
struct DegradedTransponder {
    random: ChaCha8Rng,
    drift_m: [f64; 3],
    last: Time,
    /// The next gap: from, until.
    gap: (Time, Time),
}

/// Degrades every CAT129 report; everything else stays as it was. In order of reception.
pub fn degraded(receptions: Vec<Reception>, seed: u64) -> Vec<Reception> {
    let mut transponders: BTreeMap<[u8; 12], DegradedTransponder> = BTreeMap::new();
    let mut out: Vec<Reception> =
        receptions.into_iter().filter_map(|reception| worse(reception, seed, &mut transponders)).collect();
    out.sort_by_key(|reception| reception.received); // stable
    out
}

/// `None` if the report is lost. The recordings have one report per datagram.
fn worse(
    reception: Reception,
    seed: u64,
    transponders: &mut BTreeMap<[u8; 12], DegradedTransponder>,
) -> Option<Reception> {
    let is_report = |block: &asterix::Block<'_>| block.category == cat129::Record::CATEGORY;
    let report = blocks(&reception.payload).find_map(|block| block.ok().filter(is_report));
    let (Some(block), Some(received)) = (report, reception.received) else { return Some(reception) };
    let mut record = block.records::<cat129::Record>().find_map(Result::ok)?.record;
    let serial = record.serial_number?;
    let number = transponders.len() as u64;
    let transponder =
        transponders.entry(serial).or_insert_with(|| DegradedTransponder::new(seed << 8 | number, received));
    let moved_m = transponder.error_at(received);
    let delay_s = transponder.between(DELAY_S);
    if transponder.is_lost(received) {
        return None;
    }
    let (position, altitude) = (record.position?, record.altitude_amsl?);
    let latitude_deg = position.latitude_deg() + moved_m[0] / METRES_A_DEGREE;
    let east_deg = moved_m[1] / METRES_A_DEGREE / latitude_deg.to_radians().cos();
    record.position = Position::new(latitude_deg, position.longitude_deg() + east_deg);
    record.altitude_amsl = Altitude::from_metres(altitude.metres() + moved_m[2]);
    let mut payload = Vec::new();
    encode_block(&[record], &mut payload).ok()?;
    let received = received + SignedDuration::from_nanos((delay_s * 1e9) as i64);
    Some(Reception { received: Some(received), payload, ..reception })
}

impl DegradedTransponder {
    fn new(seed: u64, first: Time) -> Self {
        let mut new = Self {
            random: ChaCha8Rng::seed_from_u64(seed),
            drift_m: [0.0; 3],
            last: first,
            gap: (first, first),
        };
        new.drift_m = [(); 3].map(|()| SLOW_M * new.normal());
        new
    }

    fn normal(&mut self) -> f64 {
        StandardNormal.sample(&mut self.random)
    }

    fn between(&mut self, (low, high): (f64, f64)) -> f64 {
        low + (high - low) * self.random.random::<f64>()
    }

    /// Error north, east, up, metres.
    fn error_at(&mut self, time: Time) -> [f64; 3] {
        let kept = (-time.seconds_since(self.last) / SLOW_S).exp();
        self.last = time;
        [0, 1, 2].map(|axis| {
            self.drift_m[axis] =
                kept * self.drift_m[axis] + SLOW_M * (1.0 - kept * kept).sqrt() * self.normal();
            self.drift_m[axis] + WHITE_M * self.normal()
        })
    }

    fn is_lost(&mut self, time: Time) -> bool {
        let after = |time: Time, seconds: f64| time + SignedDuration::from_nanos((seconds * 1e9) as i64);
        while time >= self.gap.1 {
            let from = after(self.gap.1, self.between(BETWEEN_GAPS_S));
            self.gap = (from, after(from, self.between(GAP_S)));
        }
        self.random.random::<f64>() < DROPPED || time >= self.gap.0
    }
}
