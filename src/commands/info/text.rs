//! Report of `info` as text, on one screen.

use std::fmt::{self, Display, Write as _};

use super::InputSummary;
use crate::commands::table::{TextTable, duration, grouped, short};
use fusion::time::{DAY, SECOND};
use input::capture::CaptureFormat;
use input::survey::{LineHint, SensorHint, SourceReport, Span, Stamp, SurveyReport};

/// Maximum number of rows of a table, those with the highest counts. JSON has all.
const SHOWN: usize = 20;

/// Width of the screen, in columns. Only long names make longer lines.
const WIDTH: usize = 110;

/// Text of the report on an input.
pub(super) fn text(info: &InputSummary) -> Result<String, fmt::Error> {
    let mut text = String::new();
    head(&mut text, info)?;
    let report = &info.report;
    let long = report.span.is_some_and(|span| span.duration_ns >= DAY);
    streams(&mut text, report)?;
    sources(&mut text, report, long)?;
    timing(&mut text, report, long)?;
    items(&mut text, report)?;
    categories(&mut text, report)?;
    editions(&mut text, report)?;
    misread(&mut text, report)?;
    remote_id(&mut text, report)?;
    errors(&mut text, info)?;
    sensors(&mut text, &report.sensors)?;
    let input = if info.input == "standard input" { "CAPTURE" } else { &info.input };
    text += &locate_hint(&report.sensors, &[input]);
    Ok(text)
}

fn head(text: &mut String, info: &InputSummary) -> fmt::Result {
    let report = &info.report;
    writeln!(text, "{}", info.input)?;
    writeln!(text, "format     {}, {} octets", info.format, grouped(info.size))?;
    let octets = grouped(report.octets);
    match info.format {
        CaptureFormat::Raw | CaptureFormat::Gps => {
            writeln!(text, "content    {} with {octets} octets", counted(report.datagrams, "block"))?;
        }
        CaptureFormat::Beast | CaptureFormat::Avr | CaptureFormat::Tlog => {
            let records = info.format.translation().unwrap_or_default();
            let frames = report.datagrams + info.skipped.total();
            write!(text, "content    {}, ", counted(frames, "frame"))?;
            writeln!(
                text,
                "{} of them with {octets} octets of {records}; skipped {}",
                grouped(report.datagrams),
                info.skipped
            )?;
        }
        CaptureFormat::Oradis | CaptureFormat::Final => {
            writeln!(
                text,
                "content    {} with {octets} octets",
                counted(report.datagrams, "recorded message")
            )?;
        }
        _ => {
            let frames = report.datagrams + info.skipped.total();
            // Radio captures have no UDP addresses.
            let is_radio = report.streams.is_empty() && report.remote_id.is_some();
            let what = if is_radio { "Remote ID frame" } else { "UDP datagram" };
            write!(text, "content    {}: ", counted(frames, "frame"))?;
            write!(text, "{} with {octets} octets", counted(report.datagrams, what))?;
            if report.copies > 0 {
                let copies = if report.copies == 1 { "is a copy" } else { "are copies" };
                write!(text, ", of which {} {copies} of one at most 2 s before", grouped(report.copies))?;
            }
            if info.skipped.total() > 0 {
                write!(text, "; skipped {}", info.skipped)?;
            }
            writeln!(text)?;
        }
    }
    match report.span {
        Some(Span { of, first, last, duration_ns, steps_back }) => {
            let what = if of == "reception" { "received" } else { "times" };
            write!(text, "{what:<10} {first} to {last}, {}", duration(duration_ns as f64 / SECOND as f64))?;
            if !first.dated {
                write!(text, " (times of day; there are none of reception)")?;
            }
            if steps_back > 0 {
                write!(text, "; the clock went back {}", counted(steps_back, "time"))?;
            }
            writeln!(text)?;
        }
        None => writeln!(text, "times      none, neither of reception nor in the records")?,
    }
    for trailer in info.trailers.iter().take(SHOWN) {
        writeln!(text, "trailer    {trailer}: {}", counted(trailer.datagrams, "datagram"))?;
    }
    if !report.unread.is_empty() {
        writeln!(text, "unread     {}", report.unread)?;
    }
    if let Some(damage) = &info.damage {
        writeln!(text, "damage     {damage}")?;
    }
    Ok(())
}

fn streams(text: &mut String, report: &SurveyReport) -> fmt::Result {
    let mut table = TextTable::new("lrrrl", &["stream", "datagrams", "octets", "/s", "categories"]);
    for stream in most(&report.streams, |stream| stream.datagrams) {
        table.row([
            format!("{} > {}", stream.source, stream.destination),
            grouped(stream.datagrams),
            grouped(stream.octets),
            stream.datagrams_per_s.map_or(String::new(), short),
            joined(stream.categories.iter().map(|category| format!("{category:03}")), " "),
        ]);
    }
    section(text, &table)?;
    more(text, report.streams.len(), "stream")?;
    overflow(text, report.datagrams_of_more_streams, "datagram", "streams")
}

