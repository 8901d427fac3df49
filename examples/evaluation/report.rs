//! The document: tables and their explanations.

use std::fmt::Write as _;
use std::ops::RangeInclusive;

use crate::figures::*;
use crate::flights::{FlightRow, RECORDINGS, SCENARIOS};
use crate::integrity;
use crate::limit;
use crate::measures::{self, OtherResults};
use crate::reference_measures;
use crate::results::{self, SideColumn};
use crate::score::FlightScores;
use crate::sheet;
use crate::summary::{MeanValue, SeedScores, show};
use crate::table::table;
use crate::themes;
use crate::variants::{BIAS_EQUIPPED, PAPER, VARIANTS};
use crate::worlds;

/// Markers around the section of the real flights, which is copied if these are not available.
const REAL: (&str, &str) = ("<!-- real flights -->", "<!-- end of real flights -->");

/// Contents of the document.
pub struct EvaluationDocument<'a> {
    pub scores: &'a [FlightScores],
    pub other: &'a OtherResults,
    pub seeds: RangeInclusive<u64>,
    pub city_seeds: u64,
    /// The existing document.
    pub before: &'a str,
}

impl<'a> EvaluationDocument<'a> {
    /// The whole document.
    pub fn text(&self) -> String {
        let (first, last) = (self.seeds.start(), self.seeds.end());
        let seeds = format!("{first} to {last}, of `city` {} of them", self.city_seeds);
        [
            include_str!("words/opening.md").replace("{seeds}", &seeds),
            self.results(),
            self.table_1(),
            self.simulated(),
            limit::section(&self.other.limit),
            self.meaning(),
            format!("{}\n{}", include_str!("words/variants.md"), self.variants()),
            format!("{}\n{}", include_str!("words/sheet.md"), self.sheet()),
            worlds::section(&self.other.worlds),
            self.real(),
            include_str!("words/closing.md").to_owned(),
        ]
        .join("\n")
    }

    /// Tables of all measures, and the reasons for results that fall short.
    fn results(&self) -> String {
        let measures = measures::rows(self.scores, self.other);
        let integrity = integrity::rows(&self.other.integrity);
        let reference = reference_measures::rows(self.scores, self.other);
        [
            include_str!("words/results.md").to_owned(),
            results::table(&measures, SideColumn::None),
            include_str!("words/integrity.md").to_owned(),
            results::table(&integrity, SideColumn::Count),
            include_str!("words/reference.md").to_owned(),
            results::table(&reference, SideColumn::Reference),
            "### Where results fall short\n".to_owned(),
            results::limitations(measures.iter().chain(&integrity).chain(&reference)),
        ]
        .join("\n")
    }

