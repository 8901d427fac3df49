//! The document: tables, and what they mean.

use std::fmt::Write as _;

use crate::figures::*;
use crate::flights::{RECORDINGS, Row, SCENARIOS};
use crate::score::Scores;
use crate::summary::{Mean, Seeds, show};

/// Between these the section of the real flights stands, to be taken over where they are not at hand.
const REAL: (&str, &str) = ("<!-- real flights -->", "<!-- end of real flights -->");

/// Everything that the document is made of.
pub struct Report<'a> {
    scores: &'a [Scores],
    seeds: u64,
    city_seeds: u64,
    /// The document as it stood.
    before: &'a str,
}

/// A column of a table.
struct Column {
    name: &'static str,
    group: Group,
    figure: Figure,
    decimals: usize,
}

impl<'a> Report<'a> {
    pub fn new(scores: &'a [Scores], seeds: u64, city_seeds: u64, before: &'a str) -> Self {
        Self { scores, seeds, city_seeds, before }
    }

    /// The whole document.
    pub fn text(&self) -> String {
        let seeds = format!("{} seeds each, `city` {}", self.seeds, self.city_seeds);
        let opening = include_str!("opening.md").replace("{seeds}", &seeds);
        format!(
            "{opening}\n{}\n{}\n{}\n{}\n{}",
            self.table_1(),
            self.simulated(),
            self.meaning(),
            self.real(),
            include_str!("closing.md")
        )
    }

    fn row(&self, name: &'static str) -> Seeds<'a> {
        Seeds::of(self.scores, &Row::Scenario(name))
    }

    fn scenarios(&self) -> impl Iterator<Item = (&'static str, Seeds<'a>)> + '_ {
        SCENARIOS.into_iter().map(|name| (name, self.row(name)))
    }

    /// The paper's Table 1 on `bias`.
    fn table_1(&self) -> String {
        let bias = self.row("bias");
        let rows: [(&str, Figure, usize, [&str; 3]); 7] = [
            ("PU, 4 Hz ref. (%)", PU, 2, ["48.41", "41.61", "+6.80 points"]),
            ("mean ePos (m)", EPOS, 2, ["5.13", "59.66", "91.4 %"]),
            ("SEM ePos (m)", |score| score.epos.map(|error| error.sem_m), 3, ["0.230", "1.615", "85.8 %"]),
            ("mean ePosH (m)", EPOSH, 2, ["5.03", "58.66", "91.4 %"]),
            ("SEM ePosH (m)", |score| score.eposh.map(|error| error.sem_m), 3, ["0.232", "1.629", "85.8 %"]),
            ("mean ePosV (m)", EPOSV, 2, ["0.67", "7.93", "91.5 %"]),
            ("SEM ePosV (m)", |score| score.eposv.map(|error| error.sem_m), 3, ["0.028", "0.240", "88.4 %"]),
        ];
        let mut text = String::from(include_str!("table_1.md"));
        text += "\n| metric | fused | radar | change | paper: fused | radar | change |\n|---|---:|---:|---:|---:|---:|---:|\n";
        for (name, figure, decimals, paper) in rows {
            let (reference, radar) =
                (bias.of_group(reference_equipped, figure), bias.of_group(radar_equipped, figure));
            let change = reference.zip(radar).map_or("–".to_owned(), |(reference, radar)| match name {
                _ if name.starts_with("PU") => format!("{:+.2} points", reference.mean - radar.mean),
                _ => format!("{:.1} %", 100.0 * (1.0 - reference.mean / radar.mean)),
            });
            let [a, b, c] = paper;
            let _ = writeln!(
                text,
                "| {name} | {} | {} | {change} | {a} | {b} | {c} |",
                show(reference, decimals),
                show(radar, decimals)
            );
        }
        text
    }

