//! Measures of random worlds.

use super::figures::{WorldFigures, flags_an_hour};
use crate::results::{ResultRow, measured};
use crate::summary::MeanValue;

/// Range within which the NEES of a world is consistent.
const CONSISTENT: (f64, f64) = (0.6, 1.6);

/// All rows.
pub fn rows(worlds: &[WorldFigures]) -> Vec<ResultRow> {
    let of = |figure: fn(&WorldFigures) -> Option<f64>| -> Vec<f64> {
        let mut values: Vec<f64> = worlds.iter().filter_map(figure).collect();
        values.sort_by(f64::total_cmp);
        values
    };
    let (covered, gospa) = (of(|world| world.covered), of(|world| world.gospa));
    let (beyond, beyond_height) = (of(|world| world.beyond), of(|world| world.beyond_height));
    let both = of(|world| {
        world.nees.zip(world.nees_height).map(|(over_ground, height)| {
            f64::from(u8::from(is_consistent(over_ground) && is_consistent(height)))
        })
    });
    let flags = flags_an_hour(&worlds.iter().collect::<Vec<_>>());
    let worst = |values: &[f64]| one(values.last().copied(), values.len());
    vec![
        row("covered error / transponder's, median world", one(median(&covered), covered.len())),
        row("the same, worst world", worst(&covered)),
        row("GOSPA / paper's (`reference`), worst world", worst(&gospa)),
        share("NEES over ground within 0.6 to 1.6, percent of worlds", &consistent(&of(|world| world.nees))),
        share(
            "NEES in height within 0.6 to 1.6, percent of worlds",
            &consistent(&of(|world| world.nees_height)),
        ),
        share("both, percent of worlds", &both),
        row("points beyond 3.7 of their own deviations over ground, percent, worst world", worst(&beyond)),
        row("the same in height", worst(&beyond_height)),
        row("flags on honest transponders an hour, all worlds", one(flags, worlds.len())),
    ]
}

fn is_consistent(nees: f64) -> bool {
    (CONSISTENT.0..=CONSISTENT.1).contains(&nees)
}

fn consistent(nees: &[f64]) -> Vec<f64> {
    nees.iter().map(|&nees| f64::from(u8::from(is_consistent(nees)))).collect()
}

fn row(measure: &str, result: Option<MeanValue>) -> ResultRow {
    ResultRow::new(measure, measured(result, None))
}

/// Mean of zeros and ones, percent.
fn share(measure: &str, worlds: &[f64]) -> ResultRow {
    let percent: Vec<f64> = worlds.iter().map(|is_so| 100.0 * is_so).collect();
    row(measure, MeanValue::of(&percent)).decimals(0)
}

fn one(value: Option<f64>, count: usize) -> Option<MeanValue> {
    value.map(|mean| MeanValue { mean, error: None, count })
}

/// Median of sorted values.
fn median(values: &[f64]) -> Option<f64> {
    let middle = values.len() / 2;
    match values.len() {
        0 => None,
        count if count % 2 == 1 => Some(values[middle]),
        _ => Some((values[middle - 1] + values[middle]) / 2.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worlds(covered: &[f64], nees: &[f64]) -> Vec<WorldFigures> {
        let world = |(&covered, &nees)| WorldFigures {
            covered: Some(covered),
            nees: Some(nees),
            nees_height: Some(1.0),
            flags: 1,
            hours: 2.0,
            ..WorldFigures::default()
        };
        covered.iter().zip(nees).map(world).collect()
    }

    #[test]
    fn summary_shows_median_worst_and_shares() {
        let rows = rows(&worlds(&[0.8, 1.1, 0.88, 0.7], &[0.5, 1.0, 1.6, 3.0]));
        let text = crate::results::table(&rows, crate::results::SideColumn::Count);
        let results: Vec<&str> = text.lines().skip(2).filter_map(|line| line.split(" | ").last()).collect();
        assert_eq!(results[..3], ["0.84 |", "1.10 |", "– |"]);
        assert!(results[3].starts_with("50 ±"), "{}", results[3]);
        assert!(results[4].starts_with("100 ±"), "{}", results[4]);
        assert!(results[5].starts_with("50 ±"), "{}", results[5]);
        assert_eq!(results[8], "0.50 |");
    }

    #[test]
    fn median_of_an_even_count_is_between_the_middle_two() {
        assert_eq!(median(&[]), None);
        assert_eq!(median(&[1.0, 2.0, 4.0]), Some(2.0));
        assert_eq!(median(&[1.0, 2.0, 4.0, 9.0]), Some(3.0));
    }
}
