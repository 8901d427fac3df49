//! Text format of the metrics: families with their samples.

use std::fmt::{Display, Write};

use service::live::DurationHistogram;

/// The text so far. Names in the code lack the prefix. A name that ends in `_total` is a counter, any other a gauge, unless
/// stated otherwise.
pub(super) struct Metrics {
    prefix: &'static str,
    text: String,
}

impl Metrics {
    /// Empty text, with the prefix of all names.
    pub(super) fn new(prefix: &'static str) -> Self {
        Self { prefix, text: String::new() }
    }

    pub(super) fn into_text(self) -> String {
        self.text
    }

    pub(super) fn family(&mut self, name: &str, help: &str) {
        self.family_of(if name.ends_with("_total") { "counter" } else { "gauge" }, name, help);
    }

    pub(super) fn family_of(&mut self, kind: &str, name: &str, help: &str) {
        let prefix = self.prefix;
        // Writing to memory does not fail.
        let _ = writeln!(self.text, "# HELP {prefix}{name} {help}.\n# TYPE {prefix}{name} {kind}");
    }

    pub(super) fn sample(&mut self, name: &str, labels: &[(&str, &str)], value: impl Display) {
        let label = |(name, value): &(&str, &str)| {
            let escaped = value.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n");
            format!("{name}=\"{escaped}\"")
        };
        let labels: Vec<String> = labels.iter().map(label).collect();
        let braces = if labels.is_empty() { String::new() } else { format!("{{{}}}", labels.join(",")) };
        let _ = writeln!(self.text, "{}{name}{braces} {value}", self.prefix);
    }

    /// A family with one sample.
    pub(super) fn one(&mut self, name: &str, help: &str, value: impl Display) {
        self.family(name, help);
        self.sample(name, &[], value);
    }

    /// A family with one sample, if the value is known.
    pub(super) fn known(&mut self, name: &str, help: &str, value: Option<impl Display>) {
        if let Some(value) = value {
            self.one(name, help, value);
        }
    }

    /// A family with one sample per value of a label.
    pub(super) fn by<L: Display, V: Display>(
        &mut self,
        name: &str,
        help: &str,
        label: &str,
        samples: impl IntoIterator<Item = (L, V)>,
    ) {
        self.family(name, help);
        for (value, number) in samples {
            self.sample(name, &[(label, &value.to_string())], number);
        }
    }

    /// A histogram of durations.
    pub(super) fn histogram(&mut self, name: &str, help: &str, histogram: &DurationHistogram) {
        self.family_of("histogram", name, help);
        let bucket = format!("{name}_bucket");
        for (bound_s, count) in histogram.cumulative() {
            self.sample(&bucket, &[("le", &bound_s.to_string())], count);
        }
        self.sample(&bucket, &[("le", "+Inf")], histogram.count());
        self.sample(&format!("{name}_sum"), &[], histogram.sum_s());
        self.sample(&format!("{name}_count"), &[], histogram.count());
    }
}
