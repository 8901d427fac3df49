//! The output of a capture, and each input alone for comparison.

use std::collections::BTreeMap;

use super::place::GeodeticPlace;
use super::types::{OutputPoint, PointFlags, PointSource};
use fusion::report::{Fix, Identity};
use fusion::time::Time;
use fusion::{Emission, Enu, Plot, Report};
use input::capture::{ReadError, Reception};
use input::normalise::Normaliser;
use input::pipeline::{Event, Output, Pipeline};
use picture::{PictureMaker, PictureTrack, serial_text};
use site::areas::Masks;
use site::config::{Config, PictureKind, Profile};

/// Points of each input alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct InputsAlone {
    /// Every plot that the engine accepts, at its own time, under its radar track number.
    pub radar: Vec<OutputPoint>,
    /// Every transponder's interpolated position, in each slot that has one, at the configured latency.
    pub transponder: Vec<OutputPoint>,
    /// Every transponder report that the engine accepts, at its own time, under the number of its transponder. Reports
    /// of a transponder without a number are omitted.
    pub reports: Vec<OutputPoint>,
}

/// Returns the points of a capture, as its replay writes them.
///
/// # Errors
/// The capture cannot be read to its end.
pub fn output(
    receptions: impl Iterator<Item = Result<Reception, ReadError>>,
    config: &Config,
    masks: Masks,
) -> Result<Vec<OutputPoint>, ReadError> {
    output_at(PictureKind::Lagged, receptions, config, masks)
}

/// Returns the points of one of the pictures, as `replay --at` writes them.
///
/// # Errors
/// The capture cannot be read to its end.
pub fn output_at(
    picture: PictureKind,
    receptions: impl Iterator<Item = Result<Reception, ReadError>>,
    config: &Config,
    masks: Masks,
) -> Result<Vec<OutputPoint>, ReadError> {
    let mut pipeline = Pipeline::new(config, masks);
    let maker = PictureMaker::new(config, pipeline.normaliser());
    let mut points = Vec::new();
    let mut publish = |emission: Emission| {
        let picture = match picture {
            PictureKind::Lagged => Some(maker.picture(emission)),
            PictureKind::Now => emission.now.map(|now| maker.now(now)),
        };
        let Some(picture) = picture else { return };
        let tracks = picture.within(config.output.max_accuracy_m);
        points.extend(tracks.map(|track| OutputPoint::of_track(track, &maker)));
    };
    for reception in receptions {
        pipeline.receive(&reception?);
        pipeline.emissions().for_each(&mut publish);
    }
    pipeline.finish();
    pipeline.emissions().for_each(publish);
    Ok(points)
}

impl InputsAlone {
    /// Computes the inputs of a capture with the same pipeline as the output, but without plots. The transponders are
    /// interpolated as in the `reference` profile. Reports without a height are included if the profile of the output
    /// accepts them.
    ///
    /// # Errors
    /// The capture cannot be read to its end.
    pub fn of(
        receptions: impl Iterator<Item = Result<Reception, ReadError>>,
        config: &Config,
        masks: Masks,
    ) -> Result<Self, ReadError> {
        let needs_height = config.fusion.profile == Profile::Reference;
        let mut config = config.clone();
        config.fusion.profile = Profile::Reference;
        config.fusion.latency_slots = config.fusion.latency_slots.max(1);
        let pipeline = Pipeline::new(&config, masks).without_plots();
        let mut pipeline = if needs_height { pipeline } else { pipeline.with_optional_heights() };
        let maker = PictureMaker::new(&config, pipeline.normaliser());
        let (mut plots, mut fixes, mut emissions) = (Vec::new(), Vec::new(), Vec::<Emission>::new());
        for reception in receptions {
            pipeline.receive(&reception?);
            while let Some(output) = pipeline.poll() {
                match output {
                    Output::Emission(emission) => emissions.push(emission),
                    Output::Event(Event::Accepted { report: Report::Plot(plot), .. }) => plots.push(plot),
                    Output::Event(Event::Accepted { report: Report::Fix(fix), .. }) => fixes.push(fix),
                    Output::Event(_) => {}
                }
            }
        }
        pipeline.finish();
        emissions.extend(pipeline.emissions());
        let normaliser = pipeline.normaliser();
        let reports = reports(&fixes, &emissions, normaliser);
        let heights = ReportHeights::of(&fixes);
        let tracks = emissions.into_iter().flat_map(|emission| maker.picture(emission).tracks);
        // The output omits vehicles, too.
        let tracks = tracks.filter(|track| !track.is_vehicle());
        let interpolated = |track: PictureTrack| {
            let mut point = OutputPoint::of_track(&track, &maker);
            let identity = track.point.source.transponder().map(|part| part.identity);
            if identity.is_some_and(|identity| !heights.are_said(identity, track.time)) {
                point.place.altitude_amsl_m = None;
            }
            point
        };
        Ok(Self {
            radar: plots.iter().map(|plot| plot_point(plot, normaliser, &maker)).collect(),
            transponder: tracks.map(interpolated).collect(),
            reports,
        })
    }
}

