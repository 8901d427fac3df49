//! Values as counts.

/// The nearest count of steps to a value, within limits; 0 brought within them for what is no number.
pub(crate) fn nearest(value: f64, step: f64, least: f64, most: f64) -> f64 {
    let count = (value / step).round();
    if count.is_nan() { 0.0_f64.clamp(least, most) } else { count.clamp(least, most) }
}
