//! The summary of a replay.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{self, Write as _};

use fusion::learning::LearntType;
use fusion::report::TransponderType;
use fusion::time::Time;
use fusion::{Engine, Source};
use fusion::{Identity, RadarTrackKey, SensorIndex};
use input::names::counted;
use input::pipeline::Tally;
use picture::{Picture, serial_text};
use service::integrity::Flags;
use service::live::{in_words, type_in_words, type_name, values};
use site::config::Config;

/// Counters of the output. Their size grows with the number of aircraft and radar tracks, not with time.
#[derive(Clone, Debug, Default)]
pub struct ReplaySummary {
    slots: u64,
    points: BTreeMap<&'static str, u64>,
    span: Option<(Time, Time)>,
    aircraft: BTreeMap<u32, AircraftCounts>,
    radar_only: BTreeSet<RadarTrackKey>,
    flags: Flags,
    /// Numbers and first slots of uncooperative tracks.
    uncooperative: BTreeSet<(u32, Time)>,
}

#[derive(Clone, Debug)]
struct AircraftCounts {
    identity: Identity,
    fused: u64,
    alone: u64,
    radar_tracks: BTreeSet<RadarTrackKey>,
}

impl ReplaySummary {
    /// Whether no slot was counted.
    pub fn is_empty(&self) -> bool {
        self.slots == 0
    }

    /// Counts the tracks of a picture.
    pub fn count(&mut self, picture: &Picture) {
        self.slots += 1;
        self.flags.note(&picture.concerns);
        for track in &picture.tracks {
            let source = &track.point.source;
            if track.is_uncooperative {
                self.uncooperative.insert((track.point.number, track.point.first_seen));
            }
            *self.points.entry(track.source_name()).or_default() += 1;
            let first = self.span.map_or(track.time, |(first, _)| first);
            self.span = Some((first, track.time));
            if let Some(part) = source.transponder() {
                let aircraft = self.aircraft.entry(part.number).or_insert_with(|| AircraftCounts {
                    identity: part.identity,
                    fused: 0,
                    alone: 0,
                    radar_tracks: BTreeSet::new(),
                });
                match source {
                    Source::Fused(radar, ..) => {
                        aircraft.fused += 1;
                        aircraft.radar_tracks.insert(radar.track);
                    }
                    _ => aircraft.alone += 1,
                }
            } else if let Some(radar) = source.radar() {
                self.radar_only.insert(radar.track);
            }
        }
    }

    /// Number of points published from a source: `fused`, `radar`, `transponder` or `camera`.
    pub fn points(&self, source: &str) -> u64 {
        self.points.get(source).copied().unwrap_or(0)
    }

    /// Text of the summary: received data, dropped data with reasons, and output.
    pub fn text(&self, tally: &Tally, config: &Config) -> Result<String, fmt::Error> {
        let mut text = String::new();
        received(&mut text, tally)?;
        for (index, sensor) in config.sensors.iter().enumerate() {
            let index = SensorIndex(index as u16);
            let (kind, what) = (sensor.kind.name(), if sensor.kind.is_radar() { "plots" } else { "reports" });
            let accepted = tally.accepted.get(&index).copied().unwrap_or(0);
            write!(text, "sensor     {} ({kind}): {accepted} {what}", sensor.id)?;
            let dropped = tally.refused.iter().filter(|((sensor, _), _)| *sensor == Some(index));
            dropped_list(&mut text, dropped.map(|((_, reason), count)| (*reason, *count)))?;
            if let Some(messages) = tally.service.get(&index) {
                write!(text, "; {messages} service messages")?;
            }
            writeln!(text)?;
        }
        self.output(&mut text)?;
        Ok(text)
    }

