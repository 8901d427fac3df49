//! `check --lines`: what the lines of a sensor become.

use std::fmt::Write as _;
use std::fs;
use std::io::Write;
use std::path::Path;

use asterix::cat129::WholeSerial;
use asterix::{AnyRecord, blocks, cat021};
use fusion::time::Time;
use input::gateways::lines::LineTranslator;
use input::gateways::remote_id::lines as lines_of;
use input::normalise::Normaliser;
use site::config::{Config, Connection};

use super::super::{CommandResult, Outcome};

/// Number of lines that are shown.
const SHOWN: usize = 10;

/// Prints what the first lines of a file become, and how many are dropped. A line is taken as received at its own time, else at
/// `now`.
pub(super) fn lines(
    config: &Config,
    normaliser: &Normaliser,
    (sensor, file): (Option<&str>, &Path),
    now: Time,
    out: &mut impl Write,
) -> CommandResult {
    let has_lines = |index: &usize| config.sensors[*index].connections.iter().any(Connection::has_lines);
    let wanted = |index: &usize| sensor.is_none_or(|id| config.sensors[*index].id == id);
    let mut found = (0..config.sensors.len()).filter(has_lines).filter(wanted);
    let (index, other) = (found.next(), found.next());
    let index = match (index, other) {
        (Some(index), None) => index,
        (None, _) => return Err("no such sensor has a connection with format = \"json\" or \"csv\"".into()),
        (Some(_), Some(_)) => return Err("several sensors have lines; name one with --sensor ID".into()),
    };
    let of = &config.sensors[index];
    let connection = of.connections.iter().find(|of| of.has_lines());
    let translator = connection.and_then(|connection| LineTranslator::new(config, index, connection));
    let mut translator = translator.ok_or("the sensor has no lines")?;
    let text = fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
    let (mut count, mut dropped, mut refused) = (0_usize, 0_usize, 0_usize);
    for line in lines_of(&text) {
        let before = translator.dropped().clone();
        let received = translator.time(line).unwrap_or(now);
        let mut datagram = None;
        translator.take(line, received, |translated| datagram = Some(translated));
        count += 1;
        let becomes = match datagram {
            Some(datagram) => report(normaliser, &datagram, received).unwrap_or_else(|reason| {
                refused += 1;
                format!("refused: {reason}")
            }),
            None => {
                dropped += 1;
                let reasons = translator.dropped().iter().zip(before.iter());
                let reason =
                    reasons.filter(|((_, now), (_, before))| now > before).map(|((name, _), _)| name);
                format!("dropped: {}", reason.collect::<String>())
            }
        };
        if count <= SHOWN {
            writeln!(out, "line {count}: {becomes}")?;
        }
    }
    writeln!(
        out,
        "{}: {count} lines, {dropped} dropped ({}), {refused} refused",
        of.id,
        translator.dropped()
    )?;
    Ok(if count > 0 && dropped + refused == 0 { Outcome::Done } else { Outcome::Incomplete })
}

/// The report in a translated datagram.
fn report(normaliser: &Normaliser, datagram: &[u8], received: Time) -> Result<String, String> {
    let block = blocks(datagram).next().and_then(Result::ok).ok_or("no block")?;
    let mut records = block.any_records(cat021::Edition::default()).ok_or("no known category")?;
    let located = records.next().and_then(Result::ok).ok_or("no record")?;
    let place = |position| {
        let place = normaliser.frame().to_geodetic(position);
        let amsl_m = place.height_m - normaliser.undulation_m();
        (format!("{:.6}, {:.6}", place.latitude_deg(), place.longitude_deg()), amsl_m)
    };
    let mut text = String::new();
    match located.record {
        AnyRecord::Cat048(record) => {
            let plot =
                normaliser.plot(&record, received).map_err(|(_, refusal)| refusal.name().to_owned())?;
            let (at, amsl_m) = place(plot.position);
            let _ = write!(text, "plot of track {} at {}: {at}", plot.track.number, plot.time);
            let _ = write!(text, ", {:.1} m from the radar", plot.slant_range_m);
            let _ = match plot.height_measured {
                true => write!(text, ", height {amsl_m:.1} m"),
                false => write!(text, ", no height"),
            };
            if let Some(probability) = plot.uav_probability {
                let _ = write!(text, ", drone {:.0} %", probability * 100.0);
            }
        }
        AnyRecord::Cat129(record) => {
            let fix = normaliser.fix(&record, received).map_err(|(_, refusal)| refusal.name().to_owned())?;
            let (at, amsl_m) = place(fix.position);
            let whole = record.special_purpose.as_ref().and_then(WholeSerial::read);
            let serial = match &whole {
                Some(whole) => whole.octets().to_vec(),
                None => record.serial_number.map_or_else(Vec::new, |serial| serial.to_vec()),
            };
            let serial = String::from_utf8_lossy(&serial);
            let _ = write!(text, "report of {} at {}: {at}, height {amsl_m:.1} m", serial.trim(), fix.time);
        }
        _ => return Err("another category".to_owned()),
    }
    Ok(text)
}
