//! Physical values as counts.

/// The count of steps nearest to a value, within limits. NaN counts as 0.
pub(crate) fn nearest(value: f64, step: f64, least: f64, most: f64) -> f64 {
    let count = (value / step).round();
    if count.is_nan() { 0.0_f64.clamp(least, most) } else { count.clamp(least, most) }
}
