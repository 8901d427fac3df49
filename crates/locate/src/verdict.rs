//! From plots and reports to a located radar, or to the reason why there is none.

use std::collections::BTreeMap;

use fusion::frames::{Enu, Geodetic, TangentPlane};
use fusion::time::{SECOND, Time};
use nalgebra::{Complex, Matrix2, Vector3};

use crate::advice::{remedy, unobservable};
use crate::consistency::scatter;
use crate::fit::{Fit, Recording, USUAL_SPREAD, coarse, gate, prior_sigmas, refined, rows};
use crate::located_radar::{Estimate, Evidence, LocatedRadar, PlotResidual};
use crate::measurements::{FirstGuess, PolarPlot, PositionReport};
use crate::not_located::NotLocated;
use crate::pairing::matches;
use crate::path::Path;
use crate::pieces::{TimedPlot, pieces};
use crate::pose::{Pose, residual, wrapped};
use crate::search::{Candidate, Neighbourhood, search};
use crate::vertical::vertical;

const DELAY_S: (f64, f64) = (0.1, 0.2);
/// Height of the antenna against the lowest reported height, metres, and the deviation; with a guess, that of the guess.
const BELOW_LOWEST_M: f64 = 15.0;
const HEIGHT_SIGMA_M: f64 = 30.0;
const GUESSED_SIGMA_M: f64 = 15.0;
/// Radius around a guess that is searched first, metres.
const NEAR_M: f64 = 2000.0;
/// Share of the best score from which another pose makes the result ambiguous.
const AMBIGUOUS: f64 = 0.8;
/// A pose is another one from this distance, or turn, on.
const ANOTHER: (f64, f64) = (150.0, 8.0);
/// Number of poses that are refined, and the distance and turn within which two of them count as one.
const REFINED: usize = 8;
const BESIDE: (f64, f64) = (15.0, 0.7);
/// Minimum time in common, seconds.
const COMMON_S: f64 = 60.0;
/// Largest deviations of a useful result: metres, degrees.
const USEFUL: (f64, f64) = (100.0, 2.0);
/// Largest deviations of plots of a radar that sees drones: metres, degrees.
const SCATTER: (f64, f64) = (14.0, 4.0);

struct Prepared {
    site: TangentPlane,
    epoch: Time,
    plots: Vec<TimedPlot>,
    paths: Vec<Path>,
    lowest_m: f64,
}

fn prepared(plots: &[PolarPlot], reports: &[PositionReport]) -> Result<Prepared, NotLocated> {
    let first = plots.iter().map(|plot| plot.time).min().ok_or(NotLocated::NoPlots)?;
    let epoch = reports.iter().map(|report| report.time).min().ok_or(NotLocated::NoReports)?.min(first);
    let middle = |value: &dyn Fn(&PositionReport) -> f64, share: f64| {
        let mut values: Vec<f64> = reports.iter().map(value).collect();
        values.sort_by(f64::total_cmp);
        values[((values.len() - 1) as f64 * share) as usize]
    };
    let lowest_m = middle(&|report| report.place.height_m, 0.02);
    let origin = Geodetic {
        latitude: middle(&|report| report.place.latitude, 0.5),
        longitude: middle(&|report| report.place.longitude, 0.5),
        height_m: lowest_m,
    };
    let site = TangentPlane::at_site(origin);
    let mut of_transponder: BTreeMap<usize, Vec<(f64, Vector3<f64>)>> = BTreeMap::new();
    for report in reports {
        let position = site.from_geodetic(report.place).0;
        of_transponder
            .entry(report.transponder)
            .or_default()
            .push((report.time.seconds_since(epoch), position));
    }
    let count = of_transponder.keys().last().map_or(0, |last| last + 1);
    let mut paths = vec![Path::default(); count];
    for (transponder, mut reports) in of_transponder {
        reports.sort_by(|a, b| a.0.total_cmp(&b.0));
        paths[transponder] = Path::new(&reports);
    }
    let timed = plots.iter().map(|plot| TimedPlot {
        track: plot.track,
        time_s: plot.time.seconds_since(epoch),
        range_m: plot.slant_range_m,
        azimuth: plot.azimuth,
        height_m: plot.height_m,
    });
    Ok(Prepared { site, epoch, plots: timed.collect(), paths, lowest_m })
}

