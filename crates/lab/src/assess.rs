//! Assesses a recording: what it shows of each sensor and of the fused picture, with confidence intervals.
//!
//! Sans-IO. The definitions are in `docs/ASSESS.md`; errors, owners of points and slots that count are those of [`crate::evaluate`].

mod accuracy;
mod alignment;
mod bins;
mod bootstrap;
mod compare;
mod coverage;
mod detection;
mod html;
mod identification;
mod integrity;
mod latency;
mod limits;
mod recording;
mod scene;
mod subject;
mod tracking;
mod types;

use std::collections::BTreeMap;

pub use bootstrap::REPLICATES;
pub use compare::{ComparedFigure, Verdict, compare};
pub use html::html;
pub use recording::{AssessedRecording, SensorRecording, SensorReport};
pub use types::{
    AssessedFile, Assessment, AssessmentFigure, AssessmentReport, AssessmentSection, FigureTable,
    IntervalMethod, Limit, Provenance, ReferenceKind,
};

use crate::evaluate::{GeodeticPlace, OutputPoint, Truth};
use fusion::slots::SlotGrid;
use scene::AssessmentScene;
use site::config::{Config, SensorKind};
use subject::{AssessedSubject, SubjectKind};

/// Reference of an assessment.
#[derive(Clone, Copy, Debug)]
pub struct AssessmentReference<'a> {
    /// True paths; `None`: the reports of transponders in the recording.
    pub truth: Option<&'a Truth>,
    /// Class of each aircraft of the truth, if stated.
    pub classes: &'a BTreeMap<String, String>,
    /// Seed of the bootstrap's draws.
    pub seed: u64,
}

/// Assesses a recording of the site of `config`.
pub fn assess(
    recording: &AssessedRecording,
    config: &Config,
    reference: AssessmentReference<'_>,
) -> Assessment {
    let (latitude_deg, longitude_deg, height_amsl_m) = config.origin();
    let origin = GeodeticPlace { latitude_deg, longitude_deg, altitude_amsl_m: Some(height_amsl_m) };
    let grid = SlotGrid::new(config.fusion.slot);
    let reports = recording.transponders();
    let against = match reference.truth {
        Some(truth) => (truth, ReferenceKind::Truth),
        None => (&reports, ReferenceKind::Transponders),
    };
    let mut scene = AssessmentScene::new(against, reference.classes, grid, origin, reference.seed);
    let points: Vec<Vec<OutputPoint>> = (recording.sensors.iter())
        .map(|sensor| sensor.reports.iter().map(|report| report.point.clone()).collect())
        .collect();
    let subjects: Vec<AssessedSubject<'_>> = (config.sensors.iter().zip(&recording.sensors).zip(&points))
        .filter(|((sensor, _), _)| !matches!(sensor.kind, SensorKind::Camera(_)))
        .map(|((sensor, read), points)| AssessedSubject::of_sensor(&scene, sensor, &read.reports, points))
        .collect();
    for subject in subjects.iter().filter(|subject| subject.kind == SubjectKind::Receiver) {
        for drone in subject.scored.iter().filter_map(|point| point.drone) {
            scene.equipped[drone] = true;
        }
    }
    let picture = AssessedSubject::of_picture(&scene, &recording.picture);
    let sections = Sections { scene: &scene, subjects: &subjects, picture: &picture, recording, config };
    let bearings: Vec<(&str, u64)> = (config.sensors.iter().zip(&recording.sensors))
        .filter(|(_, read)| read.bearings > 0)
        .map(|(sensor, read)| (sensor.id.as_str(), read.bearings))
        .collect();
    Assessment {
        reference: scene.kind,
        method: IntervalMethod {
            confidence_percent: 95.0,
            replicates: REPLICATES,
            seed: scene.seed,
            aircraft: scene.aircraft,
            block_s: scene.block_s(),
        },
        sections: vec![
            sections.recorded(),
            sections.detection(),
            sections.tracking(),
            sections.accuracy(),
            sections.identification(),
            sections.latency(),
            sections.alignment(),
            sections.integrity(),
        ],
        cannot_say: limits::limits(&scene, &subjects, &bearings),
    }
}

/// Inputs of the sections.
struct Sections<'a> {
    scene: &'a AssessmentScene<'a>,
    subjects: &'a [AssessedSubject<'a>],
    picture: &'a AssessedSubject<'a>,
    recording: &'a AssessedRecording,
    config: &'a Config,
}

