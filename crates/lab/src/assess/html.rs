//! The report as one HTML page without scripts, for the screen and for print.

use std::fmt::{self, Write};

use super::compare::ComparedFigure;
use super::types::{AssessmentFigure, AssessmentReport, AssessmentSection, Provenance, ReferenceKind};

const STYLE: &str = include_str!("style.css");
const METHOD: &str = include_str!("method.html");

/// Figures of the summary, if the report has them; `*` is a sensor.
const SUMMARY: [&str; 8] = [
    "detection.all",
    "interval.mean",
    "accuracy.horizontal.rms",
    "accuracy.horizontal.p95",
    "accuracy.vertical.rms",
    "tracking.changes",
    "tracking.false",
    "latency.p95",
];

/// The page.
///
/// # Errors
/// None: writing to a string cannot fail.
pub fn html(report: &AssessmentReport) -> Result<String, fmt::Error> {
    let mut page = String::new();
    let title = format!("Assessment: {}", report.provenance.site);
    write!(
        page,
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
        <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n<title>{0}</title>\n\
        <style>\n{STYLE}</style>\n</head>\n\
        <body>\n<h1>{0}</h1>\n",
        escaped(&title)
    )?;
    let reference = match report.assessment.reference {
        ReferenceKind::Truth => "Reference: the truth file.",
        ReferenceKind::Transponders => {
            "Reference: the reports of transponders in the recording, for want of a truth. Figures show agreement with them."
        }
    };
    writeln!(page, "<p class=\"lead\">{reference}</p>")?;
    provenance(&mut page, "What was assessed", &report.provenance)?;
    summary(&mut page, report)?;
    for section in &report.assessment.sections {
        self::section(&mut page, section)?;
    }
    writeln!(page, "<section id=\"cannot-say\">\n<h2>What this recording cannot say</h2>\n<dl>")?;
    for limit in &report.assessment.cannot_say {
        writeln!(page, "<dt>{}</dt><dd>{}</dd>", escaped(&limit.what), escaped(&capital(&limit.why)))?;
    }
    writeln!(page, "</dl>\n</section>")?;
    if let Some(against) = &report.against {
        comparison(&mut page, against, &report.comparison)?;
    }
    method(&mut page, report)?;
    page.push_str("</body>\n</html>\n");
    Ok(page)
}

fn provenance(page: &mut String, heading: &str, of: &Provenance) -> fmt::Result {
    writeln!(page, "<section>\n<h2>{heading}</h2>\n<table class=\"files\">")?;
    let commit = of.commit.as_deref().map_or(String::new(), |commit| format!(", commit {commit}"));
    let rows = [
        ("program", format!("{}{commit}", of.program)),
        ("site", of.site.clone()),
        ("profile", of.profile.clone()),
    ];
    for (name, value) in rows {
        writeln!(page, "<tr><th scope=\"row\">{name}</th><td>{}</td><td></td></tr>", escaped(&value))?;
    }
    for file in &of.files {
        writeln!(
            page,
            "<tr><th scope=\"row\">{}</th><td>{} ({} octets)</td><td class=\"hash\">SHA-256 {}</td></tr>",
            file.role,
            escaped(&file.name),
            file.octets,
            file.sha256
        )?;
    }
    writeln!(page, "</table>\n</section>")
}

/// The chief figures, a column for each subject.
fn summary(page: &mut String, report: &AssessmentReport) -> fmt::Result {
    let figures = || {
        let tables = report.assessment.sections.iter().flat_map(|section| &section.tables);
        tables.flat_map(|table| &table.figures)
    };
    let mut subjects: Vec<&str> = Vec::new();
    for figure in figures() {
        for end in SUMMARY {
            if let Some(subject) = figure.key.strip_suffix(end).and_then(|key| key.strip_suffix('.'))
                && !subjects.contains(&subject)
            {
                subjects.push(subject);
            }
        }
    }
    writeln!(page, "<section>\n<h2>Summary</h2>\n<table>\n<thead><tr><th scope=\"col\"></th>")?;
    for subject in &subjects {
        let name = subject.strip_prefix("sensor.").unwrap_or(subject);
        write!(page, "<th scope=\"col\" class=\"n\">{}</th>", escaped(name))?;
    }
    writeln!(page, "</tr></thead>\n<tbody>")?;
    for end in SUMMARY {
        let of = |subject: &str| figures().find(|figure| figure.key == format!("{subject}.{end}"));
        let Some(named) = subjects.iter().find_map(|subject| of(subject)) else { continue };
        let name = if end == "detection.all" { "probability of detection (update)" } else { &named.name };
        let name = match end.split('.').next() {
            Some("accuracy") => format!("error, {name}"),
            Some("latency") => format!("latency of reports, {name}"),
            _ => name.to_owned(),
        };
        write!(page, "<tr><th scope=\"row\">{}</th>", escaped(&name))?;
        for subject in &subjects {
            write!(
                page,
                "<td class=\"n\">{}</td>",
                of(subject).map_or_else(|| "–".to_owned(), with_interval)
            )?;
        }
        writeln!(page, "</tr>")?;
    }
    writeln!(page, "</tbody>\n</table>\n</section>")
}