/// Locates the radar of these plots.
///
/// Plots and reports may be in any order. With a `guess`, the neighbourhood of it is searched first.
///
/// # Errors
/// [`NotLocated`]: the recording does not determine where the radar is; the reason names what is missing.
pub fn locate(
    plots: &[PolarPlot],
    reports: &[PositionReport],
    guess: Option<FirstGuess>,
) -> Result<LocatedRadar, NotLocated> {
    let prepared = prepared(plots, reports)?;
    let (first_s, last_s) = plots_span(&prepared.plots);
    let overlaps =
        |path: &Path| path.span_s().is_some_and(|(from_s, to_s)| from_s < last_s && first_s < to_s);
    if !prepared.paths.iter().any(overlaps) {
        return Err(NotLocated::NoOverlap);
    }
    let pieces = pieces(prepared.plots.clone());
    let site = &prepared.site;
    let guessed = guess.map(|guess| (site.from_geodetic(guess.antenna).0, guess));
    let up_m = match guessed {
        Some((antenna, _)) => (antenna.z, GUESSED_SIGMA_M),
        None => (-BELOW_LOWEST_M, HEIGHT_SIGMA_M),
    };
    let recording = Recording { site, pieces: &pieces, paths: &prepared.paths, up_m };
    let near = guessed.map(|(antenna, _)| (antenna.xy(), NEAR_M));
    let neighbourhoods = if near.is_some() { vec![near, None] } else { vec![None] };
    let mut outcome = Err(NotLocated::NoConsensus);
    for near in neighbourhoods {
        outcome = best_fit(&recording, &prepared, near);
        if outcome.is_ok() {
            break;
        }
    }
    let (fit, start, runner_up) = outcome?;
    let before = match guessed {
        Some((antenna, guess)) => Pose::new(site, antenna, guess.bearing, fit.pose.later_s),
        None => start,
    };
    judged(&recording, &prepared, &fit, &before, runner_up)
}

fn plots_span(plots: &[TimedPlot]) -> (f64, f64) {
    plots.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), plot| {
        (first.min(plot.time_s), last.max(plot.time_s))
    })
}

/// The best fit, the pose it started from, and the score of the best other pose as a share of its own.
fn best_fit(
    recording: &Recording<'_>,
    prepared: &Prepared,
    near: Option<Neighbourhood>,
) -> Result<(Fit, Pose, f64), NotLocated> {
    let up_m = recording.up_m.0;
    let mean_up_m = {
        let ups: Vec<f64> =
            recording.paths.iter().flat_map(|path| path.positions().iter().map(|at| at.z)).collect();
        ups.iter().sum::<f64>() / ups.len().max(1) as f64
    };
    let ground = |range_m: f64, azimuth: f64, height_m: Option<f64>| {
        let up = height_m.map_or(mean_up_m, |height_m| height_m - prepared.lowest_m) - up_m;
        let over_ground_m = (range_m * range_m - up * up).max(0.1 * range_m * range_m).sqrt();
        Complex::new(azimuth.sin(), azimuth.cos()) * over_ground_m
    };
    let candidates = search(recording.pieces, recording.paths, ground, near);
    let pose = |candidate: &Candidate| {
        let antenna = Vector3::new(candidate.antenna.x, candidate.antenna.y, up_m);
        Pose::new(recording.site, antenna, candidate.bearing, candidate.later_s)
    };
    let mut fits: Vec<(f64, Fit, Pose)> = candidates
        .iter()
        .filter_map(|candidate| {
            let start = pose(candidate);
            let fit = coarse(recording, start)?;
            Some((score(recording, &fit), fit, start))
        })
        .collect();
    fits.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut refined_fits: Vec<(f64, Fit, Pose)> = Vec::new();
    let mut started: Vec<Pose> = Vec::new();
    for (_, fit, start) in &fits {
        let is_beside = |other: &Pose| is_within(other, &fit.pose, BESIDE);
        if started.iter().any(is_beside) {
            continue;
        }
        started.push(fit.pose);
        if started.len() > REFINED {
            break;
        }
        if let Some(fit) = refined(recording, fit.clone()) {
            refined_fits.push((score(recording, &fit), fit, *start));
        }
    }
    refined_fits.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (best_score, fit, start) = refined_fits.first().cloned().ok_or(NotLocated::NoConsensus)?;
    let others = fits.iter().chain(&refined_fits).filter(|(_, other, _)| !is_same(&other.pose, &fit.pose));
    let second = others.map(|(score, ..)| *score).fold(0.0, f64::max);
    Ok((fit, start, second / best_score))
}

fn is_same(pose: &Pose, other: &Pose) -> bool {
    is_within(pose, other, ANOTHER)
}

fn is_within(pose: &Pose, other: &Pose, (distance_m, turn_deg): (f64, f64)) -> bool {
    (pose.antenna - other.antenna).xy().norm() < distance_m
        && wrapped(pose.bearing - other.bearing).abs().to_degrees() < turn_deg
}

/// Time in which pieces agree with paths, weighted by how well, seconds; by the usual noise, so that poses compare.
fn score(recording: &Recording<'_>, fit: &Fit) -> f64 {
    let gate = gate(USUAL_SPREAD, 10.0);
    let found = matches(recording.pieces, recording.paths, &fit.pose, &gate);
    found.iter().map(|one| recording.pieces[one.piece].duration_s() * (1.0 - one.distance)).sum()
}

