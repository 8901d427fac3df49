//! Reads a recording: the reports of each sensor, and the picture that is made of them.

use std::collections::BTreeMap;

use crate::evaluate::{OutputPoint, Truth, fix_point, plot_point};
use fusion::registration::{BiasValue, Misalignment};
use fusion::time::Time;
use fusion::{Emission, Identity, Report, SensorIndex};
use input::capture::{ReadError, Reception, ReceptionKind};
use input::pipeline::{Event, Output, Pipeline, Tally};
use picture::{PictureMaker, PictureSeries, UncooperativeDetector};
use site::areas::Masks;
use site::config::Config;

/// A recording, processed once by the engine.
#[derive(Clone, Debug, Default)]
pub struct AssessedRecording {
    /// Reports of each sensor of the configuration, in order of reception.
    pub sensors: Vec<SensorRecording>,
    /// The picture as `replay` writes it.
    pub picture: Vec<OutputPoint>,
    /// First and last time of reception.
    pub span: Option<(Time, Time)>,
    /// Records without a report, by sensor (if known) and reason.
    pub refused: BTreeMap<(Option<usize>, &'static str), u64>,
    /// Counters of what was received.
    pub tally: Tally,
    /// Misalignments that the registration estimates at the end, by sensor.
    pub registered: BTreeMap<usize, Misalignment>,
}

/// Reports of a sensor.
#[derive(Clone, Debug, Default)]
pub struct SensorRecording {
    /// Reports with a position that the engine takes.
    pub reports: Vec<SensorReport>,
    /// Number of reports without a position: bearings of cameras.
    pub bearings: u64,
}

/// A report of a sensor.
#[derive(Clone, Debug)]
pub struct SensorReport {
    /// Position at its own time. The number is the radar's track number, or that of the transponder in order of appearance.
    pub point: OutputPoint,
    /// Time of reception; `None` if the file does not state it.
    pub received: Option<Time>,
    /// Probability that the target is a drone, if the radar states it.
    pub uav_probability: Option<f64>,
}

impl AssessedRecording {
    /// Processes a recording as `replay` does, without a saved state.
    ///
    /// # Errors
    /// The recording cannot be read to its end.
    pub fn read(
        receptions: impl Iterator<Item = Result<Reception, ReadError>>,
        config: &Config,
        masks: Masks,
        detector: UncooperativeDetector,
    ) -> Result<Self, ReadError> {
        let mut pipeline = Pipeline::new(config, masks);
        pipeline.engine_mut().keep_numbers_for_good();
        let normaliser = pipeline.normaliser().clone();
        let maker = PictureMaker::new(config, &normaliser);
        let mut series = PictureSeries::new(maker.clone(), detector);
        let mut read =
            Self { sensors: vec![SensorRecording::default(); config.sensors.len()], ..Self::default() };
        let mut numbers: BTreeMap<Identity, u32> = BTreeMap::new();
        let mut publish = |emission: Emission, picture: &mut Vec<OutputPoint>| {
            let (published, _) = series.pictures(emission, false);
            let tracks = published.within(config.output.max_accuracy_m);
            picture.extend(tracks.map(|track| OutputPoint::of_track(track, &maker)));
        };
        for reception in receptions {
            let reception = reception?;
            let received = reception.received;
            let stated = received.filter(|_| reception.kind == ReceptionKind::Datagram);
            if let Some(received) = received {
                let (first, last) = read.span.unwrap_or((received, received));
                read.span = Some((first.min(received), last.max(received)));
            }
            pipeline.receive(&reception);
            while let Some(output) = pipeline.poll() {
                let event = match output {
                    Output::Emission(emission) => {
                        publish(emission, &mut read.picture);
                        continue;
                    }
                    Output::Event(event) => event,
                };
                match event {
                    Event::Accepted { sensor, report } => {
                        let of_sensor = &mut read.sensors[usize::from(sensor.0)];
                        let (point, uav_probability) = match &report {
                            Report::Plot(plot) => {
                                (plot_point(plot, &normaliser, &maker), plot.uav_probability)
                            }
                            Report::Fix(fix) => {
                                let next = numbers.len() as u32 + 1;
                                let number = *numbers.entry(fix.identity).or_insert(next);
                                (fix_point(fix, number, &normaliser), None)
                            }
                            Report::Bearing(_) => {
                                of_sensor.bearings += 1;
                                continue;
                            }
                        };
                        of_sensor.reports.push(SensorReport { point, received: stated, uav_probability });
                    }
                    Event::Refused { sensor, refusal } => {
                        let sensor = sensor.map(|sensor| usize::from(sensor.0));
                        *read.refused.entry((sensor, refusal.name())).or_default() += 1;
                    }
                    Event::DuplicateDatagram => {
                        *read.refused.entry((None, "repeated_datagram")).or_default() += 1;
                    }
                    Event::Faulty { .. } | Event::FaultyLine { .. } => {
                        *read.refused.entry((None, "unreadable")).or_default() += 1;
                    }
                    _ => {}
                }
            }
        }
        pipeline.finish();
        let last: Vec<Emission> = pipeline.emissions().collect();
        last.into_iter().for_each(|emission| publish(emission, &mut read.picture));
        let registered = pipeline.engine().registered();
        let of_sensor = |(sensor, registered): (SensorIndex, &fusion::operational::Registered)| {
            (usize::from(sensor.0), registered.estimate)
        };
        read.registered = registered.map(of_sensor).collect();
        read.tally = pipeline.tally().clone();
        Ok(read)
    }

    /// The transponders' own reports as a truth, by identity.
    pub fn transponders(&self) -> Truth {
        let reports = self.sensors.iter().flat_map(|sensor| &sensor.reports);
        let mut tracks: BTreeMap<String, Vec<_>> = BTreeMap::new();
        for SensorReport { point, .. } in reports {
            if let Some(identity) = &point.identity {
                tracks.entry(identity.clone()).or_default().push((point.time, point.place));
            }
        }
        Truth::new(tracks)
    }
}

/// Names, units and values of a misalignment; angles in degrees.
pub(super) fn biases(estimate: &Misalignment) -> [(&'static str, &'static str, BiasValue); 6] {
    let degrees = |of: BiasValue| BiasValue {
        value: of.value.to_degrees(),
        deviation: of.deviation.to_degrees(),
        observable: of.observable,
    };
    [
        ("bearing", "°", degrees(estimate.bearing)),
        ("tilt about east", "°", degrees(estimate.tilt_east)),
        ("tilt about north", "°", degrees(estimate.tilt_north)),
        ("range", "m", estimate.range_m),
        ("height", "m", estimate.height_m),
        ("time", "s", estimate.time_s),
    ]
}