/// For each identity with some reports that lack a height: whether the report at each time has one.
struct ReportHeights(BTreeMap<Identity, BTreeMap<Time, bool>>);

impl ReportHeights {
    fn of(fixes: &[Fix]) -> Self {
        let unsaid =
            fixes.iter().filter(|fix| !fix.height_measured).map(|fix| (fix.identity, BTreeMap::new()));
        let mut heights: BTreeMap<Identity, BTreeMap<Time, bool>> = unsaid.collect();
        for fix in fixes {
            if let Some(reports) = heights.get_mut(&fix.identity) {
                reports.insert(fix.time, fix.height_measured);
            }
        }
        Self(heights)
    }

    /// Whether the reports before and after `time`, or the one at `time`, have a height.
    fn are_said(&self, identity: Identity, time: Time) -> bool {
        let Some(reports) = self.0.get(&identity) else { return true };
        let beside = [reports.range(..=time).next_back(), reports.range(time..).next()];
        beside.into_iter().flatten().all(|(_, is_said)| *is_said)
    }
}

/// Converts reports to points, under the numbers that their transponders have in the emissions.
pub fn reports<'a>(
    fixes: &[Fix],
    emissions: impl IntoIterator<Item = &'a Emission>,
    normaliser: &Normaliser,
) -> Vec<OutputPoint> {
    let parts = emissions.into_iter().flat_map(|emission| &emission.points);
    let parts = parts.filter_map(|point| point.source.transponder());
    let numbers: BTreeMap<Identity, u32> = parts.map(|part| (part.identity, part.number)).collect();
    let point = |fix: &Fix| Some(fix_point(fix, *numbers.get(&fix.identity)?, normaliser));
    fixes.iter().filter_map(point).collect()
}

/// A plot at its own time.
pub(crate) fn plot_point(plot: &Plot, normaliser: &Normaliser, maker: &PictureMaker) -> OutputPoint {
    OutputPoint {
        source: PointSource::Radar,
        number: plot.track.number.into(),
        radar_track: Some(plot.track.number),
        sensor: Some(maker.sensor(plot.track.sensor).to_owned()),
        ..report_point((plot.time, plot.position), plot.height_measured, normaliser)
    }
}

/// A transponder's report at its own time, under this number.
pub(crate) fn fix_point(fix: &Fix, number: u32, normaliser: &Normaliser) -> OutputPoint {
    OutputPoint {
        number,
        transponder: Some(number),
        identity: Some(serial_text(fix.identity)),
        ..report_point((fix.time, fix.position), fix.height_measured, normaliser)
    }
}

/// A point of a position, without contributors.
fn report_point((time, position): (Time, Enu), has_height: bool, normaliser: &Normaliser) -> OutputPoint {
    let position = normaliser.frame().to_geodetic(position);
    OutputPoint {
        time,
        place: GeodeticPlace {
            latitude_deg: position.latitude_deg(),
            longitude_deg: position.longitude_deg(),
            altitude_amsl_m: has_height.then(|| position.height_m - normaliser.undulation_m()),
        },
        source: PointSource::Transponder,
        number: 0,
        radar_track: None,
        sensor: None,
        transponder: None,
        identity: None,
        covariance: None,
        flags: PointFlags::default(),
    }
}