fn judged(
    recording: &Recording<'_>,
    prepared: &Prepared,
    fit: &Fit,
    before: &Pose,
    runner_up: f64,
) -> Result<LocatedRadar, NotLocated> {
    let common_s: f64 = fit.matches.iter().map(|one| recording.pieces[one.piece].duration_s()).sum();
    if common_s < COMMON_S {
        return Err(NotLocated::TooShort { common_s, needed_s: COMMON_S });
    }
    if runner_up > AMBIGUOUS {
        return Err(NotLocated::Ambiguous { runner_up });
    }
    let (range_m, azimuth_deg) = (fit.noise.range.total(), fit.noise.azimuth.total().to_degrees());
    if range_m > SCATTER.0 || azimuth_deg > SCATTER.1 {
        return Err(NotLocated::Scattered { range_m, azimuth_deg });
    }
    let gate = gate(fit.spread, 0.0);
    let both = rows(recording, &fit.pose, &fit.matches, &gate);
    let factor = scatter(recording, fit, &both)?;
    let covariance = fit.covariance * factor;
    let sigma = |index: usize| covariance[(index, index)].sqrt();
    let remedy = remedy(recording, fit);
    let position_m = sigma(0).hypot(sigma(1));
    let bearing_deg = sigma(3).to_degrees();
    if position_m > USEFUL.0 || bearing_deg > USEFUL.1 {
        return Err(NotLocated::Uncertain { position_m, bearing_deg, remedy });
    }
    let priors = prior_sigmas(recording.up_m.1);
    let antenna = recording.site.to_geodetic(Enu::from(fit.pose.antenna));
    let estimate = |index: usize, value: f64, unit: f64| Estimate {
        value: value * unit,
        sigma: sigma(index) * unit,
        prior_sigma: priors[index] * unit,
    };
    let place_of = |east, north, up| recording.site.to_geodetic(Enu::new(east, north, up));
    let of_heights = vertical(recording, fit, |east, north, up| place_of(east, north, up).height_m);
    let mut located = LocatedRadar {
        antenna,
        covariance_m2: Matrix2::from_fn(|row, column| covariance[(row, column)]),
        height_m: estimate(2, antenna.height_m, 1.0),
        bearing_deg: estimate(3, fit.pose.bearing, 1_f64.to_degrees()),
        range_offset_m: estimate(4, fit.pose.offset_m, 1.0),
        range_scale: estimate(5, fit.pose.scale, 1.0),
        clock_s: Estimate {
            value: DELAY_S.0 - fit.pose.later_s,
            sigma: sigma(6).hypot(DELAY_S.1),
            prior_sigma: priors[6],
        },
        tilt_east_deg: of_heights.map(|of| of.tilt_east_deg),
        tilt_north_deg: of_heights.map(|of| of.tilt_north_deg),
        height_offset_m: of_heights.map(|of| of.offset_m),
        azimuth_sigma_deg: fit.noise.azimuth.total().to_degrees(),
        range_sigma_m: fit.noise.range.total(),
        height_sigma_m: of_heights.map(|of| of.sigma_m),
        unobservable: Vec::new(),
        evidence: evidence(recording, fit, common_s, runner_up),
        residuals: residuals(recording, prepared, fit, before),
    };
    located.unobservable = unobservable(&located, remedy);
    Ok(located)
}

fn evidence(recording: &Recording<'_>, fit: &Fit, common_s: f64, runner_up: f64) -> Evidence {
    let distinct = |values: Vec<usize>| values.into_iter().collect::<std::collections::BTreeSet<_>>().len();
    Evidence {
        transponders: distinct(fit.matches.iter().map(|one| one.path).collect()),
        tracks: distinct(fit.matches.iter().map(|one| recording.pieces[one.piece].run).collect()),
        common_s,
        runner_up,
    }
}

fn residuals(recording: &Recording<'_>, prepared: &Prepared, fit: &Fit, before: &Pose) -> Vec<PlotResidual> {
    let mut found: Vec<PlotResidual> = Vec::new();
    for one in &fit.matches {
        let path = &recording.paths[one.path];
        for plot in &recording.pieces[one.piece].plots {
            let Some(point) = path.at(plot.time_s + fit.pose.later_s) else { continue };
            let both = residual(plot, &point, &fit.pose).zip(residual(plot, &point, before));
            let Some((after, before)) = both else { continue };
            found.push(PlotResidual {
                time: Time::from_nanos(prepared.epoch.nanos() + (plot.time_s * SECOND as f64) as i64),
                transponder: one.path,
                reported: recording.site.to_geodetic(Enu::from(point.position)),
                before: (before.azimuth.to_degrees(), before.range_m),
                after: (after.azimuth.to_degrees(), after.range_m),
            });
        }
    }
    found.sort_by_key(|residual| (residual.time, residual.transponder));
    found
}
