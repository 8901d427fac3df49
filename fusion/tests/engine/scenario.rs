//! Random scenarios: a few aircraft and radar tracks near each other; reports late, ahead, duplicated, out of order.

use jiff::SignedDuration;
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::sample::Index;
use utm_fusion_engine::report::{Bearing, UasItems};
use utm_fusion_engine::settings::{Radar, Receiver, ReferenceRules, Sensor};
use utm_fusion_engine::time::{SECOND, Time};
use utm_fusion_engine::{
    Emission, Engine, Enu, Fix, Identity, Plot, Profile, RadarTrackKey, Report, SensorIndex, Settings,
};

/// One reception with its report.
#[derive(Clone, Debug)]
pub struct Arrival {
    pub received: Time,
    pub report: Report,
}

#[derive(Clone, Debug)]
pub struct Scenario {
    pub arrivals: Vec<Arrival>,
    pub max_gap_s: i64,
    pub suppress_slots: i64,
}

pub const SLOT_NS: i64 = SECOND / 4;
const START: i64 = 1_700_000_000;
/// Position until a target sets one.
const NOWHERE: Enu = Enu::new(0.0, 0.0, 0.0);

/// Periods of the two radars, seconds; the transponder receiver has the index after them.
pub const PERIODS_S: [f64; 2] = [0.25, 1.3];

pub fn settings(scenario: &Scenario) -> Settings {
    let radar = |period_s| Sensor::Radar(Radar { period_s, ..Radar::default() });
    Settings {
        sensors: PERIODS_S.map(radar).into_iter().chain([Sensor::Receiver(Receiver::default())]).collect(),
        transponder_numbers: [(b"U2".to_vec(), 1)].into(),
        profile: Profile::Reference(ReferenceRules {
            max_gap: SignedDuration::from_secs(scenario.max_gap_s),
            suppress_slots: scenario.suppress_slots,
            ..ReferenceRules::default()
        }),
        ..Settings::default()
    }
}

/// Runs the engine over the arrivals, to the end of the input.
pub fn run(settings: &Settings, arrivals: &[Arrival]) -> Vec<Emission> {
    let mut engine = Engine::new(settings.clone()).unwrap();
    let mut emissions = Vec::new();
    for arrival in arrivals {
        emissions.extend(engine.advance(arrival.received));
        let _ = engine.handle(arrival.report);
    }
    emissions.extend(engine.finish());
    emissions
}

impl Arrival {
    /// A second report of the same track or identity and time, at another position.
    fn again(&self, delay_ms: i64, shift_m: f64) -> Self {
        let shifted = |position: Enu| Enu::new(position.east() + shift_m, position.north(), position.up());
        let report = match self.report {
            Report::Plot(plot) => Report::Plot(Plot { position: shifted(plot.position), ..plot }),
            Report::Fix(fix) => Report::Fix(Fix { position: shifted(fix.position), ..fix }),
            Report::Bearing(_) => self.report,
        };
        Self { received: Time::from_nanos(self.received.nanos() + delay_ms * 1_000_000), report }
    }
}

/// Position of a target at second 0, and its velocity, m/s.
type Target = ([f64; 3], [f64; 2]);