    fn output(&self, text: &mut String) -> fmt::Result {
        match self.span {
            Some((first, last)) => writeln!(
                text,
                "output     {first} to {last}, {} slots: {} fused, {} radar, {} transponder{} points",
                self.slots,
                self.points("fused"),
                self.points("radar"),
                self.points("transponder"),
                match self.points("camera") {
                    0 => String::new(),
                    count => format!(", {count} camera"),
                },
            )?,
            None => writeln!(text, "output     no point in {} slots", self.slots)?,
        }
        const SHOWN: usize = 30;
        for (number, aircraft) in self.aircraft.iter().take(SHOWN) {
            writeln!(
                text,
                "aircraft   {number} ({} {}): {} fused with {}, {} of the transponder alone",
                aircraft.identity.space().key(),
                serial_text(aircraft.identity),
                counted(aircraft.fused, "point"),
                counted(aircraft.radar_tracks.len() as u64, "radar track"),
                aircraft.alone,
            )?;
        }
        if self.aircraft.len() > SHOWN {
            writeln!(text, "aircraft   and {} more", self.aircraft.len() - SHOWN)?;
        }
        writeln!(text, "radar only {}", counted(self.radar_only.len() as u64, "track"))?;
        self.flagged(text)
    }

    /// Writes flagged transponders and uncooperative drones, if there are any.
    fn flagged(&self, text: &mut String) -> fmt::Result {
        let identities: Vec<String> =
            self.flags.identities().iter().map(|identity| serial_text(*identity)).collect();
        if !identities.is_empty() {
            let reasons: Vec<String> = self
                .flags
                .counts()
                .iter()
                .map(|(reason, count)| format!("{count} {}", reason.name()))
                .collect();
            let reasons = if reasons.is_empty() { "by an operator".to_owned() } else { reasons.join(", ") };
            writeln!(text, "flagged    {}: {reasons}", identities.join(", "))?;
        }
        if !self.uncooperative.is_empty() {
            writeln!(
                text,
                "flagged    {} without a transponder (uncooperative)",
                counted(self.uncooperative.len() as u64, "track")
            )?;
        }
        Ok(())
    }
}

/// Registration of each radar and orientation of each camera at the end, one per line, with unobservable values in brackets;
/// learnt errors of the radars and of
/// each type of transponder.
pub fn registered(engine: &Engine, config: &Config) -> String {
    let line = |(index, registered): (SensorIndex, &fusion::operational::Registered)| {
        let sensor = config.sensors.get(usize::from(index.0))?;
        let radar = sensor.kind.radar()?;
        let estimate = &registered.estimate;
        let value = |(name, unit, value): (&str, &str, fusion::registration::BiasValue)| {
            let digits = if unit == " m" { 1 } else { 2 };
            let text = format!("{name} {:+.digits$} ± {:.digits$}{unit}", value.value, value.deviation);
            if value.observable { text } else { format!("({text})") }
        };
        let known = values(estimate).map(value).join(", ");
        let mut line = format!(
            "registered {} ({}): {known}; {:.1} tracks",
            sensor.id,
            radar.registration.name(),
            estimate.samples
        );
        if let Some(learnt) = registered.by_radars() {
            line += &format!(", {:.1} min of aircraft that other radars see", learnt.minutes);
        }
        if let Some(residual) = estimate.residual {
            line += &format!(", residual {residual:.1}");
        }
        if let Some(step) = &registered.step {
            line += &format!(", a step at {}", step.time);
        }
        line.push('\n');
        if let Some(found) = registered.place() {
            let [east, north] = [(0, found.east_m), (1, found.north_m)].map(|(axis, value)| {
                format!("{value:+.1} ± {:.1} m", found.covariance_m2[(axis, axis)].sqrt())
            });
            let what = if found.contradicts { "contradicted: it stands" } else { "stands" };
            line += &format!(
                "position   {}: {what} {east} east, {north} north of what is configured; {:.1} drone-minutes\n",
                sensor.id, found.drone_minutes
            );
        }
        if let Some(learnt) = &registered.learnt {
            line += &format!("learnt     {}: {}\n", sensor.id, in_words(learnt));
        }
        Some(line)
    };
    let of_camera = |(index, oriented): (SensorIndex, &fusion::operational::OrientedCamera)| {
        let sensor = config.sensors.get(usize::from(index.0))?;
        let misalignment = oriented.orientation.misalignment();
        let value = |(name, value): (&str, fusion::registration::BiasValue)| {
            let text =
                format!("{name} {:+.2} ± {:.2}°", value.value.to_degrees(), value.deviation.to_degrees());
            if value.observable { text } else { format!("({text})") }
        };
        let values = [
            ("bearing", misalignment.bearing),
            ("tilt east", misalignment.tilt_east),
            ("tilt north", misalignment.tilt_north),
        ];
        let known = values.map(value).join(", ");
        let mut line = format!("oriented   {}: {known}; {} looks", sensor.id, misalignment.looks);
        if let Some(residual) = misalignment.residual {
            line += &format!(", residual {:.2}°", residual.to_degrees());
        }
        if let Some(turned) = oriented.turned {
            line += &format!(", turned at {turned}");
        }
        Some(line + "\n")
    };
    let of_type = |(kind, learnt): (TransponderType, LearntType)| {
        let sensor = config.sensors.get(usize::from(kind.receiver.0))?;
        Some(format!("learnt     {}, {}: {}\n", sensor.id, type_name(&kind), type_in_words(&learnt)))
    };
    engine
        .registered()
        .filter_map(line)
        .chain(engine.oriented_cameras().filter_map(of_camera))
        .chain(engine.learnt_types().into_iter().filter_map(of_type))
        .chain(left_out(engine.camera_starts().left_out))
        .collect()
}