/// A value with its unit, and the interval below.
fn with_interval(figure: &AssessmentFigure) -> String {
    let Some(value) = figure.value else { return "–".to_owned() };
    let interval = figure.interval.map_or(String::new(), |[low, high]| {
        format!("<br><small>{} to {}</small>", figure.printed(low), figure.printed(high))
    });
    format!("{} {}{interval}", figure.printed(value), figure.unit)
}

fn section(page: &mut String, section: &AssessmentSection) -> fmt::Result {
    writeln!(
        page,
        "<section id=\"{}\">\n<h2>{}</h2>\n<p>{}</p>",
        section.id,
        escaped(section.title),
        escaped(section.text)
    )?;
    for table in &section.tables {
        writeln!(
            page,
            "<table>\n<caption>{}</caption>\n<thead><tr><th scope=\"col\">figure</th><th scope=\"col\" class=\"n\">value</th>\
            <th scope=\"col\" class=\"n\">95 % interval</th><th scope=\"col\" class=\"n\">count</th>\
            <th scope=\"col\" class=\"n\">blocks</th></tr></thead>\n<tbody>",
            escaped(&table.title)
        )?;
        for figure in &table.figures {
            row(page, figure)?;
        }
        writeln!(page, "</tbody>\n</table>")?;
    }
    if !section.drawings.is_empty() {
        writeln!(page, "<div class=\"maps\">")?;
        for (svg, caption) in &section.drawings {
            writeln!(page, "<figure>\n{svg}\n<figcaption>{}</figcaption>\n</figure>", escaped(caption))?;
        }
        writeln!(page, "</div>")?;
    }
    writeln!(page, "</section>")
}

fn row(page: &mut String, figure: &AssessmentFigure) -> fmt::Result {
    let value = figure.value.map_or_else(
        || "–".to_owned(),
        |value| {
            if figure.unit.is_empty() {
                figure.printed(value)
            } else {
                format!("{} {}", figure.printed(value), figure.unit)
            }
        },
    );
    let interval = figure.interval.map_or_else(
        || if figure.blocks.is_some() { "too few blocks".to_owned() } else { String::new() },
        |[low, high]| format!("{} to {}", figure.printed(low), figure.printed(high)),
    );
    let count = figure.count.map_or(String::new(), |count| count.to_string());
    let blocks = figure.blocks.map_or(String::new(), |blocks| blocks.to_string());
    writeln!(
        page,
        "<tr><th scope=\"row\">{}</th><td class=\"n\">{value}</td><td class=\"n\">{interval}</td><td class=\"n\">{count}</td>\
        <td class=\"n\">{blocks}</td></tr>",
        escaped(&figure.name)
    )
}

fn comparison(page: &mut String, against: &Provenance, figures: &[ComparedFigure]) -> fmt::Result {
    writeln!(
        page,
        "<section id=\"comparison\">\n<h2>Comparison</h2>\n<p>Differences are those of the other recording less this one, with 95 % \
        intervals. Of figures that do not differ, one in twenty is outside its interval by chance.</p>"
    )?;
    provenance(page, "The other recording", against)?;
    writeln!(
        page,
        "<table>\n<thead><tr><th scope=\"col\">figure</th><th scope=\"col\" class=\"n\">this</th>\
        <th scope=\"col\" class=\"n\">other</th>\
        <th scope=\"col\" class=\"n\">difference</th><th scope=\"col\" class=\"n\">95 % interval</th>\
        <th scope=\"col\">the other is</th></tr></thead>\n<tbody>"
    )?;
    for figure in figures {
        let printed = |value: f64| format!("{value:.*}", figure.digits);
        let interval = figure
            .interval
            .map_or(String::new(), |[low, high]| format!("{} to {}", printed(low), printed(high)));
        writeln!(
            page,
            "<tr><th scope=\"row\">{}</th><td class=\"n\">{} {unit}</td><td class=\"n\">{} {unit}</td><td class=\"n\">{}</td>\
            <td class=\"n\">{interval}</td><td>{}</td></tr>",
            escaped(&figure.name),
            printed(figure.value),
            printed(figure.other),
            printed(figure.difference),
            figure.verdict.text(),
            unit = figure.unit
        )?;
    }
    writeln!(page, "</tbody>\n</table>\n</section>")
}

fn method(page: &mut String, report: &AssessmentReport) -> fmt::Result {
    let method = &report.assessment.method;
    let block = method.block_s.map_or_else(
        || "Each aircraft is a block.".to_owned(),
        |block_s| format!("A block is {block_s} s of an aircraft, because fewer than 8 aircraft fly."),
    );
    writeln!(
        page,
        "<section id=\"method\">\n<h2>Method and terms</h2>\n<p>Intervals are of {} % confidence, by a block bootstrap of {} \
        replicates, seed {}. {block}</p>\n{METHOD}</section>",
        method.confidence_percent, method.replicates, method.seed
    )
}

/// The text with a capital first letter.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// Text in which the characters of HTML are escaped.
fn escaped(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            _ => escaped.push(letter),
        }
    }
    escaped
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped() {
        assert_eq!(escaped("<a href=\"x\">&"), "&lt;a href=&quot;x&quot;&gt;&amp;");
    }
}