/// Two targets, transponders and radar tracks that follow them for up to a minute, stray reports, and occasionally a
/// silence that makes the engine restart with an empty window.
pub fn any() -> impl Strategy<Value = Scenario> {
    let stray = (0..60_000_i64, any_delay(), prop_oneof![any_fix(), any_plot()], any_target());
    let silence = prop_oneof![4 => Just(0), 1 => 20..40_i64];
    let config =
        (prop_oneof![4 => Just(25_i64), 1 => 2..5_i64], prop_oneof![4 => Just(16_i64), 1 => 0..30_i64]);
    (
        [any_target(), any_target()],
        vec(stream(1_800..2_200, any_fix().boxed()), 1..4),
        vec(stream(240..260, any_plot().boxed()), 1..5),
        vec(stray, 0..30),
        vec((proptest::prelude::any::<Index>(), any_delay(), -40.0..40.0_f64), 0..10),
        silence,
        config,
    )
        .prop_map(|(targets, fixes, plots, strays, doubled, silence, (max_gap_s, suppress_slots))| {
            let mut arrivals = Vec::new();
            for stream in fixes.into_iter().chain(plots) {
                let target = targets[stream.target];
                arrivals
                    .extend(stream.sendings.into_iter().map(|sending| sending.arrival(stream.first, target)));
            }
            arrivals.extend(strays.into_iter().map(|(sent_ms, delay_ms, report, target)| {
                Sending { sent_ms, delay_ms, noise_m: 0.0 }.arrival(report, target)
            }));
            for (which, delay_ms, shift_m) in doubled {
                arrivals.push(which.get(&arrivals).again(delay_ms, shift_m));
            }
            for arrival in &mut arrivals {
                if arrival.received.nanos() > (START + 30) * SECOND {
                    arrival.received = Time::from_nanos(arrival.received.nanos() + silence * SECOND);
                    arrival.report = moved(arrival.report, silence * SECOND);
                }
            }
            arrivals.sort_by_key(|arrival| arrival.received);
            Scenario { arrivals, max_gap_s, suppress_slots }
        })
}

#[derive(Clone, Debug)]
struct Stream {
    target: usize,
    first: Report,
    sendings: Vec<Sending>,
}

#[derive(Clone, Debug)]
struct Sending {
    sent_ms: i64,
    delay_ms: i64,
    noise_m: f64,
}

impl Sending {
    /// Reception of `report` as sent then, from the target's position.
    fn arrival(&self, report: Report, (start, velocity): Target) -> Arrival {
        let sent = START * SECOND + self.sent_ms * 1_000_000;
        let seconds = self.sent_ms as f64 / 1000.0;
        let position = Enu::new(
            start[0] + velocity[0] * seconds + self.noise_m,
            start[1] + velocity[1] * seconds - self.noise_m,
            start[2] + self.noise_m / 2.0,
        );
        let report = match report {
            Report::Plot(plot) => Report::Plot(Plot { position, slant_range_m: position.0.norm(), ..plot }),
            Report::Fix(fix) => Report::Fix(Fix { position, ..fix }),
            Report::Bearing(_) => report,
        };
        // ASTERIX counts 1/128 s.
        let time = sent - sent.rem_euclid(7_812_500);
        Arrival {
            received: Time::from_nanos(sent + self.delay_ms * 1_000_000 + 1_000_000),
            report: moved(report, time),
        }
    }
}

/// Reports of one target about every `period_ms`, often exactly in the middle of it, with gaps and noise.
fn stream(period_ms: std::ops::Range<i64>, first: BoxedStrategy<Report>) -> impl Strategy<Value = Stream> {
    let steps = 60_000 / period_ms.end;
    let noise = prop_oneof![9 => -20.0..20.0_f64, 1 => -100.0..100.0_f64];
    let each = vec((any_delay(), 0..10_u8, noise), steps as usize);
    let middle = Just(i64::midpoint(period_ms.start, period_ms.end));
    let period_ms = prop_oneof![period_ms, middle];
    (0..2_usize, first, period_ms, 0..30_000_i64, each).prop_map(
        |(target, first, period_ms, phase_ms, each)| {
            let heard = |step: usize, luck| luck > 1 || (luck == 1 && step % 20 < 10);
            let sendings = each
                .into_iter()
                .enumerate()
                .filter(|&(step, (_, luck, _))| heard(step, luck))
                .map(|(step, (delay_ms, _, noise_m))| Sending {
                    sent_ms: phase_ms + step as i64 * period_ms,
                    delay_ms,
                    noise_m,
                })
                .collect();
            Stream { target, first, sendings }
        },
    )
}

/// A target close enough to the other that gates, cells and thresholds are often crossed.
fn any_target() -> impl Strategy<Value = Target> {
    let start = (-150.0..150.0_f64, 200.0..500.0_f64, 50.0..90.0_f64).prop_map(|(e, n, u)| [e, n, u]);
    (start, (-10.0..10.0_f64, -10.0..10.0_f64).prop_map(|(e, n)| [e, n]))
}

