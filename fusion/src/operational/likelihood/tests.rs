use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use super::*;
use crate::operational::{ASSOCIATE_LLR, DISSOCIATE_LLR};
use crate::time::SECOND;

/// Errors of a radar by its data sheet: bias and white noise.
fn sheet() -> RadarErrors {
    RadarErrors::of_data_sheet(5.0, 1.0, 10.0)
}

fn radar() -> RadarSettings {
    RadarSettings::from(&crate::settings::Radar { errors: sheet(), ..crate::settings::Radar::default() })
}

/// A radar that detects an object at this distance with this period.
struct Watch {
    range_m: f64,
    period_s: f64,
}

/// Near, medium and far; four times a second and every 1.5 s.
const WATCHES: [Watch; 6] = [
    Watch { range_m: 300.0, period_s: 0.25 },
    Watch { range_m: 1500.0, period_s: 0.25 },
    Watch { range_m: 4000.0, period_s: 0.25 },
    Watch { range_m: 300.0, period_s: 1.5 },
    Watch { range_m: 1500.0, period_s: 1.5 },
    Watch { range_m: 4000.0, period_s: 1.5 },
];

impl Watch {
    /// The pair after each plot of this duration; `offset` is outward, clockwise and up at a second, metres.
    fn pair(&self, seconds: f64, mut offset: impl FnMut(f64) -> [f64; AXES]) -> Vec<(f64, PairLikelihood)> {
        let bias = TransponderBias { horizontal_m2: 4.0, vertical_m2: 20.0, time_s2: 0.0 };
        let mut pair = PairLikelihood::default();
        let after_plot = |index: usize| {
            let second = index as f64 * self.period_s;
            let offset = PlotOffset::new(offset(second).map(Some), self.range_m, &radar(), 1.5, &bias);
            pair.add(&offset, Time::from_nanos((second * SECOND as f64) as i64), self.period_s);
            pair.penalise(&offset);
            (second, pair)
        };
        (0..(seconds / self.period_s) as usize).map(after_plot).collect()
    }

    /// One aircraft for a minute, seen by a radar whose errors are a multiple of its data sheet's.
    fn one_aircraft(&self, scale: f64, seed: u64) -> Vec<(f64, PairLikelihood)> {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = move || (0..12).map(|_| random.random_range(0.0..1.0_f64)).sum::<f64>() - 6.0;
        let errors = sheet();
        let bias_m = [errors.bias_range_m, self.range_m * errors.bias_azimuth, errors.bias_height_m];
        let white_m = [errors.noise_range_m, self.range_m * errors.noise_azimuth, errors.noise_height_m];
        let kept = (-self.period_s / errors.correlation_s).exp();
        let mut slow = bias_m.map(|metres| scale * metres * normal());
        self.pair(60.0, |_| {
            std::array::from_fn(|axis| {
                let change = (1.0 - kept * kept).sqrt() * scale * bias_m[axis];
                slow[axis] = kept * slow[axis] + change * normal();
                slow[axis] + scale * white_m[axis] * normal()
            })
        })
    }
}

fn total(pair: &PairLikelihood) -> f64 {
    pair.total().unwrap()
}

#[test]
fn constant_small_offset_supports_one_aircraft() {
    for watch in WATCHES {
        for offset_m in [0.0, 1.0, 2.0] {
            let after = watch.pair(60.0, |_| [offset_m, -offset_m, offset_m]);
            let mut least = 0.0;
            for (second, pair) in &after {
                assert!(pair.llr >= least, "{} m, {second} s, {pair:?}", watch.range_m);
                least = (pair.llr - 0.1).max(least);
            }
            let (_, last) = after.last().unwrap();
            assert!(total(last) >= PAIR_LLR_MAX - 0.5, "{} m, {offset_m} m: {last:?}", watch.range_m);
        }
    }
}

#[test]
fn one_aircraft_is_one_however_good_the_radar_is() {
    for watch in WATCHES {
        for scale in [0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0] {
            let (mut plots, mut joined, mut parted) = (0, 0, 0);
            for seed in 0..20 {
                for (second, pair) in watch.one_aircraft(scale, seed) {
                    if second >= 5.0 {
                        plots += 1;
                        joined += usize::from(total(&pair) >= ASSOCIATE_LLR);
                        parted += usize::from(total(&pair) <= DISSOCIATE_LLR);
                    }
                }
            }
            let share = |count: usize| count as f64 / f64::from(plots);
            let Watch { range_m, period_s } = watch;
            let of = format!("{scale} × the data sheet, {range_m} m, {period_s} s");
            assert!(share(joined) >= 0.8, "{of}: joined {}", share(joined));
            assert!(share(parted) <= 0.05, "{of}: parted {}", share(parted));
        }
    }
}

#[test]
fn passing_aircraft_is_soon_separated() {
    for watch in &WATCHES[..2] {
        // From 120 m on one side to the other, at 12 m/s.
        let after = watch.pair(20.0, |second| [12.0 * second - 120.0, 100.0, 0.0]);
        let (_, late) = after.iter().find(|(second, _)| *second >= 5.0).unwrap();
        assert!(total(late) <= DISSOCIATE_LLR, "{late:?}");
        // At the nearest point, too.
        assert!(
            after.iter().filter(|(second, _)| *second >= 5.0).all(|(_, pair)| total(pair) < ASSOCIATE_LLR)
        );
    }
}

#[test]
fn aircraft_in_formation_is_separated_by_a_precise_radar() {
    let after = WATCHES[1].pair(20.0, |_| [100.0, 100.0, 0.0]);
    assert!(after.iter().skip(4).all(|(_, pair)| total(pair) <= DISSOCIATE_LLR), "{after:?}");
}

#[test]
fn a_track_that_walks_off_is_let_go() {
    for velocity in [[8.0, 0.0, 0.0], [-8.0, 8.0, 0.0]] {
        let after = WATCHES[1].pair(40.0, |second| velocity.map(|speed| speed * (second - 30.0).max(0.0)));
        let at = |wanted: f64| after.iter().find(|(second, _)| *second >= wanted).unwrap().1;
        assert!(total(&at(29.0)) >= ASSOCIATE_LLR);
        assert!(total(&at(37.0)) <= DISSOCIATE_LLR, "{:?}", at(37.0));
    }
}

impl PairLikelihood {
    /// A compared pair with this sum.
    pub(in crate::operational) fn with_llr(llr: f64, last_likely: Option<Time>) -> Self {
        let scales = Scales::of_data_sheet();
        let errors = PlotErrors {
            bias_m: 1.0,
            white_m: 1.0,
            sheet_white_m: 1.0,
            curve_m: 1.0,
            transponder_m2: 1.0,
            scales,
        };
        let expected = Some(SEPARATIONS.map(|separation| OffsetAxis::new(&errors, &separation)));
        Self { llr, last_likely, bias_penalty: 0.0, expected }
    }
}
