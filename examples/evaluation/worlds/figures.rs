//! Figures of a world, and the columns that show them.

use crate::summary::MeanValue;

/// Figures of the `operational` profile in one flight of a world.
#[derive(Clone, Debug, Default)]
pub struct WorldFigures {
    /// Name of the scenario.
    pub name: String,
    pub seed: u64,
    /// Ratio of the error to the transponder's error on slots that the transponder covers: 3-D, and in height.
    pub covered: Option<f64>,
    pub vertical: Option<f64>,
    /// Probability of update, percent: of equipped drones, of these on covered slots, and of the other drones.
    pub update: Option<f64>,
    pub update_covered: Option<f64>,
    pub update_others: Option<f64>,
    /// Ratio of the error in gaps of the transponder to the radar's error.
    pub gap: Option<f64>,
    /// NEES of all points, over ground and in height.
    pub nees: Option<f64>,
    pub nees_height: Option<f64>,
    /// Share of all points with an error beyond 3.7 standard deviations, over ground and in height, percent.
    pub beyond: Option<f64>,
    pub beyond_height: Option<f64>,
    /// Number of flags on transponders, all of which are false, and hours of reporting.
    pub flags: usize,
    pub hours: f64,
    /// Share of fused points whose radar track and transponder belong to one drone.
    pub precision: Option<f64>,
    /// Changes of track number per drone and minute.
    pub id_changes: Option<f64>,
    /// Share of slots in which a drone has two numbers, percent.
    pub two_numbers: Option<f64>,
    /// Seconds of false tracks per minute.
    pub false_track_s: Option<f64>,
    /// Ratio of GOSPA to that of `reference`.
    pub gospa: Option<f64>,
}

/// A column of the tables.
#[derive(Clone, Copy)]
pub struct WorldColumn {
    head: &'static str,
    pub width: usize,
    decimals: usize,
    of: Combination,
}

/// Combination of several flights in a column.
#[derive(Clone, Copy)]
enum Combination {
    /// Mean over the flights.
    Mean(fn(&WorldFigures) -> Option<f64>),
    /// All flags divided by all hours.
    FlagsAnHour,
}

const fn column(
    head: &'static str,
    width: usize,
    decimals: usize,
    of: fn(&WorldFigures) -> Option<f64>,
) -> WorldColumn {
    WorldColumn { head, width, decimals, of: Combination::Mean(of) }
}

pub const COLUMNS: [WorldColumn; 17] = [
    column("covered/T", 9, 3, |figures| figures.covered),
    column("height/T", 8, 3, |figures| figures.vertical),
    column("PU", 5, 1, |figures| figures.update),
    column("PU cov.", 7, 1, |figures| figures.update_covered),
    column("PU uneq.", 8, 1, |figures| figures.update_others),
    column("gap/R", 6, 3, |figures| figures.gap),
    column("NEES", 6, 2, |figures| figures.nees),
    column("height", 6, 2, |figures| figures.nees_height),
    column("> 3.7 σ, %", 10, 2, |figures| figures.beyond),
    column("height", 6, 2, |figures| figures.beyond_height),
    WorldColumn { head: "flags/h", width: 7, decimals: 2, of: Combination::FlagsAnHour },
    column("precision", 9, 3, |figures| figures.precision),
    column("id/min", 6, 2, |figures| figures.id_changes),
    column("2 no., %", 8, 2, |figures| figures.two_numbers),
    column("false, s/min", 12, 1, |figures| figures.false_track_s),
    column("GOSPA/ref.", 10, 3, |figures| figures.gospa),
    column("flights", 7, 0, |_| None),
];

/// Headings, including the one of the first column.
pub fn heads(first: &str) -> Vec<String> {
    [vec![first.to_owned()], COLUMNS.map(|column| column.head.to_owned()).into()].concat()
}

/// A cell for each column.
pub fn cells(flights: &[&WorldFigures]) -> Vec<String> {
    let cell = |column: &WorldColumn| {
        let decimals = column.decimals;
        if column.head == "flights" {
            return flights.len().to_string();
        }
        let value = match column.of {
            Combination::Mean(of) => mean(flights, of).map(|mean| mean.mean),
            Combination::FlagsAnHour => flags_an_hour(flights),
        };
        value.map_or("–".to_owned(), |value| format!("{value:.decimals$}"))
    };
    COLUMNS.iter().map(cell).collect()
}

/// Mean over the flights that have the figure.
pub fn mean(flights: &[&WorldFigures], of: fn(&WorldFigures) -> Option<f64>) -> Option<MeanValue> {
    MeanValue::of(&flights.iter().filter_map(|figures| of(figures)).collect::<Vec<_>>())
}

/// Flags per hour on honest transponders; `None` without any reports.
pub fn flags_an_hour(flights: &[&WorldFigures]) -> Option<f64> {
    let flags: usize = flights.iter().map(|figures| figures.flags).sum();
    let hours: f64 = flights.iter().map(|figures| figures.hours).sum();
    (hours > 0.0).then(|| flags as f64 / hours)
}