/// Milliseconds from a report's time to its reception: mostly short, sometimes up to and past the window, or ahead.
fn any_delay() -> impl Strategy<Value = i64> {
    prop_oneof![12 => 20..500_i64, 3 => 0..7_000_i64, 1 => 0..30_000_i64, 1 => -1_000..0_i64]
}

fn any_fix() -> impl Strategy<Value = Report> {
    (0..3_u8, 0..2_u8).prop_map(|(name, model)| {
        let serial_number = [b'U', b'1' + name, b' ', b' ', b' ', b' ', b' ', b' ', b' ', b' ', b' ', b' '];
        let identity = Identity::new(&serial_number, None).unwrap();
        Report::Fix(Fix {
            items: UasItems {
                manufacturer: None,
                model: Some([b'M', b'0', b'0' + model]),
                serial_number,
                registration_country: None,
            },
            ..Fix::new(SensorIndex(2), identity, Time::default(), NOWHERE)
        })
    })
}

fn any_plot() -> impl Strategy<Value = Report> {
    let probability = prop_oneof![4 => Just(Some(0.7)), 1 => Just(Some(0.0)), 1 => Just(None)];
    (0..2_u16, 1..4_u16, prop::bool::weighted(0.9), probability).prop_map(
        |(sensor, number, height_measured, uav_probability)| {
            Report::Plot(Plot {
                track: RadarTrackKey { sensor: SensorIndex(sensor), number },
                time: Time::default(),
                position: NOWHERE,
                height_measured,
                slant_range_m: 0.0,
                uav_probability,
                velocity: None,
            })
        },
    )
}

fn moved(report: Report, by_ns: i64) -> Report {
    let time = Time::from_nanos(report.time().nanos() + by_ns);
    match report {
        Report::Plot(plot) => Report::Plot(Plot { time, ..plot }),
        Report::Fix(fix) => Report::Fix(Fix { time, ..fix }),
        Report::Bearing(bearing) => Report::Bearing(Bearing { time, ..bearing }),
    }
}

/// Removes cases in which the order of reception matters: two reports with equal (identity or radar track, time), of
/// which the last received counts, and a silence about as long as the window, whose length depends on the first report
/// after it.
pub fn indifferent_to_order(mut arrivals: Vec<Arrival>) -> Vec<Arrival> {
    const WINDOW_NS: i64 = 25 * SECOND;
    for next in 1..arrivals.len() {
        let silence_ns = arrivals[next].received.nanos() - arrivals[next - 1].received.nanos();
        if (silence_ns - WINDOW_NS).abs() < SECOND {
            for arrival in &mut arrivals[next..] {
                arrival.received = Time::from_nanos(arrival.received.nanos() + 2 * SECOND);
                arrival.report = moved(arrival.report, 2 * SECOND);
            }
        }
    }
    let mut seen = std::collections::BTreeSet::new();
    arrivals.retain_mut(|arrival| match &mut arrival.report {
        Report::Plot(plot) => seen.insert((plot.time, plot.track.sensor.0, plot.track.number)),
        Report::Fix(fix) => {
            fix.items.model = None;
            seen.insert((fix.time, 99, u16::from(fix.identity.name()[1])))
        }
        Report::Bearing(bearing) => seen.insert((bearing.time, bearing.track.sensor.0, bearing.track.number)),
    });
    arrivals
}

/// The same arrivals, shuffled among those received between the making of two successive slots, which is `lead` before
/// their deadlines.
pub fn permuted(arrivals: &[Arrival], lead: SignedDuration, mut seed: u64) -> Vec<Arrival> {
    let mut shuffled: Vec<(i64, u64, Arrival)> = arrivals
        .iter()
        .map(|arrival| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            ((arrival.received + lead).nanos().div_euclid(SLOT_NS), seed >> 33, arrival.clone())
        })
        .collect();
    shuffled.sort_by_key(|&(slot, luck, _)| (slot, luck));
    shuffled.into_iter().map(|(_, _, arrival)| arrival).collect()
}
