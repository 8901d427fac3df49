//! Whether the parts of a recording agree with each other.

use nalgebra::Vector3;

use crate::fit::{Both, Fit, Recording, partial, prior_sigmas};
use crate::not_located::NotLocated;
use crate::pose::PARAMETERS;

/// Distance between the halves of a recording, in deviations, from which they contradict each other.
const CONTRADICTORY: f64 = 5.0;
/// Duration of a block whose scatter is compared with the covariance, seconds.
const BLOCK_S: f64 = 60.0;
/// Weight of the model, in blocks: the scatter of few blocks says little.
const MODEL_BLOCKS: f64 = 8.0;

/// Factor of the covariance: how much more the blocks scatter than the noise explains (a sandwich estimate); at least 1.
///
/// # Errors
/// The halves of the recording contradict each other.
pub(crate) fn scatter(recording: &Recording<'_>, fit: &Fit, both: &Both) -> Result<f64, NotLocated> {
    let (first_s, last_s) = recording.pieces.iter().fold((f64::INFINITY, 0.0_f64), |(first, last), piece| {
        (first.min(piece.span_s().0), last.max(piece.span_s().1))
    });
    let blocks = ((last_s - first_s) / BLOCK_S).ceil().max(1.0) as usize;
    let (mut measured, mut expected, mut count) = (0.0, 0.0, 0.0);
    for path in 0..recording.paths.len() {
        for block in 0..blocks {
            let from_s = first_s + block as f64 * BLOCK_S;
            let of = partial(both, &fit.noise, |of, time_s| {
                of == path && (from_s..from_s + BLOCK_S).contains(&time_s)
            });
            let gradient = of.fixed_view::<PARAMETERS, 1>(0, PARAMETERS).into_owned();
            let information = of.fixed_view::<PARAMETERS, PARAMETERS>(0, 0).into_owned();
            let share = (fit.covariance * information).trace();
            if share > 0.0 {
                measured += (gradient.transpose() * fit.covariance * gradient)[0];
                expected += share;
                count += 1.0;
            }
        }
    }
    let ratio = if expected > 0.0 { measured / expected } else { 1.0 };
    // The fit itself makes the gradients smaller.
    let freed = count / (count - 4.0_f64).max(1.0);
    let factor = ((ratio * freed * count + MODEL_BLOCKS) / (count + MODEL_BLOCKS)).max(1.0);
    let middle_s = f64::midpoint(first_s, last_s);
    let halves = [true, false].map(|is_first| {
        let of = partial(both, &fit.noise, |_, time_s| (time_s < middle_s) == is_first);
        half(&of, recording.up_m.1)
    });
    if let [Some((first, first_covariance)), Some((second, second_covariance))] = halves {
        let difference = first - second;
        let covariance = (first_covariance + second_covariance) * factor;
        // East, north and bearing.
        let chosen = [0, 1, 3];
        let part = nalgebra::Matrix3::from_fn(|row, column| covariance[(chosen[row], chosen[column])]);
        let away = Vector3::from_fn(|row, _| difference[chosen[row]]);
        let square = part.cholesky().map_or(0.0, |factor| away.dot(&factor.solve(&away)));
        // Root mean square over the three values.
        let deviations = (square / 3.0).sqrt();
        if deviations > CONTRADICTORY {
            return Err(NotLocated::Contradictory { deviations });
        }
    }
    Ok(factor)
}

type Half = (nalgebra::SVector<f64, PARAMETERS>, nalgebra::SMatrix<f64, PARAMETERS, PARAMETERS>);

fn half(
    of: &nalgebra::SMatrix<f64, { PARAMETERS + 1 }, { PARAMETERS + 1 }>,
    up_sigma_m: f64,
) -> Option<Half> {
    let mut information = of.fixed_view::<PARAMETERS, PARAMETERS>(0, 0).into_owned();
    for (index, sigma) in prior_sigmas(up_sigma_m).iter().enumerate() {
        information[(index, index)] += sigma.powi(-2);
    }
    let covariance = information.cholesky()?.inverse();
    Some((covariance * of.fixed_view::<PARAMETERS, 1>(0, PARAMETERS), covariance))
}
