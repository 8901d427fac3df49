//! Plots by radar, and positions of transponders, of a capture: the input of [`locate`](crate::locate()).

use std::collections::BTreeMap;

use asterix::cat048::DetectionType;
use asterix::{Block, DataSource, TimeOfDay, blocks, cat034, cat048, cat129};
use egm96::egm96_compute_altitude_offset;
use fusion::Identity;
use fusion::frames::Geodetic;
use fusion::time::Time;
use input::capture::CapturedDatagram;
use input::normalise::{nearest_day, on_day};

use crate::measurements::{PolarPlot, PositionReport};

/// Plots and positions of a capture.
#[derive(Clone, Debug, Default)]
pub struct AlignmentData {
    /// The radars, by SAC and SIC.
    pub radars: BTreeMap<DataSource, RadarData>,
    /// Positions of transponders (CAT129).
    pub reports: Vec<PositionReport>,
    /// Identity of each transponder, by index.
    pub transponders: Vec<Identity>,
    /// Height of the geoid above the ellipsoid where the first transponder reports (EGM96), metres.
    pub undulation_m: Option<f64>,
    /// Time of the latest record of a file without reception times.
    latest: Option<Time>,
}

/// Data of one radar.
#[derive(Clone, Debug, Default)]
pub struct RadarData {
    /// Plots with time, position and track number; without tests, simulations and coasted tracks.
    pub plots: Vec<PolarPlot>,
    /// Position that the radar states (I034/120).
    pub stated: Option<Geodetic>,
}

impl AlignmentData {
    /// Sets the undulation of the geoid, metres; by default it is that of EGM96.
    #[must_use]
    pub fn with_undulation(self, undulation_m: Option<f64>) -> Self {
        Self { undulation_m, ..self }
    }

    /// Adds a datagram. Records that cannot be read are left out; `info` counts them.
    pub fn datagram(&mut self, datagram: &CapturedDatagram) {
        for block in blocks(&datagram.payload).flatten() {
            match block.category {
                34 => self.service(block),
                48 => self.plots(block, datagram.received),
                129 => self.positions(block, datagram.received),
                _ => {}
            }
        }
    }

    /// Time of a record. Without reception times the days follow each other.
    fn time(&mut self, time_of_day: TimeOfDay, received: Option<Time>) -> Option<Time> {
        let count = time_of_day.count();
        let time = match received.or(self.latest) {
            Some(reference) => nearest_day(count, reference),
            None => on_day(count, Time::from_nanos(0)),
        }?;
        if received.is_none() {
            self.latest = Some(time);
        }
        Some(time)
    }

    fn service(&mut self, block: Block<'_>) {
        for record in block.records::<cat034::Record>().flatten().map(|located| located.record) {
            let Some((source, stated)) = record.data_source.zip(record.source_position) else { continue };
            let place = [stated.latitude_deg(), stated.longitude_deg()];
            let height_m = stated.height_m() + egm96_compute_altitude_offset(place[0], place[1]);
            let radar = self.radars.entry(source).or_default();
            radar.stated = Some(Geodetic::from_degrees(place[0], place[1], height_m));
        }
    }

    fn plots(&mut self, block: Block<'_>, received: Option<Time>) {
        for record in block.records::<cat048::Record>().flatten().map(|located| located.record) {
            let (Some(source), Some(time_of_day)) = (record.data_source, record.time_of_day) else {
                continue;
            };
            let Some(time) = self.time(time_of_day, received) else { continue };
            let radar = self.radars.entry(source).or_default();
            let is_unreal = record.target_report.as_ref().is_some_and(|report| {
                report.detection() == DetectionType::NoDetection || report.is_simulated() || report.is_test()
            });
            let (Some(polar), Some(number)) = (record.polar_position, record.track_number) else { continue };
            if is_unreal || polar.range_m() <= 0.0 {
                continue;
            }
            radar.plots.push(PolarPlot {
                track: number.number(),
                time,
                slant_range_m: polar.range_m(),
                azimuth: polar.azimuth_deg().to_radians(),
                height_m: record.height_3d.map(cat048::Height3D::height_m),
            });
        }
    }

    fn positions(&mut self, block: Block<'_>, received: Option<Time>) {
        for record in block.records::<cat129::Record>().flatten().map(|located| located.record) {
            let (Some(time_of_day), Some(position), Some(altitude), Some(serial)) =
                (record.time_of_day, record.position, record.altitude_amsl, record.serial_number)
            else {
                continue;
            };
            let Some(identity) = Identity::new(&serial, record.registration_country.as_ref()) else {
                continue;
            };
            let Some(time) = self.time(time_of_day, received) else { continue };
            if !position.in_range() {
                continue;
            }
            let place = [position.latitude_deg(), position.longitude_deg()];
            let undulation_m =
                *self.undulation_m.get_or_insert_with(|| egm96_compute_altitude_offset(place[0], place[1]));
            let known = self.transponders.iter().position(|of| *of == identity);
            let transponder = known.unwrap_or_else(|| {
                self.transponders.push(identity);
                self.transponders.len() - 1
            });
            let place = Geodetic::from_degrees(place[0], place[1], altitude.metres() + undulation_m);
            self.reports.push(PositionReport { transponder, time, place });
        }
    }

    /// The radar's plots, with heights above the ellipsoid.
    pub fn plots_of(&self, radar: &RadarData) -> Vec<PolarPlot> {
        let undulation_m = self.undulation_m.unwrap_or(0.0);
        let above_ellipsoid = |plot: &PolarPlot| PolarPlot {
            height_m: plot.height_m.map(|height_m| height_m + undulation_m),
            ..*plot
        };
        radar.plots.iter().map(above_ellipsoid).collect()
    }
}
