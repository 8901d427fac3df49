//! Least squares along a track, compared with the one-step solution with the dense covariance of all its plots.

use nalgebra::{DMatrix, DVector, Vector3};

use super::super::along::{Information, rows};
use super::{ERRORS, REFERENCE_M, Residual, World, sample_of, seconds};
use crate::frames::Enu;
use crate::registration::TrackComparison;

/// Offsets on an axis, with rows of p and of the reference's errors.
fn measured(plots: &[Residual], axis: usize) -> Vec<(f64, f64, DVector<f64>, Vector3<f64>)> {
    let measured = plots.iter().filter(|residual| axis < 2 || residual.height_measured);
    let offset = |residual: &Residual| {
        let Residual { plot, target, velocity, .. } = residual;
        let (plot, target) = (plot.0, target.0);
        let turned = plot.x.atan2(plot.y) - target.x.atan2(target.y);
        let turned = turned.sin().atan2(turned.cos());
        let ground_m = target.xy().norm();
        let (offset, direction) = match axis {
            0 => (turned, Vector3::new(target.y, -target.x, 0.0) / ground_m.powi(2)),
            1 => (plot.norm() - target.norm(), target.normalize()),
            _ => (plot.z - target.z, Vector3::z()),
        };
        let row = DVector::from_column_slice(rows(&target, velocity, turned)[axis].as_slice());
        (residual.time.as_seconds(), offset, row, direction * REFERENCE_M)
    };
    measured.map(offset).collect()
}

fn at_once(plots: &[Residual], axis: usize) -> (DMatrix<f64>, DVector<f64>) {
    let slow = [ERRORS.bias_azimuth, ERRORS.bias_range_m, ERRORS.bias_height_m][axis];
    let fast = [ERRORS.noise_azimuth, ERRORS.noise_range_m, ERRORS.noise_height_m][axis];
    let measured = measured(plots, axis);
    let covariance = DMatrix::from_fn(measured.len(), measured.len(), |i, j| {
        let ((a, .., here), (b, .., there)) = (&measured[i], &measured[j]);
        let apart = (a - b).abs();
        let white = if i == j { fast * fast } else { 0.0 };
        slow * slow * (-apart / ERRORS.correlation_s).exp() + here.dot(there) * (-apart / 60.0).exp() + white
    });
    let offsets = DVector::from_iterator(measured.len(), measured.iter().map(|(_, offset, ..)| *offset));
    let design = DMatrix::from_fn(measured.len(), 6, |i, j| measured[i].2[j]);
    let weighted = design.transpose() * covariance.try_inverse().unwrap();
    (&weighted * design, weighted * offsets)
}

/// Scales errors so that no plot is an outlier.
fn calm(plots: &mut [Residual]) {
    for residual in plots {
        residual.plot = (residual.target.0 + (residual.plot.0 - residual.target.0) * 0.4).into();
    }
}

#[test]
fn the_filter_is_the_dense_solution() {
    for seed in 0..20 {
        let mut world = World::new(seed);
        let dt = world.between(0.2, 4.0);
        let mut plots = world.plots(60.0, dt);
        calm(&mut plots);
        for (index, residual) in plots.iter_mut().enumerate() {
            residual.height_measured = index % 3 != 1;
        }
        // Some plots are missing.
        plots.retain(|residual| residual.time.nanos() / 1_000_000 % 7 != 3);
        let sample = sample_of(&plots);
        for (axis, Information { matrix, vector }) in sample.axes.iter().enumerate() {
            let (dense, offsets) = at_once(&plots, axis);
            for i in 0..6 {
                let scale = |j: usize| (dense[(i, i)] * dense[(j, j)]).sqrt();
                for j in 0..6 {
                    let wrong = (matrix[(i, j)] - dense[(i, j)]).abs();
                    assert!(wrong <= 1e-9 * scale(j), "{seed}, axis {axis}, {i} {j}: {wrong}");
                }
                let wrong = (vector[i] - offsets[i]).abs();
                assert!(wrong <= 1e-8 * dense[(i, i)].sqrt(), "{seed}, axis {axis}, {i}: {wrong}");
            }
        }
    }
}