    fn row(&self, name: &'static str) -> SeedScores<'a> {
        SeedScores::of(self.scores, &FlightRow::Scenario(name))
    }

    fn scenarios(&self) -> impl Iterator<Item = (String, SeedScores<'a>)> + '_ {
        SCENARIOS.into_iter().map(|name| (format!("`{name}`"), self.row(name)))
    }

    /// The scenarios; after `bias`, the same flights with every drone equipped.
    fn rows(&self) -> Vec<(String, SeedScores<'a>)> {
        let mut rows: Vec<_> = self.scenarios().collect();
        let beside = SCENARIOS.iter().position(|&name| name == "bias").map_or(0, |place| place + 1);
        let equipped = SeedScores::of(self.scores, &FlightRow::Variant(BIAS_EQUIPPED));
        rows.insert(beside, (format!("`{BIAS_EQUIPPED}`"), equipped));
        rows
    }

    /// The paper's Table 1: for its own flight as far as known, and for `bias`.
    fn table_1(&self) -> String {
        let paper = SeedScores::of(self.scores, &FlightRow::Variant(PAPER));
        [
            include_str!("words/table_1.md").to_owned(),
            Self::table_1_of(&paper),
            include_str!("words/table_1_bias.md").to_owned(),
            Self::table_1_of(&self.row("bias")),
        ]
        .join("\n")
    }

    fn table_1_of(seeds: &SeedScores<'_>) -> String {
        let rows: [(&str, ScoreFigure, usize, [&str; 3]); 7] = [
            ("PU, 4 Hz ref. (%)", PU, 2, ["48.41", "41.61", "+6.80 points"]),
            ("mean ePos (m)", EPOS, 2, ["5.13", "59.66", "91.4 %"]),
            ("SEM ePos (m)", SEM_EPOS, 3, ["0.230", "1.615", "85.8 %"]),
            ("mean ePosH (m)", EPOSH, 2, ["5.03", "58.66", "91.4 %"]),
            ("SEM ePosH (m)", SEM_EPOSH, 3, ["0.232", "1.629", "85.8 %"]),
            ("mean ePosV (m)", EPOSV, 2, ["0.67", "7.93", "91.5 %"]),
            ("SEM ePosV (m)", SEM_EPOSV, 3, ["0.028", "0.240", "88.4 %"]),
        ];
        let mut text = String::from(
            "| metric | radar | `reference` | change | `operational` | change | paper: radar | fused | change |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|\n",
        );
        for (name, figure, decimals, [paper_fused, paper_radar, paper_change]) in rows {
            let radar = seeds.of_group(RADAR.equipped, figure);
            let change = |fused: Option<MeanValue>| {
                fused.zip(radar).map_or("–".to_owned(), |(fused, radar)| match name {
                    _ if name.starts_with("PU") => format!("{:+.2} points", fused.mean - radar.mean),
                    _ => format!("{:.1} %", 100.0 * (1.0 - fused.mean / radar.mean)),
                })
            };
            let mut cells = vec![show(radar, decimals)];
            for profile in [REFERENCE, OPERATIONAL] {
                let fused = seeds.of_group(profile.equipped, figure);
                cells.extend([show(fused, decimals), change(fused)]);
            }
            let cells = cells.join(" | ");
            let _ = writeln!(text, "| {name} | {cells} | {paper_radar} | {paper_fused} | {paper_change} |");
        }
        text
    }

    fn simulated(&self) -> String {
        let mut text = String::from("## Simulated flights\n");
        for (head, columns) in themes::simulated() {
            let _ = write!(text, "\n### {head}\n\n{}", table("scenario", self.rows(), &columns));
        }
        text
    }

    fn variants(&self) -> String {
        let rows = VARIANTS.map(|variant| {
            (format!("`{}`", variant.name), SeedScores::of(self.scores, &FlightRow::Variant(variant.name)))
        });
        table("scenario", rows, &themes::in_short())
    }

    fn sheet(&self) -> String {
        let rows = sheet::BASES.into_iter().flat_map(sheet::rows);
        let rows = rows.map(|(name, row)| (name, SeedScores::of(self.scores, &row)));
        table("true errors", rows, &themes::sheet())
    }

    /// Explanation of the tables, with their numbers.
    fn meaning(&self) -> String {
        let over_scenarios = |figure: &dyn Fn(&SeedScores<'_>) -> Option<MeanValue>, decimals: usize| {
            let means: Vec<f64> =
                self.scenarios().filter_map(|(_, seeds)| figure(&seeds)).map(|mean| mean.mean).collect();
            let low = means.iter().copied().fold(f64::INFINITY, f64::min);
            let high = means.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            format!("{low:.decimals$} to {high:.decimals$}")
        };
        let of = |group: ScoreGroup, figure: ScoreFigure, decimals: usize| {
            over_scenarios(&|seeds| seeds.of_group(group, figure), decimals)
        };
        let ratio = |of: ScoreGroup, over: ScoreGroup, figure: ScoreFigure| {
            over_scenarios(&|seeds| seeds.ratio(of, over, figure), 2)
        };
        let points = |of: ScoreGroup, over: ScoreGroup| {
            over_scenarios(&|seeds| seeds.mean(|scores| Some(PU(of(scores))? - PU(over(scores))?)), 0)
        };
        let one = |name, group: ScoreGroup, figure: ScoreFigure, decimals| {
            show(self.row(name).of_group(group, figure), decimals)
        };
        let (us, paper) = (OPERATIONAL, REFERENCE);
        let in_bias = self.row("bias").ratio(paper.equipped, TRANSPONDER.equipped, COVERED);
        let words = [
            ("{covered_ratio}", ratio(paper.equipped, TRANSPONDER.equipped, COVERED)),
            ("{covered_ratio_now}", ratio(us.equipped, TRANSPONDER.equipped, COVERED)),
            ("{gap_ratio}", ratio(paper.equipped, RADAR.equipped, GAP)),
            ("{gap_ratio_now}", ratio(us.equipped, RADAR.equipped, GAP)),
            ("{pu_lost}", points(TRANSPONDER.equipped, paper.equipped)),
            ("{pu_equipped}", of(paper.equipped, PU, 0)),
            ("{pu_equipped_now}", of(us.equipped, PU, 0)),
            ("{pu_unequipped}", of(paper.unequipped, PU, 0)),
            ("{pu_unequipped_now}", of(us.unequipped, PU, 0)),
            ("{pu_radar_unequipped}", of(RADAR.unequipped, PU, 0)),
            ("{precision}", of(paper.all, PRECISION, 2)),
            ("{precision_now}", of(us.all, PRECISION, 2)),
            ("{id_changes}", of(paper.all, ID_CHANGES, 1)),
            ("{id_changes_now}", of(us.all, ID_CHANGES, 2)),
            ("{gap_near}", of(paper.equipped, GAP_WITHIN_50_M, 0)),
            ("{gap_near_now}", of(us.equipped, GAP_WITHIN_50_M, 0)),
            ("{false_track}", of(paper.all, FALSE_TRACK, 0)),
            ("{false_track_now}", of(us.all, FALSE_TRACK, 0)),
            ("{against_radar}", ratio(paper.equipped, RADAR.equipped, EPOS)),
            ("{pu_won}", points(paper.equipped, RADAR.equipped)),
            ("{bias_ratio}", show(in_bias, 2)),
            ("{spoof_fused}", one("spoof", paper.equipped, COVERED, 1)),
            ("{spoof_now}", one("spoof", us.equipped, COVERED, 1)),
            ("{bias_unequipped}", one("bias", paper.unequipped, EPOS, 0)),
            ("{crossing_unequipped}", one("crossing", paper.unequipped, EPOS, 0)),
        ];
        let text = include_str!("words/meaning.md").to_owned();
        words.iter().fold(text, |text, (name, number)| text.replace(name, number))
    }

    /// Section of the real flights; copied from the existing document if these are not available.
    fn real(&self) -> String {
        let clean = RECORDINGS.map(|name| (name.to_owned(), FlightRow::Clean(name)));
        let degraded = RECORDINGS.map(|name| (format!("{name}, degraded"), FlightRow::Degraded(name)));
        let prepared =
            RECORDINGS.map(|name| (format!("{name}, degraded, as recorded"), FlightRow::Prepared(name)));
        let rows = clean.into_iter().chain(degraded).chain(prepared);
        let rows: Vec<(String, SeedScores<'_>)> =
            rows.map(|(name, row)| (name, SeedScores::of(self.scores, &row))).collect();
        if rows.iter().all(|(_, seeds)| seeds.0.is_empty()) {
            let kept = self.before.split_once(REAL.0).and_then(|(_, rest)| rest.split_once(REAL.1));
            let kept =
                kept.map_or("\nNot measured yet: the recordings were not at hand.\n", |(kept, _)| kept);
            eprintln!("without recordings: the section of the real flights is kept as it was");
            return format!("{}{kept}{}\n", REAL.0, REAL.1);
        }
        let again = rows.iter().map(|(name, seeds)| (name.clone(), SeedScores(seeds.0.clone())));
        let first = table("flight", again, &themes::real());
        let second = table("flight", rows, &themes::real_by_slots());
        format!("{}\n{}\n{first}\n{second}{}\n", REAL.0, include_str!("words/real.md"), REAL.1)
    }
}

#[cfg(test)]
mod tests {
    /// The document is overwritten, so it must not have sections that the program does not write.
    #[test]
    fn document_has_only_written_sections() {
        let made = [
            include_str!("report.rs"),
            include_str!("words/results.md"),
            include_str!("words/closing.md"),
            include_str!("words/limit.md"),
            include_str!("words/meaning.md"),
            include_str!("words/real.md"),
            include_str!("words/sheet.md"),
            include_str!("words/table_1.md"),
            include_str!("words/variants.md"),
            include_str!("words/worlds.md"),
        ];
        for heading in include_str!("../../docs/EVALUATION.md").lines().filter(|line| line.starts_with("## "))
        {
            assert!(made.iter().any(|text| text.contains(heading)), "nothing writes \"{heading}\"");
        }
    }
}