    fn simulated(&self) -> String {
        let column = |name, group: Group, figure, decimals| Column { name, group, figure, decimals };
        let mut text = String::from("## Simulated flights\n\n### How often: PU, percent\n\n");
        text += &self.table(&[
            column("fused, all drones", reference, PU, 1),
            column("equipped: fused", reference_equipped, PU, 1),
            column("radar", radar_equipped, PU, 1),
            column("transponder", transponder_equipped, PU, 1),
            column("without transponder: fused", reference_unequipped, PU, 1),
            column("radar", radar_unequipped, PU, 1),
        ]);
        text += "\n### How exactly: mean position error, metres\n\n";
        text += &self.table(&[
            column("ePos: fused", reference, EPOS, 2),
            column("radar", radar, EPOS, 2),
            column("transponder", transponder, EPOS, 2),
            column("ePosH: fused", reference, EPOSH, 2),
            column("radar", radar, EPOSH, 2),
            column("transponder", transponder, EPOSH, 2),
            column("ePosV: fused", reference, EPOSV, 2),
            column("radar", radar, EPOSV, 2),
            column("transponder", transponder, EPOSV, 2),
        ]);
        text += "\n### Where the transponder is there, and where it is not: mean ePos of equipped drones, metres\n\n";
        text += &self.ratios();
        text += "\n### How rightly\n\n";
        text += &self.table(&[
            column("association precision", reference, PRECISION, 3),
            column("recall", reference, RECALL, 3),
            column("identity changes a drone and minute, equipped", reference_equipped, ID_CHANGES, 2),
            column("false track, s a minute: fused", reference, FALSE_TRACK, 1),
            column("radar", radar, FALSE_TRACK, 1),
            column("GOSPA, m: fused", reference, GOSPA, 1),
            column("radar", radar, GOSPA, 1),
            column("transponder", transponder, GOSPA, 1),
        ]);
        text
    }

    fn table(&self, columns: &[Column]) -> String {
        let names: Vec<&str> = columns.iter().map(|column| column.name).collect();
        let mut text =
            format!("| scenario | {} |\n|---|{}\n", names.join(" | "), "---:|".repeat(columns.len()));
        for (name, seeds) in self.scenarios() {
            let cell = |column: &Column| show(seeds.of_group(column.group, column.figure), column.decimals);
            let cells: Vec<String> = columns.iter().map(cell).collect();
            let _ = writeln!(text, "| `{name}` | {} |", cells.join(" | "));
        }
        text
    }

    /// Covered slots and gaps: the fused output against the better input of each.
    fn ratios(&self) -> String {
        let mut text = String::from(
            "| scenario | covered: fused | transponder | fused / transponder | in gaps: fused | radar | fused / radar |\n|---|---:|---:|---:|---:|---:|---:|\n",
        );
        for (name, seeds) in self.scenarios() {
            let covered = seeds.ratio(reference_equipped, transponder_equipped, COVERED);
            let gap = seeds.ratio(reference_equipped, radar_equipped, GAP);
            let _ = writeln!(
                text,
                "| `{name}` | {} | {} | {} | {} | {} | {} |",
                show(seeds.of_group(reference_equipped, COVERED), 2),
                show(seeds.of_group(transponder_equipped, COVERED), 2),
                show(covered, 2),
                show(seeds.of_group(reference_equipped, GAP), 1),
                show(seeds.of_group(radar_equipped, GAP), 1),
                show(gap, 2),
            );
        }
        text
    }

