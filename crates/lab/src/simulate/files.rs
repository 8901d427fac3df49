//! Writes a simulation to files.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::wire::SECOND_IDENTITY;
use super::{AircraftIdentities, SimulatedAttack, SimulatedFlight, Simulation, TRANSPONDER_ID};
use crate::evaluate::Label;
use fusion::time::{SECOND, Time};
use picture::formats::PcapWriter;
use site::config::{Sensor, SensorKind};

/// Writes `radar.ast`, `transponder.ast`, `capture.pcap`, `truth.csv`, `labels.csv` and `site.toml` into `directory`,
/// creating it if necessary. Writes `attacks.csv`, a file for each further kind of sensor, and `classes.csv` if the
/// simulation has them. `about` becomes the comment at the head of `site.toml`. Returns the paths of the files.
///
/// # Errors
/// A file cannot be written; the error names it.
pub fn write(simulation: &Simulation, about: &str, directory: &Path) -> io::Result<Vec<PathBuf>> {
    let named = |path: &Path, error: io::Error| {
        io::Error::new(error.kind(), format!("{}: cannot be written: {error}", path.display()))
    };
    fs::create_dir_all(directory).map_err(|error| named(directory, error))?;
    let mut files = Vec::new();
    let mut file = |name: &str, fill: &dyn Fn(&mut BufWriter<File>) -> io::Result<()>| {
        let path = directory.join(name);
        #[expect(clippy::disallowed_methods, reason = "the files of a simulation")]
        let written = File::create(&path).and_then(|file| {
            let mut out = BufWriter::with_capacity(1 << 16, file);
            fill(&mut out)?;
            out.flush()
        });
        written.map_err(|error| named(&path, error))?;
        files.push(path);
        Ok::<_, io::Error>(())
    };
    file("radar.ast", &|out| blocks(simulation, out, true))?;
    file("transponder.ast", &|out| blocks(simulation, out, false))?;
    file("capture.pcap", &|out| capture(simulation, out))?;
    let further_files = &simulation.further_files;
    for (index, name) in further_files.iter().enumerate() {
        // Sensors of one kind share a file.
        if !further_files[..index].contains(name) {
            file(name, &|out| further_file(simulation, name, out))?;
        }
    }
    file("truth.csv", &|out| truth(&simulation.flights, out))?;
    file("labels.csv", &|out| labels(simulation, out))?;
    if !simulation.attacks.is_empty() {
        file("attacks.csv", &|out| attacks(&simulation.attacks, out))?;
    }
    if !simulation.identified.is_empty() {
        file("classes.csv", &|out| classes(&simulation.identified, out))?;
    }
    file("site.toml", &|out| {
        about.lines().try_for_each(|line| writeln!(out, "# {line}"))?;
        write!(out, "{}", simulation.config)
    })?;
    Ok(files)
}

/// Writes what the radars, or what the transponders, sent.
fn blocks(simulation: &Simulation, out: &mut impl Write, of_radars: bool) -> io::Result<()> {
    let is_wanted = |sensor: usize| simulation.config.sensors[sensor].kind.is_radar() == of_radars;
    let mut wanted = simulation.sent.iter().filter(|sent| is_wanted(sent.sensor));
    wanted.try_for_each(|sent| out.write_all(&sent.payload))
}

/// Writes what the receivers with this file sent. A line of text ends with a line feed.
fn further_file(simulation: &Simulation, file: &str, out: &mut impl Write) -> io::Result<()> {
    let mut wanted =
        simulation.further_sent.iter().filter(|sent| simulation.further_files[sent.sensor] == file);
    wanted.try_for_each(|sent| {
        out.write_all(&sent.payload)?;
        if sent.payload.starts_with(b"{") { out.write_all(b"\n") } else { Ok(()) }
    })
}

/// Writes `id,class,serial,remote_id,icao24,callsign,emitter_category`, in order of id; missing identities are blank.
fn classes(identified: &[AircraftIdentities], out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "id,class,serial,remote_id,icao24,callsign,emitter_category")?;
    identified.iter().try_for_each(|entry| {
        let AircraftIdentities { id, class, serial, remote_id, icao24, callsign, emitter_category } = entry;
        let text = |value: &Option<String>| value.clone().unwrap_or_default();
        let category = emitter_category.map_or_else(String::new, |category| category.to_string());
        let (serial, remote_id) = (text(serial), text(remote_id));
        writeln!(out, "{id},{class},{serial},{remote_id},{},{},{category}", text(icao24), text(callsign))
    })
}

fn capture(simulation: &Simulation, out: &mut impl Write) -> io::Result<()> {
    let mut pcap = PcapWriter::new(out)?;
    simulation
        .datagrams
        .iter()
        .try_for_each(|datagram| pcap.write(datagram.flow, datagram.received, &datagram.payload))?;
    pcap.flush()
}

/// Writes `time,id,lat,lon,alt_msl,vn,ve,vd`, in order of time.
fn truth(flights: &[SimulatedFlight], out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "time,id,lat,lon,alt_msl,vn,ve,vd")?;
    let steps = flights.iter().map(|flight| flight.samples.len()).max().unwrap_or(0);
    for step in 0..steps {
        for flight in flights {
            let Some(sample) = flight.samples.get(step) else { continue };
            let [north, east, down] = sample.velocity_ned_m_s;
            writeln!(
                out,
                "{},{},{:.9},{:.9},{:.3},{north:.3},{east:.3},{down:.3}",
                seconds(sample.time),
                flight.id,
                sample.latitude_deg,
                sample.longitude_deg,
                sample.altitude_amsl_m,
            )?;
        }
    }
    Ok(())
}

/// Writes `time,sensor,number,id,seduced`, in order of time. The column `identity` follows if some transmitters are not
/// numbered by their serial number.
fn labels(simulation: &Simulation, out: &mut impl Write) -> io::Result<()> {
    let is_other = |sensor: &Sensor| matches!(sensor.kind, SensorKind::AdsB(_) | SensorKind::RemoteId(_));
    // Two transponders of one drone have two numbers at one receiver; only the identity distinguishes these from radar
    // tracks.
    let is_second = |label: &Label| label.sensor == TRANSPONDER_ID && label.number > SECOND_IDENTITY as u32;
    let with_identity =
        simulation.config.sensors.iter().any(is_other) || simulation.labels.iter().any(is_second);
    writeln!(out, "time,sensor,number,id,seduced{}", if with_identity { ",identity" } else { "" })?;
    simulation.labels.iter().try_for_each(|label| {
        let Label { sensor, number, .. } = label;
        let id = label.id.as_deref().unwrap_or("");
        let seduced = u8::from(label.seduced);
        write!(out, "{},{sensor},{number},{id},{seduced}", seconds(label.time))?;
        if with_identity {
            write!(out, ",{}", label.identity.as_deref().unwrap_or(""))?;
        }
        writeln!(out)
    })
}

/// Writes `id,number,attack,from,until`, in order of drones.
fn attacks(attacks: &[SimulatedAttack], out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "id,number,attack,from,until")?;
    attacks.iter().try_for_each(|SimulatedAttack { id, number, attack, from, until }| {
        let attack = attack.map_or("jammed", |attack| attack.name());
        writeln!(out, "{id},{number},{attack},{},{}", seconds(*from), seconds(*until))
    })
}

/// Seconds since the epoch; seven decimals represent 1/128 s exactly.
fn seconds(time: Time) -> String {
    format!("{}.{:07}", time.nanos().div_euclid(SECOND), time.nanos().rem_euclid(SECOND) / 100)
}
