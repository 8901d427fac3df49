//! A simulation as files.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::{Attacked, Flight, Identified, Simulation};
use crate::config::{Sensor, SensorKind};
use crate::evaluate::Label;
use crate::formats::PcapWriter;
use fusion::time::{SECOND, Time};

/// Writes `radar.ast`, `transponder.ast`, `capture.pcap`, `truth.csv`, `labels.csv`, `site.toml` and, where there are
/// some, `attacks.csv`, a file of each further kind of sensor and `classes.csv` into `directory`, creating it if necessary; which they are. `about` becomes the comment at the head of `site.toml`.
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
    let heard_files = &simulation.heard_files;
    for (index, name) in heard_files.iter().enumerate() {
        // Sensors of a kind share a file.
        if !heard_files[..index].contains(name) {
            file(name, &|out| heard(simulation, name, out))?;
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

/// What the radars, or what the transponders, sent.
fn blocks(simulation: &Simulation, out: &mut impl Write, of_radars: bool) -> io::Result<()> {
    let is_wanted = |sensor: usize| simulation.config.sensors[sensor].kind.is_radar() == of_radars;
    let mut wanted = simulation.sent.iter().filter(|sent| is_wanted(sent.sensor));
    wanted.try_for_each(|sent| out.write_all(&sent.payload))
}

/// What the receivers that share this file sent; a line of text ends with a line feed.
fn heard(simulation: &Simulation, file: &str, out: &mut impl Write) -> io::Result<()> {
    let mut wanted = simulation.heard.iter().filter(|sent| simulation.heard_files[sent.sensor] == file);
    wanted.try_for_each(|sent| {
        out.write_all(&sent.payload)?;
        if sent.payload.starts_with(b"{") { out.write_all(b"\n") } else { Ok(()) }
    })
}

/// `id,class,serial,remote_id,icao24,callsign,emitter_category`, by id; what an identity does not have is blank.
fn classes(identified: &[Identified], out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "id,class,serial,remote_id,icao24,callsign,emitter_category")?;
    identified.iter().try_for_each(|entry| {
        let Identified { id, class, serial, remote_id, icao24, callsign, emitter_category } = entry;
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

/// `time,id,lat,lon,alt_msl,vn,ve,vd`, in order of time.
fn truth(flights: &[Flight], out: &mut impl Write) -> io::Result<()> {
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

/// `time,sensor,number,id,seduced`, in order of time; and `identity` where there are transmitters that the service does not
/// number by their serial number.
fn labels(simulation: &Simulation, out: &mut impl Write) -> io::Result<()> {
    let is_other = |sensor: &Sensor| matches!(sensor.kind, SensorKind::AdsB(_) | SensorKind::RemoteId(_));
    let with_identity = simulation.config.sensors.iter().any(is_other);
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

/// `id,number,attack,from,until`, by drone.
fn attacks(attacks: &[Attacked], out: &mut impl Write) -> io::Result<()> {
    writeln!(out, "id,number,attack,from,until")?;
    attacks.iter().try_for_each(|Attacked { id, number, attack, from, until }| {
        let attack = attack.map_or("jammed", |attack| attack.name());
        writeln!(out, "{id},{number},{attack},{},{}", seconds(*from), seconds(*until))
    })
}

/// Seconds since the epoch; seven decimals hold 1/128 s exactly.
fn seconds(time: Time) -> String {
    format!("{}.{:07}", time.nanos().div_euclid(SECOND), time.nanos().rem_euclid(SECOND) / 100)
}