impl<'a> Sections<'a> {
    /// Subjects that the reference can judge. Without a truth, receivers are the reference.
    fn judged(&self) -> impl Iterator<Item = &'a AssessedSubject<'a>> {
        let is_truth = self.scene.is_truth();
        let is_judged = move |subject: &&AssessedSubject<'_>| {
            !subject.reports.is_empty() && (is_truth || subject.kind != SubjectKind::Receiver)
        };
        self.subjects.iter().filter(is_judged).chain(std::iter::once(self.picture))
    }

    fn recorded(&self) -> AssessmentSection {
        let plain = |key: String, name: &str, unit, digits, value: f64| {
            AssessmentFigure::plain(key, name, unit, digits, Some(value))
        };
        let Self { scene, recording, config, .. } = self;
        let length_s = recording.span.map_or(0.0, |(first, last)| last.seconds_since(first));
        let hours = scene.flown(3600.0, |_| true).values().map(|sum| sum[1]).sum();
        let mut figures = vec![
            plain("recording.length".to_owned(), "length of the recording", "s", 1, length_s),
            plain("recording.aircraft".to_owned(), "aircraft of the reference", "", 0, scene.aircraft as f64),
            plain("recording.flown".to_owned(), "flying time that counts", "h", 3, hours),
            plain(
                "picture.points".to_owned(),
                "points of the picture",
                "",
                0,
                recording.picture.len() as f64,
            ),
        ];
        for (sensor, read) in config.sensors.iter().zip(&recording.sensors) {
            let key = format!("sensor.{}.reports", sensor.id);
            let count = read.reports.len() as u64 + read.bearings;
            figures.push(plain(key, &format!("reports of {}", sensor.id), "", 0, count as f64));
        }
        for ((sensor, reason), count) in &recording.refused {
            let of = sensor.map_or("recording", |sensor| config.sensors[sensor].id.as_str());
            let name = format!("not used: {} ({of})", reason.replace('_', " "));
            figures.push(plain(format!("refused.{of}.{reason}"), &name, "", 0, *count as f64));
        }
        AssessmentSection {
            id: "recording",
            title: "Recording",
            text: "Data that the recording holds, and records that gave no report.",
            tables: vec![FigureTable { title: "recording".to_owned(), figures }],
            drawings: Vec::new(),
        }
    }

    fn detection(&self) -> AssessmentSection {
        let mut tables: Vec<FigureTable> = Vec::new();
        for subject in self.judged() {
            let mut table = detection::probability(self.scene, subject);
            table.figures.extend(detection::intervals(self.scene, subject).figures);
            tables.push(table);
        }
        if !self.scene.is_truth() {
            let receivers = self.subjects.iter().filter(|subject| subject.kind == SubjectKind::Receiver);
            tables.extend(receivers.map(|subject| detection::intervals(self.scene, subject)));
        }
        AssessmentSection {
            id: "detection",
            title: "Detection",
            text: "Probability of detection of a sensor, and probability of update of the picture: updates made of those due. A \
            radar's ranges are from its antenna, and those beyond its instrumented range do not count.",
            tables,
            drawings: self.judged().filter_map(coverage::map).collect(),
        }
    }

    fn tracking(&self) -> AssessmentSection {
        AssessmentSection {
            id: "tracking",
            title: "Tracking",
            text: "Continuity of tracks. A false track is one of which more than half of the points belong to no aircraft of the \
            truth.",
            tables: self.judged().map(|subject| tracking::tracking(self.scene, subject)).collect(),
            drawings: Vec::new(),
        }
    }

    fn accuracy(&self) -> AssessmentSection {
        let text = match self.scene.is_truth() {
            true => "Position errors: distances from the true place at the time of a point.",
            false => {
                "Differences from the places that transponders report: internal consistency, not accuracy."
            }
        };
        AssessmentSection {
            id: "accuracy",
            title: if self.scene.is_truth() { "Accuracy" } else { "Consistency with transponders" },
            text,
            tables: self.judged().map(|subject| accuracy::errors(self.scene, subject)).collect(),
            drawings: Vec::new(),
        }
    }

    fn identification(&self) -> AssessmentSection {
        let receivers: Vec<&AssessedSubject<'_>> =
            self.subjects.iter().filter(|subject| subject.kind == SubjectKind::Receiver).collect();
        let identities = identification::identities(self.scene, &receivers);
        let mut tables = vec![identification::identification(self.scene, self.picture, &identities)];
        let of_radar = |subject| identification::classification(self.scene, subject);
        tables.extend(self.subjects.iter().filter_map(of_radar));
        AssessmentSection {
            id: "identification",
            title: "Identification",
            text: "The identity of an aircraft is that of most transponder reports at its place.",
            tables,
            drawings: Vec::new(),
        }
    }

    fn latency(&self) -> AssessmentSection {
        AssessmentSection {
            id: "latency",
            title: "Latency of reports",
            text: "From the time stamp of a report to its reception, by the clock of the recorder.",
            tables: self.subjects.iter().filter_map(latency::latency).collect(),
            drawings: Vec::new(),
        }
    }

    fn alignment(&self) -> AssessmentSection {
        let mut tables = Vec::new();
        for subject in self.judged().filter(|subject| subject.kind != SubjectKind::Picture) {
            let mut table = alignment::offsets(self.scene, subject);
            let index =
                self.config.sensors.iter().position(|sensor| subject.key == format!("sensor.{}", sensor.id));
            if let Some(estimate) = index.and_then(|index| self.recording.registered.get(&index)) {
                table.figures.extend(alignment::registration(subject, estimate).figures);
            }
            tables.push(table);
        }
        AssessmentSection {
            id: "alignment",
            title: "Alignment",
            text: "Mean offsets of a sensor's reports as configured, and what the registration of the engine estimates.",
            tables,
            drawings: Vec::new(),
        }
    }

    fn integrity(&self) -> AssessmentSection {
        AssessmentSection {
            id: "integrity",
            title: "Integrity",
            text: "Transponders that the engine flags, with reasons, and tracks of drones without a transponder.",
            tables: vec![integrity::flags(self.scene, &self.recording.picture)],
            drawings: Vec::new(),
        }
    }
}