fn sources(text: &mut String, report: &SurveyReport, long: bool) -> fmt::Result {
    let names = ["cat SAC/SIC", "records", "share", "/s", "first", "last", "reports of"];
    let mut table = TextTable::new("lrrrrrl", &names);
    for source in most(&report.sources, |source| source.records) {
        let clock = |stamp: Option<Stamp>| stamp.map_or(String::new(), |stamp| clock(stamp, long));
        table.row([
            name(source),
            grouped(source.records),
            percent(source.share),
            source.records_per_s.map_or(String::new(), short),
            clock(source.first),
            clock(source.last),
            source.followed.map_or(String::new(), |followed| {
                let more = if followed.or_more { " or more" } else { "" };
                format!("{}{more}", counted(followed.count as u64, followed.of))
            }),
        ]);
    }
    section(text, &table)?;
    more(text, report.sources.len(), "source")?;
    overflow(text, report.records_of_more_sources, "record", "sources")
}

/// Regularity and delay of the sources' reports.
fn timing(text: &mut String, report: &SurveyReport, long: bool) -> fmt::Result {
    let dated = report.sources.iter().any(|source| source.delay.is_some());
    let names =
        ["cat SAC/SIC", "interval", "gaps", "longest silence", "time of day", "delay: min", "median", "p99"];
    let (columns, names) = if dated { ("lrrrlrrr", &names[..]) } else { ("lrrrl", &names[..5]) };
    let mut table = TextTable::new(columns, names);
    for source in most(&report.sources, |source| source.records) {
        let mut row = vec![name(source), String::new(), String::new(), String::new(), times_of_day(source)];
        if let Some(interval) = source.interval {
            let of = if interval.of == "record" { "" } else { interval.of };
            row[1] = format!("{} {of}", duration(interval.median_s)).trim_end().to_owned();
        }
        if let Some(silences) = source.silences {
            row[2] = match silences.gaps {
                0 => "none".to_owned(),
                gaps => format!("{} > {}", grouped(gaps), duration(silences.gap_above_s)),
            };
            row[3] = format!("{} at {}", duration(silences.longest_s), clock(silences.longest_from, long));
        }
        if let Some(delay) = source.delay {
            row.extend([delay.min_s, delay.median_s, delay.p99_s].map(duration));
        }
        table.row(row);
    }
    section(text, &table)
}

/// Faults in the times of day.
fn times_of_day(source: &SourceReport) -> String {
    let faults = [
        (source.without_time, "missing"),
        (source.out_of_range, "past 24 h"),
        (source.strays, "astray"),
        (source.steps_back, "steps back"),
    ];
    let faults = faults.into_iter().filter(|(count, _)| *count > 0);
    let text = joined(faults.map(|(count, what)| format!("{} {what}", grouped(count))), ", ");
    if text.is_empty() { "all good".to_owned() } else { text }
}

fn items(text: &mut String, report: &SurveyReport) -> fmt::Result {
    if report.sources.is_empty() {
        return Ok(());
    }
    writeln!(text, "\ncat SAC/SIC  items")?;
    for source in most(&report.sources, |source| source.records) {
        let (always, sometimes): (Vec<_>, Vec<_>) =
            source.items.0.iter().partition(|(_, count)| *count == source.records);
        let always = joined(always.iter().map(|(item, _)| item), " ");
        let share = |count: u64| percent(count as f64 / source.records as f64);
        let sometimes = sometimes.iter().map(|(item, count)| format!("{item} {}", share(*count)));
        let parts: Vec<String> =
            std::iter::once(always).chain(sometimes).filter(|part| !part.is_empty()).collect();
        wrapped(text, &format!("{:<11}  ", name(source)), &parts)?;
    }
    Ok(())
}

/// Writes the parts, separated by commas, on lines of [`WIDTH`].
fn wrapped(text: &mut String, label: &str, parts: &[String]) -> fmt::Result {
    let mut line = label.to_owned();
    for (place, part) in parts.iter().enumerate() {
        let comma = if place + 1 < parts.len() { ", " } else { "" };
        if place > 0 && line.len() + part.len() + 1 > WIDTH {
            writeln!(text, "{}", line.trim_end())?;
            line = " ".repeat(label.len());
        }
        line += part;
        line += comma;
    }
    writeln!(text, "{}", line.trim_end())
}

