//! The q-method compared with SciPy's, and with least squares.

use std::path::Path;

use nalgebra::{Matrix3, Rotation3, Vector3};

use super::super::qmethod::{DirectionPair, attitude, bare, rotation, turn};
use super::super::sums::{MisalignmentSums, SolvedSums};
use super::{World, values};

fn list(field: &str) -> Vec<f64> {
    field.split(' ').map(|number| number.parse().unwrap()).collect()
}

/// The table comes from `testdata/oracle/qmethod.py`. The published package, recognised by its `Cargo.toml.orig`, lacks the
/// table.
#[test]
#[expect(clippy::disallowed_methods, reason = "it is a test that reads")]
fn the_rotation_is_that_of_scipy() {
    let package = Path::new(env!("CARGO_MANIFEST_DIR"));
    if package.join("Cargo.toml.orig").exists() {
        eprintln!("skipped: the table is in the repository");
        return;
    }
    let table = std::fs::read_to_string(package.join("../testdata/oracle/qmethod.csv")).unwrap();
    let mut cases = 0;
    for row in table.lines().skip(2) {
        let fields: Vec<&str> = row.split(',').collect();
        let (weights, measured, reference) = (list(fields[1]), list(fields[2]), list(fields[3]));
        let (expected, loss) = (Matrix3::from_row_slice(&list(fields[4])), list(fields[5])[0]);
        let pairs = measured.chunks_exact(3).zip(reference.chunks_exact(3)).zip(&weights);
        let pairs: Vec<DirectionPair> = pairs
            .map(|((b, r), &weight)| DirectionPair {
                measured: Vector3::from_column_slice(b),
                reference: Vector3::from_column_slice(r),
                weight,
            })
            .collect();
        let profile = pairs.iter().fold(Matrix3::zeros(), |sum, pair| {
            sum + pair.measured * pair.reference.transpose() * pair.weight
        });
        let (found, trace) = rotation(&profile);
        let wrong = (found.to_rotation_matrix().matrix() - expected).amax();
        assert!(wrong < 1e-9, "case {}: {wrong:e}", fields[0]);
        let again = attitude(pairs).unwrap();
        assert!(again.angle_to(&found) < 1e-12, "case {}", fields[0]);
        let all: f64 = weights.iter().sum();
        assert!((all - trace - loss).abs() < 1e-9 * all, "case {}: {}", fields[0], all - trace);
        cases += 1;
    }
    assert_eq!(cases, 100);
}

#[test]
fn attitude_of_one_direction_is_undetermined() {
    let pair = DirectionPair { measured: Vector3::x(), reference: Vector3::y(), weight: 2.0 };
    assert_eq!(attitude([]), None);
    assert_eq!(attitude([pair]), None);
    assert_eq!(attitude([pair, DirectionPair { weight: 1.0, ..pair }]), None);
    let other = DirectionPair { measured: Vector3::z(), reference: Vector3::z(), weight: 1.0 };
    let turned = attitude([pair, other]).unwrap();
    assert!((turned * Vector3::y() - Vector3::x()).norm() < 1e-12, "{turned}");
}

/// Any rotation, with any information about it, even if some directions have none.
#[test]
fn a_profile_made_from_information_gives_its_rotation_back() {
    let turned = Rotation3::new(Vector3::new(0.02, -0.01, 0.3));
    for information in [[3.0, 5.0, 1.0], [50.0, 0.1, 1.0], [0.01, 0.01, 400.0]] {
        let profile = turned * bare(&Matrix3::from_diagonal(&information.into()));
        let (found, _) = rotation(&profile);
        assert!((found.scaled_axis() - turned.scaled_axis()).norm() < 1e-9);
    }
    let flat =
        Rotation3::from_axis_angle(&Vector3::z_axis(), -2.5) * bare(&Matrix3::from_diagonal(&Vector3::z()));
    let (clockwise, trace) = turn(&flat);
    assert!((clockwise - 2.5).abs() < 1e-12 && (trace - 1.0).abs() < 1e-12);
}

/// In the linear range both agree; the difference comes from the square of an angle in least squares.
#[test]
fn the_bearing_is_that_of_least_squares() {
    for seed in 0..40 {
        let mut world = World::wrong(seed);
        world.bias *= 0.4;
        world.heights = seed % 4 != 0;
        let mut sums = MisalignmentSums::none();
        for _ in 0..30 {
            let sample = world.sample(60.0, 1.0);
            sums.add(&MisalignmentSums::of(&sample.axes, Default::default()), 1.0);
        }
        let estimate = super::Misalignment::of(&sums);
        let solved = SolvedSums::from(&sums.axes, &[1.0; 3]);
        for index in 0..3 {
            let value = values(&estimate)[index];
            let apart = (value.value - solved.mean[index]).abs();
            // In the plane the tilts are assumed to be zero, whereas least squares estimates them from steep azimuths.
            let most = if world.heights { 0.1 } else { 0.3 } * value.deviation;
            assert!(!value.observable || apart < most, "{seed} {index}: {apart} {value:?}");
        }
    }
}

/// Least squares assumes small angles; the q-method does not.
#[test]
fn a_radar_may_be_turned_by_any_angle() {
    for degrees in [-170.0, -60.0, 20.0, 100.0_f64] {
        let mut world = World::new(9);
        world.bias[0] = degrees.to_radians();
        world.bias[2] = 0.8_f64.to_radians();
        let estimate = world.estimate(60);
        let [bearing, _, tilt_north, ..] = values(&estimate);
        let wrong = (bearing.value - world.bias[0]).abs();
        assert!(
            wrong < 4.0 * bearing.deviation + 0.002 * degrees.abs().to_radians(),
            "{degrees}: {bearing:?}"
        );
        println!("{degrees}: {bearing:?} {tilt_north:?}");
    }
}
