//! Table 1: which product of rotations is the relative alignment.

use nalgebra::Matrix3;

/// Heading, pitch and roll, degrees.
pub type Angles = [f64; 3];

/// Table 1: alignment of the radar and of the camera relative to the body axes, and of the radar relative to the
/// camera.
pub const RADAR: Angles = [0.32, 0.49, -1.12];
pub const CAMERA: Angles = [1.19, 0.64, -0.51];
pub const RELATIVE: Angles = [-0.86, -0.16, -0.61];

/// M321 of seed 003, equation 2: from the reference axes to axes rotated by heading, pitch and roll.
pub fn m321(angles: Angles) -> Matrix3<f64> {
    let [(sg, cg), (sb, cb), (sa, ca)] = angles.map(|angle| angle.to_radians().sin_cos());
    Matrix3::new(
        cb * cg,
        cb * sg,
        -sb,
        -ca * sg + sa * sb * cg,
        ca * cg + sa * sb * sg,
        sa * cb,
        sa * sg + ca * sb * cg,
        -sa * cg + ca * sb * sg,
        ca * cb,
    )
}

/// Angles of such a matrix.
pub fn angles(matrix: &Matrix3<f64>) -> Angles {
    [
        matrix[(0, 1)].atan2(matrix[(0, 0)]).to_degrees(),
        -matrix[(0, 2)].asin().to_degrees(),
        matrix[(1, 2)].atan2(matrix[(2, 2)]).to_degrees(),
    ]
}

/// M_CAMᵀ M_RAD, which the table shows, and M_RADᵀ M_CAM, which is equation 3.
pub fn products() -> [Angles; 2] {
    let (radar, camera) = (m321(RADAR), m321(CAMERA));
    [angles(&(camera.transpose() * radar)), angles(&(radar.transpose() * camera))]
}

#[cfg(test)]
mod tests {
    use nalgebra::Rotation3;

    use super::*;

    #[test]
    fn m321_is_heading_then_pitch_then_roll() {
        let [heading, pitch, roll] = CAMERA.map(f64::to_radians);
        let rotation = Rotation3::from_euler_angles(roll, pitch, heading);
        assert!((m321(CAMERA) - rotation.matrix().transpose()).norm() < 1e-15);
        for (angle, back) in CAMERA.into_iter().zip(angles(&m321(CAMERA))) {
            assert!((angle - back).abs() < 1e-12);
        }
    }

    #[test]
    fn table_1_is_of_the_transposed_product() {
        let [table, equation_3] = products();
        for (angle, printed) in table.into_iter().zip(RELATIVE) {
            assert!((angle - printed).abs() < 0.005, "{table:?}");
        }
        for (angle, expected) in table.into_iter().zip([-0.863, -0.163, -0.607]) {
            assert!((angle - expected).abs() < 0.001, "{table:?}");
        }
        assert!(equation_3.into_iter().zip(RELATIVE).any(|(angle, printed)| (angle + printed).abs() > 0.005));
    }
}