fn categories(text: &mut String, report: &SurveyReport) -> fmt::Result {
    let mut table = TextTable::new("lrrrl", &["category", "blocks", "records", "octets", ""]);
    for category in &report.categories {
        table.row([
            format!("{:03}", category.category),
            grouped(category.blocks),
            category.records.map_or("not read".to_owned(), grouped),
            grouped(category.octets),
            category.name.unwrap_or("unknown").to_owned(),
        ]);
    }
    section(text, &table)
}

/// Edition of each CAT021 source, as `decode --edition` takes it.
fn editions(text: &mut String, report: &SurveyReport) -> fmt::Result {
    let mut table = TextTable::new("llrrr", &["CAT021 of", "edition", "blocks", "unreadable", "in others"]);
    for fit in &report.editions {
        let source = fit.sac.zip(fit.sic).map_or("none".to_owned(), |(sac, sic)| format!("{sac}/{sic}"));
        let edition = match fit.edition {
            Some(edition) if fit.or_later => format!("{edition} or later"),
            Some(edition) => edition.to_owned(),
            None => "any".to_owned(),
        };
        let counts = [fit.blocks, fit.unreadable, fit.unreadable_otherwise].map(grouped);
        let [blocks, unreadable, otherwise] = counts;
        table.row([source, edition, blocks, unreadable, otherwise]);
    }
    if table.is_empty() { Ok(()) } else { section(text, &table) }
}

/// Sources that use another edition than the usual one, or an unknown one.
fn misread(text: &mut String, report: &SurveyReport) -> fmt::Result {
    let blank = if report.misread.is_empty() { "" } else { "\n" };
    write!(text, "{blank}")?;
    for of in report.misread.iter().take(SHOWN) {
        let source = of.sac.zip(of.sic).map_or(String::new(), |(sac, sic)| format!(" of {sac}/{sic}"));
        let (category, blocks) = (of.category, counted(of.blocks, "block"));
        write!(text, "CAT{category:03}{source}: {} of {blocks} misread; ", grouped(of.misread))?;
        match (of.read_in.as_slice(), of.known.first().zip(of.known.last())) {
            ([], Some((first, last))) => writeln!(
                text,
                "no edition from {first} to {last} fits: perhaps one before {first}, or another format"
            )?,
            ([], None) => writeln!(text, "no edition is known")?,
            ([only], _) => writeln!(text, "edition {only} fits: decode --edition {category}:{only}")?,
            ([first, .., last], _) => {
                writeln!(text, "editions {first} to {last} fit: decode --edition {category}:{last}")?;
            }
        }
    }
    more(text, report.misread.len(), "source")
}

fn errors(text: &mut String, info: &InputSummary) -> fmt::Result {
    let mut table = TextTable::new("lrrl", &["error", "count", "first at", ""]);
    for error in most(&info.report.errors, |error| error.count) {
        let category = error.category.map_or(String::new(), |category| format!("CAT{category:03} "));
        let item = error.first_item.map_or(String::new(), |item| format!("item {item}: "));
        table.row([
            format!("{category}{}", error.kind),
            grouped(error.count),
            error.first_offset.to_string(),
            format!("{item}{}", error.detail),
        ]);
    }
    if table.is_empty() && info.lost_frames == 0 {
        return writeln!(text, "\nno errors");
    }
    section(text, &table)?;
    more(text, info.report.errors.len(), "kind of error")?;
    if info.lost_frames > 0 {
        let frames = counted(info.lost_frames, "frame");
        writeln!(
            text,
            "{}{frames} may have held records and could not be read",
            if table.is_empty() { "\n" } else { "" }
        )?;
    }
    Ok(())
}

fn remote_id(text: &mut String, report: &SurveyReport) -> fmt::Result {
    let Some(of) = report.remote_id else { return Ok(()) };
    let counts = [
        ("Basic ID", of.basic_id),
        ("Location", of.location),
        ("Authentication", of.authentication),
        ("Self ID", of.self_id),
        ("System", of.system),
        ("Operator ID", of.operator_id),
    ];
    let there = counts.iter().filter(|(_, count)| *count > 0);
    let counts: Vec<String> = there.map(|(name, count)| format!("{} {name}", grouped(*count))).collect();
    let from = counted(of.transmitters, "transmitter");
    writeln!(
        text,
        "\nRemote ID  {from}; {}",
        if counts.is_empty() { "no message".to_owned() } else { counts.join(", ") }
    )
}