    /// What the tables say, with their own numbers.
    fn meaning(&self) -> String {
        let over_scenarios = |figure: &dyn Fn(&Seeds<'_>) -> Option<Mean>, decimals: usize| {
            let means: Vec<f64> =
                self.scenarios().filter_map(|(_, seeds)| figure(&seeds)).map(|mean| mean.mean).collect();
            let low = means.iter().copied().fold(f64::INFINITY, f64::min);
            let high = means.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            format!("{low:.decimals$} to {high:.decimals$}")
        };
        let of = |group: Group, figure: Figure| move |seeds: &Seeds<'_>| seeds.of_group(group, figure);
        let lost = |seeds: &Seeds<'_>| {
            seeds.mean(|scores| Some(PU(&scores.transponder.equipped)? - PU(&scores.reference.equipped)?))
        };
        let won = |seeds: &Seeds<'_>| {
            seeds.mean(|scores| Some(PU(&scores.reference.equipped)? - PU(&scores.radar.equipped)?))
        };
        let one = |name, group: Group, figure: Figure, decimals| {
            show(self.row(name).of_group(group, figure), decimals)
        };
        include_str!("meaning.md")
            .replace(
                "{covered_ratio}",
                &over_scenarios(&|s| s.ratio(reference_equipped, transponder_equipped, COVERED), 2),
            )
            .replace("{gap_ratio}", &over_scenarios(&|s| s.ratio(reference_equipped, radar_equipped, GAP), 2))
            .replace("{pu_lost}", &over_scenarios(&lost, 0))
            .replace("{pu_equipped}", &over_scenarios(&of(reference_equipped, PU), 0))
            .replace("{pu_unequipped}", &over_scenarios(&of(reference_unequipped, PU), 0))
            .replace("{pu_radar_unequipped}", &over_scenarios(&of(radar_unequipped, PU), 0))
            .replace("{precision}", &over_scenarios(&of(reference, PRECISION), 2))
            .replace("{id_changes}", &over_scenarios(&of(reference_equipped, ID_CHANGES), 1))
            .replace("{false_track}", &over_scenarios(&of(reference, FALSE_TRACK), 0))
            .replace(
                "{against_radar}",
                &over_scenarios(&|s| s.ratio(reference_equipped, radar_equipped, EPOS), 2),
            )
            .replace("{pu_won}", &over_scenarios(&won, 0))
            .replace(
                "{bias_ratio}",
                &show(self.row("bias").ratio(reference_equipped, transponder_equipped, COVERED), 2),
            )
            .replace("{spoof_fused}", &one("spoof", reference_equipped, COVERED, 1))
            .replace("{bias_unequipped}", &one("bias", reference_unequipped, EPOS, 0))
            .replace("{crossing_unequipped}", &one("crossing", reference_unequipped, EPOS, 0))
    }

    /// The real flights; as the document had them where they are not at hand.
    fn real(&self) -> String {
        let is_real = |scores: &&Scores| !matches!(scores.row, Row::Scenario(_));
        if !self.scores.iter().any(|scores| is_real(&scores)) {
            let kept = self.before.split_once(REAL.0).and_then(|(_, rest)| rest.split_once(REAL.1));
            let kept =
                kept.map_or("\nNot measured yet: the recordings were not at hand.\n", |(kept, _)| kept);
            eprintln!("without recordings: the section of the real flights is kept as it was");
            return format!("{}{kept}{}\n", REAL.0, REAL.1);
        }
        let mut text = format!("{}\n{}\n", REAL.0, include_str!("real.md"));
        text += "| flight | PU: fused | radar | transponder | ePosH: fused | radar | transponder | covered: fused / transponder | in gaps: fused | radar |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n";
        let clean = RECORDINGS.map(|name| (name, Row::Clean(name), ""));
        let degraded = RECORDINGS.map(|name| (name, Row::Degraded(name), ", degraded"));
        let prepared = RECORDINGS.map(|name| (name, Row::Prepared(name), ", degraded, as recorded"));
        for (name, row, how) in clean.into_iter().chain(degraded).chain(prepared) {
            let seeds = Seeds::of(self.scores, &row);
            let cell = |group: Group, figure: Figure, decimals| show(seeds.of_group(group, figure), decimals);
            let _ = writeln!(
                text,
                "| {name}{how} | {} | {} | {} | {} | {} | {} | {} | {} | {} |",
                cell(reference, PU, 1),
                cell(radar, PU, 1),
                cell(transponder, PU, 1),
                cell(reference, EPOSH, 2),
                cell(radar, EPOSH, 1),
                cell(transponder, EPOSH, 2),
                show(seeds.ratio(reference, transponder, COVERED), 2),
                cell(reference, GAP, 1),
                cell(radar, GAP, 1),
            );
        }
        format!("{text}{}\n", REAL.1)
    }
}
