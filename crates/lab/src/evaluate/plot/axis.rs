//! Axes: conversion from values to pixels, and ticks.

/// Largest value that is drawn. Larger ones are not plausible as positions or errors (metres) or times (minutes).
const DRAWABLE_MAX: f64 = 1e9;

/// Maximum number of ticks of a linear axis; there may be one more.
const TICKS: f64 = 8.0;

/// Whether a value can be drawn.
pub(super) fn drawable(value: f64) -> bool {
    value.abs() <= DRAWABLE_MAX
}

/// One axis of a figure.
#[derive(Clone, Debug)]
pub(super) struct PlotAxis {
    pub(super) label: String,
    pub(super) from: f64,
    pub(super) to: f64,
    logarithmic: bool,
    /// Value and text of each tick; a grid line without text is a minor one.
    pub(super) ticks: Vec<(f64, String)>,
}

impl PlotAxis {
    /// Linear axis from `from` to `to`, with ticks at round numbers. An interval of length zero is widened, so that a
    /// single value can be shown.
    pub(super) fn linear(label: impl Into<String>, from: f64, to: f64) -> Self {
        Self::stepped(label, from, to, None)
    }

    /// Like [`PlotAxis::linear`], with ticks at the multiples of `step` if given.
    pub(super) fn stepped(label: impl Into<String>, from: f64, to: f64, step: Option<f64>) -> Self {
        let least = 1e-6 * from.abs().max(to.abs()).max(1.0);
        let (from, to) = if to - from > least {
            (from, to)
        } else {
            let half = 0.5 * (0.1 * from.abs()).clamp(1.0, 10.0);
            (from - half, to + half)
        };
        let step = step.unwrap_or_else(|| round_step((to - from) / TICKS));
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        let (first, last) = ((from / step - 1e-9).ceil() as i64, (to / step + 1e-9).floor() as i64);
        let ticks = (first..=last).map(|count| {
            let value = count as f64 * step;
            (value, decimal(value, decimals))
        });
        Self { label: label.into(), from, to, logarithmic: false, ticks: ticks.collect() }
    }

    /// Logarithmic axis of at least one decade. It begins and ends at values of 1, 2 or 5 times a power of ten, which
    /// enclose `from` and `to`; both are above zero.
    pub(super) fn logarithmic(label: impl Into<String>, from: f64, to: f64) -> Self {
        let to = round_step(to.max(from));
        let from = 1.0 / round_step(1.0 / from.min(to / 10.0));
        let (low, high) = (from.log10().floor() as i32, to.log10().ceil() as i32);
        let few = to / from <= 1001.0;
        let mut ticks = Vec::new();
        for (decade, times) in (low..=high).flat_map(|decade| (1..10).map(move |times| (decade, times))) {
            // Division gives the float nearest to 0.2, as parsing its text does.
            let power = 10_f64.powi(decade.abs());
            let value = if decade < 0 { f64::from(times) / power } else { f64::from(times) * power };
            if (from * (1.0 - 1e-9)..=to * (1.0 + 1e-9)).contains(&value) {
                let said = times == 1 || few && (times == 2 || times == 5);
                let decimals = usize::try_from(-decade).unwrap_or(0);
                ticks.push((value, if said { decimal(value, decimals) } else { String::new() }));
            }
        }
        Self { label: label.into(), from, to, logarithmic: true, ticks }
    }

    /// Position of `value` along the axis: 0 at its beginning, 1 at its end.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        if self.logarithmic {
            let low = self.from.log10();
            (value.max(f64::MIN_POSITIVE).log10() - low) / (self.to.log10() - low)
        } else {
            (value - self.from) / (self.to - self.from)
        }
    }

    pub(super) fn holds(&self, value: f64) -> bool {
        (self.from..=self.to).contains(&value)
    }
}

/// The next of 1, 2 and 5 times a power of ten.
pub(super) fn round_step(at_least: f64) -> f64 {
    let power = 10_f64.powf(at_least.log10().floor());
    let times = [1.0, 2.0, 5.0].into_iter().find(|times| times * power >= at_least * (1.0 - 1e-9));
    times.unwrap_or(10.0) * power
}

/// Formats `value` with separated thousands and a true minus sign.
pub(super) fn decimal(value: f64, decimals: usize) -> String {
    let digits = format!("{:.decimals$}", value.abs());
    let (whole, fraction) = match digits.split_once('.') {
        Some((whole, fraction)) => (whole, Some(fraction)),
        None => (digits.as_str(), None),
    };
    let mut text = String::new();
    if value < 0.0 && digits.bytes().any(|digit| digit.is_ascii_digit() && digit != b'0') {
        text.push('\u{2212}');
    }
    for (index, digit) in whole.chars().enumerate() {
        if index > 0 && (whole.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    if let Some(fraction) = fraction {
        text.push('.');
        text.push_str(fraction);
    }
    text
}

/// Interval of the values. If outliers would stretch it to more than twice its length, the lowest and highest half
/// percent are ignored.
///
/// `None` without values; reorders them.
pub(super) fn span(values: &mut [f64]) -> Option<(f64, f64)> {
    values.sort_unstable_by(f64::total_cmp);
    let (lowest, highest) = (*values.first()?, *values.last()?);
    let spare = if values.len() < 20 { 0 } else { (values.len() / 200).max(1) };
    let (low, high) = (values[spare], values[values.len() - 1 - spare]);
    Some(if highest - lowest <= 2.0 * (high - low) { (lowest, highest) } else { (low, high) })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(axis: &PlotAxis) -> Vec<&str> {
        axis.ticks.iter().map(|(_, text)| text.as_str()).filter(|text| !text.is_empty()).collect()
    }

    #[test]
    fn ticks_are_round_and_within_the_axis() {
        assert_eq!(texts(&PlotAxis::linear("", 0.0, 6.55)), ["0", "1", "2", "3", "4", "5", "6"]);
        assert_eq!(texts(&PlotAxis::linear("", -1200.0, 950.0)), ["−1,000", "−500", "0", "500"]);
        assert_eq!(texts(&PlotAxis::linear("", 0.0, 0.1)), ["0.00", "0.02", "0.04", "0.06", "0.08", "0.10"]);
        assert_eq!(texts(&PlotAxis::logarithmic("", 0.3, 13.0)), ["0.2", "0.5", "1", "2", "5", "10", "20"]);
        assert_eq!(texts(&PlotAxis::logarithmic("", 0.02, 4300.0)), ["0.1", "1", "10", "100", "1,000"]);
        assert_eq!(texts(&PlotAxis::logarithmic("", 1.0, 1.0)), ["0.1", "0.2", "0.5", "1"]);
        assert_eq!(texts(&PlotAxis::stepped("", 0.0, 360.0, Some(90.0))), ["0", "90", "180", "270", "360"]);
    }

    #[test]
    fn single_value_is_centred_on_the_axis() {
        for value in [0.0, 57.0, -1e9] {
            assert_eq!(PlotAxis::linear("", value, value).fraction(value), 0.5);
        }
    }

    #[test]
    fn few_outliers_do_not_stretch_the_axis_span() {
        let mut values: Vec<f64> = (0..1000).map(f64::from).collect();
        assert_eq!(span(&mut values), Some((0.0, 999.0)));
        values[999] = 1e6;
        assert_eq!(span(&mut values), Some((5.0, 994.0)));
        assert_eq!(span(&mut [3.0, 1.0]), Some((1.0, 3.0)));
        assert_eq!(span(&mut []), None);
    }
}