/// Sensors, with the keys of `[[sensors]]`.
fn sensors(text: &mut String, sensors: &[SensorHint]) -> fmt::Result {
    if sensors.is_empty() {
        return Ok(());
    }
    writeln!(
        text,
        "\nsensors of a configuration for it (places and accuracies are not in the data; --config-out FILE writes it)"
    )?;
    for sensor in sensors {
        let mut keys = vec![format!("sac = {}", sensor.sac), format!("sic = {}", sensor.sic)];
        keys.extend(sensor.period_s.map(|period_s| format!("period_s = {period_s:?}")));
        keys.extend(classification(sensor));
        keys.extend(edition(sensor));
        keys.extend(inputs(sensor));
        wrapped(text, &format!("{:<11}  ", sensor.kind), &keys)?;
    }
    Ok(())
}

/// The command that finds the radars' positions, if these inputs have what it needs.
pub(super) fn locate_hint(sensors: &[SensorHint], inputs: &[&str]) -> String {
    if !can_locate(sensors) {
        return String::new();
    }
    let inputs = inputs.join(" ");
    format!("`utm-fusion locate {inputs} -o site.toml` finds the radars' places from the transponders\n")
}

/// Whether there are a radar and transponders (CAT129), so that `locate` may find the radar's position.
pub(super) fn can_locate(sensors: &[SensorHint]) -> bool {
    let has = |kind| sensors.iter().any(|sensor| sensor.kind == kind);
    has("radar") && has("transponder")
}

/// Key `classification` of a radar.
pub(super) fn classification(sensor: &SensorHint) -> Option<String> {
    Some(match sensor.classification? {
        "constant" => "classification = { source = \"constant\", value = 1.0 }".to_owned(),
        source => format!("classification = {{ source = \"{source}\" }}"),
    })
}

/// Key `edition` of an ADS-B receiver.
pub(super) fn edition(sensor: &SensorHint) -> Option<String> {
    sensor.edition.map(|edition| format!("edition = \"{edition}\""))
}

/// Key `inputs`, if the capture contains addresses.
pub(super) fn inputs(sensor: &SensorHint) -> Option<String> {
    let lines = joined(sensor.inputs.iter().map(line), ", ");
    (!lines.is_empty()).then(|| format!("inputs = [{lines}]"))
}

fn line(line: &LineHint) -> String {
    let key = if line.multicast { "group" } else { "address" };
    format!("{{ {key} = \"{}\", port = {} }}", line.address, line.port)
}

/// Writes a blank line and the table, unless the table is empty.
fn section(text: &mut String, table: &TextTable) -> fmt::Result {
    if table.is_empty() { Ok(()) } else { write!(text, "\n{table}") }
}

/// Entries with the highest counts, at most [`SHOWN`], in their original order.
fn most<T>(all: &[T], count: impl Fn(&T) -> u64) -> impl Iterator<Item = &T> {
    let mut places: Vec<_> = (0..all.len()).collect();
    places.sort_by_key(|&place| std::cmp::Reverse(count(&all[place])));
    places.truncate(SHOWN);
    places.sort_unstable();
    places.into_iter().map(|place| &all[place])
}

fn more(text: &mut String, count: usize, what: &str) -> fmt::Result {
    match count.saturating_sub(SHOWN) {
        0 => Ok(()),
        hidden => writeln!(text, "and {} more; --json has them all", counted(hidden as u64, what)),
    }
}

fn overflow(text: &mut String, count: u64, what: &str, of: &str) -> fmt::Result {
    if count == 0 {
        Ok(())
    } else {
        writeln!(text, "and {} of {of} that are not told apart", counted(count, what))
    }
}

/// Name of a source: `048 70/41`.
fn name(source: &SourceReport) -> String {
    match (source.sac, source.sic) {
        (Some(sac), Some(sic)) => format!("{:03} {sac}/{sic}", source.category),
        _ => format!("{:03} none", source.category),
    }
}

/// Time of day to a tenth of a second. In a `long` capture, date and time to the second.
fn clock(stamp: Stamp, long: bool) -> String {
    let text = stamp.to_string();
    match (stamp.dated, long) {
        (true, true) => text.get(5..19).unwrap_or(&text).replace('T', " "),
        (true, false) => text.get(11..21).unwrap_or(&text).to_owned(),
        (false, _) => text.get(..10).unwrap_or(&text).to_owned(),
    }
}

fn percent(share: f64) -> String {
    match share * 100.0 {
        100.0 => "100 %".to_owned(),
        percent if percent > 99.9 => "99.9 %".to_owned(),
        percent if percent > 0.0 && percent < 0.1 => "< 0.1 %".to_owned(),
        percent => format!("{percent:.1} %"),
    }
}

fn counted(count: u64, what: &str) -> String {
    let plural = match count {
        1 => "",
        _ if what.ends_with('s') => "es",
        _ => "s",
    };
    format!("{} {what}{plural}", grouped(count))
}

fn joined(parts: impl Iterator<Item = impl Display>, between: &str) -> String {
    parts.map(|part| part.to_string()).collect::<Vec<_>>().join(between)
}