/// Line about pairs of camera tracks that could begin no target, because there were too many.
fn left_out(pairs: u64) -> Option<String> {
    (pairs > 0).then(|| {
        format!("cameras    {pairs} pairs of tracks left out, summed over the slots: too many at a time\n")
    })
}

fn received(text: &mut String, tally: &Tally) -> fmt::Result {
    writeln!(text, "received   {} datagrams or records, {} octets", tally.received, tally.octets)?;
    let mut line = |name: String, count: u64| {
        if count > 0 { writeln!(text, "dropped    {count} {name}") } else { Ok(()) }
    };
    line("repeated datagrams (redundant lines)".to_owned(), tally.duplicates)?;
    for ((category, kind), &count) in &tally.faults {
        let category = category.map_or(String::new(), |category| format!(" in category {category}"));
        line(format!("unreadable{category}: {kind}"), count)?;
    }
    for (category, &count) in &tally.skipped {
        line(format!("blocks of category {category}, which is not used"), count)?;
    }
    for ((category, source), &count) in &tally.unknown_sources {
        line(
            format!("CAT{category:03} records of SAC {} SIC {}, which no sensor has", source.sac, source.sic),
            count,
        )?;
    }
    for ((sensor, reason), &count) in &tally.refused {
        if sensor.is_none() {
            line(format!("records of no sensor: {reason}"), count)?;
        }
    }
    let mut fates: BTreeMap<&str, u64> = BTreeMap::new();
    for ((_, fate), &count) in &tally.newcomers {
        *fates.entry(fate).or_default() += count;
    }
    for (fate, what) in [
        ("heard_once", "heard once"),
        ("inconsistent", "whose reports do not agree"),
        ("rate_limited", "above max_new_per_s"),
        ("crowded_out", "while too many others waited"),
    ] {
        let count = fates.get(fate).copied().unwrap_or(0);
        if count > 0 {
            writeln!(text, "dropped    {count} identities {what}")?;
        }
    }
    let jumping: u64 = tally.jumping_tracks.values().sum();
    if jumping > 0 {
        writeln!(text, "dropped    {jumping} radar tracks whose numbers jump")?;
    }
    let mut note = |count: u64, what: &str| {
        if count > 0 { writeln!(text, "noted      {count} {what}") } else { Ok(()) }
    };
    note(tally.several_records, "CAT129 blocks with more than one record")?;
    note(tally.restarts, "fresh starts after a silence longer than the window")?;
    note(tally.clock_behind, "backward steps of the clock of reception")
}

fn dropped_list(text: &mut String, reasons: impl Iterator<Item = (&'static str, u64)>) -> fmt::Result {
    let mut first = true;
    for (reason, count) in reasons {
        write!(text, "{} {count} {reason}", if first { "; dropped:" } else { "," })?;
        first = false;
    }
    Ok(())
}