/// A radar track, not a plot, is one independent sample.
#[test]
fn information_grows_with_duration_and_hardly_with_plots() {
    let looks = |duration_s: f64, dt: f64| {
        let (mut along, mut at) = (TrackComparison::new(&ERRORS), 0.0);
        while at <= duration_s {
            let place = Vector3::new(0.0, 2000.0, 50.0);
            let residual = Residual {
                time: seconds(at),
                plot: place.into(),
                target: place.into(),
                velocity: Vector3::zeros(),
                height_measured: true,
                lasting_m: 0.0,
                curve_m: 0.0,
                spacing_s: 0.0,
            };
            along.add(&residual);
            at += dt;
        }
        let (_, deviation) = along.take_sample().unwrap().azimuth().unwrap();
        (ERRORS.bias_azimuth / deviation).powi(2)
    };
    // 1 + D / 2T
    for (duration_s, expected) in [(20.0, 1.5), (60.0, 2.5), (200.0, 6.0)] {
        for dt in [0.25, 1.0, 4.0] {
            let looks = looks(duration_s, dt);
            assert!((looks / expected - 1.0).abs() < 0.06, "{duration_s} s, each {dt} s: {looks}");
        }
    }
}

#[test]
fn pieces_add_up_to_the_whole() {
    let plots = World::new(7).plots(60.0, 1.0);
    let whole = sample_of(&plots);
    let mut along = TrackComparison::new(&ERRORS);
    let mut pieces = Vec::new();
    for (index, residual) in plots.iter().enumerate() {
        along.add(residual);
        if index % 17 == 16 {
            assert_eq!(along.gathered_s(), 16.0);
            pieces.extend(along.take_sample());
            assert_eq!((along.gathered_s(), along.take_sample()), (0.0, None));
        }
    }
    pieces.extend(along.take_sample());
    assert_eq!(pieces.len(), 4);
    for axis in 0..3 {
        let mut sum = Information::none();
        for piece in &pieces {
            sum.add(&piece.axes[axis], 1.0);
            assert_eq!(piece.begun, whole.begun);
        }
        assert!((sum.matrix - whole.axes[axis].matrix).norm() <= 1e-12 * sum.matrix.norm());
        assert!((sum.vector - whole.axes[axis].vector).norm() <= 1e-12 * sum.vector.norm());
    }
}

/// A radar rotated by far more than its errors has no outliers.
#[test]
fn an_outlier_counts_little_and_a_turned_radar_is_none() {
    let mut world = World::new(3);
    world.bias[0] = 30_f64.to_radians();
    // The plots are so far apart that each shows the rotation independently, at twelve times the bias.
    let mut plots = world.plots(1200.0, 60.0);
    plots.retain(|residual| residual.target.0.xy().norm() > 100.0);
    calm(&mut plots);
    let (turned, deviation) = sample_of(&plots).azimuth().unwrap();
    let (dense, offsets) = at_once(&plots, 0);
    assert!((turned - offsets[0] / dense[(0, 0)]).abs() < 1e-9);
    assert!((deviation * deviation * dense[(0, 0)] - 1.0).abs() < 1e-9);
    let radar = nalgebra::Rotation3::from_axis_angle(&Vector3::z_axis(), 30_f64.to_radians());
    plots[10].plot = (radar * plots[10].plot.0).into();
    let (with, _) = sample_of(&plots).azimuth().unwrap();
    let (dense, offsets) = at_once(&plots, 0);
    let alone = offsets[0] / dense[(0, 0)] - turned;
    assert!((with - turned).abs() < 0.25 * alone.abs().max(deviation), "{with} {turned} {alone} {deviation}");
}

#[test]
fn incomparable_plots_are_omitted() {
    let plots = World::new(5).plots(20.0, 1.0);
    let mut along = TrackComparison::new(&ERRORS);
    assert_eq!(along.take_sample(), None);
    for residual in &plots {
        along.add(residual);
    }
    let all = along.clone().take_sample();
    let last = plots[plots.len() - 1];
    let later = Residual { time: seconds(5000.0), ..last };
    along.add(&last);
    along.add(&Residual { plot: Enu::new(f64::NAN, 0.0, 0.0), ..later });
    along.add(&Residual { lasting_m: f64::INFINITY, ..later });
    along.add(&Residual { curve_m: f64::NAN, ..later });
    along.add(&Residual { target: Enu::new(20.0, 20.0, 50.0), ..later });
    along.add(&Residual { target: Enu::new(150.0, 0.0, 400.0), ..later });
    assert_eq!(along.take_sample(), all);
}

#[test]
fn assumed_heights_are_no_evidence() {
    let mut world = World::new(6);
    world.heights = false;
    assert_eq!(world.sample(30.0, 1.0).axes[2], Information::none());
}
