//! Common parts of the experiments based on papers: random draws, statistics, parallel runs, and a page made of text
//! and measured numbers.

use std::fs;
use std::ops::RangeInclusive;
use std::path::Path;
use std::time::Instant;

use clap::Parser;
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use utm_fusion::evaluate::plot::Figure;

#[path = "../evaluation/parallel.rs"]
mod parallel;

/// First seed that is not used for tuning.
pub const FIRST_SEED: u64 = 1001;

/// Writes the experiment's page in docs, with its figures.
#[derive(Parser)]
pub struct Args {
    /// Print the requirements and write nothing.
    #[arg(long)]
    pub quick: bool,
    /// First seed.
    #[arg(long, requires = "quick", default_value_t = FIRST_SEED)]
    pub first_seed: u64,
    /// Number of runs; by default that of the page.
    #[arg(long, requires = "quick")]
    pub runs: Option<u64>,
}

/// Error that stops an experiment.
pub type ExperimentFailure = Box<dyn std::error::Error + Send + Sync>;

/// Random numbers of a run.
pub struct Draws(pub ChaCha8Rng);

impl Draws {
    pub fn of(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// Normal, with mean zero.
    pub fn normal(&mut self, sigma: f64) -> f64 {
        let unit: f64 = StandardNormal.sample(&mut self.0);
        sigma * unit
    }
}

/// Applies `of` to each seed, on all cores. Returns the results in the order of the seeds.
pub fn runs<R: Send>(first_seed: u64, count: u64, of: impl Fn(u64) -> R + Sync) -> Vec<R> {
    let seeds: Vec<u64> = (first_seed..first_seed + count).collect();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    parallel::each(&seeds, threads, |_, seed| of(*seed))
}

/// Mean of values; zero without values.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Root mean square; zero without values.
pub fn rms(values: &[f64]) -> f64 {
    mean(&values.iter().map(|value| value * value).collect::<Vec<_>>()).sqrt()
}

/// Value below which this share of all values lies, interpolated linearly; zero without values.
pub fn quantile(values: &[f64], share: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_unstable_by(f64::total_cmp);
    let Some(last) = sorted.len().checked_sub(1) else { return 0.0 };
    let place = share * last as f64;
    let (below, above) = (sorted[place.floor() as usize], sorted[place.ceil() as usize]);
    below + place.fract() * (above - below)
}

/// Formats a number for a page, with three significant digits.
pub fn said(value: f64) -> String {
    let whole = value.abs().log10().floor();
    let decimals = if whole.is_finite() { (2.0 - whole).clamp(0.0, 3.0) as usize } else { 0 };
    format!("{value:.decimals$}").replace('-', "−")
}

/// A requirement on an experiment.
pub struct ExperimentRequirement {
    pub what: String,
    pub required: String,
    pub measured: String,
    pub met: bool,
}

impl ExperimentRequirement {
    /// Requirement that a value lies within an interval, which may be open on one side.
    pub fn within(what: impl Into<String>, value: f64, interval: RangeInclusive<f64>) -> Self {
        let (low, high) = (*interval.start(), *interval.end());
        let required = match (low.is_finite(), high.is_finite()) {
            (true, true) => format!("{} to {}", said(low), said(high)),
            (true, false) => format!("≥ {}", said(low)),
            _ => format!("≤ {}", said(high)),
        };
        Self { what: what.into(), required, measured: said(value), met: interval.contains(&value) }
    }
}

/// Markdown table of all requirements.
pub fn requirement_table(requirements: &[ExperimentRequirement]) -> String {
    let mut table = "| | required | measured |\n|---|---|---|\n".to_owned();
    for ExperimentRequirement { what, required, measured, met } in requirements {
        let met = if *met { "" } else { ", **not met**" };
        table.push_str(&format!("| {what} | {required} | {measured}{met} |\n"));
    }
    table
}

/// Fills a page: replaces `{{name}}` in its text by measured values.
pub fn page(words: &str, measured: &[(&str, String)]) -> Result<String, ExperimentFailure> {
    let mut page = words.to_owned();
    for (name, text) in measured {
        let place = format!("{{{{{name}}}}}");
        if !page.contains(&place) {
            return Err(format!("the page has no place for {name}").into());
        }
        page = page.replace(&place, text.trim_end());
    }
    match page.find("{{") {
        Some(at) => Err(format!("nothing was measured for {:.30}", &page[at..]).into()),
        None => Ok(page),
    }
}

/// Writes a page of `docs/`, and its figures beside it.
pub fn write(name: &str, page: &str, figures: &[Figure]) -> Result<(), ExperimentFailure> {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs");
    for figure in figures {
        fs::write(docs.join("images").join(format!("{}.svg", figure.name)), &figure.svg)?;
    }
    fs::write(docs.join(name), page)?;
    Ok(())
}

/// Markdown that shows the figures.
pub fn shown(figures: &[Figure]) -> String {
    figures
        .iter()
        .map(|Figure { name, title, caption, .. }| {
            format!("![{title}](images/{name}.svg)\n\n*{title}.* {caption}\n\n")
        })
        .collect()
}

/// Returns the result of `work`, and its duration in seconds.
#[expect(clippy::disallowed_methods, reason = "an experiment reports how long it took")]
pub fn timed<R>(work: impl FnOnce() -> R) -> (R, f64) {
    let start = Instant::now();
    let made = work();
    (made, start.elapsed().as_secs_f64())
}
